"""Checks the table of `book/src/theory/apart.md` by simulation: how each effect changes the pressure of a push and hold."""

import csv
import io
import re

import numpy as np
import pytest

MODEL = """
[gas]
name = "air"
gas_constant_j_per_kg_k = 287.0
heat_capacity_ratio = 1.4

[chamber]
bore_m = 0.032
rod_m = 0.0
dead_volume_m3 = 1.3e-5
area_law = "total"

[heat_transfer]
coefficient_w_per_m2_k = 30.0
reference_pressure_pa = 5.65e5
reference_temperature_k = 293.0

[ambient]
temperature_k = 297.3
pressure_pa = 101300.0
"""

TIMES = np.arange(0.0, 9.0, 0.005)
# For each: first and last position, m; initial pressure, Pa. The move lasts from 0.5 to 0.6 s.
MOVES = {"compression": (0.15, 0.083, 3.2e5), "expansion": (0.083, 0.15, 5e5), "below ambient": (0.083, 0.15, 1.013e5)}

# Each effect with a size, and the sign of its contribution to the pressure in each move: halfway through the move, at its end,
# early and late in the hold. 0: negligible; ANY: not stated on the page.
ANY = None
LEAK = {"compression": (ANY, ANY, -1, -1), "expansion": (ANY, ANY, -1, -1), "below ambient": (ANY, ANY, 1, 1)}
SLOWER = {"compression": (ANY, ANY, 1, 1), "expansion": (ANY, ANY, -1, -1), "below ambient": (ANY, ANY, -1, ANY)}
RISING = {"compression": (ANY, ANY, 1, 1), "expansion": (ANY, ANY, 1, 1), "below ambient": (ANY, ANY, 1, 1)}
CONSTANT = {"compression": (1, 1, 1, 1), "expansion": (1, 1, 1, 1), "below ambient": (1, 1, 1, 1)}
LATE = {"compression": (-1, -1, 1, 0), "expansion": (1, 1, -1, 0), "below ambient": (1, 1, ANY, 0)}
EFFECTS = {
    "leakage": ({"conductance_m3_per_s_pa": 1e-12}, LEAK),
    "laminar_leakage": ({"conductance_m3_per_s_pa": 1e-12}, LEAK),
    "supply_leakage": ({"conductance_m3_per_s_pa": 1e-12, "supply_pressure_pa": 8e5}, RISING),
    "sensor_drift": ({"rate_pa_per_s": 300.0}, RISING),
    "wall_heating": ({"capacity_j_per_k": 3.0}, {**SLOWER, "below ambient": (ANY, ANY, -1, -1)}),
    "wall_conduction": ({"inverse_effusivity_m2_k_per_w_s05": 0.002}, SLOWER),
    "natural_convection": (
        {"exponent": 0.25},
        {"compression": (ANY, -1, -1, 1), "expansion": (ANY, 1, 1, -1), "below ambient": (ANY, 1, ANY, ANY)},
    ),
    "forced_convection": (
        {"coefficient": 2.0},
        {"compression": (-1, -1, -1, 0), "expansion": (1, 1, 1, 0), "below ambient": (1, 1, ANY, 0)},
    ),
    "decaying_turbulence": (
        {"coefficient_s_per_m": 2.0, "decay_time_s": 0.3},
        {"compression": (ANY, -1, -1, ANY), "expansion": (ANY, 1, 1, ANY), "below ambient": (ANY, 1, ANY, ANY)},
    ),
    "gas_zones": ({"mass_fraction": 0.3, "conductance_w_per_k": 0.05}, SLOWER),
    "tube_volume": ({"volume_m3": 2e-6}, {"compression": (-1, -1, -1, -1), "expansion": (1, 1, 1, 1), "below ambient": (1, 1, 1, 1)}),
    "dead_volume_surface": (
        {"extra_area_m2": 0.003},
        {"compression": (ANY, -1, -1, ANY), "expansion": (ANY, 1, 1, ANY), "below ambient": (ANY, 1, ANY, 0)},
    ),
    "warm_wall": (
        {"temperature_difference_k": 10.0},
        {"compression": (ANY, ANY, -1, ANY), "expansion": (ANY, ANY, 1, ANY), "below ambient": (ANY, ANY, ANY, 0)},
    ),
    "temperature_dependent_heat_capacity": (
        {"slope_1_per_k": 1e-3},
        {"compression": (-1, -1, ANY, 0), "expansion": (-1, -1, ANY, 0), "below ambient": (-1, -1, ANY, 0)},
    ),
    "sensor_offset": ({"offset_pa": 2000.0}, CONSTANT),
    "sensor_lag": ({"time_constant_s": 0.05}, LATE),
    "record_delay": ({"delay_s": 0.02}, LATE),
    "position_delay": (
        {"delay_s": 0.02},
        {"compression": (1, -1, -1, 0), "expansion": (-1, 1, 1, 0), "below ambient": (-1, ANY, ANY, 0)},
    ),
    "position_averaging": (
        {"window_s": 0.04},
        {"compression": (ANY, 1, 0, 0), "expansion": (ANY, -1, 0, 0), "below ambient": (ANY, -1, 0, 0)},
    ),
}
# These two change the dependence of the time constant on pressure and length, not the shape of a single relaxation.
EFFECTS_OF_SEVERAL_TESTS = {"pressure_exponent": {"pressure_exponent": 0.7}, "gas_column_length": {"exponent": -0.5}}


