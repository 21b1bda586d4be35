//! A machine as it is, its planner and its signals, and what may go wrong with them.

use super::virtual_machine::{Dice, Planner};
use super::*;

pub(super) const END: f64 = 25.0;
pub(super) const HALF_BACKLASH: f64 = 0.008;

/// The machine as it is: E of one axis at its drive's position. All of it grows with the temperature.
pub(super) fn truth(axis: usize, drive: f64, direction: f64, degrees: f64) -> f64 {
    let phase = axis as f64;
    let shape = 0.03 * (drive / 11.0 + phase).sin() + 4e-4 * drive + 0.01;
    (shape + HALF_BACKLASH * direction) * warmth(degrees)
}

pub(super) fn warmth(degrees: f64) -> f64 {
    1.0 + 0.02 * (degrees - 20.0)
}

/// What may go wrong, each for a time.
const KINDS: usize = 20;
const LOST: usize = 0;
const JUMPED: usize = 1;
const IMPOSSIBLE: usize = 2;
const INFINITE: usize = 3;
const OLD: usize = 4;
const AGE_UNKNOWN: usize = 5;
const SILENT: usize = 6;
const DRIVES_OFF: usize = 7;
const HOMING: usize = 8;
const PROBING: usize = 9;
const PROBING_MOVE: usize = 10;
const PROGRAM: usize = 11;
const ANOTHER_PROGRAM: usize = 12;
const TOOL_UNKNOWN: usize = 13;
const TOUCH: usize = 14;
const ENABLE_OFF: usize = 15;
const ENABLE_KEPT: usize = 16;
pub(super) const COARSE: usize = 17;
const SETTINGS: usize = 18;
const LIMIT: usize = 19;

/// What is wrong now, by kind: periods left.
pub(super) struct World {
    pub(super) dice: Dice,
    left: [usize; KINDS],
    pub(super) injected: [usize; KINDS],
    axes: [Planner; AXES],
    /// How the slide came there in truth.
    pub(super) direction: [f64; AXES],
    /// Whether the command has said so since homing.
    pub(super) told: [bool; AXES],
    /// Periods since the drives are on and everything is homed.
    periods: usize,
    /// Drives as they stand.
    pub(super) drive: [f64; AXES],
    pub(super) degrees: f64,
    /// Which of two images: they hold the temperature as signal 0 or 1.
    pub(super) image: usize,
}

impl World {
    pub(super) fn new(seed: u64, acceleration: f64) -> Self {
        Self {
            dice: Dice::new(seed),
            left: [0; KINDS],
            injected: [0; KINDS],
            axes: [Planner::at(0.0, acceleration); AXES],
            direction: [1.0; AXES],
            told: [false; AXES],
            periods: 0,
            drive: [0.0; AXES],
            degrees: 20.0,
            image: 0,
        }
    }

    pub(super) fn has(&self, kind: usize) -> bool {
        self.left[kind] > 0
    }

    pub(super) fn strike(&mut self) {
        self.left
            .iter_mut()
            .for_each(|left| *left = left.saturating_sub(1));
        if self.dice.once_in(25) {
            let kind = self.dice.of(KINDS);
            let longest = [2, 10, 120][self.dice.of(3)];
            self.left[kind] = 1 + self.dice.of(longest);
            self.injected[kind] += 1;
        }
        self.degrees = (self.degrees + self.dice.between(-0.01, 0.01)).clamp(15.0, 35.0);
    }

    /// Moves on; an aborted machine coasts, and its command follows the feedback.
    pub(super) fn move_axes(
        &mut self,
        correction: [f64; AXES],
        on: bool,
        homed: bool,
    ) -> [f64; AXES] {
        self.periods = if on && homed { self.periods + 1 } else { 0 };
        for (axis, correction) in correction.into_iter().enumerate() {
            let before = self.axes[axis].position;
            self.told[axis] &= homed;
            if !on {
                self.coast(axis, correction);
            } else if self.periods == 1 {
                self.axes[axis].velocity = 0.0;
            } else {
                self.choose_target(axis);
                self.axes[axis].step(PERIOD);
                self.turn(axis, self.axes[axis].position - before);
            }
        }
        self.axes.map(|axis| axis.position)
    }

