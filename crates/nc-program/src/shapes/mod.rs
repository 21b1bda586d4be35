//! Arcs, splines, corners and lines that are given by less than their ends.

pub(crate) mod arc;
pub(crate) mod contouring;
pub(crate) mod curve;
pub(crate) mod drawn;
pub(crate) mod rounding;
pub(crate) mod spline;
