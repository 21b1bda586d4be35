//! A corrector in the loop with a machine that faults strike at random. What must hold is checked in every period.

use super::virtual_machine::Dice;
use super::world::{truth, warmth, World, COARSE, END, HALF_BACKLASH};
use super::*;

/// −E where that leads.
fn model(place: &Place, signal: usize) -> [f64; AXES] {
    let mut model = [0.0; AXES];
    for (axis, part) in model.iter_mut().enumerate() {
        for _ in 0..3 {
            *part = -truth(
                axis,
                place.position[axis] + *part,
                place.travel[axis],
                place.signal[signal],
            );
        }
    }
    model
}

/// What a corrector that follows as fast as its slew allows may be behind, by axis.
#[derive(Default)]
struct Behind {
    error: [f64; AXES],
    by: [f64; AXES],
}

impl Behind {
    /// E jumps where an axis turns round. For jump / slew the correction is on its way from one to the other, and the error
    /// may be larger by what is left of the jump.
    ///
    /// `share`: how much larger the jump is at the temperature that stands in for a bad one. `unknown`: until the command
    /// has moved, the model takes the mean of both directions.
    fn allow(&mut self, axis: usize, error: f64, slewed: f64, share: f64, unknown: f64) -> f64 {
        let jump = (error - self.error[axis]).abs() * share;
        self.error[axis] = error;
        self.by[axis] = (self.by[axis] + jump - slewed).max(unknown);
        self.by[axis]
    }
}

#[derive(Default, Debug)]
struct Seen {
    faults: [usize; 11],
    phases: [usize; 7],
    behind: usize,
    without: f64,
    with: f64,
}

fn run(seed: u64, acceleration: f64, periods: usize, seen: &mut Seen) -> usize {
    let mut world = World::new(seed, acceleration);
    let mut bench = Bench::new();
    let mut behind = Behind::default();
    let mut images = [0, 1].map(|signal| {
        let mut image = stand_in(2, move |place: &Place| Wanted {
            model: model(place, signal),
            listed: place.line.is_some(),
            on_path: place.position[0] < 15.0,
            ..Wanted::default()
        });
        image.signals[1 - signal] = SignalRange {
            low: 900.0,
            high: 1100.0,
            most_step: 5.0,
        };
        image.travel = [(-END, END); AXES];
        image.has_table = true;
        image
    });
    bench.settings.slew_mm_per_s = 5.0;
    for _ in 0..periods {
        world.strike();
        let before = bench.said;
        let exchanged = !bench.inputs.enable && !before.active && world.dice.once_in(3);
        if exchanged {
            world.image = 1 - world.image;
            bench.settings.slew_mm_per_s = [2.0, 5.0, 8.0][world.dice.of(3)];
        }
        world.tell(&mut bench);
        bench.inputs.enable &= !exchanged;
        let on = bench.inputs.machine_on;
        let position = world.move_axes(before.correction, on, bench.inputs.homed);
        bench.inputs.position = position;
        let said = bench.silent_step(&mut images[world.image]);
        world.check(&bench, &before, on, &mut behind, seen);
        if on {
            world.drive = sum(position, said.correction);
        }
        seen.phases[said.phase as usize] += 1;
        seen.faults[said.fault as usize] += usize::from(said.fault != before.fault);
    }
    world.injected.iter().sum()
}

fn sum(mut a: [f64; AXES], b: [f64; AXES]) -> [f64; AXES] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

impl World {
    fn check(
        &self,
        bench: &Bench,
        before: &Outputs,
        on: bool,
        behind: &mut Behind,
        seen: &mut Seen,
    ) {
        let (said, inputs) = (&bench.said, &bench.inputs);
        let slewed = bench.settings.slew_mm_per_s * PERIOD;
        let share = (warmth(said.in_use[self.image]) / warmth(self.degrees)).max(1.0);
        gives_a_reason(said, inputs.enable);
        is_finite(said);
        for axis in 0..AXES {
            let (c, q) = (said.correction[axis], inputs.position[axis]);
            assert!(
                (c - before.correction[axis]).abs() <= slewed * (1.0 + 1e-9),
                "a step larger than the slew"
            );
            let direction = self.direction[axis];
            let error = truth(axis, q, direction, self.degrees);
            let unknown = if self.told[axis] {
                0.0
            } else {
                1.3 * HALF_BACKLASH
            };
            let allowed = behind.allow(axis, error, slewed, share, unknown);
            if !on {
                continue;
            }
            assert!(
                (q + c).abs() <= END.max(q.abs()) + 1e-12,
                "the drive at {} mm",
                q + c
            );
            let with = (c + truth(axis, q + c, direction, self.degrees)).abs();
            let rounding = 0.6 * 0.002;
            let coarse = if self.has(COARSE) { rounding } else { 0.0 };
            assert!(
                with <= error.abs() + allowed + coarse + 5e-6,
                "{with} mm with, {} without, {allowed} allowed on axis {axis}: {:?}, then {:?}",
                error.abs(),
                before,
                said
            );
            seen.behind += usize::from(allowed > 0.0);
            seen.without += error.abs();
            seen.with += with;
        }
    }
}

