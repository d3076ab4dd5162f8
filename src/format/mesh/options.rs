//! Options of a mesh shape.

/// Options of a mesh shape: which materials and which normals its triangles get.
///
/// By default, triangles get the scene's current material and the file's normals. No smooth normals
/// are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// True if faces get the materials that the mesh file names; false if they get the scene's
    /// current material.
    pub uses_file_materials: bool,
    /// True if the file's normals are ignored.
    pub ignores_normals: bool,
    /// Largest angle between two neighboring faces that share smooth normals, in degrees, inside
    /// [0, 180].
    ///
    /// `None` computes no smooth normals, so such faces are flat. The angle applies only to faces
    /// without normals in the file.
    pub max_smoothing_angle: Option<f64>,
}
