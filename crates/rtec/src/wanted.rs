//! What should be added at a place: minus the machine's error, and what the process' table says there.

use error_eval::Vector;

use crate::image::Image;
use crate::words::{number, Word};

/// Axes X, Y, Z.
pub const AXES: usize = 3;
/// Signals at most.
pub const SIGNALS: usize = 16;

/// Where the machine is in one period.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// Commanded position of X, Y, Z, machine coordinates, mm.
    pub position: Vector,
    /// How each axis came there: +1 forward, −1 return, 0 not known.
    pub travel: Vector,
    /// Tool offset in force at the control, mm: the tool point is that of the image less this.
    pub tool_offset: Vector,
    /// Signals in the order of the image.
    pub signal: [f64; SIGNALS],
    /// Line of the program that moves; none where no program that the image knows is running.
    pub line: Option<i32>,
}

/// What should be added there, mm, by cause.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// −E at the corrected place.
    pub model: Vector,
    /// Of the table, where it has a row.
    pub table: Vector,
    /// Whether the table has blocks of this line.
    pub listed: bool,
    /// Whether it has a row for this place.
    pub on_path: bool,
}

/// What a signal may be, by the image.
#[derive(Clone, Copy, Debug, Default)]
pub struct SignalRange {
    /// Lowest value at which the model holds.
    pub low: f64,
    /// Highest one.
    pub high: f64,
    /// By how much two readings that follow each other may differ at most.
    pub most_step: f64,
}

/// What the corrector asks: an image, or a stand-in of a test.
pub trait Asked {
    /// Signals that the model needs.
    fn signals(&self) -> &[SignalRange];
    /// Largest correction of an axis, mm.
    fn limit(&self) -> f64;
    /// Ends of travel of X, Y, Z, machine coordinates, mm: lowest, highest.
    fn travel(&self) -> [(f64, f64); AXES];
    /// Whether it holds a table, which belongs to one program.
    fn has_table(&self) -> bool;
    /// What should be added at a place.
    fn wanted(&mut self, place: &Place) -> Wanted;
}

/// E is asked where the machine will stand, not where it is commanded: what is left of it after two steps is E · (dE/dq)²,
/// picometres.
const FIXED_POINT_STEPS: usize = 2;

impl Asked for Image<'_> {
    fn signals(&self) -> &[SignalRange] {
        self.ranges.get(..self.signals).unwrap_or(&[])
    }

    fn limit(&self) -> f64 {
        self.limit
    }

    fn travel(&self) -> [(f64, f64); AXES] {
        self.travel
    }

    fn has_table(&self) -> bool {
        !self.path.is_empty()
    }

    #[inline]
    fn wanted(&mut self, place: &Place) -> Wanted {
        self.take_signals(&place.signal);
        let (listed, row) = self.path.ask(place.line, &place.position);
        let [dx, dz] = row.unwrap_or_default();
        let table = [dx, 0.0, dz];
        let meant = plus(&place.position, &table);
        let mut model = [0.0; AXES];
        for _ in 0..FIXED_POINT_STEPS {
            model = self.error(plus(&meant, &model), place).map(|part| -part);
        }
        Wanted {
            model,
            table,
            listed,
            on_path: row.is_some(),
        }
    }
}

impl Image<'_> {
    /// E at `q`, for the signals taken last.
    #[inline(always)]
    fn error(&mut self, q: Vector, place: &Place) -> Vector {
        let mut tool = self.tool;
        for (part, offset) in tool.iter_mut().zip(place.tool_offset) {
            *part -= offset;
        }
        let mut error = [0.0; AXES];
        for (position, slope) in q.iter().zip(&self.slope) {
            for (sum, part) in error.iter_mut().zip(slope) {
                *sum += position * part;
            }
        }
        for body in self.bodies.iter_mut().take(self.body_count) {
            body.add_error(&q, &place.travel, &tool, &self.above, &mut error);
        }
        error
    }

    /// Where a signal has changed, what depends on it is made anew.
    #[inline(always)]
    fn take_signals(&mut self, signal: &[f64; SIGNALS]) {
        let mut changed = 0;
        let own = self.above.iter_mut().zip(&self.reference).zip(signal);
        for (k, ((above, reference), signal)) in own.enumerate().take(self.signals) {
            let now = signal - reference;
            changed |= u32::from(now.to_bits() != above.to_bits()) << k;
            *above = now;
        }
        if changed != 0 {
            self.renew(changed);
        }
    }

    #[cold]
    fn renew(&mut self, changed: u32) {
        for body in self
            .bodies
            .iter_mut()
            .filter(|body| body.depends & changed != 0)
        {
            body.forget();
        }
        self.set_slope();
    }

    pub(crate) fn set_slope(&mut self) {
        let mut sums = [0.0; 9];
        for (words, share) in self
            .slopes
            .iter()
            .zip(core::iter::once(&1.0).chain(&self.above))
        {
            add(&mut sums, words, *share);
        }
        let (rows, _) = sums.as_chunks();
        for (slope, row) in self.slope.iter_mut().zip(rows) {
            *slope = *row;
        }
    }
}

fn add(sums: &mut [f64; 9], words: &[Word; 9], share: f64) {
    for (sum, word) in sums.iter_mut().zip(words) {
        *sum += share * number(word);
    }
}

fn plus(a: &Vector, b: &Vector) -> Vector {
    let mut sum = *a;
    for (sum, b) in sum.iter_mut().zip(b) {
        *sum += b;
    }
    sum
}

#[cfg(test)]
mod tests;
