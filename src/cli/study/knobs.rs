//! What each setting of a method buys: the method, and with one setting changed at a time.

use super::variants::Named;
use crate::cli::args::MethodArguments;
use crate::cli::settings::{kernel_name, settings};
use crate::integrate::{Algorithm, FinalGathering, Settings};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::scene::Scene;
use clap::ValueEnum;

const GATHER_K: [u32; 5] = [10, 20, 50, 100, 200];

/// What radii are multiplied by.
const RADII: [f32; 3] = [0.5, 1.0, 2.0];

/// What photon paths are multiplied by: fewer make more passes for the same time.
const PHOTONS: [f64; 2] = [0.25, 4.0];

/// How fast radii shrink, beside ⅔.
const ALPHAS: [f64; 3] = [0.5, 0.8, 1.0];

/// What camera rays are multiplied by.
const SAMPLES: [f64; 2] = [0.5, 2.0];

/// What a pilot found.
struct Pilot {
    samples: u32,
    photons: u32,
    caustic_photons: u32,
    radius: Option<f32>,
}

impl Pilot {
    fn new(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Self {
        let integrator = algorithm.prepare(scene, settings.clone());
        let balance = integrator.balance();
        let (width, height) = scene.camera().size();
        let looked = integrator.expected_work(integrator.plan().effects()).camera_rays;
        let radius =
            integrator.radii().map(|radii| if algorithm == Algorithm::Hybrid { radii.caustic } else { radii.global });
        Self {
            samples: (looked / (u64::from(width) * u64::from(height))).max(1) as u32,
            photons: balance.and_then(|b| b.photons).unwrap_or(settings.photons),
            caustic_photons: balance.and_then(|b| b.caustic_photons).unwrap_or(settings.caustic_photons),
            radius,
        }
    }
}

/// The variants around a method with the flags given to all. Numbers of rays and photons that a pilot would choose are chosen once, so
/// that one setting alone differs.
///
/// The radius that is halved and doubled is that of the caustic map for `hybrid`, of the global map for others; `--radius` sets both.
pub(super) fn around(
    algorithm: Algorithm,
    shared: &MethodArguments,
    wishes: EffectOverrides,
    scene: &Scene,
) -> Vec<Named> {
    let plain = Named::plain(algorithm, shared);
    let pilot = Pilot::new(scene, algorithm, &settings(&plain.method, wishes));
    vary(plain, &pilot)
}

fn vary(plain: Named, pilot: &Pilot) -> Vec<Named> {
    let Named { label: name, mut method } = plain;
    let algorithm = method.integrator;
    method.spp = Some(pilot.samples);
    if algorithm.has_photons() {
        (method.photons, method.caustic_photons) = (Some(pilot.photons), Some(pilot.caustic_photons));
    }
    let base = method.clone();
    let mut all = vec![Named { label: name.clone(), method }];
    let mut add = |flag: String, change: &dyn Fn(&mut MethodArguments)| {
        let mut method = base.clone();
        change(&mut method);
        all.push(Named { label: format!("{name} {flag}"), method });
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
mod tests {
    use super::*;
    use crate::cli::study::variants::defaults;

    fn labels(algorithm: Algorithm, change: impl FnOnce(&mut MethodArguments)) -> Vec<String> {
        let mut shared = defaults();
        change(&mut shared);
        let pilot = Pilot { samples: 1, photons: 1000, caustic_photons: 0, radius: Some(0.25) };
        let all = vary(Named::plain(algorithm, &shared), &pilot);
        // A label is what makes the variant of the base: read again, it gives the same.
        for named in &all {
            let again = Named::read(&named.label, &all[0].method).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(format!("{:?}", again.method), format!("{:?}", named.method));
        }
        all.into_iter().map(|named| named.label).collect()
    }

    #[test]
    fn one_setting_changes_at_a_time() {
        let pm = labels(Algorithm::Pm, |_| {});
        let ends = |label: &str| pm.iter().any(|l| l.strip_prefix("pm ") == Some(label));
        for wanted in [
            "--gather-k 10",
            "--gather-k 200",
            "--radius 0.125",
            "--radius 0.25",
            "--radius 0.5",
            "--kernel box",
            "--kernel cone",
            "--photons 250 --caustic-photons 0",
            "--photons 4000 --caustic-photons 0",
            "--spp 2",
            "--adaptive",
            "--final-gathering none",
            "--final-gathering importance",
        ] {
            assert!(ends(wanted), "{wanted} is not in {pm:?}");
        }
        // The base, five, three, two, two, one, one, two; half of one camera ray is one.
        assert_eq!((pm.len(), pm[0].as_str()), (17, "pm"));
        assert_eq!(labels(Algorithm::Path, |_| {}), ["path", "path --spp 2", "path --adaptive"]);
    }

    #[test]
    fn what_is_set_for_all_is_not_varied_into_itself() {
        let sppm = labels(Algorithm::Sppm, |method| {
            (method.gather_k, method.adaptive, method.kernel) = (Some(20), true, Kernel::Box);
        });
        assert!(sppm.iter().all(|l| !l.contains("--adaptive") && !l.ends_with("--gather-k 20") && !l.contains("box")));
        assert!(sppm.contains(&"sppm --kernel epanechnikov".to_owned()));
    }
}
