//! What the commands of the last periods say about each axis: how it came where it is, how fast it goes, how hard it is driven.

use super::values::Inputs;
use crate::wanted::AXES;
use error_eval::Vector;

/// A command that moves less than this stands, mm: above the rounding of a position, far below a drive's count.
const STANDS_MM: f64 = 1e-9;

/// Of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    last_mm: f64,
    /// Where its direction of travel was seen last, mm.
    seen_at_mm: f64,
    /// +1 forward, −1 return, 0 not known.
    travel: f64,
    /// mm/s, over the last period.
    pub(super) velocity: f64,
    /// Largest one seen, mm/s², without sign.
    pub(super) acceleration: f64,
}

/// Of all axes. The command is free of noise only while the drives are on: without them it follows the feedback.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Movement {
    axes: [Axis; AXES],
    /// Commands in a row that can be compared with each other; counted to two.
    commands: u8,
}

impl Movement {
    /// Takes the command of this period. Directions are kept while an axis stands and while its drive is off, and forgotten
    /// where it is not homed: its position then starts anew.
    pub(super) fn take(&mut self, inputs: &Inputs, period_s: f64) {
        if !inputs.homed {
            self.axes.iter_mut().for_each(|axis| axis.travel = 0.0);
        }
        let finite = inputs.position.iter().all(|q| q.is_finite());
        if !(inputs.homed && inputs.machine_on && finite && period_s > 0.0) {
            self.commands = 0;
            self.axes.iter_mut().for_each(|axis| axis.velocity = 0.0);
            return;
        }
        for (axis, position) in self.axes.iter_mut().zip(inputs.position) {
            axis.take(position, period_s, self.commands);
        }
        self.commands = (self.commands + 1).min(2);
    }

    pub(super) fn axes(&self) -> &[Axis; AXES] {
        &self.axes
    }

    /// Direction of travel of each axis: +1, −1, 0 not known.
    pub(super) fn travel(&self) -> Vector {
        self.axes.map(|axis| axis.travel)
    }
}

impl Axis {
    fn take(&mut self, position_mm: f64, period_s: f64, commands_before: u8) {
        if commands_before == 0 {
            self.seen_at_mm = position_mm;
        } else {
            let velocity = (position_mm - self.last_mm) / period_s;
            if commands_before > 1 {
                let acceleration = (velocity - self.velocity).abs() / period_s;
                self.acceleration = self.acceleration.max(acceleration);
            }
            self.velocity = velocity;
            self.turn(position_mm);
        }
        self.last_mm = position_mm;
    }

    fn turn(&mut self, position_mm: f64) {
        let moved = position_mm - self.seen_at_mm;
        if moved.abs() > STANDS_MM {
            self.travel = if moved > 0.0 { 1.0 } else { -1.0 };
            self.seen_at_mm = position_mm;
        }
    }
}
