//! One carrier of errors: piecewise polynomials and an arm.

use pulp::{Scalar, Simd};

use crate::lanes::{all, lanes, one, set};
use crate::Vector;

/// Displacements along X, Y, Z in mm, then rotations about them in rad.
pub const COMPONENTS: usize = 6;

/// The six errors, or one power of each.
pub type Six = [f64; COMPONENTS];

/// Why numbers make no body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelError {
    /// Breaks fewer than two, not ascending, or not finite.
    Breaks,
    /// Not as many coefficients as segments times powers.
    Coefficients,
    /// No such axis.
    Axis,
}

/// Errors of one axis or spindle.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    axis: usize,
    first: f64,
    last: f64,
    breaks: &'a [f64],
    inner: &'a [f64],
    powers: usize,
    rows: &'a [Six],
    both_ways: bool,
    arm: Arm,
}

/// What leads from the frame in which errors turn to the tool point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arm {
    /// With all axes at 0, mm.
    pub start: Vector,
    /// 1 for axes whose position adds to it, else 0.
    pub carries: Vector,
}

impl Arm {
    /// The arm at machine position `q`.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, q: &[S::f64s; 3]) -> [S::f64s; 3] {
        let mut arm = *q;
        for ((part, carried), start) in arm.iter_mut().zip(self.carries).zip(self.start) {
            *part = simd.mul_add_e_f64s(simd.splat_f64s(carried), *part, simd.splat_f64s(start));
        }
        arm
    }
}

/// Adds d + r × arm to `error`, for errors on one segment: `rows` are powers of `step`, the distance from the segment's
/// start, lowest first; `q` is the machine's position. For who keeps the rows of a segment by himself.
#[inline(always)]
pub fn add_local(rows: &[Six], step: f64, arm: &Arm, q: &Vector, error: &mut Vector) {
    let simd = Scalar::new();
    add_turned(simd, horner(simd, rows, step), arm.at(simd, q), error);
}

impl<'a> Body<'a> {
    /// A body that errs with the position of `axis` (0, 1, 2).
    ///
    /// `breaks` are the ends of the segments. `rows` hold for each segment its powers of the distance from the
    /// segment's start, lowest first; where travel matters three such tables follow each other: for travel not known,
    /// forward, return. `arm` leads to the tool point with all axes at 0; `carries` is 1 for axes whose position adds
    /// to it, else 0.
    ///
    /// # Errors
    /// [`ModelError`] for numbers that do not belong together.
    pub fn new(
        axis: usize,
        breaks: &'a [f64],
        powers: usize,
        rows: &'a [Six],
        arm: Vector,
        carries: Vector,
    ) -> Result<Self, ModelError> {
        let rising = |(a, b): (&f64, &f64)| a < b && a.is_finite() && b.is_finite();
        let ascending = breaks.iter().zip(breaks.iter().skip(1)).all(rising);
        let ([first, inner @ .., last], true) = (breaks, ascending) else {
            return Err(ModelError::Breaks);
        };
        let table = (inner.len() + 1).checked_mul(powers);
        let both_ways = table.and_then(|rows| rows.checked_mul(3)) == Some(rows.len());
        if powers == 0 || !both_ways && table != Some(rows.len()) {
            return Err(ModelError::Coefficients);
        }
        if axis > 2 {
            return Err(ModelError::Axis);
        }
        let (first, last) = (*first, *last);
        Ok(Self {
            axis,
            first,
            last,
            breaks,
            inner,
            powers,
            rows,
            both_ways,
            arm: Arm {
                start: arm,
                carries,
            },
        })
    }

    /// Adds d + r × arm to `error`. Beyond the breaks the value at the break holds.
    #[inline(always)]
    pub(crate) fn add_error<S: Simd>(
        &self,
        simd: S,
        q: &[S::f64s; 3],
        travel: &[S::f64s; 3],
        error: &mut [S::f64s; 3],
    ) {
        let (Some(at), Some(travel)) = (q.get(self.axis), travel.get(self.axis)) else {
            return;
        };
        let above = simd.max_f64s(*at, simd.splat_f64s(self.first));
        let at = simd.min_f64s(above, simd.splat_f64s(self.last));
        let six = self.six(simd, at, *travel);
        add_turned(simd, six, self.arm.at(simd, q), error);
    }

