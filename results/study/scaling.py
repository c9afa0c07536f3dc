#!/usr/bin/env python3
"""Time and memory of a study as a function of its number of rows; whole process, with Parquet output.

    target/test-environment/bin/python results/study/scaling.py [largest power of ten, 8 by default] [scratch folder]

Sealed chamber, five varied quantities, `fit = false`. Writes scaling.md and scaling.svg beside this file.
"""

import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "pneutherm", "font.size": 9})
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = os.environ.get("PNEUTHERM", HERE.parents[1] / "target" / "release" / "pneutherm")
STUDY = """
[study]
model = "{model}"
design = "latin-hypercube"
samples = {rows}
seed = 1
fit = false
[test]
final_stroke_m = 0.05
duration_s = 3.0
[vary]
bore_m = {{ from = 0.016, to = 0.063, scale = "log" }}
initial_pressure_pa = {{ from = 1e5, to = 7e5 }}
initial_stroke_m = {{ from = 0.06, to = 0.3 }}
push_time_s = {{ from = 0.02, to = 0.4, scale = "log" }}
coefficient_w_per_m2_k = {{ from = 10.0, to = 60.0 }}
"""


def measure(rows, scratch):
    """Seconds, peak resident memory in MiB, and bytes of one study."""
    study, out = scratch / "study.toml", scratch / "out"
    study.write_text(STUDY.format(rows=rows, model=HERE.parent / "model_one_lambda0.toml"))
    begun = time.monotonic()
    process = subprocess.Popen([PROGRAM, "sweep", study, "-o", out], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.monotonic() - begun
    assert status == 0, "the study failed"
    size = sum(file.stat().st_size for file in out.glob("*.parquet"))
    shutil.rmtree(out)
    return seconds, usage.ru_maxrss / 1024, size


def main():
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    with tempfile.TemporaryDirectory(dir=sys.argv[2] if len(sys.argv) > 2 else None) as scratch:
        found = [(10**power, *measure(10**power, pathlib.Path(scratch))) for power in range(4, largest + 1)]
    figure, (above, below) = plt.subplots(2, 1, figsize=(6, 6), sharex=True, layout="constrained")
    rows = [line[0] for line in found]
    above.loglog(rows, [line[1] for line in found], "o-")
    above.loglog(rows, [found[-1][1] * n / rows[-1] for n in rows], "k:", label="proportional to the rows")
    above.set_ylabel("time, s")
    above.legend()
    below.loglog(rows, [line[2] for line in found], "o-")
    below.axhline(1024, color="k", linestyle=":", label="1 GiB")
    below.set(xlabel="rows", ylabel="largest memory, MiB")
    below.legend()
    figure.savefig(HERE / "scaling.svg", metadata={"Date": None})
    lines = [f"| {n:.0e} | {s:.2f} | {n / s:,.0f} | {m:.0f} | {b / n:.0f} |" for n, s, m, b in found]
    (HERE / "scaling.md").write_text(
        "# Time and memory against rows\n\n"
        f"`results/study/scaling.py`, {os.cpu_count()} processors ({platform.machine()}): sealed chamber, five quantities vary,\n"
        "`fit = false`, the whole process with Parquet written and synced. Rates of the\n"
        "program alone are in `../benchmarks.md`.\n\n![scaling](scaling.svg)\n\n"
        "| rows | s | rows/s | largest memory, MiB | bytes/row |\n|---|---|---|---|---|\n" + "\n".join(lines) + "\n"
    )


if __name__ == "__main__":
    main()
