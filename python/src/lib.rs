//! Native part of the Python module `caustica`: loading, planning and rendering.
//!
//! The Python files in `python/caustica/` are the public interface. They check arguments, and turn
//! the bytes that this module returns into NumPy arrays. Names here are private to the package.

mod errors;
mod render;
mod rendered;
mod scene;

use pyo3::prelude::*;

/// Native functions and types of the package `caustica`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::rendered::{NativeForecast, NativeResult};
    #[pymodule_export]
    use crate::scene::{NativeScene, load_file, load_text};

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        let names = caustica::Algorithm::ALL.map(caustica::Algorithm::name);
        module.add("INTEGRATORS", names)?;
        let importers = caustica::format::IMPORTERS.iter();
        module.add("FORMATS", importers.flat_map(|importer| importer.extensions()).collect::<Vec<_>>())
    }
}
