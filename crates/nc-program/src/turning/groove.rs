//! Grooving cycles of lathes (G74 along Z, G75 along X) taken apart into moves, in the plane of (deep, across).

use crate::drilling::drill::PECK_CLEARANCE;
use crate::finding;
use crate::modes::request::Request;
use crate::path::MoveKind;
use crate::run::Runner;
use crate::shapes::arc::Point;

/// More pecks in all grooves than this are a slip.
const MOST: f64 = 10_000.0;
/// Lengths closer than this are one, mm.
const SAME: f64 = 1e-9;

/// Grooves side by side, each cut in pecks.
struct Grooving {
    /// Where the tool stands, and the last groove's bottom.
    start: Point,
    end: Point,
    /// Depth of a peck, and how far grooves are apart; infinite for one.
    peck: f64,
    step: f64,
    /// How far the tool goes back after a peck.
    back: f64,
    /// How far it gives way across at the bottom, back to where the groove before was.
    relief: f64,
}

impl Grooving {
    /// The moves; `None` where the pecks or steps make no sense.
    fn steps(&self) -> Option<Vec<(MoveKind, Point)>> {
        let [depth, width] = [0, 1].map(|axis| (self.end[axis] - self.start[axis]).abs());
        let times = |length: f64, each: f64| ((length - SAME) / each).ceil().max(1.0);
        let (grooves, pecks) = (times(width, self.step) + f64::from(u8::from(width > SAME)), times(depth, self.peck));
        if !(self.peck > 0.0 && self.step > 0.0 && grooves * pecks <= MOST) {
            return None;
        }
        let [into, over] = [0, 1].map(|axis| (self.end[axis] - self.start[axis]).signum());
        let mut steps = Vec::new();
        for groove in 0..grooves as usize {
            let across =
                if groove == 0 { self.start[1] } else { self.start[1] + over * (groove as f64 * self.step).min(width) };
            let at = |deep: f64| [self.start[0] + into * deep, across];
            if groove > 0 {
                steps.push((MoveKind::Rapid, at(0.0)));
            }
            for peck in 1..pecks as usize {
                let deep = peck as f64 * self.peck;
                steps.extend([(MoveKind::Line, at(deep)), (MoveKind::Rapid, at(deep - self.back.min(deep)))]);
            }
            let away = if groove > 0 { across - over * self.relief } else { across };
            steps.push((MoveKind::Line, [self.end[0], across]));
            if away != across {
                steps.push((MoveKind::Rapid, [self.end[0], away]));
            }
            steps.push((MoveKind::Rapid, [self.start[0], away]));
        }
        steps.push((MoveKind::Rapid, self.start));
        Some(steps)
    }
}

impl Runner<'_> {
    /// G74 (`deep` 2) or G75 (`deep` 0): the first of two blocks says how far the tool goes back after a peck; the other
    /// the end, P and Q the peck and the step along X and Z (of Haas I and K), R (of Haas D) the relief at the bottom.
    pub(crate) fn groove(&mut self, request: &Request, deep: usize, word: i32) {
        let mm = self.state.modal.mm();
        if !self.names_axis(request) {
            self.state.groove_back = request.get(b'R').map_or(self.state.groove_back, |back| back * mm);
            return;
        }
        let across = 2 - deep;
        let ((end, words), start) = (self.target(request, false), self.state.position);
        let plain = |letter: u8| request.get(letter).map(|value| value * mm);
        let along = |axis: usize| match axis {
            0 => self.stepped(request, b'P').or(plain(b'I')),
            _ => self.stepped(request, b'Q').or(plain(b'K')),
        };
        let (peck, step) = (along(deep).unwrap_or(f64::INFINITY), along(across));
        let has_other = step.is_none() && (end[across] - start[across]).abs() > SAME;
        if has_other {
            let what = "the step to the groove at its end is not given, that groove is not in the path";
            let hint = "write the step (G74: P, of Haas I; G75: Q, of Haas K), or leave out the word of that axis";
            let message = format!("{}: {what}", self.word_text(word));
            self.warn(finding::MISPLACED, self.word_start(word), message, hint);
        }
        let relief = plain(b'R').or(self.stepped(request, b'D'));
        let known = !self.state.groove_back.is_nan();
        let grooving = Grooving {
            start: [start[deep], start[across]],
            end: [end[deep], if has_other { start[across] } else { end[across] }],
            peck,
            step: step.unwrap_or(f64::INFINITY),
            back: if known { self.state.groove_back } else { PECK_CLEARANCE },
            relief: relief.unwrap_or(0.0).abs(),
        };
        let Some(steps) = grooving.steps() else {
            let message = "a grooving cycle whose pecks or steps make no sense".to_owned();
            let hint = "it wants the end, and P and Q greater than zero: the peck and the step to the next groove";
            return self.refuse(finding::MISPLACED, self.block_start(), message, hint);
        };
        if !known && peck < (end[deep] - start[deep]).abs() {
            let what = format!("how far it goes back after a peck is the control's; taken as {PECK_CLEARANCE} mm");
            self.note_opaque(word, &what);
        }
        let placed = |(kind, point): (MoveKind, Point)| {
            let mut position = start;
            (position[deep], position[across]) = (point[0], point[1]);
            (kind, position)
        };
        self.emit_turned(steps.into_iter().map(placed), words, end);
    }
}

#[cfg(test)]
mod tests {
    use super::Grooving;

    #[test]
    fn pecks_and_steps_that_make_no_sense() {
        let fit = Grooving { start: [30.0, 0.0], end: [10.0, -9.0], peck: 5.0, step: 4.0, back: 1.0, relief: 0.0 };
        assert_eq!(fit.steps().map(|steps| steps.len()), Some(4 * (2 * 3 + 2) + 3 + 1));
        for (peck, step) in [(0.0, 4.0), (5.0, 0.0), (1e-9, 4.0), (5.0, 1e-9), (-1.0, 4.0), (f64::NAN, 4.0)] {
            assert!(Grooving { peck, step, ..fit }.steps().is_none());
        }
    }
}
