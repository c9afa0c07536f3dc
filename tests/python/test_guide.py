"""Runs the tutorial's commands verbatim, page by page, in a copy of the examples' folder."""

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
    """A copy of the examples' folder, shared by all pages: each continues from the previous one."""
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
    # `pip install .` would put the module on the path too.
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
    """The tutorial's claim about its example; runs after its pages."""
    if not (folder / "compare.py").exists():
        pytest.skip("the tutorial's pages did not run")
    output = subprocess.run(
        ["python", "compare.py"], cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout
    before, after = (float(value) for value in re.findall(r": (\d+) Pa rms", output))
    assert after < before and after < 1.2 * 150.0, output


def test_lambda0_falls_and_rises_in_the_tutorial_s_two_studies_of_volume_over_area(folder):
    """The page's claim about the studies; runs after the tutorial's pages. Every row has its result."""
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
    rig, model, study = [text for language, _, text in blocks(page) if language == "toml"]
    (tmp_path / "model.toml").write_text(model)
    # A motion in the layout of the rig file, which is read with all its keys.
    (tmp_path / "rig.toml").write_text(rig)
    (tmp_path / "motion.csv").write_text("time(s),Pos(in),p(psia)\n0.0,4.0,14.7\n0.1,3.9,14.8\n0.2,3.8,14.9\n")
    pneutherm("simulate", "model.toml", "--motion", "motion.csv", "--rig", "rig.toml", "-o", "out.csv", cwd=tmp_path)
    (tmp_path / "study.toml").write_text(study)
    pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path)
    assert "72 in 16 of 16 parts" in pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout
    # Keys in comments of the page must be valid too.
    table = study.replace('"factorial"', '"table"').replace("parts = 16", "parts = 1").replace("# table", "table")
    (tmp_path / "study.toml").write_text(table.replace("# columns", "columns").split("\n[vary]\n")[0])
    (tmp_path / "points.csv").write_text("bore_m,dead_volume_m3\n0.02,1e-6\n0.03,1e-6\n")
    said = pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout
    assert "2 in 1 of 1 parts" in said, said
    # Further tables for a study, each completed to a full study.
    head = (study.split("\n[vary]\n")[0] + "\n").replace('"factorial"', '"sobol"').replace("samples = 100000", "samples = 64")
    tables = [text for language, _, text in blocks(page) if language == "text"]
    whole, *others = [text for language, _, text in blocks((root / "sweep/README.md").read_text()) if language == "toml"]
    (tmp_path / "study.toml").write_text(whole)
    assert "rows       100000 in" in pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout
    assert len(tables) == 4 and len(others) == 3
    assert all(text.startswith(("[vary]", "[statistics]")) for text in tables + others)
    for text in tables + others:
        vary = "" if "bore_m =" in text else "bore_m = { from = 0.016, to = 0.063 }\n"
        vary = text.replace("[vary]\n", f"[vary]\n{vary}") if "[vary]" in text else f"[vary]\n{vary}{text}"
        (tmp_path / "study.toml").write_text(head + vary)
        assert "rows       64 in" in pneutherm("sweep", "study.toml", "-o", "out", "--dry-run", cwd=tmp_path).stdout


def hand_written(root):
    """The hand-written pages: those of the book not generated from code, and the pages beside the sources."""
    book = [page for page in (root / "book/src").rglob("*.md") if not page.read_text().startswith("<!-- Made by")]
    beside = ["README.md", "CHANGELOG.md", "benches/README.md", "examples/fmu/README.md", "fmu/binaries/README.md"]
    return [*book, *(root / name for name in [*beside, "results/README.md", "sweep/README.md"])]


