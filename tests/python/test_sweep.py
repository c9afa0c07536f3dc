"""`pneutherm sweep`: its rows compared with an independent integration, its files in other tools, and their independence of
shards, threads and kills."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.dataset
import pyarrow.parquet as pq
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit, minimize_scalar

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
    return pa.dataset.dataset(folder / "rows").to_table()


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
    first = pq.ParquetFile(sorted((swept / "rows").iterdir())[0])
    metadata = {key.decode(): value.decode() for key, value in first.metadata.metadata.items()}
    assert json.loads(metadata["units"]) == units
    assert (metadata["seed"], metadata["shard"]) == ("5", "0/1")
    assert metadata["program_version"] and json.loads(metadata["study"])["name"] == "grid"
    manifest = json.loads((swept / "manifest.json").read_text())
    assert manifest["rows"] == rows.num_rows == sum(part["rows"] for part in manifest["parts"])
    assert sorted(part["file"] for part in manifest["parts"]) == sorted(f"rows/{p.name}" for p in (swept / "rows").iterdir())
    assert sum(manifest["statuses"].values()) == rows.num_rows


def test_continuous_columns_are_compressed_without_a_dictionary(swept):
    group = pq.ParquetFile(sorted((swept / "rows").iterdir())[0]).metadata.row_group(0)
    columns = {group.column(i).path_in_schema: group.column(i) for i in range(group.num_columns)}
    assert all(column.compression == "ZSTD" for column in columns.values())
    assert not columns["pressure_peak_pa"].has_dictionary_page
    assert "BYTE_STREAM_SPLIT" in columns["pressure_peak_pa"].encodings
    assert columns["status"].has_dictionary_page and columns["bore_m"].has_dictionary_page


def test_every_reader_takes_the_folder_of_rows_whole(swept):
    duckdb, pandas, polars = map(pytest.importorskip, ("duckdb", "pandas", "polars"))
    rows, table_of_all = swept / "rows", table(swept)
    frame = polars.scan_parquet(rows).collect()
    by_duckdb = duckdb.sql(f"select * from '{rows}/*.parquet' order by row").to_arrow_table()
    by_pandas = pandas.read_parquet(rows)
    assert pq.read_table(rows).equals(table_of_all)
    for name in ("row", "bore_m", "pressure_peak_pa", "energy_error"):
        expected = table_of_all[name].to_numpy()
        for found in (frame[name].to_numpy(), by_duckdb[name].to_numpy(), by_pandas[name].to_numpy()):
            assert np.array_equal(found, expected), name
    statuses = table_of_all["status"].to_pylist()
    assert frame["status"].to_list() == by_pandas["status"].tolist() == by_duckdb["status"].to_pylist() == statuses


def test_spark_takes_the_folder_of_rows_whole(swept):
    sql = pytest.importorskip("pyspark.sql", reason="PySpark is not installed (it needs a Java runtime)")
    spark = sql.SparkSession.builder.master("local[1]").config("spark.ui.enabled", "false").getOrCreate()
    try:
        assert spark.read.parquet(str(swept / "rows")).count() == 1560
    finally:
        spark.stop()


def test_readers_skip_row_groups_by_their_statistics(tmp_path, pneutherm):
    duckdb = pytest.importorskip("duckdb")
    vary = "bore_m = { from = 0.016, to = 0.063, count = 600 }\nfinal_stroke_m = { from = 0.03, to = 0.08, count = 500 }"
    study = write(tmp_path, 'design = "factorial"\nfit = false\nsolver = "exact"\nparts = 1', vary)
    pneutherm("sweep", study, "-o", tmp_path / "out")
    rows = pa.dataset.dataset(tmp_path / "out" / "rows")
    (fragment,) = rows.get_fragments()
    assert fragment.num_row_groups == 3
    for low, high, groups in [(0.0, 0.02, 1), (0.06, 1.0, 1), (0.03, 0.06, 3), (0.07, 1.0, 0)]:
        wanted = (pa.dataset.field("bore_m") > low) & (pa.dataset.field("bore_m") < high)
        assert sum(len(part.row_groups) for part in fragment.split_by_row_group(wanted)) == groups, (low, high)
    metadata = pq.ParquetFile(next((tmp_path / "out" / "rows").iterdir())).metadata
    for i in range(metadata.num_columns - 1):
        column = metadata.row_group(1).column(i)
        values = rows.to_table([column.path_in_schema])[0].to_numpy()[131072:262144]
        assert (column.statistics.min, column.statistics.max) == (np.nanmin(values), np.nanmax(values)), column.path_in_schema
    query = f"select count(*), max(bore_m) from '{tmp_path}/out/rows/*.parquet' where bore_m < 0.02"
    ((count, largest),) = duckdb.sql(query).fetchall()
    assert count % 500 == 0 and largest < 0.02


def test_the_status_of_a_row_group_is_in_its_statistics(swept):
    """A reader that searches for failed rows skips groups without any."""
    for part in sorted((swept / "rows").iterdir()):
        file = pq.ParquetFile(part)
        for k in range(file.num_row_groups):
            group = file.metadata.row_group(k)
            columns = {group.column(i).path_in_schema: group.column(i) for i in range(group.num_columns)}
            found = file.read_row_group(k, ["status"]).column("status").to_pylist()
            statistics = columns["status"].statistics
            assert (statistics.min, statistics.max) == (min(found), max(found))


def test_readers_find_a_damaged_page_by_its_checksum(swept, tmp_path):
    part = sorted((swept / "rows").iterdir())[0]
    metadata = pq.ParquetFile(part).metadata
    expected = pq.read_table(part, page_checksum_verification=True)
    assert expected.equals(pq.read_table(part))
    bytes_of = part.read_bytes()
    found = 0
    for group in range(metadata.num_row_groups):
        for i in range(metadata.num_columns):
            column = metadata.row_group(group).column(i)
            # The last byte of the chunk is the last one of a page's data.
            begin = column.dictionary_page_offset if column.has_dictionary_page else column.data_page_offset
            place = begin + column.total_compressed_size - 1
            damaged = bytearray(bytes_of)
            damaged[place] ^= 16
            (tmp_path / "damaged.parquet").write_bytes(damaged)
            with pytest.raises(OSError, match="(?i)crc|checksum"):
                pq.read_table(tmp_path / "damaged.parquet", page_checksum_verification=True)
            found += 1
    assert found >= 17


def test_damage_at_random_in_two_hundred_parts_is_found_by_verify_and_mended_by_a_second_run(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "sobol"\nsamples = 4000\nparts = 200\nfit = false\nsolver = "exact"', COMMON)
    out = tmp_path / "out"
    pneutherm("sweep", study, "-o", out)
    assert "agree with manifest.json" in pneutherm("sweep", "--verify", out).stdout
    before = table(out)
    random = np.random.default_rng(7)
    parts = sorted((out / "rows").iterdir())
    assert len(parts) == 200
    for part in parts:
        damaged = bytearray(part.read_bytes())
        damaged[random.integers(len(damaged))] ^= 1 << random.integers(8)
        part.write_bytes(damaged)
    error = pneutherm("sweep", "--verify", out, code=1).stderr
    assert error.count("\n") == 1 and "200 of 200 parts do not agree with manifest.json" in error
    assert "200 parts were damaged and have been recomputed" in pneutherm("sweep", study, "-o", out).stdout
    pneutherm("sweep", "--verify", out)
    assert table(out).equals(before)


# Random studies: each with its design, area law and varied quantities.
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
    "a wall that remembers": (
        "sobol",
        "total",
        "wall_conduction.inverse_effusivity_m2_k_per_w_s05 = { from = 5e-4, to = 2e-2 }",
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
    """The row's results from scipy's DOP853 at rtol 1e-11."""
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
    y, scale = chamber.at_rest(pressure, mass, start)

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
        """The maximum (for an expansion the minimum) during the hold, also between the integrator's steps."""
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
    """A study whose run takes about that many seconds."""
    study = lambda samples: write(folder, f'design = "latin-hypercube"\nseed = 2\nparts = 16\nsamples = {samples}', COMMON)
    told = pneutherm("sweep", study(20_000), "-o", folder / "never", "--dry-run").stdout
    assert not (folder / "never").exists(), "a dry run writes nothing"
    rate = float(re.search(r"\((\d+) rows/s", told)[1])
    return study(int(max(rate * seconds, 2000)))


