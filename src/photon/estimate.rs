//! Radiance from photon density.

use super::record::TangentPlane;
use super::{Kernel, PhotonData, PhotonMap};
use crate::color::Rgb;
use glam::{DVec3, Vec3};

/// Which photons a density estimate takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// Largest radius \[length].
    pub radius: f32,
    /// Largest number of photons, 0 for no limit: where more lie within the radius, it shrinks to the k-th.
    pub k: u32,
}

/// An estimate and what it rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Radiance \[W/(m² sr)].
    pub radiance: Rgb,
    /// Radius of the disc \[length].
    pub radius: f32,
    /// Photons within it.
    pub count: u32,
}

/// Discs of an estimate and of the finer ones within it, each with half the area of the one before.
pub const LEVELS: usize = 3;

/// An estimate, and what the same photons tell at finer radii.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NestedEstimate {
    /// The estimate itself.
    pub whole: Estimate,
    /// Radiance at the radius, at 1/√2 and at ½ of it \[W/(m² sr)].
    pub radiance: [Rgb; LEVELS],
}

/// Buffers of nearest-neighbour searches, made once per tile.
#[derive(Debug, Default)]
pub struct Scratch {
    found: Vec<(f32, PhotonData)>,
    /// Radius that held k photons last time: where the next search begins.
    last: f32,
}

impl Scratch {
    /// Empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The next search begins with about `radius`, not with that of the last one.
    pub(super) fn begin_with(&mut self, radius: f32) {
        self.last = radius;
    }
}

/// A disc is no smaller than this part of the distance of its middle from the origin: places are rounded to a hundredth of that, in the
/// map and out of it.
const RESOLVED: f32 = 1e-5;

/// Nor smaller than this part of the largest radius: photons gathered at one point give a finite radiance.
const LEAST: f32 = 1.0 / 1_048_576.0;

/// Photons that are added in single precision before their sum goes into one of double.
const BLOCK: u32 = 64;

/// Least cosine between the normals of a photon's surface and of the estimate's.
pub(super) const SAME_SIDE: f32 = 0.5;

/// Greatest height of a photon over the tangent plane, in radii of the largest disc.
pub(super) const FLATNESS: f32 = 0.25;

