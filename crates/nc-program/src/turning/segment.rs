//! Lines and arcs of a contour that LinuxCNC's turning cycles (G70 to G72) run on, in coordinates of their own.
//!
//! A point is (along, up), in program units, and the contour runs towards lower `along`. Bounds are those of LinuxCNC's
//! interpreter, whose moves these cycles are held to; they are in program units there too.

use crate::compensation::offset::{cross, minus, plus};
use crate::shapes::arc::Point;

/// Points nearer than this are one.
pub(crate) const NEAR: f64 = 1e-6;
/// What is smaller than this is dropped, or is no way back.
pub(crate) const SMALL: f64 = 1e-3;

/// Gaps wider than this are closed by an arc, and corners that leave them do not fit.
pub(crate) const GAP: f64 = 1e-2;

/// How an arc turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    pub centre: Point,
    /// From the first axis to the second: counterclockwise.
    pub left: bool,
}

/// A line, or an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    pub from: Point,
    pub to: Point,
    pub turn: Option<Turn>,
    /// Of a corner that is still a point: radius of the rounding, or what a rounding that touches where the chamfer
    /// ends would have; else 0.
    pub corner: f64,
}

impl Segment {
    pub fn line(from: Point, to: Point) -> Self {
        Self { from, to, turn: None, corner: 0.0 }
    }

    /// Length of a line; of an arc its chord or its radius, whichever is shorter.
    pub fn size(&self) -> f64 {
        let chord = length(minus(self.from, self.to));
        self.turn.map_or(chord, |turn| chord.min(length(minus(self.from, turn.centre))))
    }

    /// Whether it runs towards lower `along`; an arc in that half of its circle where all of it does.
    pub fn runs_on(&self) -> bool {
        let way = self.to[0] - self.from[0];
        if self.corner != 0.0 {
            return true;
        }
        let Some(turn) = self.turn else { return way <= SMALL };
        let outer = |point: Point| (point[1] - turn.centre[1]) * if turn.left { 1.0 } else { -1.0 } >= -SMALL;
        outer(self.from) && outer(self.to) && way <= -SMALL
    }

    /// The same beside itself: lines to the right of their way, and arcs that turn left grow.
    pub fn beside(&self, by: f64) -> Self {
        let Some(turn) = self.turn else {
            let back = minus(self.from, self.to);
            let off = [-by * back[1] / length(back), by * back[0] / length(back)];
            return Self { from: plus(self.from, off, 1.0), to: plus(self.to, off, 1.0), ..*self };
        };
        let radius = length(minus(self.from, turn.centre));
        let share = (radius + if turn.left { by } else { -by }) / radius;
        let scaled = |point: Point| plus(turn.centre, minus(point, turn.centre), share);
        Self { from: scaled(self.from), to: scaled(self.to), ..*self }
    }

    /// The same with a coordinate of the other sign.
    pub fn mirrored(&self, axis: usize) -> Self {
        let mirror = |point: Point| if axis == 0 { [-point[0], point[1]] } else { [point[0], -point[1]] };
        self.moved(mirror, true)
    }

    /// The same with its points moved; arcs turn the other way where that mirrors them.
    pub fn moved(&self, place: impl Fn(Point) -> Point, mirrors: bool) -> Self {
        let turn = self.turn.map(|turn| Turn { centre: place(turn.centre), left: turn.left != mirrors });
        Self { from: place(self.from), to: place(self.to), turn, ..*self }
    }

    /// Where it is at a height: `along` of the first and the last such place, of an arc that of its far side first.
    pub fn at_height(&self, up: f64) -> Option<[f64; 2]> {
        match self.turn {
            None => self.line_at_height(up),
            Some(turn) => self.arc_at_height(up, turn),
        }
    }

    fn line_at_height(&self, up: f64) -> Option<[f64; 2]> {
        let (from, to) = (self.from, self.to);
        if from[1].min(to[1]) > up + NEAR || from[1].max(to[1]) < up - NEAR {
            return None;
        }
        if (from[1] - to[1]).abs() < NEAR {
            return Some([from[0], to[0]]);
        }
        let along = (up - from[1]) / (to[1] - from[1]) * (to[0] - from[0]) + from[0];
        Some([along, along])
    }

    fn arc_at_height(&self, up: f64, turn: Turn) -> Option<[f64; 2]> {
        let radius = length(minus(self.from, turn.centre));
        // LinuxCNC's order of operations: near the arc's top the root makes 1e-8 of the last bit.
        let square = -(up - radius - turn.centre[1]) * (up + radius - turn.centre[1]);
        if square < -NEAR {
            return None;
        }
        let half = square.max(0.0).sqrt();
        let found = [turn.centre[0] + half, turn.centre[0] - half].map(|along| self.holds([along, up], turn));
        match found {
            [Some(first), Some(last)] => Some([first, last]),
            [one, other] => one.or(other).map(|along| [along, along]),
        }
    }

