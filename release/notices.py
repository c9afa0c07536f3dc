#!/usr/bin/env python3
"""Writes THIRD-PARTY.md: every crate in the program and its Python module with its licence, and the texts of those licences.

    python3 release/notices.py            # writes the file
    python3 release/notices.py --check    # fails when it is not up to date

The list is that of `cargo metadata` on the platforms that are shipped; the texts
are those in the crates themselves, each printed once.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "THIRD-PARTY.md"
PLATFORMS = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-msvc", "aarch64-apple-darwin"]
TEXTS = re.compile(r"(?i)^(licen[cs]e|copying|notice|unlicense)([-._].*)?$")

HEAD = """# Third parties

The program and its Python module contain these crates. pneutherm itself is MIT or Apache 2.0, as you prefer. The Sobol
direction numbers are those of S. Joe and F. Y. Kuo (BSD, `sweep/src/design/JOE_KUO_LICENCE.txt`).

Made by `release/notices.py`.

"""


def packages(manifest):
    """The third-party packages that the package of that manifest links, by name and version."""
    found = {}
    for platform in PLATFORMS:
        command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", platform]
        text = subprocess.run(
            [*command, "--manifest-path", str(ROOT / manifest)], check=True, capture_output=True, text=True
        ).stdout
        metadata = json.loads(text)
        by_id = {package["id"]: package for package in metadata["packages"]}
        nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
        queue = [metadata["resolve"]["root"]]
        seen = set(queue)
        while queue:
            for dependency in nodes[queue.pop()]["deps"]:
                kinds = {kind["kind"] for kind in dependency["dep_kinds"]}
                if dependency["pkg"] not in seen and None in kinds:
                    seen.add(dependency["pkg"])
                    queue.append(dependency["pkg"])
        for identity in seen:
            package = by_id[identity]
            if package["source"] is not None:
                found[package["name"], package["version"]] = package
    return found


def texts(package):
    """The licence texts in the package's folder, by file name."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and TEXTS.match(path.name)]
    return {path.name: path.read_text(encoding="utf-8", errors="replace").strip() for path in files}


def render():
    found = packages("Cargo.toml") | packages("python/Cargo.toml")
    lines = [HEAD, "| crate | version | licence |\n|---|---|---|\n"]
    users = collections.defaultdict(list)
    for (name, version), package in sorted(found.items()):
        licence = package["license"] or package["license_file"] or "see its text"
        lines.append(f"| [{name}](https://crates.io/crates/{name}) | {version} | {licence} |\n")
        for text in texts(package).values():
            users[re.sub(r"\s+", " ", text)].append((f"{name} {version}", text))
    lines.append("\n## Texts\n")
    for entries in sorted(users.values(), key=lambda entries: entries[0][0]):
        names = ", ".join(sorted({name for name, _ in entries}))
        fence = "`" * 4
        lines.append(f"\n### {names}\n\n{fence}text\n{entries[0][1]}\n{fence}\n")
    return "".join(lines)


def main():
    text = render()
    if "--check" in sys.argv[1:]:
        if not OUTPUT.exists() or OUTPUT.read_text(encoding="utf-8") != text:
            sys.exit(f"{OUTPUT.name} is not up to date: run python3 release/notices.py")
    else:
        OUTPUT.write_text(text, encoding="utf-8")
        print(f"{OUTPUT.relative_to(ROOT)}: {len(text)} bytes")


if __name__ == "__main__":
    main()
