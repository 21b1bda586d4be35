//! Writes displaced moves into their blocks, and keeps account of where the control then really is.
//!
//! `carried` is how far the tool stands off its programmed position, on the control: displacement and rounding. It does
//! not change when positions get other names. An increment is written from where the tool really is, so that rounding
//! never adds up; a position is rounded by itself.

mod called;
pub(crate) mod centre;
pub(crate) mod contour;
mod coordinate;
pub(crate) mod hole;
mod parameter;
pub(crate) mod pole;
mod refusals;
mod turned;
mod turning_cycle;

use std::cell::OnceCell;
use std::collections::HashMap;

use nc_program::dialect::Letters;
use nc_program::{Linear, Modal, MoveKind, Program, ToolPath, Word};

use crate::edits::Edits;
use crate::edits::{new_lines, BlockNumbers};
use crate::field::{sum, Vector};
use crate::geometry::Geometry;
use crate::milled::Shared;
use crate::part::Course;
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::standing::{is_increment, Standing};
use crate::text::Step;
use contour::Ended;
use hole::Drilling;
use pole::Poles;

const AXES: [u8; 3] = *b"XYZ";
/// Programs and runner may differ by this about what a word says, mm.
const SAME_MM: f64 = 1e-6;

/// A part, its path, and the edits made.
pub(crate) struct Writer<'a> {
    pub program: &'a Program,
    pub path: &'a ToolPath,
    pub geometry: &'a Geometry<'a>,
    pub edits: Edits,
    /// The poles of arcs.
    pub poles: Poles,
    /// In millimetres and in inches.
    pub steps: [Step; 2],
    /// Actual less programmed position in the program's coordinates, mm.
    pub carried: Vector,
    /// How those are turned, mirrored and scaled.
    pub linear: Option<Linear>,
    /// The drilling cycle in force.
    pub drilling: Drilling,
    /// By how much the end of the turning cycle in force is displaced, mm.
    pub turning: Vector,
    /// Those of its blocks.
    pub numbers: BlockNumbers,
    /// By how much the height values of called cycles were moved, by their first byte, mm.
    pub heights: HashMap<usize, f64>,
    /// Where the pieces of shared contours end.
    pub shared: Vec<Ended>,
    /// How cycles are displaced whose passes are the control's, by their first move.
    pub milled: HashMap<usize, Shared>,
    /// Blocks written in addition.
    pub added: usize,
    /// A start further off than this is gone to first, where the field differs by the way of travel, mm.
    pub tolerance_mm: f64,
    /// The field differs by the way of travel.
    pub knows_travel: bool,
    /// Rotary axes with whose places the field differs.
    pub follows: Letters,
    /// The blocks may run in any order.
    pub whole: bool,
    /// The part is the whole program.
    pub single: bool,
    /// Parameters of Klartext that it does not use, one for each axis.
    pub free: OnceCell<Vec<usize>>,
}

/// How an axis is written in a block.
#[derive(Clone, Copy)]
struct Axis<'a> {
    index: usize,
    letter: u8,
    /// The word that names it, if the block has one.
    word: Option<&'a Word>,
    incremental: bool,
    /// Millimetres in a unit.
    unit: f64,
}

/// A move in its block.
struct Here<'a> {
    index: usize,
    block: usize,
    state: &'a Modal,
    step: Step,
    axes: [Axis<'a>; 3],
    words: &'a [Word],
}

impl Here<'_> {
    /// Whether the axis' digits tell where it stands from a place so far off, mm; at half a step they do not.
    fn tells(&self, axis: &Axis, off_mm: f64) -> bool {
        off_mm > self.step.unit / 2.0 * axis.unit + SAME_MM
    }
}

impl<'a> Writer<'a> {
    /// How far the tool is off its programmed position, in the work frame, mm.
    pub fn off_in_work(&self) -> Vector {
        self.linear.map_or(self.carried, |linear| linear.vector(self.carried))
    }

    /// Where the tool is after a move, as the written program calls it, mm.
    pub fn actual(&self, index: usize) -> Vector {
        sum(&self.path.end[index], &self.carried)
    }

    /// Goes over to the coordinates in which a move is programmed: the tool stands as far off as before.
    pub fn turn_with(&mut self, index: usize) {
        let linear = self.path.origins[self.path.state[index] as usize].linear;
        if linear != self.linear {
            let carried = self.off_in_work();
            self.carried = linear.map_or(carried, |after| after.inverse().vector(carried));
            let stretch = |linear: &Option<Linear>| linear.map_or(1.0, |linear| linear.stretch());
            self.tolerance_mm *= stretch(&self.linear) / stretch(&linear);
            self.linear = linear;
        }
    }

