//! What leads from one phase to the next.

use super::phase::{Fault, Phase, WaitsFor};
use super::readings::Bad;
use super::values::{Inputs, Settings, MODEL_PART, TABLE_PART};
use super::Corrector;

/// `motion.motion-type` of a probing move.
const PROBING_MOVE: i32 = 5;
/// `program`: another one than that of the image.
const ANOTHER_PROGRAM: i32 = 2;

/// What a period says, as far as phases depend on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    enable: bool,
    refused: Option<Fault>,
    hindrance: Option<WaitsFor>,
    bad: Option<Bad>,
    freeze_s: f64,
    leave_s: f64,
}

impl Conditions {
    pub(super) fn new(
        inputs: &Inputs,
        settings: &Settings,
        has_table: bool,
        bad: Option<Bad>,
    ) -> Self {
        Self {
            enable: inputs.enable,
            refused: refused(inputs, settings, has_table),
            hindrance: hindrance(inputs, settings),
            bad,
            freeze_s: settings.freeze_s,
            leave_s: settings.leave_s,
        }
    }
}

/// Whether the machine is probing.
pub(super) fn probes(inputs: &Inputs) -> bool {
    inputs.probing || inputs.motion_type == PROBING_MOVE
}

impl Corrector {
    /// The phase of this period, before what is wanted has been looked at.
    pub(super) fn next_phase(&mut self, now: &Conditions, period_s: f64) {
        if !now.enable {
            self.fault = None;
            self.pauses = false;
            self.enter(Phase::Off);
        } else if self.phase == Phase::Faulted {
        } else if let Some(fault) = now.refused {
            self.fail(fault.into());
        } else if self.phase == Phase::Leaving {
            self.leave(now, period_s);
        } else if now.hindrance.is_some() {
            self.enter(Phase::Waiting);
            self.spent_s = 0.0;
        } else if let Some(bad) = now.bad {
            self.stand_in(bad, now, period_s);
        } else if !matches!(self.phase, Phase::Ramping | Phase::InForce) {
            self.enter(Phase::Ramping);
        }
    }

    /// A signal is bad: its last good reading stands in for it where the correction follows, for a time.
    fn stand_in(&mut self, bad: Bad, now: &Conditions, period_s: f64) {
        if self.phase.follows() {
            self.stay(Phase::Frozen, period_s);
            if self.spent_s > now.freeze_s {
                self.fault = Some(bad);
                self.enter(Phase::Leaving);
            }
        } else {
            self.stay(Phase::Waiting, period_s);
            if self.spent_s > now.freeze_s + now.leave_s {
                self.fail(bad);
            }
        }
    }

    /// It fades; at the end, or where it has to be zero soon, the fault is there.
    fn leave(&mut self, now: &Conditions, period_s: f64) {
        self.spent_s += period_s;
        if now.hindrance.is_some() || self.spent_s >= now.leave_s {
            self.enter(Phase::Faulted);
        }
    }

    /// The first reason stays.
    pub(super) fn fail(&mut self, bad: Bad) {
        self.fault = self.fault.or(Some(bad));
        self.enter(Phase::Faulted);
    }

    fn stay(&mut self, phase: Phase, period_s: f64) {
        if self.phase == phase {
            self.spent_s += period_s;
        } else {
            self.enter(phase);
        }
    }

    fn enter(&mut self, phase: Phase) {
        if self.phase != phase {
            self.phase = phase;
            self.spent_s = 0.0;
        }
        self.reached &= !matches!(phase, Phase::Off | Phase::Waiting);
    }

    pub(super) fn is_failing(&self) -> bool {
        matches!(self.phase, Phase::Leaving | Phase::Faulted)
    }

    pub(super) fn waits_for(&self, inputs: &Inputs, settings: &Settings, bad: Option<Bad>) -> i32 {
        let signals = bad.map(|_| WaitsFor::Signals);
        match hindrance(inputs, settings).or(signals) {
            Some(reason) if self.phase == Phase::Waiting => reason as i32,
            _ => 0,
        }
    }
}

impl Phase {
    /// Whether the correction is on the way to what is wanted, or there, or to a share of it.
    pub(super) fn follows(self) -> bool {
        self.is_in_force() || self == Self::Leaving
    }

    /// Whether the whole of what is wanted is in force, or on the way to be.
    pub(super) fn is_in_force(self) -> bool {
        matches!(self, Self::Ramping | Self::InForce | Self::Frozen)
    }
}

impl From<Fault> for Bad {
    fn from(fault: Fault) -> Self {
        Self { fault, signal: -1 }
    }
}

/// What no phase but off goes on with.
fn refused(inputs: &Inputs, settings: &Settings, has_table: bool) -> Option<Fault> {
    let finite = inputs
        .position
        .iter()
        .chain(&inputs.tool_offset)
        .all(|part| part.is_finite());
    let acts = has_table && settings.parts & TABLE_PART != 0;
    if !(make_sense(settings) && inputs.period_s.is_finite() && inputs.period_s > 0.0) {
        Some(Fault::Settings)
    } else if !finite {
        Some(Fault::NotANumber)
    } else {
        (acts && inputs.program == ANOTHER_PROGRAM).then_some(Fault::Program)
    }
}

fn make_sense(settings: &Settings) -> bool {
    let times = [
        settings.stale_s,
        settings.freeze_s,
        settings.leave_s,
        settings.watchdog_s,
        settings.off_path_s,
    ];
    let lengths = [
        settings.limit_mm,
        settings.resolution_mm,
        settings.slew_mm_per_s,
    ];
    times
        .iter()
        .chain(&lengths)
        .all(|value| value.is_finite() && *value >= 0.0)
        && settings.slew_mm_per_s > 0.0
        && settings.parts <= MODEL_PART | TABLE_PART
}

fn hindrance(inputs: &Inputs, settings: &Settings) -> Option<WaitsFor> {
    if !inputs.homed {
        Some(WaitsFor::Homing)
    } else if !inputs.machine_on {
        Some(WaitsFor::Drives)
    } else {
        (probes(inputs) && !settings.probe_corrected).then_some(WaitsFor::Probing)
    }
}
