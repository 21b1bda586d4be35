//! Arcs of Klartext about a pole: their centre stands in a block of its own, CC, before them.

use std::collections::HashMap;

use nc_program::dialect::G;
use nc_program::{Arc, MoveKind, Program, ToolPath, Word, WordKind};

use super::{Here, Writer, AXES, SAME_MM};
use crate::edits::{is_value, line_ending};
use crate::field::sum;
use crate::field::Vector;
use crate::part::Course;
use crate::pieces::Piece;
use crate::refusal::Refused;

/// The poles of a part: where the program sets them, and what they are in the program that is written.
pub(crate) struct Poles {
    /// Each time a pole is set: the move that comes next, and the block.
    set: Vec<(usize, usize)>,
    /// Blocks that were edited, and by how much the pole that they set is moved then, mm.
    moved: HashMap<usize, Vector>,
    /// The pole in force after the last arc, and how many were set before it.
    in_force: (usize, Vector),
}

impl Poles {
    /// Those that a traced run sets.
    pub fn new(program: &Program, path: &ToolPath) -> Self {
        let sets = |word: &&Word| matches!(program.code(word), Some(G::Pole(_)));
        let blocks: Vec<usize> = if program.dialect().about_pole {
            program.words().iter().filter(sets).map(|word| program.block_at(word.start as usize)).collect()
        } else {
            Vec::new()
        };
        let done = path.executed.iter().map(|done| (done.moves as usize, done.block as usize));
        let set = done.filter(|(_, block)| blocks.binary_search(block).is_ok()).collect();
        Self { set, moved: HashMap::new(), in_force: (0, Vector::default()) }
    }

    /// How many are set before a move, and the block of the last.
    fn before(&self, index: usize) -> (usize, Option<usize>) {
        let count = self.set.partition_point(|(next, _)| *next <= index);
        (count, count.checked_sub(1).and_then(|last| self.set.get(last)).map(|(_, block)| *block))
    }
}

