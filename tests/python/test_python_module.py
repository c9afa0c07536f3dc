"""The Python package: the extension module in place of the program, tables without copies."""

import gc
import math
import os
import resource
import shutil
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


def test_no_result_is_written_over_what_the_rig_consists_of(module, root, tmp_path):
    folder = shutil.copytree(root / "examples/cylinder", tmp_path / "cylinder")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    rig, trace = folder / "rig.toml", next(folder.glob("compress-*.csv"))
    for call in [
        lambda: module.identify(folder, model=rig),
        lambda: module.identify(rig, model=trace),
        lambda: module.diagnose(folder, model=trace),
        lambda: module.diagnose(folder, report=rig),
    ]:
        with pytest.raises(module.Error, match="not written, because it is read by this command"):
            call()
    with pytest.raises(module.Error, match="two results cannot go to one file"):
        module.diagnose(folder, model=tmp_path / "out", report=tmp_path / "out")
    assert before == {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}


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


def test_validate_judges_a_model_by_records(module, root, tmp_path):
    model = tmp_path / "model.toml"
    module.diagnose(root / "examples/cylinder", model=model)
    found = module.validate(model, root / "examples/cylinder")
    assert found.rmse_pa < 1.3 * found.noise_pa and found.systematic_pa is None
    assert found.records.num_rows == len(found.raw["records"]) > 5 and "rmse_pa" in found.records.column_names
    assert module.validate(model, root / "examples/cylinder", whole_record=True).systematic_pa is not None
    with pytest.raises(module.Error, match="absent.toml: cannot be read"):
        module.validate("absent.toml", root / "examples/cylinder")


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
    with pytest.raises(module.Error, match="unknown value `exakt`; expected one of: exact, time-constant"):
        module.identify(root / "examples/cylinder", method="exakt")
    with pytest.raises(module.Error, match="the initial pressure is -1; expected a number from 1000.0 to 100000000.0, in Pa, absolute"):
        module.simulate(
            root / "fuzz/corpus/model/paper.toml", root / "examples/cylinder/validation.csv", initial_pressure_pa=-1
        )


def native_simulation(module, root):
    """The native result behind the pyarrow table of `simulate`."""
    model, motion = root / "fuzz/corpus/model/paper.toml", root / "examples/cylinder/validation.csv"
    return module._native.simulate((model, None), motion, (None, None), 2e5, False, None, 0.95, 0)


def test_a_table_s_numbers_lie_where_rust_wrote_them_and_outlive_the_result(module, root):
    import pyarrow

    result = native_simulation(module, root)
    one, two = pyarrow.table(result), pyarrow.table(result)
    place = lambda table: table["pressure_pa"].chunk(0).buffers()[1].address  # noqa: E731
    assert len(result) == one.num_rows and place(one) == place(two), "a copy was made"
    before = one["pressure_pa"].to_pylist()
    del result, two
    gc.collect()
    native_simulation(module, root)
    assert one["pressure_pa"].to_pylist() == before


def test_other_libraries_take_the_result_as_it_is(module, root):
    polars = pytest.importorskip("polars")
    result = native_simulation(module, root)
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
        # The same width for both: the readline library sets COLUMNS without updating Python's copy of the environment.
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
        # A background job is started with interrupts ignored, and Python keeps it so.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    out, err = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in err and out == "" and time.monotonic() - begin < 5.0


STUDY = {
    "study": {"model": "", "design": "sobol", "samples": 3000, "fit": False},
    "test": {"initial_pressure_pa": 1.01e5, "initial_stroke_m": 0.1, "final_stroke_m": 0.05, "push_time_s": 0.04, "duration_s": 3.0},
    "vary": {"bore_m": {"from": 0.016, "to": 0.04}, "effect.leakage.conductance_m3_per_s_pa": {"from": 1e-13, "to": 1e-11, "scale": "log"}},
}


@pytest.fixture
def study(root):
    return STUDY | {"study": STUDY["study"] | {"model": root / "fuzz/corpus/model/paper.toml"}}


