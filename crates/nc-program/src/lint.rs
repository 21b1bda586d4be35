//! What can be said of a program without running it.

use crate::dialect::{Dialect, G};
use crate::finding::{self, Finding, Severity};
use crate::program::{Program, Word, WordKind};

/// Unknown words and codes, words twice in a block, numbers oddly written. At most `finding::MOST`.
pub fn lint(program: &Program) -> Vec<Finding> {
    let mut findings = Vec::new();
    for block in 0..program.blocks().len() {
        let words = program.words_of(block);
        for (index, word) in words.iter().enumerate() {
            findings.extend(of_word(program, word));
            findings.extend(repeated(program, words.get(..index).unwrap_or(&[]), word));
        }
        if findings.len() >= finding::MOST {
            break;
        }
    }
    findings.truncate(finding::MOST);
    findings
}

fn of_word(program: &Program, word: &Word) -> Option<Finding> {
    let text = String::from_utf8_lossy(program.text(word))
        .chars()
        .take(40)
        .collect::<String>();
    let at = word.start as usize;
    let dialect = program.dialect();
    if word.kind == WordKind::Unknown
        || (word.letter.is_ascii_uppercase() && !dialect.letters.contains(&word.letter))
    {
        let message = format!("{text:?} is no word of the dialect {}", dialect.name);
        let hint = "it is kept as it is and never moved; name another dialect if this one is wrong"
            .to_owned();
        return Some(Finding::new(
            Severity::Warning,
            finding::WORD,
            at,
            message,
            hint,
        ));
    }
    if word.decimal_comma {
        let message = format!(
            "{text:?} has a comma for its decimal point; read as {}",
            word.value
        );
        return Some(Finding::new(
            Severity::Warning,
            finding::NUMBER,
            at,
            message,
            "write a point".to_owned(),
        ));
    }
    if word.kind == WordKind::Number && !known_code(dialect, word) {
        let message = format!("{text} is no code of the dialect {}", dialect.name);
        let hint = "it is kept as it is; what it does to the path is not known".to_owned();
        return Some(Finding::new(
            Severity::Warning,
            finding::CODE,
            at,
            message,
            hint,
        ));
    }
    None
}

fn known_code(dialect: &Dialect, word: &Word) -> bool {
    match word.letter {
        b'G' => g(dialect, word.value).is_some(),
        b'M' => {
            (0.0..=999.0).contains(&word.value) && (dialect.m)(word.value.round() as u16).is_some()
        }
        _ => true,
    }
}

fn g(dialect: &Dialect, value: f64) -> Option<G> {
    let tenths = (value * 10.0).round();
    (0.0..=9999.0)
        .contains(&tenths)
        .then(|| (dialect.g)(tenths as u16))
        .flatten()
}

fn repeated(program: &Program, before: &[Word], word: &Word) -> Option<Finding> {
    let valued = matches!(word.kind, WordKind::Number | WordKind::Expression);
    if !valued || matches!(word.letter, b'G' | b'M') {
        return None;
    }
    let twice = |other: &&Word| other.letter == word.letter && other.kind != WordKind::Assignment;
    let first = before.iter().find(twice)?;
    let text = |word: &Word| String::from_utf8_lossy(program.text(word)).into_owned();
    let message = format!(
        "{} after {} in one block: the last counts",
        text(word),
        text(first)
    );
    let hint = "two blocks may have run together".to_owned();
    Some(Finding::new(
        Severity::Warning,
        finding::DUPLICATE,
        word.start as usize,
        message,
        hint,
    ))
}
