#!/usr/bin/env python3
"""Run the shards of a pneutherm study on a Dask cluster, or on this machine when no scheduler is named.

    python dask_sweep.py study.toml -o out --shards 64 --scheduler tcp://head:8786

A shard is `pneutherm sweep --shard I/N`: it may be repeated, interrupted and run twice at once, so a lost worker costs
only the shards it was at. The study file, its model and the folder have to be where every worker finds them.
"""

import argparse
import subprocess
import sys
import time

from distributed import Client, LocalCluster, as_completed


def shard(program, study, folder, index, count, options=()):
    """One shard, on a worker; raises with the program's own sentence when it fails."""
    command = [program, "sweep", study, "-o", folder, "--shard", f"{index}/{count}", *options]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"shard {index}/{count}: {done.stderr.strip() or f'ended by signal {-done.returncode}'}")
    return index


def sweep(client, program, study, folder, shards, options=(), retries=3):
    """All shards; yields the number that are done, as they end. A failed shard or lost worker is tried again."""
    futures = [
        client.submit(shard, program, study, folder, i, shards, options, retries=retries, pure=False)
        for i in range(shards)
    ]
    for done, future in enumerate(as_completed(futures), start=1):
        future.result()
        yield done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("-o", "--output", required=True, metavar="DIR")
    parser.add_argument("--shards", type=int, default=16)
    parser.add_argument("--scheduler", help="address of a running cluster; without it, one on this machine")
    parser.add_argument("--jobs", type=int, default=1, help="threads of each shard (default 1)")
    parser.add_argument("--program", default="pneutherm", help="the program on the workers")
    arguments = parser.parse_args()
    cluster = None if arguments.scheduler else LocalCluster(threads_per_worker=1, dashboard_address=None)
    begun = time.monotonic()
    with Client(arguments.scheduler or cluster) as client:
        options = ("--jobs", str(arguments.jobs))
        for done in sweep(client, arguments.program, arguments.study, arguments.output, arguments.shards, options):
            left = (time.monotonic() - begun) / done * (arguments.shards - done)
            print(f"{done} of {arguments.shards} shards, about {left:.0f} s left", file=sys.stderr)
    if cluster:
        cluster.close()


if __name__ == "__main__":
    main()
