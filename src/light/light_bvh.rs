//! Choosing one of many lights by what it may mean to a point.

use super::Light;
use super::bounds::{Importance, LightBounds};
use crate::color;
use crate::math::{Bounds, Sphere};
use glam::Vec3;

/// Chooses a light by power, distance and orientation: a binary tree over the lights that have a place, descended by the
/// importance of its branches (Conty Estevez and Kulla 2018; Pharr, Jakob, Humphreys 2023, section 12.6.3). Lights at infinity,
/// which a tree cannot hold, share a fixed part of the choice.
#[derive(Clone, Debug)]
pub struct LightBvhSampler {
    /// Depth first: the first child of a branch follows it.
    nodes: Vec<Node>,
    infinite: Vec<u32>,
    places: Vec<Place>,
    /// Part of the choice that goes to the lights at infinity.
    infinite_share: f64,
}

#[derive(Clone, Debug)]
struct Node {
    importance: Importance,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The index of the second child.
    Branch(u32),
    Leaf(u32),
}

/// A light with its bounds.
type Placed = (u32, LightBounds);

/// Where a light is in the choice.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// It has no power.
    Nowhere,
    Infinity,
    /// The turns from the root, the lowest bit first: 1 is the second child.
    Tree(u64),
}

/// Depth from which branches are halved, so that with 2³² lights no path is longer than the bits of its turns.
const HALVED_FROM: u32 = 31;

/// Planes tried along each axis, plus one.
const BUCKETS: usize = 12;

/// The largest number below 1 of f32, which is what is asked with next.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl LightBvhSampler {
    /// A choice among `lights`; `domain` is the ball around the scene's bounded shapes. `None` where no light has power.
    #[must_use]
    pub fn new(lights: &[Light], domain: Sphere) -> Option<Self> {
        let mut places = vec![Place::Nowhere; lights.len()];
        let (mut infinite, mut placed) = (Vec::new(), Vec::new());
        // Points and lights are rounded to f32; what looks level with a surface may be just above it.
        let margin = 1e-6 * (domain.center.abs().max_element() + domain.radius);
        for (i, light) in lights.iter().enumerate().filter(|(_, l)| color::mean(l.power(domain)) > 0.0) {
            match LightBounds::of(light, margin) {
                Some(bounds) => placed.push((i as u32, bounds)),
                None => {
                    places[i] = Place::Infinity;
                    infinite.push(i as u32);
                }
            }
        }
        let others = usize::from(!placed.is_empty());
        if infinite.len() + others == 0 {
            return None;
        }
        let infinite_share = infinite.len() as f64 / (infinite.len() + others) as f64;
        let mut choice = Self { nodes: Vec::with_capacity(2 * placed.len()), infinite, places, infinite_share };
        if !placed.is_empty() {
            choice.grow(&mut placed, 0, 0);
        }
        Some(choice)
    }

    /// Adds the tree of one light or more, whose root is reached from the whole tree's by `turns`.
    fn grow(&mut self, lights: &mut [Placed], depth: u32, turns: u64) {
        let whole = lights[1..].iter().fold(lights[0].1, |all, l| all.union(l.1));
        let index = self.nodes.len();
        let [(light, _)] = *lights else {
            let (first, second) = split(lights, depth);
            self.nodes.push(Node { importance: whole.into(), kind: Kind::Branch(0) });
            self.grow(first, depth + 1, turns);
            self.nodes[index].kind = Kind::Branch(self.nodes.len() as u32);
            self.grow(second, depth + 1, turns | 1 << depth);
            return;
        };
        self.places[light as usize] = Place::Tree(turns);
        self.nodes.push(Node { importance: whole.into(), kind: Kind::Leaf(light) });
    }

    /// A light for `u` in \[0, 1), its probability above zero, and a number in \[0, 1) that is uniform given the light.
    ///
    /// `n` is a unit normal where only what arrives on its side counts. `None` where no light can reach `p`, or where `u` ends in
    /// a group of which none can.
    #[inline]
    #[must_use]
    pub fn choose(&self, p: Vec3, n: Option<Vec3>, u: f32) -> Option<(usize, f32, f32)> {
        let mut u = f64::from(u);
        let (light, probability) = if u < self.infinite_share {
            let at = u / self.infinite_share * self.infinite.len() as f64;
            let i = (at as usize).min(self.infinite.len() - 1);
            u = at - i as f64;
            (self.infinite[i], self.infinite_share / self.infinite.len() as f64)
        } else {
            u = (u - self.infinite_share) / (1.0 - self.infinite_share);
            let mut probability = 1.0 - self.infinite_share;
            let mut index = 0;
            loop {
                let second = match self.nodes[index].kind {
                    Kind::Leaf(light) => break (light, probability),
                    Kind::Branch(second) => second as usize,
                };
                let shares = self.shares(index, second, p, n)?;
                if u < shares[0] {
                    u /= shares[0];
                    probability *= shares[0];
                    index += 1;
                } else {
                    u = ((u - shares[0]) / shares[1]).min(1.0 - f64::EPSILON);
                    probability *= shares[1];
                    index = second;
                }
            }
        };
        let probability = probability as f32;
        (probability > 0.0).then_some((light as usize, probability, (u as f32).min(BELOW_ONE)))
    }

    /// The probability with which [`LightBvhSampler::choose`] chooses a light, the same number to the bit.
    #[inline]
    #[must_use]
    pub fn probability(&self, p: Vec3, n: Option<Vec3>, light: usize) -> f32 {
        let mut turns = match self.places[light] {
            Place::Nowhere => return 0.0,
            Place::Infinity => return (self.infinite_share / self.infinite.len() as f64) as f32,
            Place::Tree(turns) => turns,
        };
        let mut probability = 1.0 - self.infinite_share;
        let mut index = 0;
        while let Kind::Branch(second) = self.nodes[index].kind {
            let Some(shares) = self.shares(index, second as usize, p, n) else {
                return 0.0;
            };
            let turn = (turns & 1) as usize;
            probability *= shares[turn];
            index = if turn == 0 { index + 1 } else { second as usize };
            turns >>= 1;
        }
        probability as f32
    }

    /// How the choice at a branch falls to its children; `None` where neither can reach `p`.
    #[inline]
    fn shares(&self, branch: usize, second: usize, p: Vec3, n: Option<Vec3>) -> Option<[f64; 2]> {
        let [a, b] = [branch + 1, second].map(|i| self.nodes[i].importance.at(p, n));
        let total = a + b;
        // Each by its own quotient: one less the other would make nothing of what is much less.
        (total > 0.0).then(|| [a / total, b / total])
    }
}

