"""`pneutherm sweep`: its rows against an independent integration, its files as other tools open them, and that neither
shards nor threads nor kills make a difference."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import reference
from conftest import PROGRAM, ROOT

MODEL = """
[gas]
gas_constant_j_per_kg_k = 287.0
heat_capacity_ratio = 1.4
[chamber]
bore_m = 0.02
rod_m = 0.0
dead_volume_m3 = 2e-6
area_law = "{law}"
[heat_transfer]
coefficient_w_per_m2_k = 30.0
reference_pressure_pa = 5.65e5
reference_temperature_k = 293.0
[ambient]
temperature_k = 293.0
pressure_pa = 1.013e5
"""
TEST = """
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.1
final_stroke_m = 0.05
push_time_s = 0.04
duration_s = 3.0
"""


def write(folder, study, vary, law="total", name="study.toml"):
    (folder / "model.toml").write_text(MODEL.format(law=law))
    path = folder / name
    path.write_text(f'[study]\nmodel = "model.toml"\n{study}\n{TEST}\n[vary]\n{vary}\n')
    return path


def table(folder):
    return pa.dataset.dataset(sorted(folder.glob("part-*.parquet"))).to_table()


FACTORIAL = """
bore_m = { from = 0.016, to = 0.063, count = 20, scale = "log" }
initial_pressure_pa = { from = 1e5, to = 7e5, count = 13 }
initial_stroke_m = { values = [0.1, 0.2, 0.4] }
"effect.leakage.conductance_m3_per_s_pa" = { values = [0.0, 1e-12] }
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory, pneutherm):
    """A factorial study's folder."""
    folder = tmp_path_factory.mktemp("factorial")
    pneutherm("sweep", write(folder, 'design = "factorial"\nname = "grid"\nseed = 5', FACTORIAL), "-o", folder / "out")
    return folder / "out"


def test_pyarrow_finds_every_row_of_the_design_and_every_unit(swept):
    rows = table(swept)
    assert rows.num_rows == 20 * 13 * 3 * 2
    assert rows["row"].to_pylist() == list(range(rows.num_rows))
    units = {field.name: field.metadata[b"unit"].decode() for field in rows.schema}
    assert units["pressure_peak_pa"] == "Pa" and units["lambda0_w_per_m2_k"] == "W/(m2.K)"
    assert units["effect.leakage.conductance_m3_per_s_pa"] == "m3/(s.Pa)"
    first = pq.ParquetFile(sorted(swept.glob("part-*.parquet"))[0])
    metadata = {key.decode(): value.decode() for key, value in first.metadata.metadata.items()}
    assert json.loads(metadata["units"]) == units
    assert (metadata["seed"], metadata["shard"]) == ("5", "0/1")
    assert metadata["program_version"] and json.loads(metadata["study"])["name"] == "grid"
    manifest = json.loads((swept / "manifest.json").read_text())
    assert manifest["rows"] == rows.num_rows == sum(part["rows"] for part in manifest["parts"])
    assert sorted(part["file"] for part in manifest["parts"]) == sorted(p.name for p in swept.glob("*.parquet"))
    assert sum(manifest["statuses"].values()) == rows.num_rows


def test_continuous_columns_are_compressed_without_a_dictionary(swept):
    group = pq.ParquetFile(sorted(swept.glob("part-*.parquet"))[0]).metadata.row_group(0)
    columns = {group.column(i).path_in_schema: group.column(i) for i in range(group.num_columns)}
    assert all(column.compression == "ZSTD" for column in columns.values())
    assert not columns["pressure_peak_pa"].has_dictionary_page
    assert "BYTE_STREAM_SPLIT" in columns["pressure_peak_pa"].encodings
    assert columns["status"].has_dictionary_page and columns["bore_m"].has_dictionary_page


def test_duckdb_and_polars_open_it(swept):
    duckdb, polars = pytest.importorskip("duckdb"), pytest.importorskip("polars")
    files = str(swept / "part-*.parquet")
    query = f"select status, count(*), max(pressure_peak_pa) from '{files}' group by status order by status"
    by_status = duckdb.sql(query).fetchall()
    frame = polars.read_parquet(files)
    assert sum(count for _, count, _ in by_status) == frame.height == 1560
    assert frame["pressure_peak_pa"].max() == max(peak for *_, peak in by_status)


