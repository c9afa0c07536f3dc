#!/usr/bin/env python3
"""Copies one labelled case into examples/cylinder, the guide's example data.

    python3 examples/make_cylinder.py FOLDER_OF_THE_LABELLED_CASES [case03]

The case comes from a simulator that shares no code with this project (other language, other state variables, other
integrator) and has measurement noise, quantisation and a measured position with noise of its own. What was put in is
written to `answer.json`: look at it after you have tried yourself.
"""

import json
import shutil
import sys
from pathlib import Path

source = Path(sys.argv[1])
case = sys.argv[2] if len(sys.argv) > 2 else "case03"
target = Path(__file__).resolve().parent / "cylinder"
target.mkdir(exist_ok=True)
for file in sorted((source / case).iterdir()):
    shutil.copyfile(file, target / file.name)
answer = json.loads((source / "answers.json").read_text())[case]
answer["case"] = case
(target / "answer.json").write_text(json.dumps(answer, indent=1) + "\n")
print(f"{target}: {case}, {sum(f.stat().st_size for f in target.iterdir())} bytes")
