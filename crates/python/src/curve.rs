//! `curve-fit` for Python: arrays in, arrays out.

use curve_fit::{fit, EndConditions, FitError, Side, SplineSpace, ORDER};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(
    _core,
    CurveFitError,
    PyValueError,
    "A fit was refused: arguments are the kind, a message and where points are missing."
);

fn refuse(error: FitError) -> PyErr {
    CurveFitError::new_err((error.kind(), error.to_string(), error.missing()))
}

fn table<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[f64; N]],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = [rows.len(), columns.min(N)];
    if columns >= N {
        return PyArray1::from_slice(py, rows.as_flattened()).reshape(shape);
    }
    let flat: Vec<f64> = rows
        .iter()
        .flat_map(|row| row.iter().take(columns).copied())
        .collect();
    flat.into_pyarray(py).reshape(shape)
}

type FitArrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// Least-squares spline with end conditions: (coefficients, covariance band, sensitivity, residuals, leverages).
#[pyfunction]
#[pyo3(signature = (points, values, weights, interior_knots, length, degree, ends))]
#[allow(clippy::too_many_arguments)] // the token of the interpreter counts as one
fn fit_spline<'py>(
    py: Python<'py>,
    points: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    weights: Option<PyReadonlyArray1<'py, f64>>,
    interior_knots: PyReadonlyArray1<'py, f64>,
    length: f64,
    degree: usize,
    ends: (Option<f64>, Option<f64>, Option<f64>, Option<f64>),
) -> PyResult<FitArrays<'py>> {
    let space = SplineSpace::new(interior_knots.as_slice()?, length, degree).map_err(refuse)?;
    let ends = EndConditions {
        start_value: ends.0,
        start_slope: ends.1,
        end_value: ends.2,
        end_slope: ends.3,
    };
    let weights = weights
        .as_ref()
        .map_or(Ok(&[][..]), |weights| weights.as_slice())?;
    let fitted = fit(
        &space,
        points.as_slice()?,
        values.as_slice()?,
        weights,
        &ends,
    )
    .map_err(refuse)?;
    Ok((
        fitted.coefficients.into_pyarray(py),
        table(py, &fitted.covariance_band, ORDER)?,
        table(py, &fitted.sensitivity, fitted.conditions)?,
        fitted.residuals.into_pyarray(py),
        fitted.leverages.into_pyarray(py),
    ))
}

type BasisArrays<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Basis functions that differ from zero at each point: (index of the first, values, slopes).
///
/// `lower` and `upper` bound the piece that is looked at: at a knot on `upper` the piece before it, at one on `lower`
/// the piece after it.
#[pyfunction]
fn spline_basis<'py>(
    py: Python<'py>,
    points: PyReadonlyArray1<'py, f64>,
    interior_knots: PyReadonlyArray1<'py, f64>,
    length: f64,
    degree: usize,
    lower: f64,
    upper: f64,
) -> PyResult<BasisArrays<'py>> {
    let space = SplineSpace::new(interior_knots.as_slice()?, length, degree).map_err(refuse)?;
    let (least, most) = (
        space.piece(lower, Side::After),
        space.piece(upper, Side::Before),
    );
    let most = most.max(least);
    let mut first = Vec::new();
    let (mut values, mut slopes): (Vec<[f64; ORDER]>, Vec<[f64; ORDER]>) = (Vec::new(), Vec::new());
    for &point in points.as_slice()? {
        let row = space.row(point, space.piece(point, Side::After).clamp(least, most));
        first.push(row.first as i64);
        values.push(row.values);
        slopes.push(row.slopes);
    }
    Ok((
        first.into_pyarray(py),
        table(py, &values, degree + 1)?,
        table(py, &slopes, degree + 1)?,
    ))
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("CurveFitError", module.py().get_type::<CurveFitError>())?;
    module.add_function(wrap_pyfunction!(fit_spline, module)?)?;
    module.add_function(wrap_pyfunction!(spline_basis, module)?)
}
