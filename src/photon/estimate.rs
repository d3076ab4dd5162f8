//! Radiance estimates by photon density estimation on surfaces.

use super::surface_photon::TangentPlane;
use super::{Kernel, PhotonAttributes, PhotonMap};
use crate::color::Rgb;
use glam::{DVec3, Vec3};

/// Limits of the disc from which a photon density estimate gathers photons: its largest radius, and
/// its largest number of photons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// Largest radius of the disc \[length].
    pub radius: f32,
    /// Largest number of photons in the disc, k; 0 for no limit.
    ///
    /// If more photons lie within `radius`, the disc shrinks to the distance of the k-th nearest
    /// photon.
    pub k: u32,
}

/// Reflected radiance, estimated from the photons in a disc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadianceEstimate {
    /// Radiance \[W/(m² sr)].
    pub radiance: Rgb,
    /// Radius of the disc whose photons were summed \[length].
    pub radius: f32,
    /// Number of photons in the disc.
    pub photon_count: u32,
}

/// Number of concentric discs of a [`NestedRadianceEstimate`]. Each disc has half the area of the
/// next larger one.
pub const NESTED_DISC_COUNT: usize = 3;

/// Radiance estimates from concentric discs of decreasing size around one point. Photons in a small
/// disc also count in the larger ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NestedRadianceEstimate {
    /// Estimate with the largest of the nested discs.
    pub full_disc: RadianceEstimate,
    /// Radiance \[W/(m² sr)] from discs with 1, 1/√2 and ½ of the radius of `full_disc`.
    pub radiance: [Rgb; NESTED_DISC_COUNT],
}

/// Reusable memory for k-nearest-photon searches, to be kept between searches at neighbouring
/// points. Each search derives its first radius from the result of the previous search.
#[derive(Debug, Default)]
pub struct PhotonSearchBuffers {
    /// Photons that the last search found, each with its squared distance from the query point.
    found: Vec<(f32, PhotonAttributes)>,
    /// Distance of the k-th photon in the last search \[length]; the search radius if fewer than k
    /// photons were found.
    ///
    /// The next search begins with 1.25 times this radius.
    last_radius: f32,
}

impl PhotonSearchBuffers {
    /// Sets the expected distance \[length] of the k-th nearest photon to `radius`. The next search
    /// begins with 1.25 times this distance.
    pub(super) fn set_expected_kth_distance(&mut self, radius: f32) {
        self.last_radius = radius;
    }
}

/// Ratio of the smallest allowed radius of a density estimate's disc to the distance of the query
/// point from the origin. Such a radius is about 100 rounding errors of a position.
const MIN_RADIUS_PER_DISTANCE: f32 = 1e-5;

/// Ratio of the smallest allowed radius of the disc in a k-nearest-neighbour estimate to
/// [`Bandwidth::radius`]: 2⁻²⁰. The limit keeps the radiance finite if k photons coincide.
const MIN_KNN_RADIUS_FRACTION: f32 = 1.0 / 1_048_576.0;

/// Number of photons that are summed in f32. Each such sum is then added to a total in f64, which
/// limits rounding errors.
const PHOTONS_PER_BLOCK: u32 = 64;

/// Smallest cosine between the normals of a photon and of the query point at which the photon
/// counts in a density estimate. At a smaller cosine, the photon is taken to lie on another
/// surface.
pub(super) const MIN_NORMAL_COSINE: f32 = 0.5;

/// Largest distance from the query point to a photon's tangent plane at which the photon counts in
/// a density estimate, divided by [`Bandwidth::radius`]. At a larger distance, the photon is taken
/// to lie on another surface.
pub(super) const MAX_RELATIVE_HEIGHT: f32 = 0.25;

impl PhotonMap {
    /// Estimates the reflected radiance at `p`: Σ f·ΔΦ·K over the photons in a disc, with BRDF f,
    /// photon flux ΔΦ and kernel K (Jensen 2001, section 7.2).
    ///
    /// `brdf` returns f \[1/sr] for a photon's incident direction. `normal` is the unit geometric
    /// normal on the viewer's side. Photons of other surfaces are left out: those whose normal
    /// differs from `normal` by more than 60°, or whose tangent plane is farther from `p` than a
    /// quarter of [`Bandwidth::radius`]. `scratch` keeps the found photons and the start radius for
    /// the next search. The estimate is not divided by the coverage, which is the fraction of the
    /// disc that is surface.
    pub fn estimate_radiance(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut PhotonSearchBuffers,
        brdf: impl Fn(&PhotonAttributes) -> Rgb,
    ) -> RadianceEstimate {
        self.estimate_radiance_in_discs::<1>(p, normal, bandwidth, kernel, scratch, brdf).0
    }

    /// Estimates the reflected radiance at `p` in [`NESTED_DISC_COUNT`] concentric discs, to
    /// measure how the estimate depends on the radius.
    ///
    /// The value of the largest disc is exactly the result of [`PhotonMap::estimate_radiance`].
    pub fn estimate_radiance_in_nested_discs(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut PhotonSearchBuffers,
        brdf: impl Fn(&PhotonAttributes) -> Rgb,
    ) -> NestedRadianceEstimate {
        let (full_disc, radiance) = self.estimate_radiance_in_discs(p, normal, bandwidth, kernel, scratch, brdf);
        NestedRadianceEstimate { full_disc, radiance }
    }

