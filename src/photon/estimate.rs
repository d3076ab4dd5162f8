//! Radiance estimates from photon density.

use super::record::TangentPlane;
use super::{Kernel, PhotonData, PhotonMap};
use crate::color::Rgb;
use glam::{DVec3, Vec3};

/// Bandwidth of a density estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// Largest radius \[length].
    pub radius: f32,
    /// Largest number of photons; 0 for no limit. The radius shrinks to the k-th nearest photon.
    pub k: u32,
}

/// A radiance estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadianceEstimate {
    /// Radiance \[W/(m² sr)].
    pub radiance: Rgb,
    /// Radius of the disc \[length].
    pub radius: f32,
    /// Number of photons in the disc.
    pub count: u32,
}

/// Number of nested discs; each has half the area of the one before.
pub const LEVELS: usize = 3;

/// An estimate with its values at smaller radii, from the same photons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NestedRadianceEstimate {
    /// Estimate at the full radius.
    pub whole: RadianceEstimate,
    /// Radiance at 1, 1/√2 and ½ of the radius \[W/(m² sr)].
    pub radiance: [Rgb; LEVELS],
}

/// Buffers of nearest-neighbour searches, made once per tile.
#[derive(Debug, Default)]
pub struct Scratch {
    found: Vec<(f32, PhotonData)>,
    /// Radius of the last k-th neighbour, where the next search begins.
    last: f32,
}

impl Scratch {
    /// Empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the first radius of the next search.
    pub(super) fn set_first_search_radius(&mut self, radius: f32) {
        self.last = radius;
    }
}

/// Least radius relative to the distance from the origin: 100 times the rounding error of
/// positions.
const MIN_RELATIVE_RADIUS: f32 = 1e-5;

/// Least radius relative to the largest radius: photons at one point give a finite radiance.
const MIN_RADIUS_FRACTION: f32 = 1.0 / 1_048_576.0;

/// Number of photons summed in f32 before the sum is added in f64.
const BLOCK: u32 = 64;

/// Least cosine between the normals of photon and estimate.
pub(super) const SAME_SIDE: f32 = 0.5;

/// Largest height of a photon over the tangent plane, in radii of the largest disc.
pub(super) const FLATNESS: f32 = 0.25;