    /// The six errors: all lanes at once where they share a polynomial, as neighbours mostly do.
    #[inline(always)]
    fn six<S: Simd>(&self, simd: S, at: S::f64s, travel: S::f64s) -> [S::f64s; COMPONENTS] {
        let (positions, ways) = (lanes::<S>(&at), lanes::<S>(&travel));
        let first = (one(positions, 0), one(ways, 0));
        if S::IS_SCALAR || self.share(simd, first, at, travel) {
            return self.sums(simd, first, at);
        }
        let mut six = [simd.splat_f64s(0.0); COMPONENTS];
        for k in 0..S::F64_LANES {
            let own = (one(positions, k), one(ways, k));
            let found = self.sums(Scalar::new(), own, own.0);
            for (six, found) in six.iter_mut().zip(found) {
                set::<S>(six, k, found);
            }
        }
        six
    }

    #[inline(always)]
    fn segment(&self, at: f64) -> usize {
        self.inner.partition_point(|end| *end <= at)
    }

    /// Whether all lie in the segment of the first and came the same way.
    #[inline(always)]
    fn share<S: Simd>(&self, simd: S, first: (f64, f64), at: S::f64s, travel: S::f64s) -> bool {
        let segment = self.segment(first.0);
        let low = self.breaks.get(segment).copied().unwrap_or(0.0);
        let high = self.inner.get(segment).copied().unwrap_or(f64::INFINITY);
        let from = simd.greater_than_or_equal_f64s(at, simd.splat_f64s(low));
        let to = simd.less_than_f64s(at, simd.splat_f64s(high));
        let ways = simd.equal_f64s(travel, simd.splat_f64s(first.1));
        all(simd, simd.and_m64s(from, to)) && (!self.both_ways || all(simd, ways))
    }

    /// Values at `at` of the polynomials that hold at a position come to that way.
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        (position, way): (f64, f64),
        at: S::f64s,
    ) -> [S::f64s; COMPONENTS] {
        let segment = self.segment(position);
        let start = self.breaks.get(segment).copied().unwrap_or(0.0);
        let table = match self.both_ways {
            true if way > 0.0 => 1,
            true if way < 0.0 => 2,
            _ => 0,
        };
        let first = (table * (self.inner.len() + 1) + segment) * self.powers;
        let rows = self.rows.get(first..first + self.powers).unwrap_or(&[]);
        horner(simd, rows, simd.sub_f64s(at, simd.splat_f64s(start)))
    }
}

/// Adds d + r × arm.
#[inline(always)]
fn add_turned<S: Simd>(
    simd: S,
    [dx, dy, dz, rx, ry, rz]: [S::f64s; COMPONENTS],
    [x, y, z]: [S::f64s; 3],
    error: &mut [S::f64s; 3],
) {
    let parts = [(dx, ry, z, rz, y), (dy, rz, x, rx, z), (dz, rx, y, ry, x)];
    for (error, (d, a, b, c, e)) in error.iter_mut().zip(parts) {
        let turned = simd.mul_add_e_f64s(a, b, simd.neg_f64s(simd.mul_f64s(c, e)));
        *error = simd.add_f64s(*error, simd.add_f64s(d, turned));
    }
}

#[inline(always)]
fn horner<S: Simd>(simd: S, rows: &[Six], step: S::f64s) -> [S::f64s; COMPONENTS] {
    // cubics, the usual case, without a loop
    match <&[Six; 4]>::try_from(rows) {
        Ok(cubic) => sums(simd, cubic, step),
        Err(_) => sums(simd, rows, step),
    }
}

#[inline(always)]
fn sums<S: Simd>(simd: S, rows: &[Six], step: S::f64s) -> [S::f64s; COMPONENTS] {
    let mut sums = [simd.splat_f64s(0.0); COMPONENTS];
    for row in rows.iter().rev() {
        for (sum, power) in sums.iter_mut().zip(row) {
            *sum = simd.mul_add_e_f64s(*sum, step, simd.splat_f64s(*power));
        }
    }
    sums
}
