//! `rtec` for Python: the object file and header that a control's component is linked with, and the corrector itself, for
//! simulations and tests: the same code, many periods in one call.

use std::collections::HashMap;

use numpy::{AllowTypeChange, IntoPyArray, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rtec::corrector::{Corrector, Inputs, Outputs, Settings};
use rtec::image::{Expected, Found, Image, Refusal};
use rtec::names::{Named, FAULTS, PHASES, REFUSALS, WAITS};
use rtec::wanted::{Asked, Place, Wanted};

static LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/rtec.o"));
static HEADER: &str = include_str!("../../rtec/include/rtec.h");

pyo3::create_exception!(
    _core,
    RealTimeRefusalError,
    PyValueError,
    "Bytes that are no image: arguments are the number, the name and the meaning."
);

/// An image and what a corrector remembers, from one call to the next.
#[pyclass]
struct RealTimeCore {
    bytes: Vec<u8>,
    corrector: Corrector,
    found: Found,
}

#[pymethods]
impl RealTimeCore {
    #[new]
    #[pyo3(signature = (image, serial=None, program=None))]
    fn new(image: &[u8], serial: Option<&str>, program: Option<&[u8]>) -> PyResult<Self> {
        let serial = serial.map(str::as_bytes);
        Image::read(image, Expected { serial, program }).map_err(refused)?;
        Ok(Self {
            bytes: image.to_vec(),
            corrector: Corrector::new(),
            found: Found::default(),
        })
    }

    /// Signals that the image needs.
    #[getter]
    fn signals(&self) -> PyResult<usize> {
        Ok(self.image()?.signals().len())
    }

    /// One period after the other; the columns of `inputs` and what comes back are named as in rtec.h.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        settings: HashMap<String, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let inputs = read_inputs(inputs)?;
        let settings = read_settings(&settings)?;
        let mut image = Image::read_again(&self.bytes).map_err(refused)?;
        image.resume(self.found);
        let corrector = &mut self.corrector;
        let outputs: Vec<Outputs> = py.detach(|| {
            let step = |inputs| corrector.step(&mut image, inputs, &settings);
            inputs.iter().map(step).collect()
        });
        self.found = image.found();
        show_outputs(py, &outputs)
    }

    /// What should be added at places that follow each other: columns position, travel, tool_offset, signal, line (−1: none).
    /// The corrector's own state stays as it is.
    fn wanted<'py>(
        &self,
        py: Python<'py>,
        places: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let places = read_places(places)?;
        let mut image = Image::read_again(&self.bytes).map_err(refused)?;
        let found: Vec<Wanted> =
            py.detach(|| places.iter().map(|place| image.wanted(place)).collect());
        let table = PyDict::new(py);
        triples(py, &table, "model", &found, |wanted| wanted.model)?;
        triples(py, &table, "table", &found, |wanted| wanted.table)?;
        values(py, &table, "listed", &found, |wanted| wanted.listed)?;
        values(py, &table, "on_path", &found, |wanted| wanted.on_path)?;
        Ok(table)
    }
}

impl RealTimeCore {
    fn image(&self) -> PyResult<Image<'_>> {
        Image::read_again(&self.bytes).map_err(refused)
    }
}

fn refused(refusal: Refusal) -> PyErr {
    RealTimeRefusalError::new_err(
        spelled(&REFUSALS)
            .into_iter()
            .find(|(number, ..)| *number == refusal as i32),
    )
}

/// Number, name and meaning.
fn spelled(names: &[Named]) -> Vec<(i32, String, String)> {
    let spelled = names.iter().map(|(number, text)| {
        let text = text.to_string_lossy();
        let (name, meaning) = text.split_once(": ").unwrap_or((&text, ""));
        (*number, name.to_owned(), meaning.to_owned())
    });
    spelled.collect()
}

/// Columns of numbers by name, each as long as `position`; one value stands for all periods.
struct Columns<'a, 'py> {
    given: &'a Bound<'py, PyDict>,
    count: usize,
}

