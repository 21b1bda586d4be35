//! Arcs that a control refuses to make as they are programmed, because their end misses their circle.

use std::f64::consts::SQRT_2;

use crate::dialect::FlowStyle;
use crate::finding::{self, Finding, Severity};
use crate::path::{Arc, ToolPath};
use crate::program::Program;

/// What an arc may end off its circle by, mm in a metric and in an inch program: LinuxCNC's bounds, the rounding of ends
/// and centre to two and three decimals.
const OFF_MM: [f64; 2] = [0.02 * SQRT_2, 0.002 * SQRT_2 * 25.4];
/// A Sinumerik's, as it is delivered, and the most that can be set for Klartext.
const STRUCTURED_OFF_MM: f64 = 0.01;
const KLARTEXT_OFF_MM: f64 = 0.016;
/// The same by this share of the radius, where that is more …
const OFF_SHARE: f64 = 0.001;
/// … but never by as many times as that bound.
const MOST_TIMES: f64 = 100.0;

/// Reports the arcs of a path that the control refuses, at the words that set their ends.
pub(crate) fn require_sound(program: &Program, path: &ToolPath, findings: &mut Vec<Finding>) {
    for arc in &path.arcs {
        let off_mm = misfit_mm(path, arc);
        if is_refused(program, path, arc, off_mm) {
            let message = format!("the arc's end is {off_mm:+.5} mm ({:+.6} in) off its circle", off_mm / 25.4);
            let hint = "check the end point and I, J, K or R: one of them was changed without the others".to_owned();
            let at = path.at(arc.of_move, program);
            finding::add(findings, Finding { severity: Severity::Error, code: finding::ARC_FIT, message, hint, at });
        }
    }
}

/// Distance of the end from the centre less that of the start.
fn misfit_mm(path: &ToolPath, arc: &Arc) -> f64 {
    radius_mm(path, arc, &path.end[arc.of_move]) - radius_mm(path, arc, &path.start[arc.of_move])
}

fn radius_mm(path: &ToolPath, arc: &Arc, point: &[f64; 3]) -> f64 {
    let (first, second, _) = path.states[path.state[arc.of_move] as usize].plane.axes();
    (point[first] - arc.centre[first]).hypot(point[second] - arc.centre[second])
}

/// One by its radius that cannot be was refused before.
fn is_refused(program: &Program, path: &ToolPath, arc: &Arc, off_mm: f64) -> bool {
    let inch = usize::from(path.states[path.state[arc.of_move] as usize].inch);
    let least = match program.dialect().flow {
        FlowStyle::Structured => STRUCTURED_OFF_MM,
        FlowStyle::Labels => KLARTEXT_OFF_MM,
        _ => OFF_MM[inch],
    };
    let end = radius_mm(path, arc, &path.end[arc.of_move]);
    let larger = end.max(end - off_mm);
    arc.radius.is_nan() && off_mm.abs() > least.max(OFF_SHARE * larger).min(MOST_TIMES * least)
}
