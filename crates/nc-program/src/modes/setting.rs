//! Settings of speed, smoothing and tolerance: the path stays what it is, the control follows it more or less closely.
//! Old ones reach further: those are not followed.

use crate::finding;
use crate::modes::request::Request;
use crate::run::Runner;

/// Axes that a setting may name, with zeros: `G05.1 Q2 X0 Y0 Z0`. With another value who knows what it does.
const AXES: [u8; 6] = *b"ABCXYZ";

impl Runner<'_> {
    /// A setting by a letter's value, as `G05 P10000`: any other value may call what is not in the program.
    pub(crate) fn setting(&mut self, request: &Request, letter: u8, known: &[f64], word: i32) {
        let named = AXES.iter().all(|axis| request.get(*axis).is_none_or(|value| value == 0.0));
        if named && request.get(letter).is_some_and(|value| known.contains(&value)) {
            return;
        }
        let with = request
            .get(letter)
            .map_or_else(|| format!("without {}", char::from(letter)), |_| self.word_text(request.word(letter)));
        let message = format!("{} {with}: the path goes on as if it were not there", self.word_text(word));
        let hint = "what it does with this value is not known; write it without this code";
        self.warn(finding::OPAQUE, self.word_start(word), message, hint);
    }

    /// CYCLE832: the tolerance, and the kind of machining.
    pub(crate) fn tolerance_cycle(&mut self, word: i32) {
        if !self.program.word(word).is_some_and(|word| keeps_frame(self.program.text(word))) {
            self.unfollowed(word);
        }
    }
}

/// Whether the second argument says no more than the kind of machining: `_FINISH`, 0 to 99. From the hundreds on its
/// digits have switched other modes in former releases, a transformation among them, and are ignored today.
fn keeps_frame(text: &[u8]) -> bool {
    let Some(open) = memchr::memchr(b'(', text) else { return false };
    let Some(inside) = text.get(open + 1..).and_then(|rest| rest.strip_suffix(b")")) else { return false };
    let mode = inside.split(|byte| *byte == b',').nth(1).unwrap_or(&[]);
    !inside.contains(&b')') && mode.split(|byte| *byte == b'+').all(|part| is_kind(part.trim_ascii()))
}

/// A constant of the control, a kind by number, with the choice of the surface in the millions, or nothing.
fn is_kind(text: &[u8]) -> bool {
    let number = std::str::from_utf8(text).ok().and_then(|text| text.parse::<u32>().ok());
    text.is_empty() || text.starts_with(b"_") || number.is_some_and(|number| number / 100 % 10_000 == 0)
}

#[cfg(test)]
mod tests {
    use super::keeps_frame;

    #[test]
    fn kinds_of_machining_and_what_former_releases_switched() {
        for text in [
            "()",
            "(0.01,_FINISH,1)",
            "(R1, 3 ,1)",
            "(0.01)",
            "(0.01,1000001,1)",
            "(_T,_TOP_SURFACE_SMOOTH_ON+_ORI_FINISH,1)",
        ] {
            assert!(keeps_frame(format!("CYCLE832{text}").as_bytes()), "{text}");
        }
        for text in ["(0.01,102001)", "(0.1,1003)", "(0.01,R1)", "(0.01,1,1) TRAORI", "(0.01", "", "(0.01,1)(2,3)"] {
            assert!(!keeps_frame(format!("CYCLE832{text}").as_bytes()), "{text}");
        }
    }
}