# Random studies: each with its area law, what is always on, and what varies.
STUDIES = {
    "the paper's model": ("sobol", "total", "dead_volume_m3 = { from = 0.0, to = 5e-6 }\nheat_capacity_ratio = { from = 1.2, to = 1.6 }"),
    "swept area, an expansion": ("latin-hypercube", "swept", "final_stroke_m = { from = 0.12, to = 0.3 }\npush_time_s = { from = 0.02, to = 2.0 }"),
    "gas colder or hotter than its surroundings": (
        "sobol",
        "total",
        "initial_temperature_k = { from = 200.0, to = 380.0 }\npush_time_s = { from = 0.02, to = 2.0 }",
    ),
    "leak and wall": (
        "sobol",
        "total",
        '"effect.leakage.conductance_m3_per_s_pa" = { from = 1e-12, to = 1e-9, scale = "log" }\n'
        "effect.wall_heating.capacity_j_per_k = { from = 0.2, to = 2.0 }\n"
        "effect.wall_heating.outer_conductance_w_per_k = { from = 0.0, to = 0.1 }",
    ),
    "laws of the coefficient": (
        "latin-hypercube",
        "total",
        "effect.pressure_exponent.pressure_exponent = { from = 0.2, to = 0.9 }\n"
        "effect.pressure_exponent.temperature_exponent = { from = 0.0, to = 1.0 }\n"
        "effect.forced_convection.coefficient = { from = 0.0, to = 5.0 }\n"
        "effect.gas_column_length.exponent = { from = -1.0, to = 0.5 }",
    ),
    "zones, tube and a free surface": (
        "sobol",
        "total",
        "effect.gas_zones.mass_fraction = { from = 0.05, to = 0.4 }\n"
        "effect.gas_zones.conductance_w_per_k = { from = 0.005, to = 0.1 }\n"
        "tube_volume.volume_m3 = { from = 1e-7, to = 5e-6 }\n"
        "natural_convection.exponent = { from = 0.05, to = 0.3 }",
    ),
}
COMMON = """
bore_m = { from = 0.012, to = 0.08, scale = "log" }
coefficient_w_per_m2_k = { from = 5.0, to = 120.0, scale = "log" }
initial_pressure_pa = { from = 1.0e5, to = 8.0e5 }
"ambient.temperature_k" = { from = 270.0, to = 320.0 }
"""


@pytest.mark.parametrize("name", STUDIES)
def test_random_rows_agree_with_an_independent_integration(name, tmp_path, pneutherm):
    design, law, vary = STUDIES[name]
    seed = list(STUDIES).index(name)
    study = write(tmp_path, f'design = "{design}"\nsamples = 5000\nseed = {seed}\nfit = false', COMMON + vary, law)
    pneutherm("sweep", study, "-o", tmp_path / "out")
    rows = table(tmp_path / "out")
    for number in np.random.default_rng(seed).choice(rows.num_rows, 12, replace=False):
        row = {key: value[0] for key, value in rows.slice(int(number), 1).to_pydict().items()}
        for key, expected in integrated(row, law).items():
            assert row[key] == pytest.approx(expected, rel=1e-7), f"row {number}: {key}"


