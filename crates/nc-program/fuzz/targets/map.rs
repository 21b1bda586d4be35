//! A field over any bytes, in every dialect: refused or written, the same in one piece and in two; no displacement
//! changes no byte where every arc fits its centre, and what is written can be run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nc_map::{writes_comma, written_decimals, Affine, Field, Limits, Mapper, Place, Surveyed, Trouble, Vector};
use nc_program::dialect::dialects;
use nc_program::{jumps, rotary_letters, run, Options, Program};

/// Blocks of one run: enough for every construct, few enough for many runs a second.
const BLOCKS: usize = 2_000;
const LIMITS: Limits = Limits { tolerance_mm: 5e-4, size_mm: f64::INFINITY, slope: f64::INFINITY };
const NOWHERE: Affine = Affine { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

/// Bends lines along X, so that moves become several.
struct Bend;

impl Field for Bend {
    fn displacements(&mut self, points: &[Vector], _: &[Place], found: &mut Vec<Vector>) -> Result<(), Trouble> {
        found.clear();
        found.extend(points.iter().map(|point| [0.01, 0.0, 0.02 * (point[0] / 20.0).sin()]));
        Ok(())
    }
}

fn options() -> Options {
    Options { block_limit: BLOCKS, roughed_contours: true, ..Options::default() }
}

/// The program with the field over it, read in two pieces; `None` where it is refused.
fn mapped(program: &Program, field: &mut dyn Field, cut: usize) -> Option<Vec<u8>> {
    let (source, comma) = (program.source(), writes_comma(program));
    let decimals = written_decimals(program);
    let surveyed = Surveyed { whole: jumps(program), named: [true; 3], comma, decimals };
    let options = Options { rotary: Some(rotary_letters(program)), unit_is_known: true, ..options() };
    let mut mapper = Mapper::new(program.dialect(), options, LIMITS, surveyed);
    let mut out = Vec::new();
    let (first, second) = source.split_at(cut.min(source.len()));
    mapper.push(first, field, &mut out).ok()?;
    mapper.push(second, field, &mut out).ok()?;
    mapper.finish(field, &mut out).ok()?;
    Some(out)
}

/// Whether both ends of every arc are equally far from its centre: others are divided, displaced or not.
fn fits(program: &Program) -> bool {
    let (path, _) = run(program, &options());
    path.arcs.iter().all(|arc| {
        let (first, second, _) = path.states[path.state[arc.of_move] as usize].plane.axes();
        let radius = |at: &Vector| (at[first] - arc.centre[first]).hypot(at[second] - arc.centre[second]);
        (radius(&path.start[arc.of_move]) - radius(&path.end[arc.of_move])).abs() < 1e-6
    })
}

fuzz_target!(|source: &[u8]| {
    let cut = source.iter().map(|byte| usize::from(*byte)).sum::<usize>() % (source.len() + 1);
    for dialect in dialects() {
        let program = Program::read(source.to_vec(), dialect).expect("a fuzzer's inputs are small");
        if let Some(out) = mapped(&program, &mut NOWHERE.clone(), 0) {
            assert!(out == source || !fits(&program), "nothing is displaced");
        }
        let one = mapped(&program, &mut Bend, 0);
        let two = mapped(&program, &mut Bend, cut);
        if let (Some(one), Some(two)) = (&one, &two) {
            assert_eq!(one, two, "in two pieces as in one");
        }
        if let Some(out) = one {
            let written = Program::read(out, dialect).expect("hardly longer than a small one");
            run(&written, &options());
        }
    }
});
