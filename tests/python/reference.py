"""An independent implementation of the chamber, written from the documentation alone and integrated by scipy (DOP853, rtol
1e-11).

States are pressure, mass and those of effects; the program's are mass and internal energy. Effects are given as a dictionary of
dictionaries, {"leakage": {"conductance_m3_per_s_pa": 1e-12}}, as in a model file. SI units.
"""

import dataclasses
import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import BSpline
from scipy.optimize import brentq

RTOL = 1e-11


def wall_modes():
    """Rates (1/s) and weights (s^-1/2) of the modes of 1/sqrt(pi t): the trapezoidal rule in log(rate) with ratio 5. The terms
    below 5^-5 and those above 5 are each merged into one: with equal sums of weight and of weight times rate, and of weight
    over rate and of weight over rate squared, respectively."""
    exponents = np.arange(-80, 81)
    rates = 5.0**exponents
    weights = math.log(5) / math.pi * np.sqrt(rates)
    slow, fast, kept = exponents < -5, exponents > 1, (exponents >= -5) & (exponents <= 1)
    slow_weight = weights[slow].sum()
    slow_rate = (weights * rates)[slow].sum() / slow_weight
    steady = (weights / rates)[fast].sum()
    fast_rate = steady / (weights / rates**2)[fast].sum()
    return (
        np.concatenate([[slow_rate], rates[kept], [fast_rate]]),
        np.concatenate([[slow_weight], weights[kept], [steady * fast_rate]]),
    )


MODE_RATES, MODE_WEIGHTS = wall_modes()


