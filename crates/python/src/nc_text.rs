//! Binds how numbers are written and words found.

use nc_map::{mentions, Step};
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

/// The number of that many steps of that size in program units, as one that is new.
#[pyfunction]
fn nc_number(steps: i64, step: f64, dialect: &str, comma: bool) -> PyResult<String> {
    let mut out = Vec::new();
    Step::of(dialect_of(dialect)?, step, comma).write(&mut out, steps);
    Ok(String::from_utf8(out)?)
}

/// The same in the style of an old one.
#[pyfunction]
fn nc_restyled(old: &[u8], steps: i64, step: f64, dialect: &str, comma: bool) -> PyResult<String> {
    let mut out = Vec::new();
    Step::of(dialect_of(dialect)?, step, comma).restyle(&mut out, old, steps);
    Ok(String::from_utf8(out)?)
}

/// The expression of a word plus that many steps of that size; None where it takes no sum.
#[pyfunction]
fn nc_with_term(program: &NcProgram, word: usize, steps: i64, step: f64) -> Option<String> {
    let program = &program.program;
    let step = Step::of(program.dialect(), step, false);
    let word = program.words().get(word);
    let text = word.and_then(|word| nc_map::with_term(program, word, step, steps));
    Some(text?.into_iter().map(char::from).collect())
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
    module.add_function(wrap_pyfunction!(nc_with_term, module)?)?;
    module.add_function(wrap_pyfunction!(nc_writes_comma, module)?)?;
    module.add_function(wrap_pyfunction!(nc_written_decimals, module)?)
}
