//! What the corrector may be doing, what it may wait for, and why it stops.

/// What the corrector is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Phase {
    /// Not asked for.
    Off = 0,
    /// Asked for, and waiting for one of [`WaitsFor`]: zero, or on the way there.
    Waiting = 1,
    /// On the way to what is wanted, as fast as the slew allows.
    Ramping = 2,
    /// What is wanted is in force.
    InForce = 3,
    /// A signal is bad; its last good reading stands in for it.
    Frozen = 4,
    /// A signal stayed bad: the correction fades to zero, and does not come back.
    Leaving = 5,
    /// Faulted: zero, or on the way there, until `enable` goes off.
    Faulted = 6,
}

/// Why the correction was taken out. It stays until `enable` goes off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Fault {
    /// A correction beyond the limit.
    Limit = 1,
    /// A position, tool offset or correction that is not a number.
    NotANumber = 2,
    /// The drive would leave its travel.
    Travel = 3,
    /// A signal is older than it may be.
    Stale = 4,
    /// A signal outside the range in which the model holds, or not a number.
    Range = 5,
    /// A signal that jumped.
    Jump = 6,
    /// The signals' component is silent.
    Watchdog = 7,
    /// Another program runs than the one that the table belongs to.
    Program = 8,
    /// A block of the table is cut elsewhere than the table says.
    OffPath = 9,
    /// Settings that make no sense: a limit, slew or time that is negative or not a number.
    Settings = 10,
}

/// What the correction waits for. Where there are several, the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum WaitsFor {
    /// All joints homed, and none homing.
    Homing = 1,
    /// The drives on.
    Drives = 2,
    /// The end of probing.
    Probing = 3,
    /// Every signal in order.
    Signals = 4,
}