/// Two parts, neither empty, of two lights or more: between buckets along an axis where it costs least, else in halves.
fn split(lights: &mut [Placed], depth: u32) -> (&mut [Placed], &mut [Placed]) {
    let middle = |l: &Placed| l.1.space.center();
    let centers = Bounds::of(lights.iter().map(middle));
    let extent = centers.extent();
    let bucket = |l: &Placed, axis: usize| {
        let x = (middle(l)[axis] - centers.min[axis]) / extent[axis];
        ((x * BUCKETS as f32) as usize).min(BUCKETS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in (0..3).filter(|axis| extent[*axis] > 0.0 && depth < HALVED_FROM) {
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        let add = |to: &mut Option<LightBounds>, b: LightBounds| *to = Some(to.map_or(b, |a| a.union(b)));
        for light in lights.iter() {
            add(&mut buckets[bucket(light, axis)], light.1);
        }
        let slimness = f64::from(extent.max_element() / extent[axis]);
        for plane in 1..BUCKETS {
            let side = |part: &[Option<LightBounds>]| part.iter().flatten().copied().reduce(LightBounds::union);
            if let (Some(a), Some(b)) = (side(&buckets[..plane]), side(&buckets[plane..])) {
                let cost = slimness * (a.cost() + b.cost());
                if cost < best.0 {
                    best = (cost, axis, plane);
                }
            }
        }
    }
    let (cost, axis, plane) = best;
    let at = if cost.is_finite() {
        lights.sort_by_key(|l| bucket(l, axis) >= plane);
        lights.partition_point(|l| bucket(l, axis) < plane)
    } else {
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        lights.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        lights.len() / 2
    };
    lights.split_at_mut(at)
}
