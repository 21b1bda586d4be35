extern crate std;

use std::vec::Vec;

use crate::{Body, Model, ModelError};

const NONE: [f64; 6] = [0.0; 6];

#[test]
fn a_displacement_and_a_rotation_about_an_arm() {
    // EXX = 0.001 + 2e-5 (x − 10), EBX = 1e-4; the arm is (0, 0, 100) and Z adds to it
    let rows = [
        [0.001, 0.0, 0.0, 0.0, 1e-4, 0.0],
        [2e-5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ];
    let body = Body::new(
        0,
        &[10.0, 510.0],
        2,
        &rows,
        [0.0, 0.0, 100.0],
        [0.0, 0.0, 1.0],
    )
    .unwrap();
    let bodies = [body];
    let model = Model::new(&bodies, [[0.0; 3], [3e-6, 0.0, 0.0], [0.0; 3]]);
    let error = model.error([110.0, 50.0, -20.0], [1.0; 3]);
    assert!((error[0] - (0.001 + 2e-5 * 100.0 + 1e-4 * 80.0 + 3e-6 * 50.0)).abs() < 1e-15);
    assert_eq!((error[1], error[2]), (0.0, 0.0));
}

#[test]
fn segments_ways_and_ends() {
    // in the two segments: mean 3, 4; forward 1, 2; return 5, 6
    let rows = [3.0, 4.0, 1.0, 2.0, 5.0, 6.0].map(|x| [x, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let body = Body::new(1, &[0.0, 1.0, 2.0], 1, &rows, [0.0; 3], [0.0; 3]).unwrap();
    let bodies = [body];
    let model = Model::new(&bodies, [[0.0; 3]; 3]);
    let at = |y, travel| model.error([0.0, y, 0.0], [travel; 3])[0];
    assert_eq!([at(-9.0, 1.0), at(0.5, 1.0), at(1.0, 1.0)], [1.0, 1.0, 2.0]);
    assert_eq!([at(99.0, -1.0), at(0.5, 0.0)], [6.0, 3.0]);
    assert!(at(f64::NAN, 1.0).is_nan());
    let mut out = [9.0; 6];
    model.errors(&[0.0, 0.5, 0.0, 0.0, 2.0, 0.0], &[1.0, -1.0, 1.0], &mut out);
    assert_eq!(out, [5.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
}

#[test]
fn numbers_that_do_not_belong_together() {
    let refuse = |axis, breaks: &[f64], powers, rows: &[[f64; 6]]| {
        Body::new(axis, breaks, powers, rows, [0.0; 3], [0.0; 3]).unwrap_err()
    };
    assert_eq!(refuse(0, &[1.0], 1, &[NONE]), ModelError::Breaks);
    assert_eq!(refuse(0, &[], 1, &[]), ModelError::Breaks);
    assert_eq!(refuse(0, &[1.0, 1.0], 1, &[NONE]), ModelError::Breaks);
    assert_eq!(refuse(0, &[0.0, f64::NAN], 1, &[NONE]), ModelError::Breaks);
    for breaks in [[0.0, 1.0, 0.5], [0.0, -1.0, 1.0]] {
        assert_eq!(refuse(0, &breaks, 1, &[NONE; 2]), ModelError::Breaks);
    }
    assert_eq!(refuse(0, &[0.0, 1.0], 2, &[NONE]), ModelError::Coefficients);
    assert_eq!(refuse(0, &[0.0, 1.0], 0, &[]), ModelError::Coefficients);
    assert_eq!(
        refuse(0, &[0.0, 1.0], usize::MAX, &[NONE]),
        ModelError::Coefficients
    );
    assert_eq!(
        refuse(0, &[0.0, 1.0], 1, &[NONE; 2]),
        ModelError::Coefficients
    );
    assert_eq!(refuse(3, &[0.0, 1.0], 1, &[NONE]), ModelError::Axis);
}

#[test]
fn many_points_are_one_point_many_times() {
    // 43 points: whole registers of neighbours in one segment, registers over several, and a rest
    let rows: Vec<[f64; 6]> = (0..3 * 5 * 4)
        .map(|k| [1.0, -0.7, 0.3, 0.01, 0.02, -0.03].map(|v| v / f64::from(k + 1)))
        .collect();
    let body = |axis, breaks, powers, rows| {
        let (arm, carries) = ([9.0, -5.0, 70.0], [1.0, 0.0, 1.0]);
        Body::new(axis, breaks, powers, rows, arm, carries).unwrap()
    };
    let breaks = [0.0, 3.0, 4.0, 20.0, 30.0, 35.0];
    let bodies = [
        body(0, &breaks, 4, &rows[..]),
        body(1, &[0.0, 9.0], 3, &rows[..3]),
        body(2, &[-5.0, 1.0, 2.0], 5, &rows[..30]),
    ];
    let model = Model::new(&bodies, [[1e-5, 0.0, 2e-5], [0.0; 3], [3e-5, 1e-4, 0.0]]);
    let z = |k: f64| if k == 17.0 { f64::NAN } else { k * 0.1 };
    let points: Vec<f64> = (0..43)
        .map(f64::from)
        .flat_map(|k| [k, 9.0 - k * 0.4, z(k)])
        .collect();
    let travel: Vec<f64> = (0..120).map(|k| f64::from(k * k % 7 % 3) - 1.0).collect();
    let mut out = [9.0; 129];
    model.errors(&points, &travel, &mut out);
    for (k, found) in out.chunks_exact(3).enumerate() {
        let at = |from: &[f64], i: usize| from.get(3 * k + i).copied().unwrap_or(0.0);
        let [q, came] = [&points, &travel].map(|from| [0, 1, 2].map(|i| at(from, i)));
        let one = model.error(q, came);
        for (one, found) in one.iter().zip(found) {
            assert!(
                k == 17 || (one - found).abs() <= 4e-16 * one.abs().max(100.0),
                "{k}: {one} {found}"
            );
            assert_eq!(one.is_nan(), k == 17);
        }
    }
}
