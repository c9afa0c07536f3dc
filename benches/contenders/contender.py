"""What a contender in Python speaks with the driver: `ready`, then seconds for `go ROWS`, and `save FILE`.

Solvers run in two processes, one for each core; each has the scenarios and solves its half of the rows.
"""

import json
import multiprocessing
import os
import sys
import time
from multiprocessing import shared_memory

import numpy as np
import scenario

PROCESSES = 2


def worker(number, prepare, path, options, name, pipe):
    sys.stdout = sys.stderr  # what a library prints is no answer
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[number % os.cpu_count()]})
    cases = scenario.read(path)
    memory = shared_memory.SharedMemory(name)
    answers = np.ndarray((len(cases), 2), buffer=memory.buf)
    solve = prepare(**options)
    pipe.send("ready")
    for rows in iter(pipe.recv, None):
        mine = slice(rows * number // PROCESSES, rows * (number + 1) // PROCESSES)
        answers[mine] = solve(cases[mine])
        pipe.send("done")
    memory.close()


def serve(prepare):
    """`prepare(**options)` gives a function from scenarios to peak and final pressure; called in each process."""
    path, options = sys.argv[1], json.loads(sys.argv[2]) if len(sys.argv) > 2 else {}
    rows = len(scenario.read(path))
    memory = shared_memory.SharedMemory(create=True, size=rows * 16)
    answers = np.ndarray((rows, 2), buffer=memory.buf)
    context = multiprocessing.get_context("spawn")
    pipes = []
    for number in range(PROCESSES):
        ours, theirs = context.Pipe()
        context.Process(target=worker, args=(number, prepare, path, options, memory.name, theirs), daemon=True).start()
        pipes.append(ours)
    try:
        for pipe in pipes:
            pipe.recv()
        print("ready", flush=True)
        solved = 0
        for line in sys.stdin:
            command, argument = line.split(maxsplit=1)
            if command == "go":
                solved = int(argument)
                begun = time.perf_counter()
                for pipe in pipes:
                    pipe.send(solved)
                for pipe in pipes:
                    pipe.recv()
                print(time.perf_counter() - begun, flush=True)
            else:
                answers[:solved].tofile(argument.strip())
                print("saved", flush=True)
        for pipe in pipes:
            pipe.send(None)
    finally:
        del answers
        memory.close()
        memory.unlink()
