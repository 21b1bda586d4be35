//! Binds `nc-map`.

use bytes::Bytes;
use nc_map::{
    first_blocks, letters, named_axes, writes_comma, written_decimals, Field, Limits, Mapper,
    Refusal, Saying, Surveyed,
};
use nc_program::dialect::Letters;
use nc_program::{jumps, place_read, rotary_letters, Options, Program};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::nc::{dialect_of, parameters_of, plane_of, tools_of, NcProgram, ToolTuple};
use crate::nc_field::NcField;

/// Code, message, hint, line, column.
type RefusalTuple = (&'static str, String, String, usize, usize);

/// What was done; see `NcMapper::summary`.
type SummaryTuple = (
    usize,
    usize,
    usize,
    usize,
    [f64; 3],
    usize,
    usize,
    usize,
    Option<(usize, bool)>,
);

/// A field on its way through a program.
#[pyclass]
struct NcMapper {
    mapper: Mapper,
    field: Box<dyn Field + Send + Sync>,
    /// Where the field's own function failed, line and column; 0 before.
    failed_at: (usize, usize),
}

#[pymethods]
impl NcMapper {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        field: &NcField,
        dialect: &str,
        parameters: Vec<(String, f64)>,
        optional_blocks: bool,
        whole: bool,
        named: [bool; 3],
        comma: bool,
        tolerance_mm: f64,
        size_mm: f64,
        slope: f64,
        tools: Vec<ToolTuple>,
        work_offsets: Vec<(usize, [f64; 3])>,
        inch: Option<bool>,
        rotary: &str,
        decimals: usize,
        py: Python<'_>,
    ) -> PyResult<Self> {
        let dialect = dialect_of(dialect)?;
        let parameters = parameters_of(parameters, dialect)?;
        let mut initial = dialect.initial;
        initial.inch = inch.unwrap_or(initial.inch);
        let options = Options {
            initial: Some(initial),
            unit_is_known: inch.is_some(),
            rotary: Some(Letters::of(rotary.as_bytes())),
            parameters,
            optional_blocks,
            tools: tools_of(tools),
            work_offsets,
            roughed_contours: true,
            block_limit: if whole {
                Options::default().block_limit
            } else {
                usize::MAX
            },
            ..Options::default()
        };
        let surveyed = Surveyed {
            whole,
            named,
            comma,
            decimals,
        };
        let limits = Limits {
            tolerance_mm,
            size_mm,
            slope,
        };
        Ok(Self {
            mapper: Mapper::new(dialect, options, limits, surveyed),
            field: field.made(py, rotary),
            failed_at: (0, 0),
        })
    }

    /// What the next bytes give; and why it goes no further, if it does not.
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        bytes: &[u8],
    ) -> PyResult<(Bound<'py, PyBytes>, Option<RefusalTuple>)> {
        let mut out = Vec::with_capacity(bytes.len() + bytes.len() / 8);
        let (mapper, field) = (&mut self.mapper, self.field.as_mut());
        let done = py.detach(|| mapper.push(bytes, field, &mut out));
        Ok((PyBytes::new(py, &out), self.told(done)?))
    }

    /// What is left gives.
    fn finish<'py>(
        &mut self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyBytes>, Option<RefusalTuple>)> {
        let mut out = Vec::new();
        let (mapper, field) = (&mut self.mapper, self.field.as_mut());
        let done = py.detach(|| mapper.finish(field, &mut out));
        Ok((PyBytes::new(py, &out), self.told(done)?))
    }

    /// Blocks, moves, edits, blocks added, largest displacement (3,), blocks not run, line of the first, line at which a
    /// roughed contour turns back; the line that states the unit before any length, and whether it is the inch.
    fn summary(&self) -> SummaryTuple {
        let s = self.mapper.summary();
        (
            s.blocks,
            s.moves,
            s.edits,
            s.added,
            s.largest_mm,
            s.not_run,
            s.first_not_run,
            s.turns_back,
            s.unit_stated,
        )
    }

    /// Has all refusals gathered instead of ending at the first; nothing is written then.
    fn gather(&mut self) {
        self.mapper.gather();
    }

    /// Those gathered: code, message, hint, line, column, and what the field's own function raised.
    fn obstacles(&mut self, py: Python<'_>) -> Vec<(RefusalTuple, Option<Py<PyAny>>)> {
        let told = |refusal: Refusal| {
            let raised = refusal
                .cause
                .and_then(|cause| cause.downcast::<PyErr>().ok());
            let raised = raised.map(|error| error.into_value(py).into_any());
            let Refusal {
                code,
                message,
                hint,
                line,
                column,
                ..
            } = refusal;
            ((code, message, hint, line, column), raised)
        };
        self.mapper.take_obstacles().into_iter().map(told).collect()
    }

    /// Line and column at which the field's own function failed.
    #[getter]
    fn failed_at(&self) -> (usize, usize) {
        self.failed_at
    }
}

