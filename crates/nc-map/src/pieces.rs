//! What a move becomes when every point of it is displaced: one piece, or as many as the tolerance asks for.

use std::f64::consts::TAU;

use nc_program::{through, Arc, MoveKind, Plane, ToolPath};

use crate::field::{sum, Field, Place, Trouble, Vector};
use crate::geometry::Geometry;

/// Pieces of one move: more would mean that the field jumps there.
const MOST: f64 = 4096.0;
/// Intervals between the points at which a straight piece is looked at.
const LINE_PROBES: usize = 4;
/// An arc by its radius that turns as much, up to as much less than a full turn, hangs on the last digit of that.
const LOOSE_RAD: f64 = TAU / 3.0;
/// Over less than this no slope is looked at, mm.
const SAME_MM: f64 = 1e-6;

/// A piece of a displaced move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Index of the move.
    pub of_move: usize,
    /// Share of the move at which it ends: 1 for the last.
    pub share: f64,
    /// Where it starts, displaced as the piece itself is: off the end of the one before where an axis turned round.
    pub start: Vector,
    /// Where it ends, displaced.
    pub end: Vector,
    /// Its centre, for a piece of an arc; along the third axis that of its start.
    pub centre: Option<Vector>,
    /// Largest displacement along each axis, wherever it was looked at.
    pub largest: Vector,
    /// Steepest change of the displacement over its length; 0 for a rapid.
    pub slope: f64,
}

impl Piece {
    /// Calls its points as the turned, mirrored or scaled coordinates do in which its move is programmed.
    pub fn take_back(&mut self, path: &ToolPath) {
        if let Some(linear) = path.origins[path.state[self.of_move] as usize].linear {
            let back = linear.inverse();
            (self.start, self.end) = (back.place(self.start), back.place(self.end));
            self.centre = self.centre.map(|centre| back.place(centre));
        }
    }
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
    /// An arc that leaves its plane where the control has no such arcs: it becomes lines.
    straight: bool,
}

/// The pieces of the moves of those indices, in order. Moves not at feed, threads, and those that arrive from a place
/// that is not known, go straight to the displaced end.
pub(crate) fn pieces(
    geometry: &Geometry,
    moves: &[usize],
    field: &mut dyn Field,
    tolerance_mm: f64,
    arrives: impl Fn(usize) -> bool,
) -> Result<Vec<Piece>, Fault> {
    let path = geometry.path;
    let is_straight = |of_move: usize| match path.kind[of_move] {
        MoveKind::Arc => false,
        MoveKind::Line => field.keeps_lines() || arrives(of_move),
        MoveKind::Rapid | MoveKind::Probe | MoveKind::Thread => true,
    };
    let (ends, others): (Vec<_>, Vec<_>) = moves.iter().copied().partition(|of_move| is_straight(*of_move));
    let mut pieces = straight(geometry, &ends, field, &arrives)?;
    let mut stretches = Vec::new();
    for of_move in others {
        stretches.extend(to_begin_with(geometry, of_move)?);
    }
    while !stretches.is_empty() {
        stretches = round(geometry, stretches, field, tolerance_mm, &mut pieces)?;
    }
    pieces.sort_by(|a, b| a.of_move.cmp(&b.of_move).then(a.share.total_cmp(&b.share)));
    Ok(pieces)
}

/// The stretches to begin with: the whole move, or an arc from quadrant to quadrant where the way of travel counts.
fn to_begin_with(geometry: &Geometry, of_move: usize) -> Result<Vec<Stretch>, Fault> {
    let whole = Stretch { of_move, from: 0.0, to: 1.0, probes: LINE_PROBES, straight: false };
    let Some(arc) = geometry.arc(of_move) else {
        return Ok(vec![whole]);
    };
    let turns = (arc.sweep.abs() / TAU - 1e-9).ceil().max(1.0) as usize;
    if !geometry.knows_travel() {
        return Ok(vec![Stretch { probes: turns * ARC_PROBES, ..whole }]);
    }
    if turns > 1 {
        return Err(Fault::Turns(of_move));
    }
    let mut ends = geometry.quadrants(of_move, arc);
    ends.push(1.0);
    let starts = std::iter::once(0.0).chain(ends.iter().copied());
    Ok(starts.zip(ends.iter()).map(|(from, to)| Stretch { from, to: *to, probes: ARC_PROBES, ..whole }).collect())
}

/// Moves that go straight to their displaced end. Where a cut starts is looked at for its slope alone.
fn straight(
    geometry: &Geometry,
    moves: &[usize],
    field: &mut dyn Field,
    arrives: &impl Fn(usize) -> bool,
) -> Result<Vec<Piece>, Fault> {
    let path = geometry.path;
    let points: Vec<_> = moves
        .iter()
        .flat_map(|of_move| {
            let comes = path.kind[*of_move] == MoveKind::Rapid || arrives(*of_move);
            [if comes { path.end[*of_move] } else { path.start[*of_move] }, path.end[*of_move]]
        })
        .collect();
    let places: Vec<_> = moves.iter().flat_map(|of_move| [geometry.place(*of_move, 0.5); 2]).collect();
    let mut found = Vec::new();
    if !points.is_empty() {
        let owners = || moves.iter().flat_map(|of_move| [*of_move; 2]).collect();
        field
            .displacements(&in_work_offset(&points, &places), &places, &mut found)
            .map_err(|trouble| Fault::Field(trouble, owners()))?;
    }
    let pairs = points.chunks_exact(2).zip(found.chunks_exact(2));
    Ok(moves
        .iter()
        .zip(pairs)
        .map(|(of_move, (points, by))| {
            let (start, end) = (sum(&path.start[*of_move], &by[0]), sum(&points[1], &by[1]));
            let (largest, slope) = size(points, by);
            Piece { of_move: *of_move, share: 1.0, start, end, centre: None, largest, slope }
        })
        .collect())
}

