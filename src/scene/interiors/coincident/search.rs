//! Search for the primitives with which a boundary of another object may coincide.

use crate::accel::PrimitiveIndex;
use crate::math::Bounds;
use crate::scene::geometry::{Geometry, HitPrimitive};
use crate::shape::{Revolution, Shape};
use glam::DVec3;
use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

/// Maximum number of faces (triangles or whole shapes) in a leaf of the tree that is searched for
/// coincident boundaries.
const LEAF_FACES: usize = 8;

/// Limit of the search for coincident boundaries: the number of pairs of faces that it may test,
/// divided by the number of faces. If the search needs more tests, all faces count as possibly
/// coincident.
const PAIRS_PER_FACE: usize = 1000;

/// Greatest number of pairs of profile leaves (short pieces of a profile curve) that the search for
/// coincident boundaries may test. Such pairs are tested where surfaces of revolution share their
/// axis. If there are more pairs, whole surfaces count as possibly coincident.
const MAX_PROFILE_LEAF_PAIRS: usize = 100_000_000;

/// Margin by which a bounding box is expanded, divided by the size c + s of the box. c is the
/// greatest absolute coordinate of the box, and s the longest side.
///
/// The margin exceeds the position errors of two surface points (see
/// `SurfacePoint::position_error`).
const RELATIVE_MARGIN: f32 = 16.0 * f32::EPSILON;

/// The part of a shape with which a boundary of another object may coincide.
#[derive(Clone, Debug, PartialEq)]
enum CoincidentPart {
    Nothing,
    Everything,
    /// Part of a surface of revolution: one flag for each interval of its profile curve, true if a
    /// boundary may coincide there. The flags are from [`Revolution::near_profile_interval_flags`].
    ProfileIntervals(Vec<bool>),
}

impl CoincidentPart {
    /// Adds the profile intervals whose flag in `intervals` is true to this part.
    fn add_intervals(&mut self, intervals: Vec<bool>) {
        match self {
            Self::Nothing => *self = Self::ProfileIntervals(intervals),
            Self::Everything => {}
            Self::ProfileIntervals(flags) => flags.iter_mut().zip(intervals).for_each(|(flag, new)| *flag |= new),
        }
    }
}

/// For each primitive of a scene: whether the boundary of another object's dielectric body may
/// coincide with the primitive, and on which part of it.
///
/// Both lists are empty if `all_flagged` is true, or if no boxes of boundary objects overlap.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct CoincidentFlags {
    /// One flag for each triangle: true if the boundary of another object may coincide with it.
    triangles: Arc<[bool]>,
    /// For each shape, the part with which the boundary of another object may coincide.
    shapes: Arc<[CoincidentPart]>,
    /// True if every primitive may coincide with another object's boundary. This is assumed if the
    /// scene has two or more boundaries, and one of them moves or is unbounded.
    all_flagged: bool,
}

impl CoincidentFlags {
    /// True if the boundary of another object's dielectric body may coincide with `primitive` at
    /// the hit.
    #[inline]
    pub fn may_coincide(&self, primitive: HitPrimitive) -> bool {
        self.all_flagged
            || match primitive {
                HitPrimitive::Triangle(i, _) => self.triangles.get(i as usize).copied().unwrap_or(false),
                HitPrimitive::Shape(i, coords) => match self.shapes.get(i as usize) {
                    None | Some(CoincidentPart::Nothing) => false,
                    Some(CoincidentPart::Everything) => true,
                    Some(CoincidentPart::ProfileIntervals(flags)) => {
                        flags[Revolution::profile_interval_index(coords.x)]
                    }
                },
                HitPrimitive::Plane(_) => false,
            }
    }
}

/// A triangle or a whole shape that bounds a dielectric body.
struct BoundaryFace {
    primitive: PrimitiveIndex,
    bounds: Bounds,
    /// Index of the mesh or shape that contains the face, in the list of boundary objects.
    boundary_object: u32,
}

/// The box around a mesh or shape that bounds a dielectric body.
struct BoundaryObjectBounds {
    bounds: Bounds,
    /// Distance by which the box is expanded \[length]. Faces of two objects count as coincident
    /// within the sum of both margins.
    margin: f32,
}

impl BoundaryObjectBounds {
    fn new(bounds: Bounds) -> Self {
        let size = bounds.min.abs().max(bounds.max.abs()).max_element() + bounds.extent().max_element();
        Self { bounds: bounds.expanded(size * RELATIVE_MARGIN), margin: size * RELATIVE_MARGIN }
    }
}

