//! Phases of an instance's life cycle, and the functions allowed in each: the standard's state machine as a table.

/// Phase of the life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated = 0,
    /// In initialization mode.
    Initialization = 1,
    /// Between steps of co-simulation.
    Step = 2,
    /// After termination: values can be read, but the simulation is over.
    Terminated = 3,
    /// In event mode.
    Event = 4,
    /// In continuous-time mode of Model Exchange.
    Continuous = 5,
}

impl Phase {
    /// All phases, for saved states and tests.
    pub const ALL: [Phase; 6] =
        [Phase::Instantiated, Phase::Initialization, Phase::Step, Phase::Terminated, Phase::Event, Phase::Continuous];

    /// Phases before the end of initialization, where fixed parameters can be set.
    pub const BEFORE: [Phase; 2] = [Phase::Instantiated, Phase::Initialization];
    /// Phases of a running simulation, after initialization.
    pub const RUNNING: [Phase; 3] = [Phase::Step, Phase::Event, Phase::Continuous];
    /// Phases in which variables can be set.
    pub const SETTABLE: [Phase; 5] =
        [Phase::Instantiated, Phase::Initialization, Phase::Step, Phase::Event, Phase::Continuous];
    /// Phases in which outputs are known.
    pub const KNOWN: [Phase; 5] =
        [Phase::Initialization, Phase::Step, Phase::Event, Phase::Continuous, Phase::Terminated];
    /// Phases in which a host that integrates may get states, rates and indicators.
    pub const EXCHANGE: [Phase; 4] = [Phase::Initialization, Phase::Event, Phase::Continuous, Phase::Terminated];

    /// Description of the phase, for a refusal.
    pub fn description(self) -> &'static str {
        match self {
            Phase::Instantiated => "before initialization mode",
            Phase::Initialization => "in initialization mode",
            Phase::Step => "after initialization mode",
            Phase::Terminated => "after fmi2Terminate",
            Phase::Event => "in event mode",
            Phase::Continuous => "in continuous-time mode",
        }
    }

    /// Whether initialization is over.
    pub fn is_started(self) -> bool {
        !Self::BEFORE.contains(&self)
    }
}
