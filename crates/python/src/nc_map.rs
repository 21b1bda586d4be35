//! Binds `nc-map`.

use bytes::Bytes;
use nc_map::field::Trouble;
use nc_map::{
    first_blocks, letters, mentions, named_axes, Affine, Field, Grid, Limits, Mapper, Place,
    Refusal, Saying, Step, Vector,
};
use nc_program::{jumps, Options, Program};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::nc::{dialect_of, parameters_of, tools_of, NcProgram, ToolTuple};

/// Code, message, hint, line, column.
type RefusalTuple = (&'static str, String, String, usize, usize);

/// A function of Python: positions (n, 3) to displacements (n, 3), mm. One that is told more gets, beside them, work
/// offsets and tools (n,), the way of travel and what the tool offset in force adds (n, 3).
struct Function {
    function: Py<PyAny>,
    told: Told,
}

/// What a function is told beside the positions.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Told {
    Nothing,
    Places,
    PlacesAndTravel,
}

impl Function {
    /// A machine is asked at positions of the work offset, whatever the program calls them.
    fn asked(&self, points: &[Vector], places: &[Place]) -> Vec<Vector> {
        if self.told == Told::Nothing {
            return points.to_vec();
        }
        let pairs = points.iter().zip(places);
        pairs
            .map(|(point, place)| [0, 1, 2].map(|axis| point[axis] + place.shift[axis]))
            .collect()
    }
}

impl Field for Function {
    fn knows_travel(&self) -> bool {
        self.told == Told::PlacesAndTravel
    }

