//! Writing of mesh files.

use super::{TriangleMesh, obj, ply};
use crate::image::{WriteError, replace_file_with};
use std::fmt::{Display, Formatter, Result as Written};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Binary PLY, little-endian.
    Ply,
    /// PLY as text.
    PlyText,
}

impl MeshFormat {
    /// Format for the extension of a path; `text` selects PLY as text. `None` for unknown
    /// extensions.
    #[must_use]
    pub fn from_path(path: &Path, text: bool) -> Option<Self> {
        let is = |name: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(name));
        match (is("obj"), is("ply"), text) {
            (true, ..) => Some(Self::Obj),
            (_, true, false) => Some(Self::Ply),
            (_, true, true) => Some(Self::PlyText),
            _ => None,
        }
    }
}

impl TriangleMesh {
    /// Writes the file completely or not at all.
    ///
    /// Numbers read back bit for bit. An OBJ file names the materials and their `libraries`; PLY
    /// has none.
    ///
    /// # Errors
    ///
    /// [`WriteError`].
    pub fn write(&self, path: &Path, format: MeshFormat, libraries: &[String]) -> Result<(), WriteError> {
        replace_file_with(path, |file| {
            let mut out = BufWriter::with_capacity(1 << 20, file);
            match format {
                MeshFormat::Obj => obj::write(self, libraries, &mut out)?,
                MeshFormat::Ply => ply::write(self, false, &mut out)?,
                MeshFormat::PlyText => ply::write(self, true, &mut out)?,
            }
            out.flush()
        })
    }
}

/// Shortest decimal that reads back as the same number, with an exponent if it is far from 1.
pub(in crate::format) struct ShortestDecimal<T>(pub T);

impl<T: Copy + Into<f64> + Display + std::fmt::LowerExp> Display for ShortestDecimal<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        match self.0.into().abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}