@dataclasses.dataclass
class Chamber:
    bore: float = 0.02
    rod: float = 0.0
    dead_volume: float = 2e-6
    lambda0: float = 30.0
    area_law: str = "total"
    ambient_temperature: float = 293.0
    ambient_pressure: float = 1.013e5
    gas_constant: float = 287.0
    gamma: float = 1.4
    p0: float = 5.65e5
    t0: float = 293.0
    effects: dict = dataclasses.field(default_factory=dict)

    def value(self, effect, key, neutral=0.0):
        return self.effects.get(effect, {}).get(key, neutral)

    @property
    def piston_area(self):
        return math.pi * (self.bore**2 - self.rod**2) / 4

    def volume(self, x, p=None):
        return (self.dead_volume + self.piston_area * x) * (1 + self.volume_share(x, p))

    def volume_share(self, x, p):
        return self.curve("volume_share", pressure=p, position=x)

    def curve(self, balance, **at):
        """The empirical term for this balance: linear between its knots, constant beyond."""
        table = self.effects.get("empirical")
        if not table or table["balance"] != balance:
            return 0.0
        return np.interp(at[table["variable"]], table["knots"], table["values"])

    def heat_area(self, x, p=None):
        volume = self.volume(x, p) - (0 if self.area_law == "total" else self.dead_volume)
        column = volume / self.piston_area
        law = math.pi * (self.bore + self.rod) * column + 2 * self.piston_area
        return max(law + self.value("dead_volume_surface", "extra_area_m2"), 0.0)

    @property
    def rest_temperature(self):
        return self.ambient_temperature + self.value("warm_wall", "temperature_difference_k")

    def cv(self, t):
        effect = "temperature_dependent_heat_capacity"
        slope, curvature = self.value(effect, "slope_1_per_k"), self.value(effect, "curvature_1_per_k2")
        return self.gas_constant / (self.gamma - 1) * (1 + slope * (t - 293) + curvature * (t - 293) ** 2)

    def enthalpy_above_energy(self, t_flow, t):
        """h of gas at t_flow minus u of gas at t, J/kg: cv is a parabola, averaged exactly by Simpson's rule."""
        mean = (self.cv(t) + 4 * self.cv((t_flow + t) / 2) + self.cv(t_flow)) / 6
        return self.gas_constant * t_flow + mean * (t_flow - t)

    def coefficient(self, p, t, tw, x, v):
        """Heat transfer coefficient: the documented product of factors."""
        n_p = self.value("pressure_exponent", "pressure_exponent", 0.5)
        n_t = self.value("pressure_exponent", "temperature_exponent", 0.5)
        n = self.value("natural_convection", "exponent")
        a = self.value("gas_column_length", "exponent")
        l_ref = self.value("gas_column_length", "reference_length_m", 0.1)
        k = self.value("forced_convection", "coefficient")
        result = self.lambda0 * (p / self.p0) ** n_p * (t / self.t0) ** n_t
        if n:
            result *= (abs(t - tw) / 20) ** n
        return result * (1 + k * abs(v) ** 0.8) * (self.volume(x, p) / self.piston_area / l_ref) ** a

    def leak(self, p, t):
        """(inflow, outflow) past seals and a closed valve, inflow at ambient temperature."""
        ambient = self.ambient_pressure
        ways = [self.orifice("leakage", ambient, p, t)]
        ways.append(self.orifice("supply_leakage", self.value("supply_leakage", "supply_pressure_pa", 7e5), p, t))
        g = self.value("laminar_leakage", "conductance_m3_per_s_pa")
        upstream = t if p > ambient else self.ambient_temperature
        laminar = g * (p**2 - ambient**2) / (2 * self.gas_constant * upstream)
        ways.append((max(-laminar, 0.0), max(laminar, 0.0)))
        return sum(way[0] for way in ways), sum(way[1] for way in ways)

    def orifice(self, effect, outside, p, t):
        """(inflow, outflow) by ISO 6358 between the gas and an outside pressure."""
        c = self.value(effect, "conductance_m3_per_s_pa")
        b = self.value(effect, "critical_pressure_ratio", 0.3)
        rho0 = 1.185 * 287 / self.gas_constant

        def flow(up, t_up, down):
            r = down / up
            if r <= b:
                psi = 1.0
            elif r <= 0.999:
                psi = math.sqrt(1 - ((r - b) / (1 - b)) ** 2)
            else:
                psi = math.sqrt(1 - ((0.999 - b) / (1 - b)) ** 2) * (1 - r) / 0.001
            return c * up * rho0 * math.sqrt(293.15 / t_up) * psi

        if p > outside:
            return 0.0, flow(p, t, outside)
        return flow(outside, self.ambient_temperature, p), 0.0

    def at_rest(self, pressure, mass, temperature):
        """States of `rates` in equilibrium, and their scales."""
        memory = np.zeros(len(MODE_RATES) if "wall_conduction" in self.effects else 0)
        turbulence = np.zeros(int("decaying_turbulence" in self.effects))
        y = np.concatenate([[pressure, mass, temperature, self.ambient_temperature, pressure], memory, turbulence])
        return y, np.concatenate([[pressure, mass, 300.0, 300.0, pressure], memory + 10.0, turbulence + 0.1])

    def rates(self, y, x, v, mdot):
        p, m, core, tw, lagged = y[:5]
        modes, turbulence = np.split(y[5:], [len(y) - 5 - int("decaying_turbulence" in self.effects)])
        g, r = self.gamma, self.gas_constant
        cp = g * r / (g - 1)
        volume, dv = self.volume(x, p), self.piston_area * v
        give = 0.0
        if self.effects.get("empirical", {}).get("balance") == "volume_share":
            # Curves are piecewise linear: differences are exact within a piece.
            dx, dp = 1e-7, 1e-2
            geometric = self.dead_volume + self.piston_area * x
            dv *= 1 + self.volume_share(x, p)
            dv += geometric * (self.volume_share(x + dx, p) - self.volume_share(x - dx, p)) / (2 * dx) * v
            give = geometric * (self.volume_share(x, p + dp) - self.volume_share(x, p - dp)) / (2 * dp)
        t = p * volume / (m * r)
        z, h = self.value("gas_zones", "mass_fraction"), self.value("gas_zones", "conductance_w_per_k")
        t1 = (t - z * core) / (1 - z)
        capacity = self.value("wall_heating", "capacity_j_per_k")
        outer = self.value("wall_heating", "outer_conductance_w_per_k")
        wall = (tw if capacity else self.ambient_temperature) + self.value("warm_wall", "temperature_difference_k")
        inverse = self.value("wall_conduction", "inverse_effusivity_m2_k_per_w_s05")
        wall += modes.sum()
        seen = dict(pressure=p, temperature=t, temperature_difference=t1 - wall, position=x, velocity=v, mass=m)
        seen["piston_power"] = p * self.piston_area * v
        share = self.curve("coefficient_share", **seen)
        stirred = 1 + self.value("decaying_turbulence", "coefficient_s_per_m") * turbulence.sum()
        flux = self.coefficient(p, t1, wall, x, v) * stirred * (1 + share) * (t1 - wall)
        q = self.curve("heat_flow", **seen) - flux * self.heat_area(x, p)
        dmodes = inverse * MODE_WEIGHTS * flux - MODE_RATES * modes if len(modes) else modes
        leak_in, leak_out = self.leak(p, t)
        unnamed = self.curve("mass_flow", **seen)
        leak_in, leak_out = leak_in + max(unnamed, 0.0), leak_out + max(-unnamed, 0.0)
        flow_in, flow_out = max(mdot, 0.0) + leak_in, max(-mdot, 0.0) + leak_out
        t_in = self.ambient_temperature

        def pressure_rate(into, out):
            # Enthalpy minus the internal energy of the gas that absorbs it: the difference warms it.
            net = into * self.enthalpy_above_energy(t_in, t) - out * self.enthalpy_above_energy(t, t)

            def rate(dv):
                warming = (q - p * dv + net) / (m * self.cv(t))
                return p * ((into - out) / m + warming / t - dv / volume)

            # A pressure-dependent volume: dV/dt = dv + give dP/dt.
            return rate(dv) / (1 + give * (rate(0.0) - rate(1.0)))

        tube = self.value("tube_volume", "volume_m3")
        if tube:
            # The flow into the tube depends on the pressure's rate, and vice versa: one equation for that rate.
            per_rate = tube / (r * self.ambient_temperature)

            def excess(rate):
                s = per_rate * rate
                return pressure_rate(flow_in + max(-s, 0.0), flow_out + max(s, 0.0)) - rate

            free = pressure_rate(flow_in, flow_out)
            rate = brentq(excess, min(0.0, 2 * free), max(0.0, 2 * free), xtol=1e-30, rtol=1e-15) if free else 0.0
            s = per_rate * rate
            flow_in, flow_out = flow_in + max(-s, 0.0), flow_out + max(s, 0.0)
        dp = pressure_rate(flow_in, flow_out)
        dcore = 0.0
        if z:
            v2 = z * m * r * core / p
            dcore = (v2 * dp + h * (t1 - core) + z * flow_in * cp * (t_in - core)) / (z * m * cp)
        dtw = (-q + outer * (self.ambient_temperature - tw)) / capacity if capacity else 0.0
        lag = self.value("sensor_lag", "time_constant_s")
        dlag = (p - lagged) / lag if lag else 0.0
        dturbulence = (abs(v) - turbulence) / self.value("decaying_turbulence", "decay_time_s", 0.3)
        return np.concatenate([[dp, flow_in - flow_out, dcore, dtw, dlag], dmodes, dturbulence]), q


