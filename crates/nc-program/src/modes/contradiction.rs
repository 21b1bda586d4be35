//! Words of a block that contradict themselves or each other: two codes of one group, less than nothing of a feed.

use crate::dialect::{FlowStyle, G};
use crate::finding::{self, Severity};
use crate::modes::codes::{acts, is_idle};
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::reading::program::Word;
use crate::run::Runner;

/// Functions that say of a whole value what it counts from.
const REFERENCES: [&[u8]; 5] = [b"IC", b"AC", b"DC", b"ACP", b"ACN"];

/// The group of a code of which a block can follow one only; `None` where that is not so, or not known.
fn group(code: G) -> Option<u8> {
    Some(match code {
        G::Motion(Motion::Tangent | Motion::Through) => return None,
        G::Motion(_) => 0,
        G::Plane(_) => 1,
        G::Incremental(_) => 2,
        G::CentreAbsolute(_) => 3,
        G::Feed(_) => 4,
        G::Inch(_) | G::LengthsInch(_) => 5,
        G::Compensation(_) | G::CompensationGiven(_) => 6,
        G::ToolOffset | G::ToolTableOffset(_) | G::NoToolOffset => 7,
        G::RetractToPlane(_) => 8,
        G::WorkOffset(_) | G::ExtendedOffset => 9,
        G::Spindle(_) | G::SpeedAndFeed(..) => 10,
        G::Diameter(_) | G::DiameterOfPositions => 11,
        _ => return None,
    })
}

impl Runner<'_> {
    /// Reports two codes of one group: an alarm on LinuxCNC and Sinumerik, elsewhere the last counts. In Klartext the
    /// function and the sense of an arc are two.
    pub(crate) fn check_groups(&mut self, request: &Request) {
        let flow = self.program.dialect().flow;
        let alarm = matches!(flow, FlowStyle::OWords | FlowStyle::Structured);
        for (index, (code, word)) in request.codes().iter().enumerate() {
            let same = |other: &(G, u32)| group(other.0) == group(*code) && (alarm || other.0 != *code);
            let before = request.codes().get(..index).unwrap_or(&[]).iter().rev().find(|other| same(other));
            let Some((_, first)) = before.filter(|_| group(*code).is_some() && flow != FlowStyle::Labels) else {
                continue;
            };
            let (again, first) = (self.word_text(*word as i32), self.word_text(*first as i32));
            let (severity, what) =
                if alarm { (Severity::Error, "the control stops") } else { (Severity::Warning, "the last counts") };
            let message = format!("\"{again}\" after \"{first}\" in one block, of one group: {what}");
            let at = self.word_start(*word as i32);
            self.report(severity, finding::DUPLICATE, at, message, "write the one that is meant");
        }
    }

    /// Reports two codes that both take the block's coordinates: of what acts the last alone is done. A move beside a way to
    /// a place of the machine is its motion, and beside G92 and G52 what is in force after them.
    pub(crate) fn check_claims(&mut self, request: &Request) {
        let turns = |code: G| matches!(code, G::Rotate | G::Scale | G::Mirror(_) | G::EndMirror | G::Shift(_));
        let moves = |code: G| matches!(code, G::Motion(_) | G::Drill(_) | G::DrillAlong(..) | G::Pass(_));
        let claims = |code: G| code == G::Dwell || acts(code) && !is_idle(code);
        let both = |one: G, other: G| {
            one != other && claims(one) && (claims(other) || one != G::Dwell && acts(other))
                || turns(one) && moves(other)
                || moves(one) && turns(other)
        };
        let codes = request.codes();
        let found = codes.iter().enumerate().find_map(|(index, (code, word))| {
            let (_, first) = codes[..index].iter().find(|(before, _)| both(*before, *code))?;
            Some((*first as i32, *word as i32))
        });
        let Some((first, again)) = found else { return };
        let message = format!(
            "\"{}\" and \"{}\" in one block both take its coordinates: this is not followed",
            self.word_text(first),
            self.word_text(again)
        );
        self.warn(finding::OPAQUE, self.word_start(again), message, "write each in a block of its own");
    }

    /// Refuses a feed or a speed below zero.
    pub(crate) fn check_sign(&mut self, request: &Request) {
        for (letter, what) in [(b'F', "feed"), (b'S', "speed")] {
            if request.get(letter).is_some_and(|value| value < 0.0) {
                let word = request.word(letter);
                let message = format!("{}: a {what} below zero", self.word_text(word));
                let hint = "write it without the sign; M3 and M4 say which way the spindle turns";
                self.refuse(finding::FEED, self.word_start(word), message, hint);
            }
        }
    }

    /// Warns of coordinates beside a dwell that are not its time.
    pub(crate) fn check_dwell(&mut self, request: &Request) {
        let time: &[u8] = if self.program.dialect().flow == FlowStyle::Macro { b"YZVW" } else { b"YZUVW" };
        for letter in time.iter().filter(|letter| request.get(**letter).is_some()) {
            let word = request.word(*letter);
            let message = format!("{} beside a dwell: nothing moves", self.word_text(word));
            self.warn(finding::MISPLACED, self.word_start(word), message, "move in a block of its own");
        }
    }

    /// Refuses `X=IC(5)+2`: what counts as an increment, and from where, no manual says.
    pub(crate) fn check_reference(&mut self, word: &Word) {
        let at = self.program.value_start(word);
        let value = self.program.source().get(at..word.end()).unwrap_or(&[]);
        if let Some(offset) = stray_reference(value) {
            let message = format!("{} is not the whole value of its word", finding::excerpt(&value[offset..]));
            let hint = "write the sum inside its brackets: X=IC(5+2)";
            self.refuse(finding::EXPRESSION, at + offset, message, hint);
        }
    }
}

/// Where a value has `IC(…)` or its like as a part of itself only.
fn stray_reference(value: &[u8]) -> Option<usize> {
    let named = |at: usize, name: &[u8]| {
        let rest = value.get(at..).unwrap_or(&[]);
        let fits = rest.get(..name.len()).is_some_and(|text| text.eq_ignore_ascii_case(name));
        fits && rest[name.len()..].trim_ascii_start().first() == Some(&b'(')
    };
    let starts = |at: usize| at == 0 || !crate::reading::names::is_name(value[at - 1]) && value[at - 1] != b'$';
    let found: Vec<_> =
        (0..value.len()).filter(|at| starts(*at) && REFERENCES.iter().any(|name| named(*at, name))).collect();
    let text = value.contains(&b'"');
    let whole = found.first() == Some(&0) && closes_at_end(value);
    found.get(usize::from(whole)).filter(|_| !text).copied()
}

/// Whether the first bracket is closed by the last byte.
fn closes_at_end(value: &[u8]) -> bool {
    let mut depth = 0usize;
    for (at, byte) in value.iter().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ => continue,
        }
        if depth == 0 {
            return at + 1 == value.len();
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::stray_reference;

    #[test]
    fn only_a_whole_value_is_an_increment_or_a_position() {
        for text in ["IC(5)", "ic ( R1 + (2) )", "AC(R1)", "R1+10", "(R1+5)*2", "MAGIC(5)", "IC", "\"IC(5)+\"", ""] {
            assert_eq!(stray_reference(text.as_bytes()), None, "{text}");
        }
        for (text, at) in
            [("IC(5)+2", 0), ("2+IC(5)", 2), ("(IC(5))", 1), ("-ic(5)", 1), ("AC(IC(5))", 3), ("AC(1)*AC(2)", 0)]
        {
            assert_eq!(stray_reference(text.as_bytes()), Some(at), "{text}");
        }
    }
}
