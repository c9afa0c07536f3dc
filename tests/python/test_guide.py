"""Runs the tutorial's commands verbatim, page after page, in a copy of the examples' folder."""

import itertools
import os
import re
import shutil
import subprocess
import sys

import pytest
from pyarrow import parquet

from conftest import PROGRAM

PAGES = ["record", "identify", "diagnose", "fmu", "sweep", "python"]
BLOCK = re.compile(r"^```(\w+)(?:,file=(\S+))?\n(.*?)^```", flags=re.S | re.M)


def blocks(page):
    """The page's code blocks: (language, file name or empty, text)."""
    return BLOCK.findall(page)


@pytest.fixture(scope="module")
def folder(root, tmp_path_factory):
    """A copy of the examples' folder, shared by all pages: each goes on where the one before ended."""
    folder = tmp_path_factory.mktemp("a reader's folder") / "try"
    shutil.copytree(root / "examples", folder)
    return folder


@pytest.fixture(scope="module")
def environment(package, tmp_path_factory):
    """The reader's shell: `pneutherm` and `python` on the PATH."""
    program = PROGRAM.resolve()
    tools = tmp_path_factory.mktemp("bin")
    (tools / "pneutherm").symlink_to(program)
    # A symbolic link to a virtual environment's interpreter would lose the environment.
    (tools / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (tools / "python").chmod(0o755)
    # `pip install .` would put the module there too.
    paths = {"PATH": os.pathsep.join([str(tools), os.environ["PATH"]]), "PYTHONPATH": str(package)}
    return {**os.environ, **paths}


@pytest.mark.parametrize("name", PAGES)
def test_the_page_works_as_written(name, root, folder, environment):
    page = (root / "book/src/tutorial" / f"{name}.md").read_text()
    for language, file, text in blocks(page):
        if file:
            (folder / file).write_text(text)
        elif language == "sh":
            for command in text.strip().splitlines():
                run(command, folder, environment)


def run(command, folder, environment):
    process = subprocess.run(
        command, shell=True, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )
    assert process.returncode == 0, f"$ {command}\n{process.stdout}\n{process.stderr}"
    assert "Traceback" not in process.stderr, process.stderr


def test_the_diagnosed_model_predicts_the_validation_record_better(root, folder, environment):
    """What the tutorial promises of its example; runs after its pages."""
    if not (folder / "compare.py").exists():
        pytest.skip("the tutorial's pages did not run")
    output = subprocess.run(
        ["python", "compare.py"], cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout
    before, after = (float(value) for value in re.findall(r": (\d+) Pa rms", output))
    assert after < before and after < 1.2 * 150.0, output


def test_lambda0_falls_and_rises_in_the_tutorial_s_two_studies_of_volume_over_area(folder):
    """What the page says of them; runs after the tutorial's pages. Every row has its result."""
    if not (folder / "both_ways.py").exists():
        pytest.skip("the tutorial's pages did not run")
    for name, sign in [("by_length", -1), ("by_bore", 1)]:
        rows = parquet.read_table(folder / name / "rows").sort_by("volume_to_area_m").to_pydict()
        assert set(rows["status"]) == {"ok"} and len(rows["status"]) == 5, rows["status"]
        change = [sign * (b - a) for a, b in itertools.pairwise(rows["lambda0_w_per_m2_k"])]
        assert min(change) > 0, rows


def test_the_commands_of_the_readme_work_as_written(root, environment, tmp_path):
    for folder in ("examples", "results"):
        shutil.copytree(root / folder, tmp_path / folder)
    commands = re.findall(r"^pneutherm .*$", (root / "README.md").read_text(), flags=re.M)
    assert len(commands) >= 4
    for command in commands:
        run(command, tmp_path, environment)


def test_the_files_of_the_reference_page_are_accepted(root, pneutherm, tmp_path):
    page = (root / "book/src/reference/files.md").read_text()
    _, model, study = [text for language, _, text in blocks(page) if language == "toml"]
    (tmp_path / "model.toml").write_text(model)
    (tmp_path / "study.toml").write_text(study)
    pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path)
    assert "72 in 16 of 16 parts" in pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout
    # What stands there as a comment is a key too.
    table = study.replace('"factorial"', '"table"').replace("parts = 16", "parts = 1").replace("# table", "table")
    (tmp_path / "study.toml").write_text(table.replace("# columns", "columns").split("\n[vary]\n")[0])
    (tmp_path / "points.csv").write_text("bore_m,dead_volume_m3\n0.02,1e-6\n0.03,1e-6\n")
    said = pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout
    assert "2 in 1 of 1 parts" in said, said


def test_every_page_of_the_summary_exists_and_every_link_leads_somewhere(root):
    source = root / "book/src"
    pages = [source / target for target in re.findall(r"\]\(([^)]+\.md)\)", (source / "SUMMARY.md").read_text())]
    assert {page for page in source.rglob("*.md")} == {*pages, source / "SUMMARY.md"}
    for page in [*pages, root / "README.md"]:
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for target, anchor in re.findall(r"\]\((?!https?:)([^)#]*)(?:#([^)]+))?\)", text):
            to = (page.parent / target).resolve() if target else page
            assert to.exists(), f"{page.name}: {target}"
            if anchor:
                anchors = [slug(line) for line in re.findall(r"^#+ (.*)$", to.read_text(), flags=re.M)]
                assert anchor in anchors, f"{page.name}: {target}#{anchor} is none of {anchors}"


def slug(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