def test_a_study_in_python_s_words_is_a_table_batches_and_a_folder_with_the_same_rows(module, study, tmp_path):
    import numpy as np
    import polars

    told = []
    table = module.sweep(study)
    assert table.num_rows == 3000 and table.schema.field("bore_m").metadata[b"unit"] == b"m"
    assert table.column_names[1:3] == ["bore_m", "effect.leakage.conductance_m3_per_s_pa"]
    with module.batches(study) as reader:
        assert reader.read_all().equals(table)
    folder = module.sweep(study, tmp_path / "out", progress=lambda done, rows: told.append((done, rows)))
    assert folder.complete and folder.rows_written == 3000 and sum(folder.statuses.values()) == 3000
    assert folder.rows.to_table().sort_by("row")["pressure_peak_pa"].equals(table["pressure_peak_pa"])
    assert told[-1] == (3000, 3000) and folder.statistics is None and folder.sensitivity is None
    assert module.sweep(study, tmp_path / "out").rows_written == 0, "what is there stays"
    larger = study | {"study": study["study"] | {"samples": 4000}}
    grown = module.sweep(larger, tmp_path / "grown", extend=tmp_path / "out")
    assert (grown.rows_written, grown.rows_taken, grown.complete) == (1000, 3000, True)
    assert grown.rows.to_table().sort_by("row").slice(0, 3000)["pressure_peak_pa"].equals(table["pressure_peak_pa"])
    polars.DataFrame(module.batches(study)).select("row", "pressure_peak_pa")
    assert polars.scan_pyarrow_dataset(folder.rows).collect().height == len(folder.rows.to_table().to_pandas()) == 3000
    assert polars.from_arrow(table).height == 3000
    listed = study | {"study": study["study"] | {"design": "factorial"}, "vary": {"bore_m": {"values": np.array([0.02, 0.03])}}}
    assert module.sweep(listed)["bore_m"].to_pylist() == [0.02, 0.03]


def test_statistics_of_a_study_are_those_of_numpy(module, study, tmp_path):
    import numpy as np

    peak = np.array(module.sweep(study)["pressure_peak_pa"])
    found = module.statistics(study, columns=["pressure_peak_pa"], quantiles=np.array([0.5, 0.9]))
    column = found["columns"]["pressure_peak_pa"]
    assert list(found["columns"]) == ["pressure_peak_pa"] and column["count"] == 3000
    assert column["mean"] == pytest.approx(peak.mean(), rel=1e-12) and column["variance"] == pytest.approx(peak.var(ddof=1), rel=1e-9)
    for quantile, share in zip(column["quantiles"], [0.5, 0.9], strict=True):
        assert quantile["value"] == pytest.approx(np.quantile(peak, share), rel=1e-3)
    without_rows = module.sweep(study | {"statistics": {"columns": ["pressure_peak_pa"], "quantiles": [0.5, 0.9]}}, tmp_path / "out", rows=False)
    assert without_rows.statistics["columns"] == found["columns"]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"vary": {"boer_m": {"values": [0.02]}}}, "did you mean `bore_m`?"),
        ({"vary": {"bore_m": {"values": [-0.02]}}}, "has to be from 1e-4 to 5"),
        ({"vary": {"bore_m": {"values": [object()]}}}, "a value of type object is not allowed in a study"),
        ({"vary": {"bore_m": {"values": [None]}}}, "study"),
        ({"study": {"model": "absent.toml", "design": "factorial"}}, "absent.toml: cannot be read"),
    ],
)
def test_a_study_that_cannot_be_raises_the_sentence(module, study, change, sentence):
    with pytest.raises(module.Error, match="(?s)" + sentence.replace("?", r"\?").replace(".", r"\.")):
        module.sweep(study | change)
    with pytest.raises(module.Error, match="is no result of this study; did you mean `pressure_peak_pa`"):
        module.statistics(study, columns=["presure_peak_pa"])
    with pytest.raises(module.Error, match="I/N with I from 0 to N-1"):
        module.sweep(study, "never", shard="2/2")


def test_a_callback_that_raises_ends_the_study(module, study, tmp_path):
    def refuse(done, rows):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        module.sweep(study | {"study": study["study"] | {"samples": 3_000_000}}, tmp_path / "out", progress=refuse)


def test_a_motion_may_be_a_table_and_has_a_band(module, root, tmp_path):
    import pandas

    model = tmp_path / "model.toml"
    module.identify(root / "examples/cylinder", model=model)
    motion = root / "examples/cylinder/validation.csv"
    from_file = module.simulate(model, motion)
    assert module.simulate(model, pandas.read_csv(motion)).equals(from_file)
    band = module.simulate(model, motion, samples=32, seed=3)
    assert band.select(from_file.column_names).equals(from_file)
    assert band.schema.field("pressure_low_pa").metadata[b"unit"] == b"Pa"
    assert all(low < high for low, high in zip(band["pressure_low_pa"].to_pylist(), band["pressure_high_pa"].to_pylist()))
    with pytest.raises(module.Error, match="16 to 100000 draws"):
        module.simulate(model, motion, samples=3)


def toml(path):
    """Contents of a TOML file."""
    tomllib = pytest.importorskip("tomllib", reason="TOML files are read by Python from version 3.11 on")
    return tomllib.loads(path.read_text())


