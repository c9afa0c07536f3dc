"""Modules of a crate have no circular uses: neither files, nor folders with all their contents. A module's `mod` lines and
re-exports (`pub use`) do not count; using a re-export counts as using the module that defines it."""

import re
from graphlib import CycleError, TopologicalSorter

import pytest

TESTS = r"#\[cfg\(test\)\]\n(?:pub )?mod tests"
USE = r"(pub(?:\([^)]*\))? )?\buse ([^;]*);"


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


class Crate:
    """The modules of a source folder, and the modules that each uses."""

    def __init__(self, source):
        code = {}
        for file in sorted(source.rglob("*.rs")):
            names = file.relative_to(source).with_suffix("").parts
            module = names[:-1] if names[-1] in ("mod", "lib", "main") else names
            code[module] = re.sub(r"//.*", "", re.split(TESTS, file.read_text())[0])
        self.modules = set(code)
        self.handed_on, used = {}, {}
        for module, text in code.items():
            uses = [(bool(pub), paths(" ".join(tree.split()))) for pub, tree in re.findall(USE, text)]
            rest = re.sub(USE, "", text)
            inline = re.findall(r"(?<![:\w])(?:\w+::)+\w+", rest)
            self.handed_on[module] = self.absolute(module, (path for pub, tree in uses if pub for path in tree))
            used[module] = self.absolute(module, [*(path for pub, tree in uses if not pub for path in tree), *inline])
        self.graph = {module: {self.home(path) for path in found} - {module} for module, found in used.items()}

    def absolute(self, module, found):
        """Absolute paths within the crate, for those that stay in it."""
        all_of_them = []
        for path in found:
            names = tuple(name.strip() for name in path.split("::") if name.strip() not in ("self", "*"))
            up = sum(name == "super" for name in names)
            if names[:1] == ("crate",):
                all_of_them.append(names[1:])
            elif up:
                all_of_them.append((*module[: len(module) - up], *names[up:]))
            elif (*module, *names[:1]) in self.modules and names:
                all_of_them.append((*module, *names))
        return all_of_them

    def home(self, path):
        """The module that defines the item at a path."""
        for length in range(len(path), -1, -1):
            if path[:length] in self.modules:
                break
        for handed_on in self.handed_on[path[:length]]:
            if length < len(path) and handed_on[-1:] == path[length : length + 1] and handed_on != path[: length + 1]:
                return self.home((*handed_on, *path[length + 1 :]))
        return path[:length]

    def folders(self):
        """For each folder, which of its entries use which others."""
        for folder in sorted({module[:-1] for module in self.modules if module}):
            depth = len(folder) + 1
            inside = {module for module in self.modules if module[:-1][: len(folder)] == folder and len(module) >= depth}
            graph = {module[:depth]: set() for module in inside}
            for module in inside:
                graph[module[:depth]] |= {other[:depth] for other in self.graph[module] & inside} - {module[:depth]}
            yield graph


def refuse_circles(graph):
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as circle:
        pytest.fail("a circle: " + " -> ".join("::".join(module) for module in circle.args[1]))


@pytest.mark.parametrize("crate", ["chamber", "records", "ensemble", "paper", "identify", "sweep", "fmu", "report", "."])
def test_files_import_one_way(root, crate):
    """The division of a module into its own parts does not count here."""
    graph = Crate(root / crate / "src").graph
    assert 2 * sum(map(len, graph.values())) > len(graph), "imports are not seen any more"
    refuse_circles({module: {other for other in used if other[: len(module)] != module} for module, used in graph.items()})


@pytest.mark.parametrize("crate", ["chamber", "records", "ensemble", "paper", "sweep", "fmu", "report", "."])
def test_folders_import_one_way(root, crate):
    for graph in Crate(root / crate / "src").folders():
        refuse_circles(graph)


def test_folders_of_the_preparation_of_records_import_one_way(root):
    whole = Crate(root / "identify/src").folders()
    of_record = [graph for graph in whole if all(module[0] == "record" and len(module) > 1 for module in graph)]
    assert len(of_record) > 8, "folders are not seen any more"
    for graph in of_record:
        refuse_circles(graph)


@pytest.mark.parametrize("crate", ["chamber", "records", "ensemble", "paper", "sweep", "fmu", "report", "."])
def test_modules_and_their_parts_import_one_way(root, crate):
    refuse_circles(Crate(root / crate / "src").graph)


@pytest.fixture
def example(tmp_path):
    for file, text in {
        "lib.rs": "mod one;\nmod two;\npub use one::Other;\n",
        "one/mod.rs": "mod part;\npub use part::Part;\nuse crate::two::{self, Two};\n",
        "one/part.rs": "use super::super::two;\n",
        "two.rs": "use crate::{one::{Part as Whole, Else}, Other};\n",
        "three.rs": "fn f() -> u8 {\n    super::two::g()\n}\n",
        "four/mod.rs": "mod part;\nfn f() -> u8 {\n    part::g()\n}\n",
        "four/part.rs": "use super::Four;\n",
    }.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(text)
    return Crate(tmp_path)


def test_what_a_module_uses_is_seen(example):
    assert example.graph == {
        (): set(),
        ("one",): {("two",)},
        ("one", "part"): {("two",)},
        ("three",): {("two",)},
        ("two",): {("one",), ("one", "part")},
        ("four",): {("four", "part")},
        ("four", "part"): {("four",)},
    }


def test_a_circle_of_folders_is_seen_and_one_of_a_module_and_its_part(example):
    whole, four, one = sorted(example.folders(), key=len, reverse=True)
    assert whole == {("one",): {("two",)}, ("two",): {("one",)}, ("three",): {("two",)}, ("four",): set()}
    assert [*four.values(), *one.values()] == [set(), set()]
    for graph in [whole, {m: used for m, used in example.graph.items() if m[:1] == ("four",)}]:
        with pytest.raises(pytest.fail.Exception, match="a circle"):
            refuse_circles(graph)
