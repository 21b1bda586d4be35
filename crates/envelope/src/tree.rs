//! Boxes around runs of consecutive segments, two and two put together up to one.

use crate::nose::Disc;
use crate::ray::{Point, Ray};

/// Segments in a box of the lowest level.
pub(crate) const RUN: usize = 8;

/// Centre and half the sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box2 {
    centre: Point,
    half: Point,
}

impl Box2 {
    fn around(points: impl Iterator<Item = Point>) -> Self {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for [x, z] in points {
            low = [low[0].min(x), low[1].min(z)];
            high = [high[0].max(x), high[1].max(z)];
        }
        Self {
            centre: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])],
            half: [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])],
        }
    }

    fn corners(&self) -> [Point; 2] {
        let ([x, z], [dx, dz]) = (self.centre, self.half);
        [[x - dx, z - dz], [x + dx, z + dz]]
    }

    /// Below what no nose with its centre in the box reaches on the ray; infinite when none meets it above the floor.
    pub(crate) fn lowest(&self, ray: &Ray, disc: &Disc, floor: f64) -> f64 {
        let (along, over) = ray.of(self.centre);
        let (dx, dz) = (self.half[0], self.half[1]);
        let spread = dx * ray.direction[0].abs() + dz * ray.direction[1].abs();
        let aside = dx * ray.across[0].abs() + dz * ray.across[1].abs();
        let beside = ((over - disc.beside).abs() - aside).max(0.0);
        if beside >= disc.radius || along + spread <= floor {
            return f64::INFINITY;
        }
        along - spread - disc.above - (disc.radius * disc.radius - beside * beside).sqrt()
    }
}

/// Levels of boxes, the lowest first.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    levels: Vec<Vec<Box2>>,
}

impl Tree {
    /// Boxes around runs of `RUN` segments of a polyline; a run has one node more than segments.
    pub(crate) fn over(nodes: &[Point]) -> Self {
        let runs = nodes.len().saturating_sub(1).div_ceil(RUN).max(1);
        let lowest = (0..runs)
            .map(|k| Box2::around(nodes.iter().skip(k * RUN).take(RUN + 1).copied()))
            .collect();
        let mut levels: Vec<Vec<Box2>> = vec![lowest];
        while let Some(below) = levels.last().filter(|boxes| boxes.len() > 1) {
            let above = below
                .chunks(2)
                .map(|pair| Box2::around(pair.iter().flat_map(Box2::corners)))
                .collect();
            levels.push(above);
        }
        Self { levels }
    }

    pub(crate) fn top(&self) -> usize {
        self.levels.len() - 1
    }

    pub(crate) fn get(&self, level: usize, index: usize) -> Option<&Box2> {
        self.levels.get(level).and_then(|boxes| boxes.get(index))
    }
}