def test_every_option_that_a_page_names_is_one_of_the_command(root):
    sections = re.split(r"^## ", (root / "book/src/reference/command-line.md").read_text(), flags=re.M)[1:]
    options = {text.split("\n")[0]: set(re.findall(r"(?<!\w)--[a-z][a-z-]+", text)) for text in sections}
    named = 0
    for page in hand_written(root):
        text = page.read_text()
        for command, rest in re.findall(r"pneutherm ([a-z]+) ([^\n`]*)", text):
            for option in re.findall(r"(?<!\S)--[a-z][a-z-]+", rest.split("#")[0]):
                assert option in options[f"pneutherm {command}"], f"{page.name}: pneutherm {command} {option}"
                named += 1
        # Options in running text belong to this program, unless listed as another program's.
        for option in re.findall(r"`(--[a-z][a-z-]+)[^`]*`", re.sub(r"```.*?```", "", text, flags=re.S)):
            assert option in set().union(*options.values()) | OTHERS, f"{page.name}: {option}"
            named += 1
    assert named > 40, named


# Options of other programs.
OTHERS = {"--requeue", "--scheduler"}


def test_every_file_that_a_page_names_exists(root):
    named = 0
    for page in hand_written(root):
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for name in re.findall(r"`([\w./-]+/[\w.-]+\.(?:rs|py|md|mo)|(?:results|examples|benches|rigs)/[\w./-]+)`", text):
            # The page on diagnosis names files of `identify/src`.
            places = [root, page.parent, root / "identify/src"]
            assert any((place / name).exists() for place in places) or name in MADE, f"{page.name}: {name}"
            named += 1
    assert named > 40, named


# Files created by following an example of a page.
MADE = {"chamber/src/effects/seal_film.rs"}

# Constants in `identify/src/policy.rs`, and their statements on the pages about the method.
POLICY = {
    "DECISIVE: f64 = 10.0": "ΔBIC above 10 is very strong evidence",
    "INDISTINGUISHABLE: f64 = 6.0": "whose BIC is within 6 of its BIC",
    "INDISTINGUISHABLE_WITHIN_A_ROW: f64 = 20.0": "each of them by less than half a row, within 20",
    "MOST_TERMS: usize = 4": "more than four effects of the gas and its wall",
    "MOST_IN_ALL: usize = 6": "more than six terms",
    "BEAM_WIDTH: usize = 3": "the three best of all, and the three best without",
    "PAIRED: usize = 6": "The six best single terms are also tried in pairs",
    "FREED: usize = 6": "Of the six best single terms the secondary parameters are freed before",
    "EXCHANGED_FROM: usize = 3": "three or more effects of the rig explain the records",
    "FITTED: usize = 8": "eight with per-record terms and eight without",
    "REJUDGED: usize = 8": "the left-out error of the eight best is judged again",
    "JUDGED: usize = 4": "for the four best of these whose other numbers allow them to enter",
    "FAR_LESS_NOISE: f64 = 0.7": "less than 0.7 of what was taken for noise",
    "FIRST_LAMBDA0: f64 = 30.0": "times as large or as small as 30 W/(m² K)",
    "FIRST_GUESS_REACH: f64 = 2.0": "more than e² times as large or as small as 30 W/(m² K)",
    "GAP_STEPS: f64 = 5.0": "more than five times as long as the median step on either side of it",
    "GAP_TRAVEL: f64 = 0.01": "more than a hundredth of its travel",
    "BEHIND_GAP: f64 = 0.3": "within 30 % (standard deviation)",
    "AT_MOVES_PROBABILITY: f64 = 1e-3": "binomial probability below 10⁻³",
    "FAMILY_PROBABILITY: f64 = 2e-5": "the probability limit of 2·10⁻⁵",
    "SQUARES_DEVIATIONS: f64 = 4.5": "less than 4.5 standard deviations above its expectation",
    "NOISE_MODEL_SHARE: f64 = 0.05": "an uncertainty of 5 % in the noise variance",
    "GEOMETRY_WIDENED: f64 = 5.0": "with the stated numbers five times as uncertain as stated",
    "TOLERANCES: f64 = 3.0": "more than three tolerances",
    "EXCESS_REMOVED_BY_MOVES: f64 = 0.5": "takes away more than half of the squares beyond noise",
    "DEVIATIONS_BEFOREHAND: f64 = 5.0": "A fit goes no farther than five of them",
    "NEARLY_EXHAUSTED: f64 = 0.95": "more than 95 % of the largest plausible value",
    "BETWEEN_RECORDS: f64 = 0.2": "with a fifth of these standard deviations",
    "KINDS_PROBABILITY: f64 = 1e-4": "a probability below 10⁻⁴",
    "KINDS_DEVIATIONS: f64 = 4.0": "more than four standard deviations apart",
    "KNOWN_TO: f64 = 1e-5": "never less than 10⁻⁵ of the rig's highest pressure",
    "ACCURACY_OF_NOISE: f64 = 0.25": "by default a quarter of the noise",
    "FAR_BEYOND_NOISE: f64 = 3.0": "the model errs by more than three times the noise and the accuracy together",
    "PREDICTS_BETTER: f64 = 0.5": "the effects at least halve the systematic error",
    "CARRIES_OVER: f64 = 1.3": "not more than 1.3 times the error on the records it is fitted to",
    "CARRIES_OVER_WITHIN_UNCERTAINTY: f64 = 2.0": "less than twice that error is enough",
    "MOST_GONE: f64 = 0.25": "falls below a quarter of that of the paper's model",
    "NEXT_TO_NOTHING: f64 = 0.02": "leaves less than 2 % of the systematic misfit",
    "REMAINING_WITHIN_ACCURACY: f64 = 0.1": "leaves less than a tenth of that and is good enough",
    "PLAIN_SHAPE: f64 = 1e-20": "if noise has its shape with a probability of less than 10⁻²⁰",
    "AT_AMBIENT: f64 = 0.02": "within 2 % of the pressure of the surroundings",
    "COMPRESSED_AIR_PA: std::ops::RangeInclusive<f64> = 2.5e4..=1.2e6": "outside 0.25 to 12 bar",
    "APART_FROM: f64 = 3.0": "more than three times the white noise",
    "APART: f64 = 0.1": "a tenth of its square",
    "PLAUSIBLE_COEFFICIENT: std::ops::RangeInclusive<f64> = 1.0..=1000.0": "a coefficient outside 1 to 1000 W/(m² K)",
}


