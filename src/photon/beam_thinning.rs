//! Random thinning of photon beams: fewer beams with more flux each, and the same expected flux. A
//! render thins its beams where a minimum kernel radius would make each lookup find too many of
//! them.

use super::PhotonBeam;

/// Keeps about the fraction `kept_fraction` of `beams`, chosen at random. The flux of the kept
/// beams is raised, so that the expected flux of each beam does not change.
///
/// Systematic sampling (Kitagawa 1996) draws each beam 0, 1 or more times; the expected number of
/// draws is proportional to the beam's flux. A beam with 0 draws is left out. A beam that is drawn
/// gets the flux: old flux · number of draws / expected number of draws.
///
/// `random_offset` in \[0, 1) is the only random number. Beams keep their order. If `kept_fraction`
/// is not between 0 and 1, all beams stay unchanged.
#[must_use]
pub fn thin_beams(mut beams: Vec<PhotonBeam>, kept_fraction: f32, random_offset: f32) -> Vec<PhotonBeam> {
    let flux = |beam: &PhotonBeam| f64::from(beam.flux.x) + f64::from(beam.flux.y) + f64::from(beam.flux.z);
    let total: f64 = beams.iter().map(flux).sum();
    let total_draws = f64::from(kept_fraction) * beams.len() as f64;
    if !(kept_fraction < 1.0 && total_draws > 0.0 && total > 0.0 && total.is_finite()) {
        return beams;
    }
    let draws_per_flux = total_draws / total;
    let (mut sum, mut draws_before) = (0.0, 0.0);
    beams.retain_mut(|beam| {
        let own = flux(beam);
        sum += own;
        let draws_after = (sum * draws_per_flux + f64::from(random_offset)).floor();
        let draws = draws_after - draws_before;
        draws_before = draws_after;
        if draws > 0.0 {
            beam.flux *= (draws / (own * draws_per_flux)) as f32;
        }
        draws > 0.0
    });
    beams
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use glam::Vec3;

    /// Over evenly spaced values of `random_offset`, weak and strong beams keep their mean flux. On
    /// average, not more than the given fraction of the beams is kept.
    #[test]
    fn thinning_keeps_the_mean_flux_of_each_beam() {
        let flux = |i: u32| Rgb::new(1.0, 0.5, 0.25) * [1.0, 3.0, 0.01, 60.0][i as usize % 4] * (1 + i % 7) as f32;
        let beams: Vec<PhotonBeam> =
            (0..40).map(|i| PhotonBeam::new(Vec3::ZERO, Vec3::Z, 1.0, flux(i), i, 0).unwrap()).collect();
        assert_eq!(thin_beams(beams.clone(), 1.0, 0.3), beams);
        for share in [0.05, 0.4, 0.9] {
            let (mut sums, mut count, starts) = (vec![Rgb::ZERO; 40], 0, 20_000);
            for k in 0..starts {
                let kept = thin_beams(beams.clone(), share, (k as f32 + 0.5) / starts as f32);
                assert!(kept.is_sorted_by_key(|beam| beam.medium));
                count += kept.len();
                kept.iter().for_each(|beam| sums[beam.medium as usize] += beam.flux / starts as f32);
            }
            assert!(count as f32 <= (share * 40.0 + 1.0) * starts as f32 && count > 0, "{share}: {count}");
            for (i, mean) in (0..).zip(sums) {
                // A weak beam is kept for only few of the 20,000 values of `random_offset`. The
                // tolerance is two such values.
                let smallest = share * 40.0 * flux(i).x / beams.iter().map(|b| b.flux.x).sum::<f32>();
                let tolerance = 1e-3 + 2.0 / (smallest * starts as f32);
                assert!((mean.x / flux(i).x - 1.0).abs() < tolerance, "{share}, beam {i}: {mean}");
            }
        }
    }
}
