"""Follows the guide's page "Add an effect" literally, in a copy of the physics crate, and runs that crate's tests."""

import os
import re
import shutil
import subprocess

import pytest

PAGE = "book/src/extend/effect.md"


@pytest.fixture
def workspace(root, tmp_path):
    """A workspace with only the physics crate and the project's lock file."""
    shutil.copytree(root / "chamber", tmp_path / "chamber")
    shutil.copy(root / "Cargo.lock", tmp_path)
    shutil.copy(root / "rustfmt.toml", tmp_path)
    manifest = (root / "Cargo.toml").read_text()
    manifest = re.sub(r"members = \[.*?\]", 'members = ["chamber"]', manifest, flags=re.S)
    manifest = re.sub(r"^(default-members|exclude) = \[.*?\]\n", "", manifest, flags=re.S | re.M)
    tables = re.split(r"^(?=\[)", manifest, flags=re.M)
    kept = [table for table in tables if re.match(r"\[(workspace[\].]|profile\.)", table)]
    assert kept, "no [workspace] table in Cargo.toml"
    (tmp_path / "Cargo.toml").write_text("".join(kept))
    return tmp_path


def follow(page, workspace):
    """Writes the page's files and inserts its lines; returns the number of each."""
    files = re.findall(r"```rust,file=(\S+)\n(.*?)```", page, flags=re.S)
    for name, text in files:
        assert not (workspace / name).exists(), f"{name} is already part of the project"
        (workspace / name).write_text(text)
    lines = re.findall(r"```rust,line-before=([^\n]+)\n(.*?)```", page, flags=re.S)
    for before, text in lines:
        target = workspace / "chamber/src/effects/mod.rs"
        source = target.read_text()
        assert source.count(before) == 1, f"{before!r} is not a line of {target.name}"
        target.write_text(source.replace(before, text + before))
    return len(files), len(lines)


def cargo(*arguments, root, workspace):
    folder = str(root / "target" / "guide")
    quick = {"CARGO_INCREMENTAL": "0", "CARGO_PROFILE_DEV_OPT_LEVEL": "0", "CARGO_PROFILE_DEV_DEBUG": "0"}
    environment = {**os.environ, "CARGO_TARGET_DIR": folder, **quick}
    process = subprocess.run(
        ["cargo", *arguments], cwd=workspace, env=environment, capture_output=True, text=True, timeout=900
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout + process.stderr


def test_the_page_adds_an_effect_that_compiles_and_passes_every_test(root, workspace):
    page = (root / PAGE).read_text()
    assert follow(page, workspace) == (1, 1)
    output = cargo("test", "-p", "pneutherm-chamber", "--lib", root=root, workspace=workspace)
    assert "effects::seal_film::tests::a_seal_at_rest_is_tight" in output
    assert "test result: ok" in output


def test_the_page_is_formatted_as_the_project_is(root, workspace):
    follow((root / PAGE).read_text(), workspace)
    cargo("fmt", "--all", "--check", root=root, workspace=workspace)
