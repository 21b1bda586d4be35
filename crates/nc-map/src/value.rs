//! The value of a word: which bytes an edit may replace, and how.

use nc_program::dialect::FlowStyle;
use nc_program::{number, Program, Word, WordKind};

use crate::refusal::Refused;
use crate::text::Step;

/// The bytes of a word's value; `AC( )` and `IC( )` of Sinumerik do not belong to it.
#[derive(Clone, Copy)]
pub(crate) struct Value {
    pub start: usize,
    pub end: usize,
    /// A number, not to be computed.
    pub is_number: bool,
}

impl Value {
    /// That of a word; refused where it stands in a way that no edit knows.
    #[inline]
    pub fn of(program: &Program, word: &Word) -> Result<Self, Refused> {
        let (start, end) = (program.value_start(word), word.end());
        let plain = Self { start, end, is_number: word.kind == WordKind::Number };
        if word.kind == WordKind::Expression && program.dialect().flow == FlowStyle::Structured {
            return plain.inside(program, word);
        }
        Ok(plain)
    }

    /// What stands in the brackets, where a name before them says whether it is a position.
    fn inside(self, program: &Program, word: &Word) -> Result<Self, Refused> {
        let text = self.text(program);
        if !text.first().is_some_and(u8::is_ascii_alphabetic) || program.reference(word).is_none() {
            return Ok(self);
        }
        let open = memchr::memchr(b'(', text).unwrap_or(text.len());
        let inside = text.get(open..).filter(|text| closes_at_end(text, b'(', b')'));
        let Some(inside) = inside.and_then(|text| text.get(1..text.len() - 1)) else {
            let message = format!("{} says its position in a way that is not followed", excerpt(program, word));
            return Err(Refused::block(word.start as usize, message, "write the position plainly, X=AC(5)"));
        };
        let number = inside.trim_ascii();
        let is_number = !number.is_empty() && number.iter().all(|byte| b"+-.0123456789".contains(byte));
        Ok(Self { start: self.start + open + 1, end: self.end - 1, is_number })
    }

    /// Its bytes.
    pub fn text<'a>(&self, program: &'a Program) -> &'a [u8] {
        program.source().get(self.start..self.end).unwrap_or(&[])
    }

    /// Writes it changed: a number anew, a formula with a term. Klartext has no formulas in its coordinates.
    pub fn change(
        &self,
        program: &Program,
        word: &Word,
        step: Step,
        (to, by): (i64, i64),
        out: &mut Vec<u8>,
    ) -> Result<(), Refused> {
        let old = self.text(program);
        if self.is_number {
            step.restyle(out, old, to);
        } else if takes_terms(program) {
            step.with_term(out, old, by, program.dialect());
        } else {
            let message = format!("{} would have to be displaced, but takes no sum", excerpt(program, word));
            return Err(Refused::block(word.start as usize, message, "write the coordinate as a number"));
        }
        Ok(())
    }
}

/// The bytes of a word's value replaced by text, and by how much its value then differs, in program units.
pub struct Moved {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
    /// What stands there then.
    pub text: Vec<u8>,
    /// New less old value, in program units; NaN where a number cannot be read.
    pub by: f64,
}

/// Moves what a word sets, by so much in program units; `None` where that rounds to nothing. Refuses a word that takes no
/// sum, and a value beyond all machines, by message and hint.
pub fn moved(program: &Program, word: &Word, step: Step, by: f64) -> Result<Option<Moved>, (String, String)> {
    let change = step.reachable(by)?;
    if change == 0 {
        return Ok(None);
    }
    let said = |refused: Refused| (refused.message, refused.hint);
    let value = Value::of(program, word).map_err(said)?;
    let inside = || number::read(value.text(program).trim_ascii(), 0).map_or(f64::NAN, |(number, _)| number);
    let given = if word.kind == WordKind::Number { word.value } else { inside() };
    let (to, mut text) = (step.reachable(if value.is_number { given + by } else { by })?, Vec::new());
    value.change(program, word, step, (to, change), &mut text).map_err(said)?;
    let by = if value.is_number { step.value(to) - given } else { step.value(change) };
    Ok(Some(Moved { start: value.start, end: value.end, text, by }))
}

/// Whether a coordinate may be a formula.
pub(crate) fn takes_terms(program: &Program) -> bool {
    program.dialect().flow != FlowStyle::Labels
}

fn excerpt(program: &Program, word: &Word) -> String {
    String::from_utf8_lossy(program.text(word)).into_owned()
}

/// Whether a bracket opens a text and closes at its end.
pub(crate) fn closes_at_end(text: &[u8], open: u8, close: u8) -> bool {
    if text.first() != Some(&open) {
        return false;
    }
    let mut depth = 0usize;
    for (position, byte) in text.iter().enumerate() {
        if *byte == open {
            depth += 1;
        } else if *byte == close {
            depth = depth.saturating_sub(1);
        }
        if depth == 0 {
            return position + 1 == text.len();
        }
    }
    false
}
