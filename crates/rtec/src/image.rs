//! The image: a file of numbers, checked as a whole before one of them is used. Its format: docs/realtime-image.md.

use error_eval::Vector;
use sha2::{Digest, Sha256};

use crate::body::{Body, BODIES};
pub use crate::path::Found;
use crate::path::Path;
use crate::wanted::{SignalRange, AXES, SIGNALS};
use crate::words::{number, numbers, Reader, Word};

const MAGIC: &[u8; 8] = b"TLRTEC\r\n";
const VERSION: u32 = 1;
const HEAD: usize = 1024;
/// Bytes of an image at most.
const MOST_BYTES: u64 = 64 << 20;
/// Errors (mm, rad), rows of a table and limits (mm) at most.
const MOST: f64 = 1e3;
/// Lengths at most, mm.
const MOST_LENGTH: f64 = MOST * MOST;
/// Signals and their references at most, whatever their unit.
const MOST_SIGNAL: f64 = 1e9;
/// What a millimetre of travel adds to an error, at most.
const MOST_SLOPE: f64 = 1.0;

/// What an image must agree with.
#[derive(Clone, Copy, Debug, Default)]
pub struct Expected<'a> {
    /// This machine's serial; none: any.
    pub serial: Option<&'a [u8]>,
    /// Content of the program that shall run; none: not compared.
    pub program: Option<&'a [u8]>,
}

/// An image that was checked, and what is remembered from one period to the next.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    pub(crate) limit: f64,
    pub(crate) travel: [(f64, f64); AXES],
    pub(crate) tool: Vector,
    pub(crate) signals: usize,
    pub(crate) ranges: [SignalRange; SIGNALS],
    pub(crate) reference: [f64; SIGNALS],
    /// At the references, then what one unit of each signal adds.
    pub(crate) slopes: &'a [[Word; 9]],
    pub(crate) bodies: [Body<'a>; BODIES],
    pub(crate) body_count: usize,
    pub(crate) path: Path<'a>,
    /// Signals of the last period, less their references.
    pub(crate) above: [f64; SIGNALS],
    /// Slopes for these signals.
    pub(crate) slope: [Vector; AXES],
}

