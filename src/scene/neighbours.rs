//! Which boundaries of bodies may coincide with another's.

use super::{HitKind, Scattering, Scene};
use crate::accel::Primitive;
use crate::math::Bounds;
use crate::shape::Shape;
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Faces of a leaf of the tree that finds them.
const LEAF: usize = 8;

/// Pairs of faces for each face that are looked at; where more boxes meet, all faces count as near.
const PAIRS: usize = 1000;

/// Places are known within some ulps of coordinates and sizes (see `SurfacePoint::error`): two of them, and to spare.
const REACH: f32 = 16.0 * f32::EPSILON;

/// For triangles and shapes, whether a boundary of another thing may lie on some part of them; empty where that is so of none.
#[derive(Clone, Debug, Default)]
pub(super) struct Neighbours {
    triangles: Arc<[bool]>,
    shapes: Arc<[bool]>,
    /// Whether it may be so of anything: what moves, and what has no end, is anywhere.
    anywhere: bool,
}

impl Neighbours {
    #[inline]
    pub fn may(&self, kind: HitKind) -> bool {
        let of = |flags: &[bool], i: u32| flags.get(i as usize).copied().unwrap_or(false);
        self.anywhere
            || match kind {
                HitKind::Triangle(i, _) => of(&self.triangles, i),
                HitKind::Shape(i, _) => of(&self.shapes, i),
                HitKind::Plane(_) => false,
            }
    }
}

/// A triangle, or a whole shape.
struct Face {
    primitive: Primitive,
    bounds: Bounds,
    /// What it is part of: a mesh or a shape.
    thing: u32,
}

/// A mesh or a shape.
struct Thing {
    bounds: Bounds,
    /// How far from its faces another counts as on them.
    reach: f32,
}

impl Thing {
    fn new(bounds: Bounds) -> Self {
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element() + bounds.extent().max_element();
        Self { bounds: bounds.expanded(reach * REACH), reach: reach * REACH }
    }
}

impl Scene {
    pub(super) fn find_neighbours(&self) -> Neighbours {
        let bounds: Vec<bool> = (0..self.materials.len() as u32).map(|material| self.may_bound(material)).collect();
        let is_boundary = |material: u32| bounds[material as usize];
        let still = self.shapes.iter().zip(&self.shape_attributes).zip(0..self.first_moving);
        let still = still.filter(|((_, attributes), _)| is_boundary(attributes.material));
        let shapes: Vec<(u32, Bounds)> = still.map(|((shape, _), i)| (i, Shape::bounds(shape))).collect();
        let mut parts: Vec<Option<Bounds>> = vec![None; self.parts.len()];
        for (i, part) in self.triangle_part.iter().enumerate() {
            if is_boundary(self.parts[*part as usize].1.material) {
                let corners = Bounds::of(self.mesh.corners(i));
                let whole = &mut parts[*part as usize];
                *whole = Some(whole.map_or(corners, |b| b.union(corners)));
            }
        }
        let moving = self.shape_attributes[self.first_moving as usize..].iter();
        let endless = self.planes.iter().map(|(_, attributes)| attributes);
        let anywhere = moving.chain(endless).filter(|attributes| is_boundary(attributes.material)).count();
        if anywhere > 0 {
            let others = shapes.len() + parts.iter().flatten().count();
            return Neighbours { anywhere: anywhere + others > 1, ..Neighbours::default() };
        }
        let mut things: Vec<Thing> = shapes.iter().map(|(_, b)| Thing::new(*b)).collect();
        let mut numbers = vec![None; parts.len()];
        for (number, whole) in numbers.iter_mut().zip(&parts) {
            if let Some(whole) = whole {
                *number = Some(things.len() as u32);
                things.push(Thing::new(*whole));
            }
        }
        let meeting = meeting(&things);
        if !meeting.contains(&true) {
            return Neighbours::default();
        }
        let mut faces: Vec<Face> = Vec::new();
        for (thing, (i, _)) in shapes.iter().enumerate().filter(|(thing, _)| meeting[*thing]) {
            faces.push(Face { primitive: Primitive::Other(*i), bounds: things[thing].bounds, thing: thing as u32 });
        }
        for (i, part) in self.triangle_part.iter().enumerate() {
            if let Some(thing) = numbers[*part as usize].filter(|thing| meeting[*thing as usize]) {
                let bounds = Bounds::of(self.mesh.corners(i)).expanded(things[thing as usize].reach);
                faces.push(Face { primitive: Primitive::Triangle(i as u32), bounds, thing });
            }
        }
        let near = |a: &Face, b: &Face| {
            let reach = f64::from(things[a.thing as usize].reach + things[b.thing as usize].reach);
            match (a.primitive, b.primitive) {
                (Primitive::Triangle(i), Primitive::Triangle(j)) => {
                    let [a, b] = [i, j].map(|i| self.mesh.corners(i as usize).map(|p| p.as_dvec3()));
                    !(on_one_side(&a, &b, reach) || on_one_side(&b, &a, reach))
                }
                _ => true,
            }
        };
        let found = Join::run(&faces, &near);
        let mut triangles = vec![false; self.triangle_part.len()];
        let mut shapes = vec![false; self.shapes.len()];
        for (face, found) in faces.iter().zip(found) {
            match face.primitive {
                Primitive::Triangle(i) => triangles[i as usize] = found,
                Primitive::Other(i) => shapes[i as usize] = found,
            }
        }
        Neighbours { triangles: triangles.into(), shapes: shapes.into(), anywhere: false }
    }

