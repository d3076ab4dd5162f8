//! The geometry of a resolved scene, with the hierarchies that find intersections.

use crate::accel::{Hierarchy, Primitive};
use crate::math::{Bounds, Ray};
use crate::shape::{Mesh, Plane, Shape, SurfacePoint, TexCoord};
use glam::Vec2;
use std::ops::Range;
use std::sync::Arc;

/// The material, light and texture mapping of one object.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectAttributes {
    /// Index of the material.
    pub material: u32,
    /// Index of the object's area light; `None` if it does not emit.
    pub light: Option<u32>,
    /// Index of the texture mapping.
    pub mapping: u32,
}

/// An intersection of a ray with the scene: distance and primitive, without surface properties.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance in units of the ray direction's length.
    pub t: f32,
    pub(super) kind: HitKind,
}

/// Index of the primitive that a ray hits, with barycentric coordinates or surface parameters.
#[derive(Clone, Copy, Debug)]
pub(super) enum HitKind {
    Triangle(u32, Vec2),
    Shape(u32, Vec2),
    Plane(u32),
}

/// Shapes, triangles and planes, with the hierarchies over them.
///
/// Objects are numbered: shapes at rest, moving shapes, meshes, planes at rest, moving planes.
#[derive(Clone)]
pub(super) struct Geometry {
    /// Attributes by object index.
    pub objects: Vec<ObjectAttributes>,
    /// Shapes at rest, then moving shapes.
    pub shapes: Vec<Shape>,
    /// Index of the first moving shape.
    pub first_moving: u32,
    /// Planes at rest, then moving planes.
    pub planes: Vec<Plane>,
    pub mesh: Arc<Mesh>,
    /// Range of triangle indices of each mesh object.
    pub mesh_ranges: Arc<[Range<u32>]>,
    /// Object index of each triangle.
    pub triangle_object: Arc<[u32]>,
    /// Bounds of all bounded objects at rest.
    pub static_bounds: Bounds,
    /// Hierarchy over triangles and shapes at rest.
    pub hierarchy: Arc<Hierarchy>,
    /// Hierarchy over moving shapes, if there are any.
    pub moving: Option<Arc<Hierarchy>>,
}

impl Geometry {
    /// Builds the hierarchies over the given primitives.
    pub fn new(
        objects: Vec<ObjectAttributes>,
        shapes: Vec<Shape>,
        first_moving: u32,
        planes: Vec<Plane>,
        mesh: Arc<Mesh>,
        mesh_ranges: Vec<Range<u32>>,
    ) -> Self {
        let corners: Vec<_> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let boxes: Vec<Bounds> = shapes[..first_moving as usize].iter().map(Shape::bounds).collect();
        let static_bounds =
            boxes.iter().copied().fold(Bounds::from_points(corners.iter().flatten().copied()), Bounds::union);
        let hierarchy = Arc::new(Hierarchy::build(&corners, &boxes));
        let mut triangle_object = Vec::with_capacity(corners.len());
        for (range, object) in mesh_ranges.iter().zip(shapes.len() as u32..) {
            triangle_object.resize(range.end as usize, object);
        }
        let mut geometry = Self {
            objects,
            shapes,
            first_moving,
            planes,
            mesh,
            mesh_ranges: mesh_ranges.into(),
            triangle_object: triangle_object.into(),
            static_bounds,
            hierarchy,
            moving: None,
        };
        geometry.rebuild_moving_hierarchy();
        geometry
    }

    /// Rebuilds the hierarchy over moving shapes after they have moved.
    pub fn rebuild_moving_hierarchy(&mut self) {
        let boxes: Vec<Bounds> = self.moving_shapes().iter().map(Shape::bounds).collect();
        self.moving = (!boxes.is_empty()).then(|| Arc::new(Hierarchy::build(&[], &boxes)));
    }

    pub fn moving_shapes(&self) -> &[Shape] {
        &self.shapes[self.first_moving as usize..]
    }

    /// Bounds of all bounded objects.
    pub fn bounds(&self) -> Bounds {
        self.moving_shapes().iter().map(Shape::bounds).fold(self.static_bounds, Bounds::union)
    }

    /// Object index of the first plane.
    fn first_plane_index(&self) -> usize {
        self.shapes.len() + self.mesh_ranges.len()
    }

    pub fn plane_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.first_plane_index()..]
    }

    pub fn mesh_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.shapes.len()..self.first_plane_index()]
    }

    /// Index of the object to which the primitive belongs.
    #[inline]
    pub fn object_index(&self, kind: HitKind) -> u32 {
        match kind {
            HitKind::Triangle(i, _) => self.triangle_object[i as usize],
            HitKind::Shape(i, _) => i,
            HitKind::Plane(i) => self.first_plane_index() as u32 + i,
        }
    }

    /// Attributes of the object to which the primitive belongs.
    #[inline]
    pub fn object_attributes(&self, kind: HitKind) -> &ObjectAttributes {
        &self.objects[self.object_index(kind) as usize]
    }

    /// Calls `visit` for every intersection along `ray`, in no particular order.
    pub fn for_each_hit(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let mut search = |hierarchy: &Hierarchy, first: u32| {
            hierarchy.for_each_hit(
                ray,
                |i, ray| self.shapes[(first + i) as usize].intersect(ray),
                |hit| {
                    let uv = Vec2::new(hit.u, hit.v);
                    let kind = match hit.primitive {
                        Primitive::Triangle(i) => HitKind::Triangle(i, uv),
                        Primitive::Other(i) => HitKind::Shape(first + i, uv),
                    };
                    visit(Hit { t: hit.t, kind });
                },
            );
        };
        search(&self.hierarchy, 0);
        if let Some(moving) = &self.moving {
            search(moving, self.first_moving);
        }
        for (i, plane) in self.planes.iter().enumerate() {
            if let Some((t, ..)) = plane.intersect(ray) {
                visit(Hit { t, kind: HitKind::Plane(i as u32) });
            }
        }
    }

    /// Position and normals at `hit` of `ray`, which must have a unit direction.
    #[inline]
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match hit.kind {
            HitKind::Triangle(i, b) => self.mesh.surface_point(i as usize, b),
            HitKind::Shape(i, uv) => self.shapes[i as usize].surface_point(ray, hit.t, uv),
            HitKind::Plane(i) => self.planes[i as usize].surface_point(ray, hit.t),
        }
    }

    /// Texture coordinates that the primitive itself defines at `hit`; zero on planes.
    pub fn surface_texture_coords(&self, hit: &Hit, point: &SurfacePoint) -> TexCoord {
        match hit.kind {
            HitKind::Triangle(i, b) => self.mesh.tex_coord(i as usize, b),
            HitKind::Shape(i, uv) => self.shapes[i as usize].tex_coord(point.p, uv),
            HitKind::Plane(_) => TexCoord::default(),
        }
    }

    /// Number that groups boundaries for the coincidence test: the object index, or `u32::MAX` for
    /// all shapes of a type that may share edges with others.
    ///
    /// A ray at a seam hits two shapes, which must count as one boundary.
    pub fn coincidence_group(&self, kind: HitKind) -> u32 {
        match kind {
            HitKind::Shape(i, _) if self.shapes[i as usize].may_share_edges() => u32::MAX,
            HitKind::Triangle(..) | HitKind::Shape(..) | HitKind::Plane(_) => self.object_index(kind),
        }
    }
}
