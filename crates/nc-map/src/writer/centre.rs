//! The words of centres and radii.

use std::f64::consts::{PI, TAU};

use super::{separate, Here, Writer};
use crate::edits::is_value;
use crate::field::Vector;
use crate::refusal::Refused;
use crate::text::Step;
use crate::value::Value;
use nc_program::{Arc, Dialect, Word};

const CENTRES: [u8; 3] = *b"IJK";
/// An arc that turns by less is a full turn, of LinuxCNC at least.
const FULL_TURN_RAD: f64 = 1e-6;

impl Writer<'_> {
    /// I, J, K or R of the block's own arc.
    pub(super) fn centre(
        &mut self,
        here: &Here,
        arc: &Arc,
        before: Vector,
        actual: Vector,
        wanted: Vector,
        whole: bool,
    ) -> Result<(), Refused> {
        let (first, second, _) = here.state.plane.axes();
        let centre = equidistant(wanted, before, actual, first, second);
        let mm = here.state.mm();
        let number = |letter: u8| here.words.iter().rev().find(|word| word.letter == letter && is_value(word));
        if let Some(word) = number(self.program.dialect().rules.radius_letter) {
            let sign = |wide: bool| if wide { -1.0 } else { 1.0 };
            let wide = arc.sweep.abs() > std::f64::consts::PI;
            let (old, sign) = (sign(wide) * arc.radius / mm, sign(wide && whole));
            let radius = sign * (before[first] - centre[first]).hypot(before[second] - centre[second]) / mm;
            return self.replace_value(here, word, radius, old, whole);
        }
        if number(CENTRES[first]).or(number(CENTRES[second])).is_none() {
            return Err(self.no_centre(here));
        }
        for axis in [first, second] {
            let said = number(CENTRES[axis]).and_then(|word| self.program.reference(word)); // I=AC(), I=IC()
            let absolute = said.map_or(here.state.centre_absolute, |increment| !increment);
            // I=AC() is a diameter where X is.
            let unit = if said == Some(false) { here.state.axis_mm(axis) } else { mm };
            let origin = |start: &Vector| if absolute { 0.0 } else { start[axis] };
            let value = (centre[axis] - origin(&before)) / unit;
            let old = (arc.centre[axis] - origin(&self.path.start[here.index])) / unit;
            match number(CENTRES[axis]) {
                Some(word) => self.replace_value(here, word, value, old, whole)?,
                None if here.step.round(value) != 0 => {
                    let (steps, step) = (here.step.round(value), here.step);
                    self.edits.insert(self.program, here.block, CENTRES[axis], |text| step.write(text, steps));
                }
                None => {}
            }
        }
        Ok(())
    }

    /// Rounding may lay the ends of a short arc on each other, or one behind the other: the control would make a full turn
    /// of it, or nothing of one that ends near its start. `sweep` is what it has to turn, positive clockwise.
    pub(super) fn require_turn(
        &self,
        here: &Here,
        sweep: f64,
        [from, to]: [&Vector; 2],
        centre: &Vector,
    ) -> Result<(), Refused> {
        let (first, second, _) = here.state.plane.axes();
        let centre = equidistant(*centre, *from, *to, first, second);
        let arm = |at: &Vector| [at[first] - centre[first], at[second] - centre[second]];
        let (from, to) = (arm(from), arm(to));
        let left = (from[0] * to[1] - from[1] * to[0]).atan2(from[0] * to[0] + from[1] * to[1]);
        let full = |turned: f64| if turned < FULL_TURN_RAD { TAU } else { turned };
        let turned = full((-left * sweep.signum()).rem_euclid(TAU));
        let wanted = sweep.abs() - TAU * ((sweep.abs() - FULL_TURN_RAD) / TAU).floor().max(0.0);
        if (turned - wanted).abs() > PI {
            return Err(self.other_turn(here, (to[0] - from[0]).hypot(to[1] - from[1]), turned));
        }
        Ok(())
    }

    pub(super) fn replace_value(
        &mut self,
        here: &Here,
        word: &Word,
        value: f64,
        old: f64,
        whole: bool,
    ) -> Result<(), Refused> {
        let (step, program) = (here.step, self.program);
        let change = step.round(value - old);
        if change == 0 {
            return Ok(());
        }
        let place = Value::of(program, word)?;
        if !place.is_number && !whole {
            self.edits.replace(place.start, place.end, |out| step.write(out, step.round(value)));
            return Ok(());
        }
        let to = step.round(value);
        self.edits.replace(place.start, place.end, |out| place.change(program, word, step, (to, change), out))?;
        Ok(())
    }

    pub(super) fn new_centre(&self, here: &Here, wanted: Vector, before: Vector, actual: Vector, text: &mut Vec<u8>) {
        let (first, second, _) = here.state.plane.axes();
        let dialect = self.program.dialect();
        let by_radius = here.words.iter().any(|word| word.letter == dialect.rules.radius_letter && is_value(word));
        if !by_radius && dialect.about_pole {
            return;
        }
        let centre = equidistant(wanted, before, actual, first, second);
        let origin = if here.state.centre_absolute { Vector::default() } else { before };
        let of = Circle { axes: [first, second], centre, start: before, origin, by_radius };
        separate(text);
        circle(dialect, here.step, here.state.mm(), &of, text);
    }
}

/// The circle of an arc as its words give it.
pub struct Circle {
    /// The axes of its plane.
    pub axes: [usize; 2],
    /// mm.
    pub centre: Vector,
    /// Where the arc starts, mm.
    pub start: Vector,
    /// From where the centre counts, mm.
    pub origin: Vector,
    /// Its word is the radius, else the centre.
    pub by_radius: bool,
}

/// Writes the words of a circle, whose program unit is so many mm: `R5.`, `I1. K-2.` in the order of the axes.
pub fn circle(dialect: &Dialect, step: Step, mm: f64, circle: &Circle, text: &mut Vec<u8>) {
    let [first, second] = circle.axes;
    let arm = |from: &Vector, axis: usize| circle.centre[axis] - from[axis];
    if circle.by_radius {
        text.extend(dialect.radius_address().bytes());
        let radius = arm(&circle.start, first).hypot(arm(&circle.start, second));
        return step.write(text, step.round(radius / mm));
    }
    for (place, axis) in [first.min(second), first.max(second)].into_iter().enumerate() {
        text.extend(if place == 0 { &b""[..] } else { b" " });
        text.push(CENTRES[axis]);
        step.write(text, step.round(arm(&circle.origin, axis) / mm));
    }
}

/// The point nearest to a centre that is equally far from both ends, which were rounded after it was found.
pub fn equidistant(centre: Vector, start: Vector, end: Vector, first: usize, second: usize) -> Vector {
    let (chord_u, chord_v) = (end[first] - start[first], end[second] - start[second]);
    let square = chord_u * chord_u + chord_v * chord_v;
    if square == 0.0 {
        return centre;
    }
    let (u, v) = ((start[first] + end[first]) / 2.0, (start[second] + end[second]) / 2.0);
    let along = ((centre[first] - u) * chord_u + (centre[second] - v) * chord_v) / square;
    let mut moved = centre;
    moved[first] -= along * chord_u;
    moved[second] -= along * chord_v;
    moved
}
