"""Recordings as benches make them, of rigs from the simulator in `rigs.py`, which shares no code with the program.

    python tests/python/recordings.py FOLDER [--rigs 2] [--only held,white] [--effects none|one] [--program target/release/pneutherm]

writes every recording of the list for a few rigs (rig.toml, traces and answer.json each), diagnoses each and prints a
table. A recording says what it does and what a diagnosis owes to it when the rig has no effect: see `Recording`.
"""

import argparse
import dataclasses
import json
import math
import pathlib
import subprocess
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

import reference
import rigs

STEP_12_BIT = 1.6e6 / 4096
STEP_16_BIT = 1e6 / 65536


class Bench(reference.Chamber):
    """A chamber with features that the paper's model lacks and that are no effects of the list, or only became so recently."""

    ambient_rate = 0.0  # K/s
    warm_wall = 0.0  # K
    warm_start = 0.0  # K
    supply = 0.0  # sonic conductance from 7 bar, m3/(s Pa)
    real_air = False

    def rates_at(self, t, y, x, v):
        cold = self.ambient_temperature
        self.ambient_temperature = ambient = cold + self.ambient_rate * t
        p, m = y[0], y[1]
        volume = self.volume(x)
        temperature = p * volume / (m * self.gas_constant)
        if self.real_air:
            # cp/R of air: Moran and Shapiro, table A-21. The pressure of a closed gas follows gamma at its temperature.
            cp = np.polyval([0.2763e-12, -1.913e-9, 3.294e-6, -1.337e-3, 3.653], temperature)
            self.gamma = cp / (cp - 1)
        try:
            rates, _ = self.rates(y, x, v, 0.0)
            power = self.warm_wall * self.coefficient(p, temperature, ambient, x, v) * self.heat_area(x)
            # Flow between the supply and the gas, from the higher pressure to the lower one.
            up, down, warm = (7e5, p, ambient) if p < 7e5 else (p, 7e5, temperature)
            over = max((down / up - 0.3) / 0.7, 0.0)
            flow = self.supply * up * 1.185 * math.sqrt(293.15 / warm) * math.sqrt(1 - over**2) * (1 if p < 7e5 else -1)
            rates[0] += ((self.gamma - 1) * power + self.gamma * self.gas_constant * flow * warm) / volume
            rates[1] += flow
        finally:
            self.ambient_temperature = cold
        return rates


@dataclasses.dataclass
class Logger:
    """From the gas to the rows of a file, and the statements of the rig file. SI units."""

    noise: float = 100.0
    step: float = STEP_16_BIT
    coloured: object = None  # rows, rate, generator -> Pa
    outliers: float = 0.0
    one_reading: float | None = None
    low_pass: float = 0.0
    delay: tuple = (0.0, 0.0)  # common, standard deviation between records
    offset: tuple = (0.0, 0.0)
    readout: tuple | None = None  # Hz, "held" or "interpolated"
    position_delay: float = 0.0
    position_low_pass: float = 0.0
    position_readout: tuple | None = None  # Hz, "held" or "interpolated"
    position_lost: float = 0.0  # fraction of the readings
    position_wave: tuple | None = None  # nonlinearity: amplitude over the travel, angle at its start and along it
    travel: tuple = (0.0, 1.0)  # range of positions in the tests, m
    creep: float = 0.0
    ambient_rise: float = 0.0
    pressure_unit: float = 1.0
    time_unit: float = 1.0
    bore: float = 1.0
    scale: float = 1.0
    position_offset: float = 0.0
    ambient_stated: float = 0.0
    ambient_column: bool = True
    repeated_stamps: int = 0
    jitter: float = 0.0  # of the reading times, standard deviation, rows


@dataclasses.dataclass
class Recording:
    name: str
    change: object  # chamber, logger, generator ->
    expected: str = "adequate"  # or "not explained", "refused", "named"
    names: tuple = ()  # also right, besides the rig's own effect
    judges_lambda0: bool = True


def autoregressive(sd, correlation):
    return lambda n, rate, g: lfilter([sd * math.sqrt(1 - correlation**2)], [1, -correlation], g.normal(size=n + 200))[200:]


