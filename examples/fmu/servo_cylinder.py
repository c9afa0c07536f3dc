"""A servo cylinder made of two chambers: the FMU twice, a piston with load and a simple valve between them, with FMPy.

    pip install fmpy numpy
    pneutherm fmu model.toml -o Chamber.fmu      # any model file
    python examples/fmu/servo_cylinder.py Chamber.fmu
"""

import math
import shutil
import sys

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STROKE_M, MASS_KG, FRICTION_N_S_PER_M = 0.2, 2.0, 60.0
SUPPLY_PA, AMBIENT_PA, AMBIENT_K = 7e5, 1.013e5, 293.0
CONDUCTANCE = 2e-9  # sonic conductance of the valve fully open, m3/(s Pa)
STEP_S = 1e-4


class Chamber:
    """One instance, by variable names."""

    def __init__(self, folder, description, name, **start):
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.set(**start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values):
        self.fmu.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, name):
        return self.fmu.getReal([self.references[name]])[0]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def through_valve(opening, upstream_pa, downstream_pa):
    """ISO 6358 mass flow, kg/s, with b = 0.3 and gas upstream at ambient temperature."""
    ratio = downstream_pa / upstream_pa
    psi = 1.0 if ratio <= 0.3 else math.sqrt(max(0.0, 1.0 - ((ratio - 0.3) / 0.7) ** 2))
    return opening * CONDUCTANCE * upstream_pa * 1.185 * psi if ratio < 1.0 else 0.0


def flows(opening, pressure_pa):
    """Flow in and out of a chamber whose port is opened to supply (positive) or exhaust (negative)."""
    if opening > 0.0:
        return through_valve(opening, SUPPLY_PA, pressure_pa), 0.0
    return 0.0, through_valve(-opening, pressure_pa, AMBIENT_PA)


def main(path):
    description, folder = read_model_description(path), extract(path)
    rest = dict(initialPressure=4e5, initialTemperature=AMBIENT_K, ambientPressure=AMBIENT_PA)
    left = Chamber(folder, description, "left", position=STROKE_M / 2, **rest)
    right = Chamber(folder, description, "right", position=STROKE_M / 2, **rest)
    x, v, target = STROKE_M / 2, 0.0, 0.13
    for k in range(round(2.0 / STEP_S)):
        opening = max(-1.0, min(1.0, 12.0 * (target - x) - 0.9 * v))
        for chamber, position, speed, port in ((left, x, v, opening), (right, STROKE_M - x, -v, -opening)):
            into, out = flows(port, chamber.get("pressure"))
            chamber.set(position=position, velocity=speed, massFlowIn=into, massFlowOut=out, temperatureIn=AMBIENT_K)
            chamber.fmu.doStep(k * STEP_S, STEP_S)
        acceleration = (left.get("force") - right.get("force") - FRICTION_N_S_PER_M * v) / MASS_KG
        x += v * STEP_S  # the stroke that both chambers have just made
        v += acceleration * STEP_S
        if k % 2000 == 0:
            print(f"t = {k * STEP_S:4.1f} s   x = {1e3 * x:6.2f} mm   p = {left.get('pressure') / 1e5:5.2f} | "
                  f"{right.get('pressure') / 1e5:5.2f} bar   T = {left.get('temperature'):5.1f} | {right.get('temperature'):5.1f} K")
    left.close()
    right.close()
    shutil.rmtree(folder, ignore_errors=True)
    print(f"reached {1e3 * x:.2f} mm of {1e3 * target:.0f} mm")
    return x


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "Chamber.fmu")