/// Points where a field is asked, whatever the program's shifts call them: one place has one displacement.
pub(crate) fn in_work_offset(points: &[Vector], places: &[Place]) -> Vec<Vector> {
    points.iter().zip(places).map(|(point, place)| sum(point, &place.shift)).collect()
}

/// Largest displacement along each axis, and its steepest change from point to point.
fn size(points: &[Vector], by: &[Vector]) -> (Vector, f64) {
    let larger = |most: Vector, by: &Vector| [0, 1, 2].map(|axis| most[axis].max(by[axis].abs()));
    let steep = |pair: (&[Vector], &[Vector])| {
        let length = apart(&pair.0[0], &pair.0[1]);
        if length > SAME_MM {
            apart(&pair.1[0], &pair.1[1]) / length
        } else {
            0.0
        }
    };
    (by.iter().fold([0.0; 3], larger), points.windows(2).zip(by.windows(2)).map(steep).fold(0.0, f64::max))
}

fn apart(a: &Vector, b: &Vector) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// Looks at every stretch once: those that will do become pieces, the halves of the others are returned.
fn round(
    geometry: &Geometry,
    stretches: Vec<Stretch>,
    field: &mut dyn Field,
    tolerance_mm: f64,
    pieces: &mut Vec<Piece>,
) -> Result<Vec<Stretch>, Fault> {
    let (mut points, mut places) = (Vec::new(), Vec::new());
    for s in &stretches {
        let share = |probe: usize| s.from + (s.to - s.from) * probe as f64 / s.probes as f64;
        points.extend((0..=s.probes).map(|probe| geometry.point(s.of_move, share(probe))));
        places.extend(std::iter::repeat_n(geometry.place(s.of_move, 0.5 * (s.from + s.to)), s.probes + 1));
    }
    let mut found = Vec::new();
    let owners = || stretches.iter().flat_map(|s| std::iter::repeat_n(s.of_move, s.probes + 1)).collect();
    field
        .displacements(&in_work_offset(&points, &places), &places, &mut found)
        .map_err(|trouble| Fault::Field(trouble, owners()))?;
    let displaced: Vec<_> = points.iter().zip(&found).map(|(point, by)| sum(point, by)).collect();
    let (mut first, mut halves) = (0, Vec::new());
    for mut s in stretches {
        let all = first..first + s.probes + 1;
        first = all.end;
        let here = &displaced[all.clone()];
        let (of_move, share, start, end) = (s.of_move, s.to, here[0], here[s.probes]);
        let arc = geometry.arc(of_move);
        let by = &found[all.clone()];
        let kept = geometry.is_polar(of_move) && by.iter().all(|other| apart(other, &by[0]) <= SAME_MM);
        s.straight |= arc.is_none() || !kept && geometry.leaves_plane(of_move, here);
        let fitted = match arc.filter(|_| !s.straight) {
            None => (chord_error(here) <= tolerance_mm).then_some(None),
            Some(arc) if kept => Some(Some(sum(&arc.centre, &by[0]))),
            Some(arc) if is_loose(arc, &s, &found[all.clone()]) => None,
            Some(_) => circle(here, geometry.plane(of_move), tolerance_mm).map(Some),
        };
        match fitted {
            Some(centre) => {
                let (largest, slope) = size(&points[all.clone()], &found[all]);
                pieces.push(Piece { of_move, share, start, end, centre, largest, slope });
            }
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

/// Whether a stretch would be written by its radius, and so near to half a turn that rounding that would throw its
/// middle off; not so where its ends go the same way, which changes neither radius nor chord.
fn is_loose(arc: &Arc, stretch: &Stretch, by: &[Vector]) -> bool {
    let turned = arc.sweep.abs() * (stretch.to - stretch.from);
    let shifted = || stretch.from == 0.0 && stretch.to == 1.0 && by.iter().all(|other| apart(other, &by[0]) <= SAME_MM);
    !arc.radius.is_nan() && (LOOSE_RAD..TAU - LOOSE_RAD).contains(&turned) && !shifted()
}

/// Intervals between the points at which one turn of an arc is looked at.
pub(crate) const ARC_PROBES: usize = 8;

/// Largest distance of the points from those that share the way from the first to the last evenly.
pub(crate) fn chord_error(points: &[Vector]) -> f64 {
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
pub(crate) fn circle(points: &[Vector], plane: Plane, tolerance_mm: f64) -> Option<Vector> {
    let (first, second, third) = plane.axes();
    let flat = |point: &Vector| [point[first], point[second]];
    let (start, end) = (points.first()?, points.last()?);
    // On a full circle first and last point coincide: two others of its first turn determine it.
    let closed = distance(flat(start), flat(end)) < 0.1 * distance(flat(start), flat(points.get(ARC_PROBES / 2)?));
    let chosen = if closed || points.len() > ARC_PROBES + 1 { [3, 5] } else { [ARC_PROBES / 2, ARC_PROBES] };
    let (centre, _) = through(flat(start), flat(points.get(chosen[0])?), flat(points.get(chosen[1])?));
    centre.iter().all(|value| value.is_finite()).then_some(())?;
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