def one_over_f(sd):
    def rows(n, rate, g):
        # Shaped in the frequency domain: amplitude ~ f^-1/2 from 1/40 s to half the row rate.
        count = max(1 << (n - 1).bit_length(), int(40 * rate))
        spectrum = np.fft.rfft(g.normal(size=count))
        spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
        spectrum[0] = 0
        signal = np.fft.irfft(spectrum, count)
        return sd * signal[:n] / signal.std()

    return rows


def set_to(**values):
    """A change of the logger's fields; a value may be a function of the generator."""

    def change(chamber, logger, g):
        for key, value in values.items():
            setattr(logger, key, value(g) if callable(value) and key != "coloured" else value)

    return change


def set_bench(**values):
    def change(chamber, logger, g):
        for key, value in values.items():
            setattr(chamber, key, value)

    return change


def sized(low, high):
    return lambda g: float(np.exp(g.uniform(math.log(low), math.log(high))))


def coloured(kind):
    """A slow disturbance of 60 to 300 Pa in place of the white noise, or with a little of it."""

    def change(chamber, logger, g):
        sd = sized(60, 300)(g)
        phase = g.uniform(0, math.tau)
        logger.noise, logger.coloured = {
            "ar1": (1e-9, autoregressive(sd, 0.9)),
            "average": (1e-9, lambda n, rate, g: np.convolve(g.normal(0, sd * math.sqrt(20), n + 19), np.ones(20) / 20, "valid")),
            "1/f": (60.0, one_over_f(sd)),
            "walk": (60.0, lambda n, rate, g: np.cumsum(g.normal(0, sd / math.sqrt(rate), n))),
            "hum": (60.0, lambda n, rate, g: sd * np.sin(math.tau * 0.3 * np.arange(n) / rate + phase + g.uniform(0, math.tau))),
        }[kind]

    return change


def either(size, around=0.0):
    return lambda g: around + size * float(g.choice([-1, 1]))


def low_pass(chamber, logger, g):
    sd = sized(60, 300)(g)
    logger.low_pass, logger.noise = 0.008, 1e-9
    logger.coloured = lambda n, rate, g: autoregressive(sd, math.exp(-1 / rate / 0.008))(n, rate, g)


def supply_leak(chamber, logger, g):
    volume = chamber.volume(0.1)
    capacity = 3e5 * volume / 295 / (chamber.gamma - 1)
    relaxation = capacity / (chamber.coefficient(3e5, 295, 295, 0.1, 0) * chamber.heat_area(0.1))
    chamber.supply = 3e-3 * volume / 1e5 / relaxation


def within_tolerance(chamber, logger, g):
    logger.bore, logger.scale = 1 + 0.005 * g.normal(), 1 + 0.005 * g.normal()
    logger.position_offset, logger.ambient_stated = 5e-4 * g.normal(), 2.0 * g.normal()
    logger.ambient_column = bool(g.integers(2))


