"""`pneutherm sweep -o s3://…`: a study in an object store, here a local S3 server, equals that in a folder."""

import signal
import subprocess
import time

import numpy as np
import pyarrow as pa
import pyarrow.dataset
import pyarrow.fs
import pyarrow.parquet as pq
import pytest

from conftest import PROGRAM
from test_sweep import COMMON, lasting, table, write


def has_object_stores():
    """Whether the program was built with the feature object-store: it then reports an incomplete address."""
    command = [PROGRAM, "sweep", "--verify", "s3://bucket"]
    return "object-store" not in subprocess.run(command, capture_output=True, text=True).stderr


def test_an_address_of_a_file_is_a_folder_and_other_addresses_are_refused(tmp_path, pneutherm):
    study = write(tmp_path, 'design = "sobol"\nsamples = 3000\nfit = false', COMMON)
    pneutherm("sweep", study, "-o", f"file://{tmp_path}/out")
    assert table(tmp_path / "out").num_rows == 3000
    assert "agree with manifest.json" in pneutherm("sweep", "--verify", f"file://{tmp_path}/out").stdout
    for place, sentence in [
        ("file://out", "expected file:///path with the whole path"),
        ("ftp://host/out", "expected a folder, file:///path or s3://bucket/prefix"),
        ("s3://bucket", "expected s3://bucket/prefix" if has_object_stores() else "--features object-store"),
    ]:
        error = pneutherm("sweep", study, "-o", place, cwd=tmp_path, code=1).stderr
        assert error.count("\n") == 1 and sentence in error, error
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.toml", "out", "study.toml"]


@pytest.fixture(scope="module")
def bucket():
    """A client of a local S3 server, its address, and the environment for the program."""
    if not has_object_stores():
        pytest.skip("the program is built without the feature object-store")
    server = pytest.importorskip("moto.server", reason='no local S3 server (pip install "moto[server]")')
    boto3 = pytest.importorskip("boto3")
    local = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    local.start()
    host, port = local.get_host_and_port()
    url = f"http://{host}:{port}"
    keys = {"AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret", "AWS_REGION": "us-east-1"}
    with pytest.MonkeyPatch.context() as environment:
        for name, value in {"AWS_ENDPOINT_URL": url, "AWS_DEFAULT_REGION": "us-east-1", **keys}.items():
            environment.setenv(name, value)
        s3 = boto3.client("s3", endpoint_url=url)
        s3.create_bucket(Bucket="studies")
        yield s3, url
    local.stop()


def objects(s3, prefix):
    """Names of the objects below a prefix of the bucket, without the prefix."""
    listed = s3.list_objects_v2(Bucket="studies", Prefix=prefix).get("Contents", [])
    return sorted(entry["Key"].removeprefix(prefix) for entry in listed)


def test_shards_into_an_object_store_are_the_study_of_a_folder(bucket, tmp_path, pneutherm):
    s3, _ = bucket
    body = lambda key: s3.get_object(Bucket="studies", Key=key)["Body"].read()
    study = write(tmp_path, 'design = "saltelli"\nsamples = 1000\nparts = 6\nfit = false', COMMON)
    study.write_text(study.read_text() + "[statistics]\n")
    for index in (1, 2, 0, 1):
        pneutherm("sweep", study, "-o", "s3://studies/a/b", "--shard", f"{index}/3")
    assert "agree with manifest.json" in pneutherm("sweep", "--verify", "s3://studies/a/b").stdout
    out = tmp_path / "out"
    pneutherm("sweep", study, "-o", out)
    whole = {path.relative_to(out).as_posix(): path for path in out.rglob("*") if path.is_file()}
    assert objects(s3, "a/b/") == sorted(whole)
    for name, path in whole.items():
        if name.startswith("rows/"):
            assert pq.read_table(pa.BufferReader(body(f"a/b/{name}"))).equals(pq.read_table(path))
        elif name.startswith(("statistics.", "sensitivity.")):
            assert body(f"a/b/{name}") == path.read_bytes()
    # A changed byte is detected by --verify, a missing part by the next run.
    part = next(name for name in whole if name.startswith("rows/"))
    s3.put_object(Bucket="studies", Key=f"a/b/{part}", Body=body(f"a/b/{part}")[:-1] + b"x")
    assert part in pneutherm("sweep", "--verify", "s3://studies/a/b", code=1).stderr
    s3.delete_object(Bucket="studies", Key=f"a/b/{part}")
    pneutherm("sweep", study, "-o", "s3://studies/a/b")
    pneutherm("sweep", "--verify", "s3://studies/a/b")
    error = pneutherm("sweep", study, "-o", "s3://nobody/a", code=1).stderr
    assert error.count("\n") == 1 and "s3://nobody/a" in error


