//! The host's inputs: values at a communication point, and their derivatives for the next step.
//!
//! u(t_k + s) = u_k + Σ d_j s^j/j!, orders 1 to 3; derivatives hold for one step. Lengths in m, flows in kg/s.

use super::values::{INPUTS, input};
use chamber::balance::Boundary;
use chamber::real::Real;

/// Highest order of an input's derivatives.
pub const ORDERS: usize = 3;

/// Inputs as set by the host, and at the present time.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    /// Values last set by the host.
    pub value: [f64; INPUTS],
    /// Derivatives for the next step, by order.
    pub derivative: [[f64; ORDERS]; INPUTS],
    /// Whether a derivative of the input was set since the last step.
    pub has_derivative: [bool; INPUTS],
    /// Value at the present time: the host's, or the end value of its extrapolation over the last step.
    pub now: [f64; INPUTS],
    /// Rate at the present time.
    pub rate: [f64; INPUTS],
}

impl Inputs {
    /// Constant inputs with these values.
    pub fn new(value: [f64; INPUTS]) -> Self {
        Self {
            value,
            derivative: [[0.0; ORDERS]; INPUTS],
            has_derivative: [false; INPUTS],
            now: value,
            rate: [0.0; INPUTS],
        }
    }

    /// Sets an input.
    pub fn set(&mut self, index: usize, value: f64) {
        self.value[index] = value;
        self.now[index] = value;
        if !self.has_derivative[index] {
            self.rate[index] = 0.0;
        }
    }

    /// Sets a derivative of an input, of order 1 or more.
    pub fn set_derivative(&mut self, index: usize, order: usize, value: f64) {
        self.derivative[index][order - 1] = value;
        self.has_derivative[index] = true;
        if order == 1 {
            self.rate[index] = value;
        }
    }

    /// Whether only the position changes within the step, linearly.
    pub fn is_plain(&self) -> bool {
        self.has_derivative == [false; INPUTS]
    }

    /// Whether a port is open, now or within the step.
    pub fn opens_ports(&self) -> bool {
        [input::SUPPLY_PORT, input::EXHAUST_PORT]
            .iter()
            .any(|port| self.value[port + 2] != 0.0 || self.has_derivative[port + 2])
    }

    /// Value of an input, `s` seconds into the step.
    #[inline]
    fn at(&self, index: usize, s: f64) -> f64 {
        let [first, second, third] = self.derivative[index];
        self.value[index] + s * (first + s * (second / 2.0 + s * (third / 6.0)))
    }

    /// Rate of an input, `s` seconds into the step.
    fn rate_at(&self, index: usize, s: f64) -> f64 {
        let [first, second, third] = self.derivative[index];
        first + s * (second + s * (third / 2.0))
    }

    /// Position and speed of the piston according to the inputs, `s` seconds into the step.
    #[inline]
    pub fn stroke(&self, s: f64) -> (f64, f64) {
        if self.has_derivative[input::POSITION] {
            return (self.at(input::POSITION, s), self.rate_at(input::POSITION, s));
        }
        self.travel_from(self.value[input::POSITION], s)
    }

    /// Position and speed of a piston moved by the velocity input alone from `begin`, m.
    #[inline]
    pub fn travel_from(&self, begin: f64, s: f64) -> (f64, f64) {
        let [first, second, third] = self.derivative[input::VELOCITY];
        let start = self.value[input::VELOCITY];
        let travel = s * (start + s * (first / 2.0 + s * (second / 6.0 + s * (third / 24.0))));
        (begin + travel, self.at(input::VELOCITY, s))
    }

    /// All inputs, `s` seconds into the step; position and velocity are the stroke's.
    #[inline]
    pub fn values(&self, s: f64) -> [f64; INPUTS] {
        let mut values: [f64; INPUTS] = core::array::from_fn(|i| self.at(i, s));
        (values[input::POSITION], values[input::VELOCITY]) = self.stroke(s);
        values
    }

    /// Advances by a step of `h` seconds: present values are extrapolated, and derivatives are used up.
    pub fn advance(&mut self, h: f64) {
        if self.is_plain() {
            self.now = self.value;
            self.now[input::POSITION] += self.value[input::VELOCITY] * h;
            self.rate = [0.0; INPUTS];
            self.rate[input::POSITION] = self.now[input::VELOCITY];
        } else {
            *self = self.extrapolated(h);
        }
    }

    /// Inputs after a step of `h` seconds, extrapolated with their derivatives.
    fn extrapolated(&self, h: f64) -> Self {
        let mut next = self.clone();
        next.now = core::array::from_fn(|i| self.at(i, h));
        next.rate = core::array::from_fn(|i| self.rate_at(i, h));
        (next.now[input::POSITION], next.now[input::VELOCITY]) = self.stroke(h);
        if self.has_derivative[input::POSITION] {
            let [_, second, third] = self.derivative[input::POSITION];
            next.rate[input::VELOCITY] = second + h * third;
        }
        next.rate[input::POSITION] = next.now[input::VELOCITY];
        next.derivative = [[0.0; ORDERS]; INPUTS];
        next.has_derivative = [false; INPUTS];
        next
    }