RECORDINGS = [
    Recording("white", set_to(noise=sized(60, 300))),
    Recording("12-bit-20", set_to(noise=20.0, step=STEP_12_BIT)),
    Recording("12-bit-60", set_to(noise=60.0, step=STEP_12_BIT)),
    Recording("12-bit-150", set_to(noise=150.0, step=STEP_12_BIT)),
    Recording("autoregressive", coloured("ar1")),
    Recording("moving-average", coloured("average")),
    Recording("one-over-f", coloured("1/f")),
    Recording("random-walk", coloured("walk")),
    Recording("hum", coloured("hum")),
    Recording("spikes", set_to(outliers=0.0025)),
    Recording("one-bad-reading", set_to(one_reading=-36e3)),
    Recording("creep-fast", set_to(creep=either(1e-4))),
    Recording("creep-slow", set_to(creep=either(2e-6), position=1e-5)),
    Recording("ambient-rises", set_to(ambient_rise=5.0)),
    Recording("interpolated", set_to(readout=(10.0, "interpolated"))),
    Recording("held", set_to(readout=(10.0, "held"))),
    Recording("position-late", set_to(position_delay=0.02), "named", ("position_delay",)),
    Recording("uneven-clock", set_to(jitter=0.2, position_delay=0.02), "named", ("position_delay",)),
    Recording("position-filtered", set_to(position_low_pass=0.05), "named", ("position_delay", "position_averaging")),
    Recording("low-pass", low_pass, "named", ("sensor_lag", "record_delay")),
    Recording("gauge-offset", set_to(offset=(2e3, 0.0)), "named", ("sensor_offset",)),
    Recording("records-differ", set_to(delay=(0.0, 0.01), offset=(0.0, 500.0))),
    Recording("bore-41-for-40", set_to(bore=41 / 40), "not explained", (), False),
    Recording("scale-2-percent", set_to(scale=either(0.02, 1.0)), "not explained", (), False),
    Recording("geometry-twice", set_to(bore=either(0.01, 1.0), scale=either(0.01, 1.0), position_offset=either(1e-3)),
              "not explained", (), False),
    Recording("within-tolerance", within_tolerance),
    Recording("ambient-10-k-wrong", set_to(ambient_stated=either(10.0), ambient_column=False), judges_lambda0=False),
    Recording("wall-warm", set_bench(warm_wall=10.0), "named", ("warm_wall",)),
    Recording("real-air", set_bench(real_air=True), "adequate", ("temperature_dependent_heat_capacity",)),
    Recording("warm-start", set_bench(warm_start=5.0)),
    Recording("supply-leak", supply_leak, "named", ("supply_leakage",)),
    Recording("bar-as-pa", set_to(pressure_unit=1e-5), "refused", (), False),
    Recording("ms-as-s", set_to(time_unit=1e3), "refused", (), False),
    Recording("position-held", set_to(position_readout=(25.0, "held"))),
    Recording("position-interpolated", set_to(position_readout=(25.0, "interpolated"))),
    Recording("position-lost", set_to(position_lost=0.005)),
    Recording("position-bent", set_to(position_wave=lambda g: (5e-4, g.uniform(0, math.tau), g.uniform(0.5, 1.5) * math.tau))),
]


def filtered(signal, step, tau):
    """First-order low-pass of a signal that is linear between its samples and starts from rest."""
    if tau == 0.0:
        return signal
    kept = math.exp(-step / tau)
    slope = np.diff(signal, prepend=signal[0]) / step
    before = np.concatenate([signal[:1], signal[:-1]])
    driven = before * (1 - kept) + slope * (step - tau * (1 - kept))
    shown, _ = lfilter([1.0], [1.0, -kept], driven[1:], zi=[kept * signal[0]])
    return np.concatenate([signal[:1], shown])


def read_out(rows, signal, readout, rate):
    """A signal whose sensor is read out less often than the row rate."""
    if not readout:
        return signal
    every = round(rate / readout[0])
    read = np.arange(0, len(rows), every)
    return np.interp(rows, rows[read], signal[read]) if readout[1] == "interpolated" else np.repeat(signal[read], every)[: len(rows)]


