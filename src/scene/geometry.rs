//! The geometry of a built scene, with the bounding volume hierarchies that find intersections.

use super::shape_list::ShapeList;
use crate::accel::{Bvh, PrimitiveHit, PrimitiveIndex, ShapeHit};
use crate::math::{Bounds, Ray};
use crate::shape::{Mesh, Plane, Shape, SurfacePoint, TexCoord};
use glam::{Vec2, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// The material, light and texture mapping of one object.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectAttributes {
    /// Index of the object's material.
    pub material: u32,
    /// Index of the object's area light; `None` if the object does not emit light.
    pub light: Option<u32>,
    /// Index of the object's texture mapping.
    pub mapping: u32,
}

/// An intersection of a ray with the scene: ray parameter and primitive, without surface
/// properties.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Ray parameter of the intersection; the distance if the ray has a unit direction.
    pub t: f32,
    /// The primitive that was hit, with the coordinates of the hit on it.
    pub(super) primitive: HitPrimitive,
}

impl Hit {
    /// Converts a hit that [`Geometry::resting_hierarchy`] found: on a triangle or on a shape at
    /// rest.
    #[inline]
    pub(super) fn from_resting_primitive(hit: PrimitiveHit) -> Self {
        let uv = Vec2::new(hit.u, hit.v);
        let primitive = match hit.primitive {
            PrimitiveIndex::Triangle(i) => HitPrimitive::Triangle(i, uv),
            PrimitiveIndex::Other(i) => HitPrimitive::Shape(i, uv),
        };
        Self { t: hit.t, primitive }
    }

    /// Converts a hit that [`Geometry::moving_hierarchy`] found: on a moving shape. `first_moving`
    /// is the index of the first moving shape in the list of all shapes.
    #[inline]
    pub(super) fn from_moving_primitive(hit: PrimitiveHit, first_moving: u32) -> Self {
        let (PrimitiveIndex::Triangle(i) | PrimitiveIndex::Other(i)) = hit.primitive;
        Self { t: hit.t, primitive: HitPrimitive::Shape(first_moving + i, Vec2::new(hit.u, hit.v)) }
    }

    /// Returns `ray` shortened to end at `hit`; unchanged if `hit` is `None`.
    #[inline]
    pub(super) fn limit_ray(hit: Option<Self>, ray: &Ray) -> Ray {
        Ray { t_max: hit.map_or(ray.t_max, |h| h.t), ..*ray }
    }
}

/// The primitive that a ray hits, with the coordinates of the hit on that primitive.
#[derive(Clone, Copy, Debug)]
pub(super) enum HitPrimitive {
    /// Index of a triangle, and the barycentric weights of its second and third corner.
    Triangle(u32, Vec2),
    /// Index of a shape, and the shape's own coordinates of the hit, as in
    /// [`ShapeHit`].
    Shape(u32, Vec2),
    /// Index of an unbounded plane.
    Plane(u32),
}

/// A set of objects whose boundaries count as one boundary wherever they coincide. There, a path
/// crosses all of them at once.
///
/// Usually each object is a group of its own. All shapes that may share edges with neighbours form
/// one group, because a ray through a common edge can hit two of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CoincidenceGroup(u32);

impl CoincidenceGroup {
    /// Coincidence group of all shapes for which [`Shape::may_share_edges`] is true.
    pub const SHARED_EDGES: Self = Self(u32::MAX);
    /// Placeholder for a boundary with which no other boundary can coincide, so that its group is
    /// never compared.
    pub const UNUSED: Self = Self(0);

    /// Coincidence group that contains only the object with this index.
    pub const fn group_of_single_object(index: u32) -> Self {
        Self(index)
    }

    /// Number that distinguishes this group from all others.
    pub const fn index(self) -> u32 {
        self.0
    }
}

/// The primitives of a scene: triangles, shapes and unbounded planes.
///
/// A ray query searches one [`Bvh`] over triangles and shapes at rest, a second one over moving
/// shapes, and all planes in turn. It then keeps the nearest hit. A `Bvh` intersects its triangles
/// itself. For a shape, it stores only the bounding box, and the caller passes a function that
/// intersects the shape.
///
/// Objects are numbered in this order: shapes at rest, moving shapes, meshes, planes at rest,
/// moving planes.
#[derive(Clone)]
pub(super) struct Geometry {
    /// Material, light and texture mapping of each object, by object index.
    pub objects: Arc<[ObjectAttributes]>,
    pub shapes: ShapeList,
    /// Planes at rest, then moving planes.
    pub planes: Vec<Plane>,
    pub mesh: Arc<Mesh>,
    /// Range of triangle indices of each mesh object.
    pub mesh_ranges: Arc<[Range<u32>]>,
    /// Object index of each triangle.
    pub object_of_triangle: Arc<[u32]>,
    /// Bounds of all objects at rest except unbounded planes.
    pub static_bounds: Bounds,
    /// Bounding volume hierarchy over triangles and shapes at rest.
    pub resting_hierarchy: Arc<Bvh>,
    /// Bounding volume hierarchy over moving shapes; `None` if there are none.
    pub moving_hierarchy: Option<Arc<Bvh>>,
}