def test_three_kills_and_a_resume_give_the_same_rows_bit_for_bit(tmp_path, pneutherm):
    study = lasting(tmp_path, pneutherm, 4.0)
    killed, whole, sharded = tmp_path / "killed", tmp_path / "whole", tmp_path / "sharded"
    finished = lambda: len(list(killed.glob("rows/*.parquet")))
    for _ in range(3):
        before = finished()
        process = subprocess.Popen([PROGRAM, "sweep", study, "-o", killed], stdout=subprocess.DEVNULL)
        while finished() < before + 2 and process.poll() is None:
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, "the run was over before it was killed"
        assert not (killed / "manifest.json").exists()
    left_behind = list(killed.glob("*/.*.tmp"))
    pneutherm("sweep", study, "-o", killed)
    assert left_behind and not list(killed.glob("*/.*.tmp")), "temporary files of killed runs are removed"
    pneutherm("sweep", study, "-o", whole, "--jobs", 1)
    for index in np.random.default_rng(0).permutation(16):
        pneutherm("sweep", study, "-o", sharded, "--shard", f"{index}/16")
    expected = table(whole)
    for folder in (killed, sharded):
        assert table(folder).equals(expected)
        assert (folder / "manifest.json").exists()


def saltelli(folder, pneutherm, keys=""):
    """A Saltelli study of 512 samples: the names of its quantities, its rows, its indices, and the problem in SALib's form."""
    ranges = {"bore_m": (0.016, 0.063), "initial_pressure_pa": (1e5, 7e5), "push_time_s": (0.02, 0.4)}
    vary = "\n".join(f"{name} = {{ from = {low}, to = {high} }}" for name, (low, high) in ranges.items())
    study = write(folder, f'design = "saltelli"\nsamples = 512\nfit = false\n{keys}', vary)
    pneutherm("sweep", study, "-o", folder / "out")
    ours = json.loads((folder / "out" / "sensitivity.json").read_text())["outputs"]
    problem = {"num_vars": len(ranges), "names": list(ranges), "bounds": [[0, 1]] * len(ranges)}
    return list(ranges), table(folder / "out"), ours, problem


