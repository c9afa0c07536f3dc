//! A chamber with all kinds of memory.

/// Parameters that switch on own states, a delayed record and a leak.
pub const MEMORY: [(&str, f64); 7] = [
    ("initialPressure", 2.5e5),
    ("wallHeating.capacity", 3.0),
    ("gasZones.massFraction", 0.2),
    ("gasZones.conductance", 0.03),
    ("sensorLag.timeConstant", 0.01),
    ("recordDelay.delay", 0.05),
    ("leakage.conductance", 1e-12),
];
