//! How much of a correction is in force: phases, slew, limits, travel, and signals that are late or impossible.
//!
//! docs/realtime-states.md says what leads from one phase to another. Whatever comes in, the correction is finite and
//! changes by slew · period at most.

mod conditions;
mod latch;
mod movement;
mod phase;
mod readings;
mod slew;
#[cfg(test)]
mod tests;
mod travel;
mod values;

pub use phase::{Fault, Phase, WaitsFor};
pub use values::{Inputs, Outputs, Settings, MODEL_PART, TABLE_PART};

use crate::wanted::{Asked, Place, Wanted, AXES};
use conditions::Conditions;
use error_eval::Vector;
use latch::Latch;
use movement::Movement;
use readings::{Bad, Readings};
use slew::{rounded, slewed, usable};
use travel::{stays_inside, Ramp};

/// What is remembered from period to period. It knows nothing of an image: one that is exchanged while nothing is in force
/// finds directions of travel as they were.
#[derive(Clone, Copy, Debug)]
pub struct Corrector {
    phase: Phase,
    fault: Option<Bad>,
    /// Last one that could be used, mm/s; before any nothing comes in force.
    slew: f64,
    correction: Vector,
    /// What the correction went to last: rounding holds on to it.
    target: Vector,
    /// Whether what is wanted has been reached since the correction last began.
    reached: bool,
    pauses: bool,
    /// Time in this phase; in phase waiting only that for signals, s.
    spent_s: f64,
    off_path_s: f64,
    movement: Movement,
    readings: Readings,
    latch: Latch,
}

impl Default for Corrector {
    fn default() -> Self {
        Self::new()
    }
}

impl Corrector {
    /// Nothing in force, nothing known.
    #[must_use]
    pub fn new() -> Self {
        Self {
            phase: Phase::Off,
            fault: None,
            slew: 0.0,
            correction: [0.0; AXES],
            target: [0.0; AXES],
            reached: false,
            pauses: false,
            spent_s: 0.0,
            off_path_s: 0.0,
            movement: Movement::default(),
            readings: Readings::default(),
            latch: Latch::default(),
        }
    }

    /// One period: what is to be added to the commands.
    pub fn step(
        &mut self,
        asked: &mut impl Asked,
        inputs: &Inputs,
        settings: &Settings,
    ) -> Outputs {
        let period_s = if inputs.period_s.is_finite() {
            inputs.period_s.max(0.0)
        } else {
            0.0
        };
        self.slew = usable(settings.slew_mm_per_s).unwrap_or(self.slew);
        let ramp = Ramp {
            slew_mm_per_s: self.slew,
            period_s,
        };
        self.latch.take(inputs.touch);
        self.movement.take(inputs, period_s);
        let bad = self
            .readings
            .take(inputs, asked.signals(), settings, period_s, !inputs.enable);
        let wanted = self.ask(asked, inputs, settings);
        let sum = in_parts(&wanted, settings);

        self.next_phase(
            &Conditions::new(inputs, settings, asked.has_table(), bad),
            period_s,
        );
        self.stray(&wanted, period_s);
        self.target = rounded(
            &self.faded(&sum, settings),
            &self.target,
            settings.resolution_mm,
        );
        if let Some(fault) = self.refusal(asked, inputs, settings, &sum, ramp) {
            self.fail(fault.into());
            self.target = [0.0; AXES];
        }
        self.correction = slewed(
            &self.correction,
            &self.target,
            ramp.slew_mm_per_s * ramp.period_s,
        );
        self.arrive();
        self.pauses |= self.is_failing() && (inputs.program != 0 || self.is_felt());
        self.latch
            .send(&inputs.position, &self.correction, &wanted.model);
        self.shown(asked.signals().len(), bad, &wanted, settings, inputs)
    }

    /// What should be added here; nothing where it cannot be asked.
    fn ask(&self, asked: &mut impl Asked, inputs: &Inputs, settings: &Settings) -> Wanted {
        let finite = inputs
            .position
            .iter()
            .chain(&inputs.tool_offset)
            .all(|part| part.is_finite());
        if !finite || !self.readings.known(asked.signals().len()) {
            return Wanted::default();
        }
        let cuts =
            inputs.program == 1 && settings.parts & TABLE_PART != 0 && !conditions::probes(inputs);
        asked.wanted(&Place {
            position: inputs.position,
            travel: self.movement.travel(),
            tool_offset: inputs.tool_offset,
            signal: self.readings.values(),
            line: cuts.then_some(inputs.line),
        })
    }

