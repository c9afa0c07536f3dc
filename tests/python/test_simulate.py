"""`pneutherm simulate` compared with an independent implementation of every effect, integrated by scipy."""

import csv

import numpy as np
import pytest

import reference
import rigs

EFFECTS = {
    "none": {},
    "leakage": {"leakage": {"conductance_m3_per_s_pa": 3e-11}},
    "wall_heating": {"wall_heating": {"capacity_j_per_k": 0.5, "outer_conductance_w_per_k": 0.05}},
    "pressure_exponent": {"pressure_exponent": {"pressure_exponent": 0.25, "temperature_exponent": 0.9}},
    "natural_convection": {"natural_convection": {"exponent": 0.25}},
    "forced_convection": {"forced_convection": {"coefficient": 4.0}},
    "decaying_turbulence": {"decaying_turbulence": {"coefficient_s_per_m": 3.0, "decay_time_s": 0.2}},
    "gas_column_length": {"gas_column_length": {"exponent": -0.5, "reference_length_m": 0.07}},
    "gas_zones": {"gas_zones": {"mass_fraction": 0.25, "conductance_w_per_k": 0.03}},
    "tube_volume": {"tube_volume": {"volume_m3": 3e-6}},
    "sensor_lag": {"sensor_lag": {"time_constant_s": 0.02}},
    "record_delay": {"record_delay": {"delay_s": 0.013}},
    "sensor_drift": {"sensor_drift": {"rate_pa_per_s": -250.0}},
    "dead_volume_surface": {"dead_volume_surface": {"extra_area_m2": 2e-3}},
    "less_surface_than_the_bore_s": {"dead_volume_surface": {"extra_area_m2": -4e-4}},
    "warm_wall": {"warm_wall": {"temperature_difference_k": 12.0}},
    "temperature_dependent_heat_capacity": {"temperature_dependent_heat_capacity": {"slope_1_per_k": 1.2e-3}},
    "bent_heat_capacity": {"temperature_dependent_heat_capacity": {"slope_1_per_k": 6e-5, "curvature_1_per_k2": 3e-6}},
    "falling_heat_capacity": {"temperature_dependent_heat_capacity": {"slope_1_per_k": -4e-4}},
    "laminar_leakage": {"laminar_leakage": {"conductance_m3_per_s_pa": 3e-11}},
    "supply_leakage": {"supply_leakage": {"conductance_m3_per_s_pa": 3e-11, "supply_pressure_pa": 2.2e5, "critical_pressure_ratio": 0.2}},
    "sensor_offset": {"sensor_offset": {"offset_pa": 2100.0}},
    "position_delay": {"position_delay": {"delay_s": 0.0137}},
    "position_filter": {"position_delay": {"delay_s": 0.0137, "filter_time_constant_s": 0.02}},
    "a_filtered_average": {"position_delay": {"filter_time_constant_s": 0.03}, "position_averaging": {"window_s": 0.06}},
    "position_averaging": {"position_averaging": {"window_s": 0.046}},
    "a_late_average": {"position_delay": {"delay_s": 0.023}, "position_averaging": {"window_s": 0.06}},
    "wall_conduction": {"wall_conduction": {"inverse_effusivity_m2_k_per_w_s05": 3e-3}},
    "a_wall_that_remembers": {
        "wall_conduction": {"inverse_effusivity_m2_k_per_w_s05": 1e-2},
        "wall_heating": {"capacity_j_per_k": 0.5, "outer_conductance_w_per_k": 0.05},
        "warm_wall": {"temperature_difference_k": 5.0},
        "natural_convection": {"exponent": 0.25},
        "gas_zones": {"mass_fraction": 0.25, "conductance_w_per_k": 0.03},
        "leakage": {"conductance_m3_per_s_pa": 3e-11},
    },
    "a_warm_heavy_wall": {
        "warm_wall": {"temperature_difference_k": -8.0},
        "wall_heating": {"capacity_j_per_k": 0.5, "outer_conductance_w_per_k": 0.05},
        "natural_convection": {"exponent": 0.25},
    },
    "real_gas_that_leaks": {
        "temperature_dependent_heat_capacity": {"slope_1_per_k": 1.2e-3},
        "leakage": {"conductance_m3_per_s_pa": 3e-11},
        "laminar_leakage": {"conductance_m3_per_s_pa": 2e-11},
        "sensor_lag": {"time_constant_s": 0.02},
    },
    "heat_over_power": {"empirical": {"balance": "heat_flow", "variable": "piston_power", "knots": [-20.0, -0.5, 0.0, 3.0], "values": [1.0, 0.1, 0.0, 0.2]}},
    "heat_over_temperature": {"empirical": {"balance": "heat_flow", "variable": "temperature", "knots": [293.0, 310.0, 420.0], "values": [0.0, -0.05, -0.4]}},
    "flow_over_pressure": {"empirical": {"balance": "mass_flow", "variable": "pressure", "knots": [1e5, 1.6e5, 3e5], "values": [1e-7, 0.0, -8e-7]}},
    "flow_over_mass": {"empirical": {"balance": "mass_flow", "variable": "mass", "knots": [0.0, 1e-3], "values": [0.0, 3e-6]}},
    "coefficient_over_difference": {
        "empirical": {"balance": "coefficient_share", "variable": "temperature_difference", "knots": [-1.0, 1.0, 40.0], "values": [0.4, 0.0, -0.2]}
    },
    "coefficient_over_velocity": {"empirical": {"balance": "coefficient_share", "variable": "velocity", "knots": [-0.4, 0.0, 0.4], "values": [2.0, 0.0, 1.0]}},
    "coefficient_over_position": {"empirical": {"balance": "coefficient_share", "variable": "position", "knots": [0.05, 0.07, 0.1], "values": [0.5, 0.1, -0.2]}},
    "volume_over_pressure": {"empirical": {"balance": "volume_share", "variable": "pressure", "knots": [1e5, 2e5, 6e5], "values": [0.0, 0.01, 0.03]}},
    "volume_over_position": {"empirical": {"balance": "volume_share", "variable": "position", "knots": [0.04, 0.08, 0.1], "values": [0.03, 0.0, -0.01]}},
    "reading_over_pressure": {
        "empirical": {"balance": "reading", "variable": "pressure", "knots": [1e5, 2e5, 6e5], "values": [0.0, 500.0, 9000.0]},
        "record_delay": {"delay_s": 0.013},
        "sensor_drift": {"rate_pa_per_s": -250.0},
    },
    "several": {
        "leakage": {"conductance_m3_per_s_pa": 3e-11},
        "wall_heating": {"capacity_j_per_k": 0.5, "outer_conductance_w_per_k": 0.05},
        "gas_zones": {"mass_fraction": 0.25, "conductance_w_per_k": 0.03},
        "tube_volume": {"volume_m3": 3e-6},
        "sensor_lag": {"time_constant_s": 0.02},
        "record_delay": {"delay_s": 0.013},
    },
}


