//! `error-eval` for Python: a compiled model, evaluated for arrays of positions.

use error_eval::{Body, Model, ModelError};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

type Six = [f64; 6];

struct Owned {
    axis: usize,
    breaks: Vec<f64>,
    powers: usize,
    forward: Vec<Six>,
    back: Option<Vec<Six>>,
    arm: [f64; 3],
    carries: [f64; 3],
}

impl Owned {
    fn body(&self) -> Result<Body<'_>, ModelError> {
        Body::new(
            self.axis,
            &self.breaks,
            self.powers,
            &self.forward,
            self.back.as_deref(),
            self.arm,
            self.carries,
        )
    }
}

type Given = (
    usize,
    Vec<f64>,
    usize,
    Vec<Six>,
    Option<Vec<Six>>,
    [f64; 3],
    [f64; 3],
);

/// A compiled machine model: bodies (axis, breaks, powers, forward, return, arm, carries) and slopes of axes.
#[pyclass(frozen)]
struct MachineEvaluator {
    bodies: Vec<Owned>,
    slope: [[f64; 3]; 3],
}

#[pymethods]
impl MachineEvaluator {
    #[new]
    fn new(bodies: Vec<Given>, slope: [[f64; 3]; 3]) -> PyResult<Self> {
        let bodies: Vec<Owned> = bodies
            .into_iter()
            .map(
                |(axis, breaks, powers, forward, back, arm, carries)| Owned {
                    axis,
                    breaks,
                    powers,
                    forward,
                    back,
                    arm,
                    carries,
                },
            )
            .collect();
        for body in &bodies {
            body.body()
                .map_err(|error| PyValueError::new_err(format!("{error:?}")))?;
        }
        Ok(Self { bodies, slope })
    }

    /// E (n, 3) at positions (n, 3); ways (n, 3) +1, −1 or 0, or None. On up to `threads` threads.
    #[pyo3(signature = (positions, ways, threads))]
    fn error<'py>(
        &self,
        py: Python<'py>,
        positions: PyReadonlyArray2<'py, f64>,
        ways: Option<PyReadonlyArray2<'py, f64>>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = positions.as_slice()?;
        let ways = ways.as_ref().map(|ways| ways.as_slice()).transpose()?;
        let bodies: Vec<Body<'_>> = self
            .bodies
            .iter()
            .filter_map(|body| body.body().ok())
            .collect();
        let model = Model::new(&bodies, self.slope);
        let count = positions.len() / 3;
        let mut out = vec![0.0; 3 * count];
        if threads <= 1 {
            py.detach(|| model.errors(positions, ways, &mut out));
        } else {
            let share = 3 * count.div_ceil(threads).max(1);
            py.detach(|| {
                std::thread::scope(|scope| {
                    for (k, errors) in out.chunks_mut(share).enumerate() {
                        let part = positions.get(k * share..).unwrap_or(&[]);
                        let ways = ways.map(|ways| ways.get(k * share..).unwrap_or(&[]));
                        scope.spawn(move || model.errors(part, ways, errors));
                    }
                });
            });
        }
        let array: Bound<'py, PyArray1<f64>> = out.into_pyarray(py);
        array.reshape([count, 3])
    }
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<MachineEvaluator>()
}