def trace(chamber, logger, moves, pressure, end, rate, position_noise, g):
    """The rows of one file: time, pressure, position, ambient temperature."""
    grid = np.arange(0, end + 0.2, 5e-4)
    settled = moves[0][0] + moves[0][1]

    def position_at(at, t):
        x, v = at(t)
        return (x + logger.creep * (t - settled), v + logger.creep) if t > settled else (x, v)

    start = chamber.ambient_temperature + chamber.warm_start
    x0, chamber.ambient_rate = moves[0][2], logger.ambient_rise / end
    mass = pressure * chamber.volume(x0) / (chamber.gas_constant * start)
    y, scale = chamber.at_rest(pressure, mass, start)
    column = 4 if chamber.value("sensor_lag", "time_constant_s") else 0
    shown, positions = np.empty(len(grid)), np.empty(len(grid))
    for begin, finish, at in rigs.stroke(moves):
        finish = min(finish, grid[-1] + 1e-6)
        if finish <= begin:
            continue
        # Not across the corner where the creep begins: integration intervals end there.
        run = solve_ivp(
            lambda t, y, at=at: chamber.rates_at(t, y, *position_at(at, t)), (begin, finish), y, "LSODA", rtol=1e-9, atol=1e-11 * scale,
            dense_output=True, max_step=(finish - begin) / 4,
        )
        assert run.success, run.message
        y = run.y[:, -1]
        inside = np.flatnonzero((grid >= begin) & (grid < finish))
        shown[inside] = run.sol(grid[inside])[column]
        positions[inside] = [position_at(at, t)[0] for t in grid[inside]]
    rows = np.arange(0, end, 1 / rate)
    read = rows
    if logger.jitter:
        read = np.maximum(rows + np.clip(logger.jitter * g.normal(size=len(rows)), -0.45, 0.45) / rate, 0)
    delay = logger.delay[0] + logger.delay[1] * g.normal() + chamber.value("record_delay", "delay_s")
    seen = np.interp(read - delay, grid, filtered(shown, grid[1], logger.low_pass))
    seen += chamber.value("sensor_drift", "rate_pa_per_s") * rows + logger.offset[0] + logger.offset[1] * g.normal()
    seen += g.normal(0, logger.noise, len(rows))
    if logger.coloured:
        seen += logger.coloured(len(rows), rate, g)
    seen = np.round(seen / logger.step) * logger.step
    bad = g.uniform(size=len(rows)) < logger.outliers
    seen[bad] += g.choice([-1, 1], bad.sum()) * g.uniform(4e3, 2e4, bad.sum())
    seen = read_out(rows, seen, logger.readout, rate)
    where = np.interp(read - logger.position_delay, grid, filtered(positions, grid[1], logger.position_low_pass))
    if logger.position_wave:
        share, begin, turn = logger.position_wave
        low, high = logger.travel
        where = where + share * (high - low) * np.sin(begin + turn * (where - low) / (high - low))
    where = where * logger.scale + logger.position_offset + g.normal(0, position_noise, len(rows))
    where = read_out(rows, where, logger.position_readout, rate)
    if logger.position_lost:
        lost = g.uniform(size=len(rows)) < logger.position_lost
        where[lost] = np.where(g.uniform(size=lost.sum()) < 0.5, 0.0, where[lost] + g.uniform(1e-3, 2e-2, lost.sum()))
    ambient = chamber.ambient_temperature + chamber.ambient_rate * rows + g.normal(0, 0.02, len(rows))
    return rows * logger.time_unit, seen * logger.pressure_unit, where, ambient


def save(path, rows, logger):
    columns = ["time_s", "pressure_pa", "position_m"] + ["ambient_temperature_k"] * logger.ambient_column
    digits = ["%.4f", "%.7g" if logger.pressure_unit != 1.0 else "%.2f", "%.7f", "%.2f"]
    table = np.column_stack(rows[: len(columns)])
    np.savetxt(path, table, fmt=digits[: len(columns)], delimiter=",", header=",".join(columns), comments="")


