#!/usr/bin/env python3
"""Runs the contenders in turn on the same scenarios and writes results/benchmarks.md and benchmarks.json.

`benches/run` makes what this needs and calls it.
"""

import argparse
import contextlib
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
BENCHES, RESULTS, TARGET = ROOT / "benches", ROOT / "results", ROOT / "target" / "benches"
sys.path[:0] = [str(BENCHES), str(BENCHES / "contenders")]
import report
import scenario
from table import CONTENDERS, WHOLE_PROCESS

PROGRAM = pathlib.Path(os.environ.get("PNEUTHERM", ROOT / "target" / "release" / "pneutherm"))


def rows_of(study, folder, **changes):
    """A study's rows as a table, by `pneutherm sweep`; `changes` replace lines of the study file. Also the seconds it took and
    the most memory it held, bytes."""
    import pyarrow.dataset

    text = (BENCHES / study).read_text()
    for key, value in changes.items():
        lines = [f"{key} = {json.dumps(value)}" if line.startswith(f"{key} =") else line for line in text.splitlines()]
        text = "\n".join(lines) if f"{key} =" in text else text.replace("[test]", f"{key} = {json.dumps(value)}\n[test]")
    shutil.copy(BENCHES / "model.toml", folder / "model.toml")
    (folder / study).write_text(text)
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    begun, memory = time.perf_counter(), 0
    sweep = subprocess.Popen([PROGRAM, "sweep", folder / study, "-o", out], stdout=subprocess.DEVNULL)
    # What `wait4` gives for a child's memory is at least this process's own.
    while sweep.poll() is None:
        memory = max(memory, peak_memory(sweep.pid))
        time.sleep(0.002)
    seconds = time.perf_counter() - begun
    if sweep.returncode:
        raise SystemExit(f"{study}: pneutherm sweep ended with {sweep.returncode}")
    return pyarrow.dataset.dataset(out / "rows").to_table(), seconds, memory


def cases_of(rows):
    """Rows of a study as the contenders read them."""
    names = {name: next((n for n in rows.column_names if n.endswith(name)), None) for name in scenario.COLUMNS}
    columns = [
        rows[names[name]].to_numpy() if names[name] else np.full(rows.num_rows, constant)
        for name, constant in scenario.COLUMNS.items()
    ]
    return np.stack(columns, axis=1)


class Contender:
    """A contender's process, ready to be timed."""

    def __init__(self, entry, files):
        self.entry = entry
        path = str(files[entry.study])
        if entry.program.endswith(".py"):
            options = {k: v.format(**files) if isinstance(v, str) else v for k, v in entry.options.items()}
            command = [sys.executable, BENCHES / "contenders" / entry.program, path, json.dumps(options)]
        else:
            built = TARGET / "release" if entry.program == "ours" else TARGET / "native" / "release"
            options = [f"{key}={str(value).lower()}" for key, value in entry.options.items()]
            command = [built / "contenders", entry.program, path, *options]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.seconds = []

    def answer(self, line=None):
        if line:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        answer = self.process.stdout.readline().strip()
        if not answer:
            raise SystemExit(f"{self.entry.name}: the contender ended with {self.process.wait()}")
        return answer

    def go(self):
        return float(self.answer(f"go {self.entry.rows}"))

    def pressures(self, folder):
        path = folder / "answers.f64"
        self.answer(f"save {path}")
        return np.fromfile(path).reshape(-1, 2)

    def peak_memory(self):
        """Most memory that the contender's processes have held, bytes."""
        return sum(map(peak_memory, [self.process.pid, *children(self.process.pid)]))

    def end(self):
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.wait(timeout=30)


def children(pid):
    """Processes that a process has started, and theirs."""
    tasks = pathlib.Path(f"/proc/{pid}/task").iterdir()
    own = [int(child) for task in tasks for child in (task / "children").read_text().split()]
    return [process for child in own for process in (child, *children(child))]


