//! What a move becomes when every point of it is displaced: one piece, or as many as the tolerance asks for.

use std::f64::consts::TAU;

use nc_program::{Arc, MoveKind, Plane, ToolPath};

use crate::field::{sum, Field, Trouble, Vector};

/// Pieces of one move: more would mean that the field jumps there.
const MOST: f64 = 4096.0;
/// Intervals between the points at which a straight piece is looked at, and those of one turn of an arc.
const LINE_PROBES: usize = 4;
const ARC_PROBES: usize = 8;

/// A piece of a displaced move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Index of the move.
    pub of_move: usize,
    /// Share of the move at which it ends: 1 for the last.
    pub share: f64,
    /// Where it ends, displaced.
    pub end: Vector,
    /// Its centre, for a piece of an arc; along the third axis that of its start.
    pub centre: Option<Vector>,
}

/// Why a move has no pieces: a field's trouble, or no number of pieces that would do.
pub(crate) enum Fault {
    Field(Trouble, Vec<usize>),
    Jump(usize),
    Turns(usize),
}

/// A stretch of a move whose displaced path is to become one piece.
#[derive(Clone, Copy)]
struct Stretch {
    of_move: usize,
    from: f64,
    to: f64,
    probes: usize,
}

/// The geometry of a move, by shares of it.
pub(crate) struct Geometry<'a> {
    path: &'a ToolPath,
    /// Index into the path's arcs, for each move.
    arc_of: Vec<u32>,
}

impl<'a> Geometry<'a> {
    pub fn new(path: &'a ToolPath) -> Self {
        let mut arc_of = vec![u32::MAX; path.len()];
        for (index, arc) in path.arcs.iter().enumerate() {
            if let Some(slot) = arc_of.get_mut(arc.of_move) {
                *slot = index as u32;
            }
        }
        Self { path, arc_of }
    }

    pub fn arc(&self, of_move: usize) -> Option<&'a Arc> {
        self.path.arcs.get(*self.arc_of.get(of_move)? as usize)
    }

    pub fn plane(&self, of_move: usize) -> Plane {
        self.path.states[self.path.state[of_move] as usize].plane
    }

    /// The programmed point at a share of the move.
    fn point(&self, of_move: usize, share: f64) -> Vector {
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

    fn whole(&self, of_move: usize) -> Stretch {
        let turns = self.arc(of_move).map(|arc| (arc.sweep.abs() / TAU - 1e-9).ceil().max(1.0) as usize);
        let probes = turns.map_or(LINE_PROBES, |turns| turns * ARC_PROBES);
        Stretch { of_move, from: 0.0, to: 1.0, probes }
    }
}

/// The pieces of the moves of those indices, in order. Moves not at feed, and threads, go straight to the displaced end.
pub(crate) fn pieces(
    geometry: &Geometry,
    moves: &[usize],
    field: &mut dyn Field,
    tolerance_mm: f64,
) -> Result<Vec<Piece>, Fault> {
    let path = geometry.path;
    let straight = |of_move: &usize| match path.kind[*of_move] {
        MoveKind::Arc => false,
        MoveKind::Line => field.keeps_lines(),
        MoveKind::Rapid | MoveKind::Probe | MoveKind::Thread => true,
    };
    let (ends, others): (Vec<_>, Vec<_>) = moves.iter().copied().partition(straight);
    let points: Vec<_> = ends.iter().map(|of_move| path.end[*of_move]).collect();
    let mut found = Vec::new();
    if !points.is_empty() {
        field.displacements(&points, &mut found).map_err(|trouble| Fault::Field(trouble, ends.clone()))?;
    }
    let displaced = points.iter().zip(&found).map(|(point, by)| sum(point, by));
    let piece = |(of_move, end): (&usize, Vector)| Piece { of_move: *of_move, share: 1.0, end, centre: None };
    let mut pieces: Vec<Piece> = ends.iter().zip(displaced).map(piece).collect();
    let mut stretches: Vec<_> = others.into_iter().map(|of_move| geometry.whole(of_move)).collect();
    while !stretches.is_empty() {
        stretches = round(geometry, stretches, field, tolerance_mm, &mut pieces)?;
    }
    pieces.sort_by(|a, b| a.of_move.cmp(&b.of_move).then(a.share.total_cmp(&b.share)));
    Ok(pieces)
}

