//! Sets of effects, by their indices in the list.

/// A set of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct EffectSet(u32);

impl EffectSet {
    /// No effect: the paper's model.
    pub const NONE: EffectSet = EffectSet(0);

    /// The set of the one effect at that index in the list.
    pub const fn one(index: usize) -> Self {
        Self(1 << index)
    }
    /// The set of the effects whose entries are true.
    pub(super) const fn of<const COUNT: usize>(is_in: [bool; COUNT]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < COUNT {
            bits |= (is_in[i] as u32) << i;
            i += 1;
        }
        Self(bits)
    }
    /// The set as a number, one bit per effect at its index in the list.
    pub const fn bits(self) -> u32 {
        self.0
    }
    /// The set with these bits, all within the list.
    pub(super) const fn of_bits(bits: u32) -> Self {
        Self(bits)
    }
    /// Whether the effect at that index is in the set.
    #[inline(always)]
    pub const fn has(self, index: usize) -> bool {
        self.0 & (1 << index) != 0
    }
    /// Effects of either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    /// Effects of this set that are not in the other.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
    /// Whether every effect of `other` is in this set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
    /// Effects of both sets.
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
    /// Indices of its effects, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let first = (rest != 0).then_some(rest.trailing_zeros() as usize);
            rest &= rest.wrapping_sub(1);
            first
        })
    }
}

impl FromIterator<usize> for EffectSet {
    /// The set of the effects at these indices in the list.
    fn from_iter<I: IntoIterator<Item = usize>>(indices: I) -> Self {
        indices.into_iter().fold(Self::NONE, |set, index| set.union(Self::one(index)))
    }
}
