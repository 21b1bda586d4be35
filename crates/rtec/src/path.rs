//! The process' table: what is added along the blocks of a program, found by program line and then by place.
//!
//! Within a block the row is looked for near the one found last, as far along the path as the command has moved since: a path
//! that crosses itself stays on its branch. Who is lost, having entered in the middle of a block, looks through the rest of
//! it, a part in each period.

use error_eval::Vector;

use crate::image::Refusal;
use crate::words::{number, numbers, whole, Reader, Word};

/// Segments looked at in one period, ahead and behind together, and as many more by who is lost.
const MOST_SEGMENTS: usize = 256;
const ROWS: usize = 1 << 21;

/// Blocks with their rows, and where on them the command is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Path<'a> {
    /// How far off its path a row still holds, mm.
    pub(crate) gate: f64,
    blocks: &'a [[Word; 3]],
    rows: &'a [[Word; 4]],
    found: Found,
    /// That of the line found.
    block: Block<'a>,
}

/// Where on the path the command was last: on which segment of the block of which line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    line: Option<i32>,
    segment: usize,
    /// X and Z then, mm.
    place: [f64; 2],
}

/// Rows of one block; none where the line is not listed.
#[derive(Clone, Copy, Debug, Default)]
struct Block<'a> {
    rows: &'a [[Word; 4]],
}

/// A place near a segment: square of its distance, and what is added there.
struct Near {
    square: f64,
    segment: usize,
    row: [f64; 2],
}

impl<'a> Path<'a> {
    /// Blocks and rows. Counts that do not fit: [`Refusal::Count`].
    pub(crate) fn read(reader: &mut Reader<'a>, gate: f64) -> Result<Self, Refusal> {
        let count = reader.count(ROWS)?;
        let blocks: &[[Word; 3]] = reader.groups(count)?;
        let count = reader.count(ROWS)?;
        let rows: &[[Word; 4]] = reader.groups(count)?;
        let path = Self {
            gate,
            blocks,
            rows,
            ..Self::default()
        };
        let good = |block: &[Word; 3]| line_of(block).is_some() && path.rows_of(block).len() >= 2;
        if blocks.iter().all(good) && blocks.is_empty() == rows.is_empty() {
            Ok(path)
        } else {
            Err(Refusal::Count)
        }
    }

    /// Whether there is no table.
    pub(crate) const fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Lines ascend: else [`Refusal::Order`]. Corrections are within `most`, places within `most_length`, mm: else
    /// [`Refusal::Limits`].
    pub(crate) fn check(&self, most: f64, most_length: f64) -> Result<(), Refusal> {
        let small = |row: &[Word; 4]| {
            let [x, z, dx, dz] = numbers(row).map(f64::abs);
            x <= most_length && z <= most_length && dx <= most && dz <= most
        };
        let lines = || self.blocks.iter().filter_map(line_of);
        if !lines().zip(lines().skip(1)).all(|(a, b)| a < b) {
            Err(Refusal::Order)
        } else if !self.rows.iter().all(small) {
            Err(Refusal::Limits)
        } else {
            Ok(())
        }
    }

    fn rows_of(&self, [_, first, count]: &[Word; 3]) -> &'a [[Word; 4]] {
        let [first, count] = [first, count].map(|word| whole(number(word), ROWS));
        let (Some(first), Some(count)) = (first, count) else {
            return &[];
        };
        self.rows.get(first..first + count).unwrap_or(&[])
    }

    /// Whether the line is listed, and what is added to X and Z at a commanded position of it.
    #[inline]
    pub(crate) fn ask(&mut self, line: Option<i32>, q: &Vector) -> (bool, Option<[f64; 2]>) {
        if self.is_empty() {
            return (false, None);
        }
        let [x, _, z] = *q;
        if self.found.line != line {
            self.enter(Found {
                line,
                segment: 0,
                place: [x, z],
            });
        }
        let row = self.block.follow(&mut self.found, self.gate, [x, z]);
        (!self.block.rows.is_empty(), row)
    }

    pub(crate) const fn found(&self) -> Found {
        self.found
    }

    pub(crate) fn resume(&mut self, found: Found) {
        self.enter(found);
    }

    /// Takes the block of a line; it has no rows where the line is not listed.
    #[cold]
    fn enter(&mut self, found: Found) {
        let place = self.blocks.binary_search_by_key(&found.line, line_of);
        let block = place.ok().and_then(|place| self.blocks.get(place));
        self.block = Block {
            rows: block.map_or(&[], |block| self.rows_of(block)),
        };
        self.found = found;
    }
}

