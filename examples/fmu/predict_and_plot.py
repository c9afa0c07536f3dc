"""The FMU along a recorded motion, beside the record, as a picture.

    pip install fmpy numpy matplotlib
    pneutherm diagnose examples/cylinder -o model.toml
    pneutherm fmu model.toml -o Chamber.fmu
    python examples/fmu/predict_and_plot.py Chamber.fmu examples/cylinder/validation.csv prediction.png
"""

import sys

import fmpy
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def predict(fmu, record):
    """Time, s; what the FMU's sensor shows and what was recorded, Pa; the gas's temperature, K."""
    data = np.genfromtxt(record, delimiter=",", names=True)
    time, position, pressure = data["time_s"], data["position_m"], data["pressure_pa"]
    inputs = np.zeros(len(time), dtype=[("time", float), ("position", float), ("velocity", float)])
    inputs["time"], inputs["position"] = time, position
    inputs["velocity"][:-1] = np.diff(position) / np.diff(time)
    moving = np.flatnonzero(np.abs(position - position[0]) > 1e-3)
    at_rest = pressure[: moving[0] if len(moving) else 1].mean()
    result = fmpy.simulate_fmu(
        fmu,
        start_values={"initialPressure": at_rest, "initialTemperature": data["ambient_temperature_k"][0]},
        input=inputs,
        output=["measuredPressure", "temperature"],
        output_interval=0.01,
        stop_time=time[-1],
    )
    shown = np.interp(time, result["time"], result["measuredPressure"])
    return time, shown, pressure, np.interp(time, result["time"], result["temperature"])


def main(fmu, record, picture):
    time, shown, recorded, temperature = predict(fmu, record)
    figure, axes = plt.subplots(3, sharex=True, figsize=(8, 8), layout="constrained")
    axes[0].plot(time, recorded / 1e5, ".", color="#1e1e1e", markersize=2, label="recorded")
    axes[0].plot(time, shown / 1e5, color="#0072b2", label="FMU")
    axes[0].set_ylabel("pressure, bar")
    axes[0].legend()
    axes[1].plot(time, recorded - shown, color="#d55e00")
    axes[1].set_ylabel("recorded less FMU, Pa")
    axes[2].plot(time, temperature, color="#0072b2")
    axes[2].set_ylabel("gas temperature, K")
    axes[2].set_xlabel("time, s")
    figure.savefig(picture, dpi=120)
    error = float(np.sqrt(np.mean((recorded - shown) ** 2)))
    print(f"{error:.0f} Pa rms between FMU and record; picture in {picture}")
    return error


if __name__ == "__main__":
    main(*(sys.argv[1:] + ["Chamber.fmu", "examples/cylinder/validation.csv", "prediction.png"][len(sys.argv) - 1 :]))
