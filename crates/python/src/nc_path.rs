//! Tool paths of `nc-program` as columns: numpy arrays.

use nc_program::{Modal, Program, ToolPath};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// An array of (n, N) that takes the values over without copying them.
fn rows<'py, T: numpy::Element, const N: usize>(
    py: Python<'py>,
    values: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyAny>> {
    let count = values.len();
    Ok(PyArray1::from_vec(py, values.into_flattened())
        .reshape([count, N])?
        .into_any())
}

fn column<'py, T: numpy::Element>(
    py: Python<'py>,
    values: impl IntoIterator<Item = T>,
) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, values.into_iter().collect()).into_any()
}

/// The moves of a tool path, a column each.
pub fn moves<'py>(
    py: Python<'py>,
    program: &Program,
    path: ToolPath,
) -> PyResult<Bound<'py, PyDict>> {
    let count = path.len();
    let columns = PyDict::new(py);
    set_arcs(py, &columns, &path)?;
    columns.set_item(
        "column",
        column(
            py,
            (0..count).map(|index| path.column(index, program) as i32),
        ),
    )?;
    columns.set_item(
        "motion",
        column(py, path.kind.iter().map(|kind| *kind as u8)),
    )?;
    columns.set_item("start_mm", rows(py, path.start)?)?;
    columns.set_item("end_mm", rows(py, path.end)?)?;
    columns.set_item("block", column(py, path.block))?;
    columns.set_item("word", rows(py, path.words)?)?;
    columns.set_item("state", column(py, path.state))?;
    let executed = path.executed;
    let blocks = executed.iter().map(|row| [row.block, row.moves, row.state]);
    columns.set_item("executed", rows(py, blocks.collect())?)?;
    columns.set_item("call", column(py, path.call))?;
    columns.set_item("calls", rows(py, path.calls)?)?;
    let milled = path
        .drilled
        .iter()
        .filter_map(|hole| Some((hole.first, hole.milled?)));
    let (first, space): (Vec<usize>, Vec<[[f64; 3]; 2]>) = milled.chain(path.pockets).unzip();
    columns.set_item("milled_before", column(py, first))?;
    let space = space
        .into_iter()
        .map(|[low, high]| [low[0], low[1], low[2], high[0], high[1], high[2]]);
    columns.set_item("milled_mm", rows(py, space.collect())?)?;
    let (moves, words): (Vec<usize>, Vec<i32>) = path.corners.into_iter().unzip();
    columns.set_item("corner_move", column(py, moves))?;
    columns.set_item("corner_word", column(py, words))?;
    let (before, seconds): (Vec<usize>, Vec<f64>) = path.dwells.into_iter().unzip();
    columns.set_item("dwell_before", column(py, before))?;
    columns.set_item("dwell_s", column(py, seconds))?;
    Ok(columns)
}

/// The columns of arcs; without any, one value throughout.
fn set_arcs(py: Python<'_>, columns: &Bound<'_, PyDict>, path: &ToolPath) -> PyResult<()> {
    let count = path.len();
    if path.arcs.is_empty() {
        let numpy = py.import("numpy")?;
        let throughout = |value: f64, shape: &[usize]| {
            numpy.call_method1("broadcast_to", (value, PyTuple::new(py, shape)?))
        };
        columns.set_item("centre_mm", throughout(f64::NAN, &[count, 3])?)?;
        columns.set_item("sweep_rad", throughout(0.0, &[count])?)?;
        return columns.set_item("programmed_radius_mm", throughout(f64::NAN, &[count])?);
    }
    let (mut centre, mut sweep, mut radius) = (
        vec![[f64::NAN; 3]; count],
        vec![0.0; count],
        vec![f64::NAN; count],
    );
    for arc in &path.arcs {
        centre[arc.of_move] = arc.centre;
        sweep[arc.of_move] = arc.sweep;
        radius[arc.of_move] = arc.radius;
    }
    columns.set_item("centre_mm", rows(py, centre)?)?;
    columns.set_item("sweep_rad", column(py, sweep))?;
    columns.set_item("programmed_radius_mm", column(py, radius))
}

/// The modal states of a tool path, a column each.
pub fn states<'py>(py: Python<'py>, path: &ToolPath) -> PyResult<Bound<'py, PyDict>> {
    let (states, origins) = (&path.states, &path.origins);
    let columns = PyDict::new(py);
    columns.set_item(
        "plane",
        column(py, states.iter().map(|state| state.plane as u8)),
    )?;
    columns.set_item("inch", column(py, states.iter().map(|state| state.inch)))?;
    columns.set_item(
        "diameter",
        column(py, states.iter().map(|state| state.diameter)),
    )?;
    columns.set_item(
        "radius_increments",
        column(py, states.iter().map(|state| state.radius_increments)),
    )?;
    columns.set_item(
        "incremental",
        column(py, states.iter().map(|state| state.incremental)),
    )?;
    columns.set_item(
        "centre_absolute",
        column(py, states.iter().map(|state| state.centre_absolute)),
    )?;
    columns.set_item(
        "feed_mode",
        column(py, states.iter().map(|state| state.feed_mode as u8)),
    )?;
    columns.set_item(
        "feed",
        column(py, states.iter().map(|state| not_yet(state.feed))),
    )?;
    columns.set_item(
        "spindle_mode",
        column(py, states.iter().map(|state| state.spindle_mode as u8)),
    )?;
    let speed = |state: &Modal| not_yet(state.spindle_speed);
    columns.set_item("spindle_speed", column(py, states.iter().map(speed)))?;
    columns.set_item(
        "spindle_limit",
        column(py, states.iter().map(|state| not_yet(state.spindle_limit))),
    )?;
    columns.set_item("tool", column(py, states.iter().map(Modal::tool_in_use)))?;
    columns.set_item(
        "radius_offset",
        column(py, states.iter().map(Modal::radius_offset)),
    )?;
    columns.set_item(
        "compensation",
        column(py, states.iter().map(|state| state.compensation as u8)),
    )?;
    columns.set_item(
        "work_offset",
        column(py, states.iter().map(|state| state.work_offset)),
    )?;
    let (total, register): (Vec<_>, Vec<_>) = origins
        .iter()
        .map(|origin| (origin.total, origin.register))
        .unzip();
    columns.set_item("origin_mm", rows(py, total)?)?;
    columns.set_item("register_mm", rows(py, register)?)?;
    let renamed = origins.iter().map(|origin| origin.renamed).collect();
    columns.set_item("renamed", rows(py, renamed)?)?;
    let tool_number = origins.iter().map(|origin| origin.tool_number);
    columns.set_item("tool_offset", column(py, tool_number))?;
    let subtracted = origins.iter().map(|origin| origin.tool_is_subtracted);
    columns.set_item("tool_offset_subtracted", column(py, subtracted))?;
    let rotary = origins.iter().map(|origin| {
        let [a, b, c, _] = origin.rotary.map(|angle| angle.unwrap_or(f64::NAN));
        [a, b, c]
    });
    columns.set_item("rotary_deg", rows(py, rotary.collect())?)?;
    let turned = origins.iter().map(|origin| origin.turned);
    columns.set_item("turned", column(py, turned))?;
    let linear = origins.iter().map(|origin| origin.is_turned);
    columns.set_item("linear", column(py, linear))?;
    Ok(columns)
}

/// NaN for a value that the program has not given yet.
fn not_yet(value: f64) -> f64 {
    if value < 0.0 {
        f64::NAN
    } else {
        value
    }
}
