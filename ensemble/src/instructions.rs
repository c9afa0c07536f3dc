//! The instruction sets that the kernel is compiled for.
//!
//! On x86-64 the wide ones are those of 2013 (AVX2 and FMA) and 2017 (AVX-512). A processor with neither gets the closed forms and,
//! to limit the code size, a single integrator with any effects for all other rows.

use pulp::{Arch, Simd, WithSimd};

/// An instruction set of this machine. Results of different sets differ in their last digits, as some fuse multiplication and addition.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(pub(crate) Arch);

impl Default for InstructionSet {
    /// The widest instruction set of this processor.
    fn default() -> Self {
        Self(Arch::new())
    }
}

impl InstructionSet {
    /// All sets that this machine has and the kernel is compiled for, with their names.
    pub fn all() -> Vec<(&'static str, Self)> {
        let mut all = vec![("any", Self(Arch::Scalar))];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(|set| ("x86-64-v3", Self(Arch::V3(set)))));
            all.extend(pulp::x86::V4::try_new().map(|set| ("x86-64-v4", Self(Arch::V4(set)))));
        }
        #[cfg(target_arch = "aarch64")]
        all.push(("aarch64", Self(Arch::new())));
        all
    }
}

/// Whether an instruction set is a wide one.
pub fn is_wide(arch: Arch) -> bool {
    !matches!(arch, Arch::Scalar)
}

/// Work that is compiled for wide instruction sets only.
pub struct Wide<W>(pub W);

impl<W: WithSimd> WithSimd for Wide<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<I: Simd>(self, simd: I) -> W::Output {
        if I::IS_SCALAR {
            unreachable!("without wide instructions rows take another path")
        } else {
            self.0.with_simd(simd)
        }
    }
}
