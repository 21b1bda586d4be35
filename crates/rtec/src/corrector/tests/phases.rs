//! What leads from one phase to the next.

use super::*;

/// Sets it, or takes it away; what is said of it.
type Hindrance = (fn(&mut Inputs, bool), WaitsFor);

const WANTED: [f64; AXES] = [0.02, 0.0, -0.05];

fn in_force() -> (Bench, StandIn<impl FnMut(&Place) -> Wanted>) {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant(WANTED));
    bench.until(&mut image, Phase::InForce);
    (bench, image)
}

#[test]
fn comes_in_force_within_jump_by_slew() {
    let mut bench = Bench::new();
    let mut image = stand_in(0, constant(WANTED));
    assert_eq!(bench.step(&mut image).phase, Phase::Ramping as i32);
    assert!(!bench.said.enabled && bench.said.active);
    // 50 µm at 5 mm/s: 10 periods with the first.
    assert_eq!(bench.until(&mut image, Phase::InForce), 9);
    assert!(bench.said.enabled);
    assert_eq!(bench.said.correction, WANTED);
}

#[test]
fn off_ramps_to_zero_and_says_nothing() {
    let (mut bench, mut image) = in_force();
    bench.inputs.enable = false;
    let first = bench.step(&mut image);
    assert_eq!(
        (first.phase, first.enabled, first.active),
        (Phase::Off as i32, false, true)
    );
    assert!(close(first.correction, [0.015, 0.0, -0.045], 1e-12));
    let last = bench.steps(&mut image, 9);
    assert_eq!((last.correction, last.active), ([0.0; AXES], false));
    assert_eq!(last.model, WANTED);
    bench.inputs.enable = true;
    assert!(!bench.step(&mut image).enabled);
}

#[test]
fn each_hindrance_takes_it_to_zero_and_it_returns_by_itself() {
    let hindrances: [Hindrance; 4] = [
        (|inputs, there| inputs.homed = !there, WaitsFor::Homing),
        (|inputs, there| inputs.machine_on = !there, WaitsFor::Drives),
        (|inputs, there| inputs.probing = there, WaitsFor::Probing),
        (
            |inputs, there| inputs.motion_type = if there { 5 } else { 2 },
            WaitsFor::Probing,
        ),
    ];
    for (set, reason) in hindrances {
        let (mut bench, mut image) = in_force();
        set(&mut bench.inputs, true);
        let waiting = bench.step(&mut image);
        assert_eq!(
            (waiting.phase, waiting.waits_for),
            (Phase::Waiting as i32, reason as i32)
        );
        assert!(!waiting.enabled && !waiting.pause && waiting.fault == 0);
        assert_eq!(bench.steps(&mut image, 10).correction, [0.0; AXES]);
        set(&mut bench.inputs, false);
        bench.until(&mut image, Phase::InForce);
        assert_eq!((bench.said.correction, bench.said.waits_for), (WANTED, 0));
    }
}

#[test]
fn the_first_of_several_hindrances_is_said() {
    let mut bench = Bench::new();
    let mut image = stand_in(1, constant(WANTED));
    let clear: [fn(&mut Inputs); 4] = [
        |inputs| inputs.homed = true,
        |inputs| inputs.machine_on = true,
        |inputs| inputs.probing = false,
        |inputs| inputs.signal = [20.0; 16],
    ];
    bench.inputs.signal = [f64::NAN; 16];
    (
        bench.inputs.homed,
        bench.inputs.machine_on,
        bench.inputs.probing,
    ) = (false, false, true);
    for (reason, clear) in (1..).zip(clear) {
        assert_eq!(bench.steps(&mut image, 2).waits_for, reason);
        clear(&mut bench.inputs);
    }
    assert_eq!(bench.step(&mut image).waits_for, 0);
}

#[test]
fn stays_in_force_while_probing_where_asked_and_then_without_the_table() {
    let mut bench = Bench::new();
    bench.settings.probe_corrected = true;
    bench.inputs.program = 1;
    let mut image = stand_in(0, |place| Wanted {
        model: WANTED,
        table: if place.line.is_some() {
            [0.01, 0.0, 0.0]
        } else {
            [0.0; AXES]
        },
        ..Wanted::default()
    });
    bench.until(&mut image, Phase::InForce);
    assert!(close(bench.said.correction, [0.03, 0.0, -0.05], 1e-12));
    bench.inputs.probing = true;
    let probing = bench.steps(&mut image, 10);
    assert_eq!(
        (probing.phase, probing.correction),
        (Phase::InForce as i32, WANTED)
    );
}

