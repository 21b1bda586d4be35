//! The words of axes.

use super::{Axis, Here, Writer, SAME_MM};
use crate::edits::is_value;
use crate::field::Vector;
use crate::refusal::Refused;
use nc_program::WordKind;

impl Writer<'_> {
    /// What the word of an axis says in program units.
    pub(super) fn said(&self, here: &Here, axis: &Axis) -> f64 {
        let origin = if axis.incremental { self.path.start[here.index][axis.index] } else { 0.0 };
        (self.path.end[here.index][axis.index] - origin) / axis.unit
    }

    /// An axis that moves is named by a word whose value is where it goes.
    pub(super) fn require_said(&self, here: &Here, axis: &Axis) -> Result<(), Refused> {
        let (start, end) = (self.path.start[here.index][axis.index], self.path.end[here.index][axis.index]);
        let hint = "write the cycle, corner or call out as moves";
        let Some(word) = axis.word else {
            if (end - start).abs() <= SAME_MM {
                return Ok(());
            }
            let letter = char::from(axis.letter);
            let message = format!("{letter} goes from {start:.5} to {end:.5} mm by no word of this block");
            return Err(Refused::block(self.block_start(here.block), message, hint));
        };
        let says = word.kind != WordKind::Number || (word.value - self.said(here, axis)).abs() * axis.unit <= SAME_MM;
        if says && is_value(word) {
            return Ok(());
        }
        let text = String::from_utf8_lossy(self.program.text(word));
        let message = format!("{text} does not say that the move ends at {end:.5} mm");
        Err(Refused::block(word.start as usize, message, hint))
    }

    /// Writes one coordinate; gives where it then is.
    pub(super) fn coordinate(&mut self, here: &Here, axis: &Axis, before: Vector, target: f64, whole: bool) -> f64 {
        let origin = if axis.incremental { before[axis.index] } else { 0.0 };
        let wanted = (target - origin) / axis.unit;
        let steps = here.step.round(wanted);
        let (step, program) = (here.step, self.program);
        let Some(word) = axis.word else {
            self.edits.insert(program, here.block, axis.letter, |text| step.write(text, steps, 0, 1));
            return origin + step.value(steps) * axis.unit;
        };
        let said = if word.kind == WordKind::Number { word.value } else { self.said(here, axis) };
        let change = step.round(wanted - said);
        if change == 0 {
            return origin + said * axis.unit;
        }
        let (start, end) = (program.value_start(word), word.end());
        let old = program.source().get(start..end).unwrap_or(&[]);
        if word.kind == WordKind::Expression && whole {
            self.edits.replace(start, end, |text| step.with_term(text, old, change, program.dialect()));
            return origin + (said + step.value(change)) * axis.unit;
        }
        if word.kind == WordKind::Expression {
            self.edits.replace(start, end, |text| step.write(text, steps, 0, 1));
        } else {
            self.edits.replace(start, end, |text| step.restyle(text, old, steps));
        }
        origin + step.value(steps) * axis.unit
    }

    pub(super) fn new_coordinate(
        &self,
        here: &Here,
        axis: &Axis,
        before: Vector,
        target: f64,
        last: bool,
        text: &mut Vec<u8>,
    ) -> f64 {
        let origin = if axis.incremental { before[axis.index] } else { 0.0 };
        let steps = here.step.round((target - origin) / axis.unit);
        text.push(axis.letter);
        let expression = axis.word.filter(|word| last && !axis.incremental && word.kind == WordKind::Expression);
        let Some(word) = expression else {
            here.step.write(text, steps, 0, 1);
            return origin + here.step.value(steps) * axis.unit;
        };
        let said = self.said(here, axis);
        let change = here.step.round(target / axis.unit - said);
        let old = self.program.source().get(self.program.value_start(word)..word.end()).unwrap_or(&[]);
        if change == 0 {
            text.extend(old);
        } else {
            here.step.with_term(text, old, change, self.program.dialect());
        }
        (said + here.step.value(change)) * axis.unit
    }
}