/// Finds the primitives of `geometry` with which a boundary of another object may coincide.
///
/// `is_boundary` returns true if the material with the given index bounds a dielectric body.
pub(in crate::scene) fn flag_coincident_primitives(
    geometry: &Geometry,
    is_boundary: impl Fn(u32) -> bool,
) -> CoincidentFlags {
    let bounds_body = |object: usize| is_boundary(geometry.objects[object].material);
    let first_moving = geometry.shapes.first_moving_index() as usize;
    let boundary_shapes: Vec<usize> = (0..first_moving).filter(|i| bounds_body(*i)).collect();
    let mesh_bounds = boundary_mesh_bounds(geometry, bounds_body);
    let moving = first_moving..geometry.shapes.len();
    let plane_objects = geometry.shapes.len() + geometry.mesh_ranges.len()..geometry.objects.len();
    let unlocated_count = moving.chain(plane_objects).filter(|object| bounds_body(*object)).count();
    if unlocated_count > 0 {
        let others = boundary_shapes.len() + mesh_bounds.iter().flatten().count();
        return CoincidentFlags { all_flagged: unlocated_count + others > 1, ..CoincidentFlags::default() };
    }
    let mut extents: Vec<BoundaryObjectBounds> =
        boundary_shapes.iter().map(|i| BoundaryObjectBounds::new(Shape::bounds(&geometry.shapes[*i as u32]))).collect();
    let mut extent_of_mesh = vec![None; mesh_bounds.len()];
    for (extent, bounds) in extent_of_mesh.iter_mut().zip(&mesh_bounds) {
        if let Some(bounds) = bounds {
            *extent = Some(extents.len() as u32);
            extents.push(BoundaryObjectBounds::new(*bounds));
        }
    }
    let is_overlapping = flag_overlapping_bounds(&extents);
    if !is_overlapping.contains(&true) {
        return CoincidentFlags::default();
    }
    let mut faces: Vec<BoundaryFace> = Vec::new();
    for (object, i) in boundary_shapes.iter().enumerate().filter(|(object, _)| is_overlapping[*object]) {
        let primitive = PrimitiveIndex::Other(*i as u32);
        faces.push(BoundaryFace { primitive, bounds: extents[object].bounds, boundary_object: object as u32 });
    }
    for (i, object) in geometry.object_of_triangle.iter().enumerate() {
        let mesh = *object as usize - geometry.shapes.len();
        if let Some(object) = extent_of_mesh[mesh].filter(|object| is_overlapping[*object as usize]) {
            let bounds = Bounds::from_points(geometry.mesh.corners(i)).expanded(extents[object as usize].margin);
            faces.push(BoundaryFace { primitive: PrimitiveIndex::Triangle(i as u32), bounds, boundary_object: object });
        }
    }
    let margin = |a: &BoundaryFace, b: &BoundaryFace| {
        f64::from(extents[a.boundary_object as usize].margin + extents[b.boundary_object as usize].margin)
    };
    // Liquids in glasses share the axis of the glass. For such pairs, the parts of both surfaces
    // that may coincide are found later.
    let coaxial_pairs = RefCell::new(Vec::new());
    let near = |a: &BoundaryFace, b: &BoundaryFace| {
        let margin = margin(a, b);
        match (a.primitive, b.primitive) {
            (PrimitiveIndex::Triangle(i), PrimitiveIndex::Triangle(j)) => {
                let [a, b] = [i, j].map(|i| geometry.mesh.corners(i as usize).map(|p| p.as_dvec3()));
                !(lie_on_one_side_of_plane(&a, &b, margin) || lie_on_one_side_of_plane(&b, &a, margin))
            }
            (PrimitiveIndex::Other(i), PrimitiveIndex::Other(j)) => match (&geometry.shapes[i], &geometry.shapes[j]) {
                (Shape::Revolution(first), Shape::Revolution(second)) if first.shares_axis(second) => {
                    coaxial_pairs.borrow_mut().push((i.min(j), i.max(j), margin));
                    false
                }
                _ => true,
            },
            (PrimitiveIndex::Other(_), PrimitiveIndex::Triangle(_))
            | (PrimitiveIndex::Triangle(_), PrimitiveIndex::Other(_)) => true,
        }
    };
    let found = SpatialSelfJoin::faces_near_other_objects(&faces, &near);
    let mut triangles = vec![false; geometry.object_of_triangle.len()];
    let mut shapes = vec![CoincidentPart::Nothing; geometry.shapes.len()];
    for (face, _) in faces.iter().zip(found).filter(|(_, found)| *found) {
        match face.primitive {
            PrimitiveIndex::Triangle(i) => triangles[i as usize] = true,
            PrimitiveIndex::Other(i) => shapes[i as usize] = CoincidentPart::Everything,
        }
    }
    flag_coaxial_pairs(geometry, coaxial_pairs.into_inner(), MAX_PROFILE_LEAF_PAIRS, &mut shapes);
    CoincidentFlags { triangles: triangles.into(), shapes: shapes.into(), all_flagged: false }
}

