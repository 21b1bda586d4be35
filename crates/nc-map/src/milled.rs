//! Cycles whose passes are the control's (pockets, faces): how much the field differs over the space that one mills.

use std::collections::HashMap;

use nc_program::{Space, ToolPath};

use crate::field::{Field, Trouble, Vector};
use crate::geometry::Geometry;
use crate::pieces::{in_work_offset, Fault};

/// The field is looked at from one end of the space to the other in so many steps at least along each axis.
const LEAST_STEPS: usize = 4;
/// … and at most: beyond half a metre the steps are longer than `STEP_MM`.
const MOST_STEPS: usize = 100;
/// A step, mm.
const STEP_MM: f64 = 5.0;

/// How a field displaces the space that a cycle mills.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shared {
    /// The middle between the least and the greatest displacement along each axis, mm.
    pub middle: Vector,
    /// How far any of them is off the middle, mm; infinite where the field has no value at a place of the space.
    pub off: Vector,
}

/// Of each cycle of the path that mills by passes of the control's, by the index of its first move.
pub(crate) fn shared(
    path: &ToolPath,
    geometry: &Geometry,
    field: &mut dyn Field,
) -> Result<HashMap<usize, Shared>, Fault> {
    let mut all = HashMap::new();
    let milled = path.drilled.iter().map(|hole| (hole.first, hole.milled));
    let turned = path.turned.iter().map(|cycle| (cycle.first, cycle.milled));
    let pockets = path.pockets.iter().map(|(of_move, space)| (*of_move, Some(*space)));
    for (first, space) in milled.chain(turned).chain(pockets) {
        let Some(space) = space.filter(|space| space.iter().flatten().all(|value| value.is_finite())) else {
            continue;
        };
        let points = points(&space);
        let places = vec![geometry.place(first, 0.5); points.len()];
        let mut found = Vec::new();
        let fault = |trouble: Trouble| Fault::Field(trouble, vec![first; points.len()]);
        field.displacements(&in_work_offset(&points, &places), &places, &mut found).map_err(fault)?;
        if found.iter().flatten().any(|by| !by.is_finite()) {
            all.insert(first, Shared { middle: [0.0; 3], off: [f64::INFINITY; 3] });
            continue;
        }
        let ends = [0, 1, 2].map(|axis| {
            let values = found.iter().map(|by: &Vector| by[axis]);
            values.fold((f64::MAX, f64::MIN), |(least, most), by| (least.min(by), most.max(by)))
        });
        let (middle, off) =
            (ends.map(|(least, most)| (least + most) / 2.0), ends.map(|(least, most)| (most - least) / 2.0));
        all.insert(first, Shared { middle, off });
    }
    Ok(all)
}

/// Points all over a space.
fn points([low, high]: &Space) -> Vec<Vector> {
    let along = |axis: usize| {
        let length = high[axis] - low[axis];
        let steps = ((length / STEP_MM).ceil() as usize).clamp(LEAST_STEPS, MOST_STEPS);
        (0..=steps).map(move |step| low[axis] + length * step as f64 / steps as f64).collect::<Vec<f64>>()
    };
    let (x, y, z) = (along(0), along(1), along(2));
    let mut points = Vec::with_capacity(x.len() * y.len() * z.len());
    for x in &x {
        for y in &y {
            points.extend(z.iter().map(|z| [*x, *y, *z]));
        }
    }
    points
}