impl Writer<'_> {
    /// Whether an arc goes about a pole.
    pub(super) fn is_about_pole(&self, here: &Here) -> bool {
        self.program.dialect().about_pole && !here.words.iter().any(|word| word.letter == b'R' && is_value(word))
    }

    /// Has the pole in force before an arc be the displaced one by the block that sets it. False where that does not do:
    /// another arc needs it elsewhere, or it is not said by plain positions.
    pub(super) fn set_pole(&mut self, here: &Here, arc: &Arc, wanted: Vector) -> Result<bool, Refused> {
        let (count, block) = self.poles.before(here.index);
        let block = block.ok_or_else(|| self.no_centre(here))?;
        let fresh = self.poles.in_force.0 != count;
        let moved = self.poles.moved.get(&block).map(|by| sum(&arc.centre, by));
        let known = if fresh { moved } else { Some(self.poles.in_force.1) };
        let stays = |axis: usize| (wanted[axis] - arc.centre[axis]).abs() <= SAME_MM;
        let pole = match known {
            Some(pole) if self.is_pole(here, &pole, &wanted) => pole,
            None if self.sets_plainly(here, arc, block) => self.displace_pole(here, arc, wanted, block)?,
            None if self.edits.len() == 0 && (0..3).all(stays) => arc.centre,
            _ => [f64::NAN; 3],
        };
        self.poles.in_force = (count, pole);
        Ok(pole.iter().all(|value| value.is_finite()))
    }

    /// The block of a pole to go about from here on; empty where it is in force already.
    pub(super) fn new_pole(&mut self, here: &Here, wanted: Vector) -> Vec<u8> {
        let pole = self.poles.in_force.1;
        if self.is_pole(here, &pole, &wanted) {
            return Vec::new();
        }
        let (first, second, _) = here.state.plane.axes();
        let (mut text, mut pole) = (b"CC".to_vec(), wanted);
        for axis in [first.min(second), first.max(second)] {
            let unit = here.state.axis_mm(axis);
            let steps = here.step.round(wanted[axis] / unit);
            text.extend([b' ', AXES[axis]]);
            here.step.write(&mut text, steps);
            pole[axis] = here.step.value(steps) * unit;
        }
        self.poles.in_force.1 = pole;
        text
    }

    /// Whether one pole is the other but for rounding.
    fn is_pole(&self, here: &Here, pole: &Vector, wanted: &Vector) -> bool {
        let (first, second, _) = here.state.plane.axes();
        let half = |axis| here.step.unit * here.state.axis_mm(axis) / 2.0 + SAME_MM;
        [first, second].iter().all(|axis| (pole[*axis] - wanted[*axis]).abs() <= half(*axis))
    }

    /// Whether the block of a pole says both of its coordinates as positions.
    fn sets_plainly(&self, here: &Here, arc: &Arc, block: usize) -> bool {
        let (first, second, _) = here.state.plane.axes();
        [first, second].iter().all(|axis| self.pole_word(here, arc, block, *axis).is_some())
    }

    fn pole_word(&self, here: &Here, arc: &Arc, block: usize, axis: usize) -> Option<&Word> {
        let (program, unit, old) = (self.program, here.state.axis_mm(axis), arc.centre[axis]);
        program.words_of(block).iter().rev().find(|word| {
            let value = if word.kind == WordKind::Number { word.value * unit } else { old };
            let plain = word.letter == AXES[axis] && is_value(word) && program.reference(word).is_none();
            plain && !here.state.incremental && (value - old).abs() <= SAME_MM
        })
    }

    /// Displaces the pole in its own block; gives where it then is.
    fn displace_pole(&mut self, here: &Here, arc: &Arc, wanted: Vector, block: usize) -> Result<Vector, Refused> {
        let (first, second, _) = here.state.plane.axes();
        let mut pole = arc.centre;
        for axis in [first, second] {
            let (unit, old) = (here.state.axis_mm(axis), arc.centre[axis]);
            if here.step.round((wanted[axis] - old) / unit) != 0 {
                pole[axis] = here.step.value(here.step.round(wanted[axis] / unit)) * unit;
            }
            let word = self.pole_word(here, arc, block, axis).copied().ok_or_else(|| self.no_centre(here))?;
            self.replace_value(here, &word, wanted[axis] / unit, old / unit, true)?;
        }
        self.poles.moved.insert(block, [0, 1, 2].map(|axis| pole[axis] - arc.centre[axis]));
        Ok(pole)
    }

    /// Sets a pole in a block before the arc's.
    pub(super) fn pole_before(&mut self, here: &Here, wanted: Vector) -> Result<(), Refused> {
        if self.is_pole_formula(here) {
            return Err(self.indivisible(here, "an arc about a parameter"));
        }
        let block = self.program.blocks().get(here.block).copied();
        let block = block.filter(|block| !block.optional).ok_or_else(|| self.unreachable(here))?;
        let (text, ending) = (self.new_pole(here, wanted), line_ending(self.program.source()));
        let at = block.start as usize;
        self.edits.replace(at, at, |out| out.extend(text.iter().chain(ending)));
        self.added += 1;
        Ok(())
    }

    /// Leaves a move to a radius and an angle as it is: its pole goes where the tool does. Its axis beside the plane is
    /// written.
    pub(super) fn about_moved_pole(&mut self, here: &Here, pieces: &[Piece], course: &Course) -> Result<(), Refused> {
        let (first, second, third) = here.state.plane.axes();
        let [piece] = pieces else { return Err(self.turned_about_pole(here)) };
        let end = self.path.end[here.index];
        let by = [0, 1, 2].map(|axis| piece.end[axis] - end[axis]);
        let written = self.move_pole(here, by)?;
        let relative = here.axes[first].incremental || !self.says_both(here);
        for axis in [first, second] {
            let off = (written[axis] - by[axis]).abs().max(if relative {
                (self.carried[axis] - by[axis]).abs()
            } else {
                0.0
            });
            if course.arrives() && relative || here.tells(&here.axes[axis], off) {
                return Err(self.turned_about_pole(here));
            }
        }
        let (from, before) = (self.edits.len(), sum(&self.path.start[here.index], &self.carried));
        let live = self.live(here, before, pieces, &course.standing)?;
        self.carried = [0, 1, 2].map(|axis| if axis == third { self.carried[axis] } else { written[axis] });
        if live[third] {
            let there = self.coordinate(here, &here.axes[third], before, piece.end[third], true)?;
            self.carried[third] = there - end[third];
        }
        if self.edits.close(here.block, from) {
            Ok(())
        } else {
            Err(self.twice(here.block))
        }
    }

    /// Whether a polar block has both the radius and the angle: its end is independent of its start.
    fn says_both(&self, here: &Here) -> bool {
        b"pq".iter().all(|letter| here.words.iter().any(|word| word.letter == *letter && is_value(word)))
    }

    /// Moves the pole in force by the positions in its block: a coordinate that it has as an increment, or not at all, is
    /// counted from where the tool stands there. Gives by how much it is moved then.
    fn move_pole(&mut self, here: &Here, by: Vector) -> Result<Vector, Refused> {
        let block = self.poles.before(here.index).1.ok_or_else(|| self.no_centre(here))?;
        if let Some(moved) = self.poles.moved.get(&block) {
            return Ok(*moved);
        }
        let (mut moved, (first, second, _)) = (by, here.state.plane.axes());
        for axis in [first, second] {
            let (unit, program) = (here.state.axis_mm(axis), self.program);
            let is_position =
                |word: &&Word| word.letter == AXES[axis] && is_value(word) && program.reference(word) != Some(true);
            let Some(word) = program.words_of(block).iter().find(is_position) else { continue };
            let old = if word.kind == WordKind::Number { word.value } else { 0.0 };
            let to = here.step.value(here.step.round(old + by[axis] / unit));
            moved[axis] = if here.step.round(by[axis] / unit) == 0 { 0.0 } else { (to - old) * unit };
            self.replace_value(here, word, old + by[axis] / unit, old, true)?;
        }
        self.poles.moved.insert(block, moved);
        Ok(moved)
    }

    /// Whether an arc goes about a pole that is set by a parameter.
    pub(super) fn is_pole_formula(&self, here: &Here) -> bool {
        if self.path.kind[here.index] != MoveKind::Arc || !self.is_about_pole(here) {
            return false;
        }
        let set = self.poles.before(here.index).1.map_or(&[][..], |block| self.program.words_of(block));
        set.iter().any(|word| word.kind == WordKind::Expression)
    }
}