def peak_memory(pid):
    """Most memory that a process has held, bytes."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    # A process that has just ended has none.
    return next((int(line.split()[1]) << 10 for line in status.splitlines() if line.startswith("VmHWM")), 0)


def errors(found, expected, ours=True):
    """Largest relative errors of peak and final pressure. `expected` has a third column, the pressure at the end of the
    push, which the peers give for the peak; with an inflow the peak may come later."""
    wanted = expected[: len(found), [0, 1] if ours else [2, 1]]
    return [float(e) for e in np.nanmax(np.abs(found / wanted - 1), axis=0)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7, help="times each contender is run, in turn with the others")
    parser.add_argument("--only", default="", help="contenders whose name has this in it; writes nothing")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        entries = [entry for entry in CONTENDERS if arguments.only in entry.name]
        files, expected, checks = prepare(folder, {"sealed": None} | {entry.study: None for entry in entries})
        contenders = [Contender(entry, files) for entry in entries]
        for contender in contenders:
            contender.answer()
            contender.go()  # compiles, fills caches
            print(f"ready: {contender.entry.name}", file=sys.stderr)
        for number in range(arguments.rounds):
            for contender in contenders:
                contender.seconds.append(contender.go())
            print(f"round {number + 1} of {arguments.rounds}", file=sys.stderr)
        results = []
        for contender in contenders:
            entry = contender.entry
            found = contender.pressures(folder)
            error = errors(found, expected[entry.study], ours=entry.program == "ours")
            results.append(report.Result.of(entry, contender.seconds, contender.peak_memory(), *error))
            contender.end()
        for entry in WHOLE_PROCESS if not arguments.only else []:
            results.append(whole_process(entry, folder, max(3, arguments.rounds // 2)))
        outcome = report.Outcome(results, checks, machine())
    if arguments.only:
        for study in {entry.study: None for entry in entries}:
            print(outcome.table([r for r in results if r.study == study]))
        return
    RESULTS.joinpath("benchmarks.md").write_text(outcome.markdown())
    RESULTS.joinpath("benchmarks.json").write_text(json.dumps(outcome.plain(), indent=1) + "\n")
    print(outcome.markdown())


def prepare(folder, studies):
    """Scenario files and FMU, the expected pressures, and how far the references are from each other."""
    import reference

    files, expected = {}, {}
    for study in studies:
        rows, *_ = rows_of(f"{study}.toml", folder)
        cases = cases_of(rows)
        files[study] = folder / f"{study}.f64"
        cases.tofile(files[study])
        if study == "sealed":
            expected[study] = scenario.Sealed.of(cases).exact()[:, [0, 1, 0]]
        else:
            # No closed form: an independent integration of some rows, the only ones that are compared.
            expected[study] = np.full((len(cases), 3), np.nan)
            some = np.arange(0, len(cases), len(cases) // 1024)
            expected[study][some] = reference.integrate_all(cases[some])
    files["fmu"] = folder / "Chamber.fmu"
    subprocess.run([PROGRAM, "fmu", BENCHES / "model.toml", "-o", files["fmu"]], check=True, stdout=subprocess.DEVNULL)
    checks = {}
    if "sealed" in studies:
        cases = scenario.read(files["sealed"])
        some = np.arange(0, len(cases), len(cases) // 64)
        distance = np.abs(reference.integrate_all(cases[some]) / expected["sealed"][some] - 1).max()
        checks["closed form against scipy's DOP853 at rtol 1e-12, 64 rows"] = float(distance)
    return files, expected, checks


def whole_process(entry, folder, repetitions):
    """The program from its start to the synced manifest."""
    seconds = []
    for _ in range(repetitions):
        rows, time_s, memory = rows_of(f"{entry.study}.toml", folder, samples=entry.rows, **entry.options)
        seconds.append(time_s)
    found = np.stack([rows["pressure_peak_pa"].to_numpy(), rows["pressure_final_pa"].to_numpy()], axis=1)
    expected = scenario.Sealed.of(cases_of(rows)).exact()
    return report.Result.of(entry, seconds, memory, *errors(found, expected))


def machine():
    """Processor, versions."""
    from importlib.metadata import version

    cpu = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.processor())
    flags = next((l for l in open("/proc/cpuinfo") if l.startswith("flags")), "")
    lock = (BENCHES / "rust" / "Cargo.lock").read_text().split("[[package]]")
    crate = lambda name: next(b.split('version = "')[1].split('"')[0] for b in lock if f'name = "{name}"\n' in b)
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True).stdout.split()[1]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    packages = {name: version(name) for name in ("heyoka", "diffrax", "jax", "scipy", "fmpy", "numpy")}
    crates = {name: crate(name) for name in ("differential-equations", "diffsol")}
    return {
        "processor": cpu,
        "cores": len(os.sched_getaffinity(0)),
        "avx512": "avx512f" in flags,
        "system": f"{platform.system()} {platform.release()}",
        "commit": commit,
        "versions": {"python": platform.python_version(), "rustc": rustc, **packages, **crates},
    }


if __name__ == "__main__":
    main()