/// Flags in `shapes` the parts of coaxial surfaces of revolution that are near each other.
///
/// Each of `pairs` holds the indices of two shapes, the lower one first, and the distance within
/// which they may coincide \[length]. At most `budget` pairs of profile leaves (short pieces of a
/// profile curve) are tested. If more are needed, whole surfaces are flagged.
fn flag_coaxial_pairs(
    geometry: &Geometry,
    mut pairs: Vec<(u32, u32, f64)>,
    mut budget: usize,
    shapes: &mut [CoincidentPart],
) {
    // Drop duplicate pairs: the search may test two faces of one tree leaf in both orders.
    pairs.sort_unstable_by_key(|(i, j, _)| (*i, *j));
    pairs.dedup_by_key(|(i, j, _)| (*i, *j));
    for (i, j, margin) in pairs {
        let (Shape::Revolution(first), Shape::Revolution(second)) = (&geometry.shapes[i], &geometry.shapes[j]) else {
            continue;
        };
        let indices = [i as usize, j as usize];
        if indices.iter().all(|i| shapes[*i] == CoincidentPart::Everything) {
            continue;
        }
        match budget.checked_sub(first.profile_leaf_count().saturating_mul(second.profile_leaf_count())) {
            Some(rest) => {
                budget = rest;
                shapes[indices[0]].add_intervals(first.near_profile_interval_flags(second, margin));
                shapes[indices[1]].add_intervals(second.near_profile_interval_flags(first, margin));
            }
            None => indices.iter().for_each(|i| shapes[*i] = CoincidentPart::Everything),
        }
    }
}

/// Returns the bounds of each mesh that bounds a dielectric body; `None` for other meshes and for
/// meshes without triangles.
fn boundary_mesh_bounds(geometry: &Geometry, bounds_body: impl Fn(usize) -> bool) -> Vec<Option<Bounds>> {
    let mut mesh_bounds: Vec<Option<Bounds>> = vec![None; geometry.mesh_ranges.len()];
    for (i, object) in geometry.object_of_triangle.iter().enumerate() {
        let object = *object as usize;
        if bounds_body(object) {
            let corners = Bounds::from_points(geometry.mesh.corners(i));
            let all = &mut mesh_bounds[object - geometry.shapes.len()];
            *all = Some(all.map_or(corners, |b| b.union(corners)));
        }
    }
    mesh_bounds
}

/// Returns a flag for each boundary object: true if the object's box overlaps the box of another
/// boundary object.
fn flag_overlapping_bounds(extents: &[BoundaryObjectBounds]) -> Vec<bool> {
    let face = |(extent, i): (&BoundaryObjectBounds, u32)| BoundaryFace {
        primitive: PrimitiveIndex::Other(i),
        bounds: extent.bounds,
        boundary_object: i,
    };
    SpatialSelfJoin::faces_near_other_objects(
        &extents.iter().zip(0..).map(face).collect::<Vec<BoundaryFace>>(),
        &|_, _| true,
    )
}

/// True if triangle `b` lies on one side of the plane of triangle `a`, farther from it than
/// `margin` \[length].
fn lie_on_one_side_of_plane(a: &[DVec3; 3], b: &[DVec3; 3], margin: f64) -> bool {
    let normal = (a[1] - a[0]).cross(a[2] - a[0]);
    let margin = margin * normal.length();
    let heights = b.map(|p| normal.dot(p - a[0]));
    heights.iter().all(|h| *h > margin) || heights.iter().all(|h| *h < -margin)
}

/// A node of the tree over boundary faces: a range of faces, and two children or none.
struct FaceTreeNode {
    bounds: Bounds,
    members: Range<usize>,
    children: Option<[usize; 2]>,
    /// Index of the object that contains all faces of the node; `None` if the faces are of several
    /// objects.
    boundary_object: Option<u32>,
}

