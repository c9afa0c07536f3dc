"""The equations of each kind of rows as heyoka integrates them, in the notation of scenario.py; SI units.

A class holds the systems of push and hold and gives, for all rows at once, their parameters, where they begin and end,
and the pressures of their states. K is the exchange of the hold, dT/dt = K T (Tw − T).
"""

import dataclasses
import math

import heyoka as hy
import numpy as np
import scenario
from scenario import AMBIENT_TEMPERATURE as TW
from scenario import GAMMA, Sealed

T, W = hy.make_vars("T", "W")
P, S = hy.par, hy.time  # parameters, the independent variable


@dataclasses.dataclass
class Stretch:
    """A part of the tests: arrays with an element for each row."""

    parameters: list
    begin: np.ndarray
    end: np.ndarray
    start: list
    stiffness: np.ndarray
    which: np.ndarray = None  # of the systems; by default the first


@dataclasses.dataclass
class System:
    """Equations, and events in them."""

    equations: list
    events: list = dataclasses.field(default_factory=list)


class Plain:
    """Sealed, V = V0 + V' t inside the equation."""

    _volume = P[0] + P[1] * S
    PUSH = [System([(T, T * ((P[2] * _volume + P[3]) * hy.sqrt(_volume) * (TW - T) - P[4]) * (1.0 / _volume))])]
    HOLD = [System([(T, P[0] * T * (TW - T))])]

    def __init__(self, cases):
        self.sealed = Sealed.of(cases)
        self.zero = np.zeros(len(cases))
        self.column = lambda name: scenario.column(cases, name)

    def push(self):
        s = self.sealed
        parameters = [s.volume, s.volume_rate, s.lateral, s.faces, (GAMMA - 1) * s.volume_rate]
        return Stretch(parameters, self.zero, s.push_time, [self.zero + TW], s.held_exchange)

    def hold(self, middle):
        s = self.sealed
        return Stretch([s.held_exchange], self.zero, s.hold_time, middle, s.held_exchange)

    def pressure(self, states, _):
        return states[0] * self.sealed.mass_gas_constant / self.sealed.held_volume


class Root(Plain):
    """Sealed, s = √V as the independent variable: dT/ds = T ((2/V') (c a1 s² + c a0) (Tw − T) − 2 (γ − 1)/s)."""

    _exchange = P[0] * S * S + P[1]
    _expansion = 2 * (GAMMA - 1) / S
    PUSH = [System([(T, T * (_exchange * (TW - T) - _expansion))])]

    def push(self):
        s = self.sealed
        parameters = [2 / s.volume_rate * s.lateral, 2 / s.volume_rate * s.faces]
        return Stretch(parameters, np.sqrt(s.volume), np.sqrt(s.held_volume), [self.zero + TW], s.held_exchange)


class WallPlain(Plain):
    """The wall's temperature W beside T: dW/dt = (m cv/Cw) (heat that cools the gas) − (G/Cw) (W − Tamb)."""

    _volume = Plain._volume
    _heating = (P[2] * _volume + P[3]) * _volume**-0.5 * T * (W - T)
    PUSH = [System([(T, _heating - P[4] * T / _volume), (W, -P[5] * _heating - P[6] * (W - TW))])]
    _heating = P[0] * T * (W - T)
    HOLD = [System([(T, _heating), (W, -P[1] * _heating - P[2] * (W - TW))])]

    def wall(self):
        """m cv/Cw and G/Cw."""
        capacity = self.column("wall_heating.capacity_j_per_k")
        outer = self.column("wall_heating.outer_conductance_w_per_k")
        return [self.sealed.mass_gas_constant / (GAMMA - 1) / capacity, outer / capacity]

    def push(self):
        stretch = super().push()
        return dataclasses.replace(stretch, parameters=stretch.parameters + self.wall(), start=stretch.start * 2)

    def hold(self, middle):
        stretch = super().hold(middle)
        stiffness = stretch.stiffness * (1 + self.wall()[0])
        return dataclasses.replace(stretch, parameters=stretch.parameters + self.wall(), stiffness=stiffness)


class WallRoot(WallPlain):
    """The same with the root of the volume as the independent variable: dt = 2 s ds/V'."""

    _heating = Root._exchange * T * (W - T)
    PUSH = [System([(T, _heating - T * Root._expansion), (W, -P[2] * _heating - P[3] * S * (W - TW))])]

    def push(self):
        stretch = Root.push(self)
        share, rate = self.wall()
        parameters = [*stretch.parameters, share, rate * 2 / self.sealed.volume_rate]
        return dataclasses.replace(stretch, parameters=parameters, start=stretch.start * 2)


class ColumnPlain(Plain):
    """The exchange times (V/(A l_ref))^a."""

    _volume = Plain._volume
    _exchange = (P[2] * _volume + P[3]) * _volume ** P[5]
    PUSH = [System([(T, T * (_exchange * (TW - T) - P[4] / _volume))])]

    def __init__(self, cases):
        super().__init__(cases)
        self.exponent = self.column("gas_column_length.exponent")
        area = math.pi / 4 * self.column("bore_m") ** 2
        self.factor = lambda volume: (volume / (area * scenario.REFERENCE_LENGTH)) ** self.exponent
        self.sealed.held_exchange = self.sealed.held_exchange * self.factor(self.sealed.held_volume)

    def push(self):
        stretch, scale = super().push(), self.factor(1.0)
        volume, rate, lateral, faces, expansion = stretch.parameters
        parameters = [volume, rate, lateral * scale, faces * scale, expansion, self.exponent - 0.5]
        return dataclasses.replace(stretch, parameters=parameters)


