//! Conversion of the library's errors to Python exceptions.

use caustica::SceneError;
use caustica::format::SceneReadError;
use caustica::image::WriteError;
use caustica::render::MemoryError;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use std::path::Path;

/// Reason why a scene cannot be read or rendered.
pub enum Failure {
    /// The content of the scene has errors.
    Scene(SceneError),
    /// The scene file cannot be read.
    Read(SceneReadError),
    /// The pictures or photons do not fit into memory.
    Memory(MemoryError),
    /// The threads of a render cannot be started. Holds the reason.
    Threads(String),
}

impl Failure {
    /// Returns the exception of this failure.
    pub fn into_exception(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Scene(error) => scene_exception(py, &error),
            Self::Read(SceneReadError::InvalidContent(error)) => scene_exception(py, &error),
            Self::Read(SceneReadError::Unreadable { path, source }) => io_exception(&path, &source),
            Self::Read(error @ SceneReadError::OutOfMemory { .. }) => {
                PyMemoryError::new_err(format!("{error}: put large parts into meshes, or allow more `memory`"))
            }
            Self::Memory(error) => {
                let remedy = match error {
                    MemoryError::Pixels(_) => "choose a smaller `size`",
                    MemoryError::Picture { .. } => "choose a smaller `size`, or allow more `memory`",
                    MemoryError::Films { .. } => "allow more `memory`",
                    MemoryError::Indices { .. } | MemoryError::Photons { .. } => {
                        "choose fewer `photons` or `caustic_photons` and more `passes`"
                    }
                };
                PyMemoryError::new_err(format!("{error}: {remedy}"))
            }
            Self::Threads(reason) => {
                PyOSError::new_err(format!("cannot start threads: {reason}: choose fewer `threads`"))
            }
        }
    }
}

/// Returns the exception `caustica.SceneError` of `error`, with the further errors of its file.
fn scene_exception(py: Python<'_>, error: &SceneError) -> PyErr {
    if error.is_out_of_memory() {
        return PyMemoryError::new_err(format!("{error}: {}", error.remedy()));
    }
    let class = py.import("caustica._errors").and_then(|module| module.getattr("SceneError"));
    let made = class.and_then(|class| {
        let of = |error: &SceneError| {
            let (file, message, remedy) = (error.file_name(), error.message(), error.remedy());
            class.call1((message, file, error.line(), error.column(), remedy))
        };
        let exception = of(error)?;
        let further = error.further_errors().iter().map(of).collect::<PyResult<Vec<_>>>()?;
        exception.setattr("further", further)?;
        Ok(exception)
    });
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Returns the `OSError` of an error on the file at `path`, such as `FileNotFoundError`.
fn io_exception(path: &Path, error: &std::io::Error) -> PyErr {
    match error.raw_os_error() {
        // Python chooses the subclass by the number.
        Some(number) => {
            let text = error.to_string();
            let reason = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, reason, path.display().to_string()))
        }
        None => PyOSError::new_err(format!("{}: {error}: check the path and its permissions", path.display())),
    }
}

/// Returns the exception of a picture that cannot be written.
pub fn write_exception(error: &WriteError) -> PyErr {
    match error {
        WriteError::Io { path, source, .. } => io_exception(path, source),
        WriteError::NoFolder { .. } | WriteError::NotAFile { .. } | WriteError::ReadOnly { .. } => {
            PyOSError::new_err(error.to_string())
        }
        WriteError::Extension { .. }
        | WriteError::LayersNotSupported { .. }
        | WriteError::Channel { .. }
        | WriteError::Metadata { .. }
        | WriteError::Exposure { .. }
        | WriteError::Encode(_) => PyValueError::new_err(error.to_string()),
    }
}
