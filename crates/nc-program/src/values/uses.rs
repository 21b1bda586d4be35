//! Which parameters a program reads.

use std::collections::HashSet;

use crate::dialect::Naming;
use crate::finding::excerpt;
use crate::reading::names;
use crate::reading::program::{Program, Word, WordKind};
use crate::reading::scan::NAME_LENGTH;
use crate::values::expression::{self, Values};
use crate::values::parameters::{read_number, Key};
use crate::values::scope::is_place;

/// Every parameter that some expression reads, with the byte of its first use; those of a computed number left out.
pub fn parameters_used(program: &Program) -> Vec<(Key<'static>, usize)> {
    let (mut used, mut known) = (Vec::new(), HashSet::new());
    for word in program.words() {
        let from = match word.kind {
            WordKind::Expression | WordKind::Assignment => program.value_start(word),
            WordKind::Flow => word.start as usize,
            _ => continue,
        };
        if program.dialect().formulas {
            let mut read = Read(Vec::new());
            let from = names::meaning(program.source(), from, program.dialect()).map_or(from, |(_, end)| end);
            let _ = expression::formula(program.source(), from, program.dialect(), &mut read);
            used.extend(read.0.into_iter().filter(|(key, _)| known.insert(key.clone())));
            continue;
        }
        for at in from..word.end() {
            if let Some(key) = key_at(program, at).filter(|key| known.insert(key.clone())) {
                used.push((key.into_owned(), at));
            }
        }
    }
    used
}

/// The first parameter that a program reads to know where the tool stands, or touched, as it is written; or one whose number
/// is computed, which may be such.
pub fn place_read(program: &Program) -> Option<String> {
    let dialect = program.dialect();
    let place = parameters_used(program).into_iter().find(|(key, _)| is_place(key, dialect));
    if place.is_some() || dialect.formulas {
        return place.map(|(key, _)| key.text(dialect));
    }
    let computed = |word: &&Word| {
        let marks = program.text(word).split(|byte| *byte == dialect.parameters.mark).skip(1);
        let of_value = matches!(word.kind, WordKind::Expression | WordKind::Assignment | WordKind::Flow);
        of_value && { marks }.any(|rest| matches!(rest.trim_ascii_start().first(), None | Some(b'[')))
    };
    let word = program.words().iter().filter(|_| dialect.parameters.unset_is_zero).find(computed)?;
    Some(excerpt(program.text(word)))
}

/// Notes what an expression asks for.
struct Read(Vec<(Key<'static>, usize)>);

impl Values for Read {
    fn get(&mut self, key: &Key, at: usize) -> f64 {
        self.0.push((key.clone().into_owned(), at));
        f64::NAN
    }

    fn exists(&self, _: &Key) -> bool {
        false
    }
}

fn key_at(program: &Program, at: usize) -> Option<Key<'_>> {
    let (source, rules) = (program.source(), program.dialect().parameters);
    if source.get(at)?.to_ascii_uppercase() != rules.mark {
        return None;
    }
    if let Some((key, _)) = read_number(source, at + 1) {
        return Some(key);
    }
    let name = source.get(at + 1..)?.strip_prefix(b"<").filter(|_| rules.named == Naming::Brackets)?;
    let length = memchr::memchr2(b'>', b'\n', name.get(..NAME_LENGTH.min(name.len()))?)?;
    (name.get(length) == Some(&b'>')).then(|| Key::named(name.get(..length).unwrap_or(&[])))
}
