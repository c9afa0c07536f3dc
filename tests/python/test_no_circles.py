"""Files of a crate look one way: none imports one that leads back to it. By the paths that begin with `crate` and `super`; how a
module is divided into its own parts does not count."""

import re
from graphlib import CycleError, TopologicalSorter

import pytest


def paths(tree, head=""):
    """The paths of a `use` tree: `a::{b, c::d}` is `a::b` and `a::c::d`."""
    if "{" not in tree:
        return [head + tree.split(" as ")[0].strip()]
    stem, _, rest = tree.partition("{")
    parts, depth, part = [], 0, ""
    for sign in rest.rpartition("}")[0]:
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += sign
    return [path for each in [*parts, part] if each.strip() for path in paths(each.strip(), head + stem.strip())]


def imports(source):
    """For each module of a source folder the modules that it names; a path's longest beginning that is one counts."""
    files = {}
    for file in sorted(source.rglob("*.rs")):
        names = file.relative_to(source).with_suffix("").parts
        files[names[:-1] if names[-1] in ("mod", "lib", "main") else names] = file
    graph = {}
    for module, file in files.items():
        code = re.sub(r"//.*", "", file.read_text().split("#[cfg(test)]\nmod tests")[0])
        used = [path for tree in re.findall(r"\buse ((?:crate|super)[^;]*);", code) for path in paths(" ".join(tree.split()))]
        used += re.findall(r"\b(?:crate|super)::(?:\w+::)+\w+", re.sub(r"\buse [^;]*;", "", code))
        found = set()
        for path in used:
            names = [name.strip() for name in path.split("::")]
            up = names.count("super")
            names = (*module[: len(module) - up], *names[up:]) if up else tuple(names[1:])
            while names and names not in files:
                names = names[:-1]
            if names and names != module:
                found.add(names)
        graph[module] = found
    return graph


@pytest.mark.parametrize("crate", ["chamber", "records", "ensemble", "paper", "identify", "sweep", "fmu", "report", "."])
def test_files_import_one_way(root, crate):
    graph = imports(root / crate / "src")
    assert 2 * sum(map(len, graph.values())) > len(graph), "imports are not seen any more"
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as circle:
        pytest.fail("a circle of files: " + " -> ".join("::".join(module) for module in circle.args[1]))


def test_a_circle_is_seen(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "lib.rs").write_text("mod one;\nmod two;\n")
    (tmp_path / "one" / "mod.rs").write_text("mod part;\nuse crate::two::{self, Two};\n")
    (tmp_path / "one" / "part.rs").write_text("use super::super::two;\n")
    (tmp_path / "two.rs").write_text("use crate::{one::{part::Part, Other}};\n")
    (tmp_path / "three.rs").write_text("fn f() -> u8 {\n    super::two::g()\n}\n")
    assert imports(tmp_path) == {
        (): set(),
        ("one",): {("two",)},
        ("one", "part"): {("two",)},
        ("three",): {("two",)},
        ("two",): {("one",), ("one", "part")},
    }
