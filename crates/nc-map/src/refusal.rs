//! Why a program is not mapped.

use std::collections::HashSet;
use std::error::Error;

use nc_program::Program;

/// A block to which the field cannot be applied.
pub const MAP: &str = "NC-MAP";
/// A position for which the field has no displacement.
pub const FIELD: &str = "NC-FIELD";
/// A displacement larger than the limit.
pub const SIZE: &str = "CMP-SIZE";
/// A displacement that changes more steeply than the limit.
pub const SLOPE: &str = "CMP-SLOPE";

/// What was wrong, at which line and column (from 1).
#[derive(Debug)]
pub struct Refusal {
    /// Code of the error catalogue.
    pub code: &'static str,
    /// What is wrong, with values.
    pub message: String,
    /// How to mend it.
    pub hint: String,
    /// Line of the whole program.
    pub line: usize,
    /// Column.
    pub column: usize,
    /// What the field failed with, when it did.
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

/// The same, by the byte of the part of the program at hand.
#[derive(Debug)]
pub(crate) struct Refused {
    pub code: &'static str,
    pub message: String,
    pub hint: String,
    pub at: usize,
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

impl Refused {
    pub fn new(code: &'static str, at: usize, message: String, hint: &str) -> Self {
        Self { code, message, hint: hint.to_owned(), at, cause: None }
    }

    /// A block to which the field cannot be applied.
    pub fn block(at: usize, message: String, hint: &str) -> Self {
        Self::new(MAP, at, message, hint)
    }

    /// With its line and column, in a part that began after so many lines.
    pub fn placed(self, program: &Program, lines_before: usize) -> Refusal {
        let block = program.block_at(self.at);
        let start = program.blocks().get(block).map_or(0, |found| found.start as usize);
        let (line, column) = (lines_before + block + 1, self.at.saturating_sub(start) + 1);
        Refusal { code: self.code, message: self.message, hint: self.hint, line, column, cause: self.cause }
    }
}

/// What becomes of refusals: the first ends the mapping, or all are gathered and the rest of the program is looked at.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    pub gathers: bool,
    of_part: Vec<Refused>,
    /// Byte and code of those: a block that runs several times is refused once.
    met: HashSet<(usize, &'static str)>,
    /// Those of the parts before.
    pub all: Vec<Refusal>,
}

impl Refusals {
    /// Keeps a refusal where all are gathered, and returns it else; tells whether there was none.
    pub fn keep(&mut self, done: Result<(), Refused>) -> Result<bool, Refused> {
        match done {
            Ok(()) => Ok(true),
            Err(refused) if !self.gathers => Err(refused),
            Err(refused) => {
                if self.met.insert((refused.at, refused.code)) {
                    self.of_part.push(refused);
                }
                Ok(false)
            }
        }
    }

    /// Whether there was none so far.
    pub fn is_empty(&self) -> bool {
        self.of_part.is_empty() && self.all.is_empty()
    }

    /// Keeps all of them, or returns the first, which counts the others.
    pub fn keep_all(&mut self, refused: Vec<Refused>) -> Result<(), Refused> {
        let more = refused.len().saturating_sub(1);
        for mut one in refused {
            if more > 0 && !self.gathers {
                one.message += &format!("; {more} more obstacles after it");
            }
            self.keep(Err(one))?;
        }
        Ok(())
    }

    /// Ends a part that began after so many lines: what was gathered in it gets its place.
    pub fn end_part(&mut self, program: &Program, lines_before: usize) {
        self.met.clear();
        let mut of_part = std::mem::take(&mut self.of_part);
        of_part.sort_by_key(|refused| refused.at);
        self.all.extend(of_part.into_iter().map(|refused| refused.placed(program, lines_before)));
    }
}
