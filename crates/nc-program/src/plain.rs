//! Blocks that say nothing but where to move: whoever looks for anything else in a program passes them over.

use crate::curve::PoleFrom;
use crate::dialect::G;
use crate::letters::Letters;
use crate::modal::{Compensation, Motion};
use crate::program::{Program, Word, WordKind};

/// Letters of positions, centres, feeds and block numbers.
const LETTERS: Letters = Letters::of(b"NXYZUVWIJKRF");

/// What a block says at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Plain {
    /// Something else, or a comment.
    Other,
    /// Nothing, or its number alone.
    Empty,
    /// Moves by numbers along X, Y and Z: lines and arcs, and their feed.
    Moves,
    /// The same without cutter compensation: `G40 G01 X5`, `L X+5 R0`.
    Uncompensated,
}

/// What that block says at most.
pub fn plain(program: &Program, block: usize) -> Plain {
    let words = program.words_of(block);
    if !is_blank_between(program, block, words) {
        return Plain::Other;
    }
    let mut said = Plain::Empty;
    for word in words.iter().filter(|word| word.letter != b'N' || word.kind != WordKind::Number) {
        said = match (word.kind, program.code(word)) {
            (_, Some(G::Compensation(Compensation::Off))) => Plain::Uncompensated,
            (_, Some(code)) if moves(code) => said.max(Plain::Moves),
            (WordKind::Number, None) if LETTERS.has(word.letter) => said.max(Plain::Moves),
            _ => return Plain::Other,
        };
    }
    said
}

impl Plain {
    fn max(self, other: Self) -> Self {
        if self as u8 > other as u8 {
            self
        } else {
            other
        }
    }
}

fn moves(code: G) -> bool {
    matches!(
        code,
        G::Motion(Motion::Rapid | Motion::Line | Motion::Clockwise | Motion::Counterclockwise)
            | G::Fast
            | G::Pole(PoleFrom::Coordinates)
    )
}

/// Whether only blanks stand between the words.
fn is_blank_between(program: &Program, block: usize, words: &[Word]) -> bool {
    let Some(span) = program.blocks().get(block) else { return false };
    let ends = words.iter().map(Word::end);
    let starts = words.iter().map(|word| word.start as usize);
    let gaps = std::iter::once(span.start as usize).chain(ends).zip(starts.chain([span.end as usize]));
    { gaps }.all(|(from, to)| {
        program.source().get(from..to).is_some_and(|gap| gap.iter().all(|byte| matches!(byte, b' ' | b'\t' | b'\r')))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::{FANUC_MILL, HEIDENHAIN};
    use crate::Dialect;

    fn of(line: &'static str, dialect: &'static Dialect) -> Plain {
        plain(&Program::read(line.as_bytes(), dialect).unwrap(), 0)
    }

    #[test]
    fn moves_and_nothing_else_are_plain() {
        for line in ["X1.", "N10 G01 X1. Y-2. Z3. F100.", "G3 X1. Y0 I0.5 J0", "G02X1.Y0.R3.", "F200.", "U1. W-2."] {
            assert_eq!(of(line, &FANUC_MILL), Plain::Moves, "{line}");
        }
        for line in ["  ", "N10"] {
            assert_eq!(of(line, &FANUC_MILL), Plain::Empty, "{line}");
        }
        for line in ["5 L X+1 Y-2 FMAX", "5 L IX+1 F200", "5 CC X+1 Y+0", "5 C X+1 Y+0 DR-"] {
            assert_eq!(of(line, &HEIDENHAIN), Plain::Moves, "{line}");
        }
        assert_eq!(of("G40 X1.", &FANUC_MILL), Plain::Uncompensated);
        assert_eq!(of("5 L X+1 R0 FMAX", &HEIDENHAIN), Plain::Uncompensated);
    }

    #[test]
    fn anything_beside_moves_is_not() {
        for line in [
            "X1. (ROUGH)",
            "X#1",
            "X[1+2]",
            "X1. M08",
            "X1. S500",
            "T1",
            "G90 X1.",
            "G41 X1. D1",
            "G81 X1. Z-2. R1.",
            "G53 Z0",
            "G28 X0",
            "G04 P100",
            "/X1.",
            "%",
            "O1000",
            "X1. A5.",
            "G92 X0",
            "#1=5",
            "X1. ,R2.",
            "X1. Q2.",
        ] {
            assert_eq!(of(line, &FANUC_MILL), Plain::Other, "{line}");
        }
        for line in ["5 L X+1 M3", "5 L X+1 RL", "5 RND R2", "5 L X+Q1", "5 L X+1 ; done", "5 * - ROUGH", "5 CT X+1"] {
            assert_eq!(of(line, &HEIDENHAIN), Plain::Other, "{line}");
        }
    }
}
