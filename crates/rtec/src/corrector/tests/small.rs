//! Rounding, the touch, and the direction of travel.

use super::*;
use std::vec;

#[test]
fn corrections_come_in_steps_of_the_resolution() {
    let mut bench = Bench::new();
    bench.settings.resolution_mm = 0.002;
    for (wanted, rounded) in [
        (0.0011, 0.0), // within 0.6 steps of nothing, which is held at first
        (0.0051, 0.006),
        (0.0029, 0.002),
        (-0.0051, -0.006),
        (0.0, 0.0),
        (0.0009, 0.0),
    ] {
        let mut image = stand_in(0, constant([wanted, 0.0, 0.0]));
        let said = bench.steps(&mut image, 20);
        assert!(
            (said.correction[0] - rounded).abs() < 1e-15,
            "{wanted}: {}",
            said.correction[0]
        );
        assert_eq!(said.phase, Phase::InForce as i32);
    }
}

#[test]
fn noise_at_an_edge_between_two_steps_does_not_move_the_drive() {
    let mut bench = Bench::new();
    bench.settings.resolution_mm = 0.002;
    let mut moves = vec![];
    for k in 0..200 {
        let noise = if k % 2 == 0 { 1e-4 } else { -1e-4 };
        let mut image = stand_in(0, constant([0.005 + noise, 0.0, 0.0]));
        bench.step(&mut image);
        moves.push(bench.said.correction[0]);
    }
    moves.dedup();
    assert!(moves.len() <= 3, "{moves:?}");
}

#[test]
fn another_resolution_leaves_no_odd_step() {
    for sign in [1.0, -1.0] {
        let mut bench = Bench::new();
        let mut image = stand_in(0, constant([sign * 0.0052, 0.0, 0.0]));
        for (resolution, rounded) in [
            (0.005, 0.005),
            (0.002, 0.006),
            (0.0, 0.0052),
            (1e-300, 0.0052),
        ] {
            bench.settings.resolution_mm = resolution;
            let said = bench.steps(&mut image, 10);
            assert!((said.correction[0] - sign * rounded).abs() < 1e-15);
        }
    }
}

#[test]
fn a_rounding_beyond_the_limit_is_refused_too() {
    let mut bench = Bench::new();
    (bench.settings.resolution_mm, bench.settings.limit_mm) = (0.01, 0.049);
    let mut image = stand_in(0, constant([0.048, 0.0, 0.0]));
    assert_eq!(bench.step(&mut image).fault, Fault::Limit as i32);
}

/// E(q) of a machine: 20 µm and 0.1 µm/mm.
fn error(q: f64) -> f64 {
    0.02 + 1e-4 * q
}

#[test]
fn the_latch_is_where_the_tool_was_with_the_correction_off_on_and_between() {
    for (probe_corrected, settling) in [(false, 30), (true, 30), (true, 3)] {
        let mut bench = Bench::new();
        bench.settings.probe_corrected = probe_corrected;
        (bench.inputs.probing, bench.inputs.program) = (true, 1);
        let mut image = stand_in(0, |place: &Place| Wanted {
            model: place.position.map(|q| -error(q - error(q))),
            table: place.line.map_or([0.0; AXES], |_| [0.05; AXES]),
            ..Wanted::default()
        });
        let mut tool = vec![];
        for k in 0..settling {
            bench.inputs.position = [0.0, 0.0, f64::from(k) * -0.05];
            let c = bench.step(&mut image).correction;
            let q = bench.inputs.position[2];
            tool.push(q + c[2] + error(q + c[2]));
        }
        let was_at = tool[tool.len() - 1];
        // The drive has moved on before the touch is seen, and it stays.
        bench.inputs.position[2] -= 0.05;
        bench.inputs.touch = true;
        let latch = bench.step(&mut image).latch[2];
        // E is asked where the whole correction leads: 20 µm away, where it is another by 2 nm.
        assert!((latch - was_at).abs() < 2.1e-6, "{latch} {was_at}");
        assert_eq!(bench.steps(&mut image, 5).latch[2], latch);
        bench.inputs.touch = false;
        assert_eq!(bench.step(&mut image).latch[2], latch);
        if probe_corrected && settling > 10 {
            assert!((latch - (f64::from(settling) - 1.0) * -0.05).abs() < 3e-6);
        }
    }
}

/// Directions that the image was asked with.
fn directions(bench: &mut Bench, positions: &[f64]) -> std::vec::Vec<f64> {
    let mut seen = vec![];
    let mut image = stand_in(0, |place: &Place| {
        seen.push(place.travel[0]);
        Wanted::default()
    });
    for q in positions {
        bench.inputs.position[0] = *q;
        bench.step(&mut image);
    }
    seen
}

#[test]
fn the_direction_of_travel_is_that_of_the_command_and_stays_while_it_stands() {
    let mut bench = Bench::new();
    let seen = directions(
        &mut bench,
        &[
            5.0,
            5.0,
            5.1,
            5.2,
            5.2,
            5.2 + 1e-14,
            5.2,
            5.1,
            5.1,
            5.1 + 2e-9,
        ],
    );
    assert_eq!(seen, [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0]);
}

#[test]
fn a_slow_axis_has_a_direction_too() {
    let mut bench = Bench::new();
    directions(&mut bench, &[5.0, 6.0]);
    let creep: std::vec::Vec<f64> = (0..40).map(|k| 6.0 - 1e-10 * f64::from(k)).collect();
    assert_eq!(directions(&mut bench, &creep).last(), Some(&-1.0));
}

#[test]
fn the_direction_survives_off_and_drives_off_but_not_homing() {
    let mut bench = Bench::new();
    directions(&mut bench, &[5.0, 6.0]);
    bench.inputs.enable = false;
    assert_eq!(directions(&mut bench, &[6.0]), [1.0]);
    // Without drives the command follows the feedback, which is noisy, and jumps to it when they come on.
    bench.inputs.machine_on = false;
    assert_eq!(directions(&mut bench, &[5.9, 5.8, 5.7]), [1.0; 3]);
    bench.inputs.machine_on = true;
    assert_eq!(directions(&mut bench, &[5.6, 5.6]), [1.0; 2]);
    bench.inputs.homed = false;
    assert_eq!(directions(&mut bench, &[5.6, 0.0]), [0.0; 2]);
    bench.inputs.homed = true;
    assert_eq!(directions(&mut bench, &[0.5, 0.4]), [0.0, -1.0]);
}

#[test]
fn readings_and_directions_are_all_that_an_off_corrector_remembers_of_an_image() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant([0.02; AXES]));
    bench.until(&mut image, Phase::InForce);
    bench.inputs.enable = false;
    bench.steps(&mut image, 10);
    let mut other = stand_in(0, constant([-0.01; AXES]));
    bench.inputs.enable = true;
    bench.until(&mut other, Phase::InForce);
    assert_eq!(bench.said.correction, [-0.01; AXES]);
}
