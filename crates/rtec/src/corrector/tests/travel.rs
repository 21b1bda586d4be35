//! The drive stays inside its travel while the command does.

use super::virtual_machine::{Dice, Planner};
use super::*;

const END: f64 = 200.0;
/// How far beyond the end command and drive may be, mm.
const BEYOND: f64 = 1e-4;

/// Moves along X to a target with `model` in force; whether a fault came of it. The drive never leaves its travel.
fn approach(bench: &mut Bench, planner: &mut Planner, model: impl Fn(f64) -> f64) -> bool {
    let mut image = stand_in(0, |place: &Place| Wanted {
        model: [model(place.position[0]), 0.0, 0.0],
        ..Wanted::default()
    });
    for _ in 0..3000 {
        bench.inputs.position[0] = planner.step(PERIOD);
        let drive = bench.inputs.position[0] + bench.step(&mut image).correction[0];
        let inside = drive.abs() <= END + BEYOND + 1e-12;
        assert!(
            inside,
            "drive at {drive}, command at {}",
            bench.inputs.position[0]
        );
    }
    if bench.said.fault != 0 {
        assert_eq!(bench.said.fault, Fault::Travel as i32);
    }
    bench.said.fault != 0
}

fn from_the_middle(target: f64, speed: f64, acceleration: f64, correction: f64) -> bool {
    let mut bench = Bench::new();
    bench.settings.limit_mm = 0.2;
    let mut planner = Planner::at(
        target - target.signum() * (speed * 1.2).min(150.0),
        acceleration,
    );
    approach(&mut bench, &mut planner, |_| correction);
    (planner.target, planner.speed) = (target, speed);
    approach(&mut bench, &mut planner, |_| correction)
}

#[test]
fn a_rapid_to_the_end_faults_before_the_drive_is_there() {
    for sign in [1.0, -1.0] {
        assert!(from_the_middle(sign * END, 200.0, 2000.0, sign * 0.1));
        assert!(from_the_middle(sign * END, 2.0, 2000.0, sign * 0.1));
        assert!(from_the_middle(sign * END, 800.0, 10_000.0, sign * 0.02));
    }
}

#[test]
fn a_correction_away_from_the_end_is_no_fault() {
    for sign in [1.0, -1.0] {
        assert!(!from_the_middle(sign * END, 200.0, 2000.0, sign * -0.1));
    }
}

#[test]
fn coming_to_rest_just_inside_is_no_fault() {
    for (left, acceleration, correction) in [
        (0.021, 2000.0, 0.02),
        (0.35, 2000.0, 0.1),
        (0.1, 10_000.0, 0.02),
    ] {
        for speed in [2.0, 50.0, 200.0] {
            let faulted = from_the_middle(END - left, speed, acceleration, correction);
            assert!(!faulted, "{left} mm left, {speed} mm/s");
        }
    }
}

#[test]
fn a_correction_that_grows_towards_the_end_faults_where_it_no_longer_fits() {
    let mut bench = Bench::new();
    let mut planner = Planner::at(100.0, 2000.0);
    (planner.target, planner.speed) = (END, 100.0);
    assert!(approach(&mut bench, &mut planner, |q| (q - 100.0) * 1e-3));
}

#[test]
fn switching_on_at_the_end_adds_nothing() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant([0.02, 0.0, 0.0]));
    bench.inputs.position[0] = END;
    let said = bench.step(&mut image);
    assert_eq!(
        (said.fault, said.correction),
        (Fault::Travel as i32, [0.0; AXES])
    );
}

#[test]
fn a_command_outside_is_a_fault_once_the_correction_should_come_in_force() {
    for q in [END + 0.001, -END - 0.001] {
        let mut bench = Bench::new();
        let mut image = stand_in(0, constant([0.0; AXES]));
        bench.inputs.position[0] = q;
        bench.inputs.homed = false;
        assert_eq!(bench.steps(&mut image, 10).fault, 0);
        bench.inputs.homed = true;
        assert_eq!(bench.step(&mut image).fault, Fault::Travel as i32);
    }
}

#[test]
fn a_fault_at_standstill_near_the_end_leaves_it_inside() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant([0.02, 0.0, 0.0]));
    bench.inputs.position[0] = END - 0.0205;
    bench.until(&mut image, Phase::InForce);
    bench.inputs.tool_offset[0] = f64::NAN;
    for _ in 0..10 {
        assert!(bench.inputs.position[0] + bench.step(&mut image).correction[0] <= END);
    }
}

#[test]
fn a_hair_s_breadth_is_enough_for_a_hair() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant([1e-4, 0.0, 0.0]));
    bench.inputs.position[0] = END - 1.1e-4;
    assert_eq!(bench.steps(&mut image, 10).phase, Phase::InForce as i32);
}

#[test]
fn a_joint_that_homed_at_the_end_of_its_travel_is_corrected() {
    // 2.9e-8 mm: measured in LinuxCNC after homing to HOME = MAX_LIMIT.
    for beyond in [1e-12, 2.9e-8, 0.9 * BEYOND] {
        for (sign, correction) in [
            (1.0, -0.02),
            (1.0, 0.0),
            (1.0, 1e-9),
            (-1.0, 0.02),
            (-1.0, 0.0),
        ] {
            let mut bench = Bench::new();
            let mut image = stand_in(0, constant([correction, 0.0, 0.0]));
            bench.inputs.position[0] = sign * (END + beyond);
            let said = bench.steps(&mut image, 10);
            assert_eq!(
                (said.phase, said.fault),
                (Phase::InForce as i32, 0),
                "{beyond}"
            );
        }
    }
}