    fn estimate_radiance_in_discs<const N: usize>(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        kernel: Kernel,
        scratch: &mut PhotonSearchBuffers,
        brdf: impl Fn(&PhotonAttributes) -> Rgb,
    ) -> (RadianceEstimate, [Rgb; N]) {
        if self.is_empty() {
            return (RadianceEstimate { radius: bandwidth.radius, ..RadianceEstimate::default() }, [Rgb::ZERO; N]);
        }
        let plane = TangentPlane::new(p, normal);
        let resolvable_radius = p.length() * MIN_RADIUS_PER_DISTANCE;
        let bandwidth = Bandwidth { radius: bandwidth.radius.max(resolvable_radius), ..bandwidth };
        let mut radius = bandwidth.radius;
        // Height of `p` over a photon's tangent plane, divided by the limit for the largest disc.
        // Smaller discs have lower limits.
        let relative_height = |data: &PhotonAttributes| {
            if N > 1 {
                data.normal_cosine_and_height(&plane).1.abs() / (bandwidth.radius * MAX_RELATIVE_HEIGHT)
            } else {
                0.0
            }
        };
        if bandwidth.k > 0 {
            let least_radius = resolvable_radius.max(radius * MIN_KNN_RADIUS_FRACTION).max(self.min_radius).min(radius);
            let r2 = match self.find_k_nearest(p, normal, bandwidth, scratch) {
                Some(r2) if r2 >= least_radius * least_radius => Some(r2),
                Some(_) => None,
                None => Some(radius * radius),
            };
            if let Some(r2) = r2 {
                let mut sums = KernelSums::<N>::new(kernel, r2);
                for (d2, data) in &scratch.found {
                    // The k-th photon defines the radius. The density (k − 1)/(πr²) of the others
                    // is unbiased.
                    if kernel.vanishes_at_edge() || *d2 < r2 || scratch.found.len() < bandwidth.k as usize {
                        sums.add(*d2, relative_height(data), brdf(data) * data.flux());
                    }
                }
                let count = scratch.found.len() as u32;
                // √(squared radius) could differ from the radius by rounding.
                let radius = if count < bandwidth.k { bandwidth.radius } else { r2.sqrt() };
                return sums.into_radiance(radius, count);
            }
            // The k-th photon is nearer than the least radius, so all photons within the least
            // radius count.
            radius = least_radius;
        }
        let mut sums = KernelSums::<N>::new(kernel, radius * radius);
        let mut count = 0;
        self.visit_within_radius(p, radius, |data, d2| {
            if is_on_query_surface(data, &plane, bandwidth.radius) {
                count += 1;
                sums.add(d2, relative_height(data), brdf(data) * data.flux());
            }
        });
        sums.into_radiance(radius, count)
    }

    /// Writes the k photons nearest to `p` to `scratch`, and returns the squared distance of the
    /// k-th \[length²]. If fewer than k lie within `bandwidth.radius`, writes all of them and
    /// returns `None`.
    ///
    /// Photons on other surfaces, with another normal or tangent plane, are left out. The search is
    /// repeated with growing radius until it finds k photons, because the kd-tree of crate kiddo
    /// cannot shrink the radius of a search while it runs.
    fn find_k_nearest(
        &self,
        p: Vec3,
        normal: Vec3,
        bandwidth: Bandwidth,
        scratch: &mut PhotonSearchBuffers,
    ) -> Option<f32> {
        let k = bandwidth.k as usize;
        let guess = if scratch.last_radius > 0.0 { scratch.last_radius * 1.25 } else { bandwidth.radius * 0.25 };
        let mut radius = guess.min(bandwidth.radius);
        let plane = TangentPlane::new(p, normal);
        let found = &mut scratch.found;
        found.clear();
        found.reserve((2 * k).min(self.len()));
        loop {
            found.clear();
            let mut cutoff = f32::INFINITY;
            self.visit_within_radius(p, radius, |data, d2| {
                if d2 < cutoff && is_on_query_surface(data, &plane, bandwidth.radius) {
                    found.push((d2, *data));
                    if found.len() == 2 * k {
                        cutoff = keep_k_nearest(found, k);
                    }
                }
            });
            if found.len() >= k {
                let r2 = keep_k_nearest(found, k);
                scratch.last_radius = r2.sqrt();
                return Some(r2);
            }
            if radius >= bandwidth.radius {
                scratch.last_radius = radius;
                return None;
            }
            let missing = (1.5 * k as f32 / found.len().max(1) as f32).sqrt();
            radius = (radius * missing.clamp(1.2, 3.0)).min(bandwidth.radius);
        }
    }