    fn turn(&mut self, axis: usize, moved: f64) {
        if moved.abs() > 1e-9 {
            self.direction[axis] = moved.signum();
            self.told[axis] |= self.periods > 1;
        }
    }

    fn choose_target(&mut self, axis: usize) {
        let (dice, planner) = (&mut self.dice, &mut self.axes[axis]);
        let rests = planner.velocity == 0.0 && dice.once_in(60);
        if rests || dice.once_in(200) {
            let end = if dice.once_in(2) { END } else { -END };
            let near = end - end.signum() * dice.between(0.0, 0.4);
            let target = [
                near,
                end,
                dice.between(-END, END),
                planner.position + dice.between(-3.0, 3.0),
            ][dice.of(4)];
            if planner.reaches(target) && target.abs() <= END {
                (planner.target, planner.speed) = (target, dice.between(2.0, 200.0));
            }
        }
    }

    fn coast(&mut self, axis: usize, correction: f64) {
        let planner = &mut self.axes[axis];
        planner.velocity *= 0.8;
        if planner.velocity.abs() < 0.1 {
            planner.velocity = 0.0;
        }
        self.drive[axis] = (self.drive[axis] + planner.velocity * PERIOD).clamp(-END, END);
        planner.position = self.drive[axis] - correction;
        planner.target = planner.position;
    }

    /// What the control and the signals' component say in this period.
    pub(super) fn tell(&self, bench: &mut Bench) {
        self.tell_signals(&mut bench.inputs);
        let inputs = &mut bench.inputs;
        inputs.homed = !self.has(HOMING);
        inputs.machine_on = !self.has(DRIVES_OFF);
        inputs.probing = self.has(PROBING);
        inputs.motion_type = if self.has(PROBING_MOVE) { 5 } else { 2 };
        inputs.program = i32::from(self.has(PROGRAM)) + i32::from(self.has(ANOTHER_PROGRAM));
        inputs.tool_offset[1] = if self.has(TOOL_UNKNOWN) {
            f64::NAN
        } else {
            0.0
        };
        inputs.touch = self.has(TOUCH);
        inputs.enable = !self.has(ENABLE_OFF) && bench.said.fault == 0 || self.has(ENABLE_KEPT);
        bench.settings = Settings {
            slew_mm_per_s: bench.settings.slew_mm_per_s,
            limit_mm: if self.has(LIMIT) { 0.01 } else { 0.2 },
            resolution_mm: if self.has(COARSE) { 0.002 } else { 0.0 },
            freeze_s: if self.has(SETTINGS) { f64::NAN } else { 0.03 },
            stale_s: 0.05,
            leave_s: 0.06,
            watchdog_s: 0.02,
            ..Settings::default()
        };
    }

    fn tell_signals(&self, inputs: &mut Inputs) {
        let own = self.image;
        inputs.signal = [-1e9; 16];
        inputs.signal[1 - own] = 1013.0;
        inputs.signal[own] = match () {
            () if self.has(LOST) => f64::NAN,
            () if self.has(JUMPED) => self.degrees + 3.0,
            () if self.has(IMPOSSIBLE) => 1e4,
            () if self.has(INFINITE) => f64::NEG_INFINITY,
            () => self.degrees,
        };
        inputs.age_s = [0.001; 16];
        inputs.age_s[own] = match () {
            () if self.has(OLD) => 99.0,
            () if self.has(AGE_UNKNOWN) => f64::NAN,
            () => 0.001,
        };
        let message = !self.has(SILENT);
        inputs.heartbeat = inputs.heartbeat.wrapping_add(u32::from(message));
    }
}
