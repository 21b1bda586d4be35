//! A contour put beside itself, as LinuxCNC's turning cycles do for what is left for finishing.
//!
//! It goes in steps of at most half the smallest piece, so that pieces which vanish are noticed: they are dropped, gaps
//! are closed by arcs about the old corner, and neighbours are ended where they meet.

use crate::compensation::offset::{cross, minus};
use crate::shapes::arc::Point;
use crate::turning::segment::{joint, Segment, Turn, GAP, SMALL};

/// More steps, or pieces, than this are a contour that vanishes.
const MOST: usize = 10_000;
const VANISHES: &str = "nothing is left of its contour at that distance";

/// The contour off by a distance, away from where its first segment comes from. That one, which leads to it, stays at
/// its start.
pub(crate) fn beside(contour: &[Segment], distance: f64) -> Result<Vec<Segment>, &'static str> {
    let (Some((lead, rest)), Some(last)) = (contour.split_first(), contour.last()) else { return Err(VANISHES) };
    let (inwards, across) = (minus(lead.to, lead.from), minus(last.from, lead.from));
    let distance = if cross(across, inwards) < 0.0 { -distance } else { distance };
    let mut segments = shifted(rest.to_vec(), distance)?;
    for index in 1..segments.len() {
        let middle = |a: Point, b: Point| [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        if let [before, after, ..] = &mut segments[index - 1..] {
            before.to = middle(before.to, after.from);
            after.from = before.to;
        }
    }
    let begins = segments.first().ok_or(VANISHES)?.from;
    segments.insert(0, Segment { to: begins, ..*lead });
    Ok(segments)
}

fn shifted(mut segments: Vec<Segment>, distance: f64) -> Result<Vec<Segment>, &'static str> {
    let (mut done, mut rounds) = (0.0, 0);
    while done != distance {
        rounds += 1;
        if rounds > MOST || segments.len() > MOST {
            return Err(VANISHES);
        }
        let smallest = segments.iter().map(|segment| segment.size() / 2.0).fold(1e9, f64::min);
        let step = smallest.min((distance - done).abs()).copysign(distance);
        segments = segments.iter().map(|segment| segment.beside(step)).filter(|s| s.size() >= SMALL).collect();
        close_gaps(&mut segments, step, distance > 0.0);
        end_where_they_meet(&mut segments)?;
        done += step;
    }
    Ok(segments)
}

/// Arcs about the old corners.
fn close_gaps(segments: &mut Vec<Segment>, step: f64, left: bool) {
    let mut index = 0;
    while index + 1 < segments.len() {
        let (before, after) = (segments[index], segments[index + 1]);
        if before.to[0] - after.from[0] > GAP {
            let (old_end, old_start) = (before.beside(-step).to, after.beside(-step).from);
            let centre = [(old_end[0] + old_start[0]) / 2.0, (old_end[1] + old_start[1]) / 2.0];
            let arc = Segment { from: before.to, to: after.from, turn: Some(Turn { centre, left }), corner: 0.0 };
            segments.insert(index + 1, arc);
            index += 1;
        }
        index += 1;
    }
}

/// Drops what has turned back, the smaller of it and its neighbour, and ends each segment where the next begins.
fn end_where_they_meet(segments: &mut Vec<Segment>) -> Result<(), &'static str> {
    let (mut index, mut rounds) = (0, 0);
    while index + 1 < segments.len() {
        rounds += 1;
        if !segments[index].runs_on() {
            let before = index.checked_sub(1).ok_or("its contour turns back where it begins")?;
            let smaller = segments[index].size() < segments[before].size();
            segments.remove(if smaller { index } else { before });
            index = 0;
        }
        if index + 1 >= segments.len() || rounds > MOST {
            return Err(VANISHES);
        }
        if segments[index].size() < SMALL {
            segments.remove(index);
            index = 0;
        } else if let Some(point) = joint(&segments[index], &segments[index + 1])? {
            segments[index].to = point;
            segments[index + 1].from = point;
        }
        index += 1;
    }
    if segments.is_empty() {
        return Err(VANISHES);
    }
    Ok(())
}
