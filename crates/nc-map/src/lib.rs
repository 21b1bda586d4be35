//! A field applied to a program: every position displaced, in parts of some lines each, so that memory does not grow
//! with the program.
//!
//! A part is read and run with the state of the parts before it, the field is asked for all its positions at once, and
//! the words are edited by span: what need not change stays as it was. A move that the displaced path leaves by more
//! than a tolerance becomes several. Programs with loops or calls have to be held whole.

mod again;
mod edits;
pub mod field;
mod geometry;
mod mention;
mod milled;
mod part;
mod pieces;
mod reader;
mod refusal;
mod register;
mod role;
mod standing;
mod text;
mod value;
mod writer;

use std::thread;

use nc_program::{Dialect, Linear, Options, TooLarge};

use again::Again;
use reader::{Part, Reader};
use standing::Standing;
use writer::hole::Drilling;

pub use edits::{inserted, new_lines, BlockNumbers};
pub use field::{Affine, Field, Grid, Place, Trouble, Vector};
pub use mention::mentions;
pub use refusal::Refusal;
use refusal::Refusals;
use register::Register;
pub use role::{first_blocks, letters, named_axes};
pub use standing::{said, Saying};
pub use text::{writes_comma, written_decimals, Step};
pub use value::{moved, Moved};
pub use writer::centre::{circle, equidistant, Circle};

/// No machine is longer, mm: beyond it lies a slip in the field, and soon what no number of steps can say.
const MOST_MM: f64 = 1e6;

/// What is accepted.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// How far the written path may leave the displaced one, rounding not counted, mm.
    pub tolerance_mm: f64,
    /// Largest displacement along an axis, mm; at most a kilometre.
    pub size_mm: f64,
    /// Largest change of the displacement in a cut, over its length.
    pub slope: f64,
}

/// What has to be known of a whole program before its first part is written.
#[derive(Clone, Copy, Debug)]
pub struct Surveyed {
    /// It is to be held whole: a block of it [`nc_program::jumps`], or reads where the tool stands.
    pub whole: bool,
    /// Which axes it names, as [`named_axes`] says.
    pub named: [bool; 3],
    /// It writes decimal commas, as [`writes_comma`] says.
    pub comma: bool,
    /// Decimals of its coordinates, as [`written_decimals`] says, or more where they are asked for.
    pub decimals: usize,
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
    /// Line at which a contour that is roughed as well turns back since it is displaced; 0 where none does.
    pub turns_back: usize,
    /// The line that states the unit before any length, and whether it is the inch.
    pub unit_stated: Option<(usize, bool)>,
}

/// A field on its way through a program.
pub struct Mapper {
    reader: Reader,
    /// The part that was read last.
    ready: Option<Part>,
    writing: Writing,
}

/// What is known of the parts that were displaced.
struct Writing {
    limits: Limits,
    /// The program jumps: it is dealt with in one part.
    whole: bool,
    /// It writes decimal commas.
    comma: bool,
    /// So many decimals are written at least.
    decimals: usize,
    carried: Vector,
    /// The turned coordinates in which that counts.
    linear: Option<Linear>,
    drilling: Drilling,
    turning: Vector,
    standing: [Standing; 3],
    /// How often each axis' positions were renamed before the last move.
    renamed: [u32; 3],
    /// The last series of holes that began at an unknown height, and what was known of it.
    begun_at: Option<(u32, Standing)>,
    /// The way each axis went last.
    travel: [i8; 3],
    /// Where each axis stood before its first position, or went since: at its reference point, or elsewhere.
    left: [i8; 3],
    register: Register,
    /// The run of what was written, of a program that is held whole; `None` once nothing is written for an obstacle.
    again: Option<Again>,
    summary: Summary,
    refusals: Refusals,
}

impl Mapper {
    /// Before the first bytes; `surveyed` is what was found of the whole program.
    pub fn new(dialect: &'static Dialect, options: Options, limits: Limits, surveyed: Surveyed) -> Self {
        let Surveyed { whole, named, comma, decimals } = surveyed;
        let options = Options { trace: dialect.about_pole, ..options };
        let writing = Writing {
            limits: Limits { size_mm: limits.size_mm.min(MOST_MM), ..limits },
            whole,
            comma,
            decimals,
            carried: [0.0; 3],
            linear: None,
            drilling: Drilling::default(),
            turning: [0.0; 3],
            standing: standing::at_start(named),
            renamed: [0; 3],
            begun_at: None,
            travel: [0; 3],
            left: [field::FROM_REFERENCE; 3],
            register: Register::default(),
            again: whole.then(|| Again::new(options.clone())),
            summary: Summary::default(),
            refusals: Refusals::default(),
        };
        Self { reader: Reader::new(dialect, options, whole), ready: None, writing }
    }

    /// What was done so far.
    pub fn summary(&self) -> Summary {
        self.writing.summary
    }

    /// Has all refusals gathered instead of ending at the first; nothing is written then.
    pub fn gather(&mut self) {
        self.writing.refusals.gathers = true;
    }

    /// Takes the refusals that were gathered, in the order of the blocks.
    pub fn take_obstacles(&mut self) -> Vec<Refusal> {
        std::mem::take(&mut self.writing.refusals.all)
    }

    /// Takes the next bytes: they are read while the part before is displaced and appended to `out`.
    pub fn push(&mut self, bytes: &[u8], field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let Self { reader, ready, writing } = self;
        let read = match ready.take() {
            None => reader.next(bytes),
            Some(part) => thread::scope(|scope| {
                let ahead = scope.spawn(|| reader.next(bytes));
                let done = writing.part(part, field, out);
                let read = ahead.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                done.map(|()| read)
            })?,
        };
        self.ready = read.map_err(|error| self.too_large(&error))?;
        Ok(())
    }

    /// Deals with what is left.
    pub fn finish(&mut self, field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let last = self.reader.last().map_err(|error| self.too_large(&error))?;
        if let Some(mut part) = self.ready.take() {
            part.last = last.path.is_empty() && last.roles.is_empty();
            self.writing.part(part, field, out)?;
        }
        self.writing.part(last, field, out)
    }

    fn too_large(&self, error: &TooLarge) -> Refusal {
        Refusal {
            code: refusal::MAP,
            message: format!("{} bytes of a program have to be held at once: 2147483647 is the most", error.bytes),
            hint: "split the program".to_owned(),
            line: self.summary().blocks + 1,
            column: 1,
            cause: None,
        }
    }
}

impl Writing {
    fn part(&mut self, mut part: Part, field: &mut dyn Field, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let before = self.summary.blocks;
        let done = self.displace(&mut part, field, out);
        self.refusals.end_part(&part.program, before);
        done.map_err(|refused| refused.placed(&part.program, before))
    }
}
