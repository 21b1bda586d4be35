//! Two evaluations of three axes with cubics, as a fixed point of two steps asks them: median, 99 % and 99.9 % of the clock's own
//! time, then of the calls, in ns, as JSON. For benches/realtime_core.py.

use error_eval::{Body, Model};
use std::hint::black_box;
use std::time::Instant;

const CALLS: u32 = 300_000;

fn main() {
    let rows: Vec<[f64; 6]> = (0..36)
        .map(|k| [1e-2, 1e-4, -1e-6, 1e-8, 2e-8, 1e-9].map(|v| v / f64::from(k + 1)))
        .collect();
    let breaks = [-300.0, -200.0, -100.0, 0.0];
    let bodies: Vec<Body<'_>> = (0..3)
        .filter_map(|axis| Body::new(axis, &breaks, 4, &rows, [10.0, -20.0, 150.0], [1.0; 3]).ok())
        .collect();
    let model = Model::new(&bodies, [[1e-5; 3]; 3]);
    let clock = sorted(|_| ());
    let twice = sorted(|k| {
        let q = [-150.0, -150.0, f64::from(k % 5900) * -0.05];
        let mut at = black_box(q);
        for _ in 0..2 {
            let error = model.error(at, [1.0, -1.0, 1.0]);
            for ((at, q), error) in at.iter_mut().zip(q).zip(error) {
                *at = q - error;
            }
        }
        black_box(at);
    });
    println!("[{}, {}]", shown(&clock), shown(&twice));
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

fn shown(times: &[u128]) -> String {
    let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
    format!("[{}, {}, {}]", at(0.5), at(0.99), at(0.999))
}
