//! How a correction changes: by the slew at most, and in steps of the drive's resolution.

use error_eval::Vector;

/// A rounded correction stays while what is wanted is within this part of a step of it, so that noise at an edge between
/// two steps does not move the drive to and fro.
const STAYS_WITHIN: f64 = 0.6;
/// From here on a number of steps has no fraction, or does not fit.
const MOST_STEPS: f64 = 4_503_599_627_370_496.0;

/// A slew that may be used, mm/s.
pub(super) fn usable(slew: f64) -> Option<f64> {
    (slew.is_finite() && slew > 0.0).then_some(slew)
}

/// What is left of a way by rounding: that much of a step may be added to it.
const HAIR: f64 = 1e-9;

/// `from`, moved towards `to` by at most `most` on each axis.
pub(super) fn slewed(from: &Vector, to: &Vector, most: f64) -> Vector {
    let mut now = *from;
    for (value, to) in now.iter_mut().zip(to) {
        let way = to - *value;
        *value = if way.abs() <= most * (1.0 + HAIR) {
            *to
        } else {
            *value + way.max(-most).min(most)
        };
    }
    now
}

/// `wanted` in whole steps of `resolution`; `held` is what it was before.
pub(super) fn rounded(wanted: &Vector, held: &Vector, resolution: f64) -> Vector {
    let mut steps = *wanted;
    if resolution > 0.0 {
        for (value, held) in steps.iter_mut().zip(held) {
            let stays = (*value - held).abs() <= STAYS_WITHIN * resolution
                && whole(*held, resolution) == *held;
            *value = if stays {
                *held
            } else {
                whole(*value, resolution)
            };
        }
    }
    steps
}

fn whole(value: f64, resolution: f64) -> f64 {
    let steps = value / resolution;
    if steps.abs() >= MOST_STEPS {
        return value;
    }
    let half = if steps < 0.0 { -0.5 } else { 0.5 };
    // A cast cuts off towards zero; `round` is not in `core`.
    (steps + half) as i64 as f64 * resolution
}
