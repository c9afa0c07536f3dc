"""The Python module, from its sources, with the program under test."""

import math
import sys

import pytest

from conftest import PROGRAM


@pytest.fixture
def module(root, monkeypatch):
    monkeypatch.syspath_prepend(str(root / "python"))
    monkeypatch.setenv("PNEUTHERM", str(PROGRAM))
    sys.modules.pop("pneutherm", None)
    import pneutherm

    return pneutherm


def test_identify_gives_each_parameter_with_its_interval_and_unit(module, root):
    fit = module.identify(root / "examples/cylinder")
    rows = {row["name"]: row for row in fit.parameters.to_pylist()}
    lambda0 = rows["lambda0_w_per_m2_k"]
    assert lambda0["ci95_low"] < lambda0["value"] < lambda0["ci95_high"] and "W" in lambda0["unit"]
    assert fit.experiments.num_rows == 5 and "time_constant_s" in fit.experiments.column_names
    assert fit.rmse_pa["fit"] > 0.0


def test_the_time_constant_method_is_another_method(module, root):
    assert module.identify(root / "examples/cylinder", method="time-constant").method == "time-constant"


def test_diagnose_and_simulate_agree_with_the_record_and_with_the_answer(module, root, tmp_path):
    model = tmp_path / "model.toml"
    diagnosis = module.diagnose(root / "examples/cylinder", model=model)
    assert diagnosis.verdict == "explained" and diagnosis.effects == ["leakage"] and diagnosis.balance == "mass"
    assert diagnosis.rmse_after_pa["held_out"] < 0.1 * diagnosis.rmse_before_pa["held_out"]
    assert diagnosis.candidates.num_rows >= 1
    record = root / "examples/cylinder/validation.csv"
    table = module.simulate(model, record)
    assert table.schema.field("pressure_pa").metadata == {b"unit": b"Pa"}
    assert table.schema.field("heat_flow_w").metadata == {b"unit": b"W"}
    measured = [float(line.split(",")[1]) for line in record.read_text().splitlines()[1:]]
    errors = [a - b for a, b in zip(table["pressure_pa"].to_pylist(), measured, strict=True)]
    assert math.sqrt(sum(e * e for e in errors) / len(errors)) < 1.3 * diagnosis.noise_pa


def test_an_initial_pressure_is_passed_on(module, root):
    model = root / "fuzz/corpus/model/paper.toml"
    motion = root / "examples/cylinder/validation.csv"
    table = module.simulate(model, motion, initial_pressure_pa=123456.0)
    assert table["gas_pressure_pa"][0].as_py() == pytest.approx(123456.0, rel=1e-9)


def test_sweep_gives_all_rows_with_units(module, root, tmp_path):
    (tmp_path / "model.toml").write_text((root / "fuzz/corpus/model/leaking.toml").read_text())
    (tmp_path / "study.toml").write_text((root / "fuzz/corpus/study/factorial.toml").read_text())
    table = module.sweep(tmp_path / "study.toml")
    assert table.num_rows == 6 and table["row"].to_pylist() == list(range(6))
    assert table.schema.field("pressure_final_pa").metadata[b"unit"] == b"Pa"


def test_what_is_wrong_is_raised_as_the_program_s_sentence(module, tmp_path):
    with pytest.raises(module.Error, match=r"absent\.toml: cannot be read"):
        module.simulate(tmp_path / "absent.toml", tmp_path / "absent.csv")
    with pytest.raises(TypeError):
        module.identify()