#[test]
fn a_fault_stays_until_enable_goes_off() {
    let (mut bench, mut image) = in_force();
    bench.inputs.position = [f64::NAN, 0.0, 0.0];
    let faulted = bench.step(&mut image);
    assert_eq!(
        (faulted.phase, faulted.fault, faulted.fault_signal),
        (Phase::Faulted as i32, Fault::NotANumber as i32, -1)
    );
    assert!(close(faulted.correction, [0.015, 0.0, -0.045], 1e-12));
    bench.inputs.position = [0.0; AXES];
    let later = bench.steps(&mut image, 100);
    assert_eq!(
        (later.fault, later.correction),
        (Fault::NotANumber as i32, [0.0; AXES])
    );
    bench.inputs.enable = false;
    assert_eq!(bench.step(&mut image).fault, 0);
    bench.inputs.enable = true;
    bench.until(&mut image, Phase::InForce);
}

#[test]
fn a_correction_beyond_either_limit_is_refused_and_not_clamped() {
    for (image_limit, own_limit) in [(0.2, 0.049), (0.049, 0.15)] {
        let mut bench = Bench::new();
        bench.settings.limit_mm = own_limit;
        let mut image = stand_in(0, constant(WANTED));
        image.limit = image_limit;
        let said = bench.step(&mut image);
        assert_eq!(
            (said.fault, said.correction),
            (Fault::Limit as i32, [0.0; AXES])
        );
        assert_eq!(said.model, WANTED);
    }
}

#[test]
fn what_is_no_number_is_refused_and_never_shown() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut bench = Bench::new();
        let mut image = stand_in(0, constant([0.01, bad, 0.0]));
        let said = bench.step(&mut image);
        assert_eq!(
            (said.fault, said.model),
            (Fault::NotANumber as i32, [0.01, 0.0, 0.0])
        );
        let (mut bench, mut image) = in_force();
        bench.inputs.tool_offset = [0.0, 0.0, bad];
        assert_eq!(bench.step(&mut image).fault, Fault::NotANumber as i32);
    }
}

#[test]
fn settings_that_make_no_sense_are_refused_and_the_slew_stays() {
    let spoil: [fn(&mut Settings); 11] = [
        |set| set.slew_mm_per_s = 0.0,
        |set| set.slew_mm_per_s = f64::NAN,
        |set| set.limit_mm = -0.1,
        |set| set.limit_mm = f64::NAN,
        |set| set.resolution_mm = -1e-3,
        |set| set.stale_s = f64::INFINITY,
        |set| set.freeze_s = -1.0,
        |set| set.leave_s = f64::NAN,
        |set| set.watchdog_s = -1.0,
        |set| set.off_path_s = -0.1,
        |set| set.parts = 4,
    ];
    for spoil in spoil {
        let (mut bench, mut image) = in_force();
        spoil(&mut bench.settings);
        let said = bench.step(&mut image);
        assert_eq!(
            (said.phase, said.fault),
            (Phase::Faulted as i32, Fault::Settings as i32)
        );
        assert!(close(said.correction, [0.015, 0.0, -0.045], 1e-12));
        bench.inputs.enable = false;
        assert_eq!(bench.step(&mut image).fault, 0);
    }
    let (mut bench, mut image) = in_force();
    bench.inputs.period_s = f64::NAN;
    let said = bench.step(&mut image);
    assert_eq!(
        (said.fault, said.correction),
        (Fault::Settings as i32, WANTED)
    );
}

#[test]
fn only_the_parts_asked_for_act() {
    let answers = [
        (0, [0.0; AXES]),
        (1, [0.02, 0.0, 0.0]),
        (2, [0.0, 0.0, 0.01]),
        (3, [0.02, 0.0, 0.01]),
    ];
    for (parts, sum) in answers {
        let mut bench = Bench::new();
        bench.settings.parts = parts;
        bench.inputs.program = 1;
        let mut image = stand_in(0, |_| Wanted {
            model: [0.02, 0.0, 0.0],
            table: [0.0, 0.0, 0.01],
            ..Wanted::default()
        });
        image.has_table = true;
        let said = bench.steps(&mut image, 20);
        assert!(close(said.correction, sum, 1e-12));
        let mut shown = said.model;
        shown.iter_mut().zip(said.table).for_each(|(a, b)| *a += b);
        assert_eq!(shown, sum);
    }
}

