//! A field applied to a program: every position displaced, in parts of some lines each, so that memory does not grow
//! with the program.
//!
//! A part is read and run with the state of the parts before it, the field is asked for all its positions at once, and
//! the words are edited by span: what need not change stays as it was. A move that the displaced path leaves by more
//! than a tolerance becomes several. Programs with loops or calls have to be held whole.

mod edits;
pub mod field;
mod lines;
mod part;
mod pieces;
mod refusal;
mod role;
mod standing;
mod text;
mod value;
mod writer;

use nc_program::{Dialect, Options, Program, Session};

use standing::Standing;

pub use field::{Affine, Field, Grid, Place, Trouble, Vector};
pub use refusal::Refusal;
pub use role::{named_axes, sets_offset};
pub use standing::{said, Saying};

/// What is accepted.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// How far the written path may leave the displaced one, rounding not counted, mm.
    pub tolerance_mm: f64,
    /// Largest displacement along an axis, mm.
    pub size_mm: f64,
    /// Largest change of the displacement in a cut, over its length.
    pub slope: f64,
}

/// What was done, over all parts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Summary {
    /// Blocks read.
    pub blocks: usize,
    /// Moves displaced.
    pub moves: usize,
    /// Words changed or inserted.
    pub edits: usize,
    /// Blocks written in addition.
    pub added: usize,
    /// Largest displacement along each axis, mm.
    pub largest_mm: Vector,
    /// Blocks with coordinates that were not run and stay as they are, and the line of the first (from 1).
    pub not_run: usize,
    /// Its line.
    pub first_not_run: usize,
}

/// A field on its way through a program.
pub struct Mapper {
    dialect: &'static Dialect,
    limits: Limits,
    session: Session,
    /// Bytes not dealt with yet.
    waiting: Vec<u8>,
    /// The program jumps: it is dealt with in one part.
    whole: bool,
    carried: Vector,
    standing: [Standing; 3],
    /// The way each axis went last.
    travel: [i8; 3],
    summary: Summary,
}

impl Mapper {
    /// Before the first bytes. `whole` for programs with a block that `nc_program::jumps`; `named` as [`named_axes`] says.
    pub fn new(dialect: &'static Dialect, options: Options, limits: Limits, whole: bool, named: [bool; 3]) -> Self {
        Self {
            dialect,
            limits,
            session: Session::new(options),
            waiting: Vec::new(),
            whole,
            carried: [0.0; 3],
            standing: standing::at_start(named),
            travel: [0; 3],
            summary: Summary::default(),
        }
    }

    /// What was done so far.
    pub fn summary(&self) -> Summary {
        self.summary
    }

    /// Takes the next bytes and appends what is done to `out`. The last whole line waits: the one before is numbered by it.
    pub fn push(&mut self, bytes: &[u8], field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        self.waiting.extend_from_slice(bytes);
        let last = if self.whole { None } else { memchr::memrchr(b'\n', &self.waiting) };
        let Some(last) = last else { return Ok(()) };
        let rest = self.waiting.split_off(last + 1);
        let part = std::mem::replace(&mut self.waiting, rest);
        let kept = memchr::memrchr(b'\n', part.get(..last).unwrap_or(&[])).map_or(0, |before| before + 1);
        let ahead = part.get(kept..).unwrap_or(&[]).to_vec();
        self.part(part, 1, field, out)?;
        self.waiting.splice(0..0, ahead);
        Ok(())
    }

    /// Deals with what is left.
    pub fn finish(&mut self, field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let part = std::mem::take(&mut self.waiting);
        self.part(part, 0, field, out)
    }

    /// A part of whole lines, of which the last `ahead` are only looked at.
    fn part(&mut self, source: Vec<u8>, ahead: usize, field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let too_large = |bytes: usize| Refusal {
            code: refusal::MAP,
            message: format!("{bytes} bytes of a program have to be held at once: 2147483647 is the most"),
            hint: "split the program".to_owned(),
            line: self.summary.blocks + 1,
            column: 1,
            cause: None,
        };
        let program = Program::read(source, self.dialect).map_err(|error| too_large(error.bytes))?;
        let until = program.blocks().len().saturating_sub(ahead);
        self.displace(&program, until, field, out).map_err(|refused| {
            let block = program.block_at(refused.at);
            let start = program.blocks().get(block).map_or(0, |found| found.start as usize);
            Refusal {
                code: refused.code,
                message: refused.message,
                hint: refused.hint,
                line: self.summary.blocks + block + 1,
                column: refused.at.saturating_sub(start) + 1,
                cause: refused.cause,
            }
        })?;
        self.summary.blocks += until;
        Ok(())
    }
}
