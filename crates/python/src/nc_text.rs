//! Binds how numbers are written and words found.

use nc_map::{circle, equidistant, mentions, Circle, Step};
use nc_program::table::{write_rows, Column};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::nc::{dialect_of, NcProgram};

/// Whether a word of ASCII letters stands in a text, in capitals or not.
#[pyfunction]
fn nc_mentions(text: &[u8], word: &[u8]) -> bool {
    mentions(text, word)
}

/// Whether a program of Klartext writes decimal commas.
#[pyfunction]
fn nc_writes_comma(program: &NcProgram) -> bool {
    nc_map::writes_comma(&program.program)
}

/// How many decimals the coordinates of a program have, nine at most.
#[pyfunction]
fn nc_written_decimals(program: &NcProgram) -> usize {
    nc_map::written_decimals(&program.program)
}

/// Message and hint of a refusal, as Python gets them.
pub fn unwritable(refused: (String, String)) -> PyErr {
    PyValueError::new_err(refused)
}

/// A number of program units as one that is new, in steps of that size, and the value that it then has.
#[pyfunction]
fn nc_number(value: f64, step: f64, dialect: &str, comma: bool) -> PyResult<(String, f64)> {
    let step = Step::of(dialect_of(dialect)?, step, comma);
    let (steps, mut out) = (step.reachable(value).map_err(unwritable)?, Vec::new());
    step.write(&mut out, steps);
    Ok((String::from_utf8(out)?, step.value(steps)))
}

/// The same in the style of an old one.
#[pyfunction]
fn nc_restyled(old: &[u8], value: f64, step: f64, dialect: &str, comma: bool) -> PyResult<String> {
    let step = Step::of(dialect_of(dialect)?, step, comma);
    let (steps, mut out) = (step.reachable(value).map_err(unwritable)?, Vec::new());
    step.restyle(&mut out, old, steps);
    Ok(String::from_utf8(out)?)
}

/// The words of an arc's circle in the plane of two axes: its radius, or its centre from the start. Positions and the
/// size of a program unit in mm.
#[pyfunction]
#[pyo3(signature = (axes, centre_mm, start_mm, by_radius, unit_mm, step, dialect, comma, end_mm=None))]
#[allow(clippy::too_many_arguments)]
fn nc_circle(
    axes: [usize; 2],
    centre_mm: [f64; 3],
    start_mm: [f64; 3],
    by_radius: bool,
    unit_mm: f64,
    step: f64,
    dialect: &str,
    comma: bool,
    end_mm: Option<[f64; 3]>,
) -> PyResult<String> {
    let (dialect, [first, second]) = (dialect_of(dialect)?, axes);
    if first.max(second) > 2 {
        return Err(PyValueError::new_err(axes));
    }
    let moved = |end| equidistant(centre_mm, start_mm, end, first, second);
    let centre = end_mm.map_or(centre_mm, moved);
    let (of, mut out) = (
        Circle {
            axes,
            centre,
            start: start_mm,
            origin: start_mm,
            by_radius,
        },
        Vec::new(),
    );
    let step = Step::of(dialect, step, comma);
    circle(dialect, step, unit_mm, &of, &mut out);
    Ok(String::from_utf8(out)?)
}

/// A column as Python gives it: numbers and their decimals, or indices and their names.
#[derive(FromPyObject)]
enum ColumnGiven<'py> {
    Number(PyReadonlyArray1<'py, f64>, usize),
    Name(PyReadonlyArray1<'py, u32>, Vec<String>),
}

impl ColumnGiven<'_> {
    /// The column, where it has those rows and every name.
    fn column(&self, last: usize) -> Option<Column<'_>> {
        let (column, rows) = match self {
            Self::Number(values, decimals) => {
                let values = values.as_slice().ok()?;
                (Column::Number(values, *decimals), values.len())
            }
            Self::Name(which, names) => {
                let which = which.as_slice().ok()?;
                which
                    .iter()
                    .all(|&at| (at as usize) < names.len())
                    .then_some(())?;
                (Column::Name(which, names), which.len())
            }
        };
        (rows >= last).then_some(column)
    }
}

/// Rows of a table from `first` to before `last`, a line each.
#[pyfunction]
fn nc_rows(
    py: Python<'_>,
    columns: Vec<ColumnGiven<'_>>,
    first: usize,
    last: usize,
) -> PyResult<String> {
    let columns: Option<Vec<_>> = columns.iter().map(|given| given.column(last)).collect();
    let columns = columns.ok_or_else(|| {
        PyValueError::new_err("a column lacks rows or names, or is not contiguous")
    })?;
    let mut out = Vec::new();
    py.detach(|| write_rows(&mut out, &columns, first..last));
    Ok(String::from_utf8(out)?)
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(nc_mentions, module)?)?;
    module.add_function(wrap_pyfunction!(nc_number, module)?)?;
    module.add_function(wrap_pyfunction!(nc_restyled, module)?)?;
    module.add_function(wrap_pyfunction!(nc_rows, module)?)?;
    module.add_function(wrap_pyfunction!(nc_circle, module)?)?;
    module.add_function(wrap_pyfunction!(nc_writes_comma, module)?)?;
    module.add_function(wrap_pyfunction!(nc_written_decimals, module)?)
}
