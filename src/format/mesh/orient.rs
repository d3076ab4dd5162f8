//! Makes the windings of a mesh consistent, with outward normals.

use super::merge::{DeduplicatedList, keep_listed_vertices};
use super::normals::face_normal;
use super::topology::{MeshTopology, ParityUnionFind};
use super::{NO_MATERIAL, TriangleMesh};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Largest number of closed components for which nesting is computed, because the cost is quadratic
/// in this number.
const MAX_NESTED_COMPONENTS: usize = 256;

/// Connected component of a mesh: triangles that reach each other across edges. Only an edge with
/// exactly two triangles connects them.
#[derive(Debug, Default)]
struct ConnectedMeshComponent {
    faces: Vec<u32>,
    /// True if every edge has exactly two triangles.
    is_closed: bool,
    /// True if flipping triangles can make all windings consistent.
    is_orientable: bool,
    low: DVec3,
    high: DVec3,
    material: u32,
}

pub(super) fn orient_outward(mesh: &mut TriangleMesh) -> usize {
    let topology = MeshTopology::new(mesh);
    let mut windings = ParityUnionFind::new(mesh.triangles.len());
    let mut conflicting = Vec::new();
    for half_edges in topology.half_edges_by_edge() {
        if let &[a, b] = half_edges
            && !windings.union_sets(a.triangle as usize, b.triangle as usize, a.is_forward == b.is_forward)
        {
            conflicting.push(a.triangle as usize);
        }
    }
    let mut is_flipped = vec![false; mesh.triangles.len()];
    let mut components: BTreeMap<usize, ConnectedMeshComponent> = BTreeMap::new();
    for (t, is_flipped) in
        is_flipped.iter_mut().enumerate().filter(|(t, _)| topology.has_distinct_positions(mesh.triangles[*t]))
    {
        let (root, is_flipped_to_root) = windings.find_root(t);
        *is_flipped = is_flipped_to_root;
        components.entry(root).or_insert_with(|| new_mesh_component(mesh, t)).add_triangle(mesh, t);
    }
    for t in conflicting {
        components.entry(windings.find_root(t).0).and_modify(|component| component.is_orientable = false);
    }
    for half_edges in topology.half_edges_by_edge().filter(|half_edges| half_edges.len() != 2) {
        for half_edge in half_edges {
            components
                .entry(windings.find_root(half_edge.triangle as usize).0)
                .and_modify(|component| component.is_closed = false);
        }
    }
    let components: Vec<ConnectedMeshComponent> = components.into_values().collect();
    let depths = component_nesting_depths(mesh, &components, &is_flipped);
    for (component, depth) in components.iter().zip(depths) {
        let flipped_count = component.faces.iter().filter(|t| is_flipped[**t as usize]).count();
        let flips_component = match (component.is_orientable, component.is_closed) {
            (false, _) => {
                component.faces.iter().for_each(|t| is_flipped[*t as usize] = false);
                continue;
            }
            (_, true) => (six_times_signed_volume(mesh, component, &is_flipped) < 0.0) != (depth % 2 == 1),
            (_, false) => 2 * flipped_count > component.faces.len(),
        };
        component.faces.iter().for_each(|t| is_flipped[*t as usize] ^= flips_component);
    }
    flip_marked_triangles(mesh, &is_flipped);
    is_flipped.into_iter().filter(|is_flipped| *is_flipped).count()
}

pub(super) fn reverse_orientation(mesh: &mut TriangleMesh) {
    mesh.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    mesh.normals.iter_mut().flatten().for_each(|n| *n = -*n);
}

fn new_mesh_component(mesh: &TriangleMesh, first: usize) -> ConnectedMeshComponent {
    ConnectedMeshComponent {
        is_closed: true,
        is_orientable: true,
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        material: mesh.triangle_materials.get(first).copied().unwrap_or(NO_MATERIAL),
        faces: Vec::new(),
    }
}

fn corner_positions(mesh: &TriangleMesh, triangle: u32) -> [DVec3; 3] {
    mesh.triangles[triangle as usize].map(|v| mesh.positions[v as usize])
}