/// Looks at every stretch once: those that will do become pieces, the halves of the others are returned.
fn round(
    geometry: &Geometry,
    stretches: Vec<Stretch>,
    field: &mut dyn Field,
    tolerance_mm: f64,
    pieces: &mut Vec<Piece>,
) -> Result<Vec<Stretch>, Fault> {
    let mut points = Vec::new();
    for s in &stretches {
        let share = |probe: usize| s.from + (s.to - s.from) * probe as f64 / s.probes as f64;
        points.extend((0..=s.probes).map(|probe| geometry.point(s.of_move, share(probe))));
    }
    let mut found = Vec::new();
    let owners = || stretches.iter().flat_map(|s| std::iter::repeat_n(s.of_move, s.probes + 1)).collect();
    field.displacements(&points, &mut found).map_err(|trouble| Fault::Field(trouble, owners()))?;
    for (point, by) in points.iter_mut().zip(&found) {
        *point = sum(point, by);
    }
    let (mut rest, mut halves) = (points.as_slice(), Vec::new());
    for s in stretches {
        let (here, after) = rest.split_at(s.probes + 1);
        rest = after;
        let (of_move, share, end) = (s.of_move, s.to, here[s.probes]);
        let fitted = match geometry.arc(of_move) {
            None => (chord_error(here) <= tolerance_mm).then_some(None),
            Some(_) => circle(here, geometry.plane(of_move), tolerance_mm).map(Some),
        };
        match fitted {
            Some(centre) => pieces.push(Piece { of_move, share, end, centre }),
            None if s.probes > ARC_PROBES => return Err(Fault::Turns(of_move)),
            None if (s.to - s.from) * MOST < 1.0 => return Err(Fault::Jump(of_move)),
            None => {
                let middle = 0.5 * (s.from + s.to);
                halves.extend([Stretch { to: middle, ..s }, Stretch { from: middle, ..s }]);
            }
        }
    }
    Ok(halves)
}

/// Largest distance of the points from those that share the way from the first to the last evenly.
fn chord_error(points: &[Vector]) -> f64 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return 0.0;
    };
    let count = (points.len() - 1) as f64;
    let off = |(index, point): (usize, &Vector)| {
        let share = index as f64 / count;
        let difference = [0, 1, 2].map(|axis| point[axis] - first[axis] - share * (last[axis] - first[axis]));
        (difference[0].powi(2) + difference[1].powi(2) + difference[2].powi(2)).sqrt()
    };
    points.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Centre of the helix through the points; `None` where it misses one by more than the tolerance.
fn circle(points: &[Vector], plane: Plane, tolerance_mm: f64) -> Option<Vector> {
    let (first, second, third) = plane.axes();
    let flat = |point: &Vector| [point[first], point[second]];
    let (start, end) = (points.first()?, points.last()?);
    // On a full circle first and last point coincide: two others of its first turn determine it.
    let closed = distance(flat(start), flat(end)) < 0.1 * distance(flat(start), flat(points.get(ARC_PROBES / 2)?));
    let chosen = if closed || points.len() > ARC_PROBES + 1 { [3, 5] } else { [ARC_PROBES / 2, ARC_PROBES] };
    let centre = through(flat(start), flat(points.get(chosen[0])?), flat(points.get(chosen[1])?))?;
    let radius = distance(flat(start), centre);
    let angle = |point: &Vector| (point[second] - centre[1]).atan2(point[first] - centre[0]);
    let (mut turned, mut before, mut last) = (Vec::new(), angle(start), 0.0);
    for point in points {
        last += (angle(point) - before + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        before = angle(point);
        turned.push(last);
    }
    for (point, angle) in points.iter().zip(&turned) {
        let across = point[third] - start[third] - angle / last * (end[third] - start[third]);
        let off = (distance(flat(point), centre) - radius).hypot(across);
        if off.is_nan() || off > tolerance_mm {
            return None;
        }
    }
    let mut whole = *start;
    (whole[first], whole[second]) = (centre[0], centre[1]);
    Some(whole)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Centre of the circle through three points of a plane.
fn through(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<[f64; 2]> {
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let twice = 2.0 * (bx * cy - by * cx);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let centre = [a[0] + (cy * b2 - by * c2) / twice, a[1] + (bx * c2 - cx * b2) / twice];
    centre.iter().all(|value| value.is_finite()).then_some(centre)
}