impl<'a, 'py> Columns<'a, 'py> {
    /// Names that are not known, or no position: `ValueError`.
    fn new(given: &'a Bound<'py, PyDict>, known: &[&str]) -> PyResult<Self> {
        for name in given.keys() {
            let name: String = name.extract()?;
            if !known.contains(&name.as_str()) {
                return Err(PyValueError::new_err(format!("no column is called {name}")));
            }
        }
        let missing = || PyValueError::new_err("no column position");
        let position = given.get_item("position")?.ok_or_else(missing)?;
        let count = position.len()?;
        Ok(Self { given, count })
    }

    /// Rows of `N` numbers; what is not given is `default`.
    fn rows<const N: usize>(&self, name: &str, default: f64) -> PyResult<Vec<[f64; N]>> {
        let mut rows = vec![[default; N]; self.count];
        let Some(column) = self.given.get_item(name)? else {
            return Ok(rows);
        };
        let column: PyArrayLikeDyn<'_, f64, AllowTypeChange> = column.extract()?;
        let width = match column.shape() {
            [] => 0,
            [count] if *count == self.count => 1,
            [count, width] if *count == self.count && *width <= N => *width,
            shape => {
                let count = self.count;
                let message = format!("{name} has shape {shape:?}, not ({count}, up to {N})");
                return Err(PyValueError::new_err(message));
            }
        };
        let values = column.as_array();
        let mut values = values.iter().copied();
        if width == 0 {
            return Ok(vec![[values.next().unwrap_or(default); N]; self.count]);
        }
        for row in &mut rows {
            for (cell, value) in row.iter_mut().zip(values.by_ref().take(width)) {
                *cell = value;
            }
        }
        Ok(rows)
    }

    /// One number a period.
    fn values(&self, name: &str, default: f64) -> PyResult<impl Iterator<Item = f64>> {
        Ok(self
            .rows::<1>(name, default)?
            .into_iter()
            .map(|[value]| value))
    }
}

/// Puts columns into the fields of the same name, each by its conversion.
macro_rules! fill {
    ($columns:ident, $rows:ident, $($method:ident $field:ident = $default:expr, $convert:expr;)*) => {
        $(for (row, value) in $rows.iter_mut().zip($columns.$method(stringify!($field), $default)?) {
            row.$field = $convert(value);
        })*
    };
}

fn read_inputs(given: &Bound<'_, PyDict>) -> PyResult<Vec<Inputs>> {
    let known = [
        "position",
        "tool_offset",
        "signal",
        "age_s",
        "period_s",
        "heartbeat",
        "line",
        "program",
        "motion_type",
        "enable",
        "homed",
        "machine_on",
        "probing",
        "touch",
    ];
    let columns = Columns::new(given, &known)?;
    let mut rows = vec![Inputs::default(); columns.count];
    let on = |value: f64| value != 0.0;
    fill! { columns, rows,
        rows position = 0.0, |row| row;
        rows tool_offset = 0.0, |row| row;
        rows signal = 0.0, |row| row;
        rows age_s = 0.0, |row| row;
        values period_s = 1e-3, |value| value;
        values heartbeat = 0.0, |value| value as u32;
        values line = 0.0, |value| value as i32;
        values program = 0.0, |value| value as i32;
        values motion_type = 0.0, |value| value as i32;
        values enable = 1.0, on;
        values homed = 1.0, on;
        values machine_on = 1.0, on;
        values probing = 0.0, on;
        values touch = 0.0, on;
    }
    Ok(rows)
}

fn read_places(given: &Bound<'_, PyDict>) -> PyResult<Vec<Place>> {
    let known = ["position", "travel", "tool_offset", "signal", "line"];
    let columns = Columns::new(given, &known)?;
    let mut rows = vec![Place::default(); columns.count];
    fill! { columns, rows,
        rows position = 0.0, |row| row;
        rows travel = 0.0, |row| row;
        rows tool_offset = 0.0, |row| row;
        rows signal = 0.0, |row| row;
        values line = -1.0, |value| (value >= 0.0).then_some(value as i32);
    }
    Ok(rows)
}

