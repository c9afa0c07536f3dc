"""The scenarios as all contenders read them, the sealed chamber's equation, and its exact solution. SI units.

    dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V'/V),   P = m R T/V,   c a = λ0 √(m R/(P0 T0)) Aq/(m cv √V)
"""

import dataclasses
import math

import numpy as np

GAS_CONSTANT, GAMMA = 287.0, 1.4
REFERENCE_PRESSURE, REFERENCE_TEMPERATURE = 5.65e5, 293.0
AMBIENT_TEMPERATURE, AMBIENT_PRESSURE = 293.0, 101325.0
REFERENCE_LENGTH = 0.1  # of the gas column, m
REFERENCE_DENSITY, LEAK_TEMPERATURE = 1.185, 293.15  # of ISO 6358
REFERENCE_DIFFERENCE = 20.0  # of natural convection, K
# The columns of a scenario, by their names in a study, and what they are where the study does not vary them.
COLUMNS = {
    "bore_m": None,
    "dead_volume_m3": None,
    "initial_pressure_pa": None,
    "initial_stroke_m": None,
    "final_stroke_m": None,
    "coefficient_w_per_m2_k": None,
    "push_time_s": 0.04,
    "duration_s": 5.04,
    "mass_flow_in_kg_per_s": 0.0,
    "leakage.conductance_m3_per_s_pa": 0.0,
    "natural_convection.exponent": 0.0,
    "wall_heating.capacity_j_per_k": 0.0,
    "wall_heating.outer_conductance_w_per_k": 0.0,
    "gas_column_length.exponent": 0.0,
}


def read(path):
    """Rows of a scenario file: 64-bit floats in the order of COLUMNS."""
    return np.fromfile(path).reshape(-1, len(COLUMNS))


def column(cases, name):
    """One of the columns."""
    return cases[..., list(COLUMNS).index(name)]


@dataclasses.dataclass
class Sealed:
    """Coefficients of the equation, one array element for each scenario."""

    volume: np.ndarray
    volume_rate: np.ndarray
    lateral: np.ndarray
    faces: np.ndarray
    held_volume: np.ndarray
    held_exchange: np.ndarray
    mass_gas_constant: np.ndarray
    push_time: np.ndarray
    hold_time: np.ndarray

    @classmethod
    def of(cls, cases):
        bore, dead, pressure, start, stop, coefficient, push_time, duration = cases[:, :8].T
        area = math.pi / 4 * bore**2
        volume, held_volume = dead + area * start, dead + area * stop
        mass_gas_constant = pressure * volume / AMBIENT_TEMPERATURE
        c = coefficient * (GAMMA - 1) / np.sqrt(mass_gas_constant * REFERENCE_PRESSURE * REFERENCE_TEMPERATURE)
        lateral, faces = c * 4 / bore, c * math.pi / 2 * bore**2
        held_exchange = (lateral * held_volume + faces) / np.sqrt(held_volume)
        rate = (held_volume - volume) / push_time
        return cls(volume, rate, lateral, faces, held_volume, held_exchange, mass_gas_constant, push_time, duration - push_time)

    def pressures(self, peak_temperature, final_temperature):
        """Peak and final pressure, a row for each scenario, Pa."""
        return np.stack([peak_temperature, final_temperature], axis=1) * (self.mass_gas_constant / self.held_volume)[:, None]

    def exact(self):
        """Peak and final pressure in closed form (Bernoulli); the integral by 24-point Gauss-Legendre, good to 1e-15."""
        tw, g = AMBIENT_TEMPERATURE, GAMMA - 1
        primitive = lambda v: (2 / 3 * self.lateral * v**1.5 + 2 * self.faces * np.sqrt(v)) / self.volume_rate
        factor = lambda v: np.exp(tw * (primitive(v) - primitive(self.volume)) - g * np.log(v / self.volume))
        inverse = 1 / tw
        for x, w in zip(*np.polynomial.legendre.leggauss(24)):
            v = self.volume + self.volume_rate * self.push_time * (x + 1) / 2
            inverse = inverse + w / 2 * self.push_time * (self.lateral * v + self.faces) / np.sqrt(v) * factor(v)
        peak = factor(self.held_volume) / inverse
        decay = np.exp(-tw * self.held_exchange * self.hold_time)
        return self.pressures(peak, tw / (1 - (1 - tw / peak) * decay))