def integrated(row, law):
    """The row's results by scipy's DOP853 at rtol 1e-11."""
    effects = {}
    for key, value in row.items():
        *_, group, parameter = ["", "", *key.split(".")]
        if group and group not in ("ambient", "chamber"):
            effects.setdefault(group, {})[parameter] = value
    chamber = reference.Chamber(
        bore=row["bore_m"],
        dead_volume=row.get("dead_volume_m3", 2e-6),
        lambda0=row["coefficient_w_per_m2_k"],
        area_law=law,
        ambient_temperature=row["ambient.temperature_k"],
        gamma=row.get("heat_capacity_ratio", 1.4),
        effects=effects,
    )
    pressure, begin, end = row["initial_pressure_pa"], 0.1, row.get("final_stroke_m", 0.05)
    push, duration = row.get("push_time_s", 0.04), 3.0
    ambient = chamber.ambient_temperature
    start = row.get("initial_temperature_k", ambient)
    mass = pressure * chamber.volume(begin) / (chamber.gas_constant * start)
    y = np.array([pressure, mass, ambient, start, pressure])
    scale = np.array([pressure, mass, 300.0, 300.0, pressure])

    def integrate(y, span, position, speed):
        rates = lambda t, y: chamber.rates(y, position + speed * t, speed, 0.0)[0]
        run = solve_ivp(rates, (0, span), y, method="DOP853", rtol=1e-11, atol=1e-14 * scale, dense_output=True)
        assert run.success
        return run

    held = integrate(integrate(y, push, begin, (end - begin) / push).y[:, -1], duration - push, end, 0.0)
    volume = chamber.volume(end)
    temperature = lambda y: y[0] * volume / (y[1] * chamber.gas_constant)
    sign = 1 if end < begin else -1

    def extreme(quantity):
        """The largest (for an expansion the smallest) value of the hold, between the integrator's steps too."""
        values = [sign * quantity(held.sol(t)) for t in held.t]
        k = int(np.argmax(values))
        if 0 < k < len(values) - 1:
            bounds = (held.t[k - 1], held.t[k + 1])
            found = minimize_scalar(lambda t: -sign * quantity(held.sol(t)), bounds=bounds, method="bounded", options={"xatol": 1e-10})
            return sign * max(values[k], -found.fun)
        return sign * values[k]

    area = chamber.heat_area(end)
    return {
        "volume_m3": volume,
        "area_m2": area,
        "volume_to_area_m": volume / area,
        "pressure_peak_pa": extreme(lambda y: y[0]),
        "pressure_final_pa": held.y[0, -1],
        "temperature_peak_k": extreme(temperature),
        "temperature_final_k": temperature(held.y[:, -1]),
    }


def lasting(folder, pneutherm, seconds):
    """A study whose run takes about that long."""
    study = lambda samples: write(folder, f'design = "latin-hypercube"\nseed = 2\nparts = 16\nsamples = {samples}', COMMON)
    told = pneutherm("sweep", study(20_000), "-o", folder / "never", "--dry-run").stdout
    assert not (folder / "never").exists(), "a dry run writes nothing"
    rate = float(re.search(r"\((\d+) rows/s", told)[1])
    return study(int(max(rate * seconds, 2000)))


def test_three_kills_and_a_resume_give_the_same_rows_bit_for_bit(tmp_path, pneutherm):
    study = lasting(tmp_path, pneutherm, 4.0)
    killed, whole, sharded = tmp_path / "killed", tmp_path / "whole", tmp_path / "sharded"
    finished = lambda: len(list(killed.glob("part-*.parquet"))) if killed.exists() else 0
    for _ in range(3):
        before = finished()
        process = subprocess.Popen([PROGRAM, "sweep", study, "-o", killed], stdout=subprocess.DEVNULL)
        while finished() < before + 2 and process.poll() is None:
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, "the run was over before it was killed"
        assert not (killed / "manifest.json").exists()
    left_behind = list(killed.glob(".*.tmp"))
    pneutherm("sweep", study, "-o", killed)
    assert left_behind and not list(killed.glob(".*.tmp")), "temporary files of killed runs are removed"
    pneutherm("sweep", study, "-o", whole, "--jobs", 1)
    for index in np.random.default_rng(0).permutation(16):
        pneutherm("sweep", study, "-o", sharded, "--shard", f"{index}/16")
    expected = table(whole)
    for folder in (killed, sharded):
        assert table(folder).equals(expected)
        assert (folder / "manifest.json").exists()


