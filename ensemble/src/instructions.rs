//! The instruction sets that lanes are computed with.

use pulp::Arch;

/// An instruction set of this machine. Results differ between sets in their last digits, as some fuse multiplication and
/// addition.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(pub(crate) Arch);

impl Default for InstructionSet {
    /// The widest instruction set of this processor.
    fn default() -> Self {
        Self(Arch::new())
    }
}

impl InstructionSet {
    /// All of this machine that the kernel is compiled for, with their names.
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
