//! From a point to the pieces that can be nearest to it: boxes around ever more of them, and each piece as good as flat.

use crate::bezier::Lifted;
use crate::descent::descended;
use crate::direction::Direction;
use crate::patch::{net_of, Foot, Patch};
use crate::{dot, minus, Point3};

/// Most pieces from which a descent starts: where more are equally near, as from a ball's centre, any of them will do.
const STARTS: usize = 16;
/// A share of the distance, of the size of rounding.
const ROUNDING: f64 = 1e-12;

/// A box around pieces `ranges`, halved along its longer side until one is left.
#[derive(Clone, Debug)]
struct Node {
    low: Point3,
    high: Point3,
    inside: Inside,
}

#[derive(Clone, Copy, Debug)]
enum Inside {
    Halves([usize; 2]),
    Piece(usize),
}

/// A piece as a parallelogram centre + s·half[0] + t·half[1], −1 ≤ s, t ≤ 1, from which none of its points strays more.
#[derive(Clone, Debug)]
struct Flat {
    centre: Point3,
    half: [Point3; 2],
    stray: f64,
    /// Parameters of the middle, and half the piece's widths.
    middle: [f64; 2],
    reach: [f64; 2],
}

/// All boxes, the first around the whole patch, and all pieces.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    nodes: Vec<Node>,
    flats: Vec<Flat>,
}

/// What a search keeps from point to point, so that nothing is allocated for each.
#[derive(Default)]
pub(crate) struct Search {
    stack: Vec<(f64, usize)>,
    found: Vec<Start>,
}

/// A place from where to descend: the distance to the flat piece, and what the surface itself cannot be nearer than.
#[derive(Clone, Copy)]
struct Start {
    distance: f64,
    least: f64,
    at: [f64; 2],
}

impl Boxes {
    pub(crate) fn new(directions: &[Direction; 2], nets: &[Lifted]) -> Self {
        let counts = [0, 1].map(|k| directions[k].pieces.len());
        let mut boxes = Self {
            nodes: Vec::new(),
            flats: Vec::new(),
        };
        for i in 0..counts[0] {
            for j in 0..counts[1] {
                boxes.flats.push(Flat::new(directions, nets, [i, j]));
            }
        }
        boxes.grow(directions, nets, [[0, counts[0]], [0, counts[1]]]);
        boxes
    }

    /// The box around pieces, and all within it; its index.
    fn grow(
        &mut self,
        directions: &[Direction; 2],
        nets: &[Lifted],
        ranges: [[usize; 2]; 2],
    ) -> usize {
        let index = self.nodes.len();
        let lengths = ranges.map(|[first, end]| end - first);
        if lengths == [1, 1] {
            let piece = [ranges[0][0], ranges[1][0]];
            let (low, high) = around(net_of(nets, directions, piece));
            let inside = Inside::Piece(piece[0] * directions[1].pieces.len() + piece[1]);
            self.nodes.push(Node { low, high, inside });
            return index;
        }
        let longer = usize::from(lengths[1] > lengths[0]);
        let middle = ranges[longer][0] + lengths[longer] / 2;
        let (mut left, mut right) = (ranges, ranges);
        (left[longer][1], right[longer][0]) = (middle, middle);
        self.nodes.push(Node {
            low: [0.0; 3],
            high: [0.0; 3],
            inside: Inside::Halves([0, 0]),
        });
        let halves = [left, right].map(|half| self.grow(directions, nets, half));
        let [a, b] = halves.map(|half| &self.nodes[half]);
        let low = [0, 1, 2].map(|k| a.low[k].min(b.low[k]));
        let high = [0, 1, 2].map(|k| a.high[k].max(b.high[k]));
        self.nodes[index] = Node {
            low,
            high,
            inside: Inside::Halves(halves),
        };
        index
    }

    /// The foot of a point.
    pub(crate) fn nearest(&self, patch: &Patch, point: Point3, search: &mut Search) -> Foot {
        self.gather(point, search);
        search
            .found
            .sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
        let mut best: Option<(f64, Foot)> = None;
        for start in search.found.iter().take(STARTS) {
            if best.is_some_and(|(distance, _)| start.least >= distance * (1.0 - ROUNDING)) {
                continue;
            }
            let foot = descended(patch, point, start.at);
            let off = minus(foot.point, point);
            let distance = dot(off, off).sqrt();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, foot));
            }
        }
        match best {
            Some((_, foot)) => foot,
            None => descended(patch, point, [0, 1].map(|k| patch.directions[k].low)),
        }
    }

    /// Every piece that can be nearest.
    fn gather(&self, point: Point3, search: &mut Search) {
        search.found.clear();
        search.stack.clear();
        search.stack.push((0.0, 0));
        let mut most = f64::INFINITY;
        while let Some((square, index)) = search.stack.pop() {
            if square > most * most {
                continue;
            }
            match self.nodes[index].inside {
                Inside::Piece(piece) => {
                    let start = self.flats[piece].start(point);
                    if start.least <= most {
                        most = most.min(start.distance + self.flats[piece].stray);
                        search.found.push(start);
                    }
                }
                Inside::Halves(halves) => {
                    let mut both = halves.map(|half| (self.nodes[half].square(point), half));
                    if both[0].0 < both[1].0 {
                        both.swap(0, 1);
                    }
                    search.stack.extend(both);
                }
            }
        }
        search.found.retain(|start| start.least <= most);
    }
}