def write_model(path, chamber):
    lines = [
        "[gas]",
        f"gas_constant_j_per_kg_k = {chamber.gas_constant}",
        f"heat_capacity_ratio = {chamber.gamma}",
        "[chamber]",
        f"bore_m = {chamber.bore}",
        f"rod_m = {chamber.rod}",
        f"dead_volume_m3 = {chamber.dead_volume}",
        f'area_law = "{chamber.area_law}"',
        "[heat_transfer]",
        f"coefficient_w_per_m2_k = {chamber.lambda0}",
        f"reference_pressure_pa = {chamber.p0}",
        f"reference_temperature_k = {chamber.t0}",
        "[ambient]",
        f"temperature_k = {chamber.ambient_temperature}",
        f"pressure_pa = {chamber.ambient_pressure}",
    ]
    for effect, values in chamber.effects.items():
        lines.append(f"[effect.{effect}]")
        lines += [f"{key} = {value!r}" for key, value in values.items()]
    path.write_text("\n".join(lines) + "\n")


def stroke():
    """Push in 50 ms, hold, pull back slowly past the start, hold; 100 Hz."""
    times = np.round(np.arange(0, 2.001, 0.01), 3)
    positions = np.interp(times, [0, 0.1, 0.15, 0.9, 1.3], [0.1, 0.1, 0.05, 0.05, 0.12])
    return times, positions


@pytest.mark.parametrize("area_law", ["total", "swept"])
@pytest.mark.parametrize("name", EFFECTS)
def test_each_effect_is_the_one_that_an_independent_implementation_gives(name, area_law, pneutherm, tmp_path):
    agree(reference.Chamber(effects=EFFECTS[name], area_law=area_law), pneutherm, tmp_path)


@pytest.mark.parametrize("area_law", ["total", "swept"])
def test_a_rod_side_is_the_one_that_an_independent_implementation_gives(area_law, pneutherm, tmp_path):
    agree(reference.Chamber(bore=0.032, rod=0.012, area_law=area_law), pneutherm, tmp_path)


def test_the_noise_of_recorded_positions_neither_warms_nor_cools_a_gas(pneutherm, tmp_path):
    chamber = reference.Chamber(effects={"forced_convection": {"coefficient": 3.0}})
    times = np.round(np.arange(0, 3.001, 0.005), 3)
    way = np.clip((times - 0.4) / 0.2, 0, 1)
    stroke = 0.1 - 0.05 * way**3 * (10 - 15 * way + 6 * way**2)
    noisy = stroke + np.random.default_rng(1).normal(0, 8e-6, len(times))

    def error(*options):
        recorded = simulated(chamber, pneutherm, tmp_path, times, noisy, options=options)["pressure_pa"]
        return np.sqrt(np.mean((recorded / planned - 1) ** 2))

    planned = simulated(chamber, pneutherm, tmp_path, times, stroke)["pressure_pa"]
    assert error() < 1.5e-4
    # Used as they are, the positions imply speeds of some mm/s, and 1.4 times their relative noise appears in the pressure.
    assert error("--raw-positions") > 5e-4