/// Builds the bounding volume hierarchy over the triangles of `mesh`, and over shapes at rest with
/// these `boxes`. Returns the hierarchy, and the bounds of all triangles and boxes.
fn build_static_hierarchy(mesh: &Mesh, boxes: &[Bounds]) -> (Arc<Bvh>, Bounds) {
    let corners: Vec<_> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
    let bounds = boxes.iter().copied().fold(Bounds::from_points(corners.iter().flatten().copied()), Bounds::union);
    (Arc::new(Bvh::build(&corners, boxes)), bounds)
}

impl Geometry {
    /// Builds the bounding volume hierarchies over the given primitives. The shapes from index
    /// `first_moving` on move; all others rest. The hierarchy over primitives at rest is taken from
    /// `earlier` if it was built from the same triangles and boxes.
    pub fn new(
        objects: Vec<ObjectAttributes>,
        shapes: Vec<Shape>,
        first_moving: u32,
        planes: Vec<Plane>,
        mesh: Arc<Mesh>,
        mesh_ranges: Vec<Range<u32>>,
        earlier: Option<&Self>,
    ) -> Self {
        let shapes = ShapeList::new(shapes, first_moving);
        let boxes: Vec<Bounds> = shapes.resting().iter().map(Shape::bounds).collect();
        let (hierarchy, static_bounds) =
            match earlier.filter(|earlier| earlier.resting_hierarchy_matches(&mesh, &boxes)) {
                Some(earlier) => (earlier.resting_hierarchy.clone(), earlier.static_bounds),
                None => build_static_hierarchy(&mesh, &boxes),
            };
        let mut triangle_object = Vec::with_capacity(mesh.triangles.len());
        for (range, object) in mesh_ranges.iter().zip(shapes.len() as u32..) {
            triangle_object.resize(range.end as usize, object);
        }
        let mut geometry = Self {
            objects: objects.into(),
            shapes,
            planes,
            mesh,
            mesh_ranges: mesh_ranges.into(),
            object_of_triangle: triangle_object.into(),
            static_bounds,
            resting_hierarchy: hierarchy,
            moving_hierarchy: None,
        };
        geometry.rebuild_moving_hierarchy();
        geometry
    }

    /// True if [`Geometry::resting_hierarchy`] was built from exactly these triangles and boxes: in
    /// this order, with the same bits.
    fn resting_hierarchy_matches(&self, mesh: &Mesh, boxes: &[Bounds]) -> bool {
        let bits = |point: Vec3| point.to_array().map(f32::to_bits);
        let corners = |mesh: &Mesh, i: usize| mesh.corners(i).map(bits);
        let box_bits = |bounds: &Bounds| [bounds.min, bounds.max].map(bits);
        let resting = self.shapes.resting();
        resting.len() == boxes.len()
            && self.mesh.triangles.len() == mesh.triangles.len()
            && resting.iter().zip(boxes).all(|(shape, bounds)| box_bits(&shape.bounds()) == box_bits(bounds))
            && (0..mesh.triangles.len()).all(|i| corners(&self.mesh, i) == corners(mesh, i))
    }

    /// Rebuilds the bounding volume hierarchy over moving shapes, after their positions have
    /// changed.
    pub fn rebuild_moving_hierarchy(&mut self) {
        let boxes: Vec<Bounds> = self.shapes.moving().iter().map(Shape::bounds).collect();
        self.moving_hierarchy = (!boxes.is_empty()).then(|| Arc::new(Bvh::build(&[], &boxes)));
    }

    /// Bounds of all objects except unbounded planes.
    pub fn bounds(&self) -> Bounds {
        self.shapes.moving().iter().map(Shape::bounds).fold(self.static_bounds, Bounds::union)
    }

    /// Index of the first plane in the list of objects.
    fn first_plane_index(&self) -> usize {
        self.shapes.len() + self.mesh_ranges.len()
    }

