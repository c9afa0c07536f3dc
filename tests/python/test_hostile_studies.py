"""Invalid studies: each ends with one sentence that names the file, and nothing is written."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from test_sweep import MODEL, TEST

STUDY = f"""[study]
model = "model.toml"
design = "factorial"
{TEST}
[vary]
bore_m = {{ values = [0.02, 0.03] }}
"""
SOBOL = ('design = "factorial"', 'design = "sobol"\nsamples = 16')
RANGE = ("{ values = [0.02, 0.03] }", "{ from = 0.02, to = 0.03, count = 3 }")


def vary(line):
    """Replacement that varies this quantity, too."""
    return [("[vary]\n", f"[vary]\n{line}\n")]


def only(line):
    """Replacement that varies only this quantity."""
    return [("bore_m = { values = [0.02, 0.03] }", line)]


# Replacements in the study above, and the expected part of the error message.
STUDIES = {
    "an empty file": ([(STUDY, "")], "study.model: missing"),
    "not TOML": ([("[study]", "[study")], "line 1, column"),
    "a value without a key": ([("[study]", "[study]\n= 3")], "line 2, column"),
    "a key twice": ([("[vary]", "duration_s = 4.0\n[vary]")], "duplicate key"),
    "a table twice": ([("[vary]", "[study]\n[vary]")], "line"),
    "an unknown table": ([("[vary]", "[extra]\na = 1\n[vary]")], "extra: unknown key"),
    "a misspelt table": ([("[vary]", "[varry]")], "did you mean `vary`?"),
    "a model's table": ([("[vary]", "[chamber]\nbore_m = 0.02\n[vary]")], "chamber: belongs to a model file"),
    "an unknown key": ([('design = "f', 'seeed = 1\ndesign = "f')], "did you mean `seed`?"),
    "no model": ([('model = "model.toml"\n', "")], "study.model: missing"),
    "an absent model": ([("model.toml", "nodel.toml")], "nodel.toml: cannot be read"),
    "a folder for a model": ([("model.toml", ".")], "cannot be read"),
    "a number for a model": ([('"model.toml"', "7")], "study.model: is the number 7, expected a text in quotes"),
    "no design": ([('design = "factorial"\n', "")], "study.design: missing"),
    "an unknown design": ([('"factorial"', '"grid"')], 'unknown value `grid`; expected one of: factorial, latin-hypercube'),
    "a design that is no text": ([('"factorial"', "true")], "study.design: is true, expected a text in quotes"),
    "nothing varies": (only(""), "at least one quantity to vary is needed"),
    "an unknown quantity": (only("boer_m = { values = [0.02] }"), "did you mean `bore_m`?"),
    "a quantity unlike any other": (only("zzz = { values = [1.0] }"), "is no number of the model or of the test"),
    "an unknown effect": (only('"effect.leek.conductance" = { values = [0.0] }'), "is no number of the model or of the test"),
    "an exponent of two effects": (only("exponent = { values = [0.1] }"), "could be effect.natural_convection.exponent or"),
    "a volume of two things": (only("volume_m3 = { values = [1e-6] }"), "chamber.dead_volume_m3"),
    "a result's name": (only("time_constant_s = { values = [1.0] }"), "the result time_constant_s, which cannot be varied"),
    "a pressure of several": (only("pressure_pa = { values = [1e5] }"), "test.initial_pressure_pa"),
    "a temperature of several": (only("temperature_k = { values = [300.0] }"), "test.initial_temperature_k"),
    "a coefficient of two": (only("coefficient = { values = [1.0] }"), "heat_transfer.coefficient_w_per_m2_k"),
    "a quantity twice": (vary('"chamber.bore_m" = { values = [0.02] }'), "line 14: vary.bore_m: repeats chamber.bore_m"),
    "bore and the ratio it is solved from": (vary("volume_to_area_m = { values = [0.004] }"), "vary one of the two"),
    "both ratios": (only("volume_to_area_m = { values = [0.004] }\nvolume_to_area_by_length_m = { values = [0.004] }"), "solved for in two ways"),
    "a stroke and the ratio it is solved from": (vary("volume_to_area_by_length_m = { values = [0.004] }\nfinal_stroke_m = { values = [0.05] }"), "both strokes are solved from"),
    "a bare number": (only("bore_m = 0.02"), "is the number 0.02, expected { values = [...] }"),
    "a bare list": (only("bore_m = [0.02, 0.03]"), "is a list, expected { values = [...] }"),
    "a text": (only('bore_m = "20 mm"'), 'is the text "20 mm", expected { values = [...] }'),
    "an empty table": (only("bore_m = {}"), "is incomplete"),
    "an empty list": (only("bore_m = { values = [] }"), "is empty"),
    "text in a list": (only('bore_m = { values = [0.02, "0.03"] }'), "expected a finite number"),
    "NaN in a list": (only("bore_m = { values = [nan] }"), "expected a finite number"),
    "infinity in a list": (only("bore_m = { values = [inf] }"), "expected a finite number"),
    "an unknown word in an axis": (only("bore_m = { vlues = [0.02] }"), "did you mean `values`?"),
    "values and a range": (only("bore_m = { values = [0.02], from = 0.01 }"), "bore_m.from: unknown key"),
    "half a range": (only("bore_m = { from = 0.02, count = 3 }"), "is incomplete"),
    "a range without a count": (only("bore_m = { from = 0.02, to = 0.03 }"), "needs a `count`"),
    "a range the wrong way round": (only("bore_m = { from = 0.03, to = 0.02, count = 3 }"), "`from` has to be below `to`"),
    "a range of one value": (only("bore_m = { from = 0.03, to = 0.03, count = 3 }"), "`from` has to be below `to`"),
    "a count of one": (only("bore_m = { from = 0.02, to = 0.03, count = 1 }"), "expected a whole number, 2 or above"),
    "half a count": (only("bore_m = { from = 0.02, to = 0.03, count = 2.5 }"), "expected a whole number, 2 or above"),
    "a negative count": (only("bore_m = { from = 0.02, to = 0.03, count = -3 }"), "expected a whole number, 2 or above"),
    "an endless range": (only("bore_m = { from = 0.02, to = inf, count = 3 }"), "expected a finite number"),
    "a logarithm of nothing": (only('rod_m = { from = 0.0, to = 0.01, count = 3, scale = "log" }'), "a logarithmic scale needs a value above 0"),
    "an unknown scale": (only('bore_m = { from = 0.02, to = 0.03, count = 3, scale = "cubic" }'), 'expected one of: linear, log'),
    "a negative bore": (only("bore_m = { values = [-0.02] }"), "takes -0.02, but has to be from 1e-4 to 5"),
    "no bore": (only("bore_m = { values = [0.0] }"), "takes 0, but has to be from 1e-4 to 5"),
    "a negative rod": (only("rod_m = { values = [-0.001] }"), "has to be from 0 to 5"),
    "a rod that fills the bore": (only("rod_m = { values = [0.0, 0.02] }"), "chamber.bore_m is 0.02 at most: the rod has to be thinner"),
    "a bore that no rod fits": (vary("rod_m = { values = [0.025, 0.028] }"), "chamber.rod_m is 0.025 at least"),
    "a negative dead volume": (only("dead_volume_m3 = { values = [-1e-6] }"), "has to be at least 0"),
    "no volume at all": (only("dead_volume_m3 = { values = [0.0] }\nfinal_stroke_m = { values = [0.0] }"), "the gas would have no volume"),
    "vacuum": (only("initial_pressure_pa = { values = [0.0] }"), "has to be from 1000 to 1e8"),
    "absolute zero": (only('"ambient.temperature_k" = { values = [0.0] }'), "has to be from 150 to 1000"),
    "millimetres": (only("bore_m = { values = [16.0] }"), "takes 16, but has to be from 1e-4 to 5"),
    "bar": (only("initial_pressure_pa = { from = 1.0, to = 7.0, count = 3 }"), "has to be from 1000 to 1e8"),
    "degrees Celsius": (only('"ambient.temperature_k" = { values = [20.0] }'), "takes 20, but has to be from 150 to 1000"),
    "a heat capacity ratio of one": (only("heat_capacity_ratio = { values = [1.0] }"), "has to be above 1"),
    "a leak that lets in what is not there": (only('"effect.leakage.conductance_m3_per_s_pa" = { values = [-1e-11] }'), "has to be from 0"),
    "a leak of a pipe": (only('"effect.leakage.conductance_m3_per_s_pa" = { values = [1.0] }'), "has to be from 0 to"),
    "more than all of the gas": (only("effect.gas_zones.mass_fraction = { values = [1.5] }"), "has to be from 0"),
    "a push of no time": (only("push_time_s = { values = [0.0] }"), "has to be above 0"),
    "a push longer than the test": (only("push_time_s = { values = [0.04, 10.0] }"), "the test must not end before its push"),
    "a test shorter than its push": ([("duration_s = 3.0", "duration_s = 0.01")], "the test must not end before its push"),
    "two lengths of the test": ([("duration_s = 3.0", "duration_s = 3.0\nhold_time_constants = 5.0")], "duration_s and hold_time_constants both set the length of the test"),
    "a length of the test given and varied": (vary("hold_time_constants = { values = [3.0] }"), "duration_s and hold_time_constants both set the length of the test"),
    "no length of the test": ([("duration_s = 3.0", "")], "test.duration_s: missing; expected duration_s or hold_time_constants"),
    "time constants without heat transfer": (only("coefficient_w_per_m2_k = { values = [0.0, 10.0] }") + [("duration_s = 3.0", "hold_time_constants = 5.0")], "without heat transfer there is no time constant"),
    "a ratio beyond every bore": (only("volume_to_area_m = { values = [0.03] }\ndead_volume_m3 = { values = [0.0] }"), "every bore gives less than 0.025 m"),
    "a ratio beyond every length": (only("volume_to_area_by_length_m = { values = [0.0051] }"), "every length gives less than 0.005"),
    "no pressure": ([("initial_pressure_pa = 1.01e5\n", "")], "test.initial_pressure_pa: missing"),
    "a pressure below vacuum": ([("1.01e5", "-1.01e5")], "has to be from 1000 to 1e8"),
    "a unit in a number": ([("duration_s = 3.0", 'duration_s = "3 s"')], "expected a finite number"),
    "a misspelt key of the test": ([("push_time_s", "push_tme_s")], "did you mean `push_time_s`?"),
    "a negative flow": ([("duration_s", "mass_flow_in_kg_per_s = -1.0\nduration_s")], "has to be at least 0"),
    "a distribution in a factorial design": (only('bore_m = { distribution = "normal", mean = 0.02, sd = 1e-4 }'), "is a distribution, which has no levels"),
    "a distribution that reaches below zero": ([SOBOL] + only('bore_m = { distribution = "normal", mean = 0.02, sd = 0.01 }'), "`from` and `to` truncate a distribution"),
    "an unknown distribution": ([SOBOL] + only('bore_m = { distribution = "gauss" }'), 'expected one of: normal, log-normal'),
    "a model without covariance": ([SOBOL] + only('from = "model"'), "the model, which has no [uncertainty]"),
    "no samples": ([('"factorial"', '"sobol"'), RANGE], "study.samples: missing"),
    "zero samples": ([('"factorial"', '"sobol"\nsamples = 0'), RANGE], "expected a whole number, 1 or above"),
    "samples in words": ([('"factorial"', '"sobol"\nsamples = "many"'), RANGE], "expected a whole number, 1 or above"),
    "more samples than a study may have": ([('"factorial"', '"sobol"\nsamples = 4000000000000000'), RANGE], "more rows than a study may have"),
    "more levels than a study may have": (only("\n".join(f"{name} = {{ from = 0.01, to = 0.02, count = 2000000 }}" for name in ("bore_m", "push_time_s", "final_stroke_m"))), "more rows than a study may have"),
    "a negative seed": ([SOBOL, ("[study]", "[study]\nseed = -1")], "expected a whole number, zero or above"),
    "no parts": ([("[study]", "[study]\nparts = 0")], "expected a whole number, 1 or above"),
    "more parts than rows": ([("[study]", "[study]\nparts = 3")], "the design has only 2 rows"),
    "an unknown solver": ([("[study]", '[study]\nsolver = "magic"')], 'expected one of: auto, exact, adaptive'),
    "a tolerance of nothing": ([("[study]", "[study]\ntolerance = 0.0")], "expected a number from 1e-13 to 1e-2"),
    "a regression perhaps": ([("[study]", '[study]\nfit = "perhaps"')], "expected true or false"),
    "a table without the design": ([("[study]", '[study]\ntable = "points.csv"')], 'belongs to design = "table"'),
    "a constraint that is a text": (vary('constraints = "rod_m < bore_m"'), "expected a list of texts"),
    "a constraint of half a comparison": (vary('constraints = ["bore_m <"]'), "ends; expected a number or a quantity"),
    "a constraint on nothing that varies": (vary('constraints = ["rod_m < 1"]'), "which depends on nothing that varies"),
    "a constraint on a result": (vary('constraints = ["bore_m < settling_time_s"]'), "which is not known before the row is solved"),
    "a constraint on what is not there": (vary('constraints = ["boer_m < 1"]'), "did you mean `bore_m`?"),
    "a constraint that keeps nothing": (vary('constraints = ["bore_m > 1"]'), "leave no row to solve"),
    "a constraint without end": (vary('constraints = ["' + "(" * 400 + 'bore_m"]'), "; expected `)`"),
    "constraints of independent quantities": ([('"factorial"', '"saltelli"\nsamples = 8'), RANGE] + vary('constraints = ["bore_m > 0"]'), "are of independent ones"),
    "statistics of nothing": ([("[vary]", "[statistics]\ncolumns = []\n[vary]")], "is empty"),
    "statistics of what is not there": ([("[vary]", '[statistics]\ncolumns = ["presure_peak_pa"]\n[vary]')], "did you mean `pressure_peak_pa`?"),
    "a front of one column": ([("[vary]", '[statistics]\npareto = { minimise = ["settling_time_s"] }\n[vary]')], "2 to 4 are expected"),
    "a front of what is not there": ([("[vary]", '[statistics]\npareto = { minimise = ["setling_time_s", "area_m2"] }\n[vary]')], "did you mean `settling_time_s`?"),
    "a front both ways": ([("[vary]", '[statistics]\npareto = { minimise = ["area_m2"], maximise = ["area_m2"] }\n[vary]')], "names `area_m2` twice"),
    "a probability beyond one": ([("[vary]", "[statistics]\nquantiles = [95]\n[vary]")], "probabilities from 0 to 1 are expected"),
    "a histogram the wrong way round": ([("[vary]", "[statistics]\nhistograms = { area_m2 = { from = 1, to = 0, bins = 9 } }\n[vary]")], "`from` has to be below `to`"),
}


def refused(folder, pneutherm, *options):
    process = pneutherm("sweep", folder / "study.toml", "-o", folder / "out", *options, code=1)
    assert process.stderr.count("\n") == 1 and process.stderr.startswith("error: "), process.stderr
    assert process.stdout == "" and not (folder / "out").exists(), "something was written"
    assert len(process.stderr) < 1000
    return process.stderr


@pytest.mark.parametrize("name", STUDIES)
def test_a_bad_study_ends_in_one_sentence(name, tmp_path, pneutherm):
    replacements, sentence = STUDIES[name]
    study = STUDY
    for old, new in replacements:
        assert old in study
        study = study.replace(old, new, 1)
    (tmp_path / "model.toml").write_text(MODEL.format(law="total"))
    (tmp_path / "study.toml").write_text(study)
    error = refused(tmp_path, pneutherm)
    assert sentence in error and str(tmp_path) in error, error


def table(name, columns):
    def make(folder):
        pq.write_table(pa.table(columns), folder / name)

    return name, make


def csv(text):
    return "points.csv", lambda folder: (folder / "points.csv").write_text(text)


# A table of points, and the expected part of the error message.
TABLES = {
    "absent": (("points.csv", lambda folder: None), "points.csv: cannot be read"),
    "of another kind": (("points.xlsx", lambda folder: (folder / "points.xlsx").write_text("PK")), "whose name ends in .parquet or .csv"),
    "empty": (csv(""), "the table has no rows"),
    "a header only": (csv("bore_m\n"), "the table has no rows"),
    "an unknown column": (csv("boer_m\n0.02\n"), "column `boer_m` is no number of the model or of the test; did you mean `bore_m`?"),
    "a column that could be two": (csv("exponent\n0.1\n"), "could be effect.natural_convection.exponent"),
    "a column twice": (csv("bore_m,bore_m\n0.02,0.02\n"), "two columns are named `bore_m`"),
    "a quantity twice": (csv("bore_m,chamber.bore_m\n0.02,0.02\n"), "is a quantity that another column holds already"),
    "text": (csv("bore_m\n0.02\n20 mm\n"), "line 3, column `bore_m`: `20 mm` is not a finite number"),
    "a decimal comma": (csv("bore_m\n0.02\n0,03\n"), "line 3: 2 values; expected 1"),
    "an empty cell": (csv("bore_m,rod_m\n0.02,\n"), "line 2, column `rod_m`: the field is empty"),
    "NaN": (csv("bore_m\nnan\n"), "line 2, column `bore_m`: `nan` is not a finite number"),
    "a bore of nothing at its end": (csv("bore_m\n" + "0.02\n" * 9000 + "0\n"), "line 9002, column `bore_m`: is 0, but has to be from 1e-4 to 5"),
    "a leak of the wrong sign": (csv('effect.leakage.conductance_m3_per_s_pa\n-1e-11\n'), "has to be from 0"),
    "a rod that fills the bore": (csv("bore_m,rod_m\n0.02,0.0\n0.02,0.02\n"), "row 1: chamber.rod_m takes 0.02, but chamber.bore_m is 0.02 at most"),
    "a push longer than the test": (csv("push_time_s\n0.04\n4.0\n"), "row 1: test.push_time_s takes 4, but test.duration_s is 3 at most"),
    "bore and the ratio it is solved from": (csv("bore_m,volume_to_area_m\n0.02,0.004\n"), "set the same thing twice"),
    "Parquet with a leak of the wrong sign": (table("points.parquet", {"effect.leakage.conductance_m3_per_s_pa": np.append(np.zeros(99), -1e-11)}), "row 99: is -1e-11, but has to be from 0"),
    "Parquet with a null": (table("points.parquet", {"bore_m": [0.02, None]}), "column `bore_m`, row 1: expected a finite number"),
    "Parquet of words": (table("points.parquet", {"bore_m": ["wide"]}), "column `bore_m` holds Utf8; expected numbers"),
    "no Parquet": (("points.parquet", lambda folder: (folder / "points.parquet").write_text("PAR1 not")), "points.parquet"),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_bad_table_of_points_ends_in_one_sentence(name, tmp_path, pneutherm):
    (file, make), sentence = TABLES[name]
    make(tmp_path)
    (tmp_path / "model.toml").write_text(MODEL.format(law="total"))
    study = STUDY.replace('"factorial"', f'"table"\ntable = "{file}"').split("[vary]")[0]
    (tmp_path / "study.toml").write_text(study)
    error = refused(tmp_path, pneutherm)
    assert sentence in error and str(tmp_path) in error, error


# Previous contents of the output folder, and the expected part of the error message.
FOLDERS = {
    "a file": (lambda out: out.write_text(""), "it is a file, not a folder"),
    "a table of someone's": (lambda out: (out.mkdir(), (out / "mine.parquet").write_text("")), "mine.parquet is not in rows/"),
    "parts of an earlier version": (lambda out: (out.mkdir(), (out / "part-00000-of-00001.parquet").write_text("")), "is not in rows/"),
    "rows of someone's": (lambda out: ((out / "rows").mkdir(parents=True), (out / "rows" / "mine.csv").write_text("")), "rows/mine.csv is none of its 1 parts"),
    "parts without their study": (lambda out: ((out / "rows").mkdir(parents=True), (out / "rows" / "part-00000-of-00001.parquet").write_text("")), "which says whose, is missing"),
    "a manifest that is none": (lambda out: (out.mkdir(), (out / "manifest.json").write_text("{")), "manifest.json: the file is damaged"),
}


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_that_is_not_the_study_s_is_refused_and_left_alone(name, tmp_path, pneutherm):
    make, sentence = FOLDERS[name]
    (tmp_path / "model.toml").write_text(MODEL.format(law="total"))
    (tmp_path / "study.toml").write_text(STUDY)
    make(tmp_path / "out")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    process = pneutherm("sweep", tmp_path / "study.toml", "-o", tmp_path / "out", code=1)
    assert process.stderr.count("\n") == 1 and sentence in process.stderr
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


SOBOL_STUDY = STUDY.replace(*SOBOL).replace(*RANGE)
# A study, another one that should continue it, and the expected part of the error message.
CONTINUED = {
    "fewer samples": (SOBOL_STUDY, SOBOL_STUDY.replace("samples = 16", "samples = 8"), "it has 16 rows, this study only 8"),
    "another seed": (SOBOL_STUDY, SOBOL_STUDY.replace("samples = 16", "samples = 32\nseed = 1"), "its seed is 0, this study's 1"),
    "another range": (SOBOL_STUDY, SOBOL_STUDY.replace("to = 0.03", "to = 0.04"), "its bore_m is {"),
    "another test": (SOBOL_STUDY, SOBOL_STUDY.replace("duration_s = 3.0", "duration_s = 4.0"), "its test.duration_s is 3.0, this study's 4.0"),
    "another constraint": (SOBOL_STUDY, SOBOL_STUDY + 'constraints = ["bore_m < 0.025"]', "its constraints is nothing, this study's ["),
    "a hypercube": (SOBOL_STUDY.replace("sobol", "latin-hypercube"), SOBOL_STUDY.replace("sobol", "latin-hypercube").replace("16", "32"), "a Latin hypercube of more samples"),
    "a value in between": (STUDY, STUDY.replace("[0.02, 0.03]", "[0.02, 0.025, 0.03]"), "its row 1 is at bore_m = 0.03, this study's at 0.025"),
    "nothing": (None, SOBOL_STUDY, "it holds no study"),
}


@pytest.mark.parametrize("name", CONTINUED)
def test_a_study_that_does_not_continue_another_ends_in_one_sentence(name, tmp_path, pneutherm):
    earlier, later, sentence = CONTINUED[name]
    (tmp_path / "model.toml").write_text(MODEL.format(law="total"))
    if earlier:
        (tmp_path / "earlier.toml").write_text(earlier)
        pneutherm("sweep", tmp_path / "earlier.toml", "-o", tmp_path / "earlier")
    (tmp_path / "study.toml").write_text(later)
    error = refused(tmp_path, pneutherm, "--extend", tmp_path / "earlier")
    assert f"{tmp_path / 'earlier'}: cannot be continued: " in error and sentence in error
