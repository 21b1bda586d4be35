//! What a byte starts: words, comments, statements.

/// Where white space does not end a word of a letter and a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blanks {
    /// Nowhere.
    End,
    /// Between the letter and the number: `X 15.`.
    BeforeNumber,
    /// There, and within the number: `X 1 5.`.
    WithinNumber,
}

/// What a byte means where a word may start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// Ends the block.
    LineEnd,
    /// Between words.
    Space,
    /// Starts a word.
    Letter,
    /// Starts a word that may be a name, though it looks like a letter and a number.
    Name,
    /// At a line's start: the block's number, without a letter.
    Digit,
    /// Starts a comment that runs to the line's end.
    LineComment,
    /// Ends the block where nothing but comments follows on its line: the sign that a control shows as the end of a block.
    BlockEnd,
    /// Starts a comment that runs to the closing parenthesis.
    Comment,
    /// Starts a statement that runs to the matching parenthesis.
    Statement,
    /// At a line's start: the block is optional.
    Slash,
    /// At a line's start: end of tape.
    Percent,
    /// Starts an assignment.
    Parameter,
    /// Before a letter: a word of its own, `,R0.5`.
    Comma,
    /// Not known here.
    Other,
}

/// Byte classes that all dialects share: letters, white space and NUL, line end, percent sign.
pub(crate) const fn common_classes(own: &[(u8, Class)]) -> [Class; 256] {
    let mut classes = [Class::Other; 256];
    let mut byte = 0;
    while byte < 256 {
        classes[byte] = match byte as u8 {
            b'\n' => Class::LineEnd,
            b' ' | b'\t' | b'\r' | 0x0b | 0x0c | 0 => Class::Space,
            b'A'..=b'Z' | b'a'..=b'z' => Class::Letter,
            b'%' => Class::Percent,
            b'/' => Class::Slash,
            _ => Class::Other,
        };
        byte += 1;
    }
    let mut index = 0;
    while index < own.len() {
        classes[own[index].0 as usize] = own[index].1;
        index += 1;
    }
    classes
}
