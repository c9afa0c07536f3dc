#!/usr/bin/env python3
"""The study of this folder, as a user would do it: two sweeps, a page of figures, a table of sensitivity indices.

    target/test-environment/bin/python results/study/make.py        (tests/run makes that environment)

Index of the push: n = ln(Ppeak/Pi)/ln(Vi/Vf), shown as (n - 1)/(gamma - 1): 0 isothermal, 1 adiabatic.
"""

import json
import os
import pathlib
import subprocess
import tempfile

import matplotlib
import numpy as np
import pyarrow.dataset as ds

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "pneutherm", "font.size": 8})
import matplotlib.pyplot as plt
from matplotlib.colors import LogNorm
from SALib.analyze import sobol

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = os.environ.get("PNEUTHERM", HERE.parents[1] / "target" / "release" / "pneutherm")
DEAD_VOLUME_M3, GAMMA, INITIAL_STROKE_M = 9.2205e-6, 1.4, 0.25  # as in ../model.toml and study.toml
# Label, factor from SI, ticks of a logarithmic axis.
AXES = {
    "volume_to_area_m": ("V/A, mm", 1e3, [3, 4, 6, 8, 12]),
    "initial_pressure_pa": ("initial pressure, bar", 1e-5, [1, 2, 3, 5, 7]),
    "final_stroke_m": ("final stroke, mm", 1e3, None),
    "push_time_s": ("push time, s", 1.0, [0.02, 0.05, 0.1, 0.2, 0.5, 1]),
}
RESULTS = {
    "time_constant_s": "time constant, s",
    "pressure_ratio": "peak over initial pressure",
    "adiabatic_index": "index of the push\n(0 isothermal, 1 adiabatic)",
}
SENSITIVE = {
    "time_constant_s": "time constant",
    "pressure_peak_pa": "peak pressure",
    "adiabatic_index": "index of the push",
    "lambda0_w_per_m2_k": "λ0 by the paper's steps",
    "settling_time_s": "settling time",
}


def sweep(study, folder):
    subprocess.run([PROGRAM, "sweep", HERE / study, "-o", folder], check=True)
    rows = ds.dataset(pathlib.Path(folder) / "rows").to_table()
    data = {name: rows[name].to_numpy() for name in rows.column_names if name != "status"}
    area = (data["volume_m3"] - DEAD_VOLUME_M3) / data["final_stroke_m"]
    ratio = (DEAD_VOLUME_M3 + area * INITIAL_STROKE_M) / data["volume_m3"]
    exponent = np.log(data["pressure_peak_pa"] / data["initial_pressure_pa"]) / np.log(ratio)
    data["adiabatic_index"] = (exponent - 1) / (GAMMA - 1)
    data["pressure_ratio"] = data["pressure_peak_pa"] / data["initial_pressure_pa"]
    return data


def figures(data):
    figure, panels = plt.subplots(3, 4, figsize=(11, 7.5), sharex="col", sharey="row", layout="constrained")
    pressure = data["initial_pressure_pa"] * 1e-5
    colours = LogNorm(1, 7)
    some = slice(0, 1500)
    for line, (result, label) in zip(panels, RESULTS.items()):
        line[0].set_ylabel(label)
        for panel, (name, (_, scale, ticks)) in zip(line, AXES.items()):
            x, y = data[name] * scale, data[result]
            points = panel.scatter(x[some], y[some], c=pressure[some], norm=colours, s=2, cmap="viridis", linewidths=0, rasterized=True)
            # The median and the central 80 %, for each twelfth of the axis.
            edges = np.quantile(x, np.linspace(0, 1, 13))
            place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, 11)
            middle = [np.quantile(y[place == k], [0.1, 0.5, 0.9]) for k in range(12)]
            centre = [np.median(x[place == k]) for k in range(12)]
            for k, style in enumerate(["k:", "k-", "k:"]):
                panel.plot(centre, [m[k] for m in middle], style, linewidth=1)
            if ticks:
                panel.set_xscale("log")
                panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
                panel.minorticks_off()
    for panel, (axis, _, _) in zip(panels[-1], AXES.values()):
        panel.set_xlabel(axis)
    bar = figure.colorbar(points, ax=panels, shrink=0.6, label="initial pressure, bar", pad=0.01)
    bar.set_ticks([1, 2, 3, 5, 7], labels=["1", "2", "3", "5", "7"])
    bar.minorticks_off()
    figure.suptitle("Push-and-hold tests: 1500 of 8192 as points; median (line) and middle 80 % (dotted) of all")
    figure.savefig(HERE / "figures.svg", dpi=110, metadata={"Date": None})


