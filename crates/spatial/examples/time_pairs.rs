//! Times the sums over pairs, and those far from each other together: `cargo run --release --example time_pairs`.

use std::time::Instant;

use spatial::{far_product, pair_sums, Decay, Points, Refused};

fn main() -> Result<(), Refused> {
    let decay = Decay::new(3.0, 0.0)?;
    for n in [625_u32, 2_500, 10_000, 40_000] {
        let (points, values) = sheet(n)?;
        timed(n, || pair_sums(&points, &values, decay).map(|_| ()))?;
    }
    let (points, values) = sheet(1_000_000)?;
    timed(1_000_000, || {
        far_product(&points, &values, 1, decay, 3.0).map(|_| ())
    })
}

fn sheet(n: u32) -> Result<(Points, Vec<f64>), Refused> {
    let place = |k| {
        let (x, y) = (
            50.0 * (f64::from(k) * 0.754_877_666).fract(),
            50.0 * (f64::from(k) * 0.569_840_291).fract(),
        );
        [x, y, 4.0 * (x / 14.0).sin() * (y / 17.0).cos()]
    };
    let rows: Vec<[f64; 3]> = (0..n).map(place).collect();
    Ok((
        Points::new(&rows)?,
        rows.iter().map(|row| row[0] * row[1]).collect(),
    ))
}

fn timed(n: u32, work: impl Fn() -> Result<(), Refused>) -> Result<(), Refused> {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        work()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{n:>7} points: {:.3} ms", best * 1e3);
    Ok(())
}