impl PhotonMap {
    /// Radiance that leaves point `p` where `brdf` gives f \[1/sr] for what brought a photon.
    ///
    /// `normal` is the unit geometric normal on the viewer's side: a photon counts if it landed on that side of a surface
    /// of similar orientation, near the tangent plane. The sum is Σ f·ΔΦ·K over the kernel's disc (Jensen 2001, section 7.2).
    pub fn estimate(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> Estimate {
        self.gather::<1>(p, normal, bandwidth, kernel, scratch, brdf).0
    }

    /// The same with what its finer discs tell: the estimate is bit for bit that of [`PhotonMap::estimate`].
    ///
    /// Within the distance of the k-th neighbour the others lie as evenly as density is even, so a finer disc is without bias as the whole
    /// one is.
    pub fn estimate_nested(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> NestedEstimate {
        let (whole, radiance) = self.gather(p, normal, bandwidth, kernel, scratch, brdf);
        NestedEstimate { whole, radiance }
    }

    fn gather<const N: usize>(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> (Estimate, [Rgb; N]) {
        if self.is_empty() {
            return (Estimate { radius: bandwidth.radius, ..Estimate::default() }, [Rgb::ZERO; N]);
        }
        let plane = TangentPlane::new(p, normal);
        let resolved = p.length() * RESOLVED;
        let bandwidth = Bandwidth { radius: bandwidth.radius.max(resolved), ..bandwidth };
        let mut radius = bandwidth.radius;
        // What a narrower search would leave out as too high over the plane, its disc does not see.
        let height =
            |data: &PhotonData| if N > 1 { data.relation(&plane).1.abs() / (bandwidth.radius * FLATNESS) } else { 0.0 };
        if bandwidth.k > 0 {
            let least = resolved.max(radius * LEAST).max(self.least).min(radius);
            let r2 = match self.nearest(p, normal, bandwidth, scratch) {
                Some(r2) if r2 >= least * least => Some(r2),
                Some(_) => None,
                None => Some(radius * radius),
            };
            if let Some(r2) = r2 {
                let mut sums = Sums::<N>::new(kernel, r2);
                for (d2, data) in &scratch.found {
                    // A kernel that does not vanish at the k-th photon must leave it out: (k − 1)/(πr²) is unbiased.
                    if kernel.vanishes_at_edge() || *d2 < r2 || scratch.found.len() < bandwidth.k as usize {
                        sums.add(*d2, height(data), brdf(data) * data.flux());
                    }
                }
                let count = scratch.found.len() as u32;
                // All within the radius keep the radius itself, to the bit.
                let radius = if count < bandwidth.k { bandwidth.radius } else { r2.sqrt() };
                return sums.estimate(radius, count);
            }
            // They crowd into less than a disc may be.
            radius = least;
        }
        let mut sums = Sums::<N>::new(kernel, radius * radius);
        let mut count = 0;
        self.visit(p, radius, |data, d2| {
            if counts(data, &plane, bandwidth.radius) {
                count += 1;
                sums.add(d2, height(data), brdf(data) * data.flux());
            }
        });
        sums.estimate(radius, count)
    }

    /// Leaves the k nearest photons in `scratch` and returns the squared distance of the k-th; `None`, and all, where the largest radius
    /// holds fewer.
    ///
    /// kiddo cannot shrink a radius during a visit, so the search widens from a first guess: a wrong guess costs time, not truth.
    fn nearest(&self, p: Vec3, normal: Vec3, bandwidth: Bandwidth, scratch: &mut Scratch) -> Option<f32> {
        let k = bandwidth.k as usize;
        let guess = if scratch.last > 0.0 { scratch.last * 1.25 } else { bandwidth.radius * 0.25 };
        let mut radius = guess.min(bandwidth.radius);
        let plane = TangentPlane::new(p, normal);
        let found = &mut scratch.found;
        found.clear();
        // As many as are asked for, but no more than there are.
        found.reserve((2 * k).min(self.len()));
        loop {
            found.clear();
            let mut cutoff = f32::INFINITY;
            self.visit(p, radius, |data, d2| {
                if d2 < cutoff && counts(data, &plane, bandwidth.radius) {
                    found.push((d2, *data));
                    if found.len() == 2 * k {
                        cutoff = keep_nearest(found, k);
                    }
                }
            });
            if found.len() >= k {
                let r2 = keep_nearest(found, k);
                scratch.last = r2.sqrt();
                return Some(r2);
            }
            if radius >= bandwidth.radius {
                scratch.last = radius;
                return None;
            }
            let missing = (1.5 * k as f32 / found.len().max(1) as f32).sqrt();
            radius = (radius * missing.clamp(1.2, 3.0)).min(bandwidth.radius);
        }
    }
}

impl PhotonMap {
    /// Distance from `p` to its k-th photon that an estimate there would count, searched up to about `most`; `None` where there
    /// are fewer.
    #[must_use]
    pub fn kth_distance(&self, p: Vec3, normal: Vec3, k: u32, most: f32) -> Option<f32> {
        let mut scratch = Scratch { last: most * 1e-3, ..Scratch::default() };
        self.nearest(p, normal, Bandwidth { radius: most, k }, &mut scratch).map(f32::sqrt)
    }
}

/// Sums over the photons of nested discs.
struct Sums<const N: usize> {
    kernel: Kernel,
    r2: f32,
    inverse: f32,
    sums: [Rgb; N],
    /// Photons in them.
    pending: u32,
    /// Those before.
    whole: [DVec3; N],
}

impl<const N: usize> Sums<N> {
    fn new(kernel: Kernel, r2: f32) -> Self {
        Self { kernel, r2, inverse: 1.0 / r2, sums: [Rgb::ZERO; N], pending: 0, whole: [DVec3::ZERO; N] }
    }

    /// `height` over the tangent plane is in parts of what counts.
    #[inline]
    fn add(&mut self, d2: f32, height: f32, reflected: Rgb) {
        let x = d2 * self.inverse;
        self.sums[0] += reflected * self.kernel.shape(x);
        let finer = [(2.0 * x, std::f32::consts::FRAC_1_SQRT_2), (4.0 * x, 0.5)];
        for (sum, (x, highest)) in self.sums[1..].iter_mut().zip(finer) {
            if height <= highest {
                *sum += reflected * self.kernel.shape_within(x);
            }
        }
        self.pending += 1;
        if self.pending == BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.whole.iter_mut().zip(&mut self.sums).for_each(|(whole, sum)| *whole += std::mem::take(sum).as_dvec3());
        self.pending = 0;
    }

    fn estimate(mut self, radius: f32, count: u32) -> (Estimate, [Rgb; N]) {
        self.flush();
        let mut r2 = self.r2;
        let radiance = self.whole.map(|sum| {
            let scaled = sum.as_vec3() * self.kernel.scale(r2);
            r2 *= 0.5;
            scaled
        });
        (Estimate { radiance: radiance[0], radius, count }, radiance)
    }
}

/// Whether a photon lies on the surface that is looked at.
#[inline]
pub(super) fn counts(data: &PhotonData, plane: &TangentPlane, radius: f32) -> bool {
    let (cosine, height) = data.relation(plane);
    cosine > SAME_SIDE && height.abs() <= radius * FLATNESS
}

/// Moves the k nearest to the front, drops the rest, and returns the k-th squared distance.
fn keep_nearest(found: &mut Vec<(f32, PhotonData)>, k: usize) -> f32 {
    let (_, kth, _) = found.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0));
    let r2 = kth.0;
    found.truncate(k);
    r2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::Photon;

    /// Photons at 1, 2, 3 … 9 along a line, and one at the edge of the world: what is near stays near, however wide the search.
    #[test]
    fn the_kth_is_as_far_in_a_huge_scene() {
        let photon = |x: f32| Photon::new(Vec3::X * x, Rgb::ONE, Vec3::Z, Vec3::Z).unwrap();
        let map = PhotonMap::build((1..10).map(|i| photon(i as f32)).chain([photon(1e6)]).collect());
        for most in [20.0, 1e3, 1e5, 1e6] {
            let found = map.kth_distance(Vec3::ZERO, Vec3::Z, 4, most).unwrap();
            assert!((found - 4.0).abs() < 1e-5, "{found} of {most}");
        }
        assert_eq!(map.kth_distance(Vec3::ZERO, Vec3::Z, 10, 1e3), None);
        // No room is taken for what is not there.
        assert_eq!(map.kth_distance(Vec3::ZERO, Vec3::Z, 4_000_000_000, 1e3), None);
    }
}
