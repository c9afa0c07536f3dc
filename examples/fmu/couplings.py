"""The couplings of a piston and its gas that are stable, and two that get worse with every delay, with FMPy.

    pip install fmpy
    python examples/fmu/couplings.py Chamber.fmu

A piston of 2 kg rests on gas of 6 bar, 20 mm from the end of its stroke, and is pushed away at 0.1 m/s. Friction of
20 N s/m and the heat that the gas loses bring it to rest again, if the coupling lets them. The master takes steps of 1 ms
and integrates the piston; `run` has a branch for each coupling. Printed is how far the piston swings in the last quarter
of a second.
"""

import collections
import shutil
import sys

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

MASS_KG, FRICTION_N_S_PER_M, SPEED_M_PER_S = 2.0, 20.0, 0.1
# The chamber, whatever the FMU's model has; a leak would let the piston sink.
START = {
    "bore": 0.025,
    "rodDiameter": 0.01,
    "deadVolume": 2e-6,
    "leakage.conductance": 0.0,
    "position": 0.02,
    "initialPressure": 6e5,
}
DURATION_S = 1.0
# strokeInput
POSITION_AND_VELOCITY, VELOCITY = 1, 2


def run(path, coupling, step=1e-3, late=0):
    """Positions of the piston after each step; `late`: by how many steps the force reaches the piston too late."""
    description, folder = read_model_description(path), extract(path)
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName=coupling
    )

    def put(values):
        fmu.setReal([references[name] for name in values], list(values.values()))

    def get(name):
        return fmu.getReal([references[name]])[0]

    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.setInteger([references["strokeInput"]], [VELOCITY if coupling == "velocity" else POSITION_AND_VELOCITY])
    put(START)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    x, v, course = START["position"], SPEED_M_PER_S, []
    load = get("force")
    forces = collections.deque([load] * late)
    for k in range(round(DURATION_S / step)):
        if coupling == "position again":
            # The outputs belong to the present inputs: the gas is where the piston is before the force is read.
            put({"position": x, "velocity": 0.0})
        forces.append(get("force"))
        v += step * (forces.popleft() - load - FRICTION_N_S_PER_M * v) / MASS_KG
        if coupling == "velocity":
            put({"velocity": v})
        elif coupling == "position and velocity":
            put({"position": x, "velocity": v})
        fmu.doStep(k * step, step)
        x = get("pistonPosition") if coupling == "velocity" else x + step * v
        course.append(x)
    fmu.terminate()
    fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return course


COUPLINGS = [
    ("velocity", 0),
    ("position and velocity", 0),
    ("position again", 0),
    ("position and velocity", 1),
    ("position and velocity", 2),
]


def swing(course):
    """From the lowest to the highest point in the last quarter, m."""
    last = course[-len(course) // 4 :]
    return max(last) - min(last)


def main(path):
    for coupling, late in COUPLINGS:
        delay = f", force {late} ms late" if late else ""
        print(f"{coupling}{delay}: swings by {1e3 * swing(run(path, coupling, late=late)):.3f} mm")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "Chamber.fmu")
