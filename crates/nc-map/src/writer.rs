//! Writes displaced moves into their blocks, and keeps account of where the control then really is.
//!
//! `carried` is how far the tool stands off its programmed position, on the control: displacement and rounding. It does
//! not change when positions get other names. An increment is written from where the tool really is, so that rounding
//! never adds up; a position is rounded by itself.

use nc_program::dialect::G;
use nc_program::{Arc, FeedMode, Modal, MoveKind, Program, ToolPath, Word, WordKind};

use crate::edits::{is_value, Edits};
use crate::field::{sum, Vector};
use crate::lines::{line_ending, new_lines};
use crate::part::Course;
use crate::pieces::{Geometry, Piece};
use crate::refusal::Refused;
use crate::standing::Standing;
use crate::text::Step;

const AXES: [u8; 3] = *b"XYZ";
const CENTRES: [u8; 3] = *b"IJK";
/// Programs and runner may differ by this about what a word says, mm.
const SAME_MM: f64 = 1e-6;
/// M codes that may come before a move that was one: spindle, tool, coolant. The others are done after a block's move.
const BEFORE_MOVE: [u16; 5] = [3, 4, 6, 7, 8];

/// A part, its path, and the edits made.
pub(crate) struct Writer<'a> {
    pub program: &'a Program,
    pub path: &'a ToolPath,
    pub geometry: &'a Geometry<'a>,
    pub edits: Edits,
    /// Actual less programmed position, mm.
    pub carried: Vector,
    /// Blocks written in addition.
    pub added: usize,
    /// A start further off than this is gone to first, where the field differs by the way of travel.
    pub tolerance_mm: Option<f64>,
    /// The blocks may run in any order.
    pub whole: bool,
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

impl<'a> Writer<'a> {
    /// Writes a move as its pieces.
    pub fn write(&mut self, index: usize, pieces: &[Piece], course: &Course) -> Result<(), Refused> {
        let here = self.here(index)?;
        let from = self.edits.len();
        let mut before = sum(&self.path.start[index], &self.carried);
        let live = self.live(&here, before, pieces, &course.standing)?;
        let turned = pieces.first().filter(|first| !course.arrives() && self.is_off(&here, &before, &first.start));
        let mut with_start = Vec::new();
        match turned {
            Some(first) if self.path.kind[index] == MoveKind::Arc => {
                before = self.go_before(&here, before, first.start, live)?
            }
            Some(first) => {
                with_start.push(Piece { end: first.start, ..*first });
                with_start.extend_from_slice(pieces);
            }
            None => {}
        }
        let pieces = if with_start.is_empty() { pieces } else { &with_start };
        if pieces.len() > 1 {
            self.require_divisible(&here)?;
        }
        let actual = self.first(&here, before, live, pieces)?;
        let texts = self.following(&here, actual, live, pieces);
        if !texts.is_empty() {
            let end = self.program.blocks().get(here.block).map_or(0, |block| block.end as usize);
            let program = self.program;
            self.edits.replace(end, end, |text| new_lines(program, here.block, &texts, text));
        }
        if !self.edits.close(here.block, from) {
            return Err(self.twice(here.block));
        }
        self.added += texts.len();
        Ok(())
    }

    /// Whether the tool has to go to a start first: an axis turned round, or what the field depends on changed.
    fn is_off(&self, here: &Here, actual: &Vector, start: &Vector) -> bool {
        let off = (0..3).map(|axis| (start[axis] - actual[axis]).abs()).fold(0.0, f64::max);
        self.path.kind[here.index] != MoveKind::Rapid && self.tolerance_mm.is_some_and(|tolerance| off > tolerance)
    }

