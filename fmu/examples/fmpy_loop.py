"""What a step costs when FMPy makes it: the baseline beside `step_cost`.   python fmu/examples/fmpy_loop.py Chamber.fmu"""

import shutil
import sys
import time

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STEPS = 100_000


def main(path):
    description, folder = read_model_description(path), extract(path)
    chamber = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="cost",
    )
    references = {v.name: v.valueReference for v in description.modelVariables}
    for name, flows in (("sealed, piston held", 0.0), ("with flow in and out", 1e-4)):
        chamber.instantiate()
        chamber.setupExperiment(startTime=0.0)
        chamber.setReal([references[n] for n in ("massFlowIn", "massFlowOut", "initialTemperature")], [flows, flows, 350.0])
        chamber.enterInitializationMode()
        chamber.exitInitializationMode()
        begin = time.perf_counter()
        for k in range(STEPS):
            chamber.doStep(k * 1e-3, 1e-3)
        print(f"| FMPy's loop over fmi2DoStep: {name} | {(time.perf_counter() - begin) / STEPS * 1e6:.2f} |")
        chamber.terminate()
        chamber.fmi2FreeInstance(chamber.component)
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main(sys.argv[1])