#[test]
fn a_command_further_beyond_the_end_is_a_fault() {
    for sign in [1.0, -1.0] {
        let mut bench = Bench::new();
        let mut image = stand_in(0, constant([0.0; AXES]));
        bench.inputs.position[0] = sign * (END + 1.1 * BEYOND);
        assert_eq!(bench.step(&mut image).fault, Fault::Travel as i32);
    }
}

#[test]
fn an_axis_that_never_moved_may_move() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant([0.1, 0.0, 0.0]));
    bench.inputs.position[0] = END - 0.11;
    assert_eq!(bench.steps(&mut image, 30).fault, Fault::Travel as i32);
}

/// A command that was seen at rest may have accelerated for half a period: to 0.5 mm/s at 1000 mm/s², which is assumed
/// without any movement, and to 10 mm/s at 20 000 mm/s², which is as much as a jump of the command counts. The quickest
/// way over 0.1323 mm peaks at u = √(132.3 + 0.125) = 11.508 mm/s and takes (2 u − 0.5) / 1000 = 22.52 ms, in which a
/// correction of up to 5 · 0.02252 − 5² / 2000 = 0.1001 mm fades; over 0.1320 mm 0.0999 mm. After a jump 2.13 mm let
/// √(42 600 + 50) = 206.52 mm/s, 20.152 ms and 5 · 0.020152 − 5² / 40 000 = 0.1001 mm; 2.12 mm let 0.0999 mm.
#[test]
fn the_room_that_a_tenth_needs_at_rest() {
    for (jumped, room, phase) in [
        (false, 0.1323, Phase::InForce),
        (false, 0.1320, Phase::Faulted),
        (true, 2.13, Phase::InForce),
        (true, 2.12, Phase::Faulted),
    ] {
        for sign in [1.0, -1.0] {
            let mut bench = Bench::new();
            let mut image = stand_in(0, constant([sign * 0.1, 0.0, 0.0]));
            bench.inputs.enable = false;
            if jumped {
                bench.steps(&mut image, 3);
            }
            bench.inputs.position[0] = sign * (END + BEYOND - room);
            bench.steps(&mut image, 3);
            bench.inputs.enable = true;
            assert_eq!(bench.steps(&mut image, 30).phase, phase as i32, "{room}");
        }
    }
}

#[test]
fn what_a_command_did_elsewhere_it_may_do_at_the_end() {
    for left in (0..300).map(|k| 0.05 + 0.001 * f64::from(k)) {
        let mut bench = Bench::new();
        let mut planner = Planner::at(190.0, 20_000.0);
        for (target, speed) in [(195.0, 200.0), (END - left, 5.0), (END, 200.0)] {
            (planner.target, planner.speed) = (target, speed);
            approach(&mut bench, &mut planner, |_| 0.03);
        }
    }
}

#[test]
fn an_axis_that_brakes_harder_than_it_was_seen_to_stays_inside() {
    let mut bench = Bench::new();
    let mut planner = Planner::at(0.0, 500.0);
    (planner.target, planner.speed) = (END, 200.0);
    let mut image = stand_in(0, constant([0.1, 0.0, 0.0]));
    while planner.position < 150.0 {
        bench.inputs.position[0] = planner.step(PERIOD);
        bench.step(&mut image);
    }
    planner.acceleration = 12_000.0;
    assert!(approach(&mut bench, &mut planner, |_| 0.1));
}

#[test]
fn a_command_that_moves_when_it_is_first_seen_was_not_hurled() {
    let mut bench = Bench::new();
    let mut planner = Planner {
        velocity: 50.0,
        ..Planner::at(150.0, 500.0)
    };
    (planner.target, planner.speed) = (END - 1.0, 50.0);
    assert!(!approach(&mut bench, &mut planner, |_| 0.1));
}

#[test]
fn a_correction_that_leaves_is_guarded_too() {
    let mut bench = Bench::new();
    bench.settings.freeze_s = 0.0;
    bench.settings.leave_s = 60.0;
    let mut planner = Planner::at(100.0, 2000.0);
    let mut image = stand_in(1, constant([0.1, 0.0, 0.0]));
    bench.inputs.position[0] = 100.0;
    bench.until(&mut image, Phase::InForce);
    bench.inputs.signal[0] = f64::NAN;
    bench.until(&mut image, Phase::Leaving);
    (planner.target, planner.speed) = (END, 200.0);
    for _ in 0..2000 {
        bench.inputs.position[0] = planner.step(PERIOD);
        assert!(
            bench.inputs.position[0] + bench.step(&mut image).correction[0] <= END + BEYOND + 1e-12
        );
    }
    // The first reason stays.
    assert_eq!(
        (bench.said.phase, bench.said.fault),
        (Phase::Faulted as i32, Fault::Range as i32)
    );
}

#[test]
fn whatever_a_planner_does_the_drive_stays_inside() {
    let mut dice = Dice::new(3);
    for _ in 0..150 {
        let acceleration = [500.0, 2000.0, 8000.0][dice.of(3)];
        let (offset, slope) = (dice.between(-0.1, 0.1), dice.between(-2e-4, 2e-4));
        let mut bench = Bench::new();
        bench.settings.limit_mm = 0.2;
        bench.settings.slew_mm_per_s = dice.between(2.0, 10.0);
        let mut planner = Planner::at(0.0, acceleration);
        (planner.target, planner.speed) = (dice.between(-20.0, 20.0), 300.0);
        approach(&mut bench, &mut planner, |q| offset + slope * q);
        for _ in 0..4 {
            let near = dice.between(-2.0, 0.0).exp2() * dice.between(0.0, 1.0);
            let end = if dice.once_in(2) { END } else { -END };
            (planner.target, planner.speed) = (end - end.signum() * near, dice.between(1.0, 300.0));
            approach(&mut bench, &mut planner, |q| offset + slope * q);
            bench.inputs.enable = dice.once_in(2);
        }
    }
}
