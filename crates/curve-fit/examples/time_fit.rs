//! Times the kernel alone: microseconds a fit, median of many, knots at every third point.

use curve_fit::{fit, EndConditions, SplineSpace};
use std::time::Instant;

fn main() {
    for n in [32_usize, 1000] {
        let length = 58.0;
        let points: Vec<f64> = (0..n)
            .map(|i| length * (i as f64 + 0.5) / n as f64)
            .collect();
        let values: Vec<f64> = points.iter().map(|s| 0.01 * (s * 0.3).sin()).collect();
        let knots: Vec<f64> = points
            .iter()
            .copied()
            .skip(2)
            .step_by(3)
            .filter(|k| *k < points[n - 1])
            .collect();
        let ends = EndConditions {
            start_value: Some(0.001),
            start_slope: Some(0.0),
            end_value: Some(-0.009),
            end_slope: Some(0.0),
        };
        let mut times: Vec<f64> = (0..2000)
            .map(|_| {
                let begin = Instant::now();
                let fitted = SplineSpace::new(&knots, length, 3)
                    .and_then(|s| fit(&s, &points, &values, &[], &ends));
                std::hint::black_box(fitted.is_ok());
                begin.elapsed().as_secs_f64() * 1e6
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("{n} {:.2}", times[times.len() / 2]);
    }
}
