"""Requirements on the dependencies: a single version of crates whose types are exchanged between ours, licences, notices."""

import re
import shutil
import subprocess
import sys
import tomllib

import pytest

ONE_VERSION = ["nalgebra", "arrow", "arrow-array", "arrow-schema", "parquet"]


def versions(lock):
    found = {}
    for package in tomllib.loads(lock.read_text())["package"]:
        found.setdefault(package["name"], set()).add(package["version"])
    return found


@pytest.mark.parametrize("name", ONE_VERSION)
def test_there_is_one_version_of(name, root):
    found = versions(root / "Cargo.lock").get(name, set())
    assert len(found) == 1, f"{name}: {sorted(found)}; `cargo tree -d` shows who asks for which"


def test_every_package_comes_from_the_registry_or_the_project(root):
    for package in tomllib.loads((root / "Cargo.lock").read_text())["package"]:
        source = package.get("source", "")
        assert not source or re.match(r"registry\+https://github.com/rust-lang/crates.io-index$", source), package


def test_the_changelog_has_the_program_s_version(root):
    version = tomllib.loads((root / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    assert f"## {version}" in (root / "CHANGELOG.md").read_text()


@pytest.mark.skipif(not shutil.which("cargo-deny"), reason="no cargo-deny here (cargo install cargo-deny --locked)")
def test_licences_versions_and_sources_are_those_that_deny_toml_allows(root):
    command = ["cargo", "deny", "--offline", "check", "--hide-inclusion-graph", "licenses", "bans", "sources"]
    process = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=300)
    assert process.returncode == 0, process.stderr


@pytest.mark.skipif(not shutil.which("cargo"), reason="no cargo here")
def test_the_third_party_notices_are_those_of_the_lock_file(root):
    command = [sys.executable, "release/notices.py", "--check"]
    process = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=300)
    assert process.returncode == 0, process.stderr
