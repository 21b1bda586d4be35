//! Drilling cycles and the holes that they make; milling cycles that are called as they are.

pub(crate) mod called_cycle;
pub(crate) mod contour_cycle;
pub(crate) mod cycle_arguments;
pub(crate) mod drill;
pub(crate) mod hole;
pub(crate) mod hole_places;
pub(crate) mod milled;
pub(crate) mod pattern_def;
