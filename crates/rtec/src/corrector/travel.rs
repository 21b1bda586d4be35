//! Whether the drive stays inside its travel: motion's soft limits see the command, not what is added to it.
//!
//! A fault takes c / slew to bring the correction c to zero, and a command may come nearer to the end meanwhile. It must
//! come to rest there, as it is inside itself, and it accelerates at a at most. The quickest such way, from speed v over the
//! room r: up to u with u² = a r + v²/2, then down to rest. c shrinks by the slew s. At the time τ before rest the
//! command has a τ²/2 of room left, the correction c − s (T − τ) with T = (2 u − v) / a; it fits for every τ where
//! c ≤ s T − s²/(2 a), that is where u ≥ (a c / s + s / 2 + v) / 2. Where u ≤ s the ramp outruns the command from the start.

use super::movement::Axis;
use crate::wanted::AXES;
use error_eval::Vector;

/// A command may accelerate this much though it was not seen to, mm/s².
const LEAST_ACCELERATION: f64 = 1000.0;
/// What is seen beyond this is a jump of the command, mm/s².
const MOST_ACCELERATION: f64 = 20_000.0;

/// Command and drive may be beyond an end of the travel by this, mm. LinuxCNC counts a joint as arrived within a T² / 1000 of
/// its target (`TINY_DP` in simple_tp.c): 2e-5 mm at [`MOST_ACCELERATION`] and 1 ms. A joint whose home is the end of its
/// travel stands beyond that end by as much.
const TOLERANCE: f64 = 1e-4;

/// How fast a correction goes in a fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    pub(super) slew_mm_per_s: f64,
    pub(super) period_s: f64,
}

/// Whether `correction` may be added at `position`: every drive is inside, and will be if a fault comes in the next period.
pub(super) fn stays_inside(
    position: &Vector,
    correction: &Vector,
    ends: &[(f64, f64); AXES],
    axes: &[Axis; AXES],
    ramp: Ramp,
) -> bool {
    let place = position.iter().zip(correction);
    place
        .zip(ends)
        .zip(axes)
        .all(|(((q, c), (low, high)), axis)| {
            let (low, high) = (low - TOLERANCE, high + TOLERANCE);
            let inside = low <= *q && *q <= high;
            let fits = if *c > 0.0 {
                room_is_enough(high - q, *c, axis.velocity, axis.acceleration, ramp)
            } else {
                room_is_enough(q - low, -c, -axis.velocity, axis.acceleration, ramp)
            };
            inside && fits
        })
}

/// Towards one end: room and correction in mm, not negative; velocity towards the end.
fn room_is_enough(room: f64, correction: f64, velocity: f64, seen: f64, ramp: Ramp) -> bool {
    if correction == 0.0 {
        return true;
    }
    let slew = ramp.slew_mm_per_s;
    let driven = MOST_ACCELERATION.min(seen.max(LEAST_ACCELERATION));
    // The velocity is that of half a period ago.
    let speed = (velocity + driven * ramp.period_s / 2.0).max(0.0);
    // A command that comes to rest inside can brake at least like that.
    let acceleration = driven.max(speed * speed / (2.0 * room));
    let peak_squared = acceleration * room + speed * speed / 2.0;
    let peak_needed = (acceleration * correction / slew + slew / 2.0 + speed) / 2.0;
    room >= correction && (peak_squared <= slew * slew || peak_squared >= peak_needed * peak_needed)
}
