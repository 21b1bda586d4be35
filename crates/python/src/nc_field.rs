//! Binds the fields of `nc-map`: tables, affine ones, functions of Python.

use nc_map::field::Trouble;
use nc_map::{Affine, Field, Grid, Place, Vector};
use nc_program::dialect::Letters;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A function of Python: positions (n, 3) to displacements (n, 3), mm. One that is told more gets, beside them, work
/// offsets and tools (n,), the way of travel, what the tool offset in force adds, where A, B, C stand (n, 3), and which lie
/// in a cut (n,).
struct Function {
    function: Py<PyAny>,
    told: Told,
    follows: Letters,
    /// Those of these that the program names: where one has turned, the start of a move is displaced otherwise.
    named: Letters,
}

/// What a function is told beside the positions.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Told {
    Nothing,
    Places,
    PlacesAndTravel,
}

impl Function {
    /// A machine is asked at positions of the work offset, whatever the register calls them.
    fn asked(&self, points: &[Vector], places: &[Place]) -> Vec<Vector> {
        if self.told == Told::Nothing {
            return points.to_vec();
        }
        let pairs = points.iter().zip(places);
        pairs
            .map(|(point, place)| [0, 1, 2].map(|axis| point[axis] + place.named[axis]))
            .collect()
    }
}

impl Field for Function {
    fn knows_travel(&self) -> bool {
        self.told == Told::PlacesAndTravel || !self.named.is_empty()
    }

    fn follows(&self) -> Letters {
        self.follows
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
                let stated = |p: &Place| {
                    [0, 1, 2].map(|axis| match self.named.has(b"ABC"[axis]) {
                        true => p.rotary[axis],
                        false => f64::NAN,
                    })
                };
                let rotary: Vec<_> = places.iter().flat_map(stated).collect();
                let rotary = rotary.into_pyarray(py).reshape([places.len(), 3])?;
                let cuts: Vec<_> = places.iter().map(|p| p.cuts).collect();
                let cuts = cuts.into_pyarray(py);
                let (work, tool) = (work.into_pyarray(py), tool.into_pyarray(py));
                self.function
                    .call1(py, (rows, work, tool, travel, offset, rotary, cuts))?
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

enum Kind {
    Affine(Affine),
    Grid(Grid),
    Function(Py<PyAny>, Told, Letters),
}

/// A displacement for every position.
#[pyclass(frozen)]
pub struct NcField {
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
    /// work offsets, tools, travel, tool offsets and rotary axes too; True: it differs by the way of travel. `follows`
    /// are the rotary axes with whose places it differs.
    #[staticmethod]
    #[pyo3(signature = (function, knows_travel=None, follows=""))]
    fn function(function: Py<PyAny>, knows_travel: Option<bool>, follows: &str) -> Self {
        let told = match knows_travel {
            None => Told::Nothing,
            Some(false) => Told::Places,
            Some(true) => Told::PlacesAndTravel,
        };
        Self {
            kind: Kind::Function(function, told, Letters::of(follows.as_bytes())),
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
        let mut field = self.made(py, "");
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

impl NcField {
    /// The field, to be asked for a program that names those rotary axes.
    pub fn made(&self, py: Python<'_>, rotary: &str) -> Box<dyn Field + Send + Sync> {
        match &self.kind {
            Kind::Affine(affine) => Box::new(*affine),
            Kind::Grid(grid) => Box::new(grid.clone()),
            Kind::Function(function, told, follows) => Box::new(Function {
                function: function.clone_ref(py),
                told: *told,
                follows: *follows,
                named: Letters::of(&both(*follows, rotary)),
            }),
        }
    }
}

fn both(follows: Letters, rotary: &str) -> Vec<u8> {
    rotary
        .bytes()
        .filter(|letter| follows.has(*letter))
        .collect()
}

/// A position that is asked for outside of a program: G54, no tool, no way of travel.
const NOWHERE: Place = Place {
    work_offset: 1,
    tool: -1,
    shift: [0.0; 3],
    named: [0.0; 3],
    tool_offset: [0.0; 3],
    travel: [0; 3],
    cuts: false,
    rotary: [f64::NAN; 3],
};

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NcField>()
}
