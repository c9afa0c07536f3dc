"""`diagnose` on rigs from a simulator that shares no code with it: the effect's name, and its model on an unseen motion."""

import csv
import json
import tomllib

import numpy as np
import pytest

import rigs

# Numbers of rigs: one without an effect, one for every balance and kind of sensor effect, some outside the list.
NUMBERS = [0, 1, 2, 5, 7, 8, 9, 10, 13, 17, 25, 41]


def column(path, name):
    with open(path, newline="") as file:
        return np.array([float(row[name]) for row in csv.DictReader(file)])


@pytest.mark.parametrize("number", NUMBERS)
def test_what_another_simulator_put_in_is_what_diagnose_finds(number, pneutherm, tmp_path):
    answer = rigs.write(tmp_path, number)
    pneutherm("diagnose", "rig.toml", "-o", "model.toml", "--json", "diagnosis.json", cwd=tmp_path)
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    effect = answer["effect"]
    if effect == "outside":
        # For the gas, an initially warmer wall is equivalent to the records' initial temperature.
        warm_wall = "warm wall" in answer["parameters"]
        assert found["verdict"] in ("unexplained", "improved") or (warm_wall and found["effects"] in ([], ["warm_wall"]))
        if found["verdict"] == "adequate":
            return
        assert found["balance"] != "none"
        return
    expected = ("adequate", []) if effect == "none" else ("explained", [effect])
    assert (found["verdict"], found["effects"]) == expected
    parameters = found["after"]["parameters"]
    assert parameters["lambda0_w_per_m2_k"]["value"] == pytest.approx(answer["lambda0_w_per_m2_k"], rel=0.01)
    assert found["after"]["rmse_pa"]["held_out"] < 1.1 * found["noise_pa"]

    pneutherm("simulate", "model.toml", "--motion", "validation.csv", "-o", "simulated.csv", cwd=tmp_path)
    measured, position = (column(tmp_path / "validation.csv", name) for name in ("pressure_pa", "position_m"))
    error = column(tmp_path / "simulated.csv", "pressure_pa") - measured
    # `simulate` starts from the mean of the rest; its error, noise/√rows, scales with the pressure: one draw, 2.5 sd.
    rest = int(np.argmax(np.abs(position - position[0]) > 1e-4))
    by_start = 2.5 * found["noise_pa"] / np.sqrt(rest) * measured / measured[:rest].mean()
    assert np.mean(error**2) < 1.1**2 * found["noise_pa"] ** 2 + np.mean(by_start**2)


@pytest.mark.parametrize("number", [0, 1])
def test_a_gas_that_is_stated_off_within_its_tolerance_is_found_and_goes_into_the_model(number, pneutherm, tmp_path):
    answer = rigs.write(tmp_path, number)
    rig = tmp_path / "rig.toml"
    stated = rig.read_text().replace('name = "air"', "gas_constant_j_per_kg_k = 287.0\nheat_capacity_ratio = 1.40168")
    rig.write_text(stated)
    diagnosed = pneutherm("diagnose", "rig.toml", "-o", "model.toml", "--json", "diagnosis.json", cwd=tmp_path)
    told = diagnosed.stdout + diagnosed.stderr
    assert "a heat capacity ratio of 1.40" in told and "instead of the 1.4017" in told
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    assert found["effects"] == ([] if answer["effect"] == "none" else [answer["effect"]])
    parameters = found["after"]["parameters"]
    assert parameters["lambda0_w_per_m2_k"]["value"] == pytest.approx(answer["lambda0_w_per_m2_k"], rel=0.01)
    ratio = tomllib.loads((tmp_path / "model.toml").read_text())["gas"]["heat_capacity_ratio"]
    assert ratio == pytest.approx(1.4, abs=2e-4)
    validated = pneutherm("validate", "model.toml", "rig.toml", cwd=tmp_path)
    assert "is it the model of this rig" not in validated.stdout + validated.stderr