fn line_of([line, ..]: &[Word; 3]) -> Option<i32> {
    let line = whole(number(line), i32::MAX as usize).filter(|line| *line > 0);
    line.map(|line| line as i32)
}

impl Block<'_> {
    /// What is added at a place, and where that is from now on.
    #[inline]
    fn follow(&self, found: &mut Found, gate: f64, place: [f64; 2]) -> Option<[f64; 2]> {
        let [dx, dz] = [0, 1].map(|k: usize| match (place.get(k), found.place.get(k)) {
            (Some(now), Some(then)) => (now - then).abs(),
            _ => 0.0,
        });
        found.place = place;
        let (first, end) = self.window(found.segment, dx + dz + 2.0 * gate);
        let near = self.settled(first, end, gate, place);
        let near = near.or_else(|| self.look_on(&mut found.segment, gate, place))?;
        found.segment = near.segment;
        Some(near.row)
    }

    /// Entered in the middle of the block: the next part of it, after its end from its beginning.
    #[cold]
    fn look_on(&self, segment: &mut usize, gate: f64, place: [f64; 2]) -> Option<Near> {
        let (first, end) = (*segment, *segment + MOST_SEGMENTS);
        *segment = if end + 1 < self.rows.len() { end } else { 0 };
        self.settled(first, end, gate, place)
    }

    /// The nearest place on some segments or, where that is on their first or last, near it: it may be beyond.
    #[inline]
    fn settled(&self, first: usize, end: usize, gate: f64, place: [f64; 2]) -> Option<Near> {
        let near = self.nearest(first, end, gate, place)?;
        if first < near.segment && near.segment + 1 < end {
            return Some(near);
        }
        let (first, end) = self.window(near.segment, 2.0 * gate);
        self.nearest(first, end, gate, place)
    }

    /// One segment, and those ahead of its end and behind its start that are within `length` of it, mm.
    fn window(&self, segment: usize, length: f64) -> (usize, usize) {
        let ahead = self.rows.get(segment + 1..).unwrap_or(&[]);
        let behind = self.rows.get(..=segment).unwrap_or(&[]);
        let first = segment.saturating_sub(walked(behind.windows(2).rev(), length));
        (first, segment + 1 + walked(ahead.windows(2), length))
    }

    /// The nearest place within the gate on some segments.
    #[inline]
    fn nearest(&self, first: usize, end: usize, gate: f64, place: [f64; 2]) -> Option<Near> {
        let last = end.min(self.rows.len().saturating_sub(1)); // of the rows, both ends of segments
        let rows = self.rows.get(first..=last)?;
        let mut best: Option<Near> = None;
        for (k, pair) in rows.windows(2).enumerate() {
            let [a, b] = pair else { continue };
            let (square, row) = near(&numbers(a), &numbers(b), place);
            if best.as_ref().is_none_or(|best| square < best.square) {
                best = Some(Near {
                    square,
                    segment: first + k,
                    row,
                });
            }
        }
        best.filter(|best| best.square <= gate * gate)
    }
}

/// How many segments it takes until `length` is walked: one more, and not more than may be. By the longer of both
/// coordinates, which is no more than the length.
#[inline]
fn walked<'r>(segments: impl Iterator<Item = &'r [[Word; 4]]>, length: f64) -> usize {
    let mut left = length;
    let mut count = 0;
    for pair in segments.take(MOST_SEGMENTS / 2) {
        let [[ax, az, ..], [bx, bz, ..]] = pair else {
            break;
        };
        count += 1;
        left -= (number(bx) - number(ax))
            .abs()
            .max((number(bz) - number(az)).abs());
        if left <= 0.0 {
            break;
        }
    }
    count
}

/// Square of the distance from a segment, and what is added at the place on it that is nearest.
#[inline(always)]
fn near(a: &[f64; 4], b: &[f64; 4], [x, z]: [f64; 2]) -> (f64, [f64; 2]) {
    let ([ax, az, adx, adz], [bx, bz, bdx, bdz]) = (a, b);
    let (ux, uz, px, pz) = (bx - ax, bz - az, x - ax, z - az);
    let square = ux * ux + uz * uz;
    let share = (px * ux + pz * uz) / square;
    let share = if square > 0.0 {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (ex, ez) = (px - share * ux, pz - share * uz);
    let row = [adx + share * (bdx - adx), adz + share * (bdz - adz)];
    (ex * ex + ez * ez, row)
}
