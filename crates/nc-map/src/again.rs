//! The written program is run again: every move has to end where it was to be displaced to. What a program computes from
//! where the tool stands is displaced already, and no term of a word may add to that.

use std::ops::Range;

use nc_program::dialect::G;
use nc_program::{place_read, Options, Program, Session, TooLarge, ToolPath, Word};

use crate::edits::Edits;
use crate::field::Vector;
use crate::refusal::Refused;

/// The run of what was written.
#[derive(Debug)]
pub(crate) struct Again(Session);

/// A program as it was given, and where each of its moves is to end, mm; `None` within a cycle, and back by no word.
pub(crate) struct Meant<'a> {
    pub program: &'a Program,
    pub path: &'a ToolPath,
    pub ends: &'a [Option<Vector>],
    pub edits: &'a Edits,
    /// By how much rounding may take the end of a move, mm.
    pub rounding_mm: f64,
}

impl Again {
    pub fn new(options: Options) -> Self {
        Self(Session::new(options))
    }

    /// Refuses a program of which a move ends elsewhere than it is meant to.
    pub fn require(&mut self, written: &[u8], meant: &Meant) -> Result<(), Refused> {
        let read = Program::read(written.to_vec(), meant.program.dialect());
        let program = read.map_err(|TooLarge { bytes }| {
            let message = format!("the program becomes {bytes} bytes: 2147483647 is the most");
            Refused::block(0, message, "split the program")
        })?;
        let (path, _) = self.0.run(&program, program.blocks().len());
        let first = meant.edits.first_lines(meant.program);
        let lines = |index: usize| {
            let block = meant.path.block[index] as usize;
            first[block]..first[block + 1]
        };
        // Of the blocks at hand moves may be left that a cycle makes, or that come where the last one was to end.
        let (mut at, mut open) = (0, Vec::new());
        for (index, end) in meant.ends.iter().enumerate() {
            let here = lines(index);
            let Some(end) = end else {
                open.push(here);
                continue;
            };
            let mut first_end = None;
            loop {
                let line = path.block.get(at).map(|block| *block as usize);
                if !line.is_some_and(|line| here.contains(&line) || is_open(&open, line)) {
                    return Err(elsewhere(meant, index, *end, first_end));
                }
                first_end = first_end.or(path.end.get(at).copied());
                at += 1;
                if line.is_some_and(|line| here.contains(&line)) && is_at(&path.end[at - 1], end, meant.rounding_mm) {
                    break;
                }
            }
            open = vec![here];
        }
        match path.block.get(at).filter(|block| !is_open(&open, **block as usize)) {
            Some(_) if !meant.ends.is_empty() => {
                let index = meant.ends.len() - 1;
                Err(elsewhere(meant, index, meant.path.end[index], path.end.get(at).copied()))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a program reads where the tool stands, or calls a cycle at a place whose height adds to that of the cycle.
pub(crate) fn is_doubtful(program: &Program) -> bool {
    let at_place = |word: &Word| program.code(word) == Some(G::CallCycleAt);
    place_read(program).is_some() || program.words().iter().any(at_place)
}

fn is_open(open: &[Range<usize>], line: usize) -> bool {
    open.iter().any(|lines| lines.contains(&line))
}

fn is_at(point: &Vector, other: &Vector, within_mm: f64) -> bool {
    let alike = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= within_mm;
    point.iter().zip(other).all(alike)
}

fn elsewhere(meant: &Meant, index: usize, end: Vector, found: Option<Vector>) -> Refused {
    let program = meant.program;
    let at = program.blocks().get(meant.path.block[index] as usize).map_or(0, |block| block.start as usize);
    let point = |at: Vector| format!("X {:.4} Y {:.4} Z {:.4} mm", at[0], at[1], at[2]);
    let goes = found.map_or("the written program does not come to".to_owned(), |found| {
        format!("the written program ends this move at {} in place of", point(found))
    });
    let Some(key) = place_read(program) else {
        let message = format!("{goes} {}", point(end));
        return Refused::block(at, message, "write the place as a move, and call the cycle there by M99");
    };
    let message = format!("{goes} {}: {key} is where the tool stands, which is displaced already", point(end));
    let hint = format!("write the position in place of {key}, as a number or as a parameter set to numbers");
    Refused::block(at, message, &hint)
}
