//! The holes of cycles that are called: they are drilled where the tool stands, displaced already, and their heights are
//! stated where the cycle is defined, for all holes at once.

use super::{Here, Writer};
use crate::field::Vector;
use crate::milled::Shared;
use crate::part::{require_said, Course};
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::standing::Standing;
use crate::value::takes_terms;
use nc_program::{number, Drilled, Placed, Said};

impl Writer<'_> {
    /// Writes the heights of a hole into the cycle that drills it; those of a later hole have to come out the same.
    pub fn drill_called(
        &mut self,
        hole: &Drilled,
        said: &Said,
        pieces: &[Piece],
        courses: &[Course],
    ) -> Result<(), Refused> {
        let here = self.place(hole.place);
        self.require_known(hole, courses)?;
        let (wanted, third) = (self.wanted(&here, hole, pieces)?, hole.third);
        for axis in here.axes.iter().filter(|axis| axis.index != third) {
            let k = axis.index;
            let off = (self.path.start[hole.place][k] + self.carried[k] - wanted.bottom[k]).abs();
            if off > self.tolerance_mm + here.step.unit * axis.unit {
                return Err(self.leaning(&here, k, off));
            }
        }
        let depth = wanted.bottom[third] - self.path.end[hole.bottom][third];
        let plane = wanted.plane - hole.plane;
        if said.is_relative() {
            let off = (depth - self.carried[third]).abs().max((plane - self.carried[third]).abs());
            return if off > self.tolerance_mm + here.step.unit * here.state.mm() {
                Err(self.leaning(&here, third, off))
            } else {
                Ok(())
            };
        }
        if said.spans().next().is_none() && plane.abs().max(depth.abs()) > self.tolerance_mm {
            return Err(self.unwritten(&here));
        }
        let mut by = None;
        for (spans, wanted) in [(said.plane, plane), (said.depth, depth)] {
            for span in spans.into_iter().filter(|(start, end)| end > start) {
                let done = self.value_of_cycle(&here, span, wanted)?;
                by = by.or(Some(done));
            }
        }
        self.carried[third] = by.unwrap_or(0.0);
        Ok(())
    }

    /// Writes the heights of a cycle whose passes are the control's: it is displaced as a whole, where the field
    /// displaces the space that it mills alike, and by as much as the tool was on its way there.
    pub fn mill_called(&mut self, hole: &Drilled, said: &Said, courses: &[Course]) -> Result<(), Refused> {
        let here = self.place(hole.place);
        let mut standing = courses[hole.first].standing;
        if !said.is_relative() {
            standing[hole.third] = Standing::Said; // by the cycle
        }
        require_said(self.program, self.path, hole.first, standing, standing)?;
        let follows = [0, 1, 2].map(|axis| axis != hole.third || said.is_relative());
        let middle = self.displaced_whole(&here, hole.first, follows)?;
        if said.is_relative() {
            return Ok(());
        }
        if said.spans().next().is_none() && middle[hole.third].abs() > self.tolerance_mm {
            return Err(self.unwritten(&here));
        }
        for span in said.spans() {
            self.carried[hole.third] = self.value_of_cycle(&here, span, middle[hole.third])?;
        }
        Ok(())
    }

    /// How far a cycle whose passes are the control's is displaced as a whole; along the axes that follow the tool by as
    /// much as that is.
    pub(super) fn displaced_whole(&self, here: &Here, first: usize, follows: [bool; 3]) -> Result<Vector, Refused> {
        let Some(Shared { middle, off }) = self.milled.get(&first).copied().filter(|_| !self.knows_travel) else {
            return Err(self.uneven(here, None));
        };
        let least = here.step.unit * here.state.mm();
        for axis in 0..3 {
            let beside = if follows[axis] { (self.carried[axis] - middle[axis]).abs() } else { 0.0 };
            let off = off[axis] + (beside - least).max(0.0);
            if off > self.tolerance_mm {
                return Err(self.uneven(here, Some((axis, off))));
            }
        }
        Ok(middle)
    }

    /// Writes the reference point of a hole pattern; every place of it has to come out the same.
    pub fn place_of_pattern(&mut self, placed: &Placed, pieces: &[Piece]) -> Result<(), Refused> {
        let here = self.place(placed.of_move);
        let end = self.path.end[placed.of_move];
        let wanted = pieces.last().map_or(end, |piece| piece.end);
        for (axis, span) in placed.axes.into_iter().zip(placed.said) {
            self.carried[axis] = self.value_of_cycle(&here, span, wanted[axis] - end[axis])?;
        }
        Ok(())
    }

    /// Moves a value of a cycle's definition by so many mm; returns by how much it was moved.
    pub(super) fn value_of_cycle(&mut self, here: &Here, (start, end): (u32, u32), by_mm: f64) -> Result<f64, Refused> {
        let (program, step, unit) = (self.program, here.step, here.state.mm());
        let (start, end) = (start as usize, end as usize);
        if let Some(known) = self.heights.get(&start).copied() {
            return if (known - by_mm).abs() <= self.tolerance_mm + step.unit * unit {
                Ok(known)
            } else {
                Err(self.other_hole(here, by_mm, known))
            };
        }
        let old = program.source().get(start..end).unwrap_or(&[]).trim_ascii();
        let number = number::read(old, 0).filter(|(_, after)| *after == old.len()).map(|(value, _)| value);
        let change = step.round(by_mm / unit);
        let done = match number {
            _ if change == 0 => 0.0,
            Some(value) => {
                let steps = step.round(value + by_mm / unit);
                self.edits.replace(start, start + old.len(), |out| step.restyle(out, old, steps));
                (step.value(steps) - value) * unit
            }
            None if takes_terms(program) => {
                self.edits.replace(start, start + old.len(), |out| step.with_term(out, old, change, program.dialect()));
                step.value(change) * unit
            }
            None => {
                let message = format!("{} would have to be displaced, but takes no sum", String::from_utf8_lossy(old));
                return Err(Refused::block(start, message, "write the height as a number"));
            }
        };
        self.heights.insert(start, done);
        Ok(done)
    }
}
