//! One body of the image: the rows of the segment last used are kept, the signals of the moment put in.
//!
//! So a period costs the same however many signals there are, and touches a few hundred bytes however long the image is.

use error_eval::{add_local, Arm, Six, Vector};

use crate::image::Refusal;
use crate::wanted::{AXES, SIGNALS};
use crate::words::{add_rows, number, numbers, whole, Reader, SixWords, Word};

/// Bodies at most: six linear and rotary axes, the spindle, and one to spare.
pub(crate) const BODIES: usize = 8;
const POWERS: usize = 8;
/// Breaks of a body at most: more than fit into an image make no sense of their own.
const BREAKS: usize = 1 << 20;
/// No coefficient is beyond: in a segment that is narrow enough a larger one stays within bounds, but would overflow times a
/// signal.
const MOST_POWER: f64 = 1e100;

/// Six errors as piecewise polynomials of one axis' position, linear in the signals.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Body<'a> {
    axis: usize,
    powers: usize,
    both_ways: bool,
    arm: Arm,
    first: f64,
    last: f64,
    breaks: &'a [Word],
    rows: &'a [SixWords],
    /// For each signal that acts here: its place, then as many rows.
    dependents: &'a [Word],
    /// One bit for each of these signals.
    pub(crate) depends: u32,
    held: Held,
}

/// The segment last used, with the signals put in.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    start: f64,
    /// Where the next segment begins; nothing is held while this is not above `start`.
    end: f64,
    table: usize,
    rows: [Six; POWERS],
}

impl<'a> Body<'a> {
    /// The next body, for an image of `signals` signals. Counts that do not fit: [`Refusal::Count`].
    pub(crate) fn read(reader: &mut Reader<'a>, signals: usize) -> Result<Self, Refusal> {
        let (axis, breaks) = (reader.count(AXES - 1)?, reader.count(BREAKS)?);
        let (tables, powers) = (reader.count(3)?, reader.count(POWERS)?);
        let acting = reader.count(signals)?;
        if breaks < 2 || tables == 0 || tables == 2 || powers == 0 {
            return Err(Refusal::Count);
        }
        let (start, carries) = (reader.vector()?, reader.vector()?);
        let breaks = reader.take(breaks)?;
        let count = tables * (breaks.len() - 1) * powers;
        let rows: &[SixWords] = reader.groups(count)?;
        let words = (6 * count + 1).checked_mul(acting).ok_or(Refusal::Count)?;
        let mut body = Self {
            axis,
            powers,
            both_ways: tables == 3,
            arm: Arm { start, carries },
            first: breaks.first().map_or(0.0, number),
            last: breaks.last().map_or(0.0, number),
            breaks,
            rows,
            dependents: reader.take(words)?,
            ..Self::default()
        };
        for (place, _) in body.dependents() {
            let place = place.filter(|place| *place < signals);
            body.depends |= 1 << place.ok_or(Refusal::Count)?;
        }
        Ok(body)
    }

    /// Whether it is a function of position that stays within bounds: breaks and signals ascend, no error is beyond
    /// `most` (mm or rad) anywhere. `spans` says how far each signal may be from its reference.
    pub(crate) fn check(&self, spans: &[f64; SIGNALS], most: f64) -> Result<(), Refusal> {
        let ascending = |pair: &[Word]| matches!(pair, [a, b] if number(a) < number(b));
        let places = || self.dependents().map(|(place, _)| place);
        let rising = places().zip(places().skip(1)).all(|(a, b)| a < b);
        let mut reach = self.reach(self.rows);
        for (place, rows) in self.dependents() {
            let span = place.and_then(|place| spans.get(place)).copied();
            reach += span.unwrap_or(0.0) * self.reach(rows);
        }
        let lever = |part: &f64| part.abs() <= most * most;
        let carried = |part: &f64| part.abs() <= 1.0;
        let bounded = reach <= most
            && self.arm.start.iter().all(lever)
            && self.arm.carries.iter().all(carried);
        if rising && bounded && self.breaks.windows(2).all(ascending) {
            Ok(())
        } else {
            Err(Refusal::Body)
        }
    }

