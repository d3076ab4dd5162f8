//! The bounding volume hierarchy: where a ray first meets the scene.
//!
//! A binary tree is grown by the surface area heuristic, then collapsed into nodes of eight boxes whose leaves are packets of
//! triangles, both laid out for vector units. The hit of a triangle is a pure function of the ray and its corners, and the
//! boxes never lose one, so no answer depends on the shape of the tree.

mod along;
mod build;
mod bvh8;
mod packet;
mod ray_precalc;
#[cfg(test)]
mod tests;

pub use along::Boxes;

use crate::math::{Bounds, Ray};
use bvh8::{Bvh8, OTHER};
use glam::Vec3;
use packet::Crossing;
use ray_precalc::RayPrecalc;

/// A primitive, by its index in the slice given to [`Hierarchy::build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Primitive {
    /// A triangle.
    Triangle(u32),
    /// Anything else, known by its box.
    Other(u32),
}

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction, `0 < t < t_max`.
    pub t: f32,
    /// What was hit.
    pub primitive: Primitive,
    /// Of a triangle the weight of its second corner; of another primitive as its closure says.
    pub u: f32,
    /// Of a triangle the weight of its third corner; of another primitive as its closure says.
    pub v: f32,
}

/// A tree of boxes over triangles and over other primitives known by their boxes.
///
/// Triangles are watertight: a ray through a closed mesh hits it, at edges and corners too, whatever the scale of the mesh
/// and its distance from the origin (Woop, Benthin and Wald 2013, with boxes padded to match). Coordinates must be finite and
/// below 10¹⁸ in magnitude. Memory is about 72 bytes a
/// triangle of a mesh, and 180 more while building.
pub struct Hierarchy {
    wide: Bvh8,
    bounds: Bounds,
}

impl Hierarchy {
    /// Builds over `triangles`, given by their corners, and `others`, boxes around what the closures of
    /// [`closest`](Self::closest) and [`occluded`](Self::occluded) intersect.
    ///
    /// At most 2³⁰ of either. Corners must be finite. A hit of another primitive must lie in its box, to 10⁻⁶ of the box's size. A triangle without area and an empty box are never hit.
    #[must_use]
    pub fn build(triangles: &[[Vec3; 3]], others: &[Bounds]) -> Self {
        let bounds = Bounds::of(triangles.iter().flatten().copied());
        let bounds = others.iter().filter(|b| !b.is_empty()).fold(bounds, |all, b| all.union(*b));
        Self { wide: Bvh8::build(triangles, others), bounds }
    }

    /// The box around all primitives, empty where there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The nearest hit with `0 < t < t_max`; among equal `t` the lower primitive, triangles before others.
    ///
    /// `other` intersects the other primitive of the given index: `t`, and two coordinates passed through to the hit. Its
    /// ray is this one with `t_max` shrunk to what can still be nearer; what it returns beyond that is ignored.
    #[inline]
    pub fn closest<F>(&self, ray: &Ray, mut other: F) -> Option<Hit>
    where
        F: FnMut(u32, &Ray) -> Option<(f32, f32, f32)>,
    {
        if !RayPrecalc::fits(ray) {
            return None;
        }
        let probe = RayPrecalc::new(ray);
        let mut best = Best { key: 0, crossing: Crossing { t: probe.t_max, weights: [0.0; 2], total: 1.0 } };
        self.wide.walk::<true, _>(&probe, |leaf, _| {
            if leaf & OTHER == 0 {
                self.wide.packet(leaf).hits(&probe, |triangle, crossing| best.offer(triangle, crossing));
            } else {
                // The bound of a ray is exclusive: an equal `t` must pass where this primitive would win the tie.
                let t_max = if leaf < best.key { best.crossing.t.next_up() } else { best.crossing.t };
                let shrunk = Ray { t_max: t_max * probe.unit, ..*ray };
                if let Some((t, u, v)) = other(leaf ^ OTHER, &shrunk) {
                    let weights = [u, v].map(f64::from);
                    best.offer(leaf, Crossing { t: t * probe.per_unit, weights, total: 1.0 });
                }
            }
            best.crossing.t
        });
        best.finish(ray, &probe)
    }

    /// Shows `visit` every hit with `0 < t < t_max`, in an order that depends on the tree.
    ///
    /// `other` is as for [`closest`](Self::closest), but gets the ray as it is.
    pub fn each<F>(&self, ray: &Ray, mut other: F, mut visit: impl FnMut(Hit))
    where
        F: FnMut(u32, &Ray) -> Option<(f32, f32, f32)>,
    {
        if !RayPrecalc::fits(ray) {
            return;
        }
        let probe = RayPrecalc::new(ray);
        let mut show = |key: u32, crossing: Crossing| {
            let mut only = Best { key: 0, crossing: Crossing { t: probe.t_max, weights: [0.0; 2], total: 1.0 } };
            only.offer(key, crossing);
            if let Some(hit) = only.finish(ray, &probe) {
                visit(hit);
            }
        };
        self.wide.walk::<false, _>(&probe, |leaf, limit| {
            if leaf & OTHER == 0 {
                self.wide.packet(leaf).hits(&probe, &mut show);
            } else if let Some((t, u, v)) = other(leaf ^ OTHER, ray) {
                show(leaf, Crossing { t: t * probe.per_unit, weights: [u, v].map(f64::from), total: 1.0 });
            }
            limit
        });
    }

    /// Whether anything lies at `0 < t < t_max`.
    ///
    /// `other` tells whether the other primitive of the given index meets the ray.
    #[inline]
    pub fn occluded<F>(&self, ray: &Ray, mut other: F) -> bool
    where
        F: FnMut(u32, &Ray) -> bool,
    {
        if !RayPrecalc::fits(ray) {
            return false;
        }
        let probe = RayPrecalc::new(ray);
        let mut found = false;
        self.wide.walk::<false, _>(&probe, |leaf, limit| {
            found = if leaf & OTHER == 0 { self.wide.packet(leaf).any(&probe) } else { other(leaf ^ OTHER, ray) };
            if found { f32::NEG_INFINITY } else { limit }
        });
        found
    }
}

/// The best hit so far, in the probe's units; its key orders equal `t`, and zero, which none can undercut, keeps `t_max`
/// itself out.
struct Best {
    key: u32,
    crossing: Crossing,
}

impl Best {
    #[inline]
    fn offer(&mut self, key: u32, crossing: Crossing) {
        let (t, least) = (crossing.t, self.crossing.t);
        if t > 0.0 && (t < least || t == least && key < self.key) {
            *self = Self { key, crossing };
        }
    }

    #[inline]
    fn finish(&self, ray: &Ray, probe: &RayPrecalc) -> Option<Hit> {
        let t = self.crossing.t * probe.unit;
        // A distance that the caller's unit cannot express is no hit.
        if !(self.crossing.t < probe.t_max && 0.0 < t && t < ray.t_max) {
            return None;
        }
        let index = self.key & !OTHER;
        let primitive = if self.key == index { Primitive::Triangle(index) } else { Primitive::Other(index) };
        let (u, v) = self.crossing.barycentric();
        Some(Hit { t, primitive, u, v })
    }
}
