"""The published results: `reproduce` writes the committed files, and the page of results states the origin of each file."""

import re
import subprocess

import pyarrow.parquet as parquet
import pytest

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# Other processors round the last digits differently.
RELATIVE, ABSOLUTE = 1e-6, 1e-9


@pytest.fixture(scope="module")
def reproduced(pneutherm, tmp_path_factory):
    """The folder filled by `pneutherm reproduce`."""
    folder = tmp_path_factory.mktemp("reproduced")
    pneutherm("reproduce", "-o", folder)
    return folder


def difference(ours, committed):
    """Where two texts differ by more than the rounding of their numbers; None if they agree."""
    if ours == committed:
        return None
    words = [NUMBER.split(text) for text in (ours, committed)]
    for mine, theirs in zip(*words):
        if mine != theirs:
            return f"{mine!r} is {theirs!r} in results/"
    numbers = [NUMBER.findall(text) for text in (ours, committed)]
    if len(numbers[0]) != len(numbers[1]):
        return f"{len(numbers[0])} numbers, {len(numbers[1])} in results/"
    for mine, theirs in zip(*numbers):
        if abs(float(mine) - float(theirs)) > max(RELATIVE * abs(float(theirs)), ABSOLUTE, last_place(theirs)):
            return f"{mine} is {theirs} in results/"
    return None


def last_place(number):
    """One unit in the last digit of a number rounded for people: rounding may go either way."""
    mantissa, _, exponent = number.lower().partition("e")
    whole, _, decimals = mantissa.lstrip("+-").partition(".")
    if len((whole + decimals).lstrip("0")) > 6:
        return 0.0
    return 1.01 * 10.0 ** (int(exponent or 0) - len(decimals))


def test_reproduce_writes_what_is_committed(reproduced, root):
    written = sorted(path.name for path in reproduced.iterdir() if path.suffix != ".fmu")
    assert len(written) > 15
    for name in written:
        ours, committed = reproduced / name, root / "results" / name
        assert committed.exists(), f"{name} is not in results/; commit what `reproduce` writes"
        if name.endswith(".parquet"):
            tables = [parquet.read_table(path) for path in (ours, committed)]
            assert tables[0].schema.equals(tables[1].schema, check_metadata=False), name
            for column in tables[0].column_names:
                mine, theirs = (table[column].to_pylist() for table in tables)
                if isinstance(mine[0], float):
                    theirs = pytest.approx(theirs, rel=RELATIVE, abs=ABSOLUTE)
                assert mine == theirs, f"{name}: {column}"
            continue
        wrong = difference(ours.read_text(encoding="utf-8"), committed.read_text(encoding="utf-8"))
        assert wrong is None, f"{name}: {wrong}; run `cargo run --release -- reproduce` and commit results/"


def test_a_changed_number_or_word_is_a_difference():
    assert difference("λ0 = 33.9 W", "λ0 = 33.9 W") is None
    assert difference("x = 1.00000000001", "x = 1.00000000002") is None
    assert difference("26.4 %", "26.5 %") is None
    assert difference("26 %", "28 %") is not None
    assert difference("0.123456789012", "0.123457789012") is not None
    assert difference("it falls to 2", "it rises to 2") is not None


def test_the_page_names_every_file_with_its_command_and_commit(root):
    page = (root / "results" / "README.md").read_text(encoding="utf-8")
    files = [path for path in (root / "results").iterdir() if path.suffix not in (".py", ".fmu") and path.name != "README.md"]
    missing = [path.name for path in files if not re.search(rf"`{re.escape(path.name)}/?`", page)]
    assert not missing, f"results/README.md does not name {missing}"
    rows = [line for line in page.splitlines() if re.match(r"\| `", line)]
    assert len(rows) >= 8
    for row in rows:
        assert re.search(r"\| [0-9a-f]{7} \|$", row), f"no commit: {row}"


def test_the_commits_of_the_page_are_in_the_history(root):
    def git(*arguments):
        return subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True)

    if git("rev-parse", "--is-shallow-repository").stdout.strip() != "false":
        pytest.skip("this is no git repository with its whole history")
    page = (root / "results" / "README.md").read_text(encoding="utf-8")
    for commit in set(re.findall(r"\| ([0-9a-f]{7}) \|$", page, flags=re.M)):
        known = git("merge-base", "--is-ancestor", commit, "HEAD")
        assert known.returncode == 0, f"{commit} is not in the history: {known.stderr}"
