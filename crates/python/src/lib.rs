//! The Python module `trueloop._core`: the only crate that knows PyO3. A file binds one crate, or a part of it.

use pyo3::prelude::*;

mod curve;
mod machine;
mod nc;
mod nc_field;
mod nc_map;
mod nc_path;
mod nc_session;
mod nc_text;
mod realtime;
mod simulator;
mod surface;

/// Keeps what a program's words and moves took for the next program: the system's own allocator gives large arrays back
/// at once, and filling fresh pages then takes half of the time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    curve::register(module)?;
    machine::register(module)?;
    nc::register(module)?;
    nc_field::register(module)?;
    nc_map::register(module)?;
    nc_session::register(module)?;
    nc_text::register(module)?;
    realtime::register(module)?;
    simulator::register(module)?;
    surface::register(module)
}
