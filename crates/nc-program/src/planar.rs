//! A programmed move in the plane in which compensation acts.

use crate::arc::Point;
use crate::offset::minus;
use crate::path::Arc;

/// A programmed move, its plane's coordinates taken out.
#[derive(Clone, Copy)]
pub(crate) struct Planar<'a> {
    pub index: usize,
    pub axes: (usize, usize),
    pub start: [f64; 3],
    pub end: [f64; 3],
    pub arc: Option<&'a Arc>,
}

impl Planar<'_> {
    pub fn point(&self, position: [f64; 3]) -> Point {
        [position[self.axes.0], position[self.axes.1]]
    }

    pub fn from(&self) -> Point {
        self.point(self.start)
    }

    pub fn to(&self) -> Point {
        self.point(self.end)
    }

    /// Centre and whether it goes clockwise.
    pub fn circle(&self) -> Option<(Point, bool)> {
        self.arc.map(|arc| (self.point(arc.centre), arc.sweep > 0.0))
    }

    /// Unit direction of travel at one of its points.
    pub fn direction(&self, at: Point) -> Point {
        match self.circle() {
            Some((centre, clockwise)) => {
                let arm = minus(at, centre);
                unit(if clockwise { [arm[1], -arm[0]] } else { [-arm[1], arm[0]] })
            }
            None => unit(minus(self.to(), self.from())),
        }
    }
}

pub(crate) fn unit(way: Point) -> Point {
    let length = way[0].hypot(way[1]);
    [way[0] / length, way[1] / length]
}
