//! Binds `nc-program`.

use bytes::Bytes;
use nc_program::{
    lint, meaning, offset_statements, parameters_used, run, Dialect, Finding, Key, Modal, Options,
    Plane, Program, Severity, Tool, ToolPath, Word, WordKind,
};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyIndexError, PyOverflowError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict, PyTuple};

/// Severity, code, message, hint, byte offset.
type FindingTuple = (&'static str, &'static str, String, String, usize);

/// Letter, start, end, start of the value, kind, value, block, reference.
type WordTuple = (
    char,
    usize,
    usize,
    usize,
    &'static str,
    f64,
    usize,
    Option<bool>,
);

/// A dialect: name, resolution in inch and in mm, comment, brackets, address of a radius, formulas without brackets.
type DialectTuple = (
    &'static str,
    f64,
    f64,
    &'static str,
    &'static str,
    char,
    char,
    String,
    bool,
);

/// Number, radius, tip, length, what T adds of geometry and wear (x, y, z), edge; mm.
pub type ToolTuple = (
    Option<i32>,
    f64,
    Option<u8>,
    Option<f64>,
    Option<[f64; 3]>,
    Option<i32>,
);

/// A program as read.
#[pyclass(frozen)]
pub struct NcProgram {
    pub program: Program,
}

#[pymethods]
impl NcProgram {
    #[new]
    fn new(py: Python<'_>, source: PyBackedBytes, dialect: &str) -> PyResult<Self> {
        let dialect = dialect_of(dialect)?;
        let source = Bytes::from_owner(source);
        let program = py.detach(|| Program::read(source, dialect));
        let program = program.map_err(|error| PyOverflowError::new_err(error.bytes.to_string()))?;
        Ok(Self { program })
    }

    /// Number of blocks (lines).
    #[getter]
    fn block_count(&self) -> usize {
        self.program.blocks().len()
    }

    /// The bytes.
    fn source<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.program.source())
    }

    /// Start, end, first word, one past the last word, optional, tape mark.
    fn block(&self, index: usize) -> PyResult<(usize, usize, usize, usize, bool, bool)> {
        let block = self
            .program
            .blocks()
            .get(index)
            .ok_or_else(|| PyIndexError::new_err(index))?;
        let words = self.program.word_range(index);
        Ok((
            block.start as usize,
            block.end as usize,
            words.start,
            words.end,
            block.optional,
            block.tape_mark,
        ))
    }

    /// Letter, start, end, start of the value, kind, value, block, whether it says to be an increment or a position.
    fn word(&self, index: usize) -> PyResult<WordTuple> {
        let word = self
            .program
            .words()
            .get(index)
            .ok_or_else(|| PyIndexError::new_err(index))?;
        Ok(word_tuple(&self.program, word))
    }

    /// What a code does; None where the word is no code that the dialect knows.
    fn meaning(&self, index: usize) -> Option<String> {
        meaning(&self.program, self.program.words().get(index)?)
    }

    /// Index of the block that holds a byte.
    fn block_at(&self, offset: usize) -> usize {
        self.program.block_at(offset)
    }

    /// What can be said without running it.
    fn findings(&self, py: Python<'_>) -> Vec<FindingTuple> {
        py.detach(|| lint(&self.program))
            .into_iter()
            .map(finding_tuple)
            .collect()
    }

    /// Parameters read by expressions, each with the byte of its first use.
    fn parameters_used(&self) -> Vec<(String, usize)> {
        let used = parameters_used(&self.program);
        used.into_iter()
            .map(|(key, at)| (key.text(self.program.dialect()), at))
            .collect()
    }

    /// Tool offset updates: tool, axis, value, start and end of the value, word.
    fn offset_statements(&self) -> Vec<(u32, char, f64, usize, usize, usize)> {
        let found = offset_statements(&self.program);
        found
            .into_iter()
            .map(|s| {
                (
                    s.tool,
                    char::from(s.axis),
                    s.value,
                    s.value_start,
                    s.value_end,
                    s.word,
                )
            })
            .collect()
    }

    /// Runs it: the columns of the tool path, those of its modal states, and the findings.
    #[pyo3(signature = (parameters, optional_blocks, position, block_limit, inch=None, diameter=None, plane=None, tools=Vec::new(), trace=false, work_offsets=Vec::new(), roughing=true))]
    #[allow(clippy::too_many_arguments)]
    fn run<'py>(
        &self,
        py: Python<'py>,
        parameters: Vec<(String, f64)>,
        optional_blocks: bool,
        position: [f64; 3],
        block_limit: usize,
        inch: Option<bool>,
        diameter: Option<bool>,
        plane: Option<u8>,
        tools: Vec<ToolTuple>,
        trace: bool,
        work_offsets: Vec<(usize, [f64; 3])>,
        roughing: bool,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>, Vec<FindingTuple>)> {
        let dialect = self.program.dialect();
        let mut initial = dialect.initial;
        initial.inch = inch.unwrap_or(initial.inch);
        initial.diameter = diameter.unwrap_or(initial.diameter);
        initial.plane = plane.map_or(Ok(initial.plane), plane_of)?;
        let options = Options {
            tools: tools_of(tools),
            parameters: parameters_of(parameters, dialect)?,
            optional_blocks,
            initial: Some(initial),
            unit_is_known: inch.is_some(),
            diameter_is_known: diameter.is_some(),
            position,
            work_offsets,
            block_limit,
            trace,
            roughing,
        };
        let (path, findings) = py.detach(|| run(&self.program, &options));
        let findings = findings.into_iter().map(finding_tuple).collect();
        let states = states(py, &path)?;
        Ok((moves(py, &self.program, path)?, states, findings))
    }
}

