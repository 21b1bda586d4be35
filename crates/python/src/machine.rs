//! `error-eval` for Python: a compiled model, evaluated for arrays of positions.

use error_eval::{Body, Model, ModelError};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

type Six = [f64; 6];

/// Axis, breaks, powers, rows, arm, carries.
#[derive(FromPyObject)]
struct Owned(usize, Vec<f64>, usize, Vec<Six>, [f64; 3], [f64; 3]);

impl Owned {
    fn body(&self) -> Result<Body<'_>, ModelError> {
        let Self(axis, breaks, powers, rows, arm, carries) = self;
        Body::new(*axis, breaks, *powers, rows, *arm, *carries)
    }
}

/// A compiled machine model: bodies (axis, breaks, powers, rows, arm, carries) and slopes of axes.
#[pyclass(frozen)]
struct MachineEvaluator {
    bodies: Vec<Owned>,
    slope: [[f64; 3]; 3],
}

#[pymethods]
impl MachineEvaluator {
    #[new]
    fn new(bodies: Vec<Owned>, slope: [[f64; 3]; 3]) -> PyResult<Self> {
        for body in &bodies {
            body.body()
                .map_err(|error| PyValueError::new_err(format!("{error:?}")))?;
        }
        Ok(Self { bodies, slope })
    }

    /// E (n, 3) at positions (n, 3); travel (n, 3) +1, −1 or 0, or None. On up to `threads` threads.
    #[pyo3(signature = (positions, travel, threads))]
    fn error<'py>(
        &self,
        py: Python<'py>,
        positions: PyReadonlyArray2<'py, f64>,
        travel: Option<PyReadonlyArray2<'py, f64>>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = positions.as_slice()?;
        let travel = match &travel {
            Some(travel) => travel.as_slice()?,
            None => &[],
        };
        let bodies: Vec<Body<'_>> = self
            .bodies
            .iter()
            .filter_map(|body| body.body().ok())
            .collect();
        let model = Model::new(&bodies, self.slope);
        let count = positions.len() / 3;
        let mut out = vec![0.0; 3 * count];
        let size = 3 * count.div_ceil(threads.max(1)).max(1);
        py.detach(|| {
            std::thread::scope(|scope| {
                let mut shares = out.chunks_mut(size).enumerate().map(|(k, errors)| {
                    move || model.errors(part(positions, size, k), part(travel, size, k), errors)
                });
                let own = shares.next();
                shares.for_each(|share| drop(scope.spawn(share)));
                own.map(|mut share| share())
            })
        });
        let array: Bound<'py, PyArray1<f64>> = out.into_pyarray(py);
        array.reshape([count, 3])
    }
}

/// Chunk number `k`, empty where there is none.
fn part(of: &[f64], size: usize, k: usize) -> &[f64] {
    of.chunks(size).nth(k).unwrap_or(&[])
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<MachineEvaluator>()
}