fn read_settings(given: &HashMap<String, f64>) -> PyResult<Settings> {
    let mut settings = Settings::default();
    for (name, value) in given {
        match name.as_str() {
            "limit_mm" => settings.limit_mm = *value,
            "slew_mm_per_s" => settings.slew_mm_per_s = *value,
            "resolution_mm" => settings.resolution_mm = *value,
            "stale_s" => settings.stale_s = *value,
            "freeze_s" => settings.freeze_s = *value,
            "leave_s" => settings.leave_s = *value,
            "watchdog_s" => settings.watchdog_s = *value,
            "off_path_s" => settings.off_path_s = *value,
            "parts" => settings.parts = *value as u32,
            "probe_corrected" => settings.probe_corrected = *value != 0.0,
            "pause_program" => settings.pause_program = *value != 0.0,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "no setting is called {name}"
                )))
            }
        }
    }
    Ok(settings)
}

fn show_outputs<'py>(py: Python<'py>, outputs: &[Outputs]) -> PyResult<Bound<'py, PyDict>> {
    let table = PyDict::new(py);
    triples(py, &table, "correction", outputs, |out| out.correction)?;
    triples(py, &table, "model", outputs, |out| out.model)?;
    triples(py, &table, "table", outputs, |out| out.table)?;
    triples(py, &table, "latch", outputs, |out| out.latch)?;
    triples(py, &table, "in_use", outputs, |out| out.in_use)?;
    values(py, &table, "oldest_age_s", outputs, |out| out.oldest_age_s)?;
    values(py, &table, "phase", outputs, |out| out.phase)?;
    values(py, &table, "fault", outputs, |out| out.fault)?;
    values(py, &table, "fault_signal", outputs, |out| out.fault_signal)?;
    values(py, &table, "waits_for", outputs, |out| out.waits_for)?;
    values(py, &table, "signal_fault", outputs, |out| out.signal_fault)?;
    values(py, &table, "enabled", outputs, |out| out.enabled)?;
    values(py, &table, "active", outputs, |out| out.active)?;
    values(py, &table, "on_path", outputs, |out| out.on_path)?;
    values(py, &table, "pause", outputs, |out| out.pause)?;
    Ok(table)
}

/// A column of one number a period.
fn values<T, V: numpy::Element>(
    py: Python<'_>,
    table: &Bound<'_, PyDict>,
    name: &str,
    rows: &[T],
    value: impl Fn(&T) -> V,
) -> PyResult<()> {
    let column: Vec<V> = rows.iter().map(value).collect();
    table.set_item(name, column.into_pyarray(py))
}

/// A column of several.
fn triples<T, const N: usize>(
    py: Python<'_>,
    table: &Bound<'_, PyDict>,
    name: &str,
    rows: &[T],
    value: impl Fn(&T) -> [f64; N],
) -> PyResult<()> {
    let column: Vec<f64> = rows.iter().flat_map(value).collect();
    table.set_item(name, column.into_pyarray(py).reshape([rows.len(), N])?)
}

/// The corrector as an object file, to be linked into a component by the C interface of `realtime_header`.
#[pyfunction]
fn realtime_library(py: Python<'_>) -> Bound<'_, PyBytes> {
    PyBytes::new(py, LIBRARY)
}

/// rtec.h.
#[pyfunction]
fn realtime_header() -> &'static str {
    HEADER
}

/// Number, name and meaning of all phases, faults, refusals, and of what is waited for.
#[pyfunction]
fn realtime_names() -> HashMap<&'static str, Vec<(i32, String, String)>> {
    let names: [(&str, &[Named]); 4] = [
        ("phases", &PHASES),
        ("faults", &FAULTS),
        ("refusals", &REFUSALS),
        ("waits", &WAITS),
    ];
    names
        .map(|(kind, names)| (kind, spelled(names)))
        .into_iter()
        .collect()
}

/// Adds what this file binds to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add(
        "RealTimeRefusalError",
        module.py().get_type::<RealTimeRefusalError>(),
    )?;
    module.add_class::<RealTimeCore>()?;
    module.add_function(wrap_pyfunction!(realtime_library, module)?)?;
    module.add_function(wrap_pyfunction!(realtime_header, module)?)?;
    module.add_function(wrap_pyfunction!(realtime_names, module)?)
}