impl NcMapper {
    /// A refusal as a tuple; what the field's own function raised is raised again.
    fn told(&mut self, done: Result<(), Refusal>) -> PyResult<Option<RefusalTuple>> {
        let Err(refusal) = done else { return Ok(None) };
        if let Some(cause) = refusal.cause {
            self.failed_at = (refusal.line, refusal.column);
            return Err(match cause.downcast::<PyErr>() {
                Ok(error) => *error,
                Err(other) => PyValueError::new_err(other.to_string()),
            });
        }
        Ok(Some((
            refusal.code,
            refusal.message,
            refusal.hint,
            refusal.line,
            refusal.column,
        )))
    }
}

type FirstBlocks = (Option<usize>, Option<usize>, Option<usize>, Option<usize>);

/// Number of blocks, whether one may send its run elsewhere, or reads where the tool stands, which of X, Y, Z are named, the block in which each letter
/// is first met, and the blocks that first set an offset by G10, first set the position register, first go to a place of the
/// machine, and first make a spline or a tangent arc; whether decimal commas are written; the decimals of coordinates; the
/// letters of rotary axes.
type SurveyTuple = (
    usize,
    bool,
    [bool; 3],
    Vec<(char, usize)>,
    FirstBlocks,
    bool,
    usize,
    String,
);

/// Of some lines of a program.
#[pyfunction]
fn nc_survey(py: Python<'_>, source: PyBackedBytes, dialect: &str) -> PyResult<SurveyTuple> {
    let dialect = dialect_of(dialect)?;
    Ok(
        py.detach(|| match Program::read(Bytes::from_owner(source), dialect) {
            Ok(program) => {
                let letters = letters(&program);
                (
                    program.blocks().len(),
                    jumps(&program) || place_read(&program).is_some(),
                    named_axes(&letters, dialect),
                    letters
                        .into_iter()
                        .map(|(letter, block)| (letter.into(), block))
                        .collect(),
                    first_blocks(&program).into(),
                    writes_comma(&program),
                    written_decimals(&program),
                    rotary_letters(&program).text(),
                )
            }
            Err(_) => (
                0,
                true,
                [true; 3],
                Vec::new(),
                (None, None, None, None),
                false,
                0,
                String::new(),
            ),
        }),
    )
}

/// Whether X, Y, Z stand where the program said, after each of its moves: (n, 3), from the block of each (n,), the words
/// that set its end (n, 3), whether its coordinates are increments (n,), and how often its axes were renamed (n, 3).
#[pyfunction]
fn nc_said<'py>(
    py: Python<'py>,
    program: &NcProgram,
    block: PyReadonlyArray1<i32>,
    word: PyReadonlyArray2<i32>,
    incremental: PyReadonlyArray1<bool>,
    renamed: PyReadonlyArray2<u32>,
    plane: PyReadonlyArray1<u8>,
) -> PyResult<Bound<'py, PyArray2<bool>>> {
    let (word, _) = word.as_slice()?.as_chunks::<3>();
    let (renamed, _) = renamed.as_slice()?.as_chunks::<3>();
    let moves = block
        .as_slice()?
        .iter()
        .zip(word)
        .zip(incremental.as_slice()?)
        .zip(renamed)
        .zip(plane.as_slice()?);
    let sayings = moves.map(|((((block, words), incremental), renamed), plane)| {
        Ok(Saying {
            block: *block as usize,
            words: *words,
            incremental: *incremental,
            renamed: *renamed,
            third: plane_of(*plane)?.axes().2,
        })
    });
    let said = nc_map::said(&program.program, sayings.collect::<PyResult<Vec<_>>>()?);
    let count = said.len();
    said.into_flattened().into_pyarray(py).reshape([count, 3])
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcMapper>()?;
    module.add_function(wrap_pyfunction!(nc_said, module)?)?;
    module.add_function(wrap_pyfunction!(nc_survey, module)?)
}