fn gives_a_reason(said: &Outputs, asked_for: bool) {
    let phase = said.phase;
    assert_eq!(asked_for, phase != Phase::Off as i32);
    assert_eq!(said.waits_for != 0, phase == Phase::Waiting as i32);
    assert_eq!(said.fault != 0, phase >= Phase::Leaving as i32);
    if phase == Phase::Frozen as i32 || said.waits_for == WaitsFor::Signals as i32 {
        assert!(said.signal_fault != 0);
    }
    let in_force = phase == Phase::InForce as i32
        || phase == Phase::Ramping as i32
        || phase == Phase::Frozen as i32;
    assert!(in_force || !said.enabled);
}

fn is_finite(said: &Outputs) {
    let axes = [said.correction, said.model, said.table, said.latch];
    let mut values = axes
        .iter()
        .flatten()
        .chain(&said.in_use)
        .chain([&said.oldest_age_s]);
    assert!(values.all(|value| value.is_finite()), "{said:?}");
}

#[test]
fn ten_thousand_faults_leave_the_machine_no_worse_than_without() {
    let mut seen = Seen::default();
    let mut injected = 0;
    for (seed, acceleration) in (1..=12).zip([500.0, 2000.0, 8000.0].into_iter().cycle()) {
        injected += run(seed, acceleration, 25_000, &mut seen);
    }
    std::println!("{injected} faults: {seen:?}");
    assert!(injected >= 10_000, "{injected}");
    assert!(seen.phases.iter().all(|count| *count > 0), "{seen:?}");
    assert!(
        seen.faults.iter().skip(1).all(|count| *count > 0),
        "{seen:?}"
    );
    // Most of the time it is not even near.
    assert!(seen.with < 0.8 * seen.without, "{seen:?}");
}

#[test]
fn nonsense_comes_out_finite_and_slewed() {
    let mut dice = Dice::new(11);
    let wild = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -0.0,
        1e300,
        -1e300,
        5e-324,
        1.0,
        -1.0,
    ];
    let mut bench = Bench::new();
    let mut slew = 1.0;
    for _ in 0..200_000 {
        let mut pick = |likely: f64| {
            if dice.once_in(12) {
                wild[dice.of(wild.len())]
            } else {
                likely
            }
        };
        let inputs = &mut bench.inputs;
        inputs.position = [0.0; AXES].map(&mut pick);
        inputs.tool_offset = [0.0; AXES].map(&mut pick);
        inputs.signal = [20.0; 16].map(&mut pick);
        inputs.age_s = [0.0; 16].map(&mut pick);
        let period = if inputs.line % 50 == 0 {
            pick(PERIOD)
        } else {
            PERIOD
        };
        inputs.period_s = period;
        let answer = [[0.02; AXES].map(&mut pick), [0.01; AXES].map(&mut pick)];
        let settings = &mut bench.settings;
        settings.slew_mm_per_s = pick(5.0);
        settings.resolution_mm = pick(0.0);
        settings.limit_mm = pick(0.2);
        settings.leave_s = pick(0.1);
        settings.freeze_s = pick(0.1);
        settings.stale_s = pick(0.1);
        inputs.enable = !dice.once_in(9);
        inputs.homed = !dice.once_in(30);
        inputs.line += 1;
        let before = bench.said.correction;
        let mut image = stand_in(3, |_| Wanted {
            model: answer[0],
            table: answer[1],
            listed: true,
            on_path: true,
        });
        let said = bench.step(&mut image);
        is_finite(&said);
        gives_a_reason(&said, bench.inputs.enable);
        let given = bench.settings.slew_mm_per_s;
        slew = if given > 0.0 && given.is_finite() {
            given
        } else {
            slew
        };
        let period = if period.is_finite() {
            period.max(0.0)
        } else {
            0.0
        };
        let most = slew * period * (1.0 + 1e-9);
        assert!(said
            .correction
            .iter()
            .zip(before)
            .all(|(now, was)| (now - was).abs() <= most));
        assert!(said.correction.iter().all(|c| c.abs() <= 1e301));
    }
}
