//! What goes into one period and comes out of it: the structures of include/rtec.h.

use crate::wanted::{AXES, SIGNALS};

/// What the control and the signals say in one period. The same as `rtec_inputs` of include/rtec.h.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Inputs {
    /// `joint.N.pos-cmd` of X, Y, Z, mm.
    pub position: [f64; AXES],
    /// Tool offset in force, mm.
    pub tool_offset: [f64; AXES],
    /// Signals in the order of the image.
    pub signal: [f64; SIGNALS],
    /// Seconds since each was read, as the signals' component knew at its last message.
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
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Outputs {
    /// Correction in force: to be added to commands and taken out of feedback, mm.
    pub correction: [f64; AXES],
    /// Of the model wanted, mm; zero where `parts` leaves it out.
    pub model: [f64; AXES],
    /// Of the table wanted, mm; zero where `parts` leaves it out, and while probing.
    pub table: [f64; AXES],
    /// Where the tool was at the last touch, by [6876 §3.3] COORDS_ACTUAL, machine coordinates, mm. The model as it knew its
    /// signals then; without any reading yet it is the command.
    pub latch: [f64; AXES],
    /// Signals in use.
    pub in_use: [f64; SIGNALS],
    /// Age of the oldest signal in use, s.
    pub oldest_age_s: f64,
    /// One of [`Phase`].
    pub phase: i32,
    /// One of [`Fault`], 0 without. From the beginning of leaving until `enable` goes off.
    pub fault: i32,
    /// Signal that the fault is about; without a fault the first bad one. −1: none, or all of them (watchdog).
    pub fault_signal: i32,
    /// In phase waiting: one of [`WaitsFor`]; otherwise 0.
    pub waits_for: i32,
    /// What is wrong with the first bad signal, one of [`Fault`], whether the correction is asked for or not; 0: nothing.
    pub signal_fault: i32,
    /// Whether the correction is in force: from when it first was what is wanted until it leaves. It stays on where a jump
    /// of what is wanted is being slewed.
    pub enabled: bool,
    /// Whether any correction is added.
    pub active: bool,
    /// Whether the table has a row for this place.
    pub on_path: bool,
    /// Whether the program shall be paused.
    pub pause: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            limit_mm: 0.150,
            slew_mm_per_s: 5.0,
            resolution_mm: 0.0,
            stale_s: 10.0,
            freeze_s: 30.0,
            leave_s: 5.0,
            watchdog_s: 2.0,
            off_path_s: 0.1,
            parts: MODEL_PART | TABLE_PART,
            probe_corrected: false,
            pause_program: true,
        }
    }
}

/// Bit of `parts`: the model.
pub const MODEL_PART: u32 = 1;
/// Bit of `parts`: the table.
pub const TABLE_PART: u32 = 2;
