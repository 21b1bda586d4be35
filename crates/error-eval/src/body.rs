//! One carrier of errors: piecewise polynomials and an arm.

use crate::Vector;

/// Displacements along X, Y, Z in mm, then rotations about them in rad.
pub const COMPONENTS: usize = 6;

type Six = [f64; COMPONENTS];

/// Which way an axis came to where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From below.
    Forward,
    /// From above.
    Return,
    /// Not known: the mean of both.
    Unknown,
}

impl Way {
    /// Positive is forward, negative return, anything else unknown.
    #[inline]
    #[must_use]
    pub fn of_sign(sign: f64) -> Self {
        if sign > 0.0 {
            Self::Forward
        } else if sign < 0.0 {
            Self::Return
        } else {
            Self::Unknown
        }
    }
}

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
    inner: &'a [f64],
    starts: &'a [f64],
    powers: usize,
    forward: &'a [Six],
    back: Option<&'a [Six]>,
    arm: Vector,
    carries: Vector,
}

impl<'a> Body<'a> {
    /// A body that errs with the position of `axis` (0, 1, 2).
    ///
    /// `breaks` are the ends of the segments. `forward` holds for each segment its powers of the distance from the
    /// segment's start, lowest first; `back` the same for return travel where that differs. `arm` leads to the tool
    /// point with all axes at 0; `carries` is 1 for axes whose position adds to it, else 0.
    ///
    /// # Errors
    /// [`ModelError`] for numbers that do not belong together.
    pub fn new(
        axis: usize,
        breaks: &'a [f64],
        powers: usize,
        forward: &'a [Six],
        back: Option<&'a [Six]>,
        arm: Vector,
        carries: Vector,
    ) -> Result<Self, ModelError> {
        let ascending = breaks
            .iter()
            .zip(breaks.iter().skip(1))
            .all(|(a, b)| a < b && a.is_finite() && b.is_finite());
        let (Some(first), Some(last), true) = (breaks.first(), breaks.last(), ascending) else {
            return Err(ModelError::Breaks);
        };
        let segments = breaks.len() - 1;
        let wanted = segments.checked_mul(powers);
        let fits = |rows: &[Six]| Some(rows.len()) == wanted;
        if segments == 0 {
            return Err(ModelError::Breaks);
        }
        if powers == 0 || !fits(forward) || !back.is_none_or(fits) {
            return Err(ModelError::Coefficients);
        }
        if axis > 2 {
            return Err(ModelError::Axis);
        }
        Ok(Self {
            axis,
            first: *first,
            last: *last,
            inner: breaks.get(1..segments).unwrap_or(&[]),
            starts: breaks,
            powers,
            forward,
            back,
            arm,
            carries,
        })
    }

    /// d + r × arm. Beyond the breaks the value at the break holds.
    #[inline]
    pub(crate) fn error(&self, q: Vector, way: [Way; 3]) -> Vector {
        let position = q.get(self.axis).copied().unwrap_or(0.0);
        let way = way.get(self.axis).copied().unwrap_or(Way::Unknown);
        let [dx, dy, dz, rx, ry, rz] = self.six(position.max(self.first).min(self.last), way);
        let [x, y, z] = self.arm;
        let ([qx, qy, qz], [cx, cy, cz]) = (q, self.carries);
        let (x, y, z) = (x + cx * qx, y + cy * qy, z + cz * qz);
        [
            dx + ry * z - rz * y,
            dy + rz * x - rx * z,
            dz + rx * y - ry * x,
        ]
    }

    #[inline]
    fn six(&self, position: f64, way: Way) -> Six {
        let segment = self.inner.partition_point(|end| *end <= position);
        let step = position - self.starts.get(segment).copied().unwrap_or(0.0);
        let value = |rows| horner(rows, segment, self.powers, step);
        match (self.back, way) {
            (None, _) | (_, Way::Forward) => value(self.forward),
            (Some(back), Way::Return) => value(back),
            (Some(back), Way::Unknown) => {
                let mut mean = value(self.forward);
                for (a, b) in mean.iter_mut().zip(value(back)) {
                    *a = 0.5 * (*a + b);
                }
                mean
            }
        }
    }
}

#[inline]
fn horner(rows: &[Six], segment: usize, powers: usize, step: f64) -> Six {
    let start = segment * powers;
    let rows = rows.get(start..start + powers).unwrap_or(&[]);
    // cubics, the usual case, keep their six sums in registers
    match <&[Six; 4]>::try_from(rows) {
        Ok(cubic) => sum_of(cubic, step),
        Err(_) => sum_of(rows, step),
    }
}

#[inline(always)]
fn sum_of(rows: &[Six], step: f64) -> Six {
    let mut sum = [0.0; COMPONENTS];
    for row in rows.iter().rev() {
        for (value, power) in sum.iter_mut().zip(row) {
            *value = *value * step + power;
        }
    }
    sum
}