def write(folder, recording, number, truth="none"):
    """Writes a rig recorded in this way and returns the truth."""
    r = rigs.rig(number, truth)
    g = r["generator"]
    fields = {f.name: getattr(r["chamber"], f.name) for f in dataclasses.fields(reference.Chamber)}
    chamber, logger = Bench(**fields), Logger(noise=sized(60, 300)(g))
    recording.change(chamber, logger, g)
    position_noise = getattr(logger, "position", min(r["logger"]["position"], 5e-6))
    rate = 100
    ends = [x for _, ends, _, _ in r["tests"].values() for x in ends]
    logger.travel = (min(ends), max(ends))
    folder.mkdir(parents=True, exist_ok=True)
    lines = [
        f"[cylinder]\nbore_m = {chamber.bore * logger.bore:.6g}",
        f"[ambient]\ntemperature_k = {chamber.ambient_temperature + logger.ambient_stated:.2f}\npressure_pa = {chamber.ambient_pressure}",
        '[gas]\nname = "air"',
    ]
    for title, (pressure, (start, end), push, hold) in r["tests"].items():
        traces = []
        for repeat in range(3):
            traces.append(f"{title}-{repeat + 1}.csv")
            length = push * g.uniform(0.9, 1.1)
            move = (0.3 + g.uniform(0, 0.01), length, start, end, r["shape"])
            rows = trace(chamber, logger, [move], pressure * g.normal(1, 0.002), 0.3 + length + hold, rate, position_noise, g)
            if logger.one_reading is not None and len(lines) == 3 and repeat == 0:
                rows[1][2 * len(rows[1]) // 3] = logger.one_reading
            save(folder / traces[-1], rows, logger)
        lines.append(f'[[experiment]]\nname = "{title}"\ntraces = {json.dumps(traces)}')
    (folder / "rig.toml").write_text("\n".join(lines) + "\n")
    answer = dict(recording=recording.name, effect=truth, strength=r["strength"], lambda0_w_per_m2_k=r["chamber"].lambda0)
    (folder / "answer.json").write_text(json.dumps(answer, indent=1))
    return answer


def judge(recording, effect, found):
    """Rates an answer (None: refused) for the recording: right, wrong name, missed or refused."""
    if found is None:
        return "right" if recording.expected == "refused" else "refused"
    verdict, named = found["verdict"], set(found["effects"])
    own = {effect} - {"none"}
    wrong = named - own - set(recording.names) - {"empirical"}
    if recording.expected == "not explained" and not own:
        return "wrong name" if wrong and verdict == "explained" else "right"
    if wrong:
        return "wrong name"
    if recording.expected == "refused" or not own <= named:
        return "missed"
    if recording.expected == "named":
        return "right" if named & set(recording.names) else "missed"
    clean = verdict == "adequate" or bool(named - {"empirical"})
    return "right" if clean else "missed"


def diagnosed(program, folder, recording, answer):
    """Diagnoses a recording: returns a row of the table."""
    begun = time.perf_counter()
    command = [program, "diagnose", folder / "rig.toml", "--json", folder / "diagnosis.json"]
    run = subprocess.run(command, capture_output=True, text=True)
    row = {"recording": recording.name, "effect": answer["effect"], "s": f"{time.perf_counter() - begun:.1f}"}
    if run.returncode:
        return row | {"outcome": judge(recording, answer["effect"], None), "verdict": "refused: " + run.stderr.strip()}
    found = json.loads((folder / "diagnosis.json").read_text())
    row |= {"outcome": judge(recording, answer["effect"], found), "verdict": found["verdict"], "named": " + ".join(found["effects"])}
    lambda0, truth = found["after"]["parameters"]["lambda0_w_per_m2_k"], answer["lambda0_w_per_m2_k"]
    row["lambda0 off, %"] = f"{100 * (lambda0['value'] / truth - 1):+.2f}"
    if recording.judges_lambda0 and row["outcome"] == "right":
        row["in interval"] = "yes" if lambda0["ci95"][0] <= truth <= lambda0["ci95"][1] else "no"
    return row


COLUMNS = ["rig", "recording", "effect", "outcome", "verdict", "named", "lambda0 off, %", "in interval", "s"]
EFFECTS = ["leakage", "wall_heating", "pressure_exponent", "gas_zones", "tube_volume"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--rigs", type=int, default=2)
    parser.add_argument("--only", default="")
    parser.add_argument("--effects", choices=["none", "one"], default="none")
    parser.add_argument("--program", default="target/release/pneutherm")
    parser.add_argument("--table", type=pathlib.Path, help="write the rows to this page")
    options = parser.parse_args()
    only = [name for name in options.only.split(",") if name]
    rows = []
    for place, recording in enumerate(RECORDINGS):
        if only and recording.name not in only:
            continue
        for number in range(options.rigs):
            effects = ["none"] + [EFFECTS[(place + number) % len(EFFECTS)]] * (options.effects == "one")
            for effect in effects:
                folder = options.folder / f"{recording.name}-{number}-{effect}"
                answer = write(folder, recording, number, effect)
                rows.append({"rig": number} | diagnosed(options.program, folder, recording, answer))
                print(" ".join(f"{key}={value}" for key, value in rows[-1].items()), flush=True)
    outcomes = [row["outcome"] for row in rows]
    print({outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))})
    if options.table:
        lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
        lines += ["| " + " | ".join(str(row.get(name, "")) for name in COLUMNS) + " |" for row in rows]
        options.table.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
