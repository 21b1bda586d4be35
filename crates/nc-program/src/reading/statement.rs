//! Statements in parentheses: `(UPD, tool, TOV(axis), value)` updates a tool's offset [NISTIR 6811, Appendix A].

use crate::reading::number;
use crate::reading::program::{Program, WordKind};

/// A tool offset update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetStatement {
    /// Tool number.
    pub tool: u32,
    /// Axis letter.
    pub axis: u8,
    /// The value, in program units.
    pub value: f64,
    /// First byte of the value.
    pub value_start: usize,
    /// One past its last byte.
    pub value_end: usize,
    /// Index of the statement's word.
    pub word: usize,
}

/// Every tool offset update of a program whose value is a number.
pub fn offset_statements(program: &Program) -> Vec<OffsetStatement> {
    let statements = program.words().iter().enumerate().filter(|(_, word)| word.kind == WordKind::Statement);
    statements.filter_map(|(index, word)| parse(program.text(word), word.start as usize, index)).collect()
}

fn parse(text: &[u8], offset: usize, word: usize) -> Option<OffsetStatement> {
    let mut fields = fields(text);
    let name = fields.next()?.1;
    let tool = std::str::from_utf8(fields.next()?.1).ok()?.parse().ok()?;
    let axis =
        *fields.next()?.1.to_ascii_uppercase().strip_prefix(b"TOV(")?.strip_suffix(b")")?.trim_ascii().first()?;
    let (start, text) = fields.next()?;
    let (value, used) = number::read(text, 0)?;
    let complete = name.eq_ignore_ascii_case(b"UPD") && used == text.len() && fields.next().is_none();
    complete.then_some(OffsetStatement {
        tool,
        axis,
        value,
        value_start: offset + start,
        value_end: offset + start + used,
        word,
    })
}

/// The fields between the outer parentheses, split at commas and trimmed, each with its offset.
fn fields(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let inner = text.get(1..text.len().saturating_sub(1)).unwrap_or(&[]);
    let mut at = 1;
    inner.split(|byte| *byte == b',').map(move |field| {
        let start = at + field.len() - field.trim_ascii_start().len();
        at += field.len() + 1;
        (start, field.trim_ascii())
    })
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn an_offset_update_and_its_value() {
        let found = parse(b"(UPD, 1, TOV(X), 0.00000)", 6, 0).unwrap();
        assert_eq!((found.tool, found.axis, found.value), (1, b'X', 0.0));
        assert_eq!((found.value_start, found.value_end), (6 + 17, 6 + 24));
        assert_eq!(parse(b"(ID,PROG, 030021, Finish)", 0, 0), None);
        assert_eq!(parse(b"(UPD, 1, TOV(X), P1)", 0, 0), None);
        assert_eq!(parse(b"()", 0, 0), None);
    }
}
