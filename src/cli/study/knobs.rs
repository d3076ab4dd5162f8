//! `caustica study --knobs`: a method, and its variants with one setting changed at a time.

use super::variants::NamedVariant;
use crate::cli::args::MethodArguments;
use crate::cli::settings::{kernel_name, settings};
use crate::integrate::{Algorithm, FinalGathering, Settings};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::scene::Scene;
use clap::ValueEnum;

/// Values of `--gather-k`.
const GATHER_K: [u32; 5] = [10, 20, 50, 100, 200];

/// Factors of the radius that a pilot chose.
const RADII: [f32; 3] = [0.5, 1.0, 2.0];

/// Factors of the numbers of photon paths. Fewer paths allow more passes in the same time.
const PHOTONS: [f64; 2] = [0.25, 4.0];

/// Values of `--alpha` other than the default of ⅔.
const ALPHAS: [f64; 3] = [0.5, 0.8, 1.0];

/// Factors of the number of camera rays.
const SAMPLES: [f64; 2] = [0.5, 2.0];

/// Settings that a pilot pass chose.
struct PilotChoices {
    samples: u32,
    photons: u32,
    caustic_photons: u32,
    radius: Option<f32>,
}

impl PilotChoices {
    fn new(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Self {
        let integrator = algorithm.prepare(scene, settings.clone());
        let balance = integrator.balance();
        let (width, height) = scene.camera().size();
        let camera_rays = integrator.expected_work(integrator.plan().simulated_effects()).camera_rays;
        let radius =
            integrator.radii().map(|radii| if algorithm == Algorithm::Hybrid { radii.caustic } else { radii.global });
        Self {
            samples: (camera_rays / (u64::from(width) * u64::from(height))).max(1) as u32,
            photons: balance.and_then(|b| b.photons).unwrap_or(settings.photons),
            caustic_photons: balance.and_then(|b| b.caustic_photons).unwrap_or(settings.caustic_photons),
            radius,
        }
    }
}

/// A method with the flags of all methods, and its variants with one setting changed.
///
/// A pilot chooses the numbers of rays and photons once for all variants, so only one setting
/// differs. The factors of the radius apply to the caustic map for `hybrid` and to the global map
/// for other methods. `--radius` sets both.
pub(super) fn variants_around(
    algorithm: Algorithm,
    shared: &MethodArguments,
    overrides: EffectOverrides,
    scene: &Scene,
) -> Vec<NamedVariant> {
    let plain = NamedVariant::plain(algorithm, shared);
    let pilot = PilotChoices::new(scene, algorithm, &settings(&plain.method, overrides));
    vary(plain, &pilot)
}

/// The variants of a method, given the settings that a pilot chose.
fn vary(plain: NamedVariant, pilot: &PilotChoices) -> Vec<NamedVariant> {
    let NamedVariant { label: name, mut method } = plain;
    let algorithm = method.integrator;
    method.spp = Some(pilot.samples);
    if algorithm.has_photons() {
        (method.photons, method.caustic_photons) = (Some(pilot.photons), Some(pilot.caustic_photons));
    }
    let base = method.clone();
    let mut all = vec![NamedVariant { label: name.clone(), method }];
    let mut add = |flag: String, change: &dyn Fn(&mut MethodArguments)| {
        let mut method = base.clone();
        change(&mut method);
        all.push(NamedVariant { label: format!("{name} {flag}"), method });
    };
    let scaled = |n: u32, by: f64| (f64::from(n) * by).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    if algorithm.has_photons() {
        for k in GATHER_K.into_iter().filter(|k| base.gather_k != Some(*k)) {
            add(format!("--gather-k {k}"), &|method| method.gather_k = Some(k));
        }
        for radius in pilot.radius.iter().flat_map(|r| RADII.map(|by| r * by)).filter(|r| base.radius != Some(*r)) {
            add(format!("--radius {radius}"), &|method| method.radius = Some(radius));
        }
        for alpha in ALPHAS.into_iter().filter(|a| algorithm != Algorithm::Pm && base.alpha != Some(*a)) {
            add(format!("--alpha {alpha}"), &|method| method.alpha = Some(alpha));
        }
        for kernel in [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov].into_iter().filter(|k| base.kernel != *k) {
            add(format!("--kernel {}", kernel_name(kernel)), &|method| method.kernel = kernel);
        }
        for by in PHOTONS {
            let [photons, caustic] =
                [pilot.photons, pilot.caustic_photons].map(|n| if n == 0 { 0 } else { scaled(n, by) });
            if [photons, caustic] == [pilot.photons, pilot.caustic_photons] {
                continue;
            }
            add(format!("--photons {photons} --caustic-photons {caustic}"), &|method| {
                (method.photons, method.caustic_photons) = (Some(photons), Some(caustic));
            });
        }
    }
    for samples in SAMPLES.map(|by| scaled(pilot.samples, by)).into_iter().filter(|n| *n != pilot.samples) {
        add(format!("--spp {samples}"), &|method| method.spp = Some(samples));
    }
    if !base.adaptive {
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
