"""`pneutherm reproduce`: the paper's numbers, and files readable by other tools."""

import csv
import json
import math
import xml.etree.ElementTree as ElementTree

import pyarrow.parquet as parquet
import pytest


@pytest.fixture(scope="module")
def results(pneutherm, tmp_path_factory):
    """The folder filled by the command."""
    folder = tmp_path_factory.mktemp("results")
    pneutherm("reproduce", "-o", folder)
    return folder


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_section_3_1_is_reproduced_to_half_a_percent(results, root):
    lines = json.loads((results / "section31.json").read_text())
    printed = rows(root / "paper/data/section31_simulation.csv")
    assert [(line["symbol"], line["unit"]) for line in lines[: len(printed)]] == [
        (row["symbol"], row["unit"]) for row in printed
    ]
    for line, row in zip(lines, printed):
        assert line["paper"] == float(row["value"])
        if line["quantity"] != "peak over steady state":
            assert line["ours"] == pytest.approx(line["paper"], rel=5e-3), line
    own = {line["symbol"]: line["ours"] for line in lines[len(printed) :]}
    assert own["lambda0_exact"] == pytest.approx(26.5, rel=1e-6)
    assert own["bias_fit"] == pytest.approx(0.067, abs=2e-3)
    assert own["bias_area"] == pytest.approx(-0.076, abs=1e-3)


def test_the_section_s_numbers_follow_from_an_independent_simulation(results):
    """scipy integrates the paper's equations (1) and (2) and fits the exponential."""
    numpy = pytest.importorskip("numpy")
    integrate = pytest.importorskip("scipy.integrate")
    optimize = pytest.importorskip("scipy.optimize")
    gamma, gas_constant, bore, dead, ambient = 1.4, 287.0, 0.02, 1.57e-6, 293.0
    piston = math.pi * bore**2 / 4

    def rates(t, state):
        pressure, temperature = state
        x, speed = (0.1 - 0.05 * t / 0.04, -0.05 / 0.04) if t < 0.04 else (0.05, 0.0)
        volume = dead + piston * x
        area = math.pi * bore * x + math.pi * bore**2 / 2
        heat = 26.5 * math.sqrt(pressure * temperature / (5.65e5 * 293)) * area * (ambient - temperature)
        growth = piston * speed / volume
        return [
            -gamma * pressure * growth + (gamma - 1) / volume * heat,
            temperature * growth * (1 - gamma) + (gamma - 1) * temperature / (pressure * volume) * heat,
        ]

    options = {"rtol": 1e-10, "atol": 1e-8, "method": "DOP853"}
    push = integrate.solve_ivp(rates, (0, 0.04 - 1e-15), [1e5, ambient], **options)
    times = numpy.arange(501) / 100
    hold = integrate.solve_ivp(rates, (0.04, 5.04), push.y[:, -1], t_eval=0.04 + times, **options)
    fit, _ = optimize.curve_fit(
        lambda t, final, rise, tau: final + rise * numpy.exp(-t / tau), times, hold.y[0] / 1e5, [1.9, 0.5, 0.4]
    )
    ours = {line["symbol"]: line["ours"] for line in json.loads((results / "section31.json").read_text())}
    assert [ours["Pf"], ours["dP"], ours["tau"]] == pytest.approx(list(fit), rel=1e-5)


@pytest.mark.parametrize("table", ["table4_heat_transfer", "table5_trend"])
def test_tables_hold_the_paper_s_columns_and_ours(results, root, table):
    printed = rows(root / f"paper/data/{table}.csv")
    ours = rows(results / f"{table.split('_')[0]}.csv")
    assert len(ours) == len(printed) == 6
    for mine, theirs in zip(ours, printed):
        for column, text in theirs.items():
            assert mine[column] == text
            if column in ("experiment", "actuator"):
                continue
            value = float(mine[column + "_ours"])
            close = 0.015 if column.startswith("coefficient") else 0.07
            assert value == pytest.approx(float(text), rel=close), (column, mine)
            assert float(mine[column + "_difference"]) == pytest.approx(value / float(text) - 1, abs=2e-4)


