//! The words of axes.

use super::{Axis, Here, Writer, SAME_MM};
use crate::edits::is_value;
use crate::field::Vector;
use crate::refusal::Refused;
use crate::value::Value;
use nc_program::{Word, WordKind};

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
        let (first, second, _) = here.state.plane.axes();
        if [first, second].contains(&axis.index) && self.geometry.is_polar(here.index) {
            return Ok(());
        }
        let Some(word) = axis.word else {
            if (end - start).abs() <= SAME_MM {
                return Ok(());
            }
            let letter = char::from(axis.letter);
            let message = format!("{letter} goes from {start:.5} to {end:.5} mm by no word of this block");
            return Err(Refused::block(self.block_start(here.block), message, hint));
        };
        if says(word, self.said(here, axis), axis.unit) {
            return Ok(());
        }
        let text = String::from_utf8_lossy(self.program.text(word));
        let message = format!("{text} does not say that the move ends at {end:.5} mm");
        Err(Refused::block(word.start as usize, message, hint))
    }

    /// Writes one coordinate; gives where it then is.
    pub(super) fn coordinate(
        &mut self,
        here: &Here,
        axis: &Axis,
        before: Vector,
        target: f64,
        whole: bool,
    ) -> Result<f64, Refused> {
        let origin = if axis.incremental { before[axis.index] } else { 0.0 };
        let wanted = (target - origin) / axis.unit;
        Ok(origin + self.value(here, axis, wanted, whole, None)? * axis.unit)
    }

    /// Writes the value of a word, in program units, or the word; gives the value that it then has. `said` is what a
    /// formula gives, where that is not the move's coordinate.
    pub(super) fn value(
        &mut self,
        here: &Here,
        axis: &Axis,
        wanted: f64,
        whole: bool,
        said: Option<f64>,
    ) -> Result<f64, Refused> {
        let (step, program) = (here.step, self.program);
        let steps = step.round(wanted);
        let Some(word) = axis.word else {
            self.edits.insert(program, here.block, axis.letter, |text| step.write(text, steps));
            return Ok(step.value(steps));
        };
        let of_formula = || said.unwrap_or_else(|| self.said(here, axis));
        let said = if word.kind == WordKind::Number { word.value } else { of_formula() };
        let change = step.round(wanted - said);
        if change == 0 {
            return Ok(said);
        }
        let value = Value::of(program, word)?;
        if !value.is_number && !whole {
            self.edits.replace(value.start, value.end, |text| step.write(text, steps));
            return Ok(step.value(steps));
        }
        if value.is_number || !self.add_to_parameter(word, axis.index, step, change)? {
            self.edits
                .replace(value.start, value.end, |out| value.change(program, word, step, (steps, change), out))?;
        }
        Ok(if value.is_number { step.value(steps) } else { said + step.value(change) })
    }

    /// The word of an axis in a new block: as the mode in force has it, whatever the old word said of itself. The last
    /// piece keeps the programmer's formula.
    pub(super) fn new_coordinate(
        &self,
        here: &Here,
        axis: &Axis,
        before: Vector,
        target: f64,
        last: bool,
        text: &mut Vec<u8>,
    ) -> Result<f64, Refused> {
        let formula = axis.word.filter(|word| last && !axis.incremental && word.kind == WordKind::Expression);
        let Some(word) = formula else {
            let increments = self.program.dialect().increments.is_some_and(|letters| letters.contains(&axis.letter));
            let incremental = increments || here.state.incremental;
            let unit = if incremental { here.state.increment_mm(axis.index) } else { here.state.axis_mm(axis.index) };
            let origin = if incremental { before[axis.index] } else { 0.0 };
            let steps = here.step.round((target - origin) / unit);
            text.push(axis.letter);
            here.step.write(text, steps);
            return Ok(origin + here.step.value(steps) * unit);
        };
        let (said, steps) = (self.said(here, axis), here.step.round(target / axis.unit));
        let change = here.step.round(target / axis.unit - said);
        let value = Value::of(self.program, word)?;
        let source = self.program.source();
        text.extend(source.get(word.start as usize..value.start).unwrap_or(&[]));
        if change == 0 {
            text.extend(value.text(self.program));
        } else {
            value.change(self.program, word, here.step, (steps, change), text)?;
        }
        text.extend(source.get(value.end..word.end()).unwrap_or(&[]));
        Ok((said + here.step.value(change)) * axis.unit)
    }
}

/// Whether a word may be edited and, where it is a number, has that value.
pub(super) fn says(word: &Word, value: f64, unit_mm: f64) -> bool {
    is_value(word) && (word.kind != WordKind::Number || (word.value - value).abs() * unit_mm <= SAME_MM)
}