class ColumnLog(ColumnPlain):
    """The same with u = ln(V/V0) as the independent variable, in which the powers are exponentials."""

    _exchange = (P[0] * hy.exp(S) + P[1]) * hy.exp(P[2] * S)
    PUSH = [System([(T, T * (_exchange * (TW - T) - (GAMMA - 1)))])]

    def push(self):
        s = self.sealed
        scale = np.sqrt(s.volume) / s.volume_rate * self.factor(s.volume)
        parameters = [s.lateral * s.volume * scale, s.faces * scale, self.exponent + 0.5]
        end = np.log(s.held_volume / s.volume)
        return Stretch(parameters, self.zero, end, [self.zero + TW], s.held_exchange)


D, E = hy.make_vars("D", "E")


class ColumnStates(ColumnLog):
    """The same, the exponentials as states of their own, and T in units of Tw."""

    PUSH = [System(
        [
        (T, T * ((P[0] * D + P[1]) * E * (1.0 - T) - (GAMMA - 1))),
        (D, D),
        (E, P[2] * E),
    ]
    )]
    HOLD = [System([(T, P[0] * T * (1.0 - T))])]

    def push(self):
        stretch = super().push()
        a, b, exponent = stretch.parameters
        one = self.zero + 1
        return dataclasses.replace(stretch, parameters=[a * TW, b * TW, exponent], start=[one, one, one])

    def hold(self, middle):
        stretch = super().hold(middle[:1])
        return dataclasses.replace(stretch, parameters=[stretch.parameters[0] * TW])

    def pressure(self, states, _):
        return super().pressure(states * TW, _)


class ColumnReciprocal(ColumnStates):
    """The same with Tw/T, whose equation is linear."""

    PUSH = [System(
        [
        (T, (P[0] * D + P[1]) * E * (1.0 - T) + (GAMMA - 1) * T),
        (D, D),
        (E, P[2] * E),
    ]
    )]
    HOLD = [System([(T, P[0] * (1.0 - T))])]

    def pressure(self, states, _):
        return super().pressure(1 / states[:1], _)


class NaturalTime(Plain):
    """The exchange times ((T − Tw)/20 K)^n. T in units of Tw above Tw; it begins a moment after the start, where the power
    has no Taylor series, with an adiabatic compression less the heat that went first. The hold with its logarithm."""

    _s = P[2] - S
    PUSH = [System([(T, (1.0 + T) * ((P[0] * _s * _s + P[1]) * T ** P[3] + 2 * (GAMMA - 1) / _s))])]
    HOLD = [System([(T, -P[0] * (1.0 + hy.exp(T)) * hy.exp(P[1] * T))])]
    MOMENT = 1e-4
    VARIABLE = staticmethod(lambda e: e)

    def __init__(self, cases):
        super().__init__(cases)
        self.exponent = self.column("natural_convection.exponent")
        self.factor = TW * (TW / scenario.REFERENCE_DIFFERENCE) ** self.exponent

    def push(self):
        s, n = self.sealed, self.exponent
        lateral, faces = (2 / s.volume_rate * a * self.factor for a in (s.lateral, s.faces))
        begin, end = np.sqrt(s.volume), np.sqrt(s.held_volume)
        moment = self.MOMENT * (begin - end)
        above = (begin / (begin - moment)) ** (2 * (GAMMA - 1)) - 1
        above = above + (lateral * s.volume + faces) * above ** (1 + n) * moment / (2 + n)
        span = map(self.VARIABLE, (moment, begin - end))
        return Stretch([lateral, faces, begin, 1 + n], *span, [above], s.held_exchange)

    def hold(self, middle):
        s = self.sealed
        rate = s.held_exchange * self.factor
        return Stretch([rate, self.exponent], self.zero, s.hold_time, [np.log(middle[0])], rate * middle[0] ** self.exponent)

    def pressure(self, states, stretch):
        above = states if stretch == "push" else np.exp(states)
        return super().pressure(TW * (1 + above), stretch)


class NaturalInverse(NaturalTime):
    """The same, the hold with (T − Tw)^-n."""

    HOLD = [System([(T, P[0] * (1.0 + T ** P[1]))])]

    def hold(self, middle):
        n = self.exponent
        stretch = super().hold(middle)
        return dataclasses.replace(stretch, parameters=[n * stretch.parameters[0], -1 / n], start=[middle[0] ** -n])

    def pressure(self, states, stretch):
        states = states if stretch == "push" else np.log(states) / -self.exponent
        return super().pressure(states, stretch)


