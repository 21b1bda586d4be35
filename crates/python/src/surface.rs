//! `surface-fit`, `spatial` and `nurbs` for Python: arrays in, arrays out.

use curve_fit::SplineSpace;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use nurbs::{Foot, Patch};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use spatial::{Decay, Points};
use surface_fit::{Direction, Scattered};

fn refuse(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

fn direction(
    interior: &PyReadonlyArray1<'_, f64>,
    degree: usize,
    at: &PyReadonlyArray1<'_, f64>,
) -> PyResult<Direction> {
    let space = SplineSpace::new(interior.as_slice()?, 1.0, degree).map_err(refuse)?;
    Direction::new(&space, at.as_slice()?).map_err(refuse)
}

/// Least-squares tensor-product spline on a grid of [0, 1] × [0, 1]: its coefficients.
#[pyfunction]
fn fit_surface_grid<'py>(
    py: Python<'py>,
    knots: (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    degrees: (usize, usize),
    at: (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    values: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let u = direction(&knots.0, degrees.0, &at.0)?;
    let v = direction(&knots.1, degrees.1, &at.1)?;
    if values.shape() != [u.points(), v.points()] {
        return Err(refuse(
            "values must be as many rows and columns as there are points",
        ));
    }
    let coefficients = surface_fit::fit_grid(&u, &v, values.as_slice()?).map_err(refuse)?;
    coefficients
        .into_pyarray(py)
        .reshape([u.unknowns(), v.unknowns()])
}

/// Tensor-product splines of [0, 1] × [0, 1] at n points anywhere: products with the design matrix A.
#[pyclass(frozen)]
struct ScatteredSplines {
    spaces: [SplineSpace; 2],
    at: [Vec<f64>; 2],
}

impl ScatteredSplines {
    fn splines(&self) -> PyResult<Scattered<'_>> {
        let [u, v] = &self.spaces;
        Scattered::new([u, v], [&self.at[0], &self.at[1]]).map_err(refuse)
    }
}

#[pymethods]
impl ScatteredSplines {
    #[new]
    fn new(
        knots: (PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>),
        degrees: (usize, usize),
        at: (PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>),
    ) -> PyResult<Self> {
        let space = |knots: &PyReadonlyArray1<'_, f64>, degree| {
            SplineSpace::new(knots.as_slice()?, 1.0, degree).map_err(refuse)
        };
        let spaces = [space(&knots.0, degrees.0)?, space(&knots.1, degrees.1)?];
        let at = [at.0.as_slice()?.to_vec(), at.1.as_slice()?.to_vec()];
        let made = Self { spaces, at };
        made.splines()?;
        Ok(made)
    }

    /// AᵀA (m, m).
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let splines = self.splines()?;
        let unknowns = splines.unknowns();
        let normal = py.detach(|| splines.normal());
        normal.into_pyarray(py).reshape([unknowns, unknowns])
    }

    /// AᵀV (m, k) for values (n, k).
    fn sums<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Matrix<'py>> {
        let splines = self.splines()?;
        multiplied(py, &values, splines.unknowns(), |v, k| splines.sums(v, k))
    }

    /// A F (n, k) for factors (m, k).
    fn combined<'py>(
        &self,
        py: Python<'py>,
        factors: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Matrix<'py>> {
        let splines = self.splines()?;
        multiplied(py, &factors, splines.points(), |f, k| {
            splines.combined(f, k)
        })
    }

    /// a M aᵀ (n,) of every row a of A, for a matrix (m, m).
    fn squares<'py>(
        &self,
        py: Python<'py>,
        matrix: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let splines = self.splines()?;
        let matrix = matrix.as_slice()?;
        let squares = py.detach(|| splines.squares(matrix)).map_err(refuse)?;
        Ok(squares.into_pyarray(py))
    }
}

/// What becomes of a matrix of k columns: another one of k columns.
fn multiplied<'py, E: ToString + Send>(
    py: Python<'py>,
    matrix: &PyReadonlyArray2<'py, f64>,
    rows: usize,
    work: impl FnOnce(&[f64], usize) -> Result<Vec<f64>, E> + Send,
) -> PyResult<Matrix<'py>> {
    let (values, columns) = (matrix.as_slice()?, matrix.shape()[1]);
    let found = py.detach(move || work(values, columns)).map_err(refuse)?;
    found.into_pyarray(py).reshape([rows, columns])
}

