//! Vector registers as the numbers in them.

use pulp::{bytemuck, Simd};

/// The numbers of a register.
#[inline(always)]
pub(crate) fn lanes<S: Simd>(values: &S::f64s) -> &[f64] {
    bytemuck::cast_slice(core::slice::from_ref(values))
}

/// One of them, 0 where there is none.
#[inline(always)]
pub(crate) fn one(lanes: &[f64], k: usize) -> f64 {
    lanes.get(k).copied().unwrap_or(0.0)
}

/// Sets one of them.
#[inline(always)]
pub(crate) fn set<S: Simd>(values: &mut S::f64s, k: usize, value: f64) {
    let lanes = bytemuck::cast_slice_mut(core::slice::from_mut(values));
    if let Some(lane) = lanes.get_mut(k) {
        *lane = value;
    }
}

/// Whether a condition holds in every lane.
#[inline(always)]
pub(crate) fn all<S: Simd>(simd: S, mask: S::m64s) -> bool {
    simd.first_true_m64s(simd.not_m64s(mask)) == S::F64_LANES
}

/// X, Y, Z of points, three numbers each, as three registers; 0 where there are fewer points than lanes.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, points: &[f64]) -> [S::f64s; 3] {
    let mut parts = points.chunks(S::F64_LANES);
    let mut rows = [simd.splat_f64s(0.0); 3];
    for row in &mut rows {
        *row = simd.partial_load_f64s(parts.next().unwrap_or(&[]));
    }
    simd.deinterleave_shfl_f64s(rows)
}

/// The way back, of so many points as there is room for.
#[inline(always)]
pub(crate) fn write<S: Simd>(simd: S, columns: [S::f64s; 3], points: &mut [f64]) {
    let rows = simd.interleave_shfl_f64s(columns);
    for (part, row) in points.chunks_mut(S::F64_LANES).zip(rows) {
        simd.partial_store_f64s(part, row);
    }
}
