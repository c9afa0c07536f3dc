#!/usr/bin/env python3
"""Draws the pictures of results/README.md that `pneutherm reproduce` does not draw.

    python3 results/gallery.py PROGRAM [diagnosed_rig] [gas_spring] [benchmarks]

`diagnosed_rig.svg` and `gas_spring.svg` are charts of `pneutherm diagnose --report`, as drawn by the program; `benchmarks.svg`
shows results/benchmarks.json. The gas spring's records are not part of this project (rigs/mbari-upper.toml says where they are
published).
"""

import html
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
WIDTH, HEIGHT = 880, 620
# Solvers of results/benchmarks.json in the picture: name in the file, and label.
SOLVERS = [
    ("exact solution", "pneutherm, exact solution"),
    ("full equations, rtol 1e-10 (the default)", "pneutherm, full equations"),
    ("diffsol, 128 as one system", "diffsol, 128 wide"),
    ("heyoka, transformed, 128 wide", "heyoka, 128 wide"),
    ("diffrax, vmap", "diffrax, vmap"),
    ("differential-equations, one at a time", "differential-equations"),
    ("FMPy, push and hold only", "FMPy, one simulation per row"),
    ("scipy, solve_ivp", "scipy, solve_ivp"),
]


def charts(program, rig, experiment, titles):
    """Charts of a diagnosis report, selected by title."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.html"
        subprocess.run([program, "diagnose", rig, "--report", report], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        page = report.read_text(encoding="utf-8")
    drawings = re.findall(r"<svg viewBox=.*?</svg>", page, flags=re.S)
    return [next(d for d in drawings if f">{html.escape(experiment)}: {title}<" in d) for title in titles]


def beside(drawings):
    """Drawings side by side in one file."""
    placed = [
        drawing.replace("<svg ", f'<svg x="{i * WIDTH}" y="0" width="{WIDTH}" height="{HEIGHT}" ', 1)
        for i, drawing in enumerate(drawings)
    ]
    size = f'viewBox="0 0 {len(drawings) * WIDTH} {HEIGHT}" width="{len(drawings) * WIDTH // 2}" height="{HEIGHT // 2}"'
    background = '<rect width="100%" height="100%" fill="#FFFFFF"/>\n'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n{background}' + "\n".join(placed) + "\n</svg>\n"


def diagnosed_rig(program):
    return beside(charts(program, "examples/cylinder", "compress-3bar", ["pressure and position", "residual"]))


def gas_spring(program):
    return beside(charts(program, "rigs/mbari-upper-moves.toml", "moves", ["pressure and position", "residual"]))


def benchmarks(_):
    """Rows per second of each solver, on a logarithmic axis."""
    measured = json.loads((HERE / "benchmarks.json").read_text())
    rates = {result["name"]: result["rate"] for result in measured["results"]}
    left, right, top, step = 380, 970, 86, 44
    decades = range(3, 8)
    to_x = lambda rate: left + (right - left) * (math.log10(rate) - decades[0]) / (decades[-1] - decades[0])
    bottom = top + step * len(SOLVERS)
    text = lambda x, y, words, anchor="start", size=20: (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-family="sans-serif" font-size="{size}" fill="#1E1E1E">{words}</text>'
    )
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1120 {bottom + 76}" width="560" height="{(bottom + 76) // 2}">',
        '<rect width="100%" height="100%" fill="#FFFFFF"/>',
        text(20, 36, "Push-and-hold tests per second, 2 cores", size=26),
    ]
    for decade in decades:
        x = to_x(10.0**decade)
        lines.append(f'<line x1="{x:.1f}" y1="{top - 14}" x2="{x:.1f}" y2="{bottom}" stroke="#D8D8D8"/>')
        lines.append(text(x, bottom + 28, f"10<tspan dy='-8' font-size='14'>{decade}</tspan>", "middle"))
    for i, (name, label) in enumerate(SOLVERS):
        y, ours = top + step * i, name in [solver for solver, _ in SOLVERS[:2]]
        x = max(to_x(rates[name]), left + 2.0)
        lines.append(text(left - 12, y + 21, label, "end"))
        lines.append(f'<rect x="{left}" y="{y}" width="{x - left:.1f}" height="28" fill="{"#1F5FA8" if ours else "#B9B9B9"}"/>')
        lines.append(text(x + 8, y + 21, _short(rates[name]), size=18))
    lines.append(text((left + right) / 2, bottom + 62, "rows per second", "middle"))
    return "\n".join(lines) + "\n</svg>\n"


def _short(rate):
    for size, unit in [(1e6, "million"), (1e3, "thousand")]:
        if rate >= size:
            return f"{rate / size:.3g} {unit}"
    return f"{rate:.3g}"


PICTURES = {"diagnosed_rig": diagnosed_rig, "gas_spring": gas_spring, "benchmarks": benchmarks}


if __name__ == "__main__":
    program = pathlib.Path(sys.argv[1]).resolve()
    for name in sys.argv[2:] or PICTURES:
        (HERE / f"{name}.svg").write_text(PICTURES[name](program), encoding="utf-8")
