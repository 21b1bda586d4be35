//! Binds `Session`: a program run in parts.

use nc_program::dialect::Letters;
use nc_program::{jumps, rotary_letters, Options, Session};
use pyo3::prelude::*;

use crate::nc::{dialect_of, parameters_of, run_tuple, NcProgram, RunTuple};

/// A run in parts, of a program of which no part jumps.
#[pyclass]
struct NcSession {
    session: Session,
}

#[pymethods]
impl NcSession {
    #[new]
    fn new(
        dialect: &str,
        parameters: Vec<(String, f64)>,
        optional_blocks: bool,
        work_offsets: Vec<(usize, [f64; 3])>,
        inch: Option<bool>,
        rotary: &str,
    ) -> PyResult<Self> {
        let dialect = dialect_of(dialect)?;
        let mut initial = dialect.initial;
        initial.inch = inch.unwrap_or(initial.inch);
        let options = Options {
            initial: Some(initial),
            unit_is_known: inch.is_some(),
            rotary: Some(Letters::of(rotary.as_bytes())),
            parameters: parameters_of(parameters, dialect)?,
            optional_blocks,
            work_offsets,
            block_limit: usize::MAX,
            roughing: true,
            ..Options::default()
        };
        Ok(Self {
            session: Session::new(options),
        })
    }

    /// Runs the blocks of the next part that come before `until`.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        part: &NcProgram,
        until: usize,
    ) -> PyResult<RunTuple<'py>> {
        let (path, findings) = py.detach(|| self.session.run(&part.program, until));
        run_tuple(py, &part.program, path.placed(), findings)
    }
}

/// Whether a block of a part may send the run elsewhere, and the letters of the rotary axes that it names.
#[pyfunction]
fn nc_part(part: &NcProgram) -> (bool, String) {
    (jumps(&part.program), rotary_letters(&part.program).text())
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcSession>()?;
    module.add_function(wrap_pyfunction!(nc_part, module)?)
}
