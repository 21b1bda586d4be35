//! From a place of a patch downhill to the point nearest to a given one: Newton's method.

use crate::bezier::Local;
use crate::patch::{Foot, Patch};
use crate::{dot, minus, Point3};

const ROUNDS: usize = 40;
/// A step below this share of the parameters' intervals ends the search.
const DONE: f64 = 1e-14;
/// So does one of Newton's below this share, once it is taken: it squares the distance to go.
const NEARLY: f64 = 1e-8;
/// How often a step that leads farther away is halved.
const HALVINGS: usize = 8;
/// What rounding makes of a squared distance.
const ROUNDING: f64 = 1e-12;

type Ranges = [[usize; 2]; 2];

/// A place, the patch there, and how far it is from the point.
#[derive(Clone, Copy)]
struct Place {
    at: [f64; 2],
    here: Local,
    off: Point3,
    square: f64,
}

impl Place {
    #[inline]
    fn new(patch: &Patch, point: Point3, at: [f64; 2], ranges: Ranges) -> Self {
        let here = patch.local(at, ranges);
        let off = minus(here.point, point);
        let square = dot(off, off);
        Self {
            at,
            here,
            off,
            square,
        }
    }

    /// Newton's step towards the least distance; Gauss and Newton's where the curvature would lead away. And whether
    /// such a step squares the distance to go.
    ///
    /// At a bound that the gradient pushes against, and where the patch has no area, each parameter goes alone.
    fn step(&self, bounds: [[f64; 2]; 2]) -> ([f64; 2], bool) {
        let Local {
            du,
            dv,
            duu,
            duv,
            dvv,
            ..
        } = self.here;
        let gradient = [dot(self.off, du), dot(self.off, dv)];
        let gauss = [dot(du, du), dot(du, dv), dot(dv, dv)];
        let bend = [dot(self.off, duu), dot(self.off, duv), dot(self.off, dvv)];
        let newton = [0, 1, 2].map(|k| gauss[k] + bend[k]);
        let convex = newton[0] > 0.0 && newton[0] * newton[2] > newton[1] * newton[1];
        let [a, b, c] = if convex { newton } else { gauss };
        let held = [0, 1].map(|k| {
            let ([low, high], at) = (bounds[k], self.at[k]);
            (at <= low && gradient[k] > 0.0) || (at >= high && gradient[k] < 0.0)
        });
        let area = a * c - b * b;
        if held == [false, false] && area > ROUNDING * a * c {
            let step = [
                b * gradient[1] - c * gradient[0],
                b * gradient[0] - a * gradient[1],
            ];
            return (step.map(|part| part / area), convex);
        }
        let alone = [0, 1].map(|k| {
            let own = if newton[2 * k] > 0.0 { newton } else { gauss }[2 * k];
            if held[k] || own <= 0.0 {
                0.0
            } else {
                -gradient[k] / own
            }
        });
        (alone, newton[0] > 0.0 && newton[2] > 0.0)
    }
}

/// The foot downhill from `near`, over edges of the patch too.
pub(crate) fn descended(patch: &Patch, point: Point3, near: [f64; 2]) -> Foot {
    let at = [0, 1].map(|k| near[k].clamp(patch.directions[k].low, patch.directions[k].high));
    let mut ranges = [0, 1].map(|k| {
        let direction = &patch.directions[k];
        direction.pieces[direction.at(at[k], direction.whole())].smooth
    });
    let mut best = within(patch, point, at, ranges);
    while let Some((place, other)) = beyond_an_edge(patch, point, &best, ranges) {
        (best, ranges) = (place, other);
    }
    let Local { point, du, dv, .. } = best.here;
    Foot {
        at: best.at,
        point,
        du,
        dv,
    }
}

/// Downhill within pieces that join smoothly.
fn within(patch: &Patch, point: Point3, at: [f64; 2], ranges: Ranges) -> Place {
    let bounds = [0, 1].map(|k| patch.directions[k].bounds(ranges[k]));
    let width = [0, 1].map(|k| patch.directions[k].high - patch.directions[k].low);
    let clamped = |at: [f64; 2]| [0, 1].map(|k| at[k].clamp(bounds[k][0], bounds[k][1]));
    let mut place = Place::new(patch, point, clamped(at), ranges);
    for _ in 0..ROUNDS {
        let (mut step, convex) = place.step(bounds);
        let size = (step[0] / width[0]).abs().max((step[1] / width[1]).abs());
        if size <= DONE {
            break;
        }
        let mut next = None;
        for _ in 0..HALVINGS {
            let at = clamped([place.at[0] + step[0], place.at[1] + step[1]]);
            let tried = Place::new(patch, point, at, ranges);
            if tried.square <= place.square * (1.0 + ROUNDING) {
                next = Some(tried);
                break;
            }
            step = step.map(|part| 0.5 * part);
        }
        let Some(next) = next else { break };
        place = next;
        if convex && size < NEARLY {
            break;
        }
    }
    place
}

/// What lies nearer on the other side of an edge at which the search was held.
fn beyond_an_edge(
    patch: &Patch,
    point: Point3,
    held: &Place,
    ranges: Ranges,
) -> Option<(Place, Ranges)> {
    for k in [0, 1] {
        let pieces = &patch.directions[k].pieces;
        let [low, high] = patch.directions[k].bounds(ranges[k]);
        let before = ranges[k][0].checked_sub(1).filter(|_| held.at[k] <= low);
        let after = Some(ranges[k][1] + 1).filter(|_| held.at[k] >= high);
        for piece in [before, after].into_iter().flatten() {
            let Some(piece) = pieces.get(piece) else {
                continue;
            };
            let mut other = ranges;
            other[k] = piece.smooth;
            let place = within(patch, point, held.at, other);
            if place.square < held.square * (1.0 - ROUNDING) {
                return Some((place, other));
            }
        }
    }
    None
}
