//! Readings: taken, refused, stood in for, missed.

use super::*;

const SLOPE: f64 = 0.002;

/// 2 µm for a degree of each signal.
fn warm(signals: usize) -> StandIn<impl FnMut(&Place) -> Wanted> {
    stand_in(signals, move |place| {
        let sum: f64 = place.signal.iter().take(signals).sum();
        Wanted {
            model: [sum * SLOPE, 0.0, 0.0],
            ..Wanted::default()
        }
    })
}

fn in_force(signals: usize) -> (Bench, StandIn<impl FnMut(&Place) -> Wanted>) {
    let (mut bench, mut image) = (Bench::new(), warm(signals));
    bench.settings = Settings {
        freeze_s: 0.5,
        leave_s: 0.25,
        ..bench.settings
    };
    bench.until(&mut image, Phase::InForce);
    (bench, image)
}

/// Each way to be bad, on signal 1 of 3.
const SPOIL: [(Change, Fault); 8] = [
    (|inputs| inputs.signal[1] = f64::NAN, Fault::Range),
    (|inputs| inputs.signal[1] = f64::INFINITY, Fault::Range),
    (|inputs| inputs.signal[1] = 9.9, Fault::Range),
    (|inputs| inputs.signal[1] = 40.1, Fault::Range),
    (|inputs| inputs.signal[1] = 21.1, Fault::Jump),
    (|inputs| inputs.age_s[1] = 10.1, Fault::Stale),
    (|inputs| inputs.age_s[1] = f64::NAN, Fault::Stale),
    (|inputs| inputs.age_s[1] = -1.0, Fault::Stale),
];

#[test]
fn a_bad_signal_freezes_then_leaves_then_faults() {
    for (spoil, fault) in SPOIL {
        let (mut bench, mut image) = in_force(3);
        let (before, signal) = (bench.said.correction, fault as i32);
        spoil(&mut bench.inputs);
        let frozen = bench.step(&mut image);
        assert_eq!(
            (frozen.phase, frozen.fault, frozen.pause),
            (Phase::Frozen as i32, 0, false)
        );
        assert_eq!((frozen.fault_signal, frozen.signal_fault), (1, signal));
        assert_eq!(
            (frozen.correction, frozen.in_use[1], frozen.enabled),
            (before, 20.0, true)
        );
        assert!((500..=502).contains(&bench.until(&mut image, Phase::Leaving)));
        assert!(bench.said.pause && !bench.said.enabled);
        assert_eq!((bench.said.fault, bench.said.fault_signal), (signal, 1));
        assert!((249..=251).contains(&bench.until(&mut image, Phase::Faulted)));
        assert_eq!((bench.said.fault, bench.said.fault_signal), (signal, 1));
        assert_eq!(bench.step(&mut image).correction, [0.0; AXES]);
    }
}

#[test]
fn a_leaving_correction_fades_evenly_and_does_not_come_back() {
    let (mut bench, mut image) = in_force(1);
    let full = bench.said.correction[0];
    bench.inputs.signal[0] = f64::NAN;
    bench.until(&mut image, Phase::Leaving);
    bench.inputs.signal[0] = 20.0;
    for share in [0.8, 0.6, 0.4, 0.2, 0.0] {
        let said = bench.steps(&mut image, 50);
        assert!((said.correction[0] - share * full).abs() < 1e-9);
    }
    assert_eq!(bench.steps(&mut image, 10).phase, Phase::Faulted as i32);
}

#[test]
fn leaving_is_never_faster_than_the_slew() {
    let (mut bench, mut image) = in_force(1);
    bench.settings.leave_s = 0.004;
    let mut last = bench.said.correction[0];
    bench.inputs.signal[0] = f64::NAN;
    for _ in 0..520 {
        let now = bench.step(&mut image).correction[0];
        assert!((now - last).abs() <= 5.0 * PERIOD * (1.0 + 1e-12));
        last = now;
    }
    assert_eq!((last, bench.said.phase), (0.0, Phase::Faulted as i32));
}

#[test]
fn times_of_zero_lead_straight_to_the_fault() {
    let (mut bench, mut image) = in_force(1);
    (bench.settings.freeze_s, bench.settings.leave_s) = (0.0, 0.0);
    bench.inputs.signal[0] = f64::NAN;
    let phases = [Phase::Frozen, Phase::Leaving, Phase::Faulted];
    for phase in phases {
        assert_eq!(bench.step(&mut image).phase, phase as i32);
    }
    assert_eq!(bench.steps(&mut image, 10).correction, [0.0; AXES]);
}

