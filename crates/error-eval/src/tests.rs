use crate::{Body, Model, ModelError, Way};

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
        None,
        [0.0, 0.0, 100.0],
        [0.0, 0.0, 1.0],
    )
    .unwrap();
    let bodies = [body];
    let model = Model::new(&bodies, [[0.0; 3], [3e-6, 0.0, 0.0], [0.0; 3]]);
    let error = model.error([110.0, 50.0, -20.0], [Way::Forward; 3]);
    assert!((error[0] - (0.001 + 2e-5 * 100.0 + 1e-4 * 80.0 + 3e-6 * 50.0)).abs() < 1e-15);
    assert_eq!((error[1], error[2]), (0.0, 0.0));
}

#[test]
fn segments_ways_and_ends() {
    let forward = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ];
    let back = [
        [5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [6.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ];
    let body = Body::new(
        1,
        &[0.0, 1.0, 2.0],
        1,
        &forward,
        Some(&back),
        [0.0; 3],
        [0.0; 3],
    )
    .unwrap();
    let bodies = [body];
    let model = Model::new(&bodies, [[0.0; 3]; 3]);
    let at = |y, way| model.error([0.0, y, 0.0], [way; 3])[0];
    assert_eq!(
        [
            at(-9.0, Way::Forward),
            at(0.5, Way::Forward),
            at(1.0, Way::Forward)
        ],
        [1.0, 1.0, 2.0]
    );
    assert_eq!([at(99.0, Way::Return), at(0.5, Way::Unknown)], [6.0, 3.0]);
    assert!(at(f64::NAN, Way::Forward).is_nan());
    let mut out = [9.0; 7];
    model.errors(
        &[0.0, 0.5, 0.0, 0.0, 2.0, 0.0],
        Some(&[1.0, -1.0, 1.0, 0.0, 0.0, 0.0]),
        &mut out,
    );
    assert_eq!(out, [5.0, 0.0, 0.0, 4.0, 0.0, 0.0, 9.0]);
}

#[test]
fn numbers_that_do_not_belong_together() {
    let refuse = |axis, breaks: &[f64], powers, rows: &[[f64; 6]]| {
        Body::new(axis, breaks, powers, rows, None, [0.0; 3], [0.0; 3]).unwrap_err()
    };
    assert_eq!(refuse(0, &[1.0], 1, &[NONE]), ModelError::Breaks);
    assert_eq!(refuse(0, &[], 1, &[]), ModelError::Breaks);
    assert_eq!(refuse(0, &[1.0, 1.0], 1, &[NONE]), ModelError::Breaks);
    assert_eq!(refuse(0, &[0.0, f64::NAN], 1, &[NONE]), ModelError::Breaks);
    assert_eq!(refuse(0, &[0.0, 1.0], 2, &[NONE]), ModelError::Coefficients);
    assert_eq!(
        refuse(0, &[0.0, 1.0], usize::MAX, &[NONE]),
        ModelError::Coefficients
    );
    assert_eq!(refuse(3, &[0.0, 1.0], 1, &[NONE]), ModelError::Axis);
}