def test_a_rig_may_be_a_file_a_dictionary_keyword_arguments_or_a_file_with_other_values(module, root, monkeypatch):
    import pandas

    monkeypatch.chdir(root / "examples/cylinder")
    rig = toml(root / "examples/cylinder/rig.toml")
    from_file = module.identify(root / "examples/cylinder").raw
    assert module.identify(rig).raw == from_file
    assert module.identify(**rig).raw == from_file
    assert module.identify("rig.toml", cylinder=rig["cylinder"], experiment=rig["experiment"]).raw == from_file
    # Records in memory, and a file with one value replaced.
    (first, *others) = rig["experiment"]
    frames = first | {"traces": [pandas.read_csv(trace) for trace in first["traces"]]}
    in_memory = module.identify(rig, experiment=[frames, *others])
    assert in_memory.parameters.equals(module.identify(rig).parameters)
    smaller = module.identify("rig.toml", cylinder={"bore_m": 0.9 * rig["cylinder"]["bore_m"]})
    mass = lambda found: next(row["value"] for row in found["parameters"].values() if row["unit"] == "kg")
    assert mass(smaller.raw) == pytest.approx(0.81 * mass(from_file), rel=0.01)


def test_diagnose_validate_and_simulate_take_contents_as_well(module, root, tmp_path, monkeypatch):
    monkeypatch.chdir(root / "examples/cylinder")
    rig = toml(root / "examples/cylinder/rig.toml")
    found = module.diagnose(**rig, model=tmp_path / "model.toml")
    assert found.effects == ["leakage"]
    model = toml(tmp_path / "model.toml")
    assert [entry["path"] for entry in model["provenance"]["traces"]][0].endswith(".csv")
    from_files = module.validate(tmp_path / "model.toml", "rig.toml")
    assert module.validate(model, rig).raw == module.validate(model, **rig).raw
    assert module.validate(model, rig).rmse_pa == from_files.rmse_pa

    motion = root / "examples/cylinder/validation.csv"
    expected = module.simulate(tmp_path / "model.toml", motion)
    assert module.simulate(model, motion).equals(expected)
    tables = {name: model[name] for name in ("chamber", "heat_transfer", "effect", "gas", "ambient")}
    assert module.simulate(None, motion, **tables).equals(expected)
    sealed = module.simulate(tmp_path / "model.toml", motion, effect={"leakage": {"conductance_m3_per_s_pa": 0.0}})
    assert min(sealed["mass_kg"].to_pylist()) == max(sealed["mass_kg"].to_pylist()) > min(expected["mass_kg"].to_pylist())


def test_a_motion_s_columns_are_keyword_arguments(module, root):
    import pandas

    model, motion = root / "fuzz/corpus/model/paper.toml", root / "examples/cylinder/validation.csv"
    frame = pandas.read_csv(motion)
    other = pandas.DataFrame({"t": frame["time_s"] * 1e3, "x": frame["position_m"] * 1e3, "ambient_temperature_k": frame["ambient_temperature_k"]})
    columns = {"time": {"name": "t", "unit": "ms"}, "position": {"name": "x", "unit": "mm"}}
    ours = module.simulate(model, other, columns=columns, initial_pressure_pa=2e5)
    expected = module.simulate(model, motion, initial_pressure_pa=2e5)
    assert ours["gas_pressure_pa"].to_pylist() == pytest.approx(expected["gas_pressure_pa"].to_pylist(), rel=1e-9)


def test_what_is_wrong_with_a_content_is_said_with_its_key_and_no_line(module, root):
    rig = toml(root / "examples/cylinder/rig.toml")
    for content, sentence in [
        ({"cylinder": {"boer_m": 0.03}}, r"^rig: cylinder.boer_m: unknown key.*bore_m"),
        ({"cylinder": {"bore_m": "wide"}}, "^rig: cylinder.bore_m: "),
        ({"cylinder": {"bore_m": None}}, r"^rig: cylinder\.bore_m: has no value \(None\)"),
        ({"cylinder": {"bore_m": math.nan}}, "a number that is not finite"),
        ({"cylinder": {"bore_m": object()}}, "a value of type object is not allowed"),
        ({"cylinder": rig["cylinder"]}, "^rig: experiment: .*at least one"),
        ({"experiment": rig["experiment"]}, "^rig: cylinder: "),
        (rig | {"experiment": [{"name": "push", "traces": "absent.csv"}]}, "absent.csv: cannot be read"),
        (rig | {"experiment": "push"}, "^rig: experiment: "),
        (rig | {"experiment": [3]}, "^rig: experiment"),
    ]:
        with pytest.raises(module.Error, match=sentence):
            module.identify(content)
        with pytest.raises(module.Error, match=sentence):
            module.identify(**content)
    with pytest.raises(module.Error, match="rig: no rig file and no content of one is given"):
        module.identify()
    with pytest.raises(module.Error, match="rig.toml: cylinder.bore_m: "):
        module.identify(root / "examples/cylinder", cylinder={"bore_m": -1.0})
    with pytest.raises(module.Error, match="^model: chamber: "):
        module.simulate({"gas": {"name": "air"}}, root / "examples/cylinder/validation.csv")
    with pytest.raises(TypeError, match="unexpected keyword argument 'methd'"):
        module.identify(root / "examples/cylinder", methd="exact")


