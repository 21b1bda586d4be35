//! Nanoseconds a point of a 21-term model with three segments an axis, one call after the other: median and p99.9.

use error_eval::{Body, Model};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let rows: Vec<[f64; 6]> = (0..36)
        .map(|k| [1e-3, 2e-5, -3e-8, 1e-6, 2e-8, 1e-9].map(|v| v / f64::from(k + 1)))
        .collect();
    let breaks = [0.0, 170.0, 330.0, 500.0];
    let bodies: Vec<Body<'_>> = (0..3)
        .filter_map(|axis| {
            Body::new(
                axis,
                &breaks,
                4,
                &rows,
                [10.0, -20.0, 150.0],
                [1.0, 1.0, 1.0],
            )
            .ok()
        })
        .collect();
    let model = Model::new(&bodies, [[0.0; 3], [1e-5, 0.0, 0.0], [2e-5, 3e-5, 0.0]]);
    let mut times: Vec<f64> = (0..20_000)
        .map(|k| {
            let start = Instant::now();
            for i in 0..100 {
                let q = [f64::from(i) * 5.0, f64::from(k % 500), 77.0];
                black_box(model.error(black_box(q), [1.0, -1.0, 1.0]));
            }
            start.elapsed().as_secs_f64() * 1e7
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
    println!(
        "{:.1} ns a point, 99.9 % of hundreds below {:.1} ns a point",
        at(0.5),
        at(0.999)
    );
}