def test_the_indices_of_a_saltelli_study_are_those_of_salib(tmp_path, pneutherm):
    from SALib.analyze import sobol

    names, rows, ours, problem = saltelli(tmp_path, pneutherm)
    assert rows.num_rows == 512 * 5
    picture = xml.etree.ElementTree.parse(tmp_path / "out" / "sensitivity.svg")
    texts = "".join(picture.getroot().itertext())
    assert all(word in texts for word in [*names, "pressure_peak_pa", "first order", "total order"])
    for output in ["pressure_peak_pa", "temperature_peak_k", "volume_to_area_m"]:
        theirs = sobol.analyze(problem, rows[output].to_numpy(), calc_second_order=False, num_resamples=10, seed=1)
        for i, name in enumerate(names):
            assert ours[output]["first_order"][name]["value"] == pytest.approx(theirs["S1"][i], abs=1e-9)
            assert ours[output]["total_order"][name]["value"] == pytest.approx(theirs["ST"][i], abs=1e-9)


def test_indices_of_second_order_are_salib_s_and_intervals_those_of_its_scatter_between_replicates(tmp_path, pneutherm):
    from SALib.analyze import sobol
    from scipy.stats import t as student

    names, rows, ours, problem = saltelli(tmp_path, pneutherm, "second_order = true")
    assert rows.num_rows == 512 * 8
    analyze = lambda values: sobol.analyze(problem, values, num_resamples=2, seed=1)
    for output in ["pressure_peak_pa", "temperature_peak_k"]:
        values = rows[output].to_numpy()
        theirs = analyze(values)
        # Block k belongs to replicate k mod 16: the jackknife leaves out one of the sixteen at a time.
        replicate = np.arange(len(values)) // 8 % 16
        without = [analyze(values[replicate != number]) for number in range(16)]

        def half_width(pick):
            found = np.array([pick(indices) for indices in without])
            return student.ppf(0.975, 15) * np.sqrt(15 / 16 * np.sum((found - found.mean()) ** 2))

        def check(index, pick):
            assert index["value"] == pytest.approx(pick(theirs), abs=1e-9)
            # SALib centres values on the mean of those left.
            assert index["ci95"] == pytest.approx(half_width(pick), rel=0.02, abs=1e-9)

        pairs = {tuple(entry["quantities"]): entry for entry in ours[output]["second_order"]}
        assert len(pairs) == 3
        for i, name in enumerate(names):
            check(ours[output]["first_order"][name], lambda indices: indices["S1"][i])
            check(ours[output]["total_order"][name], lambda indices: indices["ST"][i])
            for j in range(i + 1, 3):
                check(pairs[name, names[j]], lambda indices: indices["S2"][i, j])


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
    assert error.count("\n") == 1 and "file: " in error and "it is a file, not a folder" in error
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
        note, error = error.splitlines()
        assert re.search(r"^note: .*out: the rows take up to [\d.]+ MiB, and the disk has 256.00 KiB left$", note), note
        assert "No space left" in error and "run the same command again" in error
        for part in (disk / "out" / "rows").glob("*.parquet"):
            pq.ParquetFile(part)
        assert not list((disk / "out").glob("*/.*.tmp")) and not (disk / "out" / "manifest.json").exists()
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


