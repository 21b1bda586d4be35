//! The weight of a pair, `d^-k`, from the square of its distance.

use crate::points::Refused;

/// The exponent k: small whole numbers are powers of the reciprocal distance, all others cost a logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// k = 1.
    One,
    /// k = 2.
    Two,
    /// k = 3.
    Three,
    /// k = 4.
    Four,
    /// Any other k > 0.
    Other(f64),
}

impl Exponent {
    /// Refuses exponents that are not positive.
    pub fn new(exponent: f64) -> Result<Self, Refused> {
        if !(exponent.is_finite() && exponent > 0.0) {
            return Err(Refused::Exponent { exponent });
        }
        Ok(match exponent {
            1.0 => Self::One,
            2.0 => Self::Two,
            3.0 => Self::Three,
            4.0 => Self::Four,
            other => Self::Other(other),
        })
    }
}

/// What is done with the weight function that an exponent stands for.
pub(crate) trait WithWeight {
    type Output;
    fn call<W: Weight>(self, weight: W) -> Self::Output;
}

impl Exponent {
    /// Chooses the weight function once, so that no pair has to.
    pub(crate) fn choose<F: WithWeight>(self, then: F) -> F::Output {
        match self {
            Self::One => then.call(Power::<1>),
            Self::Two => then.call(Power::<2>),
            Self::Three => then.call(Power::<3>),
            Self::Four => then.call(Power::<4>),
            Self::Other(exponent) => then.call(Real(exponent)),
        }
    }
}

/// Weight from the squared distance; none for coincident points.
pub(crate) trait Weight: Copy + Sync {
    fn of(self, squared: f64) -> f64;
}

/// `d^-K`.
#[derive(Clone, Copy)]
pub(crate) struct Power<const K: u32>;

impl<const K: u32> Weight for Power<K> {
    #[inline(always)]
    fn of(self, squared: f64) -> f64 {
        let near = reciprocal_root(squared);
        let mut weight = near;
        for _ in 1..K {
            weight *= near;
        }
        if squared > COINCIDENT {
            weight
        } else {
            0.0
        }
    }
}

/// `d^-k` for any k.
#[derive(Clone, Copy)]
pub(crate) struct Real(f64);

impl Weight for Real {
    #[inline(always)]
    fn of(self, squared: f64) -> f64 {
        if squared > COINCIDENT {
            squared.powf(-0.5 * self.0)
        } else {
            0.0
        }
    }
}

/// Squares of distances below this, 1e-15 mm for points in millimetres, are those of coincident points.
const COINCIDENT: f64 = 1e-30;

/// `1/√a` for a from 1e-37 on, nothing beyond 1e38: in single precision first, where root and division are cheap in
/// vector registers, then a step of third order that takes the error from 1e-7 to rounding.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // meant
fn reciprocal_root(a: f64) -> f64 {
    let y = f64::from(1.0 / (a as f32).sqrt());
    let off = 1.0 - a * y * y;
    y + y * off * (0.5 + 0.375 * off)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_right_to_the_last_digits() {
        let mut a = 1e-30;
        while a < 1e30 {
            assert!(
                (reciprocal_root(a) * f64::sqrt(a) - 1.0).abs() < 5e-16,
                "{a}"
            );
            a *= 1.007;
        }
    }

    #[test]
    fn powers_agree_with_the_general_one() {
        for squared in [1e-8, 0.3, 2.0, 1e6] {
            for (fast, exponent) in [
                (Power::<1>.of(squared), 1.0),
                (Power::<2>.of(squared), 2.0),
                (Power::<3>.of(squared), 3.0),
                (Power::<4>.of(squared), 4.0),
            ] {
                assert!((fast / Real(exponent).of(squared) - 1.0).abs() < 3e-15);
            }
        }
        assert_eq!(Power::<3>.of(0.0), 0.0);
        assert_eq!(Real(2.5).of(0.0), 0.0);
        assert!(Exponent::new(0.0).is_err() && Exponent::new(f64::NAN).is_err());
    }
}