def bends(times, positions, window, apart):
    """Intervals, from one time to another, of bends in a piecewise linear stroke at rest before and after; bends closer than
    `apart` are merged."""
    slopes = np.concatenate([[0.0], np.diff(positions) / np.diff(times), [0.0]])
    bent = times[np.abs(np.diff(slopes)) * window > 1e-6 * np.ptp(positions)]
    return [[part[0], part[-1]] for part in np.split(bent, np.flatnonzero(np.diff(bent) >= apart) + 1) if len(part)]


def behind_average(recorded, ends, motion, window):
    """The cubic spline, with knots at multiples of a power of two between w/8 and w/4, whose moving average is nearest to the
    record with a small third derivative: returns its knots, coefficients, and the range where it replaces the record. Uses
    orthogonal least squares."""
    step, (begin, end), (first, last) = 2.0 ** math.floor(math.log2(window / 4)), ends, motion
    rests, steps = (first > begin, last < end), window / step
    # At a rest the knots within a quarter of a window beyond the motion are free, further ones follow the record; at an end of
    # the record all knots that affect its averages are free, up to five steps away.
    low = math.floor((first - window / 4) / step) if rests[0] else math.ceil(first / step) - 5
    high = math.ceil((last + window / 4) / step) if rests[1] else math.floor(last / step) + 5
    at = np.arange(low - 10 * rests[0], high + 10 * rests[1] + 1)
    knots, free = step * at, (at >= low) & (at <= high)
    spline = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False).antiderivative()

    def up_to(u):
        return spline(np.clip(u, -2, 2)) - spline(-2)

    samples = at[5:-5]
    away = samples[:, None] - at[None, :]
    averages = (up_to(away + steps / 2) - up_to(away - steps / 2)) / steps
    thirds = np.diff(np.eye(len(at)), 3, axis=0)
    equations = np.vstack([averages, math.sqrt(7e-7 * steps**6) * thirds])
    right = np.concatenate([recorded(step * samples), np.zeros(len(thirds))])
    # The average of a spline with a constant second difference d differs from its coefficient by (1/6 + steps^2/24) d.
    beside = recorded(knots - step) - 2 * recorded(knots) + recorded(knots + step)
    coefficients = recorded(knots) - (1 / 6 + steps**2 / 24) * beside
    right = right - equations[:, ~free] @ coefficients[~free]
    coefficients[free] = np.linalg.lstsq(equations[:, free], right, rcond=None)[0]
    inside = [knots[free][0] - 2 * step if rests[0] else first, knots[free][-1] + 2 * step if rests[1] else last]
    return step, knots, coefficients, inside