    pub fn plane_object_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.first_plane_index()..]
    }

    pub fn mesh_object_attributes(&self) -> &[ObjectAttributes] {
        &self.objects[self.shapes.len()..self.first_plane_index()]
    }

    /// Index of the object to which the primitive belongs.
    #[inline]
    pub fn object_index(&self, primitive: HitPrimitive) -> u32 {
        match primitive {
            HitPrimitive::Triangle(i, _) => self.object_of_triangle[i as usize],
            HitPrimitive::Shape(i, _) => i,
            HitPrimitive::Plane(i) => self.first_plane_index() as u32 + i,
        }
    }

    /// Attributes of the object to which the primitive belongs.
    #[inline]
    pub fn object_attributes(&self, primitive: HitPrimitive) -> &ObjectAttributes {
        &self.objects[self.object_index(primitive) as usize]
    }

    /// The nearest intersection of `ray` with any primitive, for 0 < t < `ray.t_max`; `None` if the
    /// ray hits nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let Self { shapes, resting_hierarchy: hierarchy, moving_hierarchy: moving, .. } = self;
        let (resting, in_motion) = (shapes.resting(), shapes.moving());

        // Find the nearest triangle or shape at rest.
        let mut hit =
            hierarchy.closest_hit(ray, |i, ray| resting[i as usize].intersect(ray)).map(Hit::from_resting_primitive);

        // Find a moving shape that is nearer.
        if let Some(moving) = moving {
            let nearer = moving.closest_hit(&Hit::limit_ray(hit, ray), |i, ray| in_motion[i as usize].intersect(ray));
            hit = nearer.map(|h| Hit::from_moving_primitive(h, shapes.first_moving_index())).or(hit);
        }

        self.nearest_plane_hit(&Hit::limit_ray(hit, ray)).or(hit)
    }

    /// The nearest intersection of `ray` with an unbounded plane, for 0 < t < `ray.t_max`; `None`
    /// if the ray hits no plane.
    #[inline]
    pub fn nearest_plane_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hit: Option<Hit> = None;
        for (i, plane) in self.planes.iter().enumerate() {
            let within = Ray { t_max: hit.map_or(ray.t_max, |h| h.t), ..*ray };
            if let Some(ShapeHit { t, .. }) = plane.intersect(&within) {
                hit = Some(Hit { t, primitive: HitPrimitive::Plane(i as u32) });
            }
        }
        hit
    }

    /// True if `ray` hits any primitive, for 0 < t < `ray.t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let Self { shapes, planes, resting_hierarchy: hierarchy, moving_hierarchy: moving, .. } = self;
        let (resting, in_motion) = (shapes.resting(), shapes.moving());
        planes.iter().any(|plane| plane.intersect(ray).is_some())
            || hierarchy.occluded(ray, |i, ray| resting[i as usize].occludes(ray))
            || moving.as_ref().is_some_and(|moving| moving.occluded(ray, |i, ray| in_motion[i as usize].occludes(ray)))
    }

    /// Calls `visit` for every intersection along `ray`, in no particular order.
    pub fn for_each_hit(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let mut search = |hierarchy: &Bvh, shapes: &[Shape], first: u32| {
            hierarchy.for_each_hit(
                ray,
                |i, ray| shapes[i as usize].intersect(ray),
                |hit| {
                    let uv = Vec2::new(hit.u, hit.v);
                    let primitive = match hit.primitive {
                        PrimitiveIndex::Triangle(i) => HitPrimitive::Triangle(i, uv),
                        PrimitiveIndex::Other(i) => HitPrimitive::Shape(first + i, uv),
                    };
                    visit(Hit { t: hit.t, primitive });
                },
            );
        };
        search(&self.resting_hierarchy, self.shapes.resting(), 0);
        if let Some(moving) = &self.moving_hierarchy {
            search(moving, self.shapes.moving(), self.shapes.first_moving_index());
        }
        for (i, plane) in self.planes.iter().enumerate() {
            if let Some(ShapeHit { t, .. }) = plane.intersect(ray) {
                visit(Hit { t, primitive: HitPrimitive::Plane(i as u32) });
            }
        }
    }

    /// Position and normals at `hit` of `ray`, which must have a unit direction.
    #[inline]
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match hit.primitive {
            HitPrimitive::Triangle(i, b) => self.mesh.surface_point(i as usize, b),
            HitPrimitive::Shape(i, uv) => self.shapes[i].surface_point(ray, hit.t, uv),
            HitPrimitive::Plane(i) => self.planes[i as usize].surface_point(ray, hit.t),
        }
    }

    /// Texture coordinates at `hit` as the mesh or shape itself defines them, without a texture
    /// mapping; zero on planes.
    pub fn surface_texture_coords(&self, hit: &Hit, point: &SurfacePoint) -> TexCoord {
        match hit.primitive {
            HitPrimitive::Triangle(i, b) => self.mesh.tex_coord(i as usize, b),
            HitPrimitive::Shape(i, uv) => self.shapes[i].tex_coord(point.p, uv),
            HitPrimitive::Plane(_) => TexCoord::default(),
        }
    }

    /// The coincidence group of the object to which `primitive` belongs.
    pub fn coincidence_group(&self, primitive: HitPrimitive) -> CoincidenceGroup {
        match primitive {
            HitPrimitive::Shape(i, _) if self.shapes[i].may_share_edges() => CoincidenceGroup::SHARED_EDGES,
            HitPrimitive::Triangle(..) | HitPrimitive::Shape(..) | HitPrimitive::Plane(_) => {
                CoincidenceGroup::group_of_single_object(self.object_index(primitive))
            }
        }
    }
}