def on_path():
    """An environment whose PATH starts with the program under test."""
    return os.environ | {"PATH": f"{PROGRAM.resolve().parent}{os.pathsep}{os.environ['PATH']}"}


def children(name):
    """Processes of this machine that run the program on a file of that name."""
    listed = subprocess.run(["ps", "-ww", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    return [line for line in listed.splitlines() if "dask_sweep" not in line and str(name) in line]


def test_the_dask_runner_takes_relative_paths_and_says_what_is_wrong_once(tmp_path, pneutherm):
    pytest.importorskip("distributed")
    runner = [sys.executable, ROOT / "sweep/dask_sweep.py", "study.toml", "-o", "out", "--shards", "4"]
    write(tmp_path, 'design = "sobol"\nsamples = 4000\nfit = false', COMMON)
    run = lambda: subprocess.run(runner, cwd=tmp_path, env=on_path(), capture_output=True, text=True, timeout=120)
    done = run()
    assert done.returncode == 0 and "4 of 4 shards" in done.stderr, done.stderr
    pneutherm("sweep", "--verify", tmp_path / "out")
    write(tmp_path, 'design = "sobol"\nsamples = 4000\nfit = false', "boer_m = { from = 0.01, to = 0.02 }")
    done = run()
    assert done.returncode == 1 and done.stderr.count("did you mean `bore_m`?") == 1, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="a program that ends with its parent is Linux's")
def test_the_programs_of_a_dask_runner_end_with_it(tmp_path, pneutherm):
    pytest.importorskip("distributed")
    study = lasting(tmp_path, pneutherm, 20.0)
    command = [sys.executable, ROOT / "sweep/dask_sweep.py", study, "-o", tmp_path / "out", "--shards", "4"]
    process = subprocess.Popen(
        command, env=on_path(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    until = time.monotonic() + 120
    while not children(study) and process.poll() is None and time.monotonic() < until:
        time.sleep(0.05)
    assert children(study), "no shard was begun"
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=120)[1]
    assert "run the same command again to go on" in said and process.returncode == 1
    while children(study) and time.monotonic() < until:
        time.sleep(0.05)
    assert not children(study)


def test_a_ray_cluster_makes_the_same_study(tmp_path, pneutherm):
    pytest.importorskip("ray", reason="Ray is not installed (pip install ray)")
    write(tmp_path, 'design = "sobol"\nsamples = 4000\nfit = false', COMMON)
    run = lambda: subprocess.run(
        [sys.executable, ROOT / "examples/sweep/ray_sweep.py", "study.toml", "out", "4"],
        cwd=tmp_path, env=on_path(), capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    done = run()
    assert done.returncode == 0, done.stderr
    pneutherm("sweep", tmp_path / "study.toml", "-o", tmp_path / "whole")
    assert table(tmp_path / "out").equals(table(tmp_path / "whole"))
    write(tmp_path, 'design = "sobol"\nsamples = 4000\nfit = false', "boer_m = { from = 0.01, to = 0.02 }")
    done = run()
    assert done.returncode == 1 and done.stderr.count("did you mean `bore_m`?") == 1, done.stderr


def test_a_study_grows_without_solving_its_rows_again(tmp_path, pneutherm):
    small = write(tmp_path, 'design = "sobol"\nsamples = 3000\nfit = false', COMMON, name="small.toml")
    large = write(tmp_path, 'design = "sobol"\nname = "small"\nsamples = 10000\nfit = false', COMMON, name="large.toml")
    pneutherm("sweep", small, "-o", tmp_path / "small")
    told = pneutherm("sweep", large, "-o", tmp_path / "grown", "--extend", tmp_path / "small", "--progress", "json")
    assert "7000 rows in" in told.stdout and f"3000 rows taken from {tmp_path / 'small'}" in told.stdout
    last = json.loads(told.stderr.splitlines()[-1])
    assert (last["rows_done"], last["rows_found"], last["seconds_left"]) == (10000, 3000, 0)
    pneutherm("sweep", large, "-o", tmp_path / "whole")
    files = lambda folder: {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert files(tmp_path / "grown") == files(tmp_path / "whole")


def test_what_cannot_be_is_said_before_any_row_is_solved(tmp_path, pneutherm):
    vary = 'bore_m = { from = 0.016, to = 0.063, count = 40 }\n"effect.leakage.conductance_m3_per_s_pa" = { values = [1e-12] }'
    study = write(tmp_path, 'design = "factorial"', vary)
    for arguments, sentence in [
        (["--traces", "40"], "a trace of row 40 is asked for; the study's rows are 0 to 39"),
        (["--traces", "0", "--trace-rate", "0"], "the trace rate is 0 Hz"),
        (["--traces", "0", "--trace-rate", "1e9"], "ask for a lower rate"),
    ]:
        error = pneutherm("sweep", study, "-o", tmp_path / "out", *arguments, code=1).stderr
        assert error.count("\n") == 1 and sentence in error
        assert not (tmp_path / "out").exists()
    for jobs in ("0", "1025", "100000", "-1", "two"):
        pneutherm("sweep", study, "-o", tmp_path / "out", f"--jobs={jobs}", code=2)
    pneutherm("sweep", code=2)


def test_a_shard_without_parts_says_so(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "factorial"', "bore_m = { values = [0.02] }")
    told = pneutherm("sweep", study, "-o", tmp_path / "out", "--shard", "3/4").stdout
    assert "shard 3/4 has nothing to do: the study has 1 part" in told and told.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_progress_as_json_counts_up_to_all_rows(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "sobol"\nsamples = 3000\nparts = 4\nfit = false', COMMON)
    for found in (0, 1500):
        lines = pneutherm("sweep", study, "-o", tmp_path / "out", "--progress", "json").stderr.splitlines()
        last = json.loads(lines[-1])
        assert (last["rows_done"], last["rows"], last["rows_found"]) == (3000, 3000, found)
        assert last["rows_per_second"] > 0 and last["seconds_left"] == 0
        for part in sorted((tmp_path / "out" / "rows").iterdir())[:2]:
            part.unlink()
    told = pneutherm("sweep", study, "-o", tmp_path / "out", "--progress", "none")
    assert told.stderr == "" and "2 parts existed already" in told.stdout


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_says_how_to_go_on(tmp_path, pneutherm):
    study = lasting(tmp_path, pneutherm, 4.0)
    process = subprocess.Popen([PROGRAM, "sweep", study, "-o", tmp_path / "out"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while len(list((tmp_path / "out").glob("rows/*"))) < 1 and process.poll() is None:
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "finished parts are kept; run the same command again to continue" in error and error.count("\n") == 1
    pneutherm("sweep", study, "-o", tmp_path / "out")
    assert (tmp_path / "out" / "manifest.json").exists()


@pytest.mark.alone
def test_the_estimate_is_right_where_one_end_of_an_axis_is_slow(tmp_path, pneutherm):
    # Sealed rows take a hundredth of the time of leaky ones, and all leaky rows come last.
    leaks = ", ".join(["0.0"] * 19 + ["1e-12"])
    vary = f'"effect.leakage.conductance_m3_per_s_pa" = {{ values = [{leaks}] }}\nbore_m = {{ from = 0.016, to = 0.063, count = 15000 }}'
    study = write(tmp_path, 'design = "factorial"\nfit = false', vary)
    told = pneutherm("sweep", study, "-o", tmp_path / "out", "--dry-run", "--jobs", 1).stdout
    estimated = float(re.search(r"\((\d+) rows/s", told)[1])
    told = pneutherm("sweep", study, "-o", tmp_path / "out", "--jobs", 1).stdout
    assert 0.2 < estimated / float(re.search(r"\((\d+) rows/s", told)[1]) < 5


def test_a_study_that_its_disk_has_no_room_for_is_told_so(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "sobol"\nsamples = 1_000_000_000_000\nfit = false', COMMON)
    told = pneutherm("sweep", study, "-o", tmp_path / "not" / "yet", "--dry-run").stderr
    assert re.search(r"note: .*not/yet: the rows take about [\d.]+ TiB, and the disk has [\d.]+ \wiB left", told), told
    for arguments in (["--no-rows"], ["--shard", "0/1000000"]):
        assert "disk" not in pneutherm("sweep", study, "-o", tmp_path / "not" / "yet", "--dry-run", *arguments).stderr


def test_quantiles_of_numbers_that_lie_close_together_are_as_close_to_the_exact_ones(tmp_path, pneutherm):
    # About 1e6 Pa with a 95 % width of less than a thousandth of it.
    study = write(tmp_path, 'design = "sobol"\nsamples = 100_000\nfit = false', "")
    vary = '[vary]\ninitial_pressure_pa = { distribution = "normal", mean = 5e5, sd = 100.0 }\n[statistics]\nquantiles = [0.025, 0.975]\n'
    study.write_text(study.read_text().replace("initial_pressure_pa = 1.01e5\n", "").replace("[vary]\n", vary))
    pneutherm("sweep", study, "-o", tmp_path / "out")
    column = json.loads((tmp_path / "out" / "statistics.json").read_text())["columns"]["pressure_final_pa"]
    values = table(tmp_path / "out")["pressure_final_pa"].to_numpy()
    low, high = np.quantile(values, [0.025, 0.975])
    found = [quantile["value"] for quantile in column["quantiles"]]
    assert 100.0 < high - low < 1e-3 * low
    assert abs(found[0] - low) < 1e-3 * (high - low) > abs(found[1] - high), (column["quantiles"], low, high)


def test_both_ways_of_varying_volume_over_area_have_an_axis(tmp_path, pneutherm):
    effect = "\n[effect.gas_column_length]\nexponent = -0.5\nreference_length_m = 0.1\n"
    trends = {}
    for name in ("volume_to_area_m", "volume_to_area_by_length_m"):
        study = write(tmp_path, 'design = "factorial"', f"{name} = {{ from = 0.0031, to = 0.0045, count = 6 }}")
        (tmp_path / "model.toml").write_text(MODEL.format(law="total") + effect)
        pneutherm("sweep", study, "-o", tmp_path / name)
        rows = table(tmp_path / name).to_pydict()
        for i, wanted in enumerate(rows[name]):
            assert rows["volume_m3"][i] / rows["area_m2"][i] == pytest.approx(wanted, rel=1e-12)
        trends[name] = rows
    by_bore, by_length = trends["volume_to_area_m"], trends["volume_to_area_by_length_m"]
    assert np.all(np.diff(by_bore["bore_m"]) > 0) and "final_stroke_m" not in by_bore
    assert np.all(np.diff(by_length["final_stroke_m"]) > 0) and "bore_m" not in by_length
    # design.md, finding 8: with the length varied at a bore the coefficient falls as in table 5; with the bore varied at a
    # length it rises.
    assert np.all(np.diff(by_length["lambda0_w_per_m2_k"]) < 0)
    assert np.all(np.diff(by_bore["lambda0_w_per_m2_k"]) > 0)


def test_statistics_without_rows_are_numpys(tmp_path, pneutherm):
    statistics = "\n[statistics]\nquantiles = [0.0, 0.001, 0.05, 0.5, 0.95, 1.0]\n"
    leak = '"effect.leakage.conductance_m3_per_s_pa" = { values = [0.0, 1e-12] }'
    study = write(tmp_path, 'design = "sobol"\nsamples = 20000\nparts = 8\nfit = false', COMMON + leak)
    pneutherm("sweep", study, "-o", tmp_path / "rows")
    study.write_text(study.read_text() + statistics)
    told = pneutherm("sweep", study, "-o", tmp_path / "none", "--no-rows").stdout
    assert "results: statistics.json" in told and not list((tmp_path / "none").rglob("*.parquet"))
    picture = xml.etree.ElementTree.parse(tmp_path / "none" / "statistics.svg")
    assert "results: statistics.svg" in told and "temperature_peak_k, K" in "".join(picture.getroot().itertext())
    found = json.loads((tmp_path / "none" / "statistics.json").read_text())
    rows = table(tmp_path / "rows")
    assert found["rows"] == rows.num_rows == sum(found["statuses"].values())
    for name, column in found["columns"].items():
        values = rows[name].to_numpy()
        assert column["nulls"] == np.isnan(values).sum()
        finite = values[~np.isnan(values)]
        assert column["count"] == len(finite)
        assert column["mean"] == pytest.approx(finite.mean(), rel=1e-12)
        assert column["variance"] == pytest.approx(finite.var(ddof=1), rel=1e-9)
        assert values[column["maximum"]["row"]] == column["maximum"]["value"] == finite.max()
        for quantile in column["quantiles"]:
            exact = np.quantile(finite, quantile["probability"])
            assert abs(quantile["value"] - exact) <= quantile["error_bound"] + 1e-14 * abs(exact), (name, quantile, exact)
            assert quantile["error_bound"] == 0 or len(np.unique(finite)) > 4096, (name, quantile)
    # The same for existing rows, in shards, and repeated: nothing is solved again.
    assert "0 rows in" in pneutherm("sweep", study, "-o", tmp_path / "rows").stdout
    for index in (1, 2, 0):
        pneutherm("sweep", study, "-o", tmp_path / "shards", "--no-rows", "--shard", f"{index}/3")
    expected = (tmp_path / "none" / "statistics.json").read_bytes()
    assert all((tmp_path / name / "statistics.json").read_bytes() == expected for name in ("rows", "shards"))


def test_quantiles_of_ten_million_rows_are_numpys_within_their_bound(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "sobol"\nsamples = 10_000_000\nfit = false', COMMON)
    study.write_text(study.read_text() + "\n[statistics]\nquantiles = [0.0, 1e-6, 0.01, 0.25, 0.5, 0.9, 0.999999, 1.0]\n")
    pneutherm("sweep", study, "-o", tmp_path / "out")
    found = json.loads((tmp_path / "out" / "statistics.json").read_text())["columns"]
    assert set(found) > {"pressure_peak_pa", "temperature_final_k", "settling_time_s", "volume_m3"}
    for name, column in found.items():
        values = pq.read_table(tmp_path / "out" / "rows", columns=[name])[name].drop_null().to_numpy()
        assert len(values) == column["count"] and column["count"] + column["nulls"] == 10_000_000
        exact = np.quantile(values, [quantile["probability"] for quantile in column["quantiles"]])
        for quantile, exact in zip(column["quantiles"], exact, strict=True):
            assert abs(quantile["value"] - exact) <= quantile["error_bound"] + 1e-14 * abs(exact), (name, quantile, exact)
            assert quantile["error_bound"] <= 4.89e-4 * abs(exact), (name, quantile)
        assert column["mean"] == pytest.approx(values.mean(), rel=1e-12)
    shutil.rmtree(tmp_path / "out")


def test_drawn_quantities_have_the_quantiles_moments_and_correlations_of_scipy(tmp_path, pneutherm):
    import scipy.stats as st

    measured = [0.051, 0.048, 0.055, 0.0505, 0.052]
    vary = f"""bore_m = {{ distribution = "normal", mean = 0.02, sd = 1e-3 }}
dead_volume_m3 = {{ distribution = "normal", mean = 1e-6, sd = 2e-6, from = 5e-7, to = 4e-6 }}
coefficient_w_per_m2_k = {{ distribution = "log-normal", median = 30.0, sd_log = 0.4 }}
ambient.temperature_k = {{ distribution = "log-normal", mean = 293.0, sd = 5.0, from = 285.0 }}
push_time_s = {{ distribution = "triangular", from = 0.03, mode = 0.035, to = 0.06 }}
initial_pressure_pa = {{ distribution = "uniform", from = 1e5, to = 7e5 }}
final_stroke_m = {{ distribution = "empirical", values = {measured} }}"""
    test = write(tmp_path, 'design = "sobol"\nsamples = 8192\nseed = 3\nfit = false', vary)
    pneutherm("sweep", test, "-o", tmp_path / "out")
    rows = table(tmp_path / "out").to_pandas()
    sd_log = np.sqrt(np.log1p((5 / 293) ** 2))
    log_normal = st.lognorm(sd_log, scale=293 / np.exp(sd_log**2 / 2))
    assert np.isclose(log_normal.mean(), 293) and np.isclose(log_normal.std(), 5)
    below = log_normal.cdf(285)
    expected = {
        "bore_m": st.norm(0.02, 1e-3).ppf,
        "dead_volume_m3": st.truncnorm((5e-7 - 1e-6) / 2e-6, (4e-6 - 1e-6) / 2e-6, 1e-6, 2e-6).ppf,
        "coefficient_w_per_m2_k": st.lognorm(0.4, scale=30).ppf,
        "ambient.temperature_k": lambda u: log_normal.ppf(below + u * (1 - below)),
        "push_time_s": st.triang(5 / 30, 0.03, 0.03).ppf,
        "initial_pressure_pa": st.uniform(1e5, 6e5).ppf,
        "final_stroke_m": lambda u: np.quantile(measured, u),
    }
    shares = []
    for name, ppf in expected.items():
        # Of 8192 scrambled points, one lies in each 8192th of the probability: every value is known to within its slice.
        values = np.sort(rows[name])
        slices = ppf(np.arange(8193) / 8192)
        span = np.ptp(values)
        assert (values >= slices[:-1] - 1e-12 * span).all() and (values <= slices[1:] + 1e-12 * span).all(), name
        shares.append(rows[name].rank())
    correlation = np.corrcoef(shares) - np.eye(len(shares))
    assert abs(correlation).max() < 0.03, "independent axes"


def test_the_pareto_front_is_the_rows_that_no_other_betters(tmp_path, pneutherm):
    vary = 'bore_m = { from = 0.016, to = 0.063 }\npush_time_s = { from = 0.02, to = 0.4 }\nfinal_stroke_m = { from = 0.03, to = 0.08 }'
    study = write(tmp_path, 'design = "sobol"\nsamples = 3000\nfit = false', vary)
    front = 'pareto = { minimise = ["settling_time_s"], maximise = ["pressure_peak_pa", "volume_m3"] }'
    study.write_text(study.read_text() + f"[statistics]\n{front}\n")
    pneutherm("sweep", study, "-o", tmp_path / "out")
    rows = table(tmp_path / "out").to_pandas().set_index("row")
    goals = rows[["settling_time_s", "pressure_peak_pa", "volume_m3"]].dropna() * [1, -1, -1]
    points = goals.to_numpy()
    bettered = [((points <= point).all(axis=1) & (points < point).any(axis=1)).any() for point in points]
    expected = set(goals.index[~np.array(bettered)])
    found = json.loads((tmp_path / "out" / "statistics.json").read_text())["pareto"]
    assert found["complete"] and {point["row"] for point in found["points"]} == expected and 5 < len(expected) < 2000
    for point in found["points"]:
        row = rows.loc[point["row"]]
        assert all(row[name] == value for name, value in (point["values"] | point["at"]).items())
    # The same without rows, merged from the parts.
    pneutherm("sweep", study, "-o", tmp_path / "summary", "--no-rows")
    assert json.loads((tmp_path / "summary" / "statistics.json").read_text())["pareto"] == found


# Knots of a curve of the reading, and the pressure added there, Pa: one that preserves relaxations, and one that folds the
# record.
CURVES = {
    "bent": ([1e5, 2.0e5, 2.2e5, 3.5e5, 4.0e5], [1e3, 3e3, 4e3, 5e3, 7e3]),
    "folded": ([1e5, 2.0e5, 2.2e5, 3.5e5, 4.0e5], [1e3, 9e3, -2e4, 5e3, -6e4]),
}


@pytest.mark.parametrize("lag", [0.0, 2e-3])
@pytest.mark.parametrize("curve", CURVES)
def test_a_curve_of_the_reading_is_in_the_results_as_in_dense_time_series(tmp_path, pneutherm, curve, lag):
    study = write(tmp_path, 'design = "factorial"', "initial_pressure_pa = { values = [1.01e5, 1.8e5] }")
    study.write_text(study.read_text().replace("duration_s = 3.0", "duration_s = 6.0"))
    (knots, values), rate = CURVES[curve], 100_000
    with open(tmp_path / "model.toml", "a") as model:
        model.write(f'[effect.empirical]\nbalance = "reading"\nvariable = "pressure"\nknots = {knots}\nvalues = {values}\n')
        if lag > 0.0:
            model.write(f"[effect.sensor_lag]\ntime_constant_s = {lag}\n")
    pneutherm("sweep", study, "-o", tmp_path / "out", "--traces", "0-1", "--trace-rate", rate)
    rows, traces = table(tmp_path / "out"), pq.read_table(tmp_path / "out/traces/traces.parquet")
    for row in range(2):
        trace = traces.filter(pyarrow.compute.equal(traces["row"], row))
        gas, shown, time = (trace[name].to_numpy() for name in ["gas_pressure_pa", "pressure_pa", "time_s"])
        if lag == 0.0:
            assert np.allclose(shown, gas + np.interp(gas, knots, values), rtol=1e-12)
        shown, time = shown[time > 0.04 - 1e-9], time[time > 0.04 - 1e-9] - 0.04
        ours = {name: rows[name][row].as_py() for name in rows.column_names}
        peak, final = np.max(shown), shown[-1]
        assert ours["pressure_final_pa"] == pytest.approx(final, rel=1e-8)
        assert ours["pressure_peak_pa"] == pytest.approx(peak, rel=1e-5)
        outside = np.flatnonzero(np.abs(shown - final) > 0.01 * (peak - final))
        assert ours["settling_time_s"] == pytest.approx(time[outside[-1]], abs=2 / rate)
        if curve == "bent":
            record = shown[:: rate // 100]
            record = record[np.argmax(record) :]
            at, guess = np.arange(len(record)) / 100, [record[-1], record[0] - record[-1], 0.3]
            found = curve_fit(lambda t, end, rise, tau: end + rise * np.exp(-t / tau), at, record, guess)[0]
            assert ours["status"] == "ok" and ours["time_constant_s"] == pytest.approx(found[2], rel=1e-5)
