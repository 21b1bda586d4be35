//! Drilling cycles, and the holes that they make.

pub(crate) mod called_cycle;
pub(crate) mod cycle_arguments;
pub(crate) mod drill;
pub(crate) mod hole;
pub(crate) mod hole_places;
