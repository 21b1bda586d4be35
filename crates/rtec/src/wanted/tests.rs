extern crate std;

use super::*;
use crate::built::{file, words};
use crate::image::Expected;

fn place(x: f64, z: f64, line: i32) -> Place {
    let mut place = Place {
        position: [x, 0.0, z],
        line: (line > 0).then_some(line),
        ..Place::default()
    };
    place.signal[0] = 20.0;
    place
}

#[test]
fn minus_the_error_of_the_segment_and_the_signals_of_the_moment() {
    let bytes = file(&words());
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let mut at = |z, signal: f64| {
        let mut place = place(25.0, z, 0);
        place.signal[0] = signal;
        image.wanted(&place).model
    };
    let near = |found: Vector, x: f64| {
        assert!((found[0] - x).abs() < 1e-15, "{found:?} {x}");
        assert_eq!([found[1], found[2]], [0.0, 0.0]);
    };
    near(at(-200.0, 20.0), -0.010);
    near(at(-200.0, 23.0), -0.013);
    near(at(-50.0, 23.0), -0.023);
    near(at(-50.0, 20.0), -0.020);
    near(at(-100.0, 20.0), -0.020);
    near(at(-9e9, 20.0), -0.010);
    near(at(9e9, 20.0), -0.020);
    assert!(at(-50.0, f64::NAN)[0].is_nan());
    near(at(-50.0, 20.0), -0.020); // nothing of it stays
}

#[test]
fn rows_by_line_and_place() {
    let bytes = file(&words());
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let mut at = |x, z, line| {
        let found = image.wanted(&place(x, z, line));
        assert_eq!(found.table[1], 0.0);
        (found.listed, found.on_path, found.table[0], found.table[2])
    };
    let near = |found: (bool, bool, f64, f64), x: f64, z: f64| {
        assert!(found.0 && found.1);
        assert!((found.2 - x).abs() < 1e-15 && (found.3 - z).abs() < 1e-15);
    };
    near(at(25.0, -5.0, 1), 0.011, 0.0005);
    near(at(25.05, -10.0, 1), 0.012, 0.001);
    near(at(25.0, -15.0, 2), 0.006, 0.0005);
    near(at(25.0, -25.0, 2), -0.005, 0.0);
    assert_eq!(at(25.0, -9.8, 2), (true, false, 0.0, 0.0)); // before its beginning, beyond the gate
    assert_eq!(at(25.0, -5.0, 3), (false, false, 0.0, 0.0));
    assert_eq!(at(25.0, -5.0, 0), (false, false, 0.0, 0.0));
    assert_eq!(at(f64::NAN, -5.0, 1), (true, false, 0.0, 0.0));
    near(at(25.0, -5.0, 1), 0.011, 0.0005);
}
