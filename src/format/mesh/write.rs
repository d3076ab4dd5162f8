//! Writing of meshes to OBJ and PLY files.

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
    PlyBinary,
    /// PLY as text.
    PlyText,
}

impl MeshFormat {
    /// Returns the format for the extension of `path`; `None` if the extension is unknown.
    ///
    /// For PLY, `text` selects the text format instead of the binary one.
    #[must_use]
    pub fn from_path(path: &Path, text: bool) -> Option<Self> {
        let is = |name: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(name));
        match (is("obj"), is("ply"), text) {
            (true, ..) => Some(Self::Obj),
            (_, true, false) => Some(Self::PlyBinary),
            (_, true, true) => Some(Self::PlyText),
            _ => None,
        }
    }
}

pub(super) fn write(
    mesh: &TriangleMesh,
    path: &Path,
    format: MeshFormat,
    libraries: &[String],
) -> Result<(), WriteError> {
    replace_file_with(path, |file| {
        let mut out = BufWriter::with_capacity(1 << 20, file);
        match format {
            MeshFormat::Obj => obj::write(mesh, libraries, &mut out)?,
            MeshFormat::PlyBinary => ply::write(mesh, false, &mut out)?,
            MeshFormat::PlyText => ply::write(mesh, true, &mut out)?,
        }
        out.flush()
    })
}

/// Displays the number as the shortest decimal that gives exactly this number when read again.
///
/// An exponent is used if the magnitude is below 10⁻⁵ but not 0, or if it is 10¹⁶ or more.
pub(in crate::format) struct ShortestDecimal<T>(pub T);

impl<T: Copy + Into<f64> + Display + std::fmt::LowerExp> Display for ShortestDecimal<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        match self.0.into().abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}