def true_stroke(chamber, times, positions):
    """Knots of the true stroke, from a recorded one that is delayed, low-pass filtered and averaged."""
    delay = chamber.value("position_delay", "delay_s")
    # After a low-pass: x + tau dx/dt, where the slope at a row is the mean of those on both sides; linear between the rows.
    chords = np.concatenate([[0.0], np.diff(positions) / np.diff(times), [0.0]])
    positions = positions + chamber.value("position_delay", "filter_time_constant_s") * (chords[1:] + chords[:-1]) / 2
    window = chamber.value("position_averaging", "window_s")

    def recorded(t):
        return np.interp(t, times, positions)

    ends = times[0], times[-1]
    apart = (0.25 + 12 / 4) * window
    found = [behind_average(recorded, ends, motion, window) for motion in bends(times, positions, window, apart)] if window else []
    knots = np.concatenate([times, times - delay] + [knots[(knots >= a) & (knots <= b)] - delay for _, knots, _, (a, b) in found])
    knots = np.unique(np.round(knots[(knots >= times[0]) & (knots <= times[-1])], 11))
    stroke = recorded(knots + delay)
    for step, places, coefficients, (a, b) in found:
        inside = (knots + delay >= a) & (knots + delay <= b)
        of_knot = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False)
        parts = np.nan_to_num(of_knot((knots[inside, None] + delay - places[None, :]) / step))
        stroke[inside] = parts @ coefficients
    return knots, stroke


def simulate(chamber, times, positions, pressure, mass_flows=None, rows=None):
    """The program's expected output at `rows` (by default at the knots): each column an array.

    The stroke and the mass flow (into the chamber, kg/s) are linear between the knots at `times`.
    """
    times, positions = np.asarray(times, float), np.asarray(positions, float)
    flows = np.zeros_like(times) if mass_flows is None else np.asarray(mass_flows, float)
    rows = times if rows is None else np.asarray(rows, float)
    if "position_delay" in chamber.effects or "position_averaging" in chamber.effects:
        knots, stroke = true_stroke(chamber, times, positions)
        times, positions, flows = knots, stroke, np.interp(knots, times, flows)
    rest = chamber.rest_temperature
    mass = pressure * chamber.volume(positions[0], pressure) / (chamber.gas_constant * rest)
    y, scale = chamber.at_rest(pressure, mass, rest)
    gas = np.full((len(rows), len(y)), np.nan)
    shown = np.full(len(rows), np.nan)
    delay = chamber.value("record_delay", "delay_s")
    column = 4 if chamber.value("sensor_lag", "time_constant_s") else 0
    earlier = np.maximum(rows - delay, times[0])
    # Error estimates miss a curve's corners, so steps are short there.
    parts = 32 if "empirical" in chamber.effects else 1
    gas[rows <= times[0]] = y
    shown[earlier <= times[0]] = y[column]
    for k in range(len(times) - 1):
        t0, t1 = times[k], times[k + 1]
        v = (positions[k + 1] - positions[k]) / (t1 - t0)

        def rates(t, y, k=k, t0=t0, t1=t1, v=v):
            mdot = flows[k] + (flows[k + 1] - flows[k]) * (t - t0) / (t1 - t0)
            return chamber.rates(y, positions[k] + v * (t - t0), v, mdot)[0]

        run = solve_ivp(
            rates, (t0, t1), y, method="DOP853", rtol=RTOL, atol=1e-13 * scale, dense_output=True, max_step=(t1 - t0) / parts
        )
        assert run.success, run.message
        y = run.y[:, -1]
        for i in np.flatnonzero((rows > t0) & (rows < t1)):
            gas[i] = run.sol(rows[i])
        gas[rows == t1] = y
        for i in np.flatnonzero((earlier > t0) & (earlier <= t1)):
            shown[i] = run.sol(earlier[i])[column] if earlier[i] < t1 else y[column]
    shown = shown + chamber.value("sensor_offset", "offset_pa")
    measured = shown + chamber.value("sensor_drift", "rate_pa_per_s") * (rows - times[0])
    measured = measured + chamber.curve("reading", pressure=measured)
    volume = chamber.volume(np.interp(rows, times, positions), gas[:, 0])
    return {
        "pressure_pa": measured,
        "gas_pressure_pa": gas[:, 0],
        "temperature_k": gas[:, 0] * volume / (gas[:, 1] * chamber.gas_constant),
        "mass_kg": gas[:, 1],
        "volume_m3": volume,
    }
