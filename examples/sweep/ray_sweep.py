"""The shards of a study on a Ray cluster: python ray_sweep.py study.toml out 64   (paths or addresses all nodes share)"""
import os
import subprocess
import sys

import ray


@ray.remote(max_retries=3)
def shard(study, folder, index, count):
    command = ["pneutherm", "sweep", study, "-o", folder, "--shard", f"{index}/{count}", "--jobs", "1", "--progress", "none"]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stderr.strip() if done.returncode else ""


study, folder = (path if "://" in path else os.path.abspath(path) for path in sys.argv[1:3])
ray.init(log_to_driver=False)
waiting = [shard.remote(study, folder, index, int(sys.argv[3])) for index in range(int(sys.argv[3]))]
while waiting:
    (done,), waiting = ray.wait(waiting)
    if said := ray.get(done):
        sys.exit(said)
