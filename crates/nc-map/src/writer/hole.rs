//! The holes of drilling cycles: their place, the plane R and their depth are displaced each by its own word.
//!
//! A cycle drills along its axis: a field that would have a hole lean or bend is followed by the middle of it, and
//! refused where that leaves a point of the hole further off than the tolerance.

use super::coordinate::says;
use super::{Axis, Here, Writer, SAME_MM};
use crate::field::Vector;
use crate::part::{require_said, Course};
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::standing::{is_increment, Standing};
use nc_program::dialect::FlowStyle;
use nc_program::{Drilled, MoveKind};

/// What is in force of a drilling cycle on the control, less what the program says, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drilling {
    /// The series that began at the initial height.
    series: u32,
    initial: f64,
    /// The heights R and Z; of LinuxCNC, which reads them anew in every block, what their words say.
    plane: f64,
    depth: f64,
    /// The words of the hole's place.
    words: Vector,
}

/// Where a hole is to be, displaced, mm.
pub(super) struct Wanted {
    /// Its place and its bottom.
    pub bottom: Vector,
    /// Height of the plane R.
    pub plane: f64,
}

impl<'a> Writer<'a> {
    /// Writes a hole into its block. One that its block repeats has to come out right by the words of the first.
    pub fn drill(&mut self, hole: &Drilled, pieces: &[Piece], courses: &[Course]) -> Result<(), Refused> {
        let here = self.place(hole.place);
        let standing = self.require_known(hole, courses)?;
        if self.drilling.series != hole.series {
            self.begin(&here, hole)?;
        }
        let wanted = self.wanted(&here, hole, pieces)?;
        let before = [0, 1, 2].map(|axis| self.path.start[hole.place][axis] + self.carried[axis]);
        let from = self.edits.len();
        let mut actual = before;
        for axis in here.axes.iter().filter(|axis| axis.index != hole.third) {
            actual[axis.index] = self.across(&here, hole, axis, before, wanted.bottom[axis.index], &standing)?;
        }
        let (plane, bottom) = self.along(&here, hole, &wanted)?;
        actual[hole.third] = bottom;
        let initial = hole.initial + self.drilling.initial;
        if self.goes_down_first(hole, initial < plane) {
            return Err(self.down_first(&here, hole.plane));
        }
        if hole.repeat > 0 {
            let plane_off = (plane - wanted.plane).abs();
            let off = (0..3).map(|axis| (actual[axis] - wanted.bottom[axis]).abs()).fold(plane_off, f64::max);
            if off > self.tolerance_mm + here.step.unit * here.state.mm() {
                return Err(self.repeated(&here, off));
            }
        } else if !self.edits.close(here.block, from) {
            return Err(self.twice(here.block));
        }
        actual[hole.third] = if hole.ends_at_plane { plane } else { plane.max(initial) };
        self.carried = [0, 1, 2].map(|axis| actual[axis] - self.path.end[hole.end - 1][axis]);
        Ok(())
    }

    /// Whether the tool would now go down to the plane R before it goes to the hole: LinuxCNC goes to that plane first
    /// where the series began below it.
    fn goes_down_first(&self, hole: &Drilled, begun_below: bool) -> bool {
        let by_words = self.program.dialect().flow == FlowStyle::OWords;
        by_words && begun_below && hole.initial >= hole.plane && self.path.start[hole.place][hole.third] > hole.plane
    }

    /// Every axis stands at a position of the program before the drill goes down.
    pub(super) fn require_known(&self, hole: &Drilled, courses: &[Course]) -> Result<[Standing; 3], Refused> {
        let cut = self.first_cut(hole);
        let standing = courses.get(cut).map_or([Standing::Never; 3], |course| course.standing);
        require_said(self.program, self.path, cut, standing, standing)?;
        Ok(standing)
    }

    /// The first move of a hole that is a cut.
    fn first_cut(&self, hole: &Drilled) -> usize {
        (hole.place..hole.bottom).find(|index| self.path.kind[*index] == MoveKind::Line).unwrap_or(hole.bottom)
    }

    /// A series begins: it is known how far the tool stands off the height to which it will come back.
    fn begin(&mut self, here: &Here, hole: &Drilled) -> Result<(), Refused> {
        let height = self.path.start[hole.first][hole.third];
        if (height - hole.initial).abs() > SAME_MM {
            return Err(self.begun_elsewhere(here, hole.initial, height));
        }
        let initial = self.carried[hole.third];
        let plane = if self.keeps_places() && hole.plane_from_initial { initial } else { 0.0 };
        self.drilling = Drilling { series: hole.series, initial, plane, ..Drilling::default() };
        Ok(())
    }

