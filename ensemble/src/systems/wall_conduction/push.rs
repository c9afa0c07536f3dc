//! The push with a conducting wall and no other effect, in lanes: beside the gas temperature, as in [`crate::systems::sealed`], the modes of
//! the wall over their weights k are states. With the same transformed time, and the symbols of [`crate::conduction`],
//!
//! T'/T = q − 4 (γ − 1) w'/w,  q = c p (a1 w⁴ + a0) w (Ts − T),  Ts = Tw + Σ k y,  y' = f p w T (T − Ts) − μ p w³ y
//!
//! f is c m cv over the wall's effusivity, so that b is f/√V in the hold. The state of the gas is z = 1/√T, nearly linear in the
//! transformed time, as in [`crate::general`]: one division, 1/(z w), gives all quotients. T in K, V in m³, energies over m cv.

use crate::integrator::advance::LONGEST_OF_MOVE;
use crate::integrator::problem::Problem;
use crate::integrator::step::{LaneSystem, Moment, View};
use crate::lanes::{Lanes, multiply_add};
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::TestSystem;
use chamber::effects::wall_conduction::{KERNEL, MODES, Mode};
use chamber::effects::{EffectSet, WallConduction};
use chamber::real::Real;
use core::hint::black_box;

/// The only effect on the gas that such tests have.
pub const EFFECT: EffectSet = WallConduction::SET;

/// States: z, then the modes over their weights.
pub const N: usize = 1 + MODES;

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// The gas and its time transformation, for a wall that does not warm.
    pub gas: SealedTest,
    /// f.
    feed: f64,
    /// a and b of the hold.
    pub held: [f64; 2],
}

impl Test {
    /// From a checked scenario.
    pub fn new(s: &Scenario) -> Self {
        let gas = <SealedTest as TestSystem<1>>::new(s);
        let [lateral, _] = s.chamber.geometry.area_constants();
        let coefficient = gas.closed.exchange[0] / lateral;
        let inverse_effusivity = s.chamber.effects.of(WallConduction::INDEX)[0];
        let closed = &gas.closed;
        let feed = inverse_effusivity * coefficient * closed.mass_gas_constant / closed.expansion;
        let cooling = (closed.exchange[0] * gas.held_volume + closed.exchange[1]) / feed;
        Self { gas, feed, held: [cooling, gas.rate / (closed.ambient_temperature * cooling)] }
    }

    /// The push, to be integrated to a relative tolerance. The modes start from rest.
    pub fn push(&self, s: &Scenario, relative: f64) -> Problem<N> {
        let (mut state, mut absolute) = ([0.0; N], [0.0; N]);
        state[0] = 1.0 / s.initial_temperature_k.sqrt();
        for mode in 0..MODES {
            // The same tolerance for the wall's surface as for the gas.
            absolute[1 + mode] = relative * s.initial_temperature_k / KERNEL[mode].weight;
        }
        let mut push = Problem::new(s.push_time_s, state, absolute);
        push.longest = LONGEST_OF_MOVE * push.length;
        push.first = push.longest;
        push
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    /// For a wall that does not warm.
    gas: sealed::Moving,
    /// f p.
    feed: Lanes,
}

impl LaneSystem<N> for Moving {
    type Row = Test;
    const CHEAP: bool = false;

    #[inline(always)]
    fn load(&mut self, lane: usize, Test { gas, feed, .. }: &Test) {
        self.gas.load(lane, gas);
        self.feed[lane] = feed * gas.transformation.pace_factor;
    }

    #[inline(always)]
    fn rates(&self, s: Lanes, y: &[Lanes; N]) -> Moment<N> {
        let root = self.gas.transformation.root(s);
        let square = root * root;
        let per_both = (root * y[0]).recip();
        let (per_root, root_temperature) = (per_both * y[0], per_both * root);
        let temperature = root_temperature * root_temperature;
        // In two sums, to shorten the dependency chain.
        let mut surface = [self.gas.wall, Lanes::ZERO];
        macro_rules! warm {
            ($($mode:literal)*) => {
                $(let weight = Lanes::from(KERNEL[$mode].weight);
                surface[$mode % 2] = multiply_add::<true>(y[1 + $mode], weight, surface[$mode % 2]);)*
            };
        }
        warm!(0 1 2 3 4 5 6 7 8);
        let colder = surface[0] + surface[1] - temperature;
        let (heat, work) = (self.gas.exchange_at([root, square]) * colder, self.gas.expansion_rate * per_root);
        let drive = -(self.feed * root * temperature * colder);
        let fading = -(self.gas.transformation.pace_factor * (square * root));
        let mut slope = [y[0] * 0.5 * (work - heat); N];
        for mode in 0..MODES {
            // Otherwise the compiler vectorises across modes instead of lanes.
            let Mode { rate, .. } = *black_box(&KERNEL[mode]);
            slope[1 + mode] = multiply_add::<true>(fading * rate, y[1 + mode], drive);
        }
        Moment { slope, view: View::NONE, power: [temperature * heat, temperature * work] }
    }
}