    /// Writes a move as its pieces.
    pub fn write(&mut self, index: usize, pieces: &[Piece], course: &Course) -> Result<(), Refused> {
        let here = self.here(index)?;
        if self.path.pockets.iter().any(|(of_move, _)| *of_move == index) {
            self.displaced_whole(&here, index, [false; 3])?;
        }
        if self.geometry.is_polar(index) {
            return self.about_moved_pole(&here, pieces, course);
        }
        let pole = self.geometry.arc(index).zip(pieces.first().and_then(|first| first.centre));
        let pole = pole.filter(|_| self.is_about_pole(&here));
        let is_set = pole.map_or(Ok(true), |(arc, centre)| self.set_pole(&here, arc, centre))?;
        let from = self.edits.len();
        let mut before = sum(&self.path.start[index], &self.carried);
        self.require_straight_tap(&here, &before, pieces)?;
        let live = self.live(&here, before, pieces, &course.standing)?;
        let first = pieces.first().filter(|_| !course.arrives());
        first.map_or(Ok(()), |first| self.require_begun(&here, &before, first))?;
        let mut with_start = Vec::new();
        match first.and_then(|first| Some((first, self.start(&here, &before, first)?))) {
            Some((_, start)) if self.path.kind[index] == MoveKind::Arc => {
                before = self.go_before(&here, before, start, live)?
            }
            Some((first, end)) => {
                with_start.push(Piece { end, ..*first });
                with_start.extend_from_slice(pieces);
            }
            None => {}
        }
        if let Some((_, centre)) = pole.filter(|_| !is_set) {
            self.pole_before(&here, centre)?;
        }
        let pieces = if with_start.is_empty() { pieces } else { &with_start };
        if pieces.len() > 1 {
            self.require_divisible(&here)?;
        }
        let actual = self.first(&here, before, live, pieces)?;
        let texts = self.following(&here, actual, live, pieces)?;
        if !texts.is_empty() {
            let end = self.program.blocks().get(here.block).map_or(0, |block| block.end as usize);
            let program = self.program;
            let number = self.last_number(&here).copied();
            if let Some(number) = number {
                self.edits.replace(number.start as usize, number.end(), |_| ());
            }
            self.edits
                .replace(end, end, |text| new_lines(program, here.block, &texts, number.as_ref(), &self.numbers, text));
        }
        if !self.edits.close(here.block, from) {
            return Err(self.twice(here.block));
        }
        self.added += texts.len();
        Ok(())
    }