/// The rows of an array of so many columns.
fn rows_of<const N: usize>(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; N]>> {
    if array.shape().get(1) != Some(&N) {
        return Err(refuse(format!("an array must have {N} columns")));
    }
    let rows = array.as_slice()?.chunks_exact(N);
    Ok(rows.filter_map(|row| row.try_into().ok()).collect())
}

fn points_of(rows: &PyReadonlyArray2<'_, f64>) -> PyResult<Points> {
    Points::new(&rows_of(rows)?).map_err(refuse)
}

/// Sums over ordered pairs i ≠ j with c = max(d, nearest)^-exponent: of c and of c zᵢzⱼ.
#[pyfunction]
fn pair_sums<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    exponent: f64,
    nearest: f64,
) -> PyResult<(f64, f64)> {
    let points = points_of(&points)?;
    let decay = Decay::new(exponent, nearest).map_err(refuse)?;
    let values = values.as_slice()?;
    let sums = py
        .detach(|| spatial::pair_sums(&points, values, decay))
        .map_err(refuse)?;
    Ok((sums.weights, sums.products))
}

/// The matrix of the weights times vectors (n, p): every pair, or those far from each other to so many digits.
#[pyfunction]
#[pyo3(signature = (points, vectors, exponent, nearest, digits=None))]
fn weights_product<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    vectors: PyReadonlyArray2<'py, f64>,
    exponent: f64,
    nearest: f64,
    digits: Option<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = points_of(&points)?;
    let decay = Decay::new(exponent, nearest).map_err(refuse)?;
    let columns = vectors.shape()[1];
    let vectors = vectors.as_slice()?;
    let found = py
        .detach(|| match digits {
            None => spatial::product(&points, vectors, columns, decay),
            Some(digits) => spatial::far_product(&points, vectors, columns, decay, digits),
        })
        .map_err(refuse)?;
    found.into_pyarray(py).reshape([points.len(), columns])
}

type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// A B-spline patch, rational or not, for the closest points on it.
#[pyclass(frozen)]
struct NurbsPatch {
    patch: Patch,
}

#[pymethods]
impl NurbsPatch {
    /// Control points (n, m, 4) as (w x, w y, w z, w).
    #[new]
    fn new(
        degrees: (usize, usize),
        knots: (PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>),
        control: PyReadonlyArray3<'_, f64>,
    ) -> PyResult<Self> {
        let control: Vec<[f64; 4]> = control
            .as_slice()?
            .chunks_exact(4)
            .filter_map(|point| point.try_into().ok())
            .collect();
        let knots = [knots.0.as_slice()?, knots.1.as_slice()?];
        let patch = Patch::new([degrees.0, degrees.1], knots, &control).map_err(refuse)?;
        Ok(Self { patch })
    }

    /// Closest points of points (n, 3): parameters (n, 2), places, and derivatives by u and by v, (n, 3) each.
    #[pyo3(signature = (points, near=None))]
    fn feet<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        near: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<(Matrix<'py>, Matrix<'py>, Matrix<'py>, Matrix<'py>)> {
        let points = rows_of(&points)?;
        let near = near.as_ref().map(rows_of).transpose()?;
        let feet = py
            .detach(|| self.patch.feet(&points, near.as_deref()))
            .map_err(refuse)?;
        Ok((
            matrix(py, &feet, |foot| foot.at)?,
            matrix(py, &feet, |foot| foot.point)?,
            matrix(py, &feet, |foot| foot.du)?,
            matrix(py, &feet, |foot| foot.dv)?,
        ))
    }
}

fn matrix<'py, const N: usize>(
    py: Python<'py>,
    feet: &[Foot],
    of: impl Fn(&Foot) -> [f64; N],
) -> PyResult<Matrix<'py>> {
    let flat: Vec<f64> = feet.iter().flat_map(of).collect();
    flat.into_pyarray(py).reshape([feet.len(), N])
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NurbsPatch>()?;
    module.add_class::<ScatteredSplines>()?;
    module.add_function(wrap_pyfunction!(fit_surface_grid, module)?)?;
    module.add_function(wrap_pyfunction!(pair_sums, module)?)?;
    module.add_function(wrap_pyfunction!(weights_product, module)?)
}
