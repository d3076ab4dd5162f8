//! The work of a plan, expected by counting: no seconds, so the same on any machine.

use super::settled;
use crate::integrate::{Algorithm, Settings, Silent};
use crate::plan::{Effect, Plan};
use crate::scene::Scene;
use crate::stats::Counters;

/// Longest side of the picture in which work is counted \[pixels].
const SIDE: u32 = 64;

/// Photon paths of the larger map are one in so many …
const PATHS: u32 = 16;

/// … but at least these and at most those.
const FEWEST_PATHS: u32 = 1 << 12;
const MOST_PATHS: u32 = 1 << 15;

/// Most camera rays a pixel.
const SAMPLES: u32 = 16;

/// Pilots follow one in so many of their paths.
const THINNED: u32 = 8;

/// Work of the first pass; of a difference, either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Rays of every kind.
    pub rays: i64,
    /// Photons in density estimates.
    pub gathered_photons: i64,
}

/// What a plan costs in work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedWork {
    /// All of it.
    pub whole: Work,
    /// What each effect that is simulated adds to it, in the order of [`Effect::ALL`].
    pub effects: Vec<(Effect, Work)>,
}

impl ExpectedWork {
    /// What `effect` adds; `None` where it is not simulated.
    #[must_use]
    pub fn of(&self, effect: Effect) -> Option<Work> {
        self.effects.iter().find(|(e, _)| *e == effect).map(|(_, work)| *work)
    }
}

/// Counts the work of the first pass in a small picture with few photons, and scales it to the whole. Pilots are not counted.
#[must_use]
pub fn expected_work(scene: Scene, algorithm: Algorithm, settings: &Settings) -> ExpectedWork {
    let (width, height) = scene.camera().size();
    let (w, h) = reduced(width, height);
    // Pilots would take longer than all that is counted here.
    let settings = settled(&scene, algorithm, &Settings { thinned_pilots: THINNED, ..settings.clone() });
    let scene = scene.resized(w, h);
    let mut small = settings.clone();
    small.eye.samples = settings.eye.samples.map(|n| n.min(SAMPLES));
    let samples = settings.eye.samples.map_or(1.0, |n| f64::from(n) / f64::from(n.min(SAMPLES)));
    let pixels = f64::from(width) * f64::from(height) / (f64::from(w) * f64::from(h));
    let eye = pixels * samples;

    let most = settings.photons.max(settings.caustic_photons);
    let paths = (most / PATHS).clamp(FEWEST_PATHS, MOST_PATHS).min(most);
    let photons = if most > 0 { f64::from(most) / f64::from(paths) } else { 1.0 };
    let fewer = |n: u32| (f64::from(n) / photons).round() as u32;
    (small.photons, small.caustic_photons) = (fewer(settings.photons), fewer(settings.caustic_photons));
    // Fewer photons in wider discs: as many in each. A radius that is not set, the pilot widens likewise.
    small.radius = settings.radius.map(|r| r * photons.sqrt() as f32);

    let whole_and = |without: Option<Effect>| {
        let mut small = small.clone();
        if let Some(effect) = without {
            small.eye.effects = small.eye.effects.without(effect);
        }
        let counters = algorithm.prepare(&scene, small).pass(0, &Silent).counters;
        let Counters { photon_rays, gathered_photons, .. } = counters;
        let of_eye = (counters.rays() - photon_rays) as f64;
        [of_eye * eye + photon_rays as f64 * photons, gathered_photons as f64 * eye]
    };
    let rounded =
        |[rays, gathered]: [f64; 2]| Work { rays: rays.round() as i64, gathered_photons: gathered.round() as i64 };
    let whole = whole_and(None);
    let plan = Plan::new(&scene, algorithm.simulates(), settings.eye.effects);
    let adds = |effect| {
        let without = whole_and(Some(effect));
        (effect, rounded([whole[0] - without[0], whole[1] - without[1]]))
    };
    ExpectedWork { whole: rounded(whole), effects: plan.effects().iter().map(adds).collect() }
}

/// A size of at most [`SIDE`] with about the same ratio of sides.
fn reduced(width: u32, height: u32) -> (u32, u32) {
    let scale = (f64::from(SIDE) / f64::from(width.max(height))).min(1.0);
    let side = |n: u32| ((f64::from(n) * scale).round() as u32).max(1);
    (side(width), side(height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::{glass_on_floor, matt};

    #[test]
    fn small_pictures_keep_their_shape() {
        assert_eq!((reduced(640, 480), reduced(30, 40), reduced(1, 4096)), ((64, 48), (30, 40), (1, 64)));
    }

    /// The camera's own rays are known without counting: one a pixel and sample.
    #[test]
    fn rays_of_the_camera_scale_exactly() {
        let mut settings = Settings::default();
        settings.eye.samples = Some(100);
        let work = expected_work(matt(640, 480), Algorithm::Raycast, &settings);
        assert_eq!(work, ExpectedWork { whole: Work { rays: 640 * 480 * 100, gathered_photons: 0 }, effects: vec![] });
    }

    /// Against the whole pass, of which a quarter of the rays and a sixteenth of the photons was looked at.
    #[test]
    fn what_is_expected_is_what_comes() {
        let settings = Settings { photons: 0, caustic_photons: 100_000, balance: false, ..Settings::default() };
        let (scene, again) = (glass_on_floor(128, 96), glass_on_floor(128, 96));
        let counters = Algorithm::Hybrid.prepare(&scene, settings.clone()).pass(0, &Silent).counters;
        let work = expected_work(again, Algorithm::Hybrid, &settings);
        // 3072 pixels of 8 rays and 6,250 paths are counted; means of tens of thousands are known to a percent or so, but pilots
        // that look at other photons find radii that differ by some percent, and areas by twice that.
        let close = |a: i64, b: u64, within: f64| assert!((a as f64 / b as f64 - 1.0).abs() < within, "{a} {b}");
        close(work.whole.rays, counters.rays(), 0.05);
        close(work.whole.gathered_photons, counters.gathered_photons, 0.2);
        assert!(work.of(Effect::Caustics).unwrap().gathered_photons > 0);
        assert_eq!(work.of(Effect::Environment), None);
    }
}
