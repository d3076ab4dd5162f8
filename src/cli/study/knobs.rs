//! `caustica study --knobs`: variants of a method, each with one setting changed.

use super::variants::VariantArguments;
use crate::cli::args::MethodArguments;
use crate::cli::settings::{kernel_name, settings_from_arguments};
use crate::integrate::{Algorithm, FinalGathering, Settings};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::scene::Scene;
use clap::ValueEnum;

/// Values of `--gather-k` (photons in a density estimate) that `--knobs` tries, one variant each.
const GATHER_COUNTS: [u32; 5] = [10, 20, 50, 100, 200];

/// Values of `--radius` that `--knobs` tries, divided by the gather radius that a pilot (simulation
/// before the first pass) found.
const RADIUS_FACTORS: [f32; 3] = [0.5, 1.0, 2.0];

/// Numbers of photon paths that `--knobs` tries, divided by the numbers that a pilot (simulation
/// before the first pass) chose.
const PHOTON_FACTORS: [f64; 2] = [0.25, 4.0];

/// Values of `--alpha` (shrinking of gather radii) that `--knobs` tries besides the default of ⅔.
const ALPHAS: [f64; 3] = [0.5, 0.8, 1.0];

/// Numbers of camera rays per pixel that `--knobs` tries, divided by the number that a pilot
/// (simulation before the first pass) chose.
const CAMERA_RAY_FACTORS: [f64; 2] = [0.5, 2.0];

/// Settings that pilots (short simulations before the first pass) chose for a method.
struct PilotChosenSettings {
    samples_per_pixel: u32,
    unaimed_paths: u32,
    aimed_paths: u32,
    gather_radius: Option<f32>,
}

impl PilotChosenSettings {
    fn new(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Self {
        let integrator = algorithm.prepare(scene, settings.clone());
        let balance = integrator.ray_photon_balance();
        let (width, height) = scene.camera().size();
        let camera_rays = integrator.expected_work(integrator.plan().simulated_effects()).camera_rays;
        let radius = integrator
            .initial_gather_radii()
            .map(|radii| if algorithm == Algorithm::Hybrid { radii.caustic } else { radii.indirect });
        Self {
            samples_per_pixel: (camera_rays / (u64::from(width) * u64::from(height))).max(1) as u32,
            unaimed_paths: balance.and_then(|b| b.unaimed_paths).unwrap_or(settings.unaimed_paths),
            aimed_paths: balance.and_then(|b| b.aimed_paths).unwrap_or(settings.aimed_paths),
            gather_radius: radius,
        }
    }
}

/// Returns the method of `algorithm` with the `shared` flags of the study, and variants of the
/// method that each change one setting.
///
/// One pilot (simulation before the first pass) chooses the numbers of rays and photons for all
/// variants. Variants of `--radius` scale a gather radius that this pilot found: in `hybrid`, the
/// radius of the caustic map; in other algorithms, the radius of the indirect map.
pub(super) fn knob_study_variants(
    algorithm: Algorithm,
    shared: &MethodArguments,
    overrides: EffectOverrides,
    scene: &Scene,
) -> Vec<VariantArguments> {
    let plain = VariantArguments::from_algorithm(algorithm, shared);
    let pilot = PilotChosenSettings::new(scene, algorithm, &settings_from_arguments(&plain.method, overrides));
    one_setting_variants(plain, &pilot)
}

/// Returns the method `plain`, and variants of the method with one setting changed.
///
/// `plain` and all variants use the numbers of rays and photons in `pilot`, except variants that
/// change these numbers. Changed numbers and radii are multiples of the values in `pilot`.
fn one_setting_variants(plain: VariantArguments, pilot: &PilotChosenSettings) -> Vec<VariantArguments> {
    let VariantArguments { label: name, mut method } = plain;
    let algorithm = method.integrator;
    method.spp = Some(pilot.samples_per_pixel);
    if algorithm.traces_photons() {
        (method.photons, method.caustic_photons) = (Some(pilot.unaimed_paths), Some(pilot.aimed_paths));
    }
    let base = method.clone();
    let mut all = vec![VariantArguments { label: name.clone(), method }];
    let mut add = |flag: String, change: &dyn Fn(&mut MethodArguments)| {
        let mut method = base.clone();
        change(&mut method);
        all.push(VariantArguments { label: format!("{name} {flag}"), method });
    };
    let scaled = |n: u32, by: f64| (f64::from(n) * by).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    if algorithm.traces_photons() {
        for k in GATHER_COUNTS.into_iter().filter(|k| base.gather_k != Some(*k)) {
            add(format!("--gather-k {k}"), &|method| method.gather_k = Some(k));
        }
        for radius in
            pilot.gather_radius.iter().flat_map(|r| RADIUS_FACTORS.map(|by| r * by)).filter(|r| base.radius != Some(*r))
        {
            add(format!("--radius {radius}"), &|method| method.radius = Some(radius));
        }
        for alpha in ALPHAS.into_iter().filter(|a| algorithm != Algorithm::Pm && base.alpha != Some(*a)) {
            add(format!("--alpha {alpha}"), &|method| method.alpha = Some(alpha));
        }
        for kernel in [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov].into_iter().filter(|k| base.kernel != *k) {
            add(format!("--kernel {}", kernel_name(kernel)), &|method| method.kernel = kernel);
        }
        for by in PHOTON_FACTORS {
            let [photons, caustic] =
                [pilot.unaimed_paths, pilot.aimed_paths].map(|n| if n == 0 { 0 } else { scaled(n, by) });
            if [photons, caustic] == [pilot.unaimed_paths, pilot.aimed_paths] {
                continue;
            }
            add(format!("--photons {photons} --caustic-photons {caustic}"), &|method| {
                (method.photons, method.caustic_photons) = (Some(photons), Some(caustic));
            });
        }
    }
    for samples in CAMERA_RAY_FACTORS
        .map(|by| scaled(pilot.samples_per_pixel, by))
        .into_iter()
        .filter(|n| *n != pilot.samples_per_pixel)
    {
        add(format!("--spp {samples}"), &|method| method.spp = Some(samples));
    }
    if !base.adaptive && algorithm != Algorithm::Ppm {
        add("--adaptive".to_owned(), &|method| method.adaptive = true);
    }
    if algorithm == Algorithm::Pm {
        for gathering in FinalGathering::value_variants().iter().filter(|g| base.final_gathering != **g) {
            let name = gathering.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned());
            add(format!("--final-gathering {name}"), &|method| method.final_gathering = *gathering);
        }
    }
    all
}

#[cfg(test)]
mod tests;
