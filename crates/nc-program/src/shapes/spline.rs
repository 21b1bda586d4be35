//! Splines of LinuxCNC (G5, G5.1, G5.2): rational B-splines, as the chords that its interpreter hands on for each.

use crate::compensation::offset::plus;
use crate::finding;
use crate::modes::modal::Plane;
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::{Runner, AXES};
use crate::shapes::arc::Point;

/// Chords for each control point.
const CHORDS: usize = 15;
/// A smaller order is read as this one.
const LEAST_ORDER: usize = 3;
/// More control points than this are refused.
const MOST: usize = 1000;

/// What a spline's blocks say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Spline {
    /// A cubic: I, J lead from the start to the second of four control points, P, Q from the end to the third.
    Cubic,
    /// A quadratic: I, J lead from the start to the second of three.
    Quadratic,
    /// A control point to each block, with its weight P; L the order.
    Points,
    /// The spline of these points.
    End,
}

/// What one block of a spline leaves to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct SplineData {
    /// Of a cubic, from its end to where the next one's second control point lies.
    ahead: Option<Point>,
    points: Vec<(Point, f64)>,
    order: usize,
}

/// The ends of the chords: the parameter goes up in equal steps over open, uniform knots.
fn chords(points: &[(Point, f64)], order: usize) -> Vec<Point> {
    let Some((last, _)) = points.last() else { return Vec::new() };
    let most = points.len().saturating_sub(order) as f64 + 1.0;
    let step = most / (CHORDS * points.len()) as f64;
    let (mut found, mut u) = (Vec::new(), 0.0);
    while u + step < most {
        found.push(at(points, order, u + step));
        u += step;
    }
    found.push(*last);
    found
}

/// The point of a parameter, by de Boor's recursion of the points and their weights.
fn at(points: &[(Point, f64)], order: usize, u: f64) -> Point {
    let inner = points.len().saturating_sub(order);
    let span = (u.floor() as usize).min(inner);
    let knot = |index: usize| (index as f64 - (order as f64 - 1.0)).clamp(0.0, inner as f64 + 1.0);
    let weighted = |((x, y), weight): ((f64, f64), f64)| [x * weight, y * weight, weight];
    let own = points.iter().skip(span).take(order);
    let mut row: Vec<[f64; 3]> = own.map(|(point, weight)| weighted(((point[0], point[1]), *weight))).collect();
    for level in 1..order {
        row = row
            .windows(2)
            .enumerate()
            .filter_map(|(place, pair)| {
                let [before, after] = pair else { return None };
                let (low, high) = (knot(span + place + level), knot(span + place + order));
                let share = (u - low) / (high - low);
                Some([0, 1, 2].map(|part| before[part] + share * (after[part] - before[part])))
            })
            .collect();
    }
    row.first().map_or([f64::NAN; 2], |[x, y, weight]| [x / weight, y / weight])
}

impl Runner<'_> {
    /// A block of a spline.
    pub(crate) fn spline(&mut self, request: &Request, spline: Spline) {
        let made = match spline {
            _ if self.state.modal.plane != Plane::Xy || request.any(b"Z") => Err("it lies in X and Y, under G17"),
            Spline::Cubic => self.cubic(request),
            Spline::Quadratic => self.quadratic(request),
            Spline::Points => self.add_point(request),
            Spline::End => self.end_points(),
        };
        if let Err(hint) = made {
            let message = "a spline that cannot be made of these words".to_owned();
            self.refuse(finding::MISPLACED, self.block_start(), message, hint);
        }
    }

    /// Offsets of a control point by two letters: both or none of them.
    fn offset_by(&self, request: &Request, letters: [u8; 2]) -> Option<Point> {
        let [first, second] = letters.map(|letter| request.get(letter));
        first.zip(second).map(|(first, second)| [first, second].map(|value| value * self.state.modal.mm()))
    }

    fn here_and_end(&mut self, request: &Request) -> [Point; 2] {
        [self.state.position, self.target(request, false).0].map(|[x, y, _]| [x, y])
    }

    fn cubic(&mut self, request: &Request) -> Result<(), &'static str> {
        let [start, end] = self.here_and_end(request);
        let own = self.offset_by(request, *b"IJ");
        if own.is_none() && request.any(b"IJ") {
            return Err("write I and J both, or neither");
        }
        let ahead = own.or(self.state.spline.ahead).ok_or("the first one wants I and J")?;
        let back = self.offset_by(request, *b"PQ").ok_or("write P and Q: from the end to the point before it")?;
        let points = [start, plus(start, ahead, 1.0), plus(end, back, 1.0), end].map(|point| (point, 1.0));
        self.emit_chords(&points, points.len());
        self.state.spline.ahead = Some(back.map(|part| -part));
        Ok(())
    }

    fn quadratic(&mut self, request: &Request) -> Result<(), &'static str> {
        let [start, end] = self.here_and_end(request);
        let ahead = self.offset_by(request, *b"IJ").ok_or("write I and J: from the start to the point between")?;
        let points = [start, plus(start, ahead, 1.0), end].map(|point| (point, 1.0));
        self.emit_chords(&points, points.len());
        Ok(())
    }

    fn add_point(&mut self, request: &Request) -> Result<(), &'static str> {
        let [start, end] = self.here_and_end(request);
        let begins = self.state.spline.points.is_empty();
        let weight = request.get(b'P').or(begins.then_some(1.0)).filter(|weight| *weight > 0.0);
        let weight = weight.ok_or("each point wants its weight: P, greater than zero")?;
        if begins {
            self.state.spline.order = LEAST_ORDER;
            // P belongs to the point that the block names, where it names one.
            self.state.spline.points.push((start, if request.any(&AXES) { 1.0 } else { weight }));
        }
        if request.any(&AXES) {
            self.state.spline.points.push((end, weight));
        }
        if let Some(order) = request.get(b'L') {
            self.state.spline.order = order.round().clamp(LEAST_ORDER as f64, MOST as f64) as usize;
        }
        (self.state.spline.points.len() <= MOST).then_some(()).ok_or("it has more than 1000 points")
    }

    fn end_points(&mut self) -> Result<(), &'static str> {
        let points = std::mem::take(&mut self.state.spline.points);
        let order = self.state.spline.order;
        if points.len() < order.max(LEAST_ORDER) {
            return Err("it wants at least as many points as its order, L (3 at least)");
        }
        self.emit_chords(&points, order);
        Ok(())
    }

    fn emit_chords(&mut self, points: &[(Point, f64)], order: usize) {
        let z = self.state.position[2];
        for [x, y] in chords(points, order) {
            self.emit(MoveKind::Line, [x, y, z], [INHERITED; 3]);
        }
    }
}