    /// Present values, with the piston's actual speed.
    pub fn present(&self) -> [f64; INPUTS] {
        let mut now = self.now;
        if self.has_derivative[input::POSITION] {
            now[input::VELOCITY] = self.derivative[input::POSITION][0];
        }
        now
    }

    /// Rates of the present values.
    pub fn present_rate(&self) -> [f64; INPUTS] {
        let mut rate = self.rate;
        rate[input::POSITION] = self.present()[input::VELOCITY];
        if self.has_derivative[input::POSITION] {
            rate[input::VELOCITY] = self.derivative[input::POSITION][1];
        }
        rate
    }

    /// Passes to `take` the times within a step of `h` seconds at which a linear speed or flow changes sign, where the balance
    /// has kinks.
    pub fn sign_changes(&self, h: f64, mut take: impl FnMut(f64)) {
        let speed = if self.has_derivative[input::POSITION] {
            let [first, second, third] = self.derivative[input::POSITION];
            (first, second, third)
        } else {
            let [first, second, _] = self.derivative[input::VELOCITY];
            (self.value[input::VELOCITY], first, second)
        };
        let flow = |i: usize| (self.value[i], self.derivative[i][0], self.derivative[i][1]);
        for (value, slope, curvature) in [speed, flow(input::MASS_FLOW_IN), flow(input::MASS_FLOW_OUT)] {
            let zero = -value / slope;
            if curvature == 0.0 && zero > 0.0 && zero < h {
                take(zero);
            }
        }
    }
}

/// The boundary for these input values. A negative flow is one in the other direction.
#[inline(always)]
pub fn boundary<R: Real>(u: &[R; INPUTS]) -> Boundary<R> {
    let (inward, outward) = (u[input::MASS_FLOW_IN], u[input::MASS_FLOW_OUT]);
    // At zero the derivative is that of the forward direction.
    let forward = |flow: R| (-flow).where_positive(R::ZERO, flow);
    let backward = |flow: R| (-flow).where_positive(-flow, R::ZERO);
    Boundary {
        position: u[input::POSITION],
        velocity: u[input::VELOCITY],
        mass_flow_in: forward(inward) + backward(outward),
        temperature_in: u[input::TEMPERATURE_IN],
        mass_flow_out: forward(outward) + backward(inward),
        ambient_temperature: u[input::AMBIENT_TEMPERATURE],
        ambient_pressure: u[input::AMBIENT_PRESSURE],
    }
}

#[cfg(test)]
mod tests {
    use super::super::values::start_inputs;
    use super::*;

    fn moving() -> Inputs {
        let mut values = start_inputs(0.1, 293.0, 1e5);
        values[input::VELOCITY] = 0.2;
        values[input::MASS_FLOW_IN] = 1e-3;
        values[input::MASS_FLOW_OUT] = -2e-3;
        Inputs::new(values)
    }

    #[test]
    fn without_derivatives_the_velocity_moves_the_piston() {
        let b = moving().values(0.5);
        assert_eq!((b[input::POSITION], b[input::VELOCITY]), (0.2, 0.2));
        let mut later = moving();
        later.advance(0.5);
        assert_eq!(later.now[input::POSITION], 0.2);
    }

    #[test]
    fn the_position_s_derivative_replaces_the_velocity() {
        let mut u = moving();
        u.set_derivative(input::POSITION, 1, -0.04);
        u.set_derivative(input::POSITION, 2, 0.02);
        assert_eq!(u.stroke(1.0), (0.1 - 0.04 + 0.01, -0.04 + 0.02));
        let mut next = u.clone();
        next.advance(1.0);
        assert_eq!(next.now[input::VELOCITY], -0.02);
        assert_eq!(next.rate[input::VELOCITY], 0.02);
        assert!(next.is_plain());
    }

    #[test]
    fn an_accelerated_piston_moves_by_the_integral_of_its_velocity() {
        let mut u = moving();
        u.set_derivative(input::VELOCITY, 1, -0.4);
        let (x, v) = u.stroke(0.5);
        assert!((x - (0.1 + 0.1 - 0.05)).abs() < 1e-16 && v.abs() < 1e-16);
    }

    #[test]
    fn a_negative_outflow_enters() {
        let b = boundary(&moving().value);
        assert_eq!((b.mass_flow_in, b.mass_flow_out), (3e-3, 0.0));
    }

    #[test]
    fn a_flow_that_reverses_within_the_step_breaks_it_there() {
        let mut u = moving();
        u.set_derivative(input::MASS_FLOW_IN, 1, -1e-2);
        u.set_derivative(input::VELOCITY, 1, -4.0);
        let mut times = Vec::new();
        u.sign_changes(1.0, |t| times.push(t));
        times.sort_by(f64::total_cmp);
        assert_eq!(times.len(), 2);
        assert!((times[0] - 0.05).abs() < 1e-15 && (times[1] - 0.1).abs() < 1e-15);
    }
}