#[test]
fn leaving_hurries_where_the_correction_has_to_be_zero() {
    let (mut bench, mut image) = in_force(1);
    bench.inputs.signal[0] = f64::NAN;
    bench.until(&mut image, Phase::Leaving);
    bench.inputs.homed = false;
    let said = bench.step(&mut image);
    assert_eq!(
        (said.phase, said.fault),
        (Phase::Faulted as i32, Fault::Range as i32)
    );
    assert_eq!(bench.steps(&mut image, 10).correction, [0.0; AXES]);
}

#[test]
fn frozen_recovers_by_itself_and_its_time_starts_anew() {
    let (mut bench, mut image) = in_force(2);
    for _ in 0..3 {
        bench.inputs.signal[0] = f64::NAN;
        assert_eq!(bench.steps(&mut image, 400).phase, Phase::Frozen as i32);
        bench.inputs.signal[0] = 20.5;
        assert_eq!(bench.step(&mut image).phase, Phase::InForce as i32);
        assert_eq!((bench.said.fault_signal, bench.said.signal_fault), (-1, 0));
        assert_eq!(bench.said.in_use[0], 20.5);
    }
}

#[test]
fn a_frozen_signal_still_lets_the_model_follow_the_position() {
    let mut bench = Bench::new();
    let mut image = stand_in(1, |place| Wanted {
        model: [place.position[0] * place.signal[0] * 1e-5, 0.0, 0.0],
        ..Wanted::default()
    });
    bench.inputs.position[0] = 100.0;
    bench.until(&mut image, Phase::InForce);
    bench.inputs.signal[0] = f64::NAN;
    bench.inputs.position[0] = 50.0;
    let said = bench.steps(&mut image, 10);
    assert_eq!(said.phase, Phase::Frozen as i32);
    assert!((said.correction[0] - 50.0 * 20.0 * 1e-5).abs() < 1e-12);
}

#[test]
fn the_jump_is_counted_from_the_last_good_reading() {
    let (mut bench, mut image) = in_force(1);
    for value in [20.9, 21.8, 22.7, 21.8] {
        bench.inputs.signal[0] = value;
        assert_eq!(bench.steps(&mut image, 5).signal_fault, 0);
    }
    bench.inputs.signal[0] = 25.0;
    assert_eq!(bench.steps(&mut image, 5).signal_fault, Fault::Jump as i32);
    bench.inputs.signal[0] = 24.9;
    assert_eq!(bench.steps(&mut image, 5).in_use[0], 21.8);
    bench.until(&mut image, Phase::Faulted);
    // Taking enable away acknowledges it: the reading is where the next ones are counted from.
    bench.inputs.enable = false;
    bench.step(&mut image);
    bench.inputs.enable = true;
    bench.until(&mut image, Phase::InForce);
    assert_eq!(bench.said.in_use[0], 24.9);
}

#[test]
fn silence_is_a_watchdog_s_and_ages_grow_with_it() {
    let (mut bench, mut image) = in_force(2);
    bench.inputs.age_s = [1.0; 16];
    bench.inputs.age_s[1] = 3.0;
    bench.step(&mut image);
    assert!((bench.said.oldest_age_s - 3.0).abs() < 1e-9);
    for _ in 0..1999 {
        bench.silent_step(&mut image);
    }
    assert_eq!(bench.said.phase, Phase::InForce as i32);
    assert!((bench.said.oldest_age_s - 4.999).abs() < 1e-9);
    for _ in 0..2 {
        bench.silent_step(&mut image);
    }
    assert_eq!(
        (bench.said.phase, bench.said.signal_fault),
        (Phase::Frozen as i32, Fault::Watchdog as i32)
    );
    assert_eq!(bench.said.fault_signal, -1);
    bench.step(&mut image);
    assert_eq!(bench.said.phase, Phase::InForce as i32);
}

#[test]
fn silence_makes_a_reading_stale_even_where_the_watchdog_waits() {
    let (mut bench, mut image) = in_force(1);
    (bench.settings.watchdog_s, bench.settings.stale_s) = (100.0, 0.05);
    bench.inputs.age_s[0] = 0.04;
    bench.step(&mut image);
    for _ in 0..9 {
        bench.silent_step(&mut image);
    }
    assert_eq!(bench.said.signal_fault, 0);
    for _ in 0..2 {
        bench.silent_step(&mut image);
    }
    assert_eq!(bench.said.signal_fault, Fault::Stale as i32);
}

