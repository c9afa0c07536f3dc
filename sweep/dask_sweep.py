#!/usr/bin/env python3
"""Run the shards of a pneutherm study on a Dask cluster, or on this machine when no scheduler is named.

    python dask_sweep.py study.toml -o out --shards 64 --scheduler tcp://head:8786

A shard is `pneutherm sweep --shard I/N`: it may be repeated, interrupted and run twice at once, so a lost worker costs
only the shards it was at. The study file, its model and the folder have to be where every worker finds them; a folder may
also be an address such as s3://bucket/study. What is wrong with a study is said once, and ends all shards.
"""

import argparse
import ctypes
import os
import signal
import subprocess
import sys
import time

from distributed import Client, LocalCluster, as_completed


def end_with_parent():
    """On Linux: the program ends when its worker does, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def shard(program, study, folder, index, count, options=()):
    """One shard, on a worker: nothing, or the program's own sentence where it refuses. Raises when it was killed."""
    command = [program, "sweep", study, "-o", folder, "--shard", f"{index}/{count}", "--progress", "none", *options]
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    try:
        process = subprocess.Popen(command, **pipes, preexec_fn=end_with_parent)
    except OSError as error:
        return f"{program}: cannot be started on a worker: {error.strerror}"
    try:
        said = process.communicate()[1].strip()
    finally:
        process.kill()
    if process.returncode < 0:
        raise RuntimeError(f"shard {index}/{count} was ended by signal {-process.returncode}")
    return (said or f"exit code {process.returncode}") if process.returncode else None


def anywhere(path):
    """A path that means the same in every working folder."""
    return path if "://" in path else os.path.abspath(path)


def sweep(client, program, study, folder, shards, options=(), retries=3):
    """All shards; yields the number that are done, as they end. A killed shard or lost worker is tried again; the first
    sentence of the program's ends them all and is raised."""
    study, folder = anywhere(study), anywhere(folder)
    futures = [
        client.submit(shard, program, study, folder, i, shards, options, retries=retries, pure=False)
        for i in range(shards)
    ]
    try:
        for done, future in enumerate(as_completed(futures), start=1):
            if said := future.result():
                raise SystemExit(said)
            yield done
    finally:
        client.cancel(futures)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("-o", "--output", required=True, metavar="DIR")
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--scheduler", help="address of a running cluster; without it, one on this machine")
    parser.add_argument("--jobs", type=int, default=1, help="threads of each shard (default 1)")
    parser.add_argument("--program", default="pneutherm", help="the program on the workers")
    arguments = parser.parse_args()
    cluster = None if arguments.scheduler else LocalCluster(threads_per_worker=1, dashboard_address=":0")
    begun = time.monotonic()
    try:
        with Client(arguments.scheduler or cluster) as client:
            options = ("--jobs", str(arguments.jobs))
            for done in sweep(client, arguments.program, arguments.study, arguments.output, arguments.shards, options):
                left = (time.monotonic() - begun) / done * (arguments.shards - done)
                print(f"{done} of {arguments.shards} shards, about {left:.0f} s left", file=sys.stderr)
    except KeyboardInterrupt:
        sys.exit("interrupted: finished parts are kept; run the same command again to go on")
    finally:
        if cluster:
            cluster.close()


if __name__ == "__main__":
    main()