def bars(indices):
    """First- and total-order indices with their 95 % intervals."""
    figure, panels = plt.subplots(1, len(SENSITIVE), figsize=(11, 2.8), sharey=True, layout="constrained")
    place = np.arange(len(AXES))
    for panel, (result, label) in zip(panels, SENSITIVE.items()):
        for shift, order, name in [(-0.2, "first_order", "alone (first order)"), (0.2, "total_order", "with others (total)")]:
            found = [indices[result][order][axis] for axis in AXES]
            value = [f["value"] for f in found]
            half_widths = [f["ci95"] for f in found]
            panel.barh(place + shift, value, 0.38, xerr=half_widths, label=name, error_kw={"linewidth": 0.8})
        panel.set_title(label, fontsize=8)
        panel.set_xlim(-0.02, 1)
        panel.set_xlabel("share of the variance")
    panels[0].set_yticks(place, [axis.split(",")[0] for axis, _, _ in AXES.values()])
    panels[0].invert_yaxis()
    panels[-1].legend(fontsize=7)
    figure.savefig(HERE / "sensitivities.svg", metadata={"Date": None})


def sensitivities(data, folder):
    ours = json.loads((pathlib.Path(folder) / "sensitivity.json").read_text())["outputs"]
    names = list(AXES)
    index = sobol.analyze({"num_vars": 4, "names": names, "bounds": [[0, 1]] * 4}, data["adiabatic_index"], calc_second_order=False, seed=1)
    ours["adiabatic_index"] = {
        order: {name: {"value": index[key][i], "ci95": index[key + "_conf"][i]} for i, name in enumerate(names)}
        for order, key in (("first_order", "S1"), ("total_order", "ST"))
    }
    bars(ours)
    lines = ["| result | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for result in SENSITIVE:
        first, total = ours[result]["first_order"], ours[result]["total_order"]
        cells = [f"{first[n]['value']:.2f} / {total[n]['value']:.2f}" for n in names]
        lines.append(f"| `{result}` | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    with tempfile.TemporaryDirectory() as folder:
        data = sweep("study.toml", f"{folder}/study")
        figures(data)
        table = sensitivities(sweep("sensitivity.toml", f"{folder}/sensitivity"), f"{folder}/sensitivity")
    quantiles = {name: np.quantile(data[name], [0.05, 0.5, 0.95]) for name in ("time_constant_s", "pressure_ratio", "adiabatic_index")}
    spread = "\n".join(f"| `{name}` | " + " | ".join(f"{v:.3g}" for v in q) + " |" for name, q in quantiles.items())
    (HERE / "README.md").write_text(f"""# A study: what the push and its relaxation depend on

Written by `results/study/make.py` from `study.toml` (8192 points, Sobol') and `sensitivity.toml` (12288 rows, Saltelli), both about the
chamber in `../model.toml`. Index of the push: (n - 1)/(gamma - 1) with n = ln(Ppeak/Pi)/ln(Vi/Vf): 0 isothermal, 1 adiabatic.

![figures](figures.svg)

| result | 5 % | median | 95 % |
|---|---|---|---|
{spread}

Share of the variance over the ranges of the study, first order / total order:

{table}

![sensitivities](sensitivities.svg)

Where the total exceeds the first order, quantities act together.
""")


if __name__ == "__main__":
    main()
