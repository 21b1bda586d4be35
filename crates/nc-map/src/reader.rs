//! The parts of a program, read and run one after the other.

use std::collections::HashMap;

use nc_program::{finding, first_unknown, Dialect, Finding, Options, Program, Session, Severity, TooLarge, ToolPath};

use crate::refusal::Refused;
use crate::role::{names_axis, roles, Role};

/// Mends a block whose moves are not those of its words.
const WRITE_OUT: &str = "write what it does out as moves; where exactly it goes is not known here";

/// A part: whole lines, of which some at its end are only looked at.
pub(crate) struct Part {
    pub program: Program,
    /// Blocks from this one on are looked at only.
    pub until: usize,
    /// One past the last byte of the blocks before.
    pub end: usize,
    pub path: ToolPath,
    pub roles: HashMap<usize, Role>,
    /// Whether a move came of each block.
    pub moved: Vec<bool>,
    /// The program's end was reached.
    pub ended: bool,
    /// Nothing comes after it that moves or is moved.
    pub last: bool,
    /// Why it cannot be displaced, in the order of the blocks.
    pub refused: Vec<Refused>,
}

/// What reads them.
pub(crate) struct Reader {
    dialect: &'static Dialect,
    session: Session,
    /// Bytes not dealt with yet.
    waiting: Vec<u8>,
    /// There is one part only.
    whole: bool,
}

impl Reader {
    pub fn new(dialect: &'static Dialect, options: Options, whole: bool) -> Self {
        Self { dialect, session: Session::new(options), waiting: Vec::new(), whole }
    }

    /// The part that the next bytes complete. The last whole line waits: the one before is numbered by it.
    pub fn next(&mut self, bytes: &[u8]) -> Result<Option<Part>, TooLarge> {
        self.waiting.extend_from_slice(bytes);
        let last = if self.whole { None } else { memchr::memrchr(b'\n', &self.waiting) };
        let Some(last) = last else { return Ok(None) };
        let rest = self.waiting.split_off(last + 1);
        let part = std::mem::replace(&mut self.waiting, rest);
        let kept = memchr::memrchr(b'\n', part.get(..last).unwrap_or(&[])).map_or(0, |before| before + 1);
        self.waiting.splice(0..0, part.get(kept..).unwrap_or(&[]).iter().copied());
        self.part(part, 1).map(Some)
    }

    /// What is left.
    pub fn last(&mut self) -> Result<Part, TooLarge> {
        let part = std::mem::take(&mut self.waiting);
        self.part(part, 0)
    }

    /// A part of whole lines, of which the last `ahead` are only looked at.
    fn part(&mut self, source: Vec<u8>, ahead: usize) -> Result<Part, TooLarge> {
        let program = Program::read(source, self.dialect)?;
        let until = program.blocks().len().saturating_sub(ahead);
        let end = program.blocks().get(until).map_or(program.source().len(), |block| block.start as usize);
        let (path, findings) = self.session.run(&program, until);
        let (roles, moved) = (roles(&program), moved(&program, &path));
        let refused = obstacles(&program, findings, &moved, &roles, end);
        Ok(Part { program, until, end, path, roles, moved, ended: self.session.ended(), last: ahead == 0, refused })
    }
}

/// Whether a move came of each block.
fn moved(program: &Program, path: &ToolPath) -> Vec<bool> {
    let mut moved = vec![false; program.blocks().len()];
    for block in &path.block {
        if let Some(slot) = moved.get_mut(*block as usize) {
            *slot = true;
        }
    }
    moved
}

/// What is not understood, cannot be run, or moves the tool where the path does not say.
fn obstacles(
    program: &Program,
    findings: Vec<Finding>,
    moved: &[bool],
    roles: &HashMap<usize, Role>,
    end: usize,
) -> Vec<Refused> {
    let refuses = |found: &Finding| match (found.severity, found.code) {
        (Severity::Error, _) | (Severity::Warning, finding::OPAQUE | finding::DIAMETER | finding::UNIT) => true,
        (_, finding::OPAQUE) => {
            let block = program.block_at(found.at);
            let cycle = roles.get(&block) == Some(&Role::Cycle);
            cycle
                || names_axis(program, block)
                    && !roles.contains_key(&block)
                    && !moved.get(block).is_some_and(|moved| *moved)
        }
        _ => false,
    };
    let met = findings.into_iter().filter(|found| found.at < end && refuses(found));
    let mut all: Vec<Finding> = first_unknown(program, end).into_iter().chain(met).collect();
    all.sort_by_key(|found| found.at);
    all.dedup_by_key(|found| (found.at, found.code));
    let refused = |found: Finding| {
        // What a note leaves as it is, a field over the whole program cannot.
        let hint = if found.severity == Severity::Note { WRITE_OUT.into() } else { found.hint };
        Refused { hint, ..Refused::new(found.code, found.at, found.message, "") }
    };
    all.into_iter().map(refused).collect()
}
