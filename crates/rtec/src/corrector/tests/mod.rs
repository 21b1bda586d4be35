//! A stand-in for an image, and a machine's period with all in order.

extern crate std;

mod closed_loop;
mod phases;
mod signals;
mod small;
mod travel;
mod virtual_machine;
mod world;

use super::{Corrector, Fault, Inputs, Outputs, Phase, Settings, WaitsFor};
use crate::wanted::{Asked, Place, SignalRange, Wanted, AXES};
use std::vec::Vec;

/// Sets or spoils something.
type Change = fn(&mut Inputs);

/// One servo period, s.
const PERIOD: f64 = 1e-3;

/// An image whose answer a test writes down.
struct StandIn<F> {
    signals: Vec<SignalRange>,
    limit: f64,
    travel: [(f64, f64); AXES],
    has_table: bool,
    answer: F,
}

impl<F: FnMut(&Place) -> Wanted> Asked for StandIn<F> {
    fn signals(&self) -> &[SignalRange] {
        &self.signals
    }

    fn limit(&self) -> f64 {
        self.limit
    }

    fn travel(&self) -> [(f64, f64); AXES] {
        self.travel
    }

    fn has_table(&self) -> bool {
        self.has_table
    }

    fn wanted(&mut self, place: &Place) -> Wanted {
        (self.answer)(place)
    }
}

fn stand_in<F: FnMut(&Place) -> Wanted>(signals: usize, answer: F) -> StandIn<F> {
    StandIn {
        signals: std::vec![SignalRange { low: 10.0, high: 40.0, most_step: 1.0 }; signals],
        limit: 0.2,
        travel: [(-200.0, 200.0); AXES],
        has_table: false,
        answer,
    }
}

/// Wants the same everywhere.
fn constant(model: [f64; AXES]) -> impl FnMut(&Place) -> Wanted {
    move |_| Wanted {
        model,
        ..Wanted::default()
    }
}

/// A corrector, what it is told, and what it said last.
struct Bench {
    corrector: Corrector,
    inputs: Inputs,
    settings: Settings,
    said: Outputs,
}

impl Bench {
    /// On, homed, everything in order; signals at 20 °C.
    fn new() -> Self {
        let inputs = Inputs {
            signal: [20.0; 16],
            period_s: PERIOD,
            enable: true,
            homed: true,
            machine_on: true,
            ..Inputs::default()
        };
        Self {
            corrector: Corrector::new(),
            inputs,
            settings: Settings::default(),
            said: Outputs::default(),
        }
    }

    /// One period, with a message of the signals' component.
    fn step(&mut self, image: &mut impl Asked) -> Outputs {
        self.inputs.heartbeat = self.inputs.heartbeat.wrapping_add(1);
        self.silent_step(image)
    }

    /// One period without a message.
    fn silent_step(&mut self, image: &mut impl Asked) -> Outputs {
        self.said = self.corrector.step(image, &self.inputs, &self.settings);
        self.said
    }

    fn steps(&mut self, image: &mut impl Asked, periods: usize) -> Outputs {
        for _ in 0..periods {
            self.step(image);
        }
        self.said
    }

    /// Periods until a phase is there; a test fails that waits longer than a minute.
    fn until(&mut self, image: &mut impl Asked, phase: Phase) -> usize {
        let most = 60_000;
        let count = (1..=most).find(|_| self.step(image).phase == phase as i32);
        count.expect("the phase comes within a minute")
    }
}

fn close(a: [f64; AXES], b: [f64; AXES], within: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
}
