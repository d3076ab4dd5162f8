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
    /// Index of the area light that the object is.
    pub light: Option<u32>,
    /// Index of the texture mapping.
    pub mapping: u32,
}

/// The nearest intersection of a ray with the scene, before its surface is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    pub(super) kind: HitKind,
}

/// The primitive that a ray hits, with its surface parameters.
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
    /// Attributes by object.
    pub objects: Vec<ObjectAttributes>,
    /// Shapes at rest, then moving shapes.
    pub shapes: Vec<Shape>,
    /// Index of the first moving shape.
    pub first_moving: u32,
    /// Planes at rest, then moving planes.
    pub planes: Vec<Plane>,
    pub mesh: Arc<Mesh>,
    /// Triangles of each mesh object.
    pub mesh_ranges: Arc<[Range<u32>]>,
    /// Object of each triangle.
    pub triangle_object: Arc<[u32]>,
    /// Bounds of all bounded objects at rest.
    pub static_bounds: Bounds,
    /// Over triangles and shapes at rest.
    pub hierarchy: Arc<Hierarchy>,
    /// Over moving shapes, if there are any.
    pub moving: Option<Arc<Hierarchy>>,
}

impl Geometry {
    /// Geometry of objects at one time, with its hierarchies.
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

    /// The shapes that move.
    pub fn moving_shapes(&self) -> &[Shape] {
        &self.shapes[self.first_moving as usize..]
    }

    /// Bounds of all bounded objects.
    pub fn bounds(&self) -> Bounds {
        self.moving_shapes().iter().map(Shape::bounds).fold(self.static_bounds, Bounds::union)
    }

    /// Object number of plane 0.
    fn first_plane_index(&self) -> usize {
        self.shapes.len() + self.mesh_ranges.len()
    }

    /// Attributes of the planes.
    pub fn plane_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.first_plane_index()..]
    }

    /// Attributes of the meshes.
    pub fn mesh_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.shapes.len()..self.first_plane_index()]
    }

    /// Number of the object that a primitive belongs to.
    #[inline]
    pub fn object_index(&self, kind: HitKind) -> u32 {
        match kind {
            HitKind::Triangle(i, _) => self.triangle_object[i as usize],
            HitKind::Shape(i, _) => i,
            HitKind::Plane(i) => self.first_plane_index() as u32 + i,
        }
    }

    /// Attributes of the object that a primitive belongs to.
    #[inline]
    pub fn object_attributes(&self, kind: HitKind) -> &ObjectAttributes {
        &self.objects[self.object_index(kind) as usize]
    }

    /// Calls `visit` with every intersection along `ray`, in no order.
    pub fn for_each_hit(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let mut search = |hierarchy: &Hierarchy, first: u32| {
            hierarchy.each(
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

    /// Position and normals at a hit of `ray`, whose direction must be of unit length.
    #[inline]
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match hit.kind {
            HitKind::Triangle(i, b) => self.mesh.surface_point(i as usize, b),
            HitKind::Shape(i, uv) => self.shapes[i as usize].surface_point(ray, hit.t, uv),
            HitKind::Plane(i) => self.planes[i as usize].surface_point(ray, hit.t),
        }
    }

    /// The surface's own texture coordinates at a hit; zero on planes.
    pub fn surface_texture_coords(&self, hit: &Hit, point: &SurfacePoint) -> TexCoord {
        match hit.kind {
            HitKind::Triangle(i, b) => self.mesh.tex_coord(i as usize, b),
            HitKind::Shape(i, uv) => self.shapes[i as usize].tex_coord(point.p, uv),
            HitKind::Plane(_) => TexCoord::default(),
        }
    }

    /// The object of a primitive, with all patches and surfaces of revolution as one object.
    ///
    /// They share seams, where a ray hits two of them. Other shapes keep their points off their
    /// edges.
    pub fn coincidence_group(&self, kind: HitKind) -> u32 {
        match kind {
            HitKind::Shape(i, _) => match self.shapes[i as usize] {
                Shape::Patch(_) | Shape::Revolution(_) => u32::MAX,
                _ => i,
            },
            HitKind::Triangle(..) | HitKind::Plane(_) => self.object_index(kind),
        }
    }
}
