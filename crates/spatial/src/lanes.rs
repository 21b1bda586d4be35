//! Eight numbers at once: by AVX-512 or AVX2 where there is, else as arrays that the compiler puts into registers.

/// Numbers worked off at once.
pub(crate) const LANES: usize = 8;
/// As many numbers in memory.
pub(crate) type Eight = [f64; LANES];

/// Arithmetic on eight numbers.
pub(crate) trait Lanes: Copy {
    type Vector: Copy;
    /// Terms of the series of `inverse_root_power` that matter after `rough_inverse_root`.
    const TERMS: usize;
    fn load(self, values: &Eight) -> Self::Vector;
    fn store(self, values: Self::Vector) -> Eight;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn greater(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b + c`.
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `c − a b`.
    fn subtract_product(self, c: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// About `1/√a`; 0 where a is not above `least`.
    fn rough_inverse_root(self, a: Self::Vector, least: Self::Vector) -> Self::Vector;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.load(&[value; LANES])
    }

    #[inline(always)]
    fn sum(self, values: Self::Vector) -> f64 {
        self.store(values).iter().sum()
    }

    /// `a^(-K/2)` to the last digits; 0 where a is not above `least`.
    ///
    /// With y nearly `1/√a` and h = 1 − a y², it is y^K (1 − h)^(-K/2), of whose series some terms are taken.
    #[inline(always)]
    fn inverse_root_power<const K: u32>(
        self,
        a: Self::Vector,
        least: Self::Vector,
    ) -> Self::Vector {
        let y = self.rough_inverse_root(a, least);
        let off = self.subtract_product(self.splat(1.0), a, self.multiply(y, y));
        let mut power = y;
        for _ in 1..K {
            power = self.multiply(power, y);
        }
        let factors = series(0.5 * f64::from(K));
        let mut sum = self.splat(factors[Self::TERMS - 1]);
        for factor in factors[..Self::TERMS - 1].iter().rev() {
            sum = self.multiply_add(sum, off, self.splat(*factor));
        }
        self.multiply_add(power, self.multiply(sum, off), power)
    }
}

/// Factors of h, h², … in `(1 − h)^-s`.
#[inline(always)]
fn series(s: f64) -> [f64; 5] {
    let mut factors = [s; 5];
    for (before, n) in (1..5).zip([2.0, 3.0, 4.0, 5.0]) {
        factors[before] = factors[before - 1] * (s + n - 1.0) / n;
    }
    factors
}

/// Arrays.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> Eight {
    let mut values = [0.0; LANES];
    for (lane, value) in values.iter_mut().enumerate() {
        *value = f(lane);
    }
    values
}

impl Lanes for Portable {
    type Vector = Eight;
    const TERMS: usize = 2;

    #[inline(always)]
    fn load(self, values: &Eight) -> Eight {
        *values
    }

    #[inline(always)]
    fn store(self, values: Eight) -> Eight {
        values
    }

    #[inline(always)]
    fn add(self, a: Eight, b: Eight) -> Eight {
        each(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn subtract(self, a: Eight, b: Eight) -> Eight {
        each(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn multiply(self, a: Eight, b: Eight) -> Eight {
        each(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn greater(self, a: Eight, b: Eight) -> Eight {
        each(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn multiply_add(self, a: Eight, b: Eight, c: Eight) -> Eight {
        each(|k| a[k] * b[k] + c[k])
    }

    #[inline(always)]
    fn subtract_product(self, c: Eight, a: Eight, b: Eight) -> Eight {
        each(|k| c[k] - a[k] * b[k])
    }

    /// In single precision root and division are cheap: good for a from 1e-37 to 1e38, 0 beyond.
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // meant
    fn rough_inverse_root(self, a: Eight, least: Eight) -> Eight {
        let rough = each(|k| f64::from(1.0 / (a[k] as f32).sqrt()));
        each(|k| if a[k] > least[k] { rough[k] } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(lanes: impl Lanes) {
        let mut a = 1e-29;
        while a < 1e30 {
            let [a8, least] = [a, 1e-30].map(|value| lanes.splat(value));
            let root = lanes.store(lanes.inverse_root_power::<1>(a8, least));
            assert!((root[0] * f64::sqrt(a) - 1.0).abs() < 5e-16, "{a}");
            let power = lanes.store(lanes.inverse_root_power::<8>(a8, least));
            assert!((power[7] * a.powi(4) - 1.0).abs() < 4e-15, "{a}");
            a *= 1.007;
        }
        for (a, least) in [(0.0, 1e-30), (1e300, 1e-30), (2.0, 2.0)] {
            let found =
                lanes.store(lanes.inverse_root_power::<1>(lanes.splat(a), lanes.splat(least)));
            assert!(found[7] < 1e-37, "{a}");
        }
    }

    #[test]
    fn the_root_is_right_to_the_last_digits() {
        check(Portable);
        #[cfg(target_arch = "x86_64")]
        {
            pulp::x86::V3::try_new().into_iter().for_each(check);
            pulp::x86::V4::try_new().into_iter().for_each(check);
        }
    }
}
