//! Signals: which readings are taken, and what is wrong with the others.

use super::phase::Fault;
use super::values::{Inputs, Settings};
use crate::wanted::{SignalRange, SIGNALS};

/// The last good reading of one signal.
#[derive(Clone, Copy, Debug, Default)]
struct Reading {
    value: f64,
    age_s: f64,
    known: bool,
}

/// What is wrong with the signals: of which one, −1 where it concerns all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bad {
    pub(super) fault: Fault,
    pub(super) signal: i32,
}

/// The readings in use.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Readings {
    kept: [Reading; SIGNALS],
    heartbeat: Option<u32>,
    heard: bool,
    silence_s: f64,
}

impl Readings {
    /// Takes the readings of this period that are in order; says what is wrong with the first that is not.
    ///
    /// `anew`: a reading is not compared with the one before it, as nothing is asked for and another image may be in force.
    pub(super) fn take(
        &mut self,
        inputs: &Inputs,
        ranges: &[SignalRange],
        settings: &Settings,
        period_s: f64,
        anew: bool,
    ) -> Option<Bad> {
        self.listen(inputs.heartbeat, period_s);
        let silent = !self.heard || self.silence_s > settings.watchdog_s;
        let mut first = None;
        let brought = inputs.signal.iter().zip(&inputs.age_s).zip(ranges);
        for ((signal, kept), ((value, age), range)) in (0..).zip(&mut self.kept).zip(brought) {
            kept.age_s += period_s;
            kept.known &= !(anew && kept.is_outside(range));
            let now = Reading {
                value: *value,
                age_s: age + self.silence_s,
                known: true,
            };
            match now.wrong(kept, range, settings, anew) {
                _ if silent => {
                    first = first.or(Some(Bad {
                        fault: Fault::Watchdog,
                        signal: -1,
                    }))
                }
                Some(fault) => first = first.or(Some(Bad { fault, signal })),
                None => *kept = now,
            }
        }
        first
    }

    fn listen(&mut self, heartbeat: u32, period_s: f64) {
        let changed = self.heartbeat.is_some_and(|last| last != heartbeat);
        self.heard |= changed;
        self.silence_s = if changed {
            0.0
        } else {
            self.silence_s + period_s
        };
        self.heartbeat = Some(heartbeat);
    }

    /// Whether the first `count` signals have each been read.
    pub(super) fn known(&self, count: usize) -> bool {
        self.kept.iter().take(count).all(|kept| kept.known)
    }

    /// Values in use; zero where none is known.
    pub(super) fn values(&self) -> [f64; SIGNALS] {
        self.kept
            .map(|kept| if kept.known { kept.value } else { 0.0 })
    }

    /// Age of the oldest among the first `count` that are known, s.
    pub(super) fn oldest_s(&self, count: usize) -> f64 {
        let known = self.kept.iter().take(count).filter(|kept| kept.known);
        known
            .fold(0.0_f64, |oldest, kept| oldest.max(kept.age_s))
            .min(f64::MAX)
    }
}

impl Reading {
    fn wrong(
        &self,
        before: &Self,
        range: &SignalRange,
        settings: &Settings,
        anew: bool,
    ) -> Option<Fault> {
        if self.is_outside(range) {
            return Some(Fault::Range);
        }
        if !(self.age_s >= 0.0 && self.age_s <= settings.stale_s) {
            return Some(Fault::Stale);
        }
        let jumped = before.known && !anew && (self.value - before.value).abs() > range.most_step;
        jumped.then_some(Fault::Jump)
    }

    /// True for what is not a number.
    fn is_outside(&self, range: &SignalRange) -> bool {
        !(self.value >= range.low && self.value <= range.high)
    }
}
