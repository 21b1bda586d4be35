//! The arguments of a cycle, in brackets behind its name: `CYCLE95("PART",2,0.1,,0,R5)`.

use crate::reading::names::skip_blank;
use crate::run::Runner;

/// More than this are no cycle's.
const MOST: usize = 64;

/// An argument: a text, a value, or left out.
#[derive(Clone, Debug)]
pub(crate) struct Argument {
    pub text: Option<String>,
    /// NaN of a text and of what is left out.
    pub value: f64,
    /// The bytes of a value, from one to before another.
    pub span: (u32, u32),
}

const LEFT_OUT: Argument = Argument { text: None, value: f64::NAN, span: (0, 0) };

impl Runner<'_> {
    /// Those of a word. `None` where they cannot be read; why has been reported.
    pub(crate) fn cycle_arguments(&mut self, word: i32) -> Option<Vec<Argument>> {
        let found = self.program.word(word)?;
        let source = self.program.source().get(..found.end())?;
        let open = memchr::memchr(b'(', source.get(found.start as usize..)?);
        let mut at = found.start as usize + open? + 1;
        let mut arguments = Vec::new();
        loop {
            at = skip_blank(source, at);
            let argument = match source.get(at) {
                Some(b'"') => {
                    let length = memchr::memchr(b'"', source.get(at + 1..)?)?;
                    let text = String::from_utf8_lossy(source.get(at + 1..at + 1 + length)?).into_owned();
                    at += length + 2;
                    Argument { text: Some(text), ..LEFT_OUT }
                }
                Some(b',' | b')') => LEFT_OUT,
                _ => {
                    let (value, end) = self.value(at);
                    if end == at {
                        return None;
                    }
                    let span = (at as u32, end as u32);
                    at = end;
                    Argument { value, span, ..LEFT_OUT }
                }
            };
            arguments.push(argument);
            at = skip_blank(source, at);
            match source.get(at) {
                Some(b',') if arguments.len() < MOST => at += 1,
                _ => return Some(arguments),
            }
        }
    }
}

/// The values of the first ones; `None` of what is no value.
pub(crate) fn numbers<const N: usize>(arguments: &[Argument]) -> [Option<f64>; N] {
    std::array::from_fn(|index| arguments.get(index).map(|argument| argument.value).filter(|value| !value.is_nan()))
}