def test_the_indices_of_a_saltelli_study_are_those_of_salib(tmp_path, pneutherm):
    from SALib.analyze import sobol

    names = ["bore_m", "initial_pressure_pa", "push_time_s"]
    vary = "bore_m = { from = 0.016, to = 0.063 }\ninitial_pressure_pa = { from = 1e5, to = 7e5 }\npush_time_s = { from = 0.02, to = 0.4 }"
    study = write(tmp_path, 'design = "saltelli"\nsamples = 512\nfit = false', vary)
    pneutherm("sweep", study, "-o", tmp_path / "out")
    rows = table(tmp_path / "out")
    assert rows.num_rows == 512 * 5
    ours = json.loads((tmp_path / "out" / "sensitivity.json").read_text())["outputs"]
    problem = {"num_vars": 3, "names": names, "bounds": [[0, 1]] * 3}
    for output in ["pressure_peak_pa", "temperature_peak_k", "volume_to_area_m"]:
        theirs = sobol.analyze(problem, rows[output].to_numpy(), calc_second_order=False, num_resamples=10, seed=1)
        for i, name in enumerate(names):
            assert ours[output]["first_order"][name]["value"] == pytest.approx(theirs["S1"][i], abs=1e-9)
            assert ours[output]["total_order"][name]["value"] == pytest.approx(theirs["ST"][i], abs=1e-9)


def test_a_table_from_pyarrow_is_a_design(tmp_path, pneutherm):
    bores = np.linspace(0.01, 0.06, 5000)
    pq.write_table(pa.table({"bore_m": bores, "initial_pressure_pa": np.arange(5000) + 100_000}), tmp_path / "points.parquet")
    study = write(tmp_path, 'design = "table"\ntable = "points.parquet"\nfit = false', "")
    pneutherm("sweep", study, "-o", tmp_path / "out")
    rows = table(tmp_path / "out")
    assert np.array_equal(rows["bore_m"].to_numpy(), bores)
    assert rows["initial_pressure_pa"][4999].as_py() == 104_999


def test_what_is_wrong_is_one_sentence_with_file_line_and_key(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "factorial"', "boer_m = { values = [0.02] }")
    error = pneutherm("sweep", study, "-o", tmp_path / "out", code=1).stderr
    assert error.count("\n") == 1 and "study.toml: line" in error and "did you mean `bore_m`?" in error
    assert not (tmp_path / "out").exists()
    study = write(tmp_path, 'design = "factorial"', "bore_m = { values = [0.02] }")
    (tmp_path / "file").write_text("")
    error = pneutherm("sweep", study, "-o", tmp_path / "file", code=1).stderr
    assert error.count("\n") == 1 and "cannot be written" in error
    pneutherm("sweep", study, "-o", tmp_path / "out", "--shard", "2/2", code=2)
    pneutherm("sweep", study, "-o", tmp_path / "out")
    other = write(tmp_path, 'design = "factorial"', "bore_m = { values = [0.03] }")
    error = pneutherm("sweep", other, "-o", tmp_path / "out", code=1).stderr
    assert "holds another study" in error and "vary" in error


def test_a_full_disk_is_one_sentence_and_leaves_no_half_file_of_a_final_name(tmp_path, pneutherm):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", disk], capture_output=True, text=True)
    if mounted.returncode:
        pytest.skip(f"a small file system cannot be mounted here: {mounted.stderr.strip()}")
    try:
        study = write(tmp_path, 'design = "sobol"\nsamples = 20000\nfit = false', COMMON)
        error = pneutherm("sweep", study, "-o", disk / "out", "--jobs", 1, code=1).stderr
        assert error.count("\n") == 1 and "No space left" in error and "run the same command again" in error
        for part in (disk / "out").glob("*.parquet"):
            pq.ParquetFile(part)
        assert not list((disk / "out").glob(".*.tmp")) and not (disk / "out" / "manifest.json").exists()
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_dask_cluster_finishes_a_study_though_a_worker_is_killed(tmp_path, pneutherm):
    distributed = pytest.importorskip("distributed")
    sys.path.insert(0, str(ROOT / "sweep"))
    import dask_sweep

    study = lasting(tmp_path, pneutherm, 4.0)
    folder = tmp_path / "out"
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            workers = client.run(os.getpid)
            done = []
            for count in dask_sweep.sweep(client, str(PROGRAM), str(study), str(folder), 16, ("--jobs", "1")):
                done.append(count)
                if count == 2:
                    os.kill(next(iter(workers.values())), signal.SIGKILL)
            assert done == list(range(1, 17))
            assert client.run(os.getpid) != workers, "no worker was lost"
    assert (folder / "manifest.json").exists()
    pneutherm("sweep", study, "-o", tmp_path / "whole")
    assert table(folder).equals(table(tmp_path / "whole"))
