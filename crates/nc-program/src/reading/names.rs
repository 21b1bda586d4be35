//! Words of more than a letter, `CR=5`, `DIAMON`, `CALL LBL 3`: found in the dialect's list.

use crate::dialect::{Dialect, FlowStyle, G, M};
use crate::order::flow::Flow;

/// What a word of more than a letter means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Name {
    /// An address, kept under that letter: a value follows. Lower case: one that no single letter stands for.
    Address(u8),
    /// An address whose value is an increment, whatever mode is in force.
    Increment(u8),
    /// Acts as a G code.
    Code(G),
    /// Acts as an M code.
    Function(M),
    /// Without influence on the path, with the value or the arguments in brackets that follow.
    Inert,
    /// The rest of its line is text: it acts as a G code.
    Text(G),
    /// Flow control: the rest of its line belongs to it.
    Flow(Flow),
}

/// A dialect's names, and where those of each letter begin.
#[derive(Debug)]
pub(crate) struct Names {
    list: &'static [(&'static str, Name)],
    first: [usize; 128],
}

impl Names {
    /// No names.
    pub const NONE: Self = Self::of(&[]);

    /// Those of a list, in which the names of a letter stand together, in upper case.
    pub const fn of(list: &'static [(&'static str, Name)]) -> Self {
        let mut first = [usize::MAX; 128];
        let (mut index, mut before) = (0, 0);
        while index < list.len() {
            let letter = list[index].0.as_bytes()[0];
            if letter != before {
                assert!(first[letter as usize] == usize::MAX, "names of one letter stand together");
                first[letter as usize] = index;
                before = letter;
            }
            index += 1;
        }
        Self { list, first }
    }

    pub const fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The name of that index.
    pub fn get(&self, index: usize) -> Option<Name> {
        self.list.get(index).map(|(_, name)| *name)
    }

    /// As the first one of that meaning is written.
    pub fn spelt(&self, meaning: Name) -> Option<&'static str> {
        self.list.iter().find(|(_, name)| *name == meaning).map(|(text, _)| *text)
    }
}

/// The index of the name that stands at a byte, and one past it. The first of the list that fits counts.
pub(crate) fn find(source: &[u8], at: usize, dialect: &Dialect) -> Option<(usize, usize)> {
    let letter = source.get(at)?.to_ascii_uppercase();
    let first = *dialect.names.first.get(usize::from(letter))?;
    let same = dialect.names.list.get(first..)?.iter().take_while(|(name, _)| name.as_bytes().first() == Some(&letter));
    let digits = dialect.flow == FlowStyle::Labels; // a value may follow at once: `IX5`, `RND RQ5`
    let mut fitting = same.enumerate();
    fitting.find_map(|(offset, (name, _))| Some((first + offset, ends(source, at, name.as_bytes(), digits)?)))
}

/// The meaning of the name that stands at a byte, and one past it.
pub(crate) fn meaning(source: &[u8], at: usize, dialect: &Dialect) -> Option<(Name, usize)> {
    let (index, end) = find(source, at, dialect)?;
    Some((dialect.names.get(index)?, end))
}

/// Where a name ends that is written as the pattern says: `#` stands for digits, a space for white space or none,
/// a tab for white space or the end that must follow.
fn ends(source: &[u8], mut at: usize, pattern: &[u8], digits: bool) -> Option<usize> {
    for wanted in pattern {
        match wanted {
            b' ' => at = skip(source, at, |byte| matches!(byte, b' ' | b'\t')),
            b'\t' if source.get(at).is_none_or(u8::is_ascii_whitespace) => {}
            b'#' => {
                let end = skip(source, at, |byte| byte.is_ascii_digit());
                if end == at {
                    return None;
                }
                at = end;
            }
            _ if source.get(at)?.eq_ignore_ascii_case(wanted) => at += 1,
            _ => return None,
        }
    }
    let open = pattern.last().is_some_and(|byte| is_name(*byte) || *byte == b'#');
    let value = source.get(at..).unwrap_or(&[]);
    let value = value.strip_prefix(b"Q").map_or(value, |rest| rest.strip_prefix(b"L").unwrap_or(rest));
    let has_value = digits && value.first().is_some_and(u8::is_ascii_digit);
    (!open || has_value || !source.get(at).is_some_and(|byte| is_name(*byte))).then_some(at)
}

/// Whether a byte belongs to a name.
pub(crate) fn is_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Whether a name may start with a byte.
pub(crate) fn is_start(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$')
}

/// One past the bytes from `at` on that are such.
pub(crate) fn skip(source: &[u8], at: usize, such: impl Fn(u8) -> bool) -> usize {
    at + source.iter().skip(at).take_while(|byte| such(**byte)).count()
}

/// One past the white space of a line.
pub(crate) fn skip_blank(source: &[u8], at: usize) -> usize {
    skip(source, at, |byte| matches!(byte, b' ' | b'\t'))
}

/// One past a word that stands at a byte after white space, in either case.
pub(crate) fn after(source: &[u8], at: usize, word: &[u8]) -> Option<usize> {
    let at = skip_blank(source, at);
    let end = at + word.len();
    source.get(at..end)?.eq_ignore_ascii_case(word).then_some(end)
}

/// One past the name that starts at a byte: a letter, `_` or `$`, then letters, digits, `_`.
pub(crate) fn name_end(source: &[u8], at: usize) -> Option<usize> {
    is_start(*source.get(at)?).then(|| skip(source, at + 1, is_name))
}
