//! Options of a mesh shape: materials and normals of its triangles.

/// Options of a mesh shape: which materials and which normals its triangles get.
///
/// By default, triangles get the material that the scene text selects before the shape, and the
/// normals of the mesh file. No smooth normals are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// True if faces get the materials that the mesh file names; false if they get the material
    /// that the scene text selects before the shape.
    pub uses_file_materials: bool,
    /// True if the file's normals are ignored.
    pub ignores_normals: bool,
    /// Largest angle between two neighboring faces that share smooth normals, in degrees, inside
    /// \[0, 180]. `None` leaves faces without normals flat.
    ///
    /// Smooth normals are computed only for faces without normals. These are all faces if the
    /// file's normals are ignored.
    pub max_smoothing_angle: Option<f64>,
}
