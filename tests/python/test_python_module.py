"""The Python package: the extension module in place of the program, tables without copies."""

import gc
import math
import os
import signal
import subprocess
import sys
import time

import pytest

from conftest import PROGRAM


@pytest.fixture(scope="module")
def module(package):
    sys.path.insert(0, str(package))
    import pneutherm

    yield pneutherm
    sys.path.remove(str(package))


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
    assert table.schema.field("pressure_pa").metadata [b"unit"] == b"Pa"
    assert table.schema.field("heat_flow_w").metadata [b"unit"] == b"W"
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


def test_what_is_wrong_is_raised_as_the_program_s_sentence(module, root, tmp_path):
    with pytest.raises(module.Error, match=r"absent\.toml: cannot be read"):
        module.simulate(tmp_path / "absent.toml", tmp_path / "absent.csv")
    with pytest.raises(module.Error, match="`exakt` is not known; known here: exact, time-constant"):
        module.identify(root / "examples/cylinder", method="exakt")
    with pytest.raises(module.Error, match="-1 Pa: a pressure in Pa, absolute and above zero"):
        module.simulate(
            root / "fuzz/corpus/model/paper.toml", root / "examples/cylinder/validation.csv", initial_pressure_pa=-1
        )
    with pytest.raises(TypeError):
        module.identify()


def test_a_table_s_numbers_lie_where_rust_wrote_them_and_outlive_the_result(module, root):
    import pyarrow

    arguments = [str(root / "fuzz/corpus/model/paper.toml"), str(root / "examples/cylinder/validation.csv")]
    result = module._native.simulate(*arguments, None, 2e5)
    one, two = pyarrow.table(result), pyarrow.table(result)
    place = lambda table: table["pressure_pa"].chunk(0).buffers()[1].address  # noqa: E731
    assert len(result) == one.num_rows and place(one) == place(two), "a copy was made"
    before = one["pressure_pa"].to_pylist()
    del result, two
    gc.collect()
    module.simulate(*arguments)
    assert one["pressure_pa"].to_pylist() == before


def test_other_libraries_take_the_result_as_it_is(module, root):
    polars = pytest.importorskip("polars")
    arguments = [str(root / "fuzz/corpus/model/paper.toml"), str(root / "examples/cylinder/validation.csv")]
    result = module._native.simulate(*arguments, None, 2e5)
    assert polars.DataFrame(result).columns[:2] == ["time_s", "pressure_pa"]


def test_the_module_and_the_program_give_the_same_rows(module, root, pneutherm, tmp_path):
    import pyarrow
    import pyarrow.csv
    import pyarrow.parquet

    (tmp_path / "model.toml").write_text((root / "fuzz/corpus/model/leaking.toml").read_text())
    (tmp_path / "study.toml").write_text((root / "fuzz/corpus/study/factorial.toml").read_text())
    pneutherm("sweep", tmp_path / "study.toml", "-o", tmp_path / "out")
    parts = [pyarrow.parquet.read_table(part) for part in sorted((tmp_path / "out/rows").glob("*.parquet"))]
    assert module.sweep(tmp_path / "study.toml").to_pylist() == pyarrow.concat_tables(parts).to_pylist()
    motion = root / "examples/cylinder/validation.csv"
    pneutherm("simulate", tmp_path / "model.toml", "--motion", motion, "-o", tmp_path / "out.csv")
    ours = module.simulate(tmp_path / "model.toml", motion)
    theirs = pyarrow.csv.read_csv(tmp_path / "out.csv")
    assert [[float(x) for x in column] for column in theirs.to_pydict().values()] == list(ours.to_pydict().values())


def test_the_program_runs_inside_python_as_it_does_outside(package, root, tmp_path):
    def run(*command):
        # The same width for both: the readline library sets COLUMNS where Python's own table of variables does not show it.
        environment = {**os.environ, "PYTHONPATH": str(package), "COLUMNS": "90"}
        done = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True, timeout=300)
        return done.returncode, done.stdout, done.stderr

    for arguments, code in [
        (["--version"], 0),
        (["identify", "--help"], 0),
        (["identify", root / "examples/cylinder"], 0),
        (["identify", tmp_path / "absent"], 1),
        (["identfy"], 2),
    ]:
        inside = run(sys.executable, "-m", "pneutherm", *arguments)
        assert inside == run(PROGRAM, *arguments) and inside[0] == code


def test_the_program_starts_without_loading_pyarrow(package):
    code = "import sys, pneutherm.__main__; assert 'pyarrow' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(package)}, check=True)


LONG = """
[study]
model = "model.toml"
design = "latin-hypercube"
samples = 300000
solver = "adaptive"
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.15
final_stroke_m = 0.08
push_time_s = 0.04
duration_s = 10.0
[vary]
bore_m = { from = 0.016, to = 0.063 }
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals as POSIX has them")
def test_an_interrupt_is_heard_during_long_work(package, root, tmp_path):
    (tmp_path / "model.toml").write_text((root / "fuzz/corpus/model/leaking.toml").read_text())
    (tmp_path / "study.toml").write_text(LONG)
    code = "import pneutherm; print('begins', flush=True); pneutherm.sweep('study.toml'); print('ends')"
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(package)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A job in the background is started with interrupts ignored, and Python leaves them so.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    out, err = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in err and out == "" and time.monotonic() - begin < 5.0