    /// `along` of a point of the circle, where the arc, of at most half a turn, has it.
    fn holds(&self, point: Point, turn: Turn) -> Option<f64> {
        let way = if turn.left { 1.0 } else { -1.0 };
        let beside = |end: Point| way * cross(minus(end, turn.centre), minus(point, turn.centre));
        (beside(self.from) >= -NEAR && beside(self.to) <= NEAR).then_some(point[0])
    }

    /// The circle of an arc, through that end of it.
    fn circle(&self, through: Point) -> Option<(Point, f64)> {
        self.turn.map(|turn| (turn.centre, length(minus(through, turn.centre))))
    }
}

pub(crate) fn length(way: Point) -> f64 {
    way[0].hypot(way[1])
}

/// Where one segment goes over into the next after both were put beside themselves; `None` where both stay.
pub(crate) fn joint(before: &Segment, after: &Segment) -> Result<Option<Point>, &'static str> {
    let meet = length(minus(after.from, before.to)) < NEAR;
    Ok(match (before.turn, after.turn) {
        (None, None) => Some(of_lines(before, after)?),
        (Some(_), Some(_)) => of_circles(after, before),
        (Some(_), None) if !meet => of_line_and_circle(after, before, after.from),
        (None, Some(_)) if !meet => of_line_and_circle(before, after, after.from),
        _ => None,
    })
}

fn of_lines(before: &Segment, after: &Segment) -> Result<Point, &'static str> {
    let along = minus(after.to, after.from);
    let height = |point: Point| cross(minus(point, after.to), along);
    let (first, last) = (height(before.from), height(before.to));
    if (first - last).abs() <= 1e-12 * length(along) * length(minus(before.to, before.from)) {
        return Err("two of its lines lie in one");
    }
    Ok(plus(before.from, minus(before.to, before.from), first / (first - last)))
}

/// The crossing of a line with an arc's circle that is nearer to a point; a line that passes it by counts as touching.
///
/// Where it all but touches, the root turns the last bit into 1e-8: the order of the operations is LinuxCNC's.
fn of_line_and_circle(line: &Segment, arc: &Segment, near: Point) -> Option<Point> {
    let centre = arc.turn?.centre;
    let back = minus(line.from, line.to);
    let unit = [back[0] / length(back), back[1] / length(back)];
    let own = |point: Point| {
        let way = minus(point, line.to);
        [way[0] * unit[0] + way[1] * unit[1], way[1] * unit[0] - way[0] * unit[1]]
    };
    let (middle, end) = (own(centre), own(arc.to));
    let out = minus(middle, end);
    let half = (out[0] * out[0] + out[1] * out[1] - middle[1] * middle[1]).max(0.0).sqrt();
    let [first, last] = [half, -half].map(|off| plus(line.to, unit, middle[0] + off));
    let first_is_nearer = length(minus(near, first)) < length(minus(near, last));
    Some(if first_is_nearer { first } else { last })
}

/// The crossing of two arcs' circles that lies left of the way from the first centre to the other.
fn of_circles(first: &Segment, other: &Segment) -> Option<Point> {
    let ((centre, radius), (other, far)) = (first.circle(first.from)?, other.circle(other.from)?);
    let way = minus(other, centre);
    let distance = length(way);
    let cosine = (distance * distance + radius * radius - far * far) / 2.0 / radius / distance;
    let sine = (1.0 - (cosine * cosine).min(1.0)).sqrt();
    let turned = [cosine * way[0] - sine * way[1], sine * way[0] + cosine * way[1]];
    Some(plus(centre, turned, radius / distance))
}

/// Cuts the corners of a contour, which end the segments beside them; what is left of no length is dropped.
pub(crate) fn cut_corners(segments: &mut Vec<Segment>) -> Result<(), &'static str> {
    for index in 1..segments.len().saturating_sub(1) {
        if let [before, corner, after] = &mut segments[index - 1..=index + 1] {
            if corner.corner != 0.0 {
                cut_corner(before, corner, after)?;
            }
        }
    }
    segments.retain(|segment| segment.size() >= SMALL);
    Ok(())
}

/// The circle of the rounding lies that far beside both neighbours; a chamfer joins where it would touch them.
fn cut_corner(before: &mut Segment, corner: &mut Segment, after: &mut Segment) -> Result<(), &'static str> {
    const FAILS: &str = "a corner of its contour does not fit";
    let fits = |by: f64| before.beside(by).to[0] - after.beside(by).from[0] <= GAP;
    let by = [corner.corner, -corner.corner].into_iter().find(|by| fits(*by)).ok_or(FAILS)?;
    let (mut ends, mut begins) = (before.beside(by), after.beside(by));
    if let Some(point) = joint(&ends, &begins)? {
        (ends.to, begins.from) = (point, point);
    }
    let centre = [(ends.to[0] + begins.from[0]) / 2.0, (ends.to[1] + begins.from[1]) / 2.0];
    before.to = ends.beside(-by).to;
    after.from = begins.beside(-by).from;
    let left = before.to[1] > centre[1] || after.from[1] > centre[1];
    let turn = corner.turn.map(|_| Turn { centre, left });
    *corner = Segment { from: before.to, to: after.from, turn, corner: 0.0 };
    Ok(())
}