    /// Goes straight to an arc's start in a block before its own, which then has to say G02 or G03 itself.
    fn go_before(&mut self, here: &Here, before: Vector, start: Vector, live: [bool; 3]) -> Result<Vector, Refused> {
        let block = self.program.blocks().get(here.block).copied();
        let Some(block) = block.filter(|block| !block.optional && !self.whole) else {
            return Err(self.unreachable(here));
        };
        let mut actual = before;
        let mut text = self.straight(here, start, live, &mut actual);
        if let Some(feed) = here.words.iter().find(|word| word.letter == b'F') {
            separate(&mut text);
            text.extend(self.program.text(feed));
        }
        let (at, ending) = (block.start as usize, line_ending(self.program.source()));
        self.edits.replace(at, at, |out| out.extend(text.iter().chain(ending)));
        self.added += 1;
        if self.motion_words(here).is_empty() {
            let code = self.arc_code(here);
            self.edits.insert(self.program, here.block, b'G', |text| text.extend(&code[1..]));
        }
        Ok(actual)
    }

    /// A straight block to a point.
    fn straight(&self, here: &Here, to: Vector, live: [bool; 3], actual: &mut Vector) -> Vec<u8> {
        let (before, mut text) = (*actual, b"G01".to_vec());
        for axis in here.axes.iter().filter(|axis| live[axis.index]) {
            separate(&mut text);
            actual[axis.index] = self.new_coordinate(here, axis, before, to[axis.index], false, &mut text);
        }
        text
    }