/// Returns six times the signed volume of a closed component \[length³].
///
/// Triangles marked in `is_flipped` count with reversed winding.
fn six_times_signed_volume(mesh: &TriangleMesh, component: &ConnectedMeshComponent, is_flipped: &[bool]) -> f64 {
    let middle = 0.5 * (component.low + component.high);
    let six = |t: &u32| {
        let [a, b, c] = corner_positions(mesh, *t).map(|p| p - middle);
        let six = a.dot(b.cross(c));
        if is_flipped[*t as usize] { -six } else { six }
    };
    component.faces.iter().map(six).sum()
}

/// Returns the nesting depth of each component: the number of closed components that contain it and
/// have the same material.
///
/// Triangles marked in `is_flipped` count with reversed winding. Open and non-orientable components
/// have depth 0. All depths are 0 if there are more than [`MAX_NESTED_COMPONENTS`] closed
/// components.
fn component_nesting_depths(
    mesh: &TriangleMesh,
    components: &[ConnectedMeshComponent],
    is_flipped: &[bool],
) -> Vec<usize> {
    let closed = |component: &ConnectedMeshComponent| component.is_closed && component.is_orientable;
    let mut depths = vec![0; components.len()];
    if components.iter().filter(|component| closed(component)).count() > MAX_NESTED_COMPONENTS {
        return depths;
    }
    for (depth, inner) in depths.iter_mut().zip(components).filter(|(_, inner)| closed(inner)) {
        let [a, b, c] = corner_positions(mesh, inner.faces[0]);
        let middle = (a + b + c) / 3.0;
        let contains_inner = |outer: &&ConnectedMeshComponent| {
            let other = !std::ptr::eq(*outer, inner);
            let near = middle.cmpgt(outer.low).all() && middle.cmplt(outer.high).all();
            other
                && closed(outer)
                && near
                && outer.material == inner.material
                && mesh_component_contains_point(mesh, outer, is_flipped, middle)
        };
        *depth = components.iter().filter(contains_inner).count();
    }
    depths
}

/// True if the closed component contains the point `p`.
///
/// The test sums the signed solid angles of the component's triangles (van Oosterom and Strackee
/// 1983, "The solid angle of a plane triangle"). Triangles marked in `is_flipped` count with
/// reversed winding.
fn mesh_component_contains_point(
    mesh: &TriangleMesh,
    component: &ConnectedMeshComponent,
    is_flipped: &[bool],
    p: DVec3,
) -> bool {
    let angle = |t: &u32| {
        let [a, b, c] = corner_positions(mesh, *t).map(|q| q - p);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        let angle = 2.0 * libm::atan2(a.dot(b.cross(c)), below);
        if is_flipped[*t as usize] { -angle } else { angle }
    };
    // The sum is ±4π inside and 0 outside.
    component.faces.iter().map(angle).sum::<f64>().abs() > TAU
}

/// Flips the triangles marked in `is_flipped`.
///
/// Reverses a shading normal of a flipped triangle if it would point away from the new front side.
fn flip_marked_triangles(mesh: &mut TriangleMesh, is_flipped: &[bool]) {
    let Some(normals) = &mesh.normals else {
        for (triangle, _) in mesh.triangles.iter_mut().zip(is_flipped).filter(|(_, is_flipped)| **is_flipped) {
            triangle.swap(1, 2);
        }
        return;
    };
    let mut new_vertices: DeduplicatedList<(u32, bool)> = DeduplicatedList::with_capacity(mesh.positions.len());
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for (triangle, is_flipped) in mesh.triangles.iter().zip(is_flipped) {
        let [a, b, c] = *triangle;
        let oriented = if *is_flipped { [a, c, b] } else { *triangle };
        let face = face_normal(mesh, oriented);
        triangles.push(
            oriented.map(|v| {
                new_vertices.find_or_append((v, *is_flipped && normals[v as usize].dot(face) < 0.0), |key| *key)
            }),
        );
    }
    let vertices = new_vertices.into_values();
    let normal = |&(v, is_reversed): &(u32, bool)| if is_reversed { -normals[v as usize] } else { normals[v as usize] };
    mesh.normals = Some(vertices.iter().map(normal).collect());
    mesh.triangles = triangles;
    keep_listed_vertices(mesh, vertices.iter().map(|(v, _)| *v));
    mesh.merge_equal_vertices();
}

impl ConnectedMeshComponent {
    fn add_triangle(&mut self, mesh: &TriangleMesh, t: usize) {
        self.faces.push(t as u32);
        for p in corner_positions(mesh, t as u32) {
            (self.low, self.high) = (self.low.min(p), self.high.max(p));
        }
    }
}