def test_every_form_of_the_loop_is_listed_with_its_errors(results):
    forms = {form["name"]: form for form in json.loads((results / "geometry_effect.json").read_text())}
    assert len(forms) >= 20
    for form in forms.values():
        assert form["parameters"] == len(form["values"])
        assert form["rms_fitted"] < 0.5
    one, column = forms["one lambda0"], forms["column length^-1/2"]
    assert one["rms_fitted"] == pytest.approx(0.26, abs=0.01) and one["rms_left_out"] == pytest.approx(0.38, abs=0.01)
    assert column["rms_fitted"] == pytest.approx(0.051, abs=0.003)
    assert column["rms_left_out"] == pytest.approx(0.066, abs=0.003)


def curves(path, stays="bore_m"):
    """λ0 over V/A for each bore (or the quantity `stays`) and pressure."""
    found = {}
    for row in parquet.read_table(path).to_pylist():
        curve = found.setdefault((row[stays], row["initial_pressure_pa"]), [])
        curve.append((row["volume_to_area_m"], row["lambda0_w_per_m2_k"]))
    return {key: sorted(curve) for key, curve in found.items()}


def test_the_study_shows_the_paper_s_trend_and_its_sibling_is_flat(results):
    studied = curves(results / "table5_sweep.parquet")
    flat = curves(results / "table5_sweep_one_lambda0.parquet")
    assert studied.keys() == flat.keys() and len(studied) >= 10
    for (bore, pressure), curve in studied.items():
        values = [coefficient for _, coefficient in curve]
        assert all(a > b for a, b in zip(values, values[1:]))
        other = next(c for (b, p), c in studied.items() if b == bore and p != pressure)
        # At 100 rows per second a shorter time constant has fewer rows: the fit's bias differs by that amount.
        assert values == pytest.approx([coefficient for _, coefficient in other], rel=5e-3)
    everything = [coefficient for curve in flat.values() for _, coefficient in curve]
    assert max(everything) / min(everything) - 1 < 0.02


def test_parquet_columns_name_their_units(results):
    for name in ("table5_sweep", "table5_sweep_one_lambda0"):
        file = parquet.ParquetFile(results / f"{name}.parquet")
        schema = file.schema_arrow
        assert schema.field("volume_to_area_m").metadata[b"unit"] == b"m"
        assert schema.field("lambda0_w_per_m2_k").metadata[b"unit"]
        assert file.metadata.num_rows == len(rows(results / f"{name}_points.csv"))


def test_the_study_files_give_the_same_rows_again(results, pneutherm, tmp_path):
    pneutherm("sweep", results / "table5_sweep.toml", "-o", tmp_path / "again")
    again = parquet.read_table(tmp_path / "again" / "rows").to_pylist()
    assert again == parquet.read_table(results / "table5_sweep.parquet").to_pylist()


def test_a_second_run_writes_the_same_bytes(results, pneutherm, tmp_path):
    pneutherm("reproduce", "-o", tmp_path)
    names = sorted(path.name for path in results.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    for name in names:
        assert (results / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_figures_are_drawings_with_text_and_the_report_holds_them(results):
    report = (results / "report.html").read_text()
    figures = sorted(results.glob("*.svg"))
    assert len(figures) >= 4
    for figure in figures:
        drawing = ElementTree.parse(figure).getroot()
        assert drawing.tag.endswith("svg") and len(list(drawing.iter("{http://www.w3.org/2000/svg}text"))) > 10
        assert figure.name in report
    assert "<script" not in report and 'src="http' not in report


def test_a_folder_that_cannot_be_made_is_named(pneutherm, tmp_path):
    (tmp_path / "file").write_text("in the way")
    process = pneutherm("reproduce", "-o", tmp_path / "file", code=1)
    assert "file" in process.stderr and len(process.stderr.strip().splitlines()) == 1


def test_a_folder_in_the_place_of_any_file_is_told_before_anything_is_written(results, pneutherm, tmp_path):
    for name in sorted(path.name for path in results.iterdir()):
        (tmp_path / name / name).mkdir(parents=True)
        error = pneutherm("reproduce", "-o", tmp_path / name, code=1).stderr
        assert f"{name}: cannot be written: a folder of that name exists" in error
        assert [path.name for path in (tmp_path / name).iterdir()] == [name]
