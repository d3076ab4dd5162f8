//! Light sampling with a bounding volume hierarchy over the lights.

use super::Light;
use super::light_bounds::{CompactLightBounds, LightBounds};
use crate::color;
use crate::math::{BoundingSphere, Bounds};
use glam::Vec3;

/// Samples one of many lights for a given point, with a probability that depends on flux, distance
/// and orientation.
///
/// A binary tree holds all lights that have a position. Sampling descends the tree, and chooses
/// each child with a probability proportional to its importance (Conty Estevez and Kulla 2018;
/// Pharr, Jakob, Humphreys 2023, section 12.6.3). Lights at infinity are outside of the tree, and
/// are sampled with a fixed probability.
#[derive(Clone, Debug)]
pub struct LightBvhSampler {
    /// Nodes in depth-first order: the first child comes directly after its parent.
    nodes: Vec<LightBvhNode>,
    /// Indices of the lights at infinity, which are outside of the tree. All are sampled with equal
    /// probability.
    infinite_light_indices: Vec<u32>,
    /// Place of each light: in the tree, at infinity or absent. Element i is the place of the light
    /// with index i.
    locations: Vec<LightBvhLocation>,
    /// Probability of sampling one of the lights at infinity instead of a light of the tree.
    infinite_probability: f64,
}

/// Node of the light BVH. Holds the bounds of all lights in its subtree, and either the index of
/// its second child or its only light.
#[derive(Clone, Debug)]
struct LightBvhNode {
    bounds: CompactLightBounds,
    kind: LightBvhNodeKind,
}

#[derive(Clone, Copy, Debug)]
enum LightBvhNodeKind {
    /// An inner node; the number is the index of its second child.
    Inner(u32),
    /// A leaf with one light; the number is the index of this light.
    Leaf(u32),
}

/// A light at a finite distance: its index, and the bounds of its positions and directions.
type BoundedLight = (u32, LightBounds);

/// Place of a light in a [`LightBvhSampler`]: in its tree, at infinity or absent.
#[derive(Clone, Copy, Debug, PartialEq)]
enum LightBvhLocation {
    /// The sampler does not contain the light, because it has no power.
    Absent,
    /// The light is at infinity, so it is outside of the tree.
    Infinite,
    /// The light is in the tree. The bits of the number, lowest first, are the path from the root
    /// to the light's leaf: 0 for the first child of a node, 1 for the second.
    Tree(u64),
}

/// Depth in the light BVH from which each node is split into two children with equal numbers of
/// lights. Each such split halves the number of lights. So the depth stays below 64, the number of
/// bits in the path to a leaf, even for 2³² lights.
const HALVING_DEPTH: u32 = 31;

/// Number of buckets along each axis into which the centers of lights are sorted. The boundaries
/// between buckets are the candidates for the split plane of a light BVH node.
const SPLIT_BUCKETS: usize = 12;

/// Largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl LightBvhSampler {
    /// Creates a sampler of all `lights` of nonzero power; `None` if there is none.
    ///
    /// `domain` is the bounding sphere of the scene.
    #[must_use]
    pub fn new(lights: &[Light], domain: BoundingSphere) -> Option<Self> {
        let mut locations = vec![LightBvhLocation::Absent; lights.len()];
        let (mut infinite, mut bounded) = (Vec::new(), Vec::new());
        // The margin allows for the rounding of positions: because of rounding, a light in the
        // plane of a surface may count as above the surface.
        let margin = 1e-6 * (domain.center.abs().max_element() + domain.radius);
        for (i, light) in lights.iter().enumerate().filter(|(_, l)| color::channel_mean(l.power(domain)) > 0.0) {
            match light.bounds(margin) {
                Some(bounds) => bounded.push((i as u32, bounds)),
                None => {
                    locations[i] = LightBvhLocation::Infinite;
                    infinite.push(i as u32);
                }
            }
        }
        let others = usize::from(!bounded.is_empty());
        if infinite.len() + others == 0 {
            return None;
        }
        let infinite_probability = infinite.len() as f64 / (infinite.len() + others) as f64;
        let mut sampler = Self {
            nodes: Vec::with_capacity(2 * bounded.len()),
            infinite_light_indices: infinite,
            locations,
            infinite_probability,
        };
        if !bounded.is_empty() {
            sampler.build_subtree(&mut bounded, 0, 0);
        }
        Some(sampler)
    }

    /// Appends a subtree with `lights` to `nodes`. There must be at least one light. The root of
    /// the subtree has the given `depth` in the tree.
    ///
    /// The bits of `trail`, lowest first, are the path from the root of the tree to the subtree: 0
    /// for a first child, 1 for a second.
    fn build_subtree(&mut self, lights: &mut [BoundedLight], depth: u32, trail: u64) {
        let whole = lights[1..].iter().fold(lights[0].1, |all, l| all.union(l.1));
        let index = self.nodes.len();
        let [(light, _)] = *lights else {
            let (first, second) = split_lights_by_cost(lights, depth);
            self.nodes.push(LightBvhNode { bounds: whole.into(), kind: LightBvhNodeKind::Inner(0) });
            self.build_subtree(first, depth + 1, trail);
            self.nodes[index].kind = LightBvhNodeKind::Inner(self.nodes.len() as u32);
            self.build_subtree(second, depth + 1, trail | 1 << depth);
            return;
        };
        self.locations[light as usize] = LightBvhLocation::Tree(trail);
        self.nodes.push(LightBvhNode { bounds: whole.into(), kind: LightBvhNodeKind::Leaf(light) });
    }

    /// Samples a light for the point `p` by `u` in \[0, 1). Returns the index of the light, its
    /// probability, and `u` rescaled to \[0, 1), so that the caller can use it as the next random
    /// number.
    ///
    /// If the unit normal `n` of a surface at `p` is given, lights of the tree that cannot
    /// illuminate the side to which `n` points are not sampled. Returns `None` if the descent
    /// reaches a node whose lights cannot illuminate `p`, or if the probability rounds to 0.
    #[inline]
    #[must_use]
    pub fn sample(&self, p: Vec3, n: Option<Vec3>, u: f32) -> Option<(usize, f32, f32)> {
        let mut u = f64::from(u);
        let (light, probability) = if u < self.infinite_probability {
            let at = u / self.infinite_probability * self.infinite_light_indices.len() as f64;
            let i = (at as usize).min(self.infinite_light_indices.len() - 1);
            u = at - i as f64;
            (self.infinite_light_indices[i], self.infinite_probability / self.infinite_light_indices.len() as f64)
        } else {
            u = (u - self.infinite_probability) / (1.0 - self.infinite_probability);
            let mut probability = 1.0 - self.infinite_probability;
            let mut index = 0;
            loop {
                let second = match self.nodes[index].kind {
                    LightBvhNodeKind::Leaf(light) => break (light, probability),
                    LightBvhNodeKind::Inner(second) => second as usize,
                };
                let children = self.child_probabilities(index, second, p, n)?;
                if u < children[0] {
                    u /= children[0];
                    probability *= children[0];
                    index += 1;
                } else {
                    u = ((u - children[0]) / children[1]).min(1.0 - f64::EPSILON);
                    probability *= children[1];
                    index = second;
                }
            }
        };
        let probability = probability as f32;
        (probability > 0.0).then_some((light as usize, probability, (u as f32).min(BELOW_ONE)))
    }

    /// Probability with which [`LightBvhSampler::sample`] at `p` with normal `n` samples the light
    /// with index `light`.
    ///
    /// The value has the same bits as the probability that `sample` returns.
    #[inline]
    #[must_use]
    pub fn probability(&self, p: Vec3, n: Option<Vec3>, light: usize) -> f32 {
        let mut trail = match self.locations[light] {
            LightBvhLocation::Absent => return 0.0,
            LightBvhLocation::Infinite => {
                return (self.infinite_probability / self.infinite_light_indices.len() as f64) as f32;
            }
            LightBvhLocation::Tree(trail) => trail,
        };
        let mut probability = 1.0 - self.infinite_probability;
        let mut index = 0;
        while let LightBvhNodeKind::Inner(second) = self.nodes[index].kind {
            let Some(children) = self.child_probabilities(index, second as usize, p, n) else {
                return 0.0;
            };
            let child = (trail & 1) as usize;
            probability *= children[child];
            index = if child == 0 { index + 1 } else { second as usize };
            trail >>= 1;
        }
        probability as f32
    }

    /// Probabilities of the first and the second child of the inner node `parent`, for the point
    /// `p` with normal `n`; `None` if neither child can illuminate `p`.
    ///
    /// The first child follows directly after `parent` in the list of nodes. The second child has
    /// the index `second`.
    #[inline]
    fn child_probabilities(&self, parent: usize, second: usize, p: Vec3, n: Option<Vec3>) -> Option<[f64; 2]> {
        let [a, b] = [parent + 1, second].map(|i| self.nodes[i].bounds.importance_at(p, n));
        let total = a + b;
        // Both quotients are computed, because 1 − a/total would round a small probability to zero.
        (total > 0.0).then(|| [a / total, b / total])
    }
}

/// Splits two or more lights into two non-empty groups, for the children of a light BVH node.
///
/// Candidates are the bucket boundaries along all three axes. The one of least cost is chosen: the
/// sum of [`LightBounds::bvh_node_cost`] over both groups, times e/a. Here, a is the extent along
/// the split axis of the box around all light centers, and e is the largest extent of this box.
/// From depth [`HALVING_DEPTH`] on, or if no bucket boundary separates the lights, the split is at
/// the median along the axis of largest extent.
fn split_lights_by_cost(lights: &mut [BoundedLight], depth: u32) -> (&mut [BoundedLight], &mut [BoundedLight]) {
    let center = |l: &BoundedLight| l.1.space.center();
    let centers = Bounds::from_points(lights.iter().map(center));
    let extent = centers.extent();
    let bucket = |l: &BoundedLight, axis: usize| {
        let x = (center(l)[axis] - centers.min[axis]) / extent[axis];
        ((x * SPLIT_BUCKETS as f32) as usize).min(SPLIT_BUCKETS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in (0..3).filter(|axis| extent[*axis] > 0.0 && depth < HALVING_DEPTH) {
        let mut buckets: [Option<LightBounds>; SPLIT_BUCKETS] = [None; SPLIT_BUCKETS];
        let add = |to: &mut Option<LightBounds>, b: LightBounds| *to = Some(to.map_or(b, |a| a.union(b)));
        for light in lights.iter() {
            add(&mut buckets[bucket(light, axis)], light.1);
        }
        let slimness = f64::from(extent.max_element() / extent[axis]);
        for plane in 1..SPLIT_BUCKETS {
            let side = |part: &[Option<LightBounds>]| part.iter().flatten().copied().reduce(LightBounds::union);
            if let (Some(a), Some(b)) = (side(&buckets[..plane]), side(&buckets[plane..])) {
                let split_cost = slimness * (a.bvh_node_cost() + b.bvh_node_cost());
                if split_cost < best.0 {
                    best = (split_cost, axis, plane);
                }
            }
        }
    }
    let (split_cost, axis, plane) = best;
    let at = if split_cost.is_finite() {
        lights.sort_by_key(|l| bucket(l, axis) >= plane);
        lights.partition_point(|l| bucket(l, axis) < plane)
    } else {
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        lights.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]));
        lights.len() / 2
    };
    lights.split_at_mut(at)
}
