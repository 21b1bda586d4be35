//! Sums over all pairs of points with weights that fall with a power of their distance, `d^-k`.
//!
//! Moran's I, Geary's C and their moments need nothing else. Memory grows with the number of points, not of pairs, and
//! results do not depend on how many threads there are: what a job sums is always the same. All pairs are worked off
//! one by one (`pair_sums`, `product`), or those far from each other together, to a given number of digits
//! (`far_product`). Nothing here panics.

mod block;
mod far;
mod lanes;
#[cfg(target_arch = "x86_64")]
mod lanes_x86;
mod pairs;
mod points;
mod product;
mod tree;
mod weight;

pub use far::far_product;
pub use pairs::{pair_sums, PairSums};
pub use points::{Points, Refused};
pub use product::product;
pub use weight::Decay;
