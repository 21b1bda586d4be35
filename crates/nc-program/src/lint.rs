//! What can be said of a program without running it, and which arcs of its path a control refuses.

use std::cell::OnceCell;
use std::f64::consts::SQRT_2;

use crate::dialect::{Dialect, FlowStyle, G};
use crate::finding::{self, Finding, Severity, Unseen};
use crate::order::labels::{called, Labels};
use crate::path::{Arc, ToolPath};
use crate::reading::program::{Program, Word, WordKind};
use crate::values::asked::lengths;

/// Unknown words and codes, words twice in a block, numbers oddly written. At most `finding::MOST`.
pub fn lint(program: &Program) -> Vec<Finding> {
    let mut findings = Vec::new();
    let labels = OnceCell::new();
    for block in 0..program.blocks().len() {
        let mut seen = [None; 58];
        for word in program.words_of(block) {
            if findings.len() >= finding::MOST {
                return findings;
            }
            let finding = of_word(program, word).or_else(|| repeated(program, &mut seen, word));
            let finding = finding.or_else(|| unknown_call(program, word, &labels));
            findings.extend(finding);
        }
    }
    findings
}

/// The first word or code before a byte that the dialect does not know.
pub fn first_unknown(program: &Program, before: usize) -> Option<Finding> {
    let labels = OnceCell::new();
    let words = program.words().iter().take_while(|word| (word.start as usize) < before);
    { words }.find_map(|word| unknown(program, word).or_else(|| unknown_call(program, word, &labels)))
}

fn of_word(program: &Program, word: &Word) -> Option<Finding> {
    unknown(program, word).or_else(|| odd_number(program, word))
}

#[inline(always)]
fn unknown(program: &Program, word: &Word) -> Option<Finding> {
    let dialect = program.dialect();
    if word.kind == WordKind::Unknown && !program.begins_skip(word)
        || word.letter.is_ascii_uppercase() && !dialect.letters.has(word.letter) && !calls_macro(program, word)
        || dialect.cycle_letters.has(word.letter) && !is_of_own_cycle(program, word)
    {
        return Some(unknown_word(program, word));
    }
    (word.kind == WordKind::Number
        && !known_code(dialect, word)
        && !(word.letter == b'M' && calls_macro(program, word)))
    .then(|| unknown_code(program, word))
}

/// Whether a word is an argument of a macro, whatever its letter.
fn calls_macro(program: &Program, word: &Word) -> bool {
    let block = program.words_of(program.block_at(word.start as usize));
    block.iter().any(|other| matches!(program.code(other), Some(G::CallMacro | G::ModalMacro)))
}

fn is_of_own_cycle(program: &Program, word: &Word) -> bool {
    let block = program.words_of(program.block_at(word.start as usize));
    block.iter().any(|other| program.code(other) == Some(G::OwnCycle))
}

/// A line with carriage returns within it.
pub(crate) fn runs_on(program: &Program, word: &Word) -> Option<Finding> {
    memchr::memchr(b'\r', program.text(word))?;
    let message = "carriage returns without line feeds: where one block ends and the next begins is not known";
    let hint = "save the program with LF or CR LF at the end of each line";
    Some(Finding { severity: Severity::Error, ..warning(finding::WORD, word, message.to_owned(), hint) })
}

fn unknown_word(program: &Program, word: &Word) -> Finding {
    if let Some(found) = runs_on(program, word) {
        return found;
    }
    let message =
        format!("\"{}\" is no word of the dialect {}", finding::excerpt(program.text(word)), program.dialect().name);
    let letter_o = matches!(program.text(word), [axis, b'O' | b'o', ..] if axis.is_ascii_alphabetic());
    let hint = if letter_o {
        "it has the letter O where a number belongs: if the figure is meant, write 0"
    } else {
        "it is kept as it is and never moved; name another dialect if this one is wrong"
    };
    warning(finding::WORD, word, message, hint)
}

fn unknown_code(program: &Program, word: &Word) -> Finding {
    let message =
        format!("\"{}\" is no code of the dialect {}", finding::excerpt(program.text(word)), program.dialect().name);
    let hint = "it is kept as it is; what it does to the path is not known";
    warning(finding::CODE, word, message, hint)
}

fn odd_number(program: &Program, word: &Word) -> Option<Finding> {
    let dialect = program.dialect();
    let text = || finding::excerpt(program.text(word));
    if word.kind == WordKind::Number && dialect.flow != FlowStyle::Labels && program.text(word).contains(&b',') {
        let message = format!("\"{}\" has a comma for its decimal point: read as {}", text(), word.value);
        return Some(warning(finding::NUMBER, word, message, "write a point"));
    }
    if let Some(parameter) = dialect.rules.point.filter(|_| lacks_point(program, word)) {
        let message = format!("\"{}\" has no decimal point: what it counts is a parameter of the machine", text());
        let hint = format!("write a point; {}: {}", parameter.name, parameter.says);
        return Some(warning(finding::NUMBER, word, message, &hint));
    }
    let most = usize::from(dialect.rules.most_digits);
    if most > 0 && word.kind == WordKind::Number && matches!(word.letter, b'I'..=b'K' | b'R' | b'U'..=b'Z') {
        let digits = program.text(word).iter().filter(|byte| byte.is_ascii_digit()).count();
        if digits > most {
            let message = format!("\"{}\" has {digits} digits: the control takes {most} at most", text());
            return Some(warning(finding::NUMBER, word, message, "round it"));
        }
    }
    None
}

