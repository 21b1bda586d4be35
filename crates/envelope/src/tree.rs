//! Boxes around runs of consecutive segments, two and two put together up to one.
//!
//! A box lies along the chord of its run: across a path that hardly bends it is thin, so that a ray sees at once how far
//! down the run can reach.

use crate::bundle::Bundle;
use crate::nose::Disc;
use crate::ray::{Point, Ray};

/// Segments in a box of the lowest level.
pub(crate) const RUN: usize = 8;

/// Centre, direction of the chord, half the length along it and half the width across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChordBox {
    centre: Point,
    chord: Point,
    half: Point,
}

impl ChordBox {
    /// Around points, along the line from `first` to `last`.
    fn around(first: Point, last: Point, points: impl Iterator<Item = Point>) -> Self {
        let (dx, dz) = (last[0] - first[0], last[1] - first[1]);
        let length = (dx * dx + dz * dz).sqrt();
        let chord = if length > 0.0 {
            [dx / length, dz / length]
        } else {
            [1.0, 0.0]
        };
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for point in points {
            let [x, z] = [point[0] - first[0], point[1] - first[1]];
            let here = [x * chord[0] + z * chord[1], z * chord[0] - x * chord[1]];
            low = [low[0].min(here[0]), low[1].min(here[1])];
            high = [high[0].max(here[0]), high[1].max(here[1])];
        }
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        Self {
            centre: [
                first[0] + middle[0] * chord[0] - middle[1] * chord[1],
                first[1] + middle[0] * chord[1] + middle[1] * chord[0],
            ],
            chord,
            half: [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])],
        }
    }

    fn corners(&self) -> [Point; 4] {
        let [x, z] = self.chord;
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(along, across)| {
            let [a, c] = [along * self.half[0], across * self.half[1]];
            [
                self.centre[0] + a * x - c * z,
                self.centre[1] + a * z + c * x,
            ]
        })
    }

    /// Below what no nose with its centre in the box reaches on the ray; infinite where it cannot reach below `best`.
    pub(crate) fn lowest(&self, ray: &Ray, disc: &Disc, floor: f64, best: f64) -> f64 {
        let (centre, half) = self.seen_by(ray);
        lowest(centre, half, disc, floor, best)
    }

    /// The same for every ray of a bundle.
    pub(crate) fn lowest_of_bundle(&self, bundle: &Bundle, floor: f64, best: f64) -> f64 {
        let (centre, half) = self.seen_by(&bundle.ray);
        let half = bundle.widened(centre, half);
        lowest(centre, half, &bundle.disc, floor, best)
    }

    /// Centre and half extents along a ray and across it.
    fn seen_by(&self, ray: &Ray) -> ((f64, f64), (f64, f64)) {
        let (with, against) = (ray.along(self.chord).abs(), ray.over(self.chord).abs());
        let spread = self.half[0] * with + self.half[1] * against + ROUNDING;
        let aside = self.half[0] * against + self.half[1] * with + ROUNDING;
        (ray.of(self.centre), (spread, aside))
    }
}

fn lowest(
    (along, over): (f64, f64),
    (spread, aside): (f64, f64),
    disc: &Disc,
    floor: f64,
    best: f64,
) -> f64 {
    let beside = ((over - disc.beside).abs() - aside).max(0.0);
    let square = disc.radius * disc.radius - beside * beside;
    let above = along - spread - disc.above - best;
    let misses = square <= 0.0 || along + spread <= floor;
    // Most boxes end here, before the root: it is what takes time.
    if misses || (above >= 0.0 && above * above >= square) {
        return f64::INFINITY;
    }
    above + best - square.sqrt()
}

/// What rounding may take off a box, mm: coordinates of metres are exact to 1e-13.
const ROUNDING: f64 = 1e-11;

/// Levels of boxes, the lowest first.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    levels: Vec<Vec<ChordBox>>,
}

impl Tree {
    /// Boxes around runs of `RUN` segments of a polyline, and of twice as many; a run has a node more than segments.
    pub(crate) fn over(nodes: &[Point]) -> Self {
        let runs = nodes.len().saturating_sub(1).div_ceil(RUN).max(1);
        let ends = |level: usize, k: usize| {
            let run = RUN << level;
            let last = (k * run + run).min(nodes.len().saturating_sub(1));
            (
                nodes.get(k * run).copied().unwrap_or_default(),
                nodes.get(last).copied().unwrap_or_default(),
            )
        };
        let boxes = (0..runs).map(|k| {
            let (first, last) = ends(0, k);
            let end = (k * RUN + RUN + 1).min(nodes.len());
            ChordBox::around(
                first,
                last,
                nodes.get(k * RUN..end).unwrap_or_default().iter().copied(),
            )
        });
        let mut levels = vec![boxes.collect::<Vec<ChordBox>>()];
        while let Some(below) = levels.last().filter(|below| below.len() > 1) {
            let boxes = below.chunks(2).enumerate().map(|(k, pair)| {
                let (first, last) = ends(levels.len(), k);
                ChordBox::around(first, last, pair.iter().flat_map(ChordBox::corners))
            });
            let boxes = boxes.collect();
            levels.push(boxes);
        }
        Self { levels }
    }

    pub(crate) fn top(&self) -> usize {
        self.levels.len() - 1
    }

    pub(crate) fn get(&self, level: usize, index: usize) -> Option<&ChordBox> {
        self.levels.get(level).and_then(|boxes| boxes.get(index))
    }
}
