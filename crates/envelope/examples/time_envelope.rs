//! Nanoseconds a ray: 10⁴ rays asked of 10⁴ segments of a quarter circle, smooth and with noise; the sweep made anew.

use envelope::{Nose, Point, Ray, Sweep};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;
use std::time::Instant;

const SEGMENTS: usize = 10_000;

fn main() {
    for (words, noise) in [("smooth", 0.0), ("noise of 1 µm", 1e-3)] {
        let directions: Vec<Point> = (0..=SEGMENTS)
            .map(|k| (FRAC_PI_2 * k as f64 / SEGMENTS as f64).sin_cos())
            .map(|(sine, cosine)| [cosine, sine])
            .collect();
        let mut state = 1_u64;
        let nodes: Vec<Point> = directions
            .iter()
            .map(|d| d.map(|part| 38.0 * part + noise * normal(&mut state)))
            .collect();
        let mut times: Vec<[f64; 2]> = (0..40)
            .filter_map(|_| {
                let nose = Nose::new(0.8, 0.0, 1.0, Vec::new()).ok()?;
                let begun = Instant::now();
                let sweep = Sweep::new(black_box(nodes.clone()), nose);
                let made = begun.elapsed();
                let rays = directions
                    .iter()
                    .map(|d| (Ray::new(d.map(|part| 37.2 * part), *d), 1.0));
                black_box(sweep.entries(rays, 1.0));
                Some([made, begun.elapsed()].map(|time| time.as_secs_f64() * 1e9 / SEGMENTS as f64))
            })
            .collect();
        times.sort_by(|a, b| a[1].total_cmp(&b[1]));
        println!(
            "{words}: least {:.0} ns a ray, {:.0} of them for the sweep; median {:.0}",
            times[0][1], times[0][0], times[20][1]
        );
    }
}

/// A sum of twelve uniform numbers, xorshift.
fn normal(state: &mut u64) -> f64 {
    let mut uniform = || {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}
