//! Saved states: rollback, serialization into a new process, and invalid bytes.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]
#![cfg_attr(miri, feature(c_variadic))]

mod common;
#[path = "common/memory.rs"]
mod memory;

use common::Host;
use fmu::fmi2::abi::*;
use memory::MEMORY;
use proptest::prelude::*;
use std::process::Command;
use std::ptr::null_mut;

/// A running chamber with all kinds of memory: own states, delayed record, derivatives set for the next step.
fn under_way() -> Host {
    let host = Host::started(&MEMORY);
    for k in 0..50 {
        host.set("velocity", -0.3 + 0.01 * f64::from(k));
        host.step(f64::from(k) * 2e-3, 2e-3);
    }
    host.set_derivative("massFlowIn", 1, 1e-3);
    host
}

/// All outputs over further steps, as bits.
fn continued(host: &Host) -> Vec<u64> {
    let mut bits = Vec::new();
    for k in 50..90 {
        host.set("position", 0.08 + 1e-4 * f64::from(k % 7));
        host.step(f64::from(k) * 2e-3, 2e-3);
        for name in ["pressure", "measuredPressure", "temperature", "mass", "heatFlow", "wallHeating.wallTemperature"] {
            bits.push(host.get(name).to_bits());
        }
    }
    bits
}

#[test]
fn a_rolled_back_instance_continues_bit_by_bit() {
    let host = under_way();
    let saved = host.save();
    let first = continued(&host);
    host.restore(saved);
    assert_eq!(continued(&host), first);
    host.restore(saved);
    assert_eq!(unsafe { fmi2Reset(host.c) }, 0);
    host.restore(saved);
    assert_eq!(continued(&host), first, "also after a reset");
}

#[test]
fn a_serialized_state_continues_bit_by_bit_in_a_new_process() {
    const BYTES: &str = "PNEUTHERM_TEST_STATE";
    if let Ok(path) = std::env::var(BYTES) {
        let host = Host::new();
        assert_eq!(host.deserialize(&std::fs::read(&path).unwrap()), 0, "{:?}", host.messages());
        let bits: Vec<String> = continued(&host).iter().map(u64::to_string).collect();
        std::fs::write(path, bits.join(" ")).unwrap();
        return;
    }
    let host = under_way();
    let path = std::env::temp_dir().join(format!("pneutherm-state-{}", std::process::id()));
    std::fs::write(&path, host.serialized()).unwrap();
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "a_serialized_state_continues_bit_by_bit_in_a_new_process"])
        .env(BYTES, &path)
        .output()
        .unwrap();
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));
    let bits: Vec<u64> = std::fs::read_to_string(&path).unwrap().split(' ').map(|bits| bits.parse().unwrap()).collect();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(bits, continued(&host));
}

#[test]
fn states_that_are_none_are_refused() {
    let (host, other) = (under_way(), under_way());
    let mut foreign = other.save();
    unsafe {
        assert_eq!(fmi2SetFMUstate(host.c, foreign), 3, "another instance's");
        assert_eq!(fmi2SetFMUstate(host.c, 64 as *mut _), 3, "no pointer at all");
        let mut own = host.save();
        let stale = own;
        assert_eq!(fmi2FreeFMUstate(host.c, &mut own), 0);
        assert!(own.is_null());
        assert_eq!(fmi2SetFMUstate(host.c, stale), 3, "freed");
        let mut twice = stale;
        assert_eq!(fmi2FreeFMUstate(host.c, &mut twice), 3, "freed twice");
        assert_eq!(fmi2FreeFMUstate(host.c, &mut foreign), 3);
    }
    assert!(host.messages().iter().all(|m| m.text.contains("no state that")));
}

#[test]
fn a_state_of_another_fmu_another_version_or_none_at_all_is_refused() {
    let host = under_way();
    for bytes in [&b""[..], b"PNTFMUS", b"something else entirely", &[0; 4096]] {
        assert_eq!(host.deserialize(bytes), 3);
        assert!(host.message().contains("its bytes do not begin like a state of this FMU"));
    }
    let mut other = host.serialized();
    other[20] ^= 1;
    let checksum = crc32fast::hash(&other[16..]);
    other[12..16].copy_from_slice(&checksum.to_le_bytes());
    assert_eq!(host.deserialize(&other), 3);
    assert!(host.message().contains("another guid"));
    for version in [0u32, 1, 2, 4, u32::MAX] {
        let mut older = host.serialized();
        older[8..12].copy_from_slice(&version.to_le_bytes());
        assert_eq!(host.deserialize(&older), 3, "version {version}");
        assert!(host.message().contains("it is of another version of the format"));
    }
    let size = host.serialized().len();
    let (state, mut small) = (host.save(), vec![0; size]);
    assert_eq!(unsafe { fmi2SerializeFMUstate(host.c, state, small.as_mut_ptr().cast(), size - 1) }, 3);
    assert_eq!(unsafe { fmi2SerializeFMUstate(host.c, state, null_mut(), size) }, 3);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_bytes_are_refused_and_change_nothing(cut in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), bit in 0..8u8) {
        let host = under_way();
        let bytes = host.serialized();
        prop_assert_eq!(host.deserialize(&bytes[..cut.index(bytes.len())]), 3);
        let mut flipped = bytes.clone();
        flipped[at.index(bytes.len())] ^= 1u8 << bit;
        prop_assert_eq!(host.deserialize(&flipped), 3);
        prop_assert_eq!(host.serialized(), bytes);
    }

    #[test]
    fn bytes_with_a_right_checksum_and_wrong_numbers_crash_nothing(at in any::<prop::sample::Index>(), value in any::<f64>()) {
        let host = under_way();
        let mut bytes = host.serialized();
        let offset = 56 + at.index((bytes.len() - 56) / 8) * 8;
        bytes[offset..offset + 8].copy_from_slice(&value.to_le_bytes());
        let checksum = crc32fast::hash(&bytes[16..]);
        bytes[12..16].copy_from_slice(&checksum.to_le_bytes());
        if host.deserialize(&bytes) == 0 {
            let mut reached = 0.0;
            unsafe { fmi2GetRealStatus(host.c, 2, &mut reached) };
            host.try_step(reached, 1e-3);
        }
        prop_assert!(host.messages().iter().all(|m| !m.text.contains("broke down")));
    }
}