impl Node {
    /// Squared distance of a point.
    #[inline]
    fn square(&self, point: Point3) -> f64 {
        let off = [0, 1, 2].map(|k| {
            (self.low[k] - point[k])
                .max(point[k] - self.high[k])
                .max(0.0)
        });
        dot(off, off)
    }
}

impl Flat {
    fn new(directions: &[Direction; 2], nets: &[Lifted], piece: [usize; 2]) -> Self {
        let net = net_of(nets, directions, piece);
        let [p, q] = [0, 1].map(|k| directions[k].degree);
        let point = |row: usize, column: usize| {
            let [x, y, z, w] = net[row * (q + 1) + column];
            [x / w, y / w, z / w]
        };
        let corners = [point(0, 0), point(0, q), point(p, 0), point(p, q)];
        let mean = |signs: [f64; 4]| {
            [0, 1, 2].map(|k| {
                corners
                    .iter()
                    .zip(signs)
                    .map(|(c, sign)| 0.25 * sign * c[k])
                    .sum()
            })
        };
        let [u, v] = [0, 1].map(|k| &directions[k].pieces[piece[k]]);
        let mut flat = Self {
            centre: mean([1.0; 4]),
            half: [mean([-1.0, -1.0, 1.0, 1.0]), mean([-1.0, 1.0, -1.0, 1.0])],
            stray: 0.0,
            middle: [u.from + 0.5 * u.width, v.from + 0.5 * v.width],
            reach: [0.5 * u.width, 0.5 * v.width],
        };
        for row in 0..=p {
            for column in 0..=q {
                let share = |k: usize, degree: usize| 2.0 * k as f64 / degree as f64 - 1.0;
                let off = minus(
                    point(row, column),
                    flat.at([share(row, p), share(column, q)]),
                );
                flat.stray = flat.stray.max(dot(off, off).sqrt());
            }
        }
        flat
    }

    #[inline]
    fn at(&self, [s, t]: [f64; 2]) -> Point3 {
        [0, 1, 2].map(|k| self.centre[k] + s * self.half[0][k] + t * self.half[1][k])
    }

    /// The nearest point of the parallelogram: where the nearest of its plane lies outside, on a side towards that.
    #[inline]
    fn start(&self, point: Point3) -> Start {
        let from = minus(point, self.centre);
        let [a, b] = self.half;
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let (fa, fb) = (dot(from, a), dot(from, b));
        let area = (aa * bb - ab * ab).max(f64::MIN_POSITIVE);
        let (s, t) = ((bb * fa - ab * fb) / area, (aa * fb - ab * fa) / area);
        let square = |&[s, t]: &[f64; 2]| {
            let off = minus(point, self.at([s, t]));
            dot(off, off)
        };
        let (on_s, on_t) = (clamped(s, 1.0), clamped(t, 1.0));
        let sides = [
            [on_s, clamped(fb - ab * on_s, bb)],
            [clamped(fa - ab * on_t, aa), on_t],
        ];
        let best = match (s.abs() > 1.0, t.abs() > 1.0) {
            (false, false) => [s, t],
            (true, false) => sides[0],
            (false, true) => sides[1],
            (true, true) if square(&sides[0]) <= square(&sides[1]) => sides[0],
            (true, true) => sides[1],
        };
        let distance = square(&best).sqrt();
        Start {
            distance,
            least: distance - self.stray,
            at: [0, 1].map(|k| self.middle[k] + best[k] * self.reach[k]),
        }
    }
}

/// A quotient between −1 and 1; 0 where there is none.
fn clamped(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 {
        (numerator / denominator).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

fn around(net: &[Lifted]) -> (Point3, Point3) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for control in net {
        for k in 0..3 {
            low[k] = low[k].min(control[k] / control[3]);
            high[k] = high[k].max(control[k] / control[3]);
        }
    }
    (low, high)
}
