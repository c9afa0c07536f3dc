"""FMPy: our own FMU, unpacked and instantiated once, reset for each scenario.

Options: `fmu`, `tolerance` and `form`: "simulate" is FMPy's `simulate_fmu` with `fmu_instance`, "trace" the same with a
record of 100 Hz, "steps" a loop of one's own over the FMI calls. "simulate" and "steps" take two communication steps: the
push and the hold.
"""

import contender
import numpy as np
from scenario import AMBIENT_PRESSURE
from scenario import AMBIENT_TEMPERATURE as TW

PARAMETERS = ["bore", "deadVolume", "initialPressure", "lambda0", "initialTemperature"]
CONSTANT = {"massFlowIn": 0.0, "temperatureIn": TW, "massFlowOut": 0.0, "ambientTemperature": TW, "ambientPressure": AMBIENT_PRESSURE}


def prepare(fmu, form="simulate", tolerance=1e-8):
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    description = fmpy.read_model_description(fmu)
    folder = fmpy.extract(fmu)
    identifier = description.coSimulation.modelIdentifier
    slave = FMU2Slave(guid=description.guid, modelIdentifier=identifier, unzipDirectory=folder, instanceName="one")
    slave.instantiate()
    reference = {v.name: v.valueReference for v in description.modelVariables}
    parameters, constant = ([reference[name] for name in names] for names in (PARAMETERS, CONSTANT))
    inputs = [reference["position"], reference["velocity"]]
    output = [reference["pressure"]]
    # Every input: of a missing one FMPy warns each time.
    motion = np.zeros(4, [(name, float) for name in ("time", "position", "velocity", *CONSTANT)])
    for name, value in CONSTANT.items():
        motion[name] = value

    def simulate(values, begin, end, push, duration, interval=None):
        motion["time"] = 0.0, push, push, duration
        motion["position"] = begin, end, end, end
        motion["velocity"] = (end - begin) / push, (end - begin) / push, 0.0, 0.0
        result = fmpy.simulate_fmu(
            folder,
            fmu_instance=slave,
            model_description=description,
            start_values=dict(zip(PARAMETERS, values)),
            input=motion,
            output=["pressure"],
            stop_time=duration,
            output_interval=interval or duration,
            relative_tolerance=tolerance,
            terminate=False,
        )
        pressure = result["pressure"]
        return pressure[1 if interval is None else round(push / interval)], pressure[-1]

    def trace(*arguments):
        return simulate(*arguments, interval=0.01)

    def steps(values, begin, end, push, duration):
        slave.setupExperiment(tolerance=tolerance, startTime=0.0)
        slave.setReal(parameters, values)
        slave.setReal(constant, list(CONSTANT.values()))
        slave.setReal(inputs, [begin, (end - begin) / push])
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=push)
        slave.setReal(inputs, [end, 0.0])
        peak = slave.getReal(output)[0]
        slave.doStep(currentCommunicationPoint=push, communicationStepSize=duration - push)
        return peak, slave.getReal(output)[0]

    one = {"simulate": simulate, "trace": trace, "steps": steps}[form]

    def solve(cases):
        answers = np.empty((len(cases), 2))
        for i, (bore, dead, pressure, begin, end, coefficient, push, duration) in enumerate(cases[:, :8].tolist()):
            slave.reset()
            answers[i] = one([bore, dead, pressure, coefficient, TW], begin, end, push, duration)
        return answers

    return solve


if __name__ == "__main__":
    contender.serve(prepare)