impl PhotonMap {
    /// Reflected radiance at `p` by density estimation; `brdf` returns the BRDF \[1/sr] for a
    /// photon.
    ///
    /// `normal` is the unit geometric normal on the viewer's side. A photon counts if it landed on
    /// that side of a surface with a similar normal, near the tangent plane. The estimate is Σ
    /// f·ΔΦ·K over the kernel's disc (Jensen 2001, section 7.2).
    pub fn estimate(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> RadianceEstimate {
        self.estimate_discs::<1>(p, normal, bandwidth, kernel, scratch, brdf).0
    }

    /// An estimate with nested smaller discs; equal to [`PhotonMap::estimate`] to the bit.
    ///
    /// Within the distance of the k-th neighbour, the other photons are distributed by their
    /// density. Smaller discs are therefore as unbiased as the full one.
    pub fn estimate_nested(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> NestedRadianceEstimate {
        let (whole, radiance) = self.estimate_discs(p, normal, bandwidth, kernel, scratch, brdf);
        NestedRadianceEstimate { whole, radiance }
    }

    fn estimate_discs<const N: usize>(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut Scratch,
        brdf: impl Fn(&PhotonData) -> Rgb,
    ) -> (RadianceEstimate, [Rgb; N]) {
        if self.is_empty() {
            return (RadianceEstimate { radius: bandwidth.radius, ..RadianceEstimate::default() }, [Rgb::ZERO; N]);
        }
        let plane = TangentPlane::new(p, normal);
        let resolved = p.length() * MIN_RELATIVE_RADIUS;
        let bandwidth = Bandwidth { radius: bandwidth.radius.max(resolved), ..bandwidth };
        let mut radius = bandwidth.radius;
        // A search with a smaller radius would reject photons that are high over the plane.
        let height = |data: &PhotonData| {
            if N > 1 { data.normal_cosine_and_height(&plane).1.abs() / (bandwidth.radius * FLATNESS) } else { 0.0 }
        };
        if bandwidth.k > 0 {
            let least = resolved.max(radius * MIN_RADIUS_FRACTION).max(self.min_radius).min(radius);
            let r2 = match self.nearest(p, normal, bandwidth, scratch) {
                Some(r2) if r2 >= least * least => Some(r2),
                Some(_) => None,
                None => Some(radius * radius),
            };
            if let Some(r2) = r2 {
                let mut sums = Sums::<N>::new(kernel, r2);
                for (d2, data) in &scratch.found {
                    // The k-th photon defines the disc: (k − 1)/(πr²) is unbiased unless the kernel
                    // vanishes there.
                    if kernel.vanishes_at_edge() || *d2 < r2 || scratch.found.len() < bandwidth.k as usize {
                        sums.add(*d2, height(data), brdf(data) * data.flux());
                    }
                }
                let count = scratch.found.len() as u32;
                // With fewer than k photons, the radius stays unchanged to the bit.
                let radius = if count < bandwidth.k { bandwidth.radius } else { r2.sqrt() };
                return sums.estimate(radius, count);
            }
            // The photons lie within less than the least radius.
            radius = least;
        }
        let mut sums = Sums::<N>::new(kernel, radius * radius);
        let mut count = 0;
        self.visit(p, radius, |data, d2| {
            if is_on_surface(data, &plane, bandwidth.radius) {
                count += 1;
                sums.add(d2, height(data), brdf(data) * data.flux());
            }
        });
        sums.estimate(radius, count)
    }

    /// Finds the k nearest photons into `scratch`; returns the squared distance of the k-th.
    ///
    /// If the largest radius holds fewer, returns `None` and all of them. kiddo cannot shrink a
    /// radius during a query, so the search radius grows from a first guess.
    fn nearest(&self, p: Vec3, normal: Vec3, bandwidth: Bandwidth, scratch: &mut Scratch) -> Option<f32> {
        let k = bandwidth.k as usize;
        let guess = if scratch.last > 0.0 { scratch.last * 1.25 } else { bandwidth.radius * 0.25 };
        let mut radius = guess.min(bandwidth.radius);
        let plane = TangentPlane::new(p, normal);
        let found = &mut scratch.found;
        found.clear();
        // Reserves for 2k photons, but not for more than the map holds.
        found.reserve((2 * k).min(self.len()));
        loop {
            found.clear();
            let mut cutoff = f32::INFINITY;
            self.visit(p, radius, |data, d2| {
                if d2 < cutoff && is_on_surface(data, &plane, bandwidth.radius) {
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
    /// Distance from `p` to the k-th photon that an estimate would use; `None` if `most` \[length]
    /// holds fewer.
    #[must_use]
    pub fn kth_photon_distance(&self, p: Vec3, normal: Vec3, k: u32, most: f32) -> Option<f32> {
        let mut scratch = Scratch { last: most * 1e-3, ..Scratch::default() };
        self.nearest(p, normal, Bandwidth { radius: most, k }, &mut scratch).map(f32::sqrt)
    }
}

/// Kernel-weighted sums over nested discs.
struct Sums<const N: usize> {
    kernel: Kernel,
    r2: f32,
    inverse: f32,
    sums: [Rgb; N],
    /// Number of photons in `sums`.
    pending: u32,
    /// Sums of the earlier blocks.
    whole: [DVec3; N],
}

impl<const N: usize> Sums<N> {
    fn new(kernel: Kernel, r2: f32) -> Self {
        Self { kernel, r2, inverse: 1.0 / r2, sums: [Rgb::ZERO; N], pending: 0, whole: [DVec3::ZERO; N] }
    }

    /// Adds one photon; `height` over the tangent plane is relative to the largest height.
    #[inline]
    fn add(&mut self, d2: f32, height: f32, reflected: Rgb) {
        let x = d2 * self.inverse;
        self.sums[0] += reflected * self.kernel.unnormalized(x);
        let finer = [(2.0 * x, std::f32::consts::FRAC_1_SQRT_2), (4.0 * x, 0.5)];
        for (sum, (x, highest)) in self.sums[1..].iter_mut().zip(finer) {
            if height <= highest {
                *sum += reflected * self.kernel.unnormalized_or_zero(x);
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

    fn estimate(mut self, radius: f32, count: u32) -> (RadianceEstimate, [Rgb; N]) {
        self.flush();
        let mut r2 = self.r2;
        let radiance = self.whole.map(|sum| {
            let scaled = sum.as_vec3() * self.kernel.normalization(r2);
            r2 *= 0.5;
            scaled
        });
        (RadianceEstimate { radiance: radiance[0], radius, count }, radiance)
    }
}

/// True if a photon lies on the surface of the estimate.
#[inline]
pub(super) fn is_on_surface(data: &PhotonData, plane: &TangentPlane, radius: f32) -> bool {
    let (cosine, height) = data.normal_cosine_and_height(plane);
    cosine > SAME_SIDE && height.abs() <= radius * FLATNESS
}

/// Keeps the k nearest photons, and returns the k-th squared distance.
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

    /// Photons at 1 … 9 along a line, and one very far away.
    #[test]
    fn kth_distance_ignores_scene_extent() {
        let photon = |x: f32| Photon::new(Vec3::X * x, Rgb::ONE, Vec3::Z, Vec3::Z).unwrap();
        let map = PhotonMap::build((1..10).map(|i| photon(i as f32)).chain([photon(1e6)]).collect());
        for most in [20.0, 1e3, 1e5, 1e6] {
            let found = map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 4, most).unwrap();
            assert!((found - 4.0).abs() < 1e-5, "{found} of {most}");
        }
        assert_eq!(map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 10, 1e3), None);
        // A huge k does not allocate.
        assert_eq!(map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 4_000_000_000, 1e3), None);
    }
}