/// A name that is no program of the file: who knows what it does.
#[inline(always)]
fn unknown_call(program: &Program, word: &Word, labels: &OnceCell<Labels>) -> Option<Finding> {
    let by_number = program.dialect().flow == FlowStyle::Structured && word.letter == b'L';
    (word.kind == WordKind::Call || by_number).then(|| unknown_name(program, word, labels)).flatten()
}

fn unknown_name(program: &Program, word: &Word, labels: &OnceCell<Labels>) -> Option<Finding> {
    let labels = labels.get_or_init(|| Labels::read(program));
    let (name, _) = called(program, word);
    let text = name.to_ascii_uppercase();
    let message =
        format!("\"{text}\" is no word of the dialect {} and no program of this file", program.dialect().name);
    let hint = "it is kept as it is; what it does to the path is not known";
    labels.named_program(&name).is_none().then(|| warning(finding::WORD, word, message, hint))
}

/// Whether a coordinate other than zero is written without a decimal point.
fn lacks_point(program: &Program, word: &Word) -> bool {
    let is_value = matches!(word.kind, WordKind::Number | WordKind::Expression);
    let plain = is_value && word.value != 0.0 && !program.text(word).iter().any(|byte| b".#[".contains(byte));
    plain && {
        let codes =
            program.words_of(program.block_at(word.start as usize)).iter().filter_map(|word| program.code(word));
        lengths(program.dialect(), codes).has(word.letter)
    }
}

fn warning(code: &'static str, word: &Word, message: String, hint: &str) -> Finding {
    Finding {
        severity: Severity::Warning,
        code,
        message,
        hint: hint.to_owned(),
        at: word.start as usize,
        unseen: Unseen::Nothing,
    }
}

#[inline]
fn known_code(dialect: &Dialect, word: &Word) -> bool {
    match word.letter {
        b'G' => dialect.g_code(word.value).is_some(),
        b'M' => dialect.m_code(word.value).is_some(),
        _ => true,
    }
}

/// A word whose letter was seen in the block; G and M may come more than once.
fn repeated<'a>(program: &Program, seen: &mut [Option<&'a Word>; 58], word: &'a Word) -> Option<Finding> {
    if !matches!(word.kind, WordKind::Number | WordKind::Expression) || matches!(word.letter, b'G' | b'M') {
        return None;
    }
    if word.letter == b'N' && program.dialect().rules.sequence_names {
        return None; // the second one names a contour
    }
    if matches!(word.letter, b'I'..=b'K') && calls_macro(program, word) {
        return None; // further arguments
    }
    let slot = seen.get_mut(usize::from(word.letter.wrapping_sub(b'A')))?;
    let first = slot.replace(word)?;
    let (again, first) = (finding::excerpt(program.text(word)), finding::excerpt(program.text(first)));
    let message = format!("\"{again}\" after \"{first}\" in one block: the last counts");
    Some(warning(finding::DUPLICATE, word, message, "two blocks may have run together"))
}

/// What an arc may end off its circle by, mm in a metric and in an inch program: LinuxCNC's bounds, the rounding of ends
/// and centre to two and three decimals.
const OFF_MM: [f64; 2] = [0.02 * SQRT_2, 0.002 * SQRT_2 * 25.4];
/// A Sinumerik's, as it is delivered, and the most that can be set for Klartext.
const STRUCTURED_OFF_MM: f64 = 0.01;
const KLARTEXT_OFF_MM: f64 = 0.016;
/// The same by this share of the radius, where that is more …
const OFF_SHARE: f64 = 0.001;
/// … but never by as many times as that bound.
const MOST_TIMES: f64 = 100.0;

/// Reports the arcs of a path that the control refuses, at the words that set their ends.
pub(crate) fn require_sound(program: &Program, path: &ToolPath, findings: &mut Vec<Finding>) {
    for arc in &path.arcs {
        let off_mm = misfit_mm(path, arc);
        if is_refused(program, path, arc, off_mm) {
            let message = format!("the arc's end is {off_mm:+.5} mm ({:+.6} in) off its circle", off_mm / 25.4);
            let hint = "check the end point and I, J, K or R: one of them was changed without the others".to_owned();
            let at = path.at(arc.of_move, program);
            finding::add(
                findings,
                Finding {
                    severity: Severity::Error,
                    code: finding::ARC_FIT,
                    message,
                    hint,
                    at,
                    unseen: Unseen::Nothing,
                },
            );
        }
    }
}

/// Distance of the end from the centre less that of the start.
fn misfit_mm(path: &ToolPath, arc: &Arc) -> f64 {
    radius_mm(path, arc, &path.end[arc.of_move]) - radius_mm(path, arc, &path.start[arc.of_move])
}

fn radius_mm(path: &ToolPath, arc: &Arc, point: &[f64; 3]) -> f64 {
    let (first, second, _) = path.states[path.state[arc.of_move] as usize].plane.axes();
    (point[first] - arc.centre[first]).hypot(point[second] - arc.centre[second])
}

/// One by its radius that cannot be was refused before.
fn is_refused(program: &Program, path: &ToolPath, arc: &Arc, off_mm: f64) -> bool {
    let inch = usize::from(path.states[path.state[arc.of_move] as usize].inch);
    let least = match program.dialect().flow {
        FlowStyle::Structured => STRUCTURED_OFF_MM,
        FlowStyle::Labels => KLARTEXT_OFF_MM,
        _ => OFF_MM[inch],
    };
    let end = radius_mm(path, arc, &path.end[arc.of_move]);
    let larger = end.max(end - off_mm);
    arc.radius.is_nan() && off_mm.abs() > least.max(OFF_SHARE * larger).min(MOST_TIMES * least)
}