    /// Counts how long a listed block has been off its path while the correction follows.
    fn stray(&mut self, wanted: &Wanted, period_s: f64) {
        let strays = wanted.listed && !wanted.on_path && self.phase.follows();
        self.off_path_s = if strays {
            self.off_path_s + period_s
        } else {
            0.0
        };
    }

    /// What of it the phase lets come in force. A correction that leaves fades: it stays between nothing and what is wanted
    /// wherever the axes go meanwhile.
    fn faded(&self, sum: &Vector, settings: &Settings) -> Vector {
        let share = match self.phase {
            Phase::Ramping | Phase::InForce | Phase::Frozen => 1.0,
            Phase::Leaving => (1.0 - self.spent_s / settings.leave_s).max(0.0),
            Phase::Off | Phase::Waiting | Phase::Faulted => return [0.0; AXES],
        };
        sum.map(|part| part * share)
    }

    /// Why what is wanted may not come in force.
    fn refusal(
        &self,
        asked: &impl Asked,
        inputs: &Inputs,
        settings: &Settings,
        sum: &Vector,
        ramp: Ramp,
    ) -> Option<Fault> {
        if !self.phase.follows() {
            return None;
        }
        if !sum.iter().all(|part| part.is_finite()) {
            return Some(Fault::NotANumber);
        }
        let limit = settings.limit_mm.min(asked.limit());
        if !sum
            .iter()
            .chain(&self.target)
            .all(|part| part.abs() <= limit)
        {
            return Some(Fault::Limit);
        }
        if self.off_path_s > settings.off_path_s {
            return Some(Fault::OffPath);
        }
        let next = slewed(
            &self.correction,
            &self.target,
            ramp.slew_mm_per_s * ramp.period_s,
        );
        let inside = stays_inside(
            &inputs.position,
            &next,
            &asked.travel(),
            self.movement.axes(),
            ramp,
        );
        (!inside).then_some(Fault::Travel)
    }

    fn arrive(&mut self) {
        if !self.phase.follows() {
            return;
        }
        let there = self.correction == self.target;
        self.reached |= there;
        if matches!(self.phase, Phase::Ramping | Phase::InForce) {
            self.phase = if there {
                Phase::InForce
            } else {
                Phase::Ramping
            };
        }
    }

    /// Whether a fault would be seen on the part.
    fn is_felt(&self) -> bool {
        self.reached || self.correction.iter().any(|part| *part != 0.0)
    }

    fn shown(
        &self,
        signals: usize,
        bad: Option<Bad>,
        wanted: &Wanted,
        settings: &Settings,
        inputs: &Inputs,
    ) -> Outputs {
        let fault = self.fault;
        Outputs {
            correction: self.correction,
            model: shown_part(&wanted.model, settings.parts & MODEL_PART),
            table: shown_part(&wanted.table, settings.parts & TABLE_PART),
            latch: self.latch.at,
            in_use: self.readings.values(),
            oldest_age_s: self.readings.oldest_s(signals),
            phase: self.phase as i32,
            fault: fault.map_or(0, |fault| fault.fault as i32),
            fault_signal: fault.or(bad).map_or(-1, |bad| bad.signal),
            waits_for: self.waits_for(inputs, settings, bad),
            signal_fault: bad.map_or(0, |bad| bad.fault as i32),
            enabled: self.reached && self.phase.is_in_force(),
            active: self.correction.iter().any(|part| *part != 0.0),
            on_path: wanted.on_path,
            pause: self.pauses && settings.pause_program,
        }
    }
}

/// What is wanted of the parts that shall act.
fn in_parts(wanted: &Wanted, settings: &Settings) -> Vector {
    let mut sum = [0.0; AXES];
    for (bit, part) in [(MODEL_PART, wanted.model), (TABLE_PART, wanted.table)] {
        for (sum, part) in sum.iter_mut().zip(part) {
            *sum += if settings.parts & bit != 0 { part } else { 0.0 };
        }
    }
    sum
}

fn shown_part(part: &Vector, acts: u32) -> Vector {
    part.map(|value| {
        if acts != 0 && value.is_finite() {
            value
        } else {
            0.0
        }
    })
}
