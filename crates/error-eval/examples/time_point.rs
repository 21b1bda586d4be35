//! How long one evaluation takes: a 21-term model with three segments an axis, a million calls, each timed by itself.
//!
//! The clock's own time is in every figure, and said. For a quiet core: `taskset -c 1 chrt -f 50` before the command; what is
//! not quiet shows at the far end, where the core was taken away.

use error_eval::{Body, Model};
use std::hint::black_box;
use std::time::Instant;

const CALLS: u32 = 1_000_000;
const WIDTH: f64 = 60.0;

fn main() {
    let rows: Vec<[f64; 6]> = (0..36)
        .map(|k| [1e-3, 2e-5, -3e-8, 1e-6, 2e-8, 1e-9].map(|v| v / f64::from(k + 1)))
        .collect();
    let breaks = [0.0, 170.0, 330.0, 500.0];
    let arm = ([10.0, -20.0, 150.0], [1.0, 1.0, 1.0]);
    let bodies: Vec<Body<'_>> = (0..3)
        .filter_map(|axis| Body::new(axis, &breaks, 4, &rows, arm.0, arm.1).ok())
        .collect();
    let model = Model::new(&bodies, [[0.0; 3], [1e-5, 0.0, 0.0], [2e-5, 3e-5, 0.0]]);
    let clock = sorted(|_| ());
    let point = sorted(|k| {
        let q = [f64::from(k % 100) * 5.0, f64::from(k % 499), 77.0];
        black_box(model.error(black_box(q), [1.0, -1.0, 1.0]));
    });
    println!(
        "ns a call, the clock's own {} among them:",
        share(&clock, 0.5)
    );
    for part in [0.5, 0.9, 0.99, 0.999, 0.9999, 1.0] {
        println!("{:8.2} % within {:>8}", 100.0 * part, share(&point, part));
    }
    histogram(&point);
}

/// Nanoseconds of every call, ascending.
fn sorted(mut call: impl FnMut(u32)) -> Vec<u128> {
    let mut times: Vec<u128> = (0..CALLS)
        .map(|k| {
            let start = Instant::now();
            call(k);
            start.elapsed().as_nanos()
        })
        .collect();
    times.sort_unstable();
    times
}

fn share(times: &[u128], part: f64) -> u128 {
    times[(part * (times.len() - 1) as f64) as usize]
}

/// Calls by powers of two; the bars are logarithmic, so that a single one is seen.
fn histogram(times: &[u128]) {
    let most = times[times.len() - 1];
    let mut from = 0;
    for power in 4.. {
        let to = 1_u128 << power;
        let count =
            times.partition_point(|time| *time < to) - times.partition_point(|time| *time < from);
        if count > 0 {
            let bar = (WIDTH * (1.0 + count as f64).ln() / f64::from(CALLS).ln()) as usize;
            println!(
                "{from:>9} to {to:>9} ns {count:>9} {}",
                "#".repeat(bar.max(1))
            );
        }
        if to > most {
            return;
        }
        from = to;
    }
}
