//! Rays that hardly differ, asked together which runs of segments they have to look at.

use crate::nose::Disc;
use crate::ray::{Point, Ray};

/// Rays asked together.
pub(crate) const BUNDLE: usize = 16;

/// Most runs that a bundle looks at: more are looked for by each ray for itself.
const MOST_RUNS: usize = 8;

/// Room for the boxes that wait, about as many as the tree has levels; more get room when they come.
const WAITING: usize = 32;

/// Rays whose origins lie no farther from that of `ray` than `apart`, along themselves and across, and that are turned
/// against it by no more than an angle of the chord `turned`; `disc` holds the discs of all.
#[derive(Debug)]
pub(crate) struct Bundle {
    pub ray: Ray,
    pub disc: Disc,
    apart: (f64, f64),
    turned: f64,
}

impl Bundle {
    /// The bundle; None of no rays, and of rays farther apart than a small part of the nose.
    pub(crate) fn of<'a>(
        rays: impl ExactSizeIterator<Item = (&'a Ray, &'a Disc)> + Clone,
    ) -> Option<Self> {
        let (ray, disc) = rays.clone().nth(rays.len() / 2)?;
        let mut bundle = Self {
            ray: *ray,
            disc: *disc,
            apart: (0.0, 0.0),
            turned: 0.0,
        };
        for (other, own) in rays {
            let (along, over) = other.of(ray.origin);
            let beside = (own.beside - disc.beside).abs();
            bundle.apart.0 = bundle.apart.0.max(along.abs());
            bundle.apart.1 = bundle.apart.1.max(over.abs() + beside);
            bundle.turned = bundle.turned.max(distance(ray.direction, other.direction));
            bundle.disc.above = bundle.disc.above.max(own.above);
        }
        let near = bundle.apart.0 + bundle.apart.1 < 0.5 * disc.radius && bundle.turned < 0.1;
        near.then_some(bundle)
    }

    /// The half extents of a box as seen by `ray`, so that they hold for all.
    ///
    /// Turned by δ, a point at (along, over) moves along by along·(1 − cos δ) + over·sin δ, and 1 − cos δ = turned²/2.
    pub(crate) fn widened(
        &self,
        (along, over): (f64, f64),
        (spread, aside): (f64, f64),
    ) -> (f64, f64) {
        let (along, over) = (along.abs() + spread, over.abs() + aside);
        let less = 0.5 * self.turned * self.turned;
        (
            spread + self.apart.0 + along * less + over * self.turned,
            aside + self.apart.1 + over * less + along * self.turned,
        )
    }
}

fn distance(a: Point, b: Point) -> f64 {
    let [x, z] = [a[0] - b[0], a[1] - b[1]];
    (x * x + z * z).sqrt()
}

/// A few runs of segments, and below what none of their noses reaches.
#[derive(Debug, Default)]
pub(crate) struct Runs {
    runs: [(usize, f64); MOST_RUNS],
    count: usize,
}

impl Runs {
    /// Adds one; false where there is no room.
    pub(crate) fn push(&mut self, run: (usize, f64)) -> bool {
        let Some(place) = self.runs.get_mut(self.count) else {
            return false;
        };
        *place = run;
        self.count += 1;
        true
    }

    pub(crate) fn as_slice(&self) -> &[(usize, f64)] {
        self.runs.get(..self.count).unwrap_or_default()
    }
}

/// Boxes of the tree that are still to be looked into.
#[derive(Debug)]
pub(crate) struct Waiting {
    boxes: Vec<(usize, usize)>,
}

impl Waiting {
    /// The box of the top.
    pub(crate) fn of(top: usize) -> Self {
        let mut boxes = Vec::with_capacity(WAITING);
        boxes.push((top, 0));
        Self { boxes }
    }

    pub(crate) fn next(&mut self) -> Option<(usize, usize)> {
        self.boxes.pop()
    }

    pub(crate) fn halves(&mut self, level: usize, index: usize) {
        self.boxes
            .extend([(level - 1, 2 * index), (level - 1, 2 * index + 1)]);
    }
}