#[test]
fn a_reading_as_old_as_it_may_be_is_taken() {
    let (mut bench, mut image) = in_force(1);
    (bench.settings.stale_s, bench.inputs.age_s[0]) = (3.0, 3.0);
    assert_eq!(bench.step(&mut image).signal_fault, 0);
    // Times of 0: what is read and told in every period is neither old nor silent.
    (bench.settings.stale_s, bench.settings.watchdog_s) = (0.0, 0.0);
    bench.inputs.age_s[0] = 0.0;
    assert_eq!(bench.steps(&mut image, 5).signal_fault, 0);
    assert_eq!(
        bench.silent_step(&mut image).signal_fault,
        Fault::Watchdog as i32
    );
}

#[test]
fn nothing_is_taken_before_the_first_message() {
    let (mut bench, mut image) = (Bench::new(), warm(1));
    for _ in 0..10 {
        let said = bench.silent_step(&mut image);
        assert_eq!(
            (said.phase, said.waits_for),
            (Phase::Waiting as i32, WaitsFor::Signals as i32)
        );
        assert_eq!(said.signal_fault, Fault::Watchdog as i32);
    }
    assert_eq!(bench.step(&mut image).phase, Phase::Ramping as i32);
}

#[test]
fn an_image_without_signals_needs_no_heartbeat() {
    let (mut bench, mut image) = (Bench::new(), warm(0));
    bench.inputs.signal = [f64::NAN; 16];
    for _ in 0..5000 {
        bench.silent_step(&mut image);
    }
    assert_eq!(
        (bench.said.phase, bench.said.oldest_age_s),
        (Phase::InForce as i32, 0.0)
    );
}

#[test]
fn a_signal_that_is_bad_from_the_start_faults_after_freeze_and_leave() {
    let (mut bench, mut image) = (Bench::new(), warm(1));
    bench.settings = Settings {
        freeze_s: 0.5,
        leave_s: 0.25,
        ..bench.settings
    };
    bench.inputs.signal[0] = 50.0;
    bench.inputs.machine_on = false;
    assert_eq!(bench.steps(&mut image, 2000).phase, Phase::Waiting as i32);
    bench.inputs.machine_on = true;
    assert!((750..=752).contains(&bench.until(&mut image, Phase::Faulted)));
    assert_eq!(
        (bench.said.fault, bench.said.fault_signal),
        (Fault::Range as i32, 0)
    );
    assert!(!bench.said.pause && bench.said.correction == [0.0; AXES]);
}

#[test]
fn waiting_for_a_signal_is_counted_while_nothing_else_is_in_the_way() {
    let (mut bench, mut image) = (Bench::new(), warm(1));
    bench.settings = Settings {
        freeze_s: 0.5,
        leave_s: 0.25,
        ..bench.settings
    };
    bench.inputs.signal[0] = 50.0;
    bench.steps(&mut image, 700);
    bench.inputs.machine_on = false;
    bench.steps(&mut image, 3);
    bench.inputs.machine_on = true;
    assert!((750..=752).contains(&bench.until(&mut image, Phase::Faulted)));
}

#[test]
fn a_lost_signal_grows_old() {
    let (mut bench, mut image) = in_force(2);
    bench.inputs.signal[1] = f64::NAN;
    let said = bench.steps(&mut image, 300);
    assert!(
        (said.oldest_age_s - 0.3).abs() < 1e-9,
        "{}",
        said.oldest_age_s
    );
}

#[test]
fn an_exchanged_image_with_other_signals_takes_their_readings_as_they_come() {
    let (mut bench, mut image) = in_force(1);
    bench.inputs.enable = false;
    bench.steps(&mut image, 20);
    let mut other = warm(2);
    other.signals[0] = SignalRange {
        low: 100.0,
        high: 900.0,
        most_step: 1.0,
    };
    (bench.inputs.signal[0], bench.inputs.signal[1]) = (f64::NAN, 20.0);
    let said = bench.step(&mut other);
    // The old image's 20 °C is no pressure of the new one.
    assert_eq!((said.in_use[0], said.model), (0.0, [0.0; AXES]));
    bench.inputs.signal[0] = 500.0;
    bench.inputs.enable = true;
    other.limit = 10.0;
    bench.settings.limit_mm = 10.0;
    assert_eq!(bench.step(&mut other).waits_for, 0);
}
