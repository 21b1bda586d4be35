//! Codes of Fanuc's kind that scale and mirror the coordinates of what follows.

use crate::dialect::FlowStyle;
use crate::finding::{self, Severity};
use crate::modes::linear::Linear;
use crate::modes::request::Request;
use crate::modes::turned_frame::{MIRRORS, SCALES};
use crate::run::{Runner, AXES};

/// How near a centre has to stay to itself, mm: no control's step is as small.
const STAYS_MM: f64 = 1e-9;

impl Runner<'_> {
    /// G51: each axis times its factor, about a centre that the block names.
    pub(crate) fn scale(&mut self, request: &Request, word: i32) {
        let Some(factors) = self.factors(request, word) else { return };
        let given = self.given(request);
        let scales = [0, 1, 2].map(|axis| factors[axis] != 1.0);
        let states = |axis: usize| !scales[axis] || given[axis].is_some_and(f64::is_finite);
        let about = given.map(|value| value.unwrap_or(0.0));
        let what = match () {
            () if self.state.modal.incremental => "the centre of a scaling under G91",
            () if self.state.frame.parts[SCALES].is_some() => "a scaling over another",
            () if !(0..3).all(states) => "a scaling about the place where the tool stands",
            () if !self.stays(SCALES, about) => "a scaling about a point that the mirror image moves",
            () => return self.set_part(SCALES, Some(Linear::scaled(factors, about)), word),
        };
        self.not_turned(
            word,
            what,
            "name X, Y and Z of the centre under G90, and end a scaling by G50 before the next",
        );
    }

    /// P, or I, J and K: of Haas as written, of Fanuc in steps of a parameter. Of the third axis another parameter says
    /// whether it is scaled.
    fn factors(&mut self, request: &Request, word: i32) -> Option<[f64; 3]> {
        let (third, rule) = (self.state.modal.plane.axes().2, self.program.dialect().rules.scale);
        let all = request.get(b'P').is_some();
        let letters = if all { *b"PPP" } else { *b"IJK" };
        let mut values = letters.map(|letter| request.get(letter));
        let mut is_clear = all && !request.any(b"IJK");
        if let Some([unit, scales_third]) = rule {
            is_clear |= !all;
            is_clear &= !letters.iter().any(|letter| self.has_point(request.word(*letter)));
            let what = "a factor of scaling counts 0.00001 or 0.001";
            let step = if self.ask(unit, Severity::Error, word, what)? == 0.0 { 1e-5 } else { 1e-3 };
            values = values.map(|value| value.map(|count| count * step));
            if self.ask(scales_third, Severity::Error, word, "the tool's axis is scaled or not")? == 0.0 {
                values[third] = Some(1.0);
            }
        }
        let positive = |value: f64| value > 0.0 || !all && value < 0.0;
        match values {
            [Some(x), Some(y), Some(z)] if is_clear && [x, y, z].into_iter().all(positive) => Some([x, y, z]),
            _ => {
                let hint = "name the factor of every axis: P, or on Fanuc I, J and K, there without a decimal point";
                let states = values.iter().any(Option::is_some);
                let what = if states {
                    "a scaling whose factors are not all given, not above zero, or in a form that the control reads otherwise,"
                } else {
                    "a scaling by a factor that the block does not state"
                };
                self.not_turned(word, what, hint);
                None
            }
        }
    }

    /// G51.1 mirrors the axes named at a position each; G101 of Haas (`at_zero`) at the zero of the work offset.
    pub(crate) fn mirror(&mut self, request: &Request, at_zero: bool, word: i32) {
        let (given, frame) = (self.given(request), &self.state.frame);
        let shifted = at_zero && ((0..3).any(|axis| given[axis].unwrap_or(0.0) != 0.0 || frame.register[axis] != 0.0));
        let named = given.iter().flatten().all(|at| at.is_finite()) && given.iter().any(Option::is_some);
        let why = match () {
            () if !named => Some("a mirror image of no axis"),
            () if self.state.modal.incremental => Some("a mirror image under G91"),
            () if given[self.state.modal.plane.axes().2].is_some() => Some("a mirror image of the tool's axis"),
            () if shifted => Some("a mirror image away from zero, or under G52 or G92,"),
            () => None,
        };
        if let Some(what) = why {
            let hint = "mirror axes of the plane under G90; on Haas at X0 or Y0, without G52 and G92";
            return self.not_turned(word, what, hint);
        }
        let before = frame.parts[MIRRORS].unwrap_or(Linear::scaled([1.0; 3], [0.0; 3]));
        let mut mirrored = before;
        for (axis, at) in given.into_iter().enumerate() {
            if let Some(at) = at {
                (mirrored.matrix[axis][axis], mirrored.shift[axis]) = (-1.0, 2.0 * at);
            }
        }
        self.set_part(MIRRORS, Some(mirrored), word);
    }

    /// G50.1 and G100: the axes named are mirrored no more.
    pub(crate) fn end_mirror(&mut self, request: &Request, word: i32) {
        let Some(mut mirrored) = self.state.frame.parts[MIRRORS] else { return };
        if !request.any(&AXES) {
            return self.not_turned(
                word,
                "the end of a mirror image of axes that it does not name",
                "name them: X0 Y0",
            );
        }
        for axis in (0..3).filter(|axis| request.get(AXES[*axis]).is_some()) {
            (mirrored.matrix[axis][axis], mirrored.shift[axis]) = (1.0, 0.0);
        }
        self.set_part(MIRRORS, Some(mirrored), word);
    }

    /// Whether what mirrors or scales outside of a part leaves its centre where it is, in the plane: else it depends on the
    /// control which of the two acts first.
    pub(crate) fn stays(&self, part: usize, about: [f64; 3]) -> bool {
        let (first, second, _) = self.state.modal.plane.axes();
        self.state.frame.parts[..part].iter().flatten().all(|outer| {
            let place = outer.place(about);
            [first, second].iter().all(|axis| (place[*axis] - about[*axis]).abs() < STAYS_MM)
        })
    }

    /// Whether a hole along an axis is scaled or mirrored in its depth, on a control whose cycles do not follow from that.
    pub(crate) fn scales_depth(&self, third: usize) -> bool {
        let scaled = self.state.frame.linear.is_some_and(|linear| linear.matrix[third][third] != 1.0);
        scaled && matches!(self.program.dialect().flow, FlowStyle::Macro | FlowStyle::Labels)
    }

    fn not_turned(&mut self, word: i32, what: &str, hint: &str) {
        let message = format!("{}: {what} is not followed", self.word_text(word));
        self.warn(finding::OPAQUE, self.word_start(word), message, hint);
    }
}