X, R = hy.make_vars("X", "R")
CRITICAL, LINEAR, SPREAD = 0.3, 0.999, 1 - 0.3
# Pressures over the surroundings' at which the leak changes its law, and number of the highest law: choked outflow.
CORNERS = [LINEAR, 1.0, 1 / LINEAR, 1 / CRITICAL]
CHOKED = len(CORNERS)


def leak(ratio, law):
    """ISO 6358's psi by the number of the law that holds."""
    r = hy.select(hy.lt(law, 1.5), ratio, 1.0 / ratio)
    subsonic = lambda r: (1 - ((r - CRITICAL) / SPREAD) ** 2.0) ** 0.5
    linear = (1 - ((LINEAR - CRITICAL) / SPREAD) ** 2) ** 0.5 / (1 - LINEAR) * (1 - r)
    near = hy.logical_and([hy.gt(law, 0.5), hy.lt(law, 2.5)])
    return hy.select(near, linear, subsonic(r))


def flows(exchange, expansion, volume, dt, chokes):
    """Rates of X = √(T/Tw) and R = √(m0/m), in which they are polynomials while the leak chokes, with P[0] (inflow)/m0,
    P[1] C ρ0 R √(T0 Tw), P[2] P0 V0/Pamb and P[3] the law of the leak; `dt` belongs to the independent variable."""
    inward, outward = P[0] * R * R, P[1] * X / volume
    if not chokes:
        share, out = leak(P[2] * X * X / (R * R * volume), P[3]), hy.gt(P[3], 1.5)
        inward = inward + hy.select(out, 0.0, P[1] / P[2] * R * R * share)
        outward = outward * hy.select(hy.gt(P[3], 3.5), 1.0, hy.select(out, share, 0.0))
    inward, outward = inward * dt, outward * dt
    gas = X * (exchange * R * (1.0 - X * X) - expansion - (GAMMA - 1) * outward) + inward * (GAMMA / X - X)
    return [(X, 0.5 * gas), (R, 0.5 * R * (outward - inward))]


def corners(volume):
    """Where the leak changes its law: there a step ends and the other law begins."""

    def other_law(corner):
        def change(integrator, _, lane):
            law = integrator.pars[3, lane]
            integrator.pars[3, lane] = corner + 1 if law == corner else corner
            return True

        return change

    excess = lambda ratio: P[2] * X * X - ratio * R * R * volume
    return [hy.t_event_batch(excess(ratio), callback=other_law(i)) for i, ratio in enumerate(CORNERS)]


class FlowsRoot(Plain):
    """A leak after ISO 6358 and a constant inflow, with √V as the independent variable of the push. Rows whose leak
    chokes all the time go apart, as their equations are simpler; in the others a step ends where the law changes."""

    _push = (P[4] * S * S + P[5], 2 * (GAMMA - 1) / S, S * S, S)
    _hold = (P[4], 0.0, 1.0, 1.0)
    PUSH = [System(flows(*_push, chokes=True)), System(flows(*_push, chokes=False), corners(S * S))]
    HOLD = [System(flows(*_hold, chokes=True)), System(flows(*_hold, chokes=False), corners(1.0))]

    def __init__(self, cases):
        super().__init__(cases)
        s = self.sealed
        self.mass = s.mass_gas_constant / scenario.GAS_CONSTANT
        self.inflow = self.column("mass_flow_in_kg_per_s") / self.mass
        conductance = self.column("leakage.conductance_m3_per_s_pa") * scenario.REFERENCE_DENSITY
        self.leak = conductance * scenario.GAS_CONSTANT * math.sqrt(scenario.LEAK_TEMPERATURE * TW)
        self.ratio = s.mass_gas_constant * TW / scenario.AMBIENT_PRESSURE

    def stretch(self, volume, span, flows, exchange, states, time):
        """With the law that holds at first. Even if all the heat went at once and nothing flowed in, the pressure would not
        fall below the last but one of these figures."""
        s = self.sealed
        inflow, leak, ratio = flows
        pressure = self.ratio * states[0] ** 2 / (states[1] ** 2 * volume)
        lowest = self.ratio / (states[1] ** 2 * volume) * np.exp(-self.leak / s.held_volume * states[0] * time)
        law = np.searchsorted(CORNERS, pressure).astype(float)
        which = (lowest < 1 / CRITICAL).astype(int)
        return Stretch([inflow, leak, ratio, law, *exchange], *span, states, s.held_exchange, which)

    def push(self):
        s, rate = self.sealed, 2 / self.sealed.volume_rate
        span = np.sqrt(s.volume), np.sqrt(s.held_volume)
        exchange = [rate * s.lateral * TW, rate * s.faces * TW]
        states = [self.zero + 1, self.zero + 1]
        return self.stretch(s.volume, span, (rate * self.inflow, rate * self.leak, self.ratio), exchange, states, s.push_time)

    def hold(self, middle):
        s = self.sealed
        flows = self.inflow, self.leak / s.held_volume, self.ratio / s.held_volume
        return self.stretch(s.held_volume, (self.zero, s.hold_time), flows, [s.held_exchange * TW], middle, s.hold_time)

    def pressure(self, states, _):
        return super().pressure(TW * states[:1] ** 2 / states[1] ** 2, _)