    /// Where the hole is to be: across, the middle between the outermost of its points.
    pub(super) fn wanted(&self, here: &Here, hole: &Drilled, pieces: &[Piece]) -> Result<Wanted, Refused> {
        let down = self.first_cut(hole)..=hole.bottom;
        let cuts =
            || pieces.iter().filter(|p| down.contains(&p.of_move) && self.path.kind[p.of_move] == MoveKind::Line);
        let (Some(first), Some(last)) = (cuts().next(), cuts().next_back()) else {
            return Err(self.twice(here.block));
        };
        let mut bottom = last.end;
        for axis in (0..3).filter(|axis| *axis != hole.third) {
            let ends = cuts().flat_map(|piece| [piece.start[axis], piece.end[axis]]);
            let (least, most) = ends.fold((f64::MAX, f64::MIN), |(least, most), at| (least.min(at), most.max(at)));
            if most - least > 2.0 * self.tolerance_mm {
                return Err(self.leaning(here, axis, most - least));
            }
            bottom[axis] = (least + most) / 2.0;
        }
        Ok(Wanted { bottom, plane: first.start[hole.third] })
    }

    /// Writes a coordinate of the hole's place; gives where it then is.
    fn across(
        &mut self,
        here: &Here,
        hole: &Drilled,
        axis: &Axis,
        before: Vector,
        target: f64,
        standing: &[Standing; 3],
    ) -> Result<f64, Refused> {
        self.require_said(here, axis)?;
        let k = axis.index;
        if hole.repeat > 0 {
            let said = if axis.incremental { before[k] } else { 0.0 } + self.said(here, axis) * axis.unit;
            return Ok(if axis.word.is_some() { said + self.drilling.words[k] } else { before[k] });
        }
        let off = (target - before[k]).abs();
        if axis.word.is_none() && !here.tells(axis, off) {
            self.drilling.words[k] = 0.0;
            return Ok(before[k]);
        }
        if standing[k] == Standing::Never {
            return Err(self.nowhere(here, axis, off));
        }
        let actual = self.coordinate(here, axis, before, target, true)?;
        let origin = if axis.incremental { before[k] } else { 0.0 };
        self.drilling.words[k] = actual - origin - self.said(here, axis) * axis.unit;
        Ok(actual)
    }

    /// Writes R and the depth; gives the heights of the plane R and of the bottom.
    fn along(&mut self, here: &Here, hole: &Drilled, wanted: &Wanted) -> Result<(f64, f64), Refused> {
        let (state, third) = (here.state, hole.third);
        let programmed = if hole.plane_from_initial { hole.initial } else { 0.0 };
        let origin = [programmed, programmed + if hole.plane_from_initial { self.drilling.initial } else { 0.0 }];
        let axis =
            Axis { letter: b'R', word: self.program.word(hole.plane_word), unit: state.mm(), ..here.axes[third] };
        let heights = [hole.plane, wanted.plane];
        self.drilling.plane = self.height(here, hole, &axis, origin, heights, self.drilling.plane)?;
        let plane = hole.plane + self.height_off(origin, self.drilling.plane);

        let word = self.program.word(hole.depth_word);
        let letter = word.map_or(super::AXES[third], |word| word.letter);
        let incremental = is_increment(self.program, word, state.incremental);
        let origin = if incremental { [hole.plane, plane] } else { [0.0; 2] };
        let axis = Axis { letter, word, unit: state.axis_mm(third), ..here.axes[third] };
        let bottom = self.path.end[hole.bottom][third];
        let heights = [bottom, wanted.bottom[third]];
        self.drilling.depth = self.height(here, hole, &axis, origin, heights, self.drilling.depth)?;
        Ok((plane, bottom + self.height_off(origin, self.drilling.depth)))
    }

    /// How far a height is off that says in force what `in_force` tells, mm.
    fn height_off(&self, origin: [f64; 2], in_force: f64) -> f64 {
        in_force + if self.keeps_places() { 0.0 } else { origin[1] - origin[0] }
    }

    /// Whether R and Z stay at the heights that they named when they were given.
    fn keeps_places(&self) -> bool {
        self.program.dialect().flow != FlowStyle::OWords
    }

    /// Writes a height, where it is not in force already; gives what is then in force, less what the program says, mm.
    /// `origin` and `height` are as programmed and as they are to be, `in_force` is what stays without a word.
    fn height(
        &mut self,
        here: &Here,
        hole: &Drilled,
        axis: &Axis,
        origin: [f64; 2],
        height: [f64; 2],
        in_force: f64,
    ) -> Result<f64, Refused> {
        let [said, wanted] = [0, 1].map(|k| (height[k] - origin[k]) / axis.unit);
        if axis.word.is_some_and(|word| !says(word, said, axis.unit)) {
            return Err(self.other_height(here, axis, height[0]));
        }
        let off = (height[1] - height[0] - self.height_off(origin, in_force)).abs();
        let stays = axis.word.is_none() && !here.tells(axis, off);
        if stays || hole.repeat > 0 {
            return Ok(in_force);
        }
        let of_word = (self.value(here, axis, wanted, true, Some(said))? - said) * axis.unit;
        Ok(of_word + if self.keeps_places() { origin[1] - origin[0] } else { 0.0 })
    }
}