@pytest.fixture(scope="module")
def simulated(pneutherm, tmp_path_factory):
    """Simulates a move with an effect, and caches the results."""
    folder = tmp_path_factory.mktemp("effects")
    known = {}

    def simulate(move, effect=None, parameters=None, final=None, ambient=297.3):
        key = (move, effect, final, ambient)
        if key not in known:
            first, last, pressure = MOVES[move]
            share = np.clip((TIMES - 0.5) / 0.1, 0, 1)
            stroke = first + ((final or last) - first) * share**2 * (3 - 2 * share)
            table = "" if effect is None else f"[effect.{effect}]\n" + "".join(f"{k} = {v!r}\n" for k, v in parameters.items())
            (folder / "model.toml").write_text(MODEL.replace("297.3", repr(ambient)) + table)
            rows = "".join(f"{t!r},{x!r}\n" for t, x in zip(TIMES.tolist(), stroke.tolist()))
            (folder / "motion.csv").write_text("time_s,position_m\n" + rows)
            out = pneutherm("simulate", "model.toml", "--motion", "motion.csv", "--initial-pressure", pressure, cwd=folder).stdout
            known[key] = np.array([float(row["pressure_pa"]) for row in csv.DictReader(io.StringIO(out))])
        return known[key]

    return simulate


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_changes_the_pressure_as_the_page_says(simulated, effect):
    parameters, expected = EFFECTS[effect]
    for move, signs in expected.items():
        paper, found = simulated(move), simulated(move, effect, parameters)
        # Threshold of a significant change: a five-hundredth of the relaxation.
        peak = paper[120:].max() - paper[-1] if move == "compression" else paper[-1] - paper[120:].min()
        least = peak / 500
        for time, sign in zip((0.55, 0.6, 1.3, 4.5), signs):
            added = (found - paper)[np.searchsorted(TIMES, time)]
            seen = 0 if abs(added) < least else np.sign(added)
            assert sign is ANY or seen == sign, f"{move}, {time} s: {added:+.0f} Pa of {peak:.0f} Pa"


def test_a_warm_wall_acts_like_an_error_of_the_ambient_temperature(simulated):
    for move in MOVES:
        warm = simulated(move, "warm_wall", EFFECTS["warm_wall"][0])
        assert warm == pytest.approx(simulated(move, ambient=307.3), rel=1e-7)


def time_constant(pressure):
    """Time, from just after the move, in which 1 - Pf/P falls to 1/e."""
    hold, times = pressure[124:], TIMES[124:]
    share = np.abs(1 - hold[-1] / hold)
    return np.interp(1 / np.e, (share / share[0])[::-1], times[::-1]) - times[0]


def test_a_pressure_exponent_and_the_column_s_length_change_how_the_time_constant_varies(simulated):
    compression, below = "compression", "below ambient"

    def ratio_of_levels(*effect):
        return time_constant(simulated(compression, *effect)) / time_constant(simulated(below, *effect))

    def ratio_of_lengths(*effect):
        return time_constant(simulated(compression, *effect)) / time_constant(simulated(compression, *effect, final=0.11))

    paper, exponent = ratio_of_levels(), ratio_of_levels("pressure_exponent", EFFECTS_OF_SEVERAL_TESTS["pressure_exponent"])
    assert exponent < 0.9 * paper
    length = ratio_of_lengths("gas_column_length", EFFECTS_OF_SEVERAL_TESTS["gas_column_length"])
    assert length < 0.95 * ratio_of_lengths()


def test_the_table_has_every_effect(root):
    page = (root / "book/src/theory/apart.md").read_text()
    rows = re.findall(r"^\| `(\w+)`", page, flags=re.M)
    effects = re.findall(r"^## (\w+)$", (root / "book/src/reference/effects.md").read_text(), flags=re.M)
    # An empirical term may have any shape.
    named = sorted(effect for effect in effects if effect != "empirical")
    assert sorted(rows) == named == sorted([*EFFECTS, *EFFECTS_OF_SEVERAL_TESTS])