    /// Whether a material, or what it is mixed from, bounds a body.
    fn may_bound(&self, material: u32) -> bool {
        let mut found = false;
        self.scatterings(material, &mut |scattering| found |= matches!(scattering, Scattering::Boundary(_)));
        found
    }
}

/// Which things have boxes that meet another's.
fn meeting(things: &[Thing]) -> Vec<bool> {
    let face = |(thing, i): (&Thing, u32)| Face { primitive: Primitive::Other(i), bounds: thing.bounds, thing: i };
    Join::run(&things.iter().zip(0..).map(face).collect::<Vec<Face>>(), &|_, _| true)
}

/// Whether all of triangle `b` lies farther than `reach` from the plane of `a`, on one side.
fn on_one_side(a: &[DVec3; 3], b: &[DVec3; 3], reach: f64) -> bool {
    let normal = (a[1] - a[0]).cross(a[2] - a[0]);
    let reach = reach * normal.length();
    let heights = b.map(|p| normal.dot(p - a[0]));
    heights.iter().all(|h| *h > reach) || heights.iter().all(|h| *h < -reach)
}

/// A node of a tree of boxes: members are those of a range; `children` are two nodes, or none.
struct Node {
    bounds: Bounds,
    members: Range<usize>,
    children: Option<[usize; 2]>,
    /// The thing that all members belong to, if there is one.
    thing: Option<u32>,
}

/// Finds which faces come near one of another thing.
struct Join<'a> {
    faces: &'a [Face],
    near: &'a dyn Fn(&Face, &Face) -> bool,
    /// Faces by nodes.
    order: Vec<u32>,
    nodes: Vec<Node>,
    found: Vec<bool>,
    /// Pairs that may still be looked at.
    budget: usize,
}

impl<'a> Join<'a> {
    fn run(faces: &'a [Face], near: &'a dyn Fn(&Face, &Face) -> bool) -> Vec<bool> {
        let order = (0..faces.len() as u32).collect();
        if faces.is_empty() {
            return Vec::new();
        }
        let (nodes, found, budget) = (Vec::new(), vec![false; faces.len()], faces.len().saturating_mul(PAIRS));
        let mut join = Self { faces, near, order, nodes, found, budget };
        join.grow(0..faces.len());
        if join.within(0).is_none() {
            join.found.fill(true);
        }
        join.found
    }

