//! What a pass is like, found from few points of the film and few photons.

use super::balance::{self, Balance, Part};
use super::maker::PilotBudget;
use super::maps::Maps;
use super::prepared::{Found, Job, Prepared};
use super::{Pass, PhotonReport, Silent};
use crate::color;
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::stats::Counters;
use glam::Vec2;

/// Points of the film.
const POINTS: u32 = 1024;

/// One of so many of a pass's photon paths.
const PILOT_PART: u32 = 16;

impl Prepared<'_> {
    /// How a pass should divide its work; `None` where there are no photons to divide it with. It depends on the scene and the settings
    /// alone.
    pub fn find_balance(&self) -> Option<Balance> {
        if !self.maker.has_photons() {
            return None;
        }
        let key = Key::new(self.eye.seed).purpose(Purpose::Balance);
        let points = |other| self.points(key, other);
        let whole = self.maker.counts;
        let draft = |i| {
            let mut out = Pass::default();
            let draft = PilotBudget { key: key.with(i), pass: 0, part: PILOT_PART, limited: false };
            (self.maker.make_from(&draft, &Silent, &mut out), out)
        };
        let ((mut one, made), (mut other, _)) = (draft(0), draft(1));
        let look = |maps: &Maps<'_>, points: &[(Vec2, Sampler)]| {
            let mut found = Found::default();
            self.walk(maps, 0, Job::Points(points, &mut found));
            found
        };
        let (here, beside) = (points(0), points(1));
        let first = look(&one, &here);
        let second = look(&one, &beside);
        std::mem::swap(&mut one.caustic, &mut other.caustic);
        // What caustics become comes from the paths of the caustic map.
        let shared = self.maker.needs.after_caustic;
        if shared {
            std::mem::swap(&mut one.smooth, &mut other.smooth);
        }
        let by_caustics = look(&one, &here);
        let by_global = if shared { None } else { Some(look(&other, &here)) };
        let light: Vec<f64> = (0..here.len())
            .map(|i| {
                let values = [&first, &second, &by_caustics].map(|f| f64::from(color::mean(f.radiance[i])));
                values.iter().sum::<f64>() / 3.0
            })
            .collect();
        let noise = |other: &Found| balance::noise(&first.radiance, &other.radiance, &light);

        let pixels = self.pixels();
        let points = f64::from(POINTS);
        // Estimates hold more photons the more there are; all that a pass will have, not only the pilot's.
        let gathered = balance::gathering(&first.counters) / points * pixels * f64::from(PILOT_PART);
        let paths = (made.global.emitted + made.caustic.emitted) as f64;
        let part = |noise: f64, report: &PhotonReport, rays: f64, count: u32| {
            let emitted = report.emitted as f64;
            let cost = rays / paths
                + balance::storing(report.stored) / emitted.max(1.0)
                + gathered / (paths * f64::from(PILOT_PART));
            Part { variance: noise * emitted, cost, count: f64::from(count) }
        };
        let rays = made.counters.photon_rays as f64;
        let walking = balance::walking(&first.counters) / points * pixels;
        let camera = Part {
            variance: noise(&second),
            cost: if self.strategy.estimates_each_sample() { walking + gathered } else { walking },
            count: f64::from(self.samples),
        };
        let caustic = part(noise(&by_caustics), &made.caustic, rays, whole.caustic_photons);
        let global = by_global.map_or(0.0, |found| noise(&found));
        let global = part(global, &made.global, rays, whole.photons);
        let [samples, photons, caustic_photons] = balance::divide(&[camera, global, caustic]);
        let paths = |n: f64, emitted: u64| (emitted > 0).then(|| n.round().min(f64::from(u32::MAX)) as u32);
        Some(Balance {
            samples: samples.round().max(1.0) as u32,
            photons: paths(photons, made.global.emitted),
            caustic_photons: paths(caustic_photons, made.caustic.emitted),
        })
    }

    fn pixels(&self) -> f64 {
        let (width, height) = self.scene.camera().size();
        f64::from(width) * f64::from(height)
    }

    /// Points of the film with their random numbers; of two sets with the same key, points of one place are in one pixel.
    fn points(&self, key: Key, set: u64) -> Vec<(Vec2, Sampler)> {
        let (width, height) = self.scene.camera().size();
        let size = Vec2::new(width as f32, height as f32);
        let key = key.purpose(Purpose::Camera);
        let point = |i| {
            let pixel = (Sampler::new(key, i, POINTS).get_2d(Dimension::Film) * size).floor();
            let draw = Sampler::new(key.with(set << 32 | u64::from(i)), 0, 1);
            (pixel + draw.get_2d(Dimension::Film), draw)
        };
        (0..POINTS).map(point).collect()
    }

    /// Counts the work of a pass at few points with few photons.
    pub fn sketch(&self) -> Counters {
        let key = Key::new(self.eye.seed).purpose(Purpose::Balance);
        let mut out = Pass::default();
        let maps =
            self.maker.make_from(&PilotBudget { key, pass: 0, part: PILOT_PART, limited: true }, &Silent, &mut out);
        let mut found = Found::default();
        self.walk(&maps, 0, Job::Points(&self.points(key, 0), &mut found));
        let scaled = |n: u64, by: f64| (n as f64 * by).round() as u64;
        let Counters { continuation_rays, shadow_rays, gathers, gathered_photons, .. } = found.counters;
        let samples = f64::from(self.samples) * self.pixels() / f64::from(POINTS);
        let estimates = if self.strategy.estimates_each_sample() { samples } else { self.pixels() / f64::from(POINTS) };
        let photons = f64::from(PILOT_PART);
        Counters {
            camera_rays: u64::from(self.samples) * self.pixels() as u64,
            continuation_rays: scaled(continuation_rays, samples),
            shadow_rays: scaled(shadow_rays, samples),
            photon_rays: scaled(out.counters.photon_rays, photons),
            gathers: scaled(gathers, estimates),
            gathered_photons: scaled(gathered_photons, estimates * photons),
            rejected_samples: 0,
            rejected_photons: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::camera::Camera;
    use crate::integrate::{Algorithm, Settings};
    use crate::scene::{LightStrength, Material, SceneBuilder, SourceKind};
    use crate::shape::{Plane, Shape, Sphere};
    use glam::{DVec3, Vec3};

    /// `hybrid` has no global map, so its paths cost nothing and change nothing.
    #[test]
    fn what_an_algorithm_does_not_trace_has_no_say() {
        let mut builder = SceneBuilder::new();
        let white = builder.material(Material::diffuse(Vec3::splat(0.7)));
        let glass = builder.material(Material::dielectric(1.5, Vec3::ZERO));
        builder.plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Vec3::ZERO);
        builder.shape(Shape::Sphere(Sphere::new(DVec3::Y, 0.8)), glass, Vec3::ZERO);
        let kind = SourceKind::Point { position: DVec3::new(2.0, 4.0, 1.0) };
        builder.source(kind, LightStrength::Power(Vec3::splat(100.0)));
        let eye =
            Camera::perspective(DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.0, -0.2, -1.0), DVec3::Y, 0.7, 64, 48).unwrap();
        let scene = builder.build(eye).unwrap();
        let balance = |photons| {
            let settings = Settings { photons, caustic_photons: 20_000, ..Settings::default() };
            Algorithm::Hybrid.prepare(&scene, settings).balance().unwrap()
        };
        let found = balance(1);
        assert_eq!((found, found.photons), (balance(4_000_000), None));
        assert!((5000..=80_000).contains(&found.caustic_photons.unwrap()), "{found:?}");
    }
}