    fn here(&self, index: usize) -> Result<Here<'a>, Refused> {
        let here = self.place(index);
        for axis in &here.axes {
            self.require_said(&here, axis)?;
        }
        Ok(here)
    }

    /// A move in its block, whatever its words say.
    fn place(&self, index: usize) -> Here<'a> {
        let (program, path) = (self.program, self.path);
        let block = path.block[index] as usize;
        let state = &path.states[path.state[index] as usize];
        let step = self.steps[usize::from(state.inch)];
        let axis = |axis: usize| {
            let word = program.word(path.words[index][axis]);
            let letter = word.map_or(AXES[axis], |word| word.letter);
            let incremental = is_increment(program, word, state.incremental);
            let unit = if incremental { state.increment_mm(axis) } else { state.axis_mm(axis) };
            Axis { index: axis, letter, word, incremental, unit }
        };
        let axes = [axis(0), axis(1), axis(2)];
        Here { index, block, state, step, axes, words: program.words_of(block) }
    }

    /// The axes to be written: those named, and those whose displacement changes by more than half a step. One that
    /// stands where the program has not said is never written: its displacement waits for its own next word.
    fn live(
        &self,
        here: &Here,
        before: Vector,
        pieces: &[Piece],
        standing: &[Standing; 3],
    ) -> Result<[bool; 3], Refused> {
        let mut live = [false; 3];
        for axis in &here.axes {
            let k = axis.index;
            if axis.word.is_some() {
                live[k] = true;
                continue;
            }
            // Displaced by nothing but the rounding that it carries already it stays.
            let off = pieces.iter().map(|piece| self.off(piece, k, before[k])).fold(0.0, f64::max);
            let moves = here.tells(axis, off) && self.path.start[here.index][k].is_finite();
            if moves && standing[k] == Standing::Never && self.path.kind[here.index] != MoveKind::Rapid {
                return Err(self.nowhere(here, axis, off));
            }
            live[k] = moves && standing[k] == Standing::Said;
            live[k] &= !(live[k] && self.is_left(here, k, off)?);
        }
        Ok(live)
    }

    /// How far a piece takes an axis from where it was; its start counts where it is gone to.
    fn off(&self, piece: &Piece, axis: usize, before: f64) -> f64 {
        let start = if self.knows_travel { piece.start[axis] } else { before };
        (piece.end[axis] - before).abs().max((start - before).abs())
    }

    /// The block itself: the first piece. Gives where the tool then is.
    fn first(&mut self, here: &Here, before: Vector, live: [bool; 3], pieces: &[Piece]) -> Result<Vector, Refused> {
        let (Some(first), whole) = (pieces.first(), pieces.len() == 1) else {
            return Ok(before);
        };
        let mut actual = before;
        if self.is_straightened(here, first) {
            self.straighten(here);
        }
        let live = self.in_plane(here, live, first);
        for axis in here.axes.iter().filter(|axis| live[axis.index]) {
            actual[axis.index] = self.coordinate(here, axis, before, first.end[axis.index], whole)?;
        }
        if let (Some(arc), Some(centre)) = (self.geometry.arc(here.index), first.centre) {
            let closed = whole && self.path.start[here.index] == self.path.end[here.index];
            if closed && here.axes.iter().any(|axis| (actual[axis.index] - before[axis.index]).abs() > SAME_MM) {
                return Err(self.open_circle(here));
            }
            if !self.is_about_pole(here) {
                self.centre(here, arc, before, actual, centre, whole)?;
            }
            self.require_turn(here, arc.sweep * first.share, [&before, &actual], &centre)?;
        }
        self.note_end(here, first, actual);
        let end = self.path.end[here.index];
        if whole {
            self.carried = [0, 1, 2].map(|axis| actual[axis] - end[axis]);
        }
        Ok(actual)
    }

    /// The blocks of the pieces after the first; the last keeps the programmer's expressions.
    fn following(
        &mut self,
        here: &Here,
        mut actual: Vector,
        live: [bool; 3],
        pieces: &[Piece],
    ) -> Result<Vec<Vec<u8>>, Refused> {
        let mut texts = Vec::new();
        for (number, piece) in pieces.iter().enumerate().skip(1) {
            let arc = self.path.kind[here.index] == MoveKind::Arc;
            let turned = Some(piece).filter(|_| arc).and_then(|piece| self.start(here, &actual, piece));
            if let Some(start) = turned {
                texts.push(self.straight(here, start, live, &mut actual)?);
            }
            if let Some(centre) = piece.centre.filter(|_| self.is_about_pole(here)) {
                texts.extend(Some(self.new_pole(here, centre)).filter(|text| !text.is_empty()));
            }
            let (before, mut text) = (actual, self.motion_words(here));
            if self.is_straightened(here, piece) {
                text = self.line_code().to_vec();
            } else if turned.is_some() && text.is_empty() {
                text.extend(self.arc_code(here));
            }
            let live = self.in_plane(here, live, piece);
            for axis in here.axes.iter().filter(|axis| live[axis.index]) {
                let last = number + 1 == pieces.len();
                separate(&mut text);
                actual[axis.index] = self.new_coordinate(here, axis, before, piece.end[axis.index], last, &mut text)?;
            }
            if let Some(centre) = piece.centre {
                self.new_centre(here, centre, before, actual, &mut text);
                text.extend(self.turn(here));
                let share = pieces.get(number - 1).map_or(0.0, |before| before.share);
                let sweep = self.geometry.arc(here.index).map_or(0.0, |arc| arc.sweep * (piece.share - share));
                self.require_turn(here, sweep, [&before, &actual], &centre)?;
            }
            self.note_end(here, piece, actual);
            texts.push(text);
        }
        if !texts.is_empty() {
            self.carried = [0, 1, 2].map(|axis| actual[axis] - self.path.end[here.index][axis]);
        }
        Ok(texts)
    }
}

/// A space between words.
fn separate(text: &mut Vec<u8>) {
    if !text.is_empty() {
        text.push(b' ');
    }
}
