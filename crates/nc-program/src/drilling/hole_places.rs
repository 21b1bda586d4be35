//! Holes at places that a cycle or a call names itself: HOLES1, HOLES2 and CYCL CALL POS.

use std::f64::consts::TAU;

use crate::drilling::cycle_arguments::numbers;
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::{Runner, AXES};

/// More places of a pattern than this are a slip.
const MOST: f64 = 10_000.0;

/// The bytes of two coordinates, from one to before another.
type Spans = [(u32, u32); 2];

/// How a pattern's places lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// On a line: HOLES1 (SPCA, SPCO, STA1, FDIS, DBH, NUM).
    Row,
    /// On a circle: HOLES2 (CPA, CPO, RAD, STA1, INDA, NUM).
    Circle,
}

/// A move to a place of a pattern, and where the coordinates are written from which its places count.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Index of the move.
    pub of_move: usize,
    /// The axes of the plane.
    pub axes: [usize; 2],
    /// Where the reference point's coordinates stand.
    pub said: Spans,
}

impl Runner<'_> {
    /// Goes to the places of a pattern at rapid, and drills at each what MCALL has put in force.
    pub(crate) fn pattern(&mut self, pattern: Pattern, word: i32) {
        let (places, said) = match self.places(pattern, word) {
            Ok(found) => found,
            Err(why) => return self.not_followed(word, &why),
        };
        let (first, second, _) = self.state.modal.plane.axes();
        for place in places {
            let mut end = self.state.position;
            (end[first], end[second]) = (place[0], place[1]);
            self.path.placed.push(Placed { of_move: self.path.len(), axes: [first, second], said });
            self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
            if let Some(hole) = self.state.modal_cycle {
                self.drill_here(&hole);
            }
        }
    }

    /// The places in their order, mm, and where the reference point is written.
    fn places(&mut self, pattern: Pattern, word: i32) -> Result<(Vec<[f64; 2]>, Spans), String> {
        let arguments = self.cycle_arguments(word).ok_or("its arguments cannot be read")?;
        let more = |index: usize| {
            let further = arguments.get(index..).unwrap_or(&[]);
            further
                .iter()
                .any(|one| one.value != 0.0 && !one.value.is_nan() || one.text.as_ref().is_some_and(|t| !t.is_empty()))
        };
        if more(6) {
            return Err("its arguments behind the number of holes are not followed".to_owned());
        }
        let [Some(x), Some(y), third, fourth, fifth, Some(count)] = numbers::<6>(&arguments) else {
            return Err("its reference point or the number of its holes is not given".to_owned());
        };
        let count = if count.fract() == 0.0 && (1.0..=MOST).contains(&count) {
            count as usize
        } else {
            return Err(format!("it has {count} holes"));
        };
        let (first, second, _) = self.state.modal.plane.axes();
        let mm = self.state.modal.mm();
        if [first, second].iter().any(|axis| self.state.modal.axis_mm(*axis) != mm) {
            return Err("an axis of its plane counts diameters".to_owned());
        }
        let place = |distance: f64, angle_deg: f64| {
            let angle = angle_deg.to_radians();
            [(x + distance * angle.cos()) * mm, (y + distance * angle.sin()) * mm]
        };
        let [third, fourth, fifth] = [third, fourth, fifth].map(|value| value.unwrap_or(0.0));
        let mut places: Vec<[f64; 2]> = match pattern {
            Pattern::Row => (0..count).map(|index| place(fourth + index as f64 * fifth, third)).collect(),
            Pattern::Circle => {
                let step = if fifth == 0.0 { TAU.to_degrees() / count as f64 } else { fifth };
                (0..count).map(|index| place(third, fourth + index as f64 * step)).collect()
            }
        };
        let here = [self.state.position[first], self.state.position[second]];
        let away = |at: Option<&[f64; 2]>| at.map_or(0.0, |at| (at[0] - here[0]).hypot(at[1] - here[1]));
        if pattern == Pattern::Row && away(places.last()) < away(places.first()) {
            places.reverse(); // a row begins at its nearer end
        }
        let span = |index: usize| arguments.get(index).map_or((0, 0), |argument| argument.span);
        Ok((places, [span(0), span(1)]))
    }

    /// CYCL CALL POS: goes to a place of the plane and runs the cycle defined last there, its surface higher by the
    /// coordinate along the tool. F counts for the way there alone.
    pub(crate) fn call_at(&mut self, request: &Request, word: i32) {
        let third = self.state.modal.plane.axes().2;
        let letter = AXES[third];
        let Some((number, drill)) = self.state.defined.cycle else {
            return self.warn_opaque(word, "the moves of the cycle defined last are not in the path");
        };
        if !AXES.iter().all(|letter| request.get(*letter).is_some()) || request.reference(letter) == Some(true) {
            return self.not_followed(word, "X, Y and Z are not all given, that along the tool as a position");
        }
        let mut hole = match self.defined_hole(number, drill) {
            Ok(hole) if !hole.is_relative() => hole,
            Ok(_) => return self.not_followed(word, "the cycle defined last begins where the tool stands"),
            Err(why) => return self.not_followed(word, &why),
        };
        let (target, mut words) = self.target(request, false);
        words[third] = INHERITED;
        let value = self.program.words().get(request.word(letter) as usize);
        let span = value.map_or((0, 0), |word| (self.program.value_start(word) as u32, word.end() as u32));
        hole.raise(target[third], span);
        let kind = if self.state.modal.motion == Motion::Rapid { MoveKind::Rapid } else { MoveKind::Line };
        let before = self.state.modal.feed;
        if let Some(feed) = request.get(b'F') {
            self.state.modal.feed = self.feed_mm(request, feed);
        }
        if self.state.position[third] < hole.surface() {
            self.height(kind, self.state.position, third, hole.retract(), INHERITED);
        }
        let mut end = target;
        end[third] = self.state.position[third];
        self.emit(kind, end, words);
        self.state.modal.feed = before;
        self.drill_here(&hole);
    }
}