    /// What no error of these rows is beyond: Σ |power| · widthᵏ, the largest of all segments. Infinite with a coefficient
    /// beyond [`MOST_POWER`].
    fn reach(&self, rows: &[SixWords]) -> f64 {
        if rows
            .as_flattened()
            .iter()
            .any(|word| number(word).abs() > MOST_POWER)
        {
            return f64::INFINITY;
        }
        let widths = self.breaks.iter().zip(self.breaks.iter().skip(1));
        let widths = widths.map(|(a, b)| number(b) - number(a));
        let segments = rows.chunks_exact(self.powers.max(1));
        let mut most = 0.0;
        for (segment, width) in segments.zip(widths.cycle()) {
            let mut sums = [0.0; 6];
            for row in segment.iter().rev() {
                for (sum, power) in sums.iter_mut().zip(numbers(row)) {
                    *sum = *sum * width + power.abs();
                }
            }
            for sum in sums {
                most = if sum <= most { most } else { sum }; // keeps a NaN, which is then beyond any bound
            }
        }
        most
    }

    /// The signals that act here: place (none: no whole number), rows.
    fn dependents(&self) -> impl Iterator<Item = (Option<usize>, &'a [SixWords])> {
        let size = 6 * self.rows.len() + 1;
        self.dependents.chunks_exact(size).filter_map(|words| {
            let (place, rows) = words.split_first()?;
            Some((whole(number(place), SIGNALS - 1), rows.as_chunks().0))
        })
    }

    /// Says that a signal has changed.
    pub(crate) fn forget(&mut self) {
        self.held.end = f64::NEG_INFINITY;
    }

    /// Adds d + r × arm at `q` to `error`; `tool` is added to the arm, `above` is each signal less its reference.
    #[inline(always)]
    pub(crate) fn add_error(
        &mut self,
        q: &Vector,
        travel: &Vector,
        tool: &Vector,
        above: &[f64; SIGNALS],
        error: &mut Vector,
    ) {
        let (Some(at), Some(travel)) = (q.get(self.axis), travel.get(self.axis)) else {
            return;
        };
        let at = at.max(self.first).min(self.last);
        let table = match self.both_ways {
            true if *travel > 0.0 => 1,
            true if *travel < 0.0 => 2,
            _ => 0,
        };
        if !(self.held.start <= at && at < self.held.end && table == self.held.table) {
            self.hold(at, table, above);
        }
        let mut arm = self.arm;
        for (part, tool) in arm.start.iter_mut().zip(tool) {
            *part += tool;
        }
        let rows = self.held.rows.get(..self.powers).unwrap_or(&[]);
        add_local(rows, at - self.held.start, &arm, q, error);
    }

    /// Takes the segment of `at`, and puts the signals in.
    #[cold]
    fn hold(&mut self, at: f64, table: usize, above: &[f64; SIGNALS]) {
        let inner = self.breaks.get(1..self.breaks.len().saturating_sub(1));
        let inner = inner.unwrap_or(&[]);
        let segment = inner.partition_point(|end| number(end) <= at);
        let first = (table * (inner.len() + 1) + segment) * self.powers;
        let mut held = Held {
            start: self.breaks.get(segment).map_or(self.first, number),
            end: inner.get(segment).map_or(f64::INFINITY, number),
            table,
            rows: [[0.0; 6]; POWERS],
        };
        let own = |rows: &'a [SixWords]| rows.get(first..first + self.powers).unwrap_or(&[]);
        add_rows(&mut held.rows, own(self.rows), 1.0);
        for (place, rows) in self.dependents() {
            let share = place.and_then(|place| above.get(place)).copied();
            add_rows(&mut held.rows, own(rows), share.unwrap_or(0.0));
        }
        self.held = held;
    }
}
