//! Binds `nc-program`.

use bytes::Bytes;
use nc_map::{BlockNumbers, Step};
use nc_program::{
    lint, meaning, offset_statements, parameters_used, run, Dialect, Finding, Key, Options, Plane,
    Program, Severity, Tool, ToolPath, Word, WordKind,
};
use pyo3::exceptions::{PyIndexError, PyOverflowError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict};

use crate::nc_path::{moves, states};
use crate::nc_text::unwritable;

/// Severity, code, message, hint, byte offset.
pub type FindingTuple = (
    &'static str,
    &'static str,
    String,
    String,
    usize,
    &'static str,
);

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

/// A dialect: name, resolution in inch and in mm, comment, opening bracket, address of a radius, whether a lead counts
/// along the thread, directions of the tip, the control of which it is a variant, marks of its programs with their points.
type DialectTuple = (
    &'static str,
    f64,
    f64,
    &'static str,
    &'static str,
    char,
    String,
    bool,
    Vec<[f64; 2]>,
    &'static str,
    Vec<(u32, &'static str)>,
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

/// What a run gives; see `NcProgram::run`.
pub type RunTuple<'py> = (
    Bound<'py, PyDict>,
    Bound<'py, PyDict>,
    Vec<FindingTuple>,
    Option<(usize, bool)>,
);

/// A program as read.
#[pyclass(frozen)]
pub struct NcProgram {
    pub program: Program,
    numbers: BlockNumbers,
}

#[pymethods]
impl NcProgram {
    #[new]
    fn new(py: Python<'_>, source: PyBackedBytes, dialect: &str) -> PyResult<Self> {
        let dialect = dialect_of(dialect)?;
        let source = Bytes::from_owner(source);
        let program = py.detach(|| Program::read(source, dialect));
        let program = program.map_err(|error| PyOverflowError::new_err(error.bytes.to_string()))?;
        Ok(Self {
            program,
            numbers: BlockNumbers::default(),
        })
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

    /// Blocks written after one, each on its line and numbered as the program numbers its blocks.
    fn new_lines<'py>(
        &self,
        py: Python<'py>,
        block: usize,
        texts: Vec<Vec<u8>>,
    ) -> Bound<'py, PyBytes> {
        let mut out = Vec::new();
        nc_map::new_lines(&self.program, block, &texts, None, &self.numbers, &mut out);
        PyBytes::new(py, &out)
    }

    /// A word that sets so much more, in program units and steps of that size: start, end and text of its value, and by
    /// how much it is changed as written; None where that rounds to nothing. A ValueError has message and hint.
    fn moved(
        &self,
        word: usize,
        by: f64,
        step: f64,
        comma: bool,
    ) -> PyResult<Option<(usize, usize, String, f64)>> {
        let step = Step::of(self.program.dialect(), step, comma);
        let word = self.program.words().get(word);
        let word = word.ok_or_else(|| PyIndexError::new_err("no such word"))?;
        let moved = nc_map::moved(&self.program, word, step, by).map_err(unwritable)?;
        let text = |bytes: Vec<u8>| bytes.into_iter().map(char::from).collect();
        Ok(moved.map(|moved| (moved.start, moved.end, text(moved.text), moved.by)))
    }

    /// The byte at which a word that a block has not is written into it, and its text with the space beside it.
    fn inserted(&self, block: usize, word: &str) -> (usize, String) {
        let (at, text) = nc_map::inserted(&self.program, block, word.as_bytes());
        (at, text.into_iter().map(char::from).collect())
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

    /// Runs it: the columns of the tool path, those of its modal states, the findings, and the block that states the unit
    /// before any length, with whether it is the inch.
    #[pyo3(signature = (parameters, optional_blocks, position, block_limit, inch=None, diameter=None, plane=None, tools=Vec::new(), trace=false, work_offsets=Vec::new(), roughing=true, placed=true, roughed_contours=false))]
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
        placed: bool,
        roughed_contours: bool,
    ) -> PyResult<RunTuple<'py>> {
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
            rotary: None,
            position,
            work_offsets,
            block_limit,
            trace,
            roughing,
            roughed_contours,
        };
        let (path, findings) = py.detach(|| {
            let (path, findings) = run(&self.program, &options);
            (if placed { path.placed() } else { path }, findings)
        });
        run_tuple(py, &self.program, path, findings)
    }
}

/// What a run gives, as Python takes it.
pub fn run_tuple<'py>(
    py: Python<'py>,
    program: &Program,
    path: ToolPath,
    findings: Vec<Finding>,
) -> PyResult<RunTuple<'py>> {
    let findings = findings.into_iter().map(finding_tuple).collect();
    let states = states(py, &path)?;
    let unit = path.unit_stated;
    Ok((moves(py, program, path)?, states, findings, unit))
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

/// Parameters by their keys; a ValueError names one that is not one of the dialect.
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

pub(crate) fn plane_of(number: u8) -> PyResult<Plane> {
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
        finding.unseen.name(),
    )
}

/// Every dialect as a writer of programs needs it.
#[pyfunction]
fn nc_dialects() -> Vec<DialectTuple> {
    let row = |d: &'static Dialect| {
        let ((inch, mm), (open, close)) = (d.resolution, d.comment);
        (
            d.name,
            inch,
            mm,
            open,
            close,
            char::from(d.brackets.0),
            d.radius_address(),
            d.rules.lead_along_thread,
            (0..=9)
                .map(|number| nc_program::tip_direction(number, d))
                .collect(),
            d.like,
            d.marks.to_vec(),
        )
    };
    nc_program::dialect::dialects().map(row).collect()
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcProgram>()?;
    module.add_function(wrap_pyfunction!(nc_dialects, module)?)
}
