//! Times the sums over pairs: `cargo run --release --example time_pairs`.

use std::time::Instant;

use spatial::{pair_sums, Exponent, Points, Refused};

fn main() -> Result<(), Refused> {
    for n in [625_u32, 2_500, 10_000, 40_000] {
        let rows: Vec<[f64; 3]> = (0..n)
            .map(|k| {
                let t = f64::from(k);
                [
                    (t * 0.7).sin() * 40.0,
                    (t * 1.3).cos() * 30.0,
                    (t * 0.1).sin(),
                ]
            })
            .collect();
        let values: Vec<f64> = rows.iter().map(|row| row[0] * row[1]).collect();
        let points = Points::new(&rows)?;
        let mut best = f64::INFINITY;
        for _ in 0..7 {
            let start = Instant::now();
            std::hint::black_box(pair_sums(&points, &values, Exponent::Three)?);
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{n:>6} points: {:.3} ms", best * 1e3);
    }
    Ok(())
}
