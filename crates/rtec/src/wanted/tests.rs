extern crate std;

use super::*;
use crate::built::{file, hash, words, BODY, ROWS, SLOPE};
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

/// An image of the same machine whose body errs by these six numbers everywhere, whatever the signal.
fn erring(six: [f64; 6]) -> std::vec::Vec<f64> {
    let mut words = words();
    let rows = BODY + 14;
    words[rows..rows + 6].copy_from_slice(&six);
    words[rows + 6..rows + 12].copy_from_slice(&six);
    words[rows + 13..rows + 25].fill(0.0);
    words
}

#[test]
fn rotations_have_the_arm_to_the_tool_point_less_the_offset_in_force() {
    // the arm (0, 0, 120 − 50) less (3, 5, 30) is (−3, −5, 40); r × arm by hand, and its negative wanted
    let bytes = file(&erring([0.0, 0.0, 0.0, 1e-3, 2e-3, -1e-3]));
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let mut at = place(25.0, -200.0, 0);
    at.tool_offset = [3.0, 5.0, 30.0];
    let found = image.wanted(&at).model;
    for (part, error) in found.into_iter().zip([0.075, -0.037, 0.001]) {
        assert!((part + error).abs() < 1e-15, "{found:?}");
    }
}

#[test]
fn squareness_grows_with_the_position_and_with_the_signal() {
    // X pushes Y by 20 µm a metre, and by 1 µm a metre more for each degree
    let mut words = erring([0.0; 6]);
    words[SLOPE + 1] = 2e-5;
    words[SLOPE + 9 + 1] = 1e-6;
    let bytes = file(&words);
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let mut at = place(25.0, -200.0, 0);
    for (signal, slope) in [(20.0, 2e-5), (23.0, 2.3e-5), (17.0, 1.7e-5)] {
        at.signal[0] = signal;
        let [x, y, z] = image.wanted(&at).model;
        assert_eq!([x, z], [0.0, 0.0]);
        assert!((y + 25.0 * slope).abs() < 1e-15, "{signal}: {y}");
    }
}

#[test]
fn the_error_is_that_of_the_place_where_the_machine_will_stand() {
    // E = 0.001 x: 25 + m is to be less than 25 by 0.001 (25 + m), and what is left is E (dE/dq)² = 0.025 · 1e-6
    let mut words = erring([0.0; 6]);
    words[SLOPE] = 1e-3;
    let bytes = file(&words);
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let [x, ..] = image.wanted(&place(25.0, -200.0, 0)).model;
    assert!((x + 0.025 / 1.001).abs() < 2.6e-8, "{x}");
}

#[test]
fn each_way_of_travel_has_its_own_polynomials_in_every_segment() {
    // EXZ = 0.001 w + 0.01 s + 1e-5 (1 + s) · (z − start of segment s), w = 0 not known, 1 forward, 2 return
    let mut words = erring([0.0; 6]);
    let rows = BODY + 14;
    let mut own = std::vec::Vec::new();
    for way in 0..3 {
        for segment in 0..2 {
            let (way, segment) = (f64::from(way), f64::from(segment));
            own.extend([0.001 * way + 0.01 * segment, 0.0, 0.0, 0.0, 0.0, 0.0]);
            own.extend([1e-5 * (1.0 + segment), 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
    }
    let mut dependent = std::vec![0.0; 1 + own.len()];
    dependent[0] = words[rows + 12];
    words.splice(rows..rows + 25, own.into_iter().chain(dependent));
    words[BODY + 2] = 3.0;
    words[BODY + 3] = 2.0;
    let bytes = file(&words);
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    for (way, travel) in [(1.0, 1.0), (2.0, -1.0), (0.0, 0.0), (2.0, -1.0), (1.0, 1.0)] {
        for (z, expected) in [(-200.0, 1e-3), (-100.0, 0.01), (-50.0, 0.011), (9.0, 0.012)] {
            let mut at = place(25.0, z, 0);
            at.travel = [-travel, -travel, travel];
            let x = image.wanted(&at).model[0];
            assert!((x + 0.001 * way + expected).abs() < 1e-15, "{way} {z}: {x}");
        }
    }
}

#[test]
fn between_rows_a_share_of_them_and_within_the_gate_beyond_their_ends_the_outermost() {
    let mut words = words();
    words[ROWS + 6] = -0.5; // the first line ends half a millimetre from its start
    let bytes = file(&words);
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    for (z, [dx, dz]) in [
        (-0.25, [0.011, 0.0005]),
        (-0.55, [0.012, 0.001]),
        (0.05, [0.010, 0.0]),
    ] {
        let found = image.wanted(&place(25.0, z, 1));
        assert!(found.on_path);
        assert!((found.table[0] - dx).abs() < 1e-15 && (found.table[2] - dz).abs() < 1e-15);
    }
}

#[test]
fn without_a_table_no_line_is_listed() {
    let mut words = words();
    words.truncate(BODY + 39);
    words.extend([0.0, 0.0]);
    let mut bytes = file(&words);
    bytes[224..256].fill(0);
    hash(&mut bytes);
    let mut image = Image::read(&bytes, Expected::default()).unwrap();
    let found = image.wanted(&place(25.0, -5.0, 1));
    assert!(!image.has_table() && !found.listed && !found.on_path);
    assert_eq!(found.table, [0.0; AXES]);
}