    fn arc_code(&self, here: &Here) -> &'static [u8] {
        let clockwise = self.geometry.arc(here.index).is_some_and(|arc| arc.sweep > 0.0);
        if clockwise {
            b"G02"
        } else {
            b"G03"
        }
    }

    fn here(&self, index: usize) -> Result<Here<'a>, Refused> {
        let (program, path) = (self.program, self.path);
        let block = path.block[index] as usize;
        let state = &path.states[path.state[index] as usize];
        let step = Step::of(program.dialect(), state.inch);
        let increments = program.dialect().increments.unwrap_or([0; 3]);
        let axes = [0, 1, 2].map(|axis| {
            let word = usize::try_from(path.words[index][axis]).ok().and_then(|word| program.words().get(word));
            let letter = word.map_or(AXES[axis], |word| word.letter);
            let incremental = letter == increments[axis] || state.incremental;
            Axis { index: axis, letter, word, incremental, unit: state.axis_mm(axis) }
        });
        let here = Here { index, block, state, step, axes, words: program.words_of(block) };
        for axis in &axes {
            self.require_said(&here, axis)?;
        }
        Ok(here)
    }

    /// What the word of an axis says in program units.
    fn said(&self, here: &Here, axis: &Axis) -> f64 {
        let origin = if axis.incremental { self.path.start[here.index][axis.index] } else { 0.0 };
        (self.path.end[here.index][axis.index] - origin) / axis.unit
    }

    /// An axis that moves is named by a word whose value is where it goes.
    fn require_said(&self, here: &Here, axis: &Axis) -> Result<(), Refused> {
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

    /// The axes to be written: those named, and those whose displacement changes by more than half a step. One that
    /// stands where the program has not said is never written: its displacement waits for its own next word.
    fn live(
        &self,
        here: &Here,
        before: Vector,
        pieces: &[Piece],
        standing: &[Standing; 3],
    ) -> Result<[bool; 3], Refused> {
        let half = here.step.unit / 2.0;
        let mut live = [false; 3];
        for axis in &here.axes {
            let k = axis.index;
            let off =
                pieces.iter().map(|piece| (piece.end[k] - before[k]).abs().max((piece.start[k] - before[k]).abs()));
            // Displaced by nothing but the rounding that it carries already it stays.
            let off = off.fold(0.0, f64::max);
            let moves = axis.word.is_none() && off > half * axis.unit && self.path.start[here.index][k].is_finite();
            if moves && standing[k] == Standing::Never && self.path.kind[here.index] != MoveKind::Rapid {
                return Err(self.nowhere(here, axis, off));
            }
            live[k] = axis.word.is_some() || moves && standing[k] == Standing::Said;
        }
        Ok(live)
    }

    /// The block itself: the first piece. Gives where the tool then is.
    fn first(&mut self, here: &Here, before: Vector, live: [bool; 3], pieces: &[Piece]) -> Result<Vector, Refused> {
        let (Some(first), whole) = (pieces.first(), pieces.len() == 1) else {
            return Ok(before);
        };
        let mut actual = before;
        for axis in here.axes.iter().filter(|axis| live[axis.index]) {
            actual[axis.index] = self.coordinate(here, axis, before, first.end[axis.index], whole);
        }
        if let (Some(arc), Some(centre)) = (self.geometry.arc(here.index), first.centre) {
            let closed = whole && self.path.start[here.index] == self.path.end[here.index];
            if closed && here.axes.iter().any(|axis| (actual[axis.index] - before[axis.index]).abs() > SAME_MM) {
                return Err(self.open_circle(here));
            }
            self.centre(here, arc, before, actual, centre, whole)?;
        }
        let end = self.path.end[here.index];
        if whole {
            self.carried = [0, 1, 2].map(|axis| actual[axis] - end[axis]);
        }
        Ok(actual)
    }

    /// Writes one coordinate; gives where it then is.
    fn coordinate(&mut self, here: &Here, axis: &Axis, before: Vector, target: f64, whole: bool) -> f64 {
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

    /// I, J, K or R of the block's own arc.
    fn centre(
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
        let number = |letter: u8| here.words.iter().rev().find(|word| word.letter == letter);
        if let Some(word) = number(b'R') {
            let sign = if whole && arc.sweep.abs() > std::f64::consts::PI { -1.0 } else { 1.0 };
            let old = sign * arc.radius / mm;
            let radius = sign * (before[first] - centre[first]).hypot(before[second] - centre[second]) / mm;
            self.replace_value(here, word, radius, old, whole);
            return Ok(());
        }
        if number(CENTRES[first]).or(number(CENTRES[second])).is_none() {
            let hint = "write the arc with I, J, K or R in its own block";
            let message = "the arc's centre is not said in its block of 1 move".to_owned();
            return Err(Refused::block(self.block_start(here.block), message, hint));
        }
        for axis in [first, second] {
            let origin = |start: &Vector| {
                if here.state.centre_absolute {
                    0.0
                } else {
                    start[axis]
                }
            };
            let value = (centre[axis] - origin(&before)) / mm;
            let old = (arc.centre[axis] - origin(&self.path.start[here.index])) / mm;
            match number(CENTRES[axis]) {
                Some(word) => self.replace_value(here, word, value, old, whole),
                None if here.step.round(value) != 0 => {
                    let (steps, step) = (here.step.round(value), here.step);
                    self.edits.insert(self.program, here.block, CENTRES[axis], |text| step.write(text, steps, 0, 1));
                }
                None => {}
            }
        }
        Ok(())
    }

    fn replace_value(&mut self, here: &Here, word: &Word, value: f64, old: f64, whole: bool) {
        let (step, program) = (here.step, self.program);
        let change = step.round(value - old);
        if change == 0 {
            return;
        }
        let (start, end) = (program.value_start(word), word.end());
        let text = program.source().get(start..end).unwrap_or(&[]);
        if word.kind == WordKind::Expression && whole {
            self.edits.replace(start, end, |out| step.with_term(out, text, change, program.dialect()));
        } else {
            self.edits.replace(start, end, |out| step.restyle(out, text, step.round(value)));
        }
    }

    /// The blocks of the pieces after the first; the last keeps the programmer's expressions.
    fn following(&mut self, here: &Here, mut actual: Vector, live: [bool; 3], pieces: &[Piece]) -> Vec<Vec<u8>> {
        let mut texts = Vec::new();
        for (number, piece) in pieces.iter().enumerate().skip(1) {
            let turned = piece.centre.is_some() && self.is_off(here, &actual, &piece.start);
            if turned {
                texts.push(self.straight(here, piece.start, live, &mut actual));
            }
            let (before, mut text) = (actual, self.motion_words(here));
            if turned && text.is_empty() {
                text.extend(self.arc_code(here));
            }
            for axis in here.axes.iter().filter(|axis| live[axis.index]) {
                let last = number + 1 == pieces.len();
                separate(&mut text);
                actual[axis.index] = self.new_coordinate(here, axis, before, piece.end[axis.index], last, &mut text);
            }
            if let Some(centre) = piece.centre {
                self.new_centre(here, centre, before, actual, &mut text);
            }
            texts.push(text);
        }
        if !texts.is_empty() {
            self.carried = [0, 1, 2].map(|axis| actual[axis] - self.path.end[here.index][axis]);
        }
        texts
    }

    fn motion_words(&self, here: &Here) -> Vec<u8> {
        let motion = |word: &&Word| {
            let code = (self.program.dialect().g)((word.value * 10.0).round() as u16);
            word.letter == b'G' && word.kind == WordKind::Number && matches!(code, Some(G::Motion(_)))
        };
        here.words.iter().find(motion).map_or(Vec::new(), |word| self.program.text(word).to_vec())
    }

    fn new_coordinate(
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

    fn new_centre(&self, here: &Here, wanted: Vector, before: Vector, actual: Vector, text: &mut Vec<u8>) {
        let (first, second, _) = here.state.plane.axes();
        let centre = equidistant(wanted, before, actual, first, second);
        let mut write = |letter: u8, value: f64| {
            separate(text);
            text.push(letter);
            here.step.write(text, here.step.round(value / here.state.mm()), 0, 1);
        };
        if here.words.iter().any(|word| word.letter == b'R') {
            return write(b'R', (before[first] - centre[first]).hypot(before[second] - centre[second]));
        }
        for axis in [first, second] {
            let origin = if here.state.centre_absolute { 0.0 } else { before[axis] };
            write(CENTRES[axis], centre[axis] - origin);
        }
    }

    /// Some moves are one to the control: a thread, one whose time is given, one with a code that is done at its end.
    fn require_divisible(&self, here: &Here) -> Result<(), Refused> {
        let late = |word: &&Word| word.letter == b'M' && !BEFORE_MOVE.contains(&(word.value.round() as u16));
        let code = here.words.iter().find(late).map(|word| String::from_utf8_lossy(self.program.text(word)));
        let why = if self.path.kind[here.index] == MoveKind::Thread {
            "a thread".to_owned()
        } else if here.state.feed_mode == FeedMode::InverseTime {
            "a move whose time is given (G93)".to_owned()
        } else if let Some(code) = code {
            format!("a move with {code} in its block")
        } else {
            return Ok(());
        };
        let message = format!("{why} would have to become several blocks to follow the field");
        let hint = "put the code into a block of its own, or allow a larger tolerance";
        Err(Refused::block(self.block_start(here.block), message, hint))
    }

    fn nowhere(&self, here: &Here, axis: &Axis, off_mm: f64) -> Refused {
        let letter = char::from(axis.letter);
        let message = format!("{letter} is displaced by {off_mm:.5} mm, but the program never says where it stands");
        let hint = "name the axis before the first cut, or leave its displacement out of the field";
        Refused::block(self.block_start(here.block), message, hint)
    }

    fn unreachable(&self, here: &Here) -> Refused {
        let message = "an axis turns round before this arc, whose block may not be the next that is run".to_owned();
        let hint = "write loops and calls out, and arcs in blocks that are not optional";
        Refused::block(self.block_start(here.block), message, hint)
    }

    fn open_circle(&self, here: &Here) -> Refused {
        let message = "this full circle would not close after rounding".to_owned();
        let hint = "write it as two half circles, its start reached by absolute coordinates";
        Refused::block(self.block_start(here.block), message, hint)
    }

    fn twice(&self, block: usize) -> Refused {
        let message = "1 block moves the tool several times, to places that are displaced differently".to_owned();
        Refused::block(self.block_start(block), message, "write the loop, subprogram or cycle out")
    }

    fn block_start(&self, block: usize) -> usize {
        self.program.blocks().get(block).map_or(0, |block| block.start as usize)
    }
}

/// A space between words.
fn separate(text: &mut Vec<u8>) {
    if !text.is_empty() {
        text.push(b' ');
    }
}

/// The point nearest to a centre that is equally far from both ends, which were rounded after it was found.
fn equidistant(centre: Vector, start: Vector, end: Vector, first: usize, second: usize) -> Vector {
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