def test_traces_from_tables_and_files_are_the_rows_of_the_text_file(module, root, tmp_path):
    """The example's record, as stored by other programs, gives the chamber the same course."""
    import pandas
    import polars
    import pyarrow
    import pyarrow.feather
    import pyarrow.parquet
    import scipy.io

    record = root / "examples/cylinder/validation.csv"
    frame = pandas.read_csv(record)
    expected = module.write_trace(frame, tmp_path / "expected.csv").read_text()
    assert pandas.read_csv(tmp_path / "expected.csv").equals(frame)
    arrays = {name: frame[name].to_numpy() for name in frame.columns}
    pyarrow.parquet.write_table(pyarrow.table(arrays), tmp_path / "trace.parquet")
    pyarrow.feather.write_feather(pyarrow.table(arrays), tmp_path / "trace.feather")
    scipy.io.savemat(tmp_path / "trace.mat", arrays | {"comment": "a remark", "bore": 0.032})
    scipy.io.savemat(tmp_path / "nested.mat", {"record": arrays, "matrix": frame.to_numpy()})
    sources = [pyarrow.table(arrays), polars.DataFrame(arrays), arrays, tmp_path / "trace.parquet", tmp_path / "trace.feather", tmp_path / "trace.mat"]
    for source in sources:
        assert module.write_trace(source, tmp_path / "trace.csv").read_text() == expected, source
    fields = {name: f"record.{name}" for name in arrays}
    assert module.write_trace(tmp_path / "nested.mat", tmp_path / "trace.csv", columns=fields).read_text() == expected
    matrix = {name: f"matrix(:,{i + 1})" for i, name in enumerate(arrays)}
    assert module.write_trace(tmp_path / "nested.mat", tmp_path / "trace.csv", columns=matrix).read_text() == expected
    import h5py

    with h5py.File(tmp_path / "v73.mat", "w") as file:  # MATLAB's layout of version 7.3: HDF5, a column as 1 x n.
        for name, values in arrays.items():
            file[f"record/{name}"] = values.reshape(1, -1)
    assert module.write_trace(tmp_path / "v73.mat", tmp_path / "trace.csv", columns=fields).read_text() == expected
    with pandas.ExcelWriter(tmp_path / "trace.xlsx") as book:
        pandas.DataFrame({"note": ["not this sheet"]}).to_excel(book, sheet_name="notes", index=False)
        units = pandas.DataFrame([{name: name.rpartition("_")[2] for name in frame.columns}])
        pandas.concat([units, frame]).to_excel(book, sheet_name="record", index=False)
    assert module.write_trace(tmp_path / "trace.xlsx", tmp_path / "trace.csv", sheet="record").read_text() == expected


def test_a_source_that_is_no_trace_is_refused_in_a_sentence(module, tmp_path):
    import scipy.io

    (tmp_path / "broken.mat").write_bytes(b"MATLAB?")
    (tmp_path / "broken.parquet").write_bytes(b"PAR1")
    scipy.io.savemat(tmp_path / "unequal.mat", {"t": [0.0, 1.0, 2.0], "p": [1e5, 1e5]})
    for source, sentence in [
        (tmp_path / "broken.mat", "broken.mat: cannot be read"),
        (tmp_path / "broken.parquet", "broken.parquet: cannot be read"),
        (tmp_path / "absent.parquet", "absent.parquet: cannot be read"),
        (tmp_path / "unequal.mat", r"its columns differ in length: t \(3\), p \(2\)"),
        (tmp_path / "trace.txt", "is none of .*text files are read as they are"),
        (3, "int is no table"),
        ({"name": ["a", "b"]}, "has no column of numbers"),
    ]:
        with pytest.raises(module.Error, match=sentence):
            module.write_trace(source, tmp_path / "trace.csv")
    with pytest.raises(module.Error, match="has no column `p`; it has `t`"):
        module.write_trace({"t": [0.0, 1.0]}, tmp_path / "trace.csv", columns=["t", "p"])
    assert not (tmp_path / "trace.csv").exists()


def test_a_trace_that_cannot_be_written_leaves_what_stood_there(module, tmp_path):
    trace = tmp_path / "trace.csv"
    trace.write_text("before")
    limit, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(module.Error, match="trace.csv: cannot be written: File too large"):
            module.write_trace({"t": [float(row) for row in range(1000)]}, trace)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
        signal.signal(signal.SIGXFSZ, handler)
    assert trace.read_text() == "before" and [file.name for file in tmp_path.iterdir()] == ["trace.csv"]
