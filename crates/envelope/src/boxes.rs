//! Upright boxes in space around runs of consecutive segments, two and two put together up to one.

use crate::space::{along, dot, length, minus, Point3};

/// Segments in a box of the lowest level.
pub(crate) const RUN: usize = 8;

/// Lower and upper corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upright {
    low: Point3,
    high: Point3,
}

impl Upright {
    fn around(nodes: &[Point3]) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for node in nodes {
            for ((low, high), value) in low.iter_mut().zip(high.iter_mut()).zip(node) {
                *low = low.min(*value);
                *high = high.max(*value);
            }
        }
        Self { low, high }
    }

    /// Below what no ball with its centre in the box reaches on the ray; infinite where it passes beside, or all of the
    /// box lies below −reach.
    pub(crate) fn lowest(&self, origin: Point3, direction: Point3, radius: f64, reach: f64) -> f64 {
        let half = minus(self.high, self.low).map(|side| 0.5 * side);
        let from = minus(along(self.low, 1.0, half), origin);
        let ahead = dot(from, direction);
        let spread = dot(half, direction.map(f64::abs));
        let beside = (dot(from, from) - ahead * ahead).max(0.0).sqrt() - length(half);
        if beside >= radius || ahead + spread <= -reach {
            return f64::INFINITY;
        }
        let beside = beside.max(0.0);
        ahead - spread - (radius * radius - beside * beside).sqrt()
    }
}

/// Levels of boxes, the lowest first; a box of one covers two of the level below.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    levels: Vec<Vec<Upright>>,
}

impl Boxes {
    pub(crate) fn over(nodes: &[Point3]) -> Self {
        let segments = nodes.len().saturating_sub(1);
        let mut levels = Vec::new();
        let mut run = RUN;
        loop {
            let count = segments.div_ceil(run).max(1);
            let boxes = (0..count).map(|k| {
                let end = (k * run + run + 1).min(nodes.len());
                Upright::around(nodes.get(k * run..end).unwrap_or_default())
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

    /// How many there are on the lowest level.
    pub(crate) fn runs(&self) -> usize {
        self.levels.first().map_or(0, Vec::len)
    }

    pub(crate) fn get(&self, level: usize, index: usize) -> Option<&Upright> {
        self.levels.get(level).and_then(|boxes| boxes.get(index))
    }
}
