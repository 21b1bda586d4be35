//! The geometry of a path's moves, by shares of each.

use std::f64::consts::TAU;

use nc_program::{Arc, MoveKind, Plane, ToolPath};

use crate::field::{Place, Vector};

/// An axis that goes less than this stands, mm.
const STANDS_MM: f64 = 1e-9;

/// A path with what its moves do on their way.
pub(crate) struct Geometry<'a> {
    pub path: &'a ToolPath,
    /// Index into the path's arcs, for each move.
    arc_of: Vec<u32>,
    /// The way each axis went last before the end of each move; empty for a field to which it is all one.
    travel: Vec<[i8; 3]>,
    /// Where an axis comes from whose way the path does not tell.
    from: Vec<[i8; 3]>,
    /// How far an arc may leave its plane, mm, in metric and inch programs, where the control has no helices by their ends.
    flat_mm: Option<[f64; 2]>,
}

impl<'a> Geometry<'a> {
    /// `travel` is that before the first move, and is taken on to the last's where `from` has it for each move: where an
    /// axis comes from whose way does not follow from the path ([`FROM_REFERENCE`], …), else 0.
    pub fn new(path: &'a ToolPath, travel: &mut [i8; 3], from: Option<&[[i8; 3]]>, flat_mm: Option<[f64; 2]>) -> Self {
        let mut arc_of = vec![u32::MAX; path.len()];
        for (index, arc) in path.arcs.iter().enumerate() {
            if let Some(slot) = arc_of.get_mut(arc.of_move) {
                *slot = index as u32;
            }
        }
        let mut geometry = Self { path, arc_of, travel: Vec::new(), from: Vec::new(), flat_mm };
        if let Some(from) = from {
            geometry.from = from.to_vec();
            geometry.travel = (0..path.len())
                .map(|index| {
                    *travel = geometry.travels(index, *travel, 1.0 - 1e-6);
                    *travel
                })
                .collect();
        }
        geometry
    }

    /// The way of travel at a share of the move, from that before: an axis that stands keeps the way it came.
    fn travels(&self, of_move: usize, before: [i8; 3], share: f64) -> [i8; 3] {
        let (way, from) = (self.way(of_move, share), self.from.get(of_move).copied().unwrap_or_default());
        [0, 1, 2].map(|axis| match way[axis] {
            _ if from[axis] != 0 => from[axis],
            along if along > STANDS_MM => 1,
            along if along < -STANDS_MM => -1,
            _ => before[axis],
        })
    }

    pub fn arc(&self, of_move: usize) -> Option<&'a Arc> {
        self.path.arcs.get(*self.arc_of.get(of_move)? as usize)
    }

    /// Whether a move of Klartext ends by its radius and angle about the pole.
    pub fn is_polar(&self, of_move: usize) -> bool {
        let (first, second, _) = self.plane(of_move).axes();
        let words = self.path.words[of_move];
        self.flat_mm.is_some() && words[first] >= 0 && words[first] == words[second]
    }

    pub fn plane(&self, of_move: usize) -> Plane {
        self.path.states[self.path.state[of_move] as usize].plane
    }

    /// The programmed point at a share of the move.
    pub fn point(&self, of_move: usize, share: f64) -> Vector {
        let (start, end) = (self.path.start[of_move], self.path.end[of_move]);
        if share <= 0.0 || share >= 1.0 {
            return if share <= 0.0 { start } else { end };
        }
        let mut point = [0, 1, 2].map(|axis| start[axis] + share * (end[axis] - start[axis]));
        if let Some(arc) = self.arc(of_move) {
            let (first, second, _) = self.plane(of_move).axes();
            let spoke = |at: &Vector| (at[first] - arc.centre[first], at[second] - arc.centre[second]);
            let ((u, v), (u_end, v_end)) = (spoke(&start), spoke(&end));
            let angle = v.atan2(u) - arc.sweep * share;
            let radius = u.hypot(v) + share * (u_end.hypot(v_end) - u.hypot(v));
            point[first] = arc.centre[first] + radius * angle.cos();
            point[second] = arc.centre[second] + radius * angle.sin();
        }
        point
    }

    /// The way that each axis goes at a share of the move, mm a share; only its sign is of use.
    fn way(&self, of_move: usize, share: f64) -> Vector {
        let (start, end) = (self.path.start[of_move], self.path.end[of_move]);
        let mut way = [0, 1, 2].map(|axis| end[axis] - start[axis]);
        if let Some(arc) = self.arc(of_move) {
            let (first, second, _) = self.plane(of_move).axes();
            let (u, v) = (start[first] - arc.centre[first], start[second] - arc.centre[second]);
            let angle = v.atan2(u) - arc.sweep * share;
            (way[first], way[second]) = (arc.sweep * u.hypot(v) * angle.sin(), -arc.sweep * u.hypot(v) * angle.cos());
        }
        way
    }

    /// What a field has to know of a stretch: the way is that of its middle, for no axis turns round within it.
    pub fn place(&self, of_move: usize, middle: f64) -> Place {
        let index = self.path.state[of_move] as usize;
        let (state, origin) = (&self.path.states[index], &self.path.origins[index]);
        let travel = self.travel.get(of_move).map(|travel| self.travels(of_move, *travel, middle));
        Place {
            work_offset: state.work_offset,
            tool: state.tool_in_use(),
            shift: origin.shift,
            named: [0, 1, 2].map(|axis| origin.register[axis] - origin.shift[axis]),
            tool_offset: origin.tool.unwrap_or([f64::NAN; 3]),
            travel: travel.unwrap_or_default(),
            cuts: !matches!(self.path.kind[of_move], MoveKind::Rapid | MoveKind::Probe),
            rotary: [0, 1, 2].map(|axis| origin.rotary[axis].unwrap_or(f64::NAN)),
        }
    }

    /// Whether the way of travel counts.
    pub fn knows_travel(&self) -> bool {
        !self.travel.is_empty()
    }

    /// Whether the displaced points of an arc leave its plane where the control has no helices by their ends.
    pub fn leaves_plane(&self, of_move: usize, points: &[Vector]) -> bool {
        let state = &self.path.states[self.path.state[of_move] as usize];
        let (_, _, third) = state.plane.axes();
        let off = |most: f64| points.iter().any(|other| (other[third] - points[0][third]).abs() > most);
        self.flat_mm.is_some_and(|flat| off(flat[usize::from(state.inch)]))
    }

    /// Shares at which an axis of the arc's plane turns round.
    pub fn quadrants(&self, of_move: usize, arc: &Arc) -> Vec<f64> {
        let (first, second, _) = self.plane(of_move).axes();
        let start = self.path.start[of_move];
        let from = (start[second] - arc.centre[second]).atan2(start[first] - arc.centre[first]);
        let share = |quarter: i32| (from - f64::from(quarter) * TAU / 4.0) / arc.sweep;
        let mut found: Vec<f64> = (-8..=8).map(share).filter(|share| (1e-6..1.0 - 1e-6).contains(share)).collect();
        found.sort_by(f64::total_cmp);
        found
    }
}