def simulated(chamber, pneutherm, tmp_path, times, positions, flows=None, options=()):
    """The program's output columns for a chamber that starts at 1.5 bar."""
    flows = np.zeros_like(times) if flows is None else flows
    write_model(tmp_path / "model.toml", chamber)
    with open(tmp_path / "motion.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "position_m", "mass_flow_kg_per_s"])
        writer.writerows(zip(times.tolist(), positions.tolist(), flows.tolist()))
    pneutherm("simulate", "model.toml", "--motion", "motion.csv", "--initial-pressure", "150000", "-o", "out.csv", *options, cwd=tmp_path)
    with open(tmp_path / "out.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(times)
    return {column: np.array([float(row[column]) for row in rows]) for column in rows[0]}


def agree(chamber, pneutherm, tmp_path):
    times, positions = stroke()
    flows = np.where((times > 1.5) & (times < 1.8), 2e-5, 0.0) - np.where(times > 1.9, 1e-5, 0.0)
    ours = simulated(chamber, pneutherm, tmp_path, times, positions, flows)
    expected = reference.simulate(chamber, times, positions, 150000.0, flows)
    for column, values in expected.items():
        np.testing.assert_allclose(ours[column], values, rtol=2e-7, err_msg=column)


def columns(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_a_predictive_band_covers_left_out_records_at_its_level(tmp_path, pneutherm):
    """Rigs from another simulator, each identified and then simulated along an unseen motion."""
    inside, rows = {0.95: 0, 0.5: 0}, 0
    for number in range(6):
        folder = tmp_path / str(number)
        rigs.write(folder, number, "none")
        rig = rigs.rig(number, "none")
        rig["generator"] = np.random.default_rng(number)
        rig["logger"]["position"] = 0.0  # The band uses the motion as given.
        _, (far, near), _, hold = rig["tests"]["compress-3bar"]
        moves = [(0.3, 0.4, far, near, "cosine"), (1.5, 0.3, near, (far + near) / 2, "quintic")]
        rigs.save(folder / "left_out.csv", rigs.trace(rig, moves, 2.5e5, 1.8 + hold))
        # The statements of these rigs are exact; with tolerances the band would cover all rigs consistent with them.
        exact = "[tolerance]\nbore_m = 1e-9\nposition_scale = 1e-9\nposition_offset_m = 1e-9\nambient_temperature_k = 1e-3\nheat_capacity_ratio = 1e-9\n"
        (folder / "rig.toml").write_text(exact + (folder / "rig.toml").read_text())
        pneutherm("identify", folder, "-o", folder / "model.toml")
        measured = columns(folder / "left_out.csv")["pressure_pa"]
        for level in inside:
            process = pneutherm("simulate", folder / "model.toml", "--motion", folder / "left_out.csv", "--samples", 64, "--level", level, "-o", folder / "band.csv")
            assert "64 draws of lambda0_w_per_m2_k, dead_volume_m3; the band of pressure_pa includes" in process.stderr
            band = columns(folder / "band.csv")
            inside[level] += np.count_nonzero((band["pressure_low_pa"] <= measured) & (measured <= band["pressure_high_pa"]))
            for name in ("gas_pressure_pa", "temperature_k", "mass_kg", "heat_flow_w"):
                quantity, _, unit = name.rpartition("_")
                low, high = band[f"{quantity}_low_{unit}"], band[f"{quantity}_high_{unit}"]
                assert (low <= high).all() and (high - low).max() > 0, name
        rows += len(measured)
    assert rows > 2000
    assert 0.93 < inside[0.95] / rows < 0.97 and 0.45 < inside[0.5] / rows < 0.55, (inside, rows)


def test_a_band_needs_a_model_that_knows_how_well_it_is_known(tmp_path, pneutherm, root):
    model, motion = root / "fuzz/corpus/model/paper.toml", root / "examples/cylinder/validation.csv"
    error = pneutherm("simulate", model, "--motion", motion, "--samples", 64, code=1).stderr
    assert "no band can be drawn: the model has no [uncertainty]" in error and error.count("\n") == 1
    pneutherm("simulate", model, "--motion", motion, "--samples", 3, code=2)
    pneutherm("simulate", model, "--motion", motion, "--level", 0.9, code=2)
    pneutherm("simulate", model, "--motion", motion, "--samples", 64, "--level", 1.0, code=2)