impl<'a> Image<'a> {
    /// The image that lies in `bytes`.
    ///
    /// # Errors
    /// The first [`Refusal`], in the order that docs/realtime-image.md says.
    pub fn read(bytes: &'a [u8], expected: Expected<'_>) -> Result<Self, Refusal> {
        let words = check_head(bytes, expected)?;
        if !words.iter().all(|word| number(word).is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let image = Self::lay_out(words)?;
        image.check_limits()?;
        image.check_bodies()?;
        image.path.check(MOST, MOST_LENGTH)?;
        if image.path.is_empty() != is_zero(bytes, 224, 32) {
            return Err(Refusal::Program);
        }
        Ok(image)
    }

    /// An image that [`Image::read`] has taken before, and not changed since: only its counts are read again.
    ///
    /// # Errors
    /// [`Refusal::Count`] for what is no image. Others give numbers without meaning.
    pub fn read_again(bytes: &'a [u8]) -> Result<Self, Refusal> {
        Self::lay_out(bytes.get(HEAD..).unwrap_or(&[]).as_chunks().0)
    }

    /// Where on the table's path the command was found last.
    #[must_use]
    pub const fn found(&self) -> Found {
        self.path.found()
    }

    /// Goes on where another reading of the same image was.
    pub fn resume(&mut self, found: Found) {
        self.path.resume(found);
    }

    /// Where everything lies. Counts that do not fit: [`Refusal::Count`].
    fn lay_out(words: &'a [Word]) -> Result<Self, Refusal> {
        let mut reader = Reader::new(words);
        let [limit, gate] = reader.numbers()?;
        let mut travel = [(0.0, 0.0); AXES];
        for ends in &mut travel {
            *ends = reader.numbers::<2>()?.into();
        }
        let tool = reader.vector()?;
        let signals = reader.count(SIGNALS)?;
        let mut ranges = [SignalRange::default(); SIGNALS];
        let mut reference = [0.0; SIGNALS];
        for (range, reference) in ranges.iter_mut().zip(&mut reference).take(signals) {
            let low;
            [*reference, low, range.high, range.most_step] = reader.numbers()?;
            range.low = low;
        }
        let slopes = reader.groups(1 + signals)?;
        let body_count = reader.count(BODIES)?;
        let mut bodies = [Body::default(); BODIES];
        for body in bodies.iter_mut().take(body_count) {
            *body = Body::read(&mut reader, signals)?;
        }
        let path = Path::read(&mut reader, gate)?;
        if !reader.is_done() {
            return Err(Refusal::Count);
        }
        let mut image = Self {
            limit,
            travel,
            tool,
            signals,
            ranges,
            reference,
            slopes,
            bodies,
            body_count,
            path,
            above: [0.0; SIGNALS],
            slope: [[0.0; 3]; AXES],
        };
        image.set_slope();
        Ok(image)
    }

    /// What each signal may differ from its reference, at most.
    fn spans(&self) -> [f64; SIGNALS] {
        let mut spans = [0.0; SIGNALS];
        for ((span, range), reference) in spans.iter_mut().zip(&self.ranges).zip(&self.reference) {
            *span = (range.low - reference)
                .abs()
                .max((range.high - reference).abs());
        }
        spans
    }

    fn check_limits(&self) -> Result<(), Refusal> {
        let length = |value: f64| value > 0.0 && value <= MOST;
        let signal = |(range, reference): (&SignalRange, &f64)| {
            let numbers = [range.low, range.high, *reference];
            let small = numbers.iter().all(|value| value.abs() <= MOST_SIGNAL);
            small && range.low <= range.high && range.most_step > 0.0
        };
        let mut signals = self.ranges.iter().zip(&self.reference).take(self.signals);
        let shares = core::iter::once(1.0).chain(self.spans());
        let mut reach = [0.0; 9];
        for (words, share) in self.slopes.iter().zip(shares) {
            for (sum, slope) in reach.iter_mut().zip(numbers(words)) {
                *sum += share * slope.abs();
            }
        }
        let good = length(self.limit)
            && length(self.path.gate)
            && self.travel.iter().all(|(low, high)| low <= high)
            && self.tool.iter().all(|part| part.abs() <= MOST_LENGTH)
            && signals.all(signal)
            && reach.iter().all(|sum| *sum <= MOST_SLOPE);
        if good {
            Ok(())
        } else {
            Err(Refusal::Limits)
        }
    }

    fn check_bodies(&self) -> Result<(), Refusal> {
        let spans = self.spans();
        let mut bodies = self.bodies.iter().take(self.body_count);
        bodies.try_for_each(|body| body.check(&spans, MOST))
    }
}

/// Everything before the words; gives the words.
fn check_head<'a>(bytes: &'a [u8], expected: Expected<'_>) -> Result<&'a [Word], Refusal> {
    let given = bytes.len() as u64;
    if bytes.is_empty() {
        return Err(Refusal::Empty);
    }
    if !bytes.starts_with(MAGIC) {
        let begins = MAGIC.starts_with(bytes);
        return Err(if begins {
            Refusal::Short
        } else {
            Refusal::Magic
        });
    }
    let Some((head, _)) = bytes.split_first_chunk::<HEAD>() else {
        return Err(Refusal::Short);
    };
    let known = u32_at(head, 8) == VERSION && u32_at(head, 12) == HEAD as u32;
    if !known || !is_zero(head, 24, 8) {
        return Err(Refusal::Version);
    }
    let said = u64_at(head, 16);
    if given < said || said < HEAD as u64 {
        return Err(Refusal::Short);
    }
    if given > said || given > MOST_BYTES {
        return Err(Refusal::Long);
    }
    let (words, []) = bytes.get(HEAD..).unwrap_or(&[]).as_chunks() else {
        return Err(Refusal::Odd);
    };
    if !same(head, 32, &Sha256::digest(bytes.get(64..).unwrap_or(&[]))) {
        return Err(Refusal::Hash);
    }
    let serial = part(head, 128, 64);
    let serial = serial.split(|byte| *byte == 0).next().unwrap_or(&[]);
    if expected.serial.is_some_and(|own| own != serial) {
        return Err(Refusal::Serial);
    }
    let other = |program| !same(head, 224, &Sha256::digest(program));
    if !is_zero(head, 224, 32) && expected.program.is_some_and(other) {
        return Err(Refusal::Program);
    }
    Ok(words)
}

fn part(bytes: &[u8], first: usize, count: usize) -> &[u8] {
    bytes.get(first..first + count).unwrap_or(&[])
}

fn is_zero(bytes: &[u8], first: usize, count: usize) -> bool {
    part(bytes, first, count).iter().all(|byte| *byte == 0)
}

fn same(bytes: &[u8], first: usize, hash: &[u8]) -> bool {
    part(bytes, first, 32) == hash
}

fn u32_at(bytes: &[u8], first: usize) -> u32 {
    part(bytes, first, 4)
        .first_chunk()
        .map_or(0, |four| u32::from_le_bytes(*four))
}

fn u64_at(bytes: &[u8], first: usize) -> u64 {
    part(bytes, first, 8)
        .first_chunk()
        .map_or(0, |eight| u64::from_le_bytes(*eight))
}

/// Why a file is no image for this machine. The numbers are those that `reload-error` shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Refusal {
    /// The file cannot be read.
    Missing = 1,
    /// Nothing in it.
    Empty = 2,
    /// It ends before what it says it holds.
    Short = 3,
    /// Its length is no whole number of words.
    Odd = 4,
    /// It goes on after what it says it holds, or holds more than there may be.
    Long = 5,
    /// It does not begin as an image does.
    Magic = 6,
    /// Another version of the format.
    Version = 7,
    /// Its SHA-256 is another than it says.
    Hash = 8,
    /// It was made for another machine.
    Serial = 9,
    /// A count that is none, or does not fit the rest.
    Count = 10,
    /// A number that is not finite.
    NotFinite = 11,
    /// Its table belongs to another program.
    Program = 12,
    /// Program lines that do not ascend.
    Order = 13,
    /// Segments or coefficients that make no function of position.
    Body = 14,
    /// Limits, ranges or travels that are none.
    Limits = 15,
}

#[cfg(test)]
mod tests;
