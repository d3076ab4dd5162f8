//! Differences between photon density estimates with nested gather discs of several sizes. They
//! measure the bias of the estimates in a pixel.

use crate::color::Rgb;
use crate::photon::NESTED_DISC_COUNT;
use glam::DVec3;
use serde::Serialize;

/// Mean gather radius and mean photon count of a pixel's density estimates on surfaces. The means
/// may cover several passes, and two photon maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeanGatherDisc {
    /// Mean gather radius of the density estimates \[length].
    pub radius: f32,
    /// Mean number of photons in a density estimate.
    #[serde(rename = "photons")]
    pub mean_count: f32,
}

/// Differences between a pixel's photon estimates with gather discs of full, half and quarter area.
///
/// The bias of a density estimate grows with its disc. Estimates with discs around the same center
/// share most of their noise, so their differences measure the bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NestedDifferences {
    /// Two differences of radiance \[W/(m² sr)] between estimates with discs of neighbouring areas:
    /// full minus half, and half minus quarter.
    pub differences: [Rgb; NESTED_DISC_COUNT - 1],
    /// Mean radius and photon count of the density estimates on surfaces from the caustic map;
    /// `None` without an estimate.
    pub caustic_disc: Option<MeanGatherDisc>,
    /// Mean radius and photon count of the density estimates on surfaces from the indirect and the
    /// interreflection map; `None` without an estimate. Together, these maps hold the indirect
    /// light.
    pub indirect_disc: Option<MeanGatherDisc>,
}

/// Sums of the gather radii and of the photon counts of a pixel's density estimates on surfaces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GatherDiscSum {
    radius_sum: f32,
    photon_counts: f32,
    count: u32,
}

impl GatherDiscSum {
    /// Counts one density estimate: adds its gather radius \[length] and its number of photons to
    /// the sums.
    pub fn add(&mut self, radius: f32, photons: u32) {
        self.radius_sum += radius;
        self.photon_counts += photons as f32;
        self.count += 1;
    }

    /// Returns the means over the counted density estimates; `None` without an estimate.
    fn mean(self) -> Option<MeanGatherDisc> {
        let n = self.count as f32;
        (self.count > 0).then(|| MeanGatherDisc { radius: self.radius_sum / n, mean_count: self.photon_counts / n })
    }
}

/// Differences between photon estimates with gather discs of full, half and quarter area, summed
/// over one camera ray and over all rays of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelNestedDifferenceSum {
    /// True if photon estimates are repeated in smaller discs with the same center. False leaves
    /// all sums at 0.
    pub is_wanted: bool,
    /// Sums of throughput times difference over the photon estimates of the camera ray that is
    /// being traced \[W/(m² sr)]. The first difference is the estimate in the full gather disc
    /// minus that in a disc of half its area. The second is the estimate in the disc of half the
    /// area minus that in a disc of a quarter of the area.
    camera_ray_sum: [Rgb; NESTED_DISC_COUNT - 1],
    /// Sum of `camera_ray_sum` over the camera rays of the pixel, weighted by the pixel filter
    /// \[W/(m² sr)].
    pixel_sum: [DVec3; NESTED_DISC_COUNT - 1],
    /// Radiance of the last photon estimate minus the estimate with half its disc area \[W/(m²
    /// sr)].
    pub last_difference: Rgb,
    /// Sums of gather radii and of photon counts, over the pixel's density estimates from the
    /// caustic map.
    pub caustic_discs: GatherDiscSum,
    /// Sums of gather radii and of photon counts, over the pixel's density estimates from the
    /// indirect and the interreflection map, which together hold the indirect light.
    pub indirect_discs: GatherDiscSum,
}

impl PixelNestedDifferenceSum {
    /// Returns sums for a new pixel, all 0. If `is_wanted` is false, they stay 0.
    pub fn new(is_wanted: bool) -> Self {
        Self { is_wanted, ..Self::default() }
    }

    /// Adds one photon estimate, given its radiance with each disc size, largest disc first \[W/(m²
    /// sr)].
    ///
    /// `throughput` is the factor from the estimate's radiance to the radiance of the pixel.
    #[inline]
    pub fn add(&mut self, throughput: Rgb, radiance: [Rgb; NESTED_DISC_COUNT]) {
        for (sum, pair) in self.camera_ray_sum.iter_mut().zip(radiance.windows(2)) {
            *sum += throughput * (pair[0] - pair[1]);
        }
        self.last_difference = radiance[0] - radiance[1];
    }

    /// Ends a camera ray: adds its nested differences, times its filter weight `weight`, to the
    /// sums of the pixel. Resets the sums of the ray.
    ///
    /// A ray whose radiance is not finite has the `weight` `None`. Such a ray adds nothing, nor
    /// does a ray with a nested difference that is not finite.
    #[inline]
    pub fn finish_camera_ray(&mut self, weight: Option<f32>) {
        if let Some(weight) = weight.filter(|_| self.camera_ray_sum.iter().all(|difference| difference.is_finite())) {
            for (sum, difference) in self.pixel_sum.iter_mut().zip(self.camera_ray_sum) {
                *sum += difference.as_dvec3() * f64::from(weight);
            }
        }
        self.camera_ray_sum = [Rgb::ZERO; NESTED_DISC_COUNT - 1];
    }

    /// Returns the pixel's nested differences, and resets the sums for the next pixel.
    ///
    /// Differences of radiance are means over the pixel's `rays` camera rays.
    pub fn finish_pixel(&mut self, rays: u32) -> NestedDifferences {
        let differences = self.pixel_sum.map(|sum| (sum / f64::from(rays)).as_vec3());
        let differences = NestedDifferences {
            differences,
            caustic_disc: self.caustic_discs.mean(),
            indirect_disc: self.indirect_discs.mean(),
        };
        *self = Self::new(self.is_wanted);
        differences
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_means_of_their_accepted_rays() {
        let mut sum = PixelNestedDifferenceSum::default();
        let levels = |a: f32, b: f32, c: f32| [a, b, c].map(Rgb::splat);
        sum.add(Rgb::splat(0.5), levels(4.0, 2.0, 1.0));
        sum.add(Rgb::ONE, levels(1.0, 1.0, 2.0));
        sum.caustic_discs.add(0.5, 10);
        sum.caustic_discs.add(1.5, 20);
        sum.finish_camera_ray(Some(1.0));
        sum.add(Rgb::ONE, levels(100.0, 0.0, 0.0));
        sum.finish_camera_ray(None);
        sum.add(Rgb::ONE, levels(f32::INFINITY, 0.0, 0.0));
        sum.finish_camera_ray(Some(1.0));
        let found = sum.finish_pixel(2);
        assert_eq!(found.differences, [Rgb::splat(0.5), Rgb::splat(-0.25)]);
        assert_eq!(
            (found.caustic_disc, found.indirect_disc),
            (Some(MeanGatherDisc { radius: 1.0, mean_count: 15.0 }), None)
        );
        assert_eq!(sum.finish_pixel(1), NestedDifferences::default());
    }
}
