//! The objects of a scene before they are placed.

use crate::color::Rgb;
use crate::math::Motion;
use crate::shape::{Mesh, Plane, Shape, TextureMappingKind, TriangleIndices};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::ops::Range;

/// Minimum and maximum corner of a bounding box, in double precision.
pub(super) type BoundsF64 = (DVec3, DVec3);

/// A shape, mesh or plane with its material, in world coordinates. A moving object is stored before
/// its motion is applied.
#[derive(Debug)]
pub(super) struct SceneObject {
    pub geometry: ObjectGeometry,
    /// Motion of the object, which maps it to world coordinates; `None` if it rests.
    pub motion: Option<Motion>,
    /// Index of the object's material.
    pub material: u32,
    /// Mean radiance that the object emits \[W/(m² sr)].
    pub emission: Rgb,
    /// Index of the emission texture, and the factor from texture values to radiance \[W/(m² sr)];
    /// `None` if the object emits uniformly or not at all.
    pub emission_texture: Option<(u32, Rgb)>,
    /// Kind of the object's texture mapping, and the motion from the mapping's object space to the
    /// world; `None` for the default mapping.
    pub mapping: Option<(TextureMappingKind, Motion)>,
}

/// The geometry of an object.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "lives only while the scene is built")]
pub(super) enum ObjectGeometry {
    Shape(Shape),
    /// A range of triangles of the scene's [`MergedMeshes`].
    Mesh(Range<u32>),
    Plane(Plane),
}

impl SceneObject {
    /// Bounding box of an object at rest; `None` for planes, moving objects, and meshes without
    /// triangles.
    pub fn resting_bounds(&self, mesh: &MergedMeshes) -> Option<BoundsF64> {
        match &self.geometry {
            ObjectGeometry::Shape(shape) if self.motion.is_none() => Some(shape.bounds_f64()),
            ObjectGeometry::Mesh(range) => mesh.triangle_bounds(range.clone()),
            ObjectGeometry::Shape(_) | ObjectGeometry::Plane(_) => None,
        }
    }

    /// True if the object emits light.
    pub fn emits(&self) -> bool {
        self.emission != Rgb::ZERO
    }

    /// Sort key of objects, in this order: shapes, meshes, planes. Moving shapes and planes follow
    /// those at rest.
    ///
    /// Shapes at rest that emit light come first. Where shapes are coplanar, a ray hits the one of
    /// lowest index. It thus hits the emitter, as light sampling assumes.
    pub fn object_sort_key(&self) -> u8 {
        match (&self.geometry, &self.motion) {
            (ObjectGeometry::Shape(_), None) if self.emits() => 0,
            (ObjectGeometry::Shape(_), None) => 1,
            (ObjectGeometry::Shape(_), Some(_)) => 2,
            (ObjectGeometry::Mesh(_), _) => 3,
            (ObjectGeometry::Plane(_), None) => 4,
            (ObjectGeometry::Plane(_), Some(_)) => 5,
        }
    }
}

/// The vertices and triangles of all mesh objects, in world coordinates.
#[derive(Debug, Default)]
pub(super) struct MergedMeshes {
    positions: Vec<DVec3>,
    /// Unit vertex normals; zero for a mesh without normals. Shorter than `positions` if the meshes
    /// added last have none.
    normals: Vec<Vec3>,
    /// Texture coordinates by vertex; zero for a mesh without any. Shorter than `positions` if the
    /// meshes added last have none.
    texcoords: Vec<Vec2>,
    pub triangles: Vec<TriangleIndices>,
}

impl MergedMeshes {
    /// Adds a mesh, and returns the range of its triangles. Triangles of zero area are dropped.
    pub fn add_mesh(&mut self, positions: &[DVec3], normals: &[Vec3], triangles: &[TriangleIndices]) -> Range<u32> {
        let (base, first) = (self.positions.len() as u32, self.triangles.len() as u32);
        self.positions.extend_from_slice(positions);
        if !normals.is_empty() {
            self.normals.resize(base as usize, Vec3::ZERO);
            self.normals.extend_from_slice(normals);
        }
        let area = |t: &TriangleIndices| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(c - a).length_squared()
        };
        self.triangles.extend(triangles.iter().filter(|t| area(t) > 0.0).map(|t| t.map(|v| v + base)));
        first..self.triangles.len() as u32
    }

    /// Adds texture coordinates to the mesh added last, one pair per vertex.
    pub fn add_texcoords(&mut self, texcoords: &[DVec2]) {
        let before = self.positions.len().saturating_sub(texcoords.len());
        self.texcoords.resize(before, Vec2::ZERO);
        self.texcoords.extend(texcoords.iter().map(|t| t.as_vec2()));
    }

    /// Bounding box of a range of triangles; `None` if it is empty.
    fn triangle_bounds(&self, triangles: Range<u32>) -> Option<BoundsF64> {
        let vertices = self.triangles[triangles.start as usize..triangles.end as usize].iter().flatten();
        let points = vertices.map(|v| self.positions[*v as usize]).map(|p| (p, p));
        points.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    /// Returns all mesh objects as one mesh, in coordinates relative to `origin`.
    pub fn recentered(self, origin: DVec3) -> Mesh {
        let Self { positions, mut normals, mut texcoords, triangles } = self;
        if !normals.is_empty() {
            normals.resize(positions.len(), Vec3::ZERO);
        }
        if !texcoords.is_empty() {
            texcoords.resize(positions.len(), Vec2::ZERO);
        }
        let positions = positions.iter().map(|p| (*p - origin).as_vec3()).collect();
        Mesh { positions, normals, texcoords, triangles }
    }
}
