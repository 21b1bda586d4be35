//! Sums over all pairs of points with weights that fall with a power of their distance, `d^-k`.
//!
//! Moran's I, Geary's C and their moments need nothing else. Pairs are worked off in tiles: memory grows with the number
//! of points, not of pairs, and what is summed in one tile does not depend on how many threads there are, so neither do
//! the results. Coincident points have no weight. Nothing here panics.

mod pairs;
mod points;
mod product;
mod weight;

pub use pairs::{pair_sums, PairSums};
pub use points::{Points, Refused};
pub use product::{product, Product};
pub use weight::Exponent;