    /// Distance from `p` to the k-th nearest photon on the surface of `p` \[length]. `normal` is
    /// the unit geometric normal at `p`.
    ///
    /// Returns `None` if fewer than k photons lie within the distance `most` \[length]. Photons on
    /// other surfaces, with another normal or tangent plane, do not count.
    #[must_use]
    pub fn kth_photon_distance(&self, p: Vec3, normal: Vec3, k: u32, most: f32) -> Option<f32> {
        let mut scratch = PhotonSearchBuffers { last_radius: most * 1e-3, ..PhotonSearchBuffers::default() };
        self.find_k_nearest(p, normal, Bandwidth { radius: most, k }, &mut scratch).map(f32::sqrt)
    }
}

/// Kernel-weighted sums of BRDF · flux over N nested discs.
struct KernelSums<const N: usize> {
    kernel: Kernel,
    /// Squared radius of the largest disc \[length²].
    r2: f32,
    inverse_r2: f32,
    /// Sums in f32 over the photons that are not yet in `total`, fewer than [`PHOTONS_PER_BLOCK`];
    /// one sum of BRDF · flux · kernel for each disc.
    block_sums: [Rgb; N],
    /// Number of photons whose contributions are in `block_sums`.
    block_photon_count: u32,
    /// Sums in f64 over the photons of all full blocks; one sum of BRDF · flux · kernel for each
    /// disc.
    total: [DVec3; N],
}

impl<const N: usize> KernelSums<N> {
    fn new(kernel: Kernel, r2: f32) -> Self {
        Self {
            kernel,
            r2,
            inverse_r2: 1.0 / r2,
            block_sums: [Rgb::ZERO; N],
            block_photon_count: 0,
            total: [DVec3::ZERO; N],
        }
    }

    /// Adds `reflected` = BRDF · flux of a photon at squared distance `d2` from the query point,
    /// times the kernel, to the sum of each disc.
    ///
    /// `height` is the distance from the query point to the photon's tangent plane, divided by the
    /// largest distance that the largest disc allows. The limit of a smaller disc is lower in
    /// proportion to its radius, and photons above it are left out of its sum.
    #[inline]
    fn add(&mut self, d2: f32, height: f32, reflected: Rgb) {
        let x = d2 * self.inverse_r2;
        self.block_sums[0] += reflected * self.kernel.unnormalized_value(x);
        let finer = [(2.0 * x, std::f32::consts::FRAC_1_SQRT_2), (4.0 * x, 0.5)];
        for (sum, (x, highest)) in self.block_sums[1..].iter_mut().zip(finer) {
            if height <= highest {
                *sum += reflected * self.kernel.unnormalized_value_or_zero(x);
            }
        }
        self.block_photon_count += 1;
        if self.block_photon_count == PHOTONS_PER_BLOCK {
            self.flush_block_sums();
        }
    }

    fn flush_block_sums(&mut self) {
        self.total
            .iter_mut()
            .zip(&mut self.block_sums)
            .for_each(|(total, sum)| *total += std::mem::take(sum).as_dvec3());
        self.block_photon_count = 0;
    }

    fn into_radiance(mut self, radius: f32, count: u32) -> (RadianceEstimate, [Rgb; N]) {
        self.flush_block_sums();
        let mut r2 = self.r2;
        let radiance = self.total.map(|sum| {
            let scaled = sum.as_vec3() * self.kernel.normalization_factor(r2);
            r2 *= 0.5;
            scaled
        });
        (RadianceEstimate { radiance: radiance[0], radius, photon_count: count }, radiance)
    }
}

/// True if a photon counts as lying on the surface of a density estimate's query point. `plane` is
/// the tangent plane at that point.
///
/// The photon's normal must be within 60° of the plane's normal. The photon's tangent plane must
/// pass within [`MAX_RELATIVE_HEIGHT`] · `radius` of the query point. `radius` is the largest
/// radius of the estimate \[length].
#[inline]
pub(super) fn is_on_query_surface(data: &PhotonAttributes, plane: &TangentPlane, radius: f32) -> bool {
    let (cosine, height) = data.normal_cosine_and_height(plane);
    cosine > MIN_NORMAL_COSINE && height.abs() <= radius * MAX_RELATIVE_HEIGHT
}

/// Truncates `found` to the k nearest photons, and returns the squared distance of the k-th.
fn keep_k_nearest(found: &mut Vec<(f32, PhotonAttributes)>, k: usize) -> f32 {
    let (_, kth, _) = found.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0));
    let r2 = kth.0;
    found.truncate(k);
    r2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::Photon;

    /// `kth_photon_distance` finds the exact distance of the k-th photon, even if one photon of the
    /// map is as far away as 10⁶.
    #[test]
    fn kth_distance_ignores_scene_extent() {
        let photon = |x: f32| Photon::new(Vec3::X * x, Rgb::ONE, Vec3::Z, Vec3::Z).unwrap();
        let map = PhotonMap::build((1..10).map(|i| photon(i as f32)).chain([photon(1e6)]).collect());
        for most in [20.0, 1e3, 1e5, 1e6] {
            let found = map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 4, most).unwrap();
            assert!((found - 4.0).abs() < 1e-5, "{found} of {most}");
        }
        assert_eq!(map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 10, 1e3), None);
        // A huge k does not allocate memory for k photons.
        assert_eq!(map.kth_photon_distance(Vec3::ZERO, Vec3::Z, 4_000_000_000, 1e3), None);
    }
}
