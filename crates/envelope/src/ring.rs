//! The edge of a bull-nose or flat end cutter on a piece of its way: where a ray enters it.
//!
//! The cutter's end is a disc of the ring's radius with a ball of the corner's radius around each of its points. Its
//! sweep along a piece on which the axis stands still is convex: the points within a corner radius of the swept disc. On a
//! ray the distance from that is a convex function, and Newton's method from outside comes to its first place without
//! ever stepping over it. Where the axis turns, the piece must be so short that this holds but for what may be neglected.

use crate::space::{along, dot, length, minus, Point3};

/// Steps along a ray at most; each more than halves what is left unless the ray only grazes the cutter.
const STEPS: usize = 80;
/// Steps to the nearest place of the way; each at least halves where it may be.
const HALVINGS: usize = 60;
/// mm: nearer than this is there but for one more step; nearer still, rounding says where the way is nearest.
const THERE: f64 = 1e-10;
/// A share of the way that is known to this is known.
const SHARE: f64 = 1e-13;
/// mm²: a squared distance that changes by less does not change.
const SQUARE: f64 = 1e-28;
/// How a plane below the end is tilted towards it, in its reach: of all planes one that is hardly ever far too low.
const TILT: f64 = 0.25;

/// A cutter's end: the radius of the circle on which the corner's centre runs, and the corner's.
#[derive(Clone, Copy, Debug)]
pub struct End {
    pub(crate) ring: f64,
    pub(crate) corner: f64,
}

/// A piece of the way: the disc's centre, given from the ray's origin, its way on, and the axis at both ends. Or several
/// pieces together: how far they leave that way, and by what chord at most an axis differs from the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub from: Point3,
    pub segment: Point3,
    pub axes: [Point3; 2],
    pub aside: f64,
    pub turned: f64,
}

/// The disc at a place of its way: centre, axis, and how the axis moves on.
struct Disc {
    centre: Point3,
    axis: Point3,
    turning: Point3,
}

impl Piece {
    /// Pieces between nodes, each with its axis, given from the ray's origin.
    pub(crate) fn over(nodes: &[Point3], axes: [Point3; 2], origin: Point3) -> Option<Self> {
        let (first, last) = (nodes.first()?, nodes.last()?);
        Some(Self {
            from: minus(*first, origin),
            segment: minus(*last, *first),
            axes,
            aside: 0.0,
            turned: length(minus(axes[1], axes[0])),
        })
    }

    pub(crate) fn middle(&self) -> Point3 {
        along(self.from, 0.5, self.segment)
    }

    /// How far along the ray the way comes.
    pub(crate) fn ahead(&self, direction: Point3) -> f64 {
        dot(self.from, direction) + dot(self.segment, direction).max(0.0)
    }

    /// Squared distance of a point from the way.
    pub(crate) fn off(&self, point: Point3) -> f64 {
        let from = minus(point, self.from);
        let square = dot(self.segment, self.segment).max(f64::MIN_POSITIVE);
        let share = (dot(from, self.segment) / square).clamp(0.0, 1.0);
        let off = along(from, -share, self.segment);
        dot(off, off)
    }

    fn turn(&self) -> Point3 {
        minus(self.axes[1], self.axes[0])
    }

    fn disc(&self, share: f64) -> Disc {
        let centre = along(self.from, share, self.segment);
        let [axis, _] = self.axes;
        let turn = self.turn();
        if turn == [0.0; 3] {
            return Disc {
                centre,
                axis,
                turning: turn,
            };
        }
        let axis = along(axis, share, turn);
        let size = 1.0 / length(axis);
        let axis = axis.map(|part| part * size);
        let turning = along(turn, -dot(turn, axis), axis).map(|part| part * size);
        Disc {
            centre,
            axis,
            turning,
        }
    }
}

impl End {
    /// Radii not below zero, one of them above.
    pub fn new(ring: f64, corner: f64) -> Self {
        Self { ring, corner }
    }

    /// Farthest that the end reaches from the ring's centre.
    pub(crate) fn reach(&self) -> f64 {
        self.ring + self.corner
    }

    /// Where the disc's centre is, from the ray's origin, when the end touches a plane across the ray there.
    pub(crate) fn touching(&self, direction: Point3, axis: Point3) -> Point3 {
        let lean = along(direction, -dot(direction, axis), axis);
        let size = length(lean).max(1e-9);
        let centre = direction.map(|part| self.corner * part);
        along(centre, self.ring / size, lean)
    }

    /// Below what the end does not reach on the ray, on its way: it stays above two planes that the ray goes through.
    pub(crate) fn lowest(&self, piece: &Piece, direction: Point3, touching: Point3) -> f64 {
        let off = minus(piece.middle(), touching);
        let aside = along(off, -dot(off, direction), direction);
        let tilted = along(direction, TILT / self.reach(), aside);
        let flat = self.above(piece, direction);
        flat.max(self.above(piece, tilted))
    }