def test_the_page_on_the_method_states_every_threshold_of_the_code(root):
    code = (root / "identify/src/policy.rs").read_text()
    assert re.findall(r"^pub const (.*);$", code, flags=re.M) == list(POLICY)
    theory = root / "book/src/theory"
    words = " ".join(((theory / "diagnosis.md").read_text() + (theory / "apart.md").read_text()).split())
    for threshold, sentence in POLICY.items():
        assert sentence in words, f"{threshold}: `{sentence}` is not in the guide"


def test_the_page_on_effects_names_every_hook(root):
    trait = (root / "chamber/src/effects/effect.rs").read_text().split("pub trait Effect {")[1].split("\n}\n")[0]
    hooks = re.findall(r"^    fn (\w+)", trait, flags=re.M)
    page = (root / "book/src/extend/effect.md").read_text()
    named = re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \|", page, flags=re.M)))
    assert sorted(named) == sorted(hooks)


def test_every_page_of_the_summary_exists_and_every_link_leads_somewhere(root):
    source = root / "book/src"
    pages = [source / target for target in re.findall(r"\]\(([^)]+\.md)\)", (source / "SUMMARY.md").read_text())]
    assert {page for page in source.rglob("*.md")} == {*pages, source / "SUMMARY.md"}
    for page in {*pages, *hand_written(root)}:
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for target, anchor in re.findall(r"\]\((?!https?:)([^)#]*)(?:#([^)]+))?\)", text):
            to = (page.parent / target).resolve() if target else page
            assert to.exists(), f"{page.name}: {target}"
            if anchor:
                anchors = [slug(line) for line in re.findall(r"^#+ (.*)$", to.read_text(), flags=re.M)]
                assert anchor in anchors, f"{page.name}: {target}#{anchor} is none of {anchors}"


def slug(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
