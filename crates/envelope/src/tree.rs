//! Boxes around runs of consecutive segments, two and two put together up to one.
//!
//! A box lies along the chord of its run: across a path that hardly bends it is thin, so that a ray sees at once how far
//! down the run can reach.

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
    fn around(nodes: &[Point]) -> Self {
        let (first, last) = match (nodes.first(), nodes.last()) {
            (Some(first), Some(last)) => (*first, *last),
            _ => ([0.0; 2], [0.0; 2]),
        };
        let (dx, dz) = (last[0] - first[0], last[1] - first[1]);
        let length = dx.hypot(dz);
        let chord = if length > 0.0 {
            [dx / length, dz / length]
        } else {
            [1.0, 0.0]
        };
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for node in nodes {
            let [x, z] = [node[0] - first[0], node[1] - first[1]];
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

    /// Below what no nose with its centre in the box reaches on the ray; infinite where it cannot reach below `best`.
    pub(crate) fn lowest(&self, ray: &Ray, disc: &Disc, floor: f64, best: f64) -> f64 {
        let (along, over) = ray.of(self.centre);
        let (with, against) = (ray.along(self.chord).abs(), ray.over(self.chord).abs());
        let spread = self.half[0] * with + self.half[1] * against + ROUNDING;
        let aside = self.half[0] * against + self.half[1] * with + ROUNDING;
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
        let segments = nodes.len().saturating_sub(1);
        let mut levels: Vec<Vec<ChordBox>> = Vec::new();
        let mut run = RUN;
        loop {
            let count = segments.div_ceil(run).max(1);
            let boxes = (0..count).map(|k| {
                let end = (k * run + run + 1).min(nodes.len());
                ChordBox::around(nodes.get(k * run..end).unwrap_or_default())
            });
            levels.push(boxes.collect());
            if count == 1 {
                return Self { levels };
            }
            run *= 2;
        }
    }

    pub(crate) fn top(&self) -> usize {
        self.levels.len() - 1
    }

    pub(crate) fn get(&self, level: usize, index: usize) -> Option<&ChordBox> {
        self.levels.get(level).and_then(|boxes| boxes.get(index))
    }
}