/// A spatial self-join: finds the faces that are near a face of another object.
struct SpatialSelfJoin<'a> {
    faces: &'a [BoundaryFace],
    near: &'a dyn Fn(&BoundaryFace, &BoundaryFace) -> bool,
    /// Indices of faces, ordered so that the faces of each tree node are consecutive.
    order: Vec<u32>,
    nodes: Vec<FaceTreeNode>,
    found: Vec<bool>,
    /// Number of pairs of faces that may still be tested.
    budget: usize,
}

impl<'a> SpatialSelfJoin<'a> {
    fn faces_near_other_objects(
        faces: &'a [BoundaryFace],
        near: &'a dyn Fn(&BoundaryFace, &BoundaryFace) -> bool,
    ) -> Vec<bool> {
        let order = (0..faces.len() as u32).collect();
        if faces.is_empty() {
            return Vec::new();
        }
        let (nodes, found, budget) = (Vec::new(), vec![false; faces.len()], faces.len().saturating_mul(PAIRS_PER_FACE));
        let mut join = Self { faces, near, order, nodes, found, budget };
        join.build_subtree(0..faces.len());
        if join.join_node_with_itself(0).is_none() {
            join.found.fill(true);
        }
        join.found
    }

    fn nth_face_in_tree_order(&self, member: usize) -> &'a BoundaryFace {
        &self.faces[self.order[member] as usize]
    }

    fn build_subtree(&mut self, members: Range<usize>) -> usize {
        let bounds = members.clone().fold(Bounds::EMPTY, |all, i| all.union(self.nth_face_in_tree_order(i).bounds));
        let object = self.nth_face_in_tree_order(members.start).boundary_object;
        let object =
            members.clone().all(|i| self.nth_face_in_tree_order(i).boundary_object == object).then_some(object);
        let index = self.nodes.len();
        self.nodes.push(FaceTreeNode { bounds, members: members.clone(), children: None, boundary_object: object });
        if members.len() > LEAF_FACES {
            let axis = bounds.extent().max_position();
            let faces = self.faces;
            let middle = |i: &u32| faces[*i as usize].bounds.min[axis] + faces[*i as usize].bounds.max[axis];
            let half = members.len() / 2;
            self.order[members.clone()].select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            let cut = members.start + half;
            self.nodes[index].children =
                Some([self.build_subtree(members.start..cut), self.build_subtree(cut..members.end)]);
        }
        index
    }

    /// Tests the faces below `node` in pairs, and flags faces of different objects that are near
    /// each other. Returns `None` if the budget of pair tests does not suffice.
    fn join_node_with_itself(&mut self, node: usize) -> Option<()> {
        if self.nodes[node].boundary_object.is_some() {
            return Some(());
        }
        match self.nodes[node].children {
            Some([a, b]) => {
                self.join_node_with_itself(a)?;
                self.join_node_with_itself(b)?;
                self.join_node_pair(a, b)
            }
            None => self.flag_near_face_pairs(self.nodes[node].members.clone(), self.nodes[node].members.clone()),
        }
    }

    /// Tests each face below node `a` with each face below node `b`, and flags both if they are
    /// near each other and are faces of different objects. Returns `None` if the budget of pair
    /// tests does not suffice.
    fn join_node_pair(&mut self, a: usize, b: usize) -> Option<()> {
        let (first, second) = (&self.nodes[a], &self.nodes[b]);
        if first.boundary_object.is_some() && first.boundary_object == second.boundary_object
            || !first.bounds.overlaps(&second.bounds)
        {
            return Some(());
        }
        match (first.children, second.children) {
            (Some(children), None) => children.into_iter().try_for_each(|child| self.join_node_pair(child, b)),
            (Some(children), _) if first.members.len() >= second.members.len() => {
                children.into_iter().try_for_each(|child| self.join_node_pair(child, b))
            }
            (_, Some(children)) => children.into_iter().try_for_each(|child| self.join_node_pair(a, child)),
            (None, None) => self.flag_near_face_pairs(first.members.clone(), second.members.clone()),
        }
    }

    fn flag_near_face_pairs(&mut self, first: Range<usize>, second: Range<usize>) -> Option<()> {
        self.budget = self.budget.checked_sub(first.len() * second.len())?;
        for i in first {
            for j in second.clone() {
                let (a, b) = (self.nth_face_in_tree_order(i), self.nth_face_in_tree_order(j));
                let [i, j] = [i, j].map(|member| self.order[member] as usize);
                if a.boundary_object != b.boundary_object
                    && !(self.found[i] && self.found[j])
                    && a.bounds.overlaps(&b.bounds)
                    && (self.near)(a, b)
                {
                    (self.found[i], self.found[j]) = (true, true);
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests;