/// Tools as Python gives them.
pub fn tools_of(tools: Vec<ToolTuple>) -> Vec<Tool> {
    let tools = tools.into_iter();
    let tools = tools.map(|(number, radius, tip, length, offset, edge)| Tool {
        number,
        radius,
        tip,
        length,
        offset,
        edge,
    });
    tools.collect()
}

/// Parameters by their keys; a ValueError names one that is none of the dialect.
pub fn parameters_of(
    named: Vec<(String, f64)>,
    dialect: &Dialect,
) -> PyResult<Vec<(Key<'static>, f64)>> {
    let keyed = named.into_iter().map(|(name, value)| {
        let key = Key::parse(&name, dialect).map(Key::into_owned);
        let key = key.ok_or_else(|| PyValueError::new_err(name))?;
        Ok((key, value))
    });
    keyed.collect()
}

/// The dialect of that name.
pub fn dialect_of(name: &str) -> PyResult<&'static Dialect> {
    Dialect::named(name).ok_or_else(|| PyValueError::new_err(name.to_owned()))
}

fn plane_of(number: u8) -> PyResult<Plane> {
    match number {
        17 => Ok(Plane::Xy),
        18 => Ok(Plane::Zx),
        19 => Ok(Plane::Yz),
        _ => Err(PyValueError::new_err(number)),
    }
}

fn word_tuple(program: &Program, word: &Word) -> WordTuple {
    let kind = match word.kind {
        WordKind::Number => "number",
        WordKind::Expression => "expression",
        WordKind::Assignment => "assignment",
        WordKind::Statement => "statement",
        WordKind::Flow => "flow",
        WordKind::Name => "name",
        WordKind::Label => "label",
        WordKind::Call => "call",
        WordKind::Unknown => "unknown",
    };
    let (start, end) = (word.start as usize, word.end());
    (
        char::from(word.letter),
        start,
        end,
        program.value_start(word),
        kind,
        word.value,
        program.block_at(start),
        program.reference(word),
    )
}

fn finding_tuple(finding: Finding) -> FindingTuple {
    let severity = match finding.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    (
        severity,
        finding.code,
        finding.message,
        finding.hint,
        finding.at,
    )
}

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

fn moves<'py>(py: Python<'py>, program: &Program, path: ToolPath) -> PyResult<Bound<'py, PyDict>> {
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
    let positions = executed.iter().map(|row| row.position);
    columns.set_item("executed_at_mm", rows(py, positions.collect())?)?;
    let offsets = executed.iter().map(|row| row.offset);
    columns.set_item("executed_offset_mm", rows(py, offsets.collect())?)?;
    columns.set_item("call", column(py, path.call))?;
    columns.set_item("calls", rows(py, path.calls)?)?;
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

fn states<'py>(py: Python<'py>, path: &ToolPath) -> PyResult<Bound<'py, PyDict>> {
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
    columns.set_item("tool", column(py, states.iter().map(|state| state.tool)))?;
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

/// Every dialect as a writer of programs needs it.
#[pyfunction]
fn nc_dialects() -> Vec<DialectTuple> {
    let row = |d: &'static Dialect| {
        let ((inch, mm), (open, close), brackets) = (d.resolution, d.comment, d.brackets);
        (
            d.name,
            inch,
            mm,
            open,
            close,
            char::from(brackets.0),
            char::from(brackets.1),
            d.radius_address(),
            d.formulas,
        )
    };
    nc_program::dialect::DIALECTS.into_iter().map(row).collect()
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcProgram>()?;
    module.add_function(wrap_pyfunction!(nc_dialects, module)?)
}
