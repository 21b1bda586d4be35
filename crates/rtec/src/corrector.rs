//! How much of a correction is in force: phases, slew, limits, travel, and signals that are late or impossible.

use crate::wanted::{AXES, SIGNALS};

/// What the control and the signals say in one period. The same as `rtec_inputs` of include/rtec.h.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Inputs {
    /// `joint.N.pos-cmd` of X, Y, Z, mm.
    pub position: [f64; AXES],
    /// Tool offset in force, mm.
    pub tool_offset: [f64; AXES],
    /// Signals in the order of the image.
    pub signal: [f64; SIGNALS],
    /// Seconds since each was read, as the signals' component knows.
    pub age_s: [f64; SIGNALS],
    /// Length of the period, s.
    pub period_s: f64,
    /// Changes with every message of the signals' component.
    pub heartbeat: u32,
    /// `motion.program-line`.
    pub line: i32,
    /// 0: no program runs; 1: that of the image's table; 2: another.
    pub program: i32,
    /// `motion.motion-type`: 5 is probing.
    pub motion_type: i32,
    /// Whether the correction shall be in force.
    pub enable: bool,
    /// Whether all joints are homed, and none is homing.
    pub homed: bool,
    /// Whether the drives are on.
    pub machine_on: bool,
    /// Whether a probing session is going on.
    pub probing: bool,
    /// Whether the probe touches.
    pub touch: bool,
}

/// What an integrator may set. The same as `rtec_settings`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Settings {
    /// Largest correction, mm; the image's own holds where that is smaller.
    pub limit_mm: f64,
    /// How fast the correction may change, mm/s.
    pub slew_mm_per_s: f64,
    /// Smallest step of the correction, mm; 0: none.
    pub resolution_mm: f64,
    /// A reading older than this is bad, s.
    pub stale_s: f64,
    /// How long the last good reading stands in for a bad one, s.
    pub freeze_s: f64,
    /// How long the correction then takes to zero, s.
    pub leave_s: f64,
    /// Without a new heartbeat for this long every signal is bad, s.
    pub watchdog_s: f64,
    /// How long a listed block may be off its path, s.
    pub off_path_s: f64,
    /// 1: the model; 2: the table; 3: both.
    pub parts: u32,
    /// Whether the correction stays in force while probing.
    pub probe_corrected: bool,
    /// Whether a fault, or the way to it, pauses the program.
    pub pause_program: bool,
}

/// What is in force, and why. The same as `rtec_outputs`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Outputs {
    /// Correction in force: to be added to commands and taken out of feedback, mm.
    pub correction: [f64; AXES],
    /// Of the model wanted, mm.
    pub model: [f64; AXES],
    /// Of the table wanted, mm.
    pub table: [f64; AXES],
    /// Where the tool was at the last touch, by [6876 §3.3] COORDS_ACTUAL, machine coordinates, mm.
    pub latch: [f64; AXES],
    /// Signals in use.
    pub in_use: [f64; SIGNALS],
    /// Age of the oldest signal in use, s.
    pub oldest_age_s: f64,
    /// One of [`Phase`].
    pub phase: i32,
    /// One of [`Fault`], 0 without.
    pub fault: i32,
    /// Signal that the fault, or the freezing, is about; −1 without.
    pub fault_signal: i32,
    /// Whether the correction is in force.
    pub enabled: bool,
    /// Whether any correction is added.
    pub active: bool,
    /// Whether the table has a row for this place.
    pub on_path: bool,
    /// Whether the program shall be paused.
    pub pause: bool,
}

/// What the corrector is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Phase {
    /// Not asked for.
    Off = 0,
    /// Asked for, and waiting: not homed, drives off, or probing.
    Waiting = 1,
    /// On the way to what is wanted, as fast as the slew allows.
    Ramping = 2,
    /// What is wanted is in force.
    InForce = 3,
    /// A signal is bad; its last good reading stands in for it.
    Frozen = 4,
    /// A signal stayed bad: the correction goes to zero.
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
