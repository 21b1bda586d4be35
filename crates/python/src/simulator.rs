//! `envelope` for Python: a swept nose, asked by rays.

use envelope::{End, EndSweep, Nose, Point, Point3, Ray, Sweep};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point>> {
    let shape = array.shape();
    let flat = array.as_slice()?;
    if shape.get(1) != Some(&2) || flat.iter().any(|value| !value.is_finite()) {
        return Err(PyValueError::new_err(
            "points must be finite numbers of shape (n, 2)",
        ));
    }
    Ok(flat
        .chunks_exact(2)
        .filter_map(|pair| Some([*pair.first()?, *pair.last()?]))
        .collect())
}

/// Rays that one core works off before the next look for work.
const TOGETHER: usize = 1024;

/// A nose swept along a polyline of its centre, (n, 2), x a radius, mm.
///
/// The nose is round with `radius`, plus a cubic a piece over contact angle, (m, 4), pieces `step` wide from `first` on.
#[pyclass(frozen)]
struct NoseSweep {
    sweep: Sweep,
}

#[pymethods]
impl NoseSweep {
    #[new]
    fn new(
        py: Python<'_>,
        nodes: PyReadonlyArray2<'_, f64>,
        radius: f64,
        first: f64,
        step: f64,
        pieces: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let pieces = pieces
            .as_slice()?
            .chunks_exact(4)
            .filter_map(|piece| piece.try_into().ok())
            .collect();
        let nose = Nose::new(radius, first, step, pieces)
            .map_err(|refused| PyValueError::new_err(refused.to_string()))?;
        let nodes = points(&nodes)?;
        Ok(Self {
            sweep: py.detach(|| Sweep::new(nodes, nose)),
        })
    }

    /// Where rays out of the material first meet the swept region, (q,): between −reach and `known`, (q,).
    fn entries<'py>(
        &self,
        py: Python<'py>,
        origins: PyReadonlyArray2<'py, f64>,
        directions: PyReadonlyArray2<'py, f64>,
        known: PyReadonlyArray1<'py, f64>,
        reach: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (origins, directions) = (points(&origins)?, points(&directions)?);
        let known = known.as_slice()?;
        if origins.len() != directions.len() || origins.len() != known.len() {
            return Err(PyValueError::new_err(
                "as many directions and known entries as origins",
            ));
        }
        let found = py.detach(|| {
            let rays: Vec<_> = origins
                .iter()
                .zip(&directions)
                .map(|(o, d)| Ray::new(*o, *d))
                .zip(known.iter().copied())
                .collect();
            let jobs: Vec<_> = rays.chunks(TOGETHER).collect();
            threads::spread(&jobs, |rays| {
                self.sweep.entries(rays.iter().copied(), reach)
            })
            .concat()
        });
        Ok(found.into_pyarray(py))
    }
}

fn points3(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point3>> {
    let flat = array.as_slice()?;
    if array.shape().get(1) != Some(&3) || flat.iter().any(|value| !value.is_finite()) {
        return Err(PyValueError::new_err(
            "points must be finite numbers of shape (n, 3)",
        ));
    }
    Ok(flat
        .chunks_exact(3)
        .filter_map(|point| point.try_into().ok())
        .collect())
}

/// A cutter's end swept along a polyline of its centre, (n, 3), mm.
#[pyclass(frozen)]
struct CutterSweep {
    sweep: EndSweep,
}

#[pymethods]
impl CutterSweep {
    #[new]
    fn new(
        nodes: PyReadonlyArray2<'_, f64>,
        ring: f64,
        corner: f64,
        axes: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let (nodes, axes) = (points3(&nodes)?, points3(&axes)?);
        let size = ring + corner;
        let an_end = ring >= 0.0 && corner >= 0.0 && size.is_finite() && size > 0.0;
        let unit = axes.iter().all(|axis| {
            let length: f64 = axis.map(|part| part * part).iter().sum();
            (length - 1.0).abs() < 1e-9
        });
        if !an_end || !unit || (axes.len() != 1 && axes.len() != nodes.len()) {
            return Err(PyValueError::new_err(
                "ring and corner must be numbers not below 0, one of them above, and axes unit vectors: one, or one a node",
            ));
        }
        Ok(Self {
            sweep: EndSweep::new(nodes, axes, End::new(ring, corner)),
        })
    }

    /// Where rays out of the material first meet the swept region, (q,): −reach to `known`, (q,) (nothing lower).
    fn entries<'py>(
        &self,
        py: Python<'py>,
        origins: PyReadonlyArray2<'py, f64>,
        directions: PyReadonlyArray2<'py, f64>,
        known: PyReadonlyArray1<'py, f64>,
        reach: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (origins, directions) = (points3(&origins)?, points3(&directions)?);
        let known = known.as_slice()?;
        if origins.len() != directions.len() || origins.len() != known.len() {
            return Err(PyValueError::new_err(
                "as many directions and known heights as origins",
            ));
        }
        let rays = origins.into_iter().zip(directions).zip(known);
        let rays = rays.map(|((origin, direction), known)| (origin, direction, *known));
        Ok(py
            .detach(|| self.sweep.entries(rays, reach))
            .into_pyarray(py))
    }
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NoseSweep>()?;
    module.add_class::<CutterSweep>()
}