def test_statistics_and_a_larger_study_come_from_an_object_store_as_from_a_folder(bucket, tmp_path, pneutherm):
    s3, _ = bucket
    body = lambda key: s3.get_object(Bucket="studies", Key=key)["Body"].read()
    small, large = (
        write(tmp_path, f'name = "grown"\ndesign = "sobol"\nsamples = {n}\nfit = false', COMMON, name=f"{n}.toml")
        for n in (3000, 9000)
    )
    pneutherm("sweep", small, "-o", "s3://studies/small")
    said = pneutherm("sweep", large, "-o", "s3://studies/large", "--extend", "s3://studies/small").stdout
    assert "3000 rows taken from s3://studies/small" in said
    pneutherm("sweep", large, "-o", tmp_path / "large")
    parts = [name for name in objects(s3, "large/") if name.startswith("rows/")]
    assert parts and all(body(f"large/{name}") == (tmp_path / "large" / name).read_bytes() for name in parts)
    # Statistics alone, and later those of stored rows.
    pneutherm("sweep", large, "-o", "s3://studies/summary", "--no-rows")
    large.write_text(large.read_text() + "[statistics]\n")
    pneutherm("sweep", large, "-o", "s3://studies/large")
    assert not any(name.startswith("rows/") for name in objects(s3, "summary/"))
    assert body("summary/statistics.json") == body("large/statistics.json")
    pneutherm("sweep", large, "-o", "s3://studies/large", "--traces", "0,7")
    traces = pq.read_table(pa.BufferReader(body("large/traces/traces.parquet")))
    assert set(traces["row"].to_pylist()) == {0, 7}


def test_a_part_of_several_uploads_is_whole_or_not_there(bucket, tmp_path, pneutherm):
    s3, _ = bucket
    study = write(tmp_path, 'design = "sobol"\nsamples = 200000\nparts = 1\nfit = false', COMMON)
    part = "pieces/rows/part-00000-of-00001.parquet"
    # Left behind by a run killed during the upload of a part: an upload that is never completed.
    upload = s3.create_multipart_upload(Bucket="studies", Key=part)["UploadId"]
    s3.upload_part(Bucket="studies", Key=part, UploadId=upload, PartNumber=1, Body=bytes(6 << 20))
    assert objects(s3, "pieces/") == []
    pneutherm("sweep", study, "-o", "s3://studies/pieces")
    assert s3.head_object(Bucket="studies", Key=part)["ContentLength"] > 8 << 20, "sent in one piece"
    assert "agree with manifest.json" in pneutherm("sweep", "--verify", "s3://studies/pieces").stdout


def test_without_credentials_one_sentence_says_which_are_missing(bucket, tmp_path, pneutherm, monkeypatch):
    study = write(tmp_path, 'design = "sobol"\nsamples = 3000\nfit = false', COMMON)
    monkeypatch.delenv("AWS_ACCESS_KEY_ID")
    error = pneutherm("sweep", study, "-o", "s3://studies/out", code=1).stderr
    assert error.count("\n") == 1 and "AccessKeyId" in error, error
    monkeypatch.delenv("AWS_SECRET_ACCESS_KEY")
    monkeypatch.setenv("AWS_METADATA_ENDPOINT", "http://127.0.0.1:9")  # no machine with a role
    error = pneutherm("sweep", study, "-o", "s3://studies/out", code=1).stderr
    assert error.count("\n") == 1 and "set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY" in error, error


def test_a_killed_study_in_an_object_store_goes_on_and_readers_take_its_rows(bucket, tmp_path, pneutherm):
    polars = pytest.importorskip("polars")
    s3, url = bucket
    study = lasting(tmp_path, pneutherm, 2.0)
    process = subprocess.Popen([PROGRAM, "sweep", study, "-o", "s3://studies/killed"], stdout=subprocess.DEVNULL)
    while len(objects(s3, "killed/rows/")) < 2 and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, "the run was over before it was killed"
    there = len(objects(s3, "killed/rows/"))
    assert "manifest.json" not in objects(s3, "killed/") and there < 16
    assert f"{there} parts existed already" in pneutherm("sweep", study, "-o", "s3://studies/killed").stdout
    pneutherm("sweep", study, "-o", tmp_path / "whole")
    expected = table(tmp_path / "whole")
    from_bucket = pa.fs.S3FileSystem(
        access_key="key", secret_key="secret", region="us-east-1", scheme="http", endpoint_override=url.removeprefix("http://")
    )
    assert pa.dataset.dataset("studies/killed/rows", filesystem=from_bucket).to_table().equals(expected)
    options = {"aws_access_key_id": "key", "aws_secret_access_key": "secret", "aws_region": "us-east-1"}
    options |= {"aws_endpoint_url": url, "aws_allow_http": "true"}
    frame = polars.scan_parquet("s3://studies/killed/rows/", storage_options=options).collect()
    assert np.array_equal(frame["pressure_peak_pa"].to_numpy(), expected["pressure_peak_pa"].to_numpy())
