//! What a code does, by the name of its kind: for whoever writes the program anew.

use crate::dialect::{Name, G, M};
use crate::program::{Program, Word, WordKind};

/// What a G code, or a word that acts as one, does (`Dwell`, `Drill(Tap)`), an M code with an `M` before it (`MEnd`);
/// `None` for what is none.
pub fn meaning(program: &Program, word: &Word) -> Option<String> {
    let dialect = program.dialect();
    match (word.kind, word.letter) {
        (WordKind::Number, b'G') => dialect.g_code(word.value).map(of_g),
        (WordKind::Number, b'M') => dialect.m_code(word.value).map(of_m),
        (WordKind::Name, _) => match dialect.names.get(word.value as usize)? {
            Name::Code(code) | Name::Text(code) => Some(of_g(code)),
            Name::Function(function) => Some(of_m(function)),
            Name::Inert => Some(of_g(G::Inert)),
            _ => None,
        },
        _ => None,
    }
}

fn of_g(code: G) -> String {
    match code {
        G::Setting(..) | G::ToleranceCycle => of_g(G::Inert),
        _ => format!("{code:?}"),
    }
}

fn of_m(function: M) -> String {
    format!("M{function:?}")
}
