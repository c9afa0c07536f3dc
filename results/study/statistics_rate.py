#!/usr/bin/env python3
"""Cost of statistics without rows: time, processor time and memory for many rows, and the rate compared with solving only.

    cargo build --release -p pneutherm -p pneutherm-sweep --example statistics_rate --bins
    python3 results/study/statistics_rate.py [rows, 1000000000 by default]

Uses the rows of `benches/sealed.toml`. A billion takes two minutes on two processors. Writes statistics_rate.md beside this
file.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PROGRAM = os.environ.get("PNEUTHERM", ROOT / "target" / "release" / "pneutherm")
EXAMPLE = ROOT / "target" / "release" / "examples" / "statistics_rate"


def main():
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 10**9
    rates = subprocess.run([EXAMPLE, "benches/sealed.toml"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    alone, beside, share = re.search(r"only\s+(\d+) rows/s.*statistics\s+(\d+) rows/s, ([\d.]+) %", rates, re.DOTALL).groups()
    with tempfile.TemporaryDirectory() as scratch:
        study = pathlib.Path(scratch) / "study.toml"
        text = (ROOT / "benches" / "sealed.toml").read_text().replace("samples = 131072", f"samples = {rows}")
        study.write_text(text.replace('"model.toml"', f'"{ROOT / "benches" / "model.toml"}"'))
        begun = time.monotonic()
        process = subprocess.Popen([PROGRAM, "sweep", study, "-o", pathlib.Path(scratch) / "out", "--no-rows"], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.monotonic() - begun
        assert status == 0, "the study failed"
    (HERE / "statistics_rate.md").write_text(f"""# Statistics without rows

`results/study/statistics_rate.py`, {os.cpu_count()} processors: rows of `benches/sealed.toml` (closed form, `fit = false`), statistics of every
column.

| | |
|---|---|
| rows | {rows:.0e} |
| wall time | {seconds:.0f} s |
| processor time, all threads | {usage.ru_utime + usage.ru_stime:.0f} s |
| largest memory | {usage.ru_maxrss / 1024:.0f} MiB |
| one thread, rows solved only | {int(alone):,} rows/s |
| one thread, with statistics of every column | {int(beside):,} rows/s, {share} % |

The rates are the best of 100 turns of 131,072 rows each, taken in turn (`sweep/examples/statistics_rate.rs`).
""")


if __name__ == "__main__":
    main()
