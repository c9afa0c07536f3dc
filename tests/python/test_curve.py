"""If no named effect fits: a curve read off the records, in the model, the FMU and a study, on motions not used for it."""

import json
import tomllib

import numpy as np
import pyarrow.parquet as pq
import pytest

import reference
import rigs
import test_whole_loop as loop

STUDY = """
[study]
name = "curve"
model = "model.toml"
design = "factorial"
fit = false
[test]
initial_pressure_pa = 2.5e5
initial_stroke_m = 0.1
push_time_s = 0.2
duration_s = 4.0
[vary]
final_stroke_m = { values = [0.05, 0.07] }
"""


def unknown_heat():
    """A cylinder whose friction heats the gas with a twentieth of the piston's work, in both directions."""
    values = dict(bore=0.025, dead_volume=6e-6, lambda0=35.0, ambient_temperature=loop.AMBIENT_K)
    chamber = rigs.Outside(**values)
    chamber.outside = ("friction heat", 0.05)
    return chamber


@pytest.fixture(scope="module")
def diagnosed(pneutherm, tmp_path_factory):
    """The folder of a rig with that heat, diagnosed, and the findings."""
    folder = tmp_path_factory.mktemp("curve")
    loop.write_rig(folder, unknown_heat(), np.random.default_rng(13))
    pneutherm("diagnose", "rig.toml", "-o", "model.toml", "--json", "found.json", "--report", "report.html", cwd=folder)
    return folder, json.loads((folder / "found.json").read_text())


def test_a_heat_that_no_effect_describes_becomes_a_curve_that_holds_it(diagnosed):
    folder, found = diagnosed
    assert (found["verdict"], found["effects"]) == ("improved", ["empirical"])
    curve = found["empirical"]
    assert curve["accepted"] and (curve["balance"], curve["variable_unit"]) == ("heat_flow", "W")
    knots, values = np.array(curve["knots"]), np.array(curve["values"])
    assert np.allclose(values, 0.05 * np.abs(knots), atol=0.1 * 0.05 * np.abs(knots).max())
    low, high = np.array(curve["ci95"]).T
    assert np.all(low < high)
    assert found["after"]["rmse_pa"]["held_out"] < 1.3 * loop.NOISE_PA < 0.5 * found["before"]["rmse_pa"]["held_out"]
    assert "The missing term as a curve" in (folder / "report.html").read_text()


def test_the_fmu_of_a_curve_leaves_noise_on_another_motion(diagnosed, pneutherm):
    folder, _ = diagnosed
    pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=folder)
    rows, measured, position = loop.record(unknown_heat(), *loop.VALIDATION, np.random.default_rng(14))
    shown = loop.run_fmu(str(folder / "Chamber.fmu"), rows, position, loop.VALIDATION[0])
    assert np.sqrt(np.mean((shown - measured) ** 2)) < 1.3 * loop.NOISE_PA


def test_a_study_of_a_curve_has_the_pressures_of_an_independent_implementation(diagnosed, pneutherm):
    folder, _ = diagnosed
    (folder / "study.toml").write_text(STUDY)
    pneutherm("sweep", "study.toml", "-o", "out", cwd=folder)
    model = tomllib.loads((folder / "model.toml").read_text())
    chamber = reference.Chamber(
        bore=model["chamber"]["bore_m"],
        dead_volume=model["chamber"]["dead_volume_m3"],
        lambda0=model["heat_transfer"]["coefficient_w_per_m2_k"],
        ambient_temperature=model["ambient"]["temperature_k"],
        ambient_pressure=model["ambient"]["pressure_pa"],
        effects=model["effect"],
    )
    for row in pq.read_table(folder / "out" / "rows").to_pylist():
        truth = reference.simulate(chamber, [0.0, 0.2, 4.0], [0.1, row["final_stroke_m"], row["final_stroke_m"]], 2.5e5)
        peak, final = truth["pressure_pa"][1:]
        assert row["pressure_peak_pa"] == pytest.approx(peak, rel=2e-7)
        assert row["pressure_final_pa"] == pytest.approx(final, rel=2e-7)


@pytest.mark.parametrize(
    "line, problem",
    [
        ('"effect.empirical.knots[1]" = { values = [1.0] }', "is a fixed part of the model's table"),
        ('"effect.empirical.values[9]" = { values = [1.0] }', "did you mean"),
        ('"effect.empirical.values[8]" = { values = [1.0] }', "is beyond the entries of the model's table"),
    ],
)
def test_what_a_curve_is_of_is_not_varied(line, problem, diagnosed, pneutherm):
    folder, _ = diagnosed
    (folder / "faulty.toml").write_text(STUDY + line + "\n")
    refused = pneutherm("sweep", "faulty.toml", "-o", "faulty", cwd=folder, code=1).stderr
    assert problem in refused and len(refused.strip().splitlines()) == 1


def test_a_share_of_the_volume_is_refused_by_the_fmu(pneutherm, tmp_path):
    (tmp_path / "model.toml").write_text(
        "[chamber]\nbore_m = 0.02\n[heat_transfer]\ncoefficient_w_per_m2_k = 30.0\n[effect.empirical]\n"
        'balance = "volume_share"\nvariable = "pressure"\nknots = [1e5, 5e5]\nvalues = [0.0, 0.01]\n'
    )
    refused = pneutherm("fmu", "model.toml", "-o", "Chamber.fmu", cwd=tmp_path, code=1).stderr
    assert "a share of the volume" in refused and not (tmp_path / "Chamber.fmu").exists()