    /// How far the end stays above the plane through the ray's origin with this normal, in lengths of the normal.
    fn above(&self, piece: &Piece, normal: Point3) -> f64 {
        let centre = dot(piece.from, normal);
        let square = dot(normal, normal);
        let lean = piece
            .axes
            .map(|axis| (square - dot(normal, axis).powi(2)).max(0.0));
        let besides = self.corner + piece.aside + self.ring * piece.turned;
        let below = besides * square.sqrt() + self.ring * lean[0].max(lean[1]).sqrt();
        centre + dot(piece.segment, normal).min(0.0) - below
    }

    /// Where a ray from the origin first meets the end on its way, between `low` and `high`; infinite where it does not.
    pub(crate) fn entry(&self, piece: &Piece, direction: Point3, [low, high]: [f64; 2]) -> f64 {
        let mut t = low;
        let mut share = 0.5;
        for _ in 0..STEPS {
            let point = direction.map(|part| t * part);
            share = self.nearest(piece, point, share);
            let away = self.beyond(&piece.disc(share), point).0;
            let distance = length(away);
            let left = distance - self.corner;
            let slope = dot(away, direction) / distance;
            if left <= THERE {
                return t + left.max(0.0) / (-slope).max(0.1);
            }
            t -= left / slope;
            if slope >= 0.0 || t >= high {
                return f64::INFINITY;
            }
        }
        t
    }

    /// The share of the way at which the disc comes nearest to a point.
    fn nearest(&self, piece: &Piece, point: Point3, guess: f64) -> f64 {
        let found = self.still(piece, point, guess);
        if piece.turn() == [0.0; 3] {
            return found;
        }
        // A disc that turns may come nearest at either end.
        let square = |share: f64| {
            let away = self.beyond(&piece.disc(share), point).0;
            dot(away, away)
        };
        let nearer = |a: f64, b: f64| if square(b) < square(a) { b } else { a };
        nearer(nearer(found, 0.0), 1.0)
    }

    /// The share at which the squared distance stands still, or the end it falls towards: Newton's method between
    /// bounds, halving them where it leaves them.
    fn still(&self, piece: &Piece, point: Point3, guess: f64) -> f64 {
        let ([mut low, mut high], [mut low_seen, mut high_seen]) = ([0.0, 1.0], [false, false]);
        let mut share = guess;
        for _ in 0..HALVINGS {
            let (falling, bend) = self.slope(piece, point, share);
            if falling == 0.0 || (share >= 1.0 && falling > 0.0) || (share <= 0.0 && falling < 0.0)
            {
                return share;
            }
            if falling > 0.0 {
                (low, low_seen) = (share, true);
            } else {
                (high, high_seen) = (share, true);
            }
            let step = falling / bend;
            if step.abs() < SHARE || (falling * step).abs() < SQUARE {
                return (share + step).clamp(0.0, 1.0);
            }
            let next = share + step;
            share = if !(next > low || low_seen) {
                low
            } else if !(next < high || high_seen) {
                high
            } else if next > low && next < high {
                next
            } else {
                0.5 * (low + high)
            };
        }
        share
    }

    /// Half of what the squared distance falls by for a share more, and half its second derivative (but for turning).
    fn slope(&self, piece: &Piece, point: Point3, share: f64) -> (f64, f64) {
        let disc = piece.disc(share);
        let (away, aside, radius) = self.beyond(&disc, point);
        let beyond = (1.0 - self.ring / radius).max(0.0);
        // The disc's nearest place moves on with its centre, and with the turn about it.
        let out = dot(disc.turning, aside) * (1.0 - beyond);
        let moving = along(piece.segment, -out, disc.axis);
        let up = dot(moving, disc.axis);
        let flat = along(moving, -up, disc.axis);
        let mut bend = up * up + beyond * dot(flat, flat);
        if beyond > 0.0 {
            bend += self.ring * dot(aside, flat).powi(2) / radius.powi(3);
        }
        (dot(away, moving), bend)
    }

    /// The vector to a point from the nearest place of the disc; that across the axis from its centre, and its length.
    fn beyond(&self, disc: &Disc, point: Point3) -> (Point3, Point3, f64) {
        let from = minus(point, disc.centre);
        let height = dot(from, disc.axis);
        let aside = along(from, -height, disc.axis);
        let radius = length(aside);
        let beyond = (1.0 - self.ring / radius).max(0.0);
        let away = along(disc.axis.map(|part| height * part), beyond, aside);
        (away, aside, radius)
    }
}
