//! The parameters of all effects.

use super::{CARDS, COUNT, EffectSet, PARAMETER_OFFSETS, PARAMETERS};
use crate::real::Real;

/// The effect that owns each parameter, as its bit of [`EffectSet::bits`].
const OWNERS: [u32; PARAMETERS] = {
    let mut out = [0; PARAMETERS];
    let mut i = 0;
    while i < COUNT {
        let mut index = PARAMETER_OFFSETS[i];
        while index < PARAMETER_OFFSETS[i + 1] {
            out[index] = EffectSet::one(i).bits();
            index += 1;
        }
        i += 1;
    }
    out
};

/// A value for each parameter of each effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectValues<R = f64>(pub [R; PARAMETERS]);

impl EffectValues<f64> {
    /// Each parameter at its neutral value.
    pub const NEUTRAL: Self = {
        let mut values = [0.0; PARAMETERS];
        let mut i = 0;
        while i < COUNT {
            let mut j = 0;
            while j < CARDS[i].parameters.len() {
                values[PARAMETER_OFFSETS[i] + j] = CARDS[i].parameters[j].neutral;
                j += 1;
            }
            i += 1;
        }
        Self(values)
    };

    /// These values with the effects in `set` at their neutral values.
    pub fn without(mut self, set: EffectSet) -> Self {
        for index in set.iter() {
            self.of_mut(index).copy_from_slice(Self::NEUTRAL.of(index));
        }
        self
    }

    /// These values with the effects in `set` at their typical values.
    pub fn with_typical(mut self, set: EffectSet) -> Self {
        for index in set.iter() {
            self.of_mut(index).iter_mut().zip(CARDS[index].parameters).for_each(|(to, p)| *to = p.typical);
        }
        self
    }

    /// These values with the first parameters of the effect at that index in the list replaced.
    pub fn with(mut self, index: usize, first: &[f64]) -> Self {
        self.of_mut(index)[..first.len()].copy_from_slice(first);
        self
    }

    /// The effects whose parameters are not all neutral.
    pub fn active(&self) -> EffectSet {
        // Branch-free, because kernels evaluate this for every row.
        let mut bits = 0;
        for (index, owner) in OWNERS.iter().enumerate() {
            bits |= if self.0[index] != Self::NEUTRAL.0[index] { *owner } else { 0 };
        }
        EffectSet::from_bits(bits)
    }
}

impl<R: Real> EffectValues<R> {
    /// The parameters of the effect at that index in the list, in its card's order.
    pub fn of(&self, index: usize) -> &[R] {
        &self.0[PARAMETER_OFFSETS[index]..PARAMETER_OFFSETS[index + 1]]
    }

    /// The same, mutable.
    pub fn of_mut(&mut self, index: usize) -> &mut [R] {
        &mut self.0[PARAMETER_OFFSETS[index]..PARAMETER_OFFSETS[index + 1]]
    }

    /// The same values in another number type.
    pub fn lift<S: Real + From<R>>(self) -> EffectValues<S> {
        EffectValues(self.0.map(S::from))
    }
}
