//! Values and derivatives of one Bézier piece.

use crate::Point3;

/// Highest degree.
pub(crate) const MOST: usize = 25;

/// A control point as (w x, w y, w z, w).
pub(crate) type Lifted = [f64; 4];

/// A surface at one place, with its derivatives by u and v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    pub(crate) point: Point3,
    pub(crate) du: Point3,
    pub(crate) dv: Point3,
    pub(crate) duu: Point3,
    pub(crate) duv: Point3,
    pub(crate) dvv: Point3,
}

/// Bernstein's polynomials of one degree at one place: of each its value, first and second derivative.
type Basis = [[f64; 3]; MOST + 1];

/// At a share of a piece of that width.
#[inline]
pub(crate) fn bernstein(degree: usize, share: f64, width: f64) -> Basis {
    let mut basis = [[0.0; 3]; MOST + 1];
    basis[0][0] = 1.0;
    for level in 1..=degree {
        let rate = level as f64 / width;
        for k in (0..=level).rev() {
            let below = if k > 0 { basis[k - 1] } else { [0.0; 3] };
            let own = basis[k];
            basis[k] = [
                own[0] + share * (below[0] - own[0]),
                rate * (below[0] - own[0]),
                rate * (below[1] - own[1]),
            ];
        }
    }
    basis
}

/// The piece with control points `net`, row by row, where the basis functions have those values.
#[inline]
pub(crate) fn evaluated(
    net: &[Lifted],
    degrees: [usize; 2],
    along: &Basis,
    across: &Basis,
) -> Local {
    let mut sums = [[0.0; 4]; 6];
    let orders = degrees.map(|degree| degree + 1);
    for (row, a) in net.chunks_exact(orders[1]).zip(along) {
        let mut within = [[0.0; 4]; 3];
        for (control, b) in row.iter().zip(across) {
            for (within, factor) in within.iter_mut().zip(b) {
                add(within, *factor, control);
            }
        }
        for (sum, (i, j)) in sums.iter_mut().zip(ORDERS) {
            add(sum, a[i], &within[j]);
        }
    }
    projected(&sums)
}

/// How often `Local`'s members are derived by u and by v.
const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

#[inline]
fn add(sum: &mut Lifted, factor: f64, values: &Lifted) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += factor * value;
    }
}

/// Derivatives of the quotient (x, y, z)/w from those of its parts.
#[inline]
fn projected([h, hu, hv, huu, huv, hvv]: &[Lifted; 6]) -> Local {
    let w = 1.0 / h[3];
    let axes = [0, 1, 2];
    let point = axes.map(|k| h[k] * w);
    let du = axes.map(|k| (hu[k] - hu[3] * point[k]) * w);
    let dv = axes.map(|k| (hv[k] - hv[3] * point[k]) * w);
    Local {
        point,
        du,
        dv,
        duu: axes.map(|k| (huu[k] - 2.0 * hu[3] * du[k] - huu[3] * point[k]) * w),
        duv: axes.map(|k| (huv[k] - hu[3] * dv[k] - hv[3] * du[k] - huv[3] * point[k]) * w),
        dvv: axes.map(|k| (hvv[k] - 2.0 * hv[3] * dv[k] - hvv[3] * point[k]) * w),
    }
}