    fn face(&self, member: usize) -> &'a Face {
        &self.faces[self.order[member] as usize]
    }

    fn grow(&mut self, members: Range<usize>) -> usize {
        let bounds = members.clone().fold(Bounds::EMPTY, |all, i| all.union(self.face(i).bounds));
        let thing = self.face(members.start).thing;
        let thing = members.clone().all(|i| self.face(i).thing == thing).then_some(thing);
        let index = self.nodes.len();
        self.nodes.push(Node { bounds, members: members.clone(), children: None, thing });
        if members.len() > LEAF {
            let axis = bounds.extent().max_position();
            let faces = self.faces;
            let middle = |i: &u32| faces[*i as usize].bounds.min[axis] + faces[*i as usize].bounds.max[axis];
            let half = members.len() / 2;
            self.order[members.clone()].select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            let cut = members.start + half;
            self.nodes[index].children = Some([self.grow(members.start..cut), self.grow(cut..members.end)]);
        }
        index
    }

    /// Holds the members of a node against each other; `None` where that takes too long.
    fn within(&mut self, node: usize) -> Option<()> {
        if self.nodes[node].thing.is_some() {
            return Some(());
        }
        match self.nodes[node].children {
            Some([a, b]) => {
                self.within(a)?;
                self.within(b)?;
                self.between(a, b)
            }
            None => self.compare(self.nodes[node].members.clone(), self.nodes[node].members.clone()),
        }
    }

    /// The same of the members of two nodes.
    fn between(&mut self, a: usize, b: usize) -> Option<()> {
        let (first, second) = (&self.nodes[a], &self.nodes[b]);
        if first.thing.is_some() && first.thing == second.thing || !first.bounds.meets(&second.bounds) {
            return Some(());
        }
        match (first.children, second.children) {
            (Some(children), None) => children.into_iter().try_for_each(|child| self.between(child, b)),
            (Some(children), _) if first.members.len() >= second.members.len() => {
                children.into_iter().try_for_each(|child| self.between(child, b))
            }
            (_, Some(children)) => children.into_iter().try_for_each(|child| self.between(a, child)),
            (None, None) => self.compare(first.members.clone(), second.members.clone()),
        }
    }

    fn compare(&mut self, first: Range<usize>, second: Range<usize>) -> Option<()> {
        self.budget = self.budget.checked_sub(first.len() * second.len())?;
        for i in first {
            for j in second.clone() {
                let (a, b) = (self.face(i), self.face(j));
                let [i, j] = [i, j].map(|member| self.order[member] as usize);
                if a.thing != b.thing
                    && !(self.found[i] && self.found[j])
                    && a.bounds.meets(&b.bounds)
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
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::color::Rgb;
    use crate::scene::{Body, Material, SceneBuilder};
    use crate::shape::{Plane, Sphere};
    use glam::{Vec2, Vec3};

    /// Of a cube of twelve triangles, and of a smaller one, how many may coincide with the other's.
    fn cubes(scale: f64, shift: DVec3) -> [usize; 2] {
        let mut builder = SceneBuilder::new();
        let corners: Vec<DVec3> = (0..8).map(|i| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(f64::from))).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |f: [u32; 4]| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]];
        let triangles: Vec<[u32; 3]> = faces.into_iter().flat_map(halves).collect();
        for (index, scale, shift) in [(1.3, 1.0, DVec3::ZERO), (1.5, scale, shift)] {
            let glass = builder.material(Material::body(Body::new(index)));
            let placed: Vec<DVec3> = corners.iter().map(|p| *p * scale + shift).collect();
            builder.mesh(&placed, &[], &triangles, glass, Rgb::ZERO);
        }
        let camera = Camera::perspective(DVec3::splat(9.0), DVec3::NEG_ONE, DVec3::Y, 1.0, 4, 4).unwrap();
        let scene = builder.build(camera).unwrap();
        let may = |i: &u32| scene.neighbours.may(HitKind::Triangle(*i, Vec2::ZERO));
        [(0..12).filter(may).count(), (12..24).filter(may).count()]
    }

    #[test]
    fn faces_that_others_may_lie_on_are_found_and_no_more() {
        let beside = |x: f64| cubes(0.5, DVec3::new(x, 0.25, 0.25));
        // The wall that is shared, and of the small cube the four that end at it.
        assert_eq!(beside(1.0), [2, 10]);
        assert_eq!(beside(1.0 + 1e-7), [2, 10], "within the error of places");
        assert_eq!(beside(0.75), [2, 8], "walls that cross");
        for x in [0.25, 0.999, 1.001, 2.0] {
            assert_eq!(beside(x), if x == 0.999 { [2, 8] } else { [0, 0] }, "{x}");
        }
    }

    #[test]
    fn a_join_finds_what_all_pairs_find() {
        let mut key = 1u32;
        let mut chance = || {
            key = key.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (key >> 8) as f32 / 16_777_216.0
        };
        for (count, size) in [(3, 0.5), (200, 0.1), (3000, 0.02)] {
            let faces: Vec<Face> = (0..count)
                .map(|i| {
                    let min = Vec3::new(chance(), chance(), chance());
                    let max = min + Vec3::new(chance(), chance(), chance()) * size;
                    Face { primitive: Primitive::Other(i), bounds: Bounds { min, max }, thing: i % 3 }
                })
                .collect();
            let one = |a: &Face| faces.iter().any(|b| a.thing != b.thing && a.bounds.meets(&b.bounds));
            let expected: Vec<bool> = faces.iter().map(one).collect();
            assert!(count < 100 || expected.contains(&true) && expected.contains(&false));
            assert_eq!(Join::run(&faces, &|_, _| true), expected, "{count}");
        }
    }

    #[test]
    fn where_too_many_meet_all_may() {
        let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let face = |i| Face { primitive: Primitive::Other(i), bounds, thing: i % 2 };
        let faces: Vec<Face> = (0..3000).map(face).collect();
        assert_eq!(Join::run(&faces, &|_, _| false), vec![true; 3000]);
        assert_eq!(Join::run(&faces[..100], &|_, _| false), vec![false; 100]);
    }

    #[test]
    fn what_has_no_end_may_be_anywhere() {
        let scene = |planes: u32, balls: u32| {
            let mut builder = SceneBuilder::new();
            let glass = builder.material(Material::body(Body::new(1.5)));
            for i in 0..balls {
                let center = DVec3::X * 10.0 * f64::from(i);
                builder.shape(Shape::Sphere(Sphere::new(center, 1.0)), glass, Rgb::ZERO);
            }
            for _ in 0..planes {
                builder.plane(Plane::new(DVec3::ZERO, DVec3::Y), glass, Rgb::ZERO);
            }
            let camera = Camera::perspective(DVec3::splat(9.0), DVec3::NEG_ONE, DVec3::Y, 1.0, 4, 4).unwrap();
            builder.build(camera).unwrap().neighbours.may(HitKind::Shape(0, Vec2::ZERO))
        };
        assert_eq!([scene(0, 2), scene(1, 1), scene(1, 0)], [false, true, false]);
    }
}