    fn displacements(
        &mut self,
        points: &[Vector],
        places: &[Place],
        found: &mut Vec<Vector>,
    ) -> Result<(), Trouble> {
        let asked = Python::attach(|py| {
            let flat = self.asked(points, places).into_flattened().into_pyarray(py);
            let rows = flat.reshape([points.len(), 3])?;
            let answer = if self.told == Told::Nothing {
                self.function.call1(py, (rows,))?
            } else {
                let work: Vec<_> = places.iter().map(|p| i64::from(p.work_offset)).collect();
                let tool: Vec<_> = places.iter().map(|p| i64::from(p.tool)).collect();
                let travel: Vec<_> = places
                    .iter()
                    .flat_map(|p| p.travel.map(f64::from))
                    .collect();
                let travel = travel.into_pyarray(py).reshape([places.len(), 3])?;
                let offset: Vec<_> = places.iter().flat_map(|p| p.tool_offset).collect();
                let offset = offset.into_pyarray(py).reshape([places.len(), 3])?;
                let (work, tool) = (work.into_pyarray(py), tool.into_pyarray(py));
                self.function
                    .call1(py, (rows, work, tool, travel, offset))?
            };
            let answer: PyReadonlyArray2<f64> = answer.extract(py).map_err(|_| {
                PyTypeError::new_err(
                    "a field answers an array of floats (n, 3) to positions (n, 3)",
                )
            })?;
            let rows = answer.as_array();
            if rows.shape() != [points.len(), 3] {
                let message = format!(
                    "a field answered {:?} to {} positions",
                    rows.shape(),
                    points.len()
                );
                return Err(PyTypeError::new_err(message));
            }
            found.clear();
            found.extend(rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]));
            Ok(())
        });
        asked.map_err(|error: PyErr| Trouble::Failed(Box::new(error)))
    }
}

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
        tolerance_mm: f64,
        size_mm: f64,
        slope: f64,
        tools: Vec<ToolTuple>,
        work_offsets: Vec<(usize, [f64; 3])>,
        py: Python<'_>,
    ) -> PyResult<Self> {
        let dialect = dialect_of(dialect)?;
        let parameters = parameters_of(parameters, dialect)?;
        let options = Options {
            parameters,
            optional_blocks,
            tools: tools_of(tools),
            work_offsets,
            block_limit: if whole {
                Options::default().block_limit
            } else {
                usize::MAX
            },
            ..Options::default()
        };
        let limits = Limits {
            tolerance_mm,
            size_mm,
            slope,
        };
        Ok(Self {
            mapper: Mapper::new(dialect, options, limits, whole, named),
            field: field.kind.made(py),
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

    /// Blocks, moves, edits, blocks added, largest displacement (3,), blocks not run, line of the first.
    fn summary(&self) -> (usize, usize, usize, usize, [f64; 3], usize, usize) {
        let s = self.mapper.summary();
        (
            s.blocks,
            s.moves,
            s.edits,
            s.added,
            s.largest_mm,
            s.not_run,
            s.first_not_run,
        )
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

enum Kind {
    Affine(Affine),
    Grid(Grid),
    Function(Py<PyAny>, Told),
}

impl Kind {
    fn made(&self, py: Python<'_>) -> Box<dyn Field + Send + Sync> {
        match self {
            Self::Affine(affine) => Box::new(*affine),
            Self::Grid(grid) => Box::new(grid.clone()),
            Self::Function(function, told) => Box::new(Function {
                function: function.clone_ref(py),
                told: *told,
            }),
        }
    }
}

/// A displacement for every position.
#[pyclass(frozen)]
struct NcField {
    kind: Kind,
}

#[pymethods]
impl NcField {
    /// p ↦ matrix·p + shift.
    #[staticmethod]
    fn affine(matrix: [[f64; 3]; 3], shift: [f64; 3]) -> Self {
        Self {
            kind: Kind::Affine(Affine { matrix, shift }),
        }
    }

    /// Linear between the nodes of a grid: (n, 3) displacements, z fastest.
    #[staticmethod]
    fn grid(
        x: Vec<f64>,
        y: Vec<f64>,
        z: Vec<f64>,
        displacement: PyReadonlyArray2<f64>,
    ) -> PyResult<Self> {
        let rows = displacement.as_array();
        let nodes = rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]);
        let grid = Grid::new([x, y, z], nodes.collect());
        let grid =
            grid.ok_or_else(|| PyValueError::new_err("axes that do not rise, or a wrong count"))?;
        Ok(Self {
            kind: Kind::Grid(grid),
        })
    }

    /// A function of positions (n, 3) that answers displacements (n, 3). With `knows_travel` given it is asked with
    /// work offsets, tools, travel and tool offsets too; True: it differs by the way of travel.
    #[staticmethod]
    #[pyo3(signature = (function, knows_travel=None))]
    fn function(function: Py<PyAny>, knows_travel: Option<bool>) -> Self {
        let told = match knows_travel {
            None => Told::Nothing,
            Some(false) => Told::Places,
            Some(true) => Told::PlacesAndTravel,
        };
        Self {
            kind: Kind::Function(function, told),
        }
    }

    /// Displacements at positions (n, 3).
    fn displacements<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = points.as_array();
        let points: Vec<Vector> = rows
            .rows()
            .into_iter()
            .map(|row| [row[0], row[1], row[2]])
            .collect();
        let mut found = Vec::new();
        let mut field = self.kind.made(py);
        let places = vec![NOWHERE; points.len()];
        match field.displacements(&points, &places, &mut found) {
            Ok(()) => {
                let count = found.len();
                Ok(PyArray1::from_vec(py, found.into_flattened())
                    .reshape([count, 3])?
                    .into_any())
            }
            Err(Trouble::Outside(index)) => Err(PyValueError::new_err(index)),
            Err(Trouble::Failed(cause)) => Err(PyValueError::new_err(cause.to_string())),
        }
    }
}

/// A position that is asked for outside of a program: G54, no tool, no way of travel.
const NOWHERE: Place = Place {
    work_offset: 1,
    tool: -1,
    shift: [0.0; 3],
    tool_offset: [0.0; 3],
    travel: [0; 3],
};

type FirstBlocks = (Option<usize>, Option<usize>, Option<usize>, Option<usize>);

/// Number of blocks, whether one may send its run elsewhere, which of X, Y, Z are named, the block in which each letter
/// is first met, and the blocks that first set an offset by G10, first set the position register, first go to a place of the
/// machine, and first make a spline or a tangent arc.
type Surveyed = (usize, bool, [bool; 3], Vec<(char, usize)>, FirstBlocks);

/// Of some lines of a program.
#[pyfunction]
fn nc_survey(py: Python<'_>, source: PyBackedBytes, dialect: &str) -> PyResult<Surveyed> {
    let dialect = dialect_of(dialect)?;
    Ok(
        py.detach(|| match Program::read(Bytes::from_owner(source), dialect) {
            Ok(program) => {
                let letters = letters(&program);
                (
                    program.blocks().len(),
                    jumps(&program),
                    named_axes(&letters),
                    letters
                        .into_iter()
                        .map(|(letter, block)| (letter.into(), block))
                        .collect(),
                    first_blocks(&program).into(),
                )
            }
            Err(_) => (0, true, [true; 3], Vec::new(), (None, None, None, None)),
        }),
    )
}

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
) -> PyResult<Bound<'py, PyArray2<bool>>> {
    let (word, _) = word.as_slice()?.as_chunks::<3>();
    let (renamed, _) = renamed.as_slice()?.as_chunks::<3>();
    let moves = block
        .as_slice()?
        .iter()
        .zip(word)
        .zip(incremental.as_slice()?)
        .zip(renamed);
    let sayings = moves.map(|(((block, words), incremental), renamed)| Saying {
        block: *block as usize,
        words: *words,
        incremental: *incremental,
        renamed: *renamed,
    });
    let said = nc_map::said(&program.program, sayings);
    let count = said.len();
    said.into_flattened().into_pyarray(py).reshape([count, 3])
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcMapper>()?;
    module.add_class::<NcField>()?;
    module.add_function(wrap_pyfunction!(nc_mentions, module)?)?;
    module.add_function(wrap_pyfunction!(nc_said, module)?)?;
    module.add_function(wrap_pyfunction!(nc_writes_comma, module)?)?;
    module.add_function(wrap_pyfunction!(nc_number, module)?)?;
    module.add_function(wrap_pyfunction!(nc_restyled, module)?)?;
    module.add_function(wrap_pyfunction!(nc_survey, module)?)
}
