"""A servo cylinder: the FMUs of its two sides, a piston with load between them, valves at their ports, with FMPy.

    pip install fmpy numpy
    pneutherm fmu model.toml -o CapSide.fmu          # any model file
    pneutherm fmu rod_side.toml -o RodSide.fmu       # the same with rod_m, or the same file again
    python examples/fmu/servo_cylinder.py CapSide.fmu RodSide.fmu
    python examples/fmu/servo_cylinder.py CapSide.fmu RodSide.fmu --steps     # what step the coupling needs

The valve opens a port of each chamber; the flow is solved inside, with the gas. The piston's velocity drives the strokes
(`strokeInput` = velocity): velocity in, force out, no iteration.
"""

import shutil
import sys

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STROKE_M, MASS_KG, FRICTION_N_S_PER_M = 0.2, 2.0, 60.0
SUPPLY_PA, AMBIENT_PA, AMBIENT_K = 7e5, 1.013e5, 293.0
CONDUCTANCE = 2e-9  # sonic conductance of the valve fully open, m3/(s Pa)
TARGET_M, DURATION_S, STEP_S = 0.13, 2.0, 1e-3
VELOCITY = 2  # strokeInput
# Both sides at rest in the middle, SI units.
REST = dict(
    initialPressure=4e5,
    initialTemperature=AMBIENT_K,
    ambientPressure=AMBIENT_PA,
    position=STROKE_M / 2,
    stroke=STROKE_M,
    supplyPortPressure=SUPPLY_PA,
    supplyPortTemperature=AMBIENT_K,
    exhaustPortPressure=AMBIENT_PA,
    exhaustPortTemperature=AMBIENT_K,
)


class Chamber:
    """One instance, by variable names."""

    def __init__(self, path, name, **start):
        description, self.folder = read_model_description(path), extract(path)
        self.variables = {v.name: v for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.setInteger([self.variables["strokeInput"].valueReference], [VELOCITY])
        self.set(**start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values):
        self.fmu.setReal([self.variables[name].valueReference for name in values], list(values.values()))

    def get(self, name):
        return self.fmu.getReal([self.variables[name].valueReference])[0]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def run(cap_side, rod_side, step=STEP_S, report=lambda *_: None):
    """Positions and pressures, every 20 ms, of a piston that goes from the middle to its target."""
    cap, rod = Chamber(cap_side, "cap", **REST), Chamber(rod_side, "rod", **REST)
    v, course = 0.0, []
    every = round(0.02 / step)
    for k in range(round(DURATION_S / step)):
        x = cap.get("pistonPosition")
        opening = max(-1.0, min(1.0, 12.0 * (TARGET_M - x) - 0.9 * v))
        # Half of the push before the step and half after it: the mean speed of the step moves the gas.
        push = cap.get("force") - rod.get("force") - FRICTION_N_S_PER_M * v
        half = v + 0.5 * step * push / MASS_KG
        for chamber, speed, valve in ((cap, half, opening), (rod, -half, -opening)):
            chamber.set(
                velocity=speed,
                supplyPortConductance=CONDUCTANCE * max(0.0, valve),
                exhaustPortConductance=CONDUCTANCE * max(0.0, -valve),
            )
            chamber.fmu.doStep(k * step, step)
        push = cap.get("force") - rod.get("force") - FRICTION_N_S_PER_M * half
        v = half + 0.5 * step * push / MASS_KG
        if (k + 1) % every == 0:
            course.append((cap.get("pistonPosition"), cap.get("pressure"), rod.get("pressure")))
            report((k + 1) * step, cap, rod)
    cap.close()
    rod.close()
    return course


def tell(time, cap, rod):
    """A line every 0.2 s."""
    if round(time / 0.02) % 10 == 0:
        both = [(chamber.get("pressure") / 1e5, chamber.get("temperature")) for chamber in (cap, rod)]
        print(
            f"t = {time:4.1f} s   x = {1e3 * cap.get('pistonPosition'):6.2f} mm   "
            f"p = {both[0][0]:5.2f} | {both[1][0]:5.2f} bar   T = {both[0][1]:5.1f} | {both[1][1]:5.1f} K"
        )


def steps(cap_side, rod_side):
    """What step a master needs: largest errors of position and pressure against a step of 0.05 ms."""
    fine = run(cap_side, rod_side, 5e-5)
    print("| step | position | pressure |\n|---|---|---|")
    for step in (2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2):
        coarse = run(cap_side, rod_side, step)
        position = max(abs(a[0] - b[0]) for a, b in zip(coarse, fine))
        pressure = max(abs(a[i] - b[i]) for a, b in zip(coarse, fine) for i in (1, 2))
        print(f"| {1e3 * step:g} ms | {1e3 * position:.3f} mm | {pressure / 1e5:.4f} bar |")


def main(cap_side, rod_side, *options):
    if "--steps" in options:
        return steps(cap_side, rod_side)
    x = run(cap_side, rod_side, report=tell)[-1][0]
    print(f"reached {1e3 * x:.2f} mm of {1e3 * TARGET_M:.0f} mm")
    return x


if __name__ == "__main__":
    main(*(sys.argv[1:] if len(sys.argv) > 2 else ["CapSide.fmu", "RodSide.fmu"]))
