//! What a tool nose leaves when its centre runs along a path: the envelope, asked ray by ray.
//!
//! The plane is (x, z). A nose is a convex body given by its support function (`nose`), so that a worn nose is as
//! exact as a round one. Its sweep along a polyline is the union of one convex hull a segment (`sweep`). A ray that
//! leaves the material asks where it first meets that union; boxes around runs of segments (`tree`) leave a handful of
//! segments to look at, and neighbouring rays look for them together (`bundle`). A milling cutter in space is asked the
//! same way (`mill`, `ring`, `boxes`). Undercuts need nothing special: rays go in any direction. Nothing here panics.

mod boxes;
mod bundle;
mod mill;
mod nose;
mod ray;
mod ring;
mod space;
mod sweep;
mod tree;

pub use mill::EndSweep;
pub use nose::{Nose, NoseError};
pub use ray::{Point, Ray};
pub use ring::End;
pub use space::Point3;
pub use sweep::Sweep;
