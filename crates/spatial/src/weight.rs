//! The weight of a pair, `d^-k`, from the square of its distance.

use crate::block::FAR;
use crate::lanes::{Lanes, Portable, LANES};
use crate::points::Refused;

/// How weights fall with distance: c = d^-k, distances below `nearest` counted as that.
///
/// With `nearest` zero, coincident points have no weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    exponent: f64,
    nearest: f64,
}

impl Decay {
    /// Refuses exponents that are not positive, and a distance that is negative.
    pub fn new(exponent: f64, nearest: f64) -> Result<Self, Refused> {
        if !(exponent.is_finite() && exponent > 0.0) {
            return Err(Refused::Exponent { exponent });
        }
        if !(nearest.is_finite() && nearest >= 0.0) {
            return Err(Refused::Nearest { nearest });
        }
        Ok(Self { exponent, nearest })
    }

    /// Distances below this count as this.
    pub(crate) fn nearest(self) -> f64 {
        self.nearest
    }

    /// Weight of coincident points.
    pub(crate) fn at_none(self) -> f64 {
        if self.nearest > 0.0 {
            self.nearest.powf(-self.exponent)
        } else {
            0.0
        }
    }

    /// Does the work with the arithmetic of this machine and the weight function chosen once, so that no pair has to.
    pub(crate) fn run<J: Job>(self, job: J) -> J::Output {
        let least = if self.nearest > 0.0 { -1.0 } else { COINCIDENT };
        let floor = self.nearest * self.nearest;
        match self.exponent {
            1.0 => dispatched(Power::<1> { floor, least }, job),
            2.0 => dispatched(Power::<2> { floor, least }, job),
            3.0 => dispatched(Power::<3> { floor, least }, job),
            4.0 => dispatched(Power::<4> { floor, least }, job),
            6.0 => dispatched(Power::<6> { floor, least }, job),
            8.0 => dispatched(Power::<8> { floor, least }, job),
            exponent => dispatched(
                Real {
                    exponent,
                    floor,
                    least,
                },
                job,
            ),
        }
    }
}

/// Work that needs weights.
pub(crate) trait Job {
    type Output;
    fn run<L: Lanes, W: Weight>(self, lanes: L, weight: W) -> Self::Output;
}

fn dispatched<W: Weight, J: Job>(weight: W, job: J) -> J::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(lanes) = pulp::x86::V4::try_new() {
            return lanes.vectorize(Bound { lanes, weight, job });
        }
        if let Some(lanes) = pulp::x86::V3::try_new() {
            return lanes.vectorize(Bound { lanes, weight, job });
        }
    }
    pulp::Arch::new().dispatch(Bound {
        lanes: Portable,
        weight,
        job,
    })
}

struct Bound<L, W, J> {
    lanes: L,
    weight: W,
    job: J,
}

impl<L: Lanes, W: Weight, J: Job> pulp::NullaryFnOnce for Bound<L, W, J> {
    type Output = J::Output;

    #[inline(always)]
    fn call(self) -> J::Output {
        self.job.run(self.lanes, self.weight)
    }
}

/// Weights from squared distances.
pub(crate) trait Weight: Copy {
    fn of<L: Lanes>(self, lanes: L, squared: L::Vector) -> L::Vector;
}

/// `d^-K`.
#[derive(Clone, Copy)]
pub(crate) struct Power<const K: u32> {
    floor: f64,
    least: f64,
}

impl<const K: u32> Weight for Power<K> {
    #[inline(always)]
    fn of<L: Lanes>(self, lanes: L, squared: L::Vector) -> L::Vector {
        let squared = lanes.greater(squared, lanes.splat(self.floor));
        lanes.inverse_root_power::<K>(squared, lanes.splat(self.least))
    }
}

/// `d^-k` for any k, one at a time.
#[derive(Clone, Copy)]
pub(crate) struct Real {
    exponent: f64,
    floor: f64,
    least: f64,
}

impl Weight for Real {
    #[inline(always)]
    fn of<L: Lanes>(self, lanes: L, squared: L::Vector) -> L::Vector {
        let mut weights = [0.0; LANES];
        for (weight, squared) in weights.iter_mut().zip(lanes.store(squared)) {
            if squared > self.least && squared < NOWHERE {
                *weight = squared.max(self.floor).powf(-0.5 * self.exponent);
            }
        }
        lanes.load(&weights)
    }
}

/// Squares of distances beyond this are those of points that only fill up.
const NOWHERE: f64 = 0.1 * FAR * FAR;

/// Squares of distances below this, 1e-15 mm for points in millimetres, are those of coincident points.
const COINCIDENT: f64 = 1e-30;

#[cfg(test)]
mod tests {
    use super::*;

    struct At(f64);

    impl Job for At {
        type Output = f64;
        fn run<L: Lanes, W: Weight>(self, lanes: L, weight: W) -> f64 {
            lanes.store(weight.of(lanes, lanes.splat(self.0)))[3]
        }
    }

    #[test]
    fn weights_are_powers_of_the_distance() {
        for exponent in [1.0, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0] {
            for nearest in [0.0, 0.5_f64] {
                let decay = Decay::new(exponent, nearest).unwrap();
                for distance in [1e-3, 0.3, 2.0, 1e3_f64] {
                    let wanted = distance.max(nearest).powf(-exponent);
                    let found = decay.run(At(distance * distance));
                    assert!((found / wanted - 1.0).abs() < 5e-15);
                }
                assert!((decay.run(At(0.0)) - decay.at_none()).abs() <= 5e-15 * decay.at_none());
            }
        }
        assert!(Decay::new(0.0, 0.0).is_err() && Decay::new(f64::NAN, 0.0).is_err());
        assert!(Decay::new(3.0, -1.0).is_err());
    }
}
