//! Rays in the (x, z) plane.

/// A point or a vector: (x, z).
pub type Point = [f64; 2];

/// A ray from `origin` along the unit vector `direction`.
///
/// `across` is the direction turned to greater angles, from +z towards +x.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub(crate) origin: Point,
    pub(crate) direction: Point,
    pub(crate) across: Point,
}

impl Ray {
    /// A ray; the direction is taken as it is, so give a unit vector.
    pub fn new(origin: Point, direction: Point) -> Self {
        Self {
            origin,
            direction,
            across: [direction[1], -direction[0]],
        }
    }

    /// Angle of the direction from +z towards +x.
    pub(crate) fn angle(&self) -> f64 {
        self.direction[0].atan2(self.direction[1])
    }

    /// Coordinates of a point along and across the ray.
    pub(crate) fn of(&self, point: Point) -> (f64, f64) {
        let from = [point[0] - self.origin[0], point[1] - self.origin[1]];
        (self.along(from), self.over(from))
    }

    /// Component of a vector along the ray.
    pub(crate) fn along(&self, vector: Point) -> f64 {
        vector[0] * self.direction[0] + vector[1] * self.direction[1]
    }

    /// Component of a vector across the ray.
    pub(crate) fn over(&self, vector: Point) -> f64 {
        vector[0] * self.across[0] + vector[1] * self.across[1]
    }
}