#[test]
fn another_program_than_the_table_s_is_a_fault() {
    for (has_table, parts, program, fault) in [
        (true, 3, 2, Fault::Program as i32),
        (true, 3, 1, 0),
        (true, 3, 0, 0),
        (true, 1, 2, 0),
        (false, 3, 2, 0),
    ] {
        let mut bench = Bench::new();
        bench.settings.parts = parts;
        bench.inputs.program = program;
        let mut image = stand_in(0, constant(WANTED));
        image.has_table = has_table;
        assert_eq!(bench.step(&mut image).fault, fault);
    }
}

#[test]
fn the_table_is_asked_by_line_only_while_its_program_runs() {
    for (program, parts, line) in [
        (0, 3, None),
        (1, 3, Some(7)),
        (2, 3, None),
        (1, 2, Some(7)),
        (1, 1, None),
    ] {
        let mut bench = Bench::new();
        bench.settings.parts = parts;
        (bench.inputs.program, bench.inputs.line) = (program, 7);
        let mut seen = None;
        let mut image = stand_in(0, |place| {
            seen = place.line;
            Wanted::default()
        });
        bench.step(&mut image);
        assert_eq!(seen, line);
    }
}

#[test]
fn a_listed_block_may_be_off_its_path_for_a_time() {
    let (mut on_path, mut bench) = (true, Bench::new());
    bench.inputs.program = 1;
    let step = |bench: &mut Bench, on_path: bool, periods: usize| {
        let mut image = stand_in(0, move |_| Wanted {
            listed: true,
            on_path,
            ..Wanted::default()
        });
        bench.steps(&mut image, periods)
    };
    for _ in 0..5 {
        assert_eq!(step(&mut bench, on_path, 99).fault, 0);
        on_path = !on_path;
    }
    assert!(!on_path);
    step(&mut bench, true, 1);
    bench.inputs.enable = false;
    step(&mut bench, false, 200);
    bench.inputs.enable = true;
    assert_eq!(step(&mut bench, false, 99).fault, 0);
    assert_eq!(step(&mut bench, false, 2).fault, Fault::OffPath as i32);
}

#[test]
fn a_fault_pauses_what_it_would_be_seen_on() {
    // A correction was in force.
    let (mut bench, mut image) = in_force();
    bench.inputs.tool_offset = [f64::NAN; AXES];
    assert!(bench.step(&mut image).pause);
    assert!(bench.steps(&mut image, 100).pause);
    bench.settings.pause_program = false;
    assert!(!bench.step(&mut image).pause);
    bench.settings.pause_program = true;
    bench.inputs.enable = false;
    assert!(!bench.step(&mut image).pause);
    // One of zero was in force here, and would have been another elsewhere.
    let mut nothing = stand_in(0, constant([0.0; AXES]));
    let mut bench = Bench::new();
    bench.until(&mut nothing, Phase::InForce);
    bench.inputs.tool_offset = [f64::NAN; AXES];
    assert!(bench.step(&mut nothing).pause);
    // None was, and no program runs: one that is started then is paused.
    let mut bench = Bench::new();
    bench.inputs.tool_offset = [f64::NAN; AXES];
    assert!(!bench.steps(&mut image, 10).pause);
    bench.inputs.program = 1;
    assert!(bench.step(&mut image).pause);
    bench.inputs.program = 0;
    assert!(bench.step(&mut image).pause);
}

#[test]
fn a_jump_of_what_is_wanted_is_slewed_and_stays_enabled() {
    let (mut bench, _) = in_force();
    let mut image = stand_in(0, constant([0.04, 0.0, -0.05]));
    for _ in 0..3 {
        let said = bench.step(&mut image);
        assert_eq!((said.phase, said.enabled), (Phase::Ramping as i32, true));
    }
    let said = bench.step(&mut image);
    assert_eq!(
        (said.phase, said.correction),
        (Phase::InForce as i32, [0.04, 0.0, -0.05])
    );
}
