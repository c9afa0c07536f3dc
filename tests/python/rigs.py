"""Random rigs from a simulator that shares no code with the program: `reference.Chamber` integrated by scipy.

    python tests/python/rigs.py FOLDER FROM TO [--program target/release/pneutherm]

writes rigs FROM..TO-1 into FOLDER (rig.toml, traces, validation.csv and answer.json each), diagnoses each and prints a
table of truth against verdict. A rig depends on its number alone.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess
import time

import numpy as np
from scipy.integrate import solve_ivp

import reference

SHAPES = {
    "quintic": lambda u: (u**3 * (10 - 15 * u + 6 * u * u), 30 * u * u * (1 - u) ** 2),
    "cosine": lambda u: ((1 - math.cos(math.pi * u)) / 2, math.pi / 2 * math.sin(math.pi * u)),
    "cubic": lambda u: (u * u * (3 - 2 * u), 6 * u * (1 - u)),
    "ramp": lambda u: (u, 1.0),
}


class Outside(reference.Chamber):
    """A chamber with something outside the list of effects."""

    def rates(self, y, x, v, mdot):
        rates, heat = super().rates(y, x, v, mdot)
        p, m = y[0], y[1]
        volume = self.volume(x)
        t = p * volume / (m * self.gas_constant)
        kind, size = self.outside
        area, ambient = self.heat_area(x), self.ambient_temperature
        power = 0.0
        if kind == "warm wall":
            power = self.coefficient(p, t, ambient, x, v) * area * size
        elif kind == "radiation":
            power = size * area * 5.67e-8 * 60 * (ambient**4 - t**4)
        elif kind == "friction heat":
            power = size * p * self.piston_area * abs(v)
        elif kind == "one-sided coefficient":
            power = size * self.coefficient(p, t, ambient, x, v) * area * max(ambient - t, 0.0)
        elif kind == "outgassing":
            flow = size * m
            rates[1] += flow
            rates[0] += self.gamma * self.gas_constant * flow * ambient / volume
        rates[0] += (self.gamma - 1) * power / volume
        return rates, heat + power


OUTSIDE = {"warm wall": 2.5, "radiation": 0.03, "friction heat": 0.05, "one-sided coefficient": 0.3, "outgassing": 2e-4}


def stroke(moves):
    """Pieces (start, end, position and speed at t) of a stroke, from moves (start, length, from, to, shape)."""
    pieces, time_s = [], 0.0
    for begin, length, start, end, shape in moves:
        pieces.append((time_s, begin, lambda t, x=start: (x, 0.0)))

        def moving(t, begin=begin, length=length, start=start, end=end, shape=SHAPES[shape]):
            way, rate = shape(min(max((t - begin) / length, 0.0), 1.0))
            return start + (end - start) * way, (end - start) * rate / length

        pieces.append((begin, begin + length, moving))
        time_s = begin + length
    pieces.append((time_s, math.inf, lambda t, x=moves[-1][3]: (x, 0.0)))
    return pieces


def readings(chamber, moves, pressure, rows):
    """Noise-free sensor readings at the rows, and the positions there."""
    ambient = chamber.ambient_temperature
    first = moves[0][2]
    mass = pressure * chamber.volume(first) / (chamber.gas_constant * ambient)
    y, scale = chamber.at_rest(pressure, mass, ambient)
    delay = chamber.value("record_delay", "delay_s")
    column = 4 if chamber.value("sensor_lag", "time_constant_s") else 0
    earlier = rows - delay
    shown, positions = np.full(len(rows), pressure), np.full(len(rows), first)
    for begin, end, at in stroke(moves):
        end = min(end, rows[-1] + 1e-6)
        if end <= begin:
            continue
        run = solve_ivp(
            lambda t, y: chamber.rates(y, *at(t), 0.0)[0], (begin, end), y, "DOP853", rtol=1e-9, atol=1e-11 * scale, dense_output=True,
            max_step=(end - begin) / 4,
        )
        assert run.success, run.message
        y = run.y[:, -1]
        for i in np.flatnonzero((earlier >= begin) & (earlier < end)):
            shown[i] = run.sol(earlier[i])[column]
        for i in np.flatnonzero((rows >= begin) & (rows < end)):
            positions[i] = at(rows[i])[0]
    return shown + chamber.value("sensor_drift", "rate_pa_per_s") * rows, positions


def effects(generator, chamber, shortest, strength):
    """Every effect of the list, with a size that a rig of this geometry can show."""
    volume = chamber.volume(shortest)
    capacity = 3e5 * volume / (chamber.gas_constant * 295) * chamber.gas_constant / (chamber.gamma - 1)
    conductance = chamber.coefficient(3e5, 295, 295, shortest, 0) * chamber.heat_area(shortest)
    relaxation = capacity / conductance
    either = generator.choice([-1, 1])
    return {
        "none": {},
        "leakage": {"conductance_m3_per_s_pa": 2e-2 * strength * volume / 1e5 / relaxation,
                    "critical_pressure_ratio": generator.choice([0.3, generator.uniform(0.1, 0.5)])},
        "wall_heating": {"capacity_j_per_k": 8 * capacity / strength,
                         "outer_conductance_w_per_k": conductance * generator.uniform(0.05, 1.0)},
        "pressure_exponent": {"pressure_exponent": 0.5 + either * 0.2 * min(strength, 2)},
        "natural_convection": {"exponent": 0.25 * min(strength, 1.3)},
        "forced_convection": {"coefficient": 2.5 * strength},
        "gas_column_length": {"exponent": -0.5 * strength},
        "gas_zones": {"mass_fraction": min(0.2 * strength, 0.6), "conductance_w_per_k": conductance * generator.uniform(0.1, 1)},
        "tube_volume": {"volume_m3": 0.06 * strength * volume},
        "sensor_lag": {"time_constant_s": 0.015 * strength},
        "record_delay": {"delay_s": 0.015 * strength},
        "sensor_drift": {"rate_pa_per_s": either * 200 * strength},
    }


def rig(number, truth=None):
    """The truth of a rig: chamber, name of its effect, experiments, logger."""
    g = np.random.default_rng(20261121 + number)
    bore = g.choice([0.012, 0.016, 0.02, 0.025, 0.032, 0.04, 0.05, 0.063])
    longest = float(np.exp(g.uniform(math.log(0.05), math.log(0.32))))
    shortest = longest * g.uniform(0.35, 0.65)
    swept = math.pi / 4 * bore**2 * shortest
    values = dict(
        bore=float(bore), dead_volume=swept * g.uniform(0.03, 0.5), lambda0=float(np.exp(g.uniform(math.log(12), math.log(60)))),
        ambient_temperature=g.uniform(288, 303), ambient_pressure=101300.0,
    )
    chamber = reference.Chamber(**values)
    names = list(effects(np.random.default_rng(0), chamber, shortest, 1.0)) + ["none", "outside"]
    name = truth or names[number % len(names)]
    strength = float(np.exp(g.uniform(math.log(0.3), math.log(2.0))))
    parameters = {}
    if name == "outside":
        kind = list(OUTSIDE)[number // len(names) % len(OUTSIDE)]
        chamber = Outside(**values)
        chamber.outside = (kind, OUTSIDE[kind] * strength)
        parameters = {kind: OUTSIDE[kind] * strength}
    elif name != "none":
        parameters = {k: float(v) for k, v in effects(g, chamber, shortest, strength)[name].items()}
        chamber.effects = {name: parameters}
    conductance = chamber.lambda0 * chamber.heat_area(shortest)
    relaxation = 3e5 * chamber.volume(shortest) / 295 / 0.4 / conductance
    shape = str(g.choice(["quintic", "quintic", "cosine", "cubic", "ramp"]))
    tests = {}
    for title, pressure, ends in [
        ("compress-ambient", 1.013e5, (longest, shortest)), ("compress-3bar", 3.2e5, (longest, shortest)),
        ("expand-5bar", 5e5, (shortest, longest)), ("expand-ambient", 1.013e5, (shortest, longest)),
        ("compress-part", 2e5, (longest, (longest + shortest) / 2)),
    ]:
        tests[title] = (pressure, ends, float(g.uniform(0.08, 0.5)), float(np.clip(g.uniform(4, 9) * relaxation, 1.5, 12)))
    logger = dict(
        noise=float(np.exp(g.uniform(math.log(60), math.log(350)))), step=float(g.choice([1e6 / 65536, 1e6 / 16384, 1.0])),
        position=float(np.exp(g.uniform(math.log(1e-6), math.log(8e-6)))), rate=float(g.choice([100, 100, 200])), repeats=int(g.integers(2, 4)),
    )
    return dict(chamber=chamber, truth=name, strength=strength, parameters=parameters, tests=tests, shape=shape, logger=logger, generator=g)


def trace(r, moves, pressure, end):
    """Noisy rows of one trace."""
    g, logger = r["generator"], r["logger"]
    rows = np.arange(0, end, 1 / logger["rate"])
    shown, position = readings(r["chamber"], moves, pressure, rows)
    shown = np.round((shown + g.normal(0, logger["noise"], len(rows))) / logger["step"]) * logger["step"]
    position = position + g.normal(0, logger["position"], len(rows))
    ambient = r["chamber"].ambient_temperature + g.normal(0, 0.02, len(rows))
    return rows, shown, position, ambient


def save(path, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "pressure_pa", "position_m", "ambient_temperature_k"])
        writer.writerows((f"{t:.4f}", f"{p:.1f}", f"{x:.6f}", f"{a:.2f}") for t, p, x, a in zip(*rows))


def write(folder, number, truth=None):
    """Writes a rig and returns its truth."""
    r = rig(number, truth)
    g, chamber = r["generator"], r["chamber"]
    folder.mkdir(parents=True, exist_ok=True)
    lines = [
        f"[cylinder]\nbore_m = {chamber.bore}\nrod_m = 0.0",
        f"[ambient]\ntemperature_k = {chamber.ambient_temperature:.1f}\npressure_pa = {chamber.ambient_pressure}",
        f'[gas]\nname = "air"\n[sensor]\nsample_rate_hz = {r["logger"]["rate"]}',
    ]
    for title, (pressure, (start, end), push, hold) in r["tests"].items():
        traces = []
        for repeat in range(r["logger"]["repeats"]):
            traces.append(f"{title}-{repeat + 1}.csv")
            length = push * g.uniform(0.9, 1.1)
            move = (0.3 + g.uniform(0, 0.01), length, start, end, r["shape"])
            save(folder / traces[-1], trace(r, [move], pressure * g.normal(1, 0.002), 0.3 + length + hold))
        lines.append(f'[[experiment]]\nname = "{title}"\ntraces = {json.dumps(traces)}')
    (folder / "rig.toml").write_text("\n".join(lines) + "\n")
    _, (far, near), push, hold = r["tests"]["compress-3bar"]
    middle = (far + near) / 2
    moves = [(0.3, 0.4, far, middle, "cosine"), (1.2, 0.2, middle, near, "quintic"), (2.5, 0.6, near, far, "cosine")]
    save(folder / "validation.csv", trace(r, moves, 2.5e5, 3.1 + hold))
    answer = dict(effect=r["truth"], strength=r["strength"], parameters=r["parameters"], lambda0_w_per_m2_k=chamber.lambda0,
                  dead_volume_m3=chamber.dead_volume, noise_pa=r["logger"]["noise"],
                  position_noise_m=r["logger"]["position"], shape=r["shape"])
    (folder / "answer.json").write_text(json.dumps(answer, indent=1))
    return answer


def diagnosed(program, folder, answer):
    """Diagnoses a rig: returns a row of the table with verdict and truth."""
    begun = time.perf_counter()
    command = [program, "diagnose", folder / "rig.toml", "--json", folder / "diagnosis.json", "-o", folder / "model.toml"]
    run = subprocess.run(command, capture_output=True, text=True)
    seconds = time.perf_counter() - begun
    row = {"effect": answer["effect"], "strength": f"{answer['strength']:.2f}", "move": answer["shape"]}
    if run.returncode:
        return row | {"right": "no", "verdict": "refused: " + run.stderr.strip(), "found": "", "s": f"{seconds:.1f}"}
    found = json.loads((folder / "diagnosis.json").read_text())
    named = found["effects"]
    right = {"none": found["verdict"] == "adequate", "outside": found["verdict"] in ("unexplained", "improved")}.get(answer["effect"], named == [answer["effect"]])
    if answer["effect"] == "outside":
        row["effect"] = next(iter(answer["parameters"])) + " (outside)"
    row |= {"right": "yes" if right else "no", "verdict": found["verdict"], "found": " + ".join(named)}
    row["not told apart"] = "; ".join(", ".join(group) for group in found["indistinguishable"])
    if found["verdict"] != "unexplained":
        simulated = folder / "simulated.csv"
        subprocess.run([program, "simulate", folder / "model.toml", "--motion", folder / "validation.csv", "-o", simulated], check=True)
        columns = [np.genfromtxt(path, delimiter=",", names=True)["pressure_pa"] for path in (simulated, folder / "validation.csv")]
        lambda0 = found["after"]["parameters"]["lambda0_w_per_m2_k"]
        truth = answer["lambda0_w_per_m2_k"]
        row["lambda0 off, %"] = f"{100 * (lambda0['value'] / truth - 1):+.2f}"
        row["in interval"] = "yes" if lambda0["ci95"][0] <= truth <= lambda0["ci95"][1] else "no"
        row["before / noise"] = f"{found['before']['rmse_pa']['held_out'] / found['noise_pa']:.2f}"
        row["held out / noise"] = f"{found['after']['rmse_pa']['held_out'] / found['noise_pa']:.3f}"
        row["validation / noise"] = f"{np.sqrt(np.mean((columns[0] - columns[1]) ** 2)) / found['noise_pa']:.3f}"
    return row | {"s": f"{seconds:.1f}"}


COLUMNS = ["rig", "effect", "strength", "move", "right", "verdict", "found", "not told apart", "lambda0 off, %", "in interval",
           "before / noise", "held out / noise", "validation / noise", "s"]


def page(rows, options):
    """The page with the table."""
    right = sum(row["right"] == "yes" for row in rows)
    judged = [row for row in rows if "in interval" in row]
    inside = sum(row["in interval"] == "yes" for row in judged)
    lines = [
        "# Rigs from another simulator", "",
        f"Written by `python tests/python/rigs.py FOLDER {options.first} {options.last} --table results/diagnosis_independent.md`: random rigs from a simulator",
        "that shares no code with the program (`tests/python/rigs.py`: scipy's DOP853 on pressure and mass), each with one effect, none, or one that is",
        "not in the list. Strength 1: sizes in `effects()` there. Errors are rms over the noise that the program found; *before* is the paper's model on",
        "held-out data, *validation* a motion that no experiment has, from the mean pressure before its first move.", "",
        f"**{right} of {len(rows)} right; the interval of λ0 holds the truth in {inside} of {len(judged)}.**", "",
        "| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS),
    ]
    lines += ["| " + " | ".join(str(row.get(name, "")) for name in COLUMNS) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--program", default="target/release/pneutherm")
    parser.add_argument("--table", type=pathlib.Path, help="write the rows to this page")
    options = parser.parse_args()
    rows = []
    for number in range(options.first, options.last):
        folder = options.folder / f"rig{number:03}"
        saved = folder / "answer.json"
        answer = json.loads(saved.read_text()) if saved.exists() else write(folder, number)
        rows.append({"rig": number} | diagnosed(options.program, folder, answer))
        print(" ".join(f"{key}={value}" for key, value in rows[-1].items()), flush=True)
    if options.table:
        options.table.write_text(page(rows, options))


if __name__ == "__main__":
    main()
