use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::photon::{Bandwidth, Kernel, Photon, PhotonMap, VisiblePoint};
use crate::scene::{InteriorStack, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use crate::shape::{Rectangle, Shape, Sphere};
use glam::{DVec3, Vec2, Vec3};

/// A scene with a floor of 16 × 16, a wall behind it, and the lamps that `lamps` adds to the
/// builder.
fn scene_with_lamps(lamps: impl FnOnce(&mut SceneBuilder)) -> Scene {
    let mut builder = SceneBuilder::new();
    let grey = builder.add_material(Material::diffuse(Rgb::splat(0.5)));
    let (x, y, z) = (DVec3::X * 16.0, DVec3::Y * 7.0, DVec3::Z * 16.0);
    builder.add_shape(Shape::Rectangle(Rectangle::new(DVec3::new(-8.0, 0.0, -8.0), z, x)), grey, Rgb::ZERO);
    builder.add_shape(Shape::Rectangle(Rectangle::new(DVec3::new(-8.0, 0.0, -8.0), x, y)), grey, Rgb::ZERO);
    lamps(&mut builder);
    builder.build(Camera::perspective(DVec3::Y, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap()).unwrap()
}

const LAMP: DVec3 = DVec3::new(0.0, 6.0, 0.0);

fn delta_light_scene(kind: UnscaledDeltaLight) -> Scene {
    scene_with_lamps(|b| {
        b.add_delta_light(kind, LightStrength::Physical(Rgb::new(1.0, 2.0, 3.0)));
    })
}

fn spot_light_scene() -> Scene {
    delta_light_scene(UnscaledDeltaLight::Spot { position: LAMP, axis: DVec3::NEG_Y, inner: 1.1, outer: 1.15 })
}

fn area_light_scene(shape: Shape) -> Scene {
    scene_with_lamps(|b| {
        let black = b.add_material(Material::diffuse(Rgb::ZERO));
        b.add_shape(shape, black, Rgb::new(1.0, 2.0, 3.0));
    })
}

fn square_light_scene() -> Scene {
    area_light_scene(Shape::Rectangle(Rectangle::new(LAMP, DVec3::X, DVec3::Z)))
}

/// One scene for each kind of light, with the name of the kind.
fn scenes_by_lamp_kind() -> [(&'static str, Scene); 5] {
    [
        ("point", delta_light_scene(UnscaledDeltaLight::Point { position: LAMP })),
        ("spot", spot_light_scene()),
        ("directional", delta_light_scene(UnscaledDeltaLight::Directional { direction: DVec3::new(0.3, -1.0, 0.1) })),
        ("square", square_light_scene()),
        ("ball", area_light_scene(Shape::Sphere(Sphere::new(LAMP, 0.4)))),
    ]
}

/// Converts a position of the scene description to the frame of the built scene.
fn to_scene_frame(scene: &Scene, p: DVec3) -> Vec3 {
    (p - scene.origin()).as_vec3()
}

/// A lattice of 40 × 40 points over the corner \[6, 8]² of the floor. Tests count only this corner
/// as visible.
fn floor_corner_points(scene: &Scene) -> impl Iterator<Item = Vec3> {
    let at = |i: u32| 6.025 + 0.05 * f64::from(i);
    let points: Vec<Vec3> =
        (0..40 * 40).map(|i| to_scene_frame(scene, DVec3::new(at(i % 40), 0.0, at(i / 40)))).collect();
    points.into_iter()
}

fn floor_corner_point_map(scene: &Scene) -> VisiblePointMap {
    VisiblePointMap::new(
        floor_corner_points(scene).map(|position| VisiblePoint {
            position,
            position_error: Vec3::ZERO,
            normal: Vec3::Y,
            weight: 1.0,
        }),
        0.1,
    )
}

const MASK: StoreMask = StoreMask::ALL;
const BOUNCES: u32 = 2;

fn source_guided_to_visible<'a>(
    scene: &'a Scene,
    visible: &VisiblePointMap,
) -> (PhotonSource<'a>, EmissionGuidingReport) {
    let pilot = EmissionGuidingPilotSettings {
        mask: MASK,
        max_bounces: BOUNCES,
        visible_points: visible,
        paths: 1 << 16,
        seed: 11,
    };
    PhotonSource::emitting_in_all_directions(scene).unwrap().with_guided_emission(&pilot)
}

fn photon_tracer_of_source<'a>(scene: &'a Scene, source: &'a PhotonSource<'a>) -> PhotonTracer<'a> {
    PhotonTracer { scene, source, mask: MASK, max_bounces: BOUNCES }
}

fn pass_key(pass: u64) -> Key {
    Key::new(5).purpose_key(Purpose::Test).child_key(pass)
}

/// Running sums over passes, from which mean and variance of a pass's result follow.
#[derive(Clone, Copy, Default)]
struct PassStatistics {
    n: f64,
    sum: f64,
    squares: f64,
}

impl PassStatistics {
    fn add(&mut self, x: f64) {
        (self.n, self.sum, self.squares) = (self.n + 1.0, self.sum + x, self.squares + x * x);
    }

    fn mean(&self) -> f64 {
        self.sum / self.n
    }

    /// Sample variance of the result of one pass.
    fn variance(&self) -> f64 {
        ((self.squares / self.n - self.mean() * self.mean()) * self.n / (self.n - 1.0)).max(0.0)
    }

    fn agrees_within_five_sigma(&self, other: &Self) -> bool {
        // If neither result has variance, the means may still differ by the rounding of the sums.
        let rounding = 1e-5 * self.mean().abs();
        (self.mean() - other.mean()).abs()
            <= 5.0 * (self.variance() / self.n + other.variance() / other.n).sqrt() + rounding
    }
}

/// Statistics over 32 passes of four fluxes \[W]: stored on the visible corner, stored on the rest
/// of the floor, stored on the wall, and emitted.
fn fluxes_by_region(scene: &Scene, source: &PhotonSource<'_>) -> [PassStatistics; 4] {
    let floor = to_scene_frame(scene, DVec3::ZERO).y;
    let edge = to_scene_frame(scene, DVec3::new(6.0, 0.0, 6.0));
    let mut means = [PassStatistics::default(); 4];
    for i in 0..32 {
        let traced = photon_tracer_of_source(scene, source).trace(pass_key(i), 8192, &|_| {});
        let mut flux = [0.0; 3];
        for Photon { position: p, attributes: f } in &traced.deposits.surface_photons {
            let region = if (p.y - floor).abs() > 1e-3 { 2 } else { usize::from(p.x < edge.x || p.z < edge.z) };
            flux[region] += f64::from(color::channel_mean(f.flux()));
        }
        let emitted = traced.audit.emitted.iter().sum::<f64>() / 3.0;
        means.iter_mut().zip(flux.into_iter().chain([emitted])).for_each(|(mean, x)| mean.add(x));
    }
    means
}

/// Sum of the squared fluxes \[W²] of the photons on the visible corner in eight passes. The
/// variance of photon estimates there is proportional to it, if the paths are independent.
fn squared_flux_on_corner(scene: &Scene, source: &PhotonSource<'_>) -> f64 {
    let floor = to_scene_frame(scene, DVec3::ZERO).y;
    let edge = to_scene_frame(scene, DVec3::new(6.0, 0.0, 6.0));
    let is_visible = |p: Vec3| (p.y - floor).abs() <= 1e-3 && p.x >= edge.x && p.z >= edge.z;
    let squared_flux = |pass| {
        let traced = photon_tracer_of_source(scene, source).trace(pass_key(pass), 8192, &|_| {});
        let photons = traced.deposits.surface_photons.iter().filter(|photon| is_visible(photon.position));
        let flux = photons.map(|photon| f64::from(color::channel_mean(photon.attributes.flux())));
        flux.map(|flux| flux * flux).sum::<f64>()
    };
    (0..8).map(squared_flux).sum()
}

/// Guided and unguided fluxes of 32 passes agree within five standard errors. The 25 comparisons
/// have a false alarm rate of 1.4·10⁻⁵.
#[test]
fn guiding_is_unbiased() {
    for (name, scene) in scenes_by_lamp_kind() {
        let plain = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let (guided, report) = source_guided_to_visible(&scene, &floor_corner_point_map(&scene));
        assert!(
            report.contributing_fraction > 0.0 && report.variance_gain > 1.0,
            "{name} has something to learn: {report:?}"
        );
        let (before, after) = (fluxes_by_region(&scene, &plain), fluxes_by_region(&scene, &guided));
        for (region, (a, b)) in before.iter().zip(&after).enumerate() {
            assert!(a.mean() > 0.0);
            assert!(a.agrees_within_five_sigma(b), "{name}, region {region}: {} became {}", a.mean(), b.mean());
        }
        let power = f64::from(color::channel_mean(scene.lights()[0].power(scene.photon_domain())));
        let mut given = PassStatistics::default();
        [power; 2].iter().for_each(|p| given.add(*p));
        assert!(after[3].agrees_within_five_sigma(&given), "{name} emits {} of {power}", after[3].mean());
        let (before, after) = (squared_flux_on_corner(&scene, &plain), squared_flux_on_corner(&scene, &guided));
        assert!(after < 0.5 * before, "{name} gained nothing where it is seen: {before} became {after}");
    }
}

/// A source aimed at glass balls sends the same flux to the visible corner with and without
/// guiding.
///
/// One ball is above the corner, another far away.
#[test]
fn aiming_and_guiding_together_are_unbiased() {
    let scene = scene_with_lamps(|b| {
        let glass = b.add_material(Material::dielectric(1.5, Rgb::ZERO));
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(6.5, 1.2, 6.5), 0.8)), glass, Rgb::ZERO);
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(-6.5, 1.2, -5.5), 1.2)), glass, Rgb::ZERO);
        b.add_delta_light(UnscaledDeltaLight::Point { position: LAMP }, LightStrength::Physical(Rgb::ONE));
    });
    let visible = floor_corner_point_map(&scene);
    let pilot = EmissionGuidingPilotSettings {
        mask: StoreMask::CAUSTIC,
        max_bounces: 20,
        visible_points: &visible,
        paths: 1 << 15,
        seed: 1,
    };
    let plain = PhotonSource::aimed_at_casters(&scene).unwrap();
    let (guided, report) = PhotonSource::aimed_at_casters(&scene).unwrap().with_guided_emission(&pilot);
    let flux = |source: &PhotonSource<'_>| {
        let tracer = PhotonTracer { scene: &scene, source, mask: StoreMask::CAUSTIC, max_bounces: 20 };
        let corner = to_scene_frame(&scene, DVec3::new(6.0, 0.5, 6.0));
        let (mut seen, mut emitted) = (PassStatistics::default(), PassStatistics::default());
        for i in 0..32 {
            let traced = tracer.trace(pass_key(i), 4096, &|_| {});
            let there =
                traced.deposits.surface_photons.iter().filter(|p| p.position.x > corner.x && p.position.z > corner.z);
            seen.add(there.map(|p| f64::from(color::channel_mean(p.attributes.flux()))).sum());
            emitted.add(traced.audit.emitted[0]);
        }
        (seen, emitted)
    };
    let (before, after) = (flux(&plain), flux(&guided));
    assert!(
        before.0.mean() > 0.0 && before.0.agrees_within_five_sigma(&after.0),
        "{} became {}",
        before.0.mean(),
        after.0.mean()
    );
    assert!(before.1.agrees_within_five_sigma(&after.1), "emitted {} became {}", before.1.mean(), after.1.mean());
    assert!(report.variance_gain > 1.2, "{report:?}");
}

/// Guiding reduces the variance on the visible corner at least 7.5 times.
///
/// The corner receives 0.6 % of the unguided photons, and at least 20 % of the guided ones, a
/// factor of 30. With eight seeds, the measured ratios of the variances are 13 to 54.
#[test]
fn guiding_reduces_visible_variance() {
    let scene = spot_light_scene();
    let (guided, _) = source_guided_to_visible(&scene, &floor_corner_point_map(&scene));
    let plain = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let variance = |source: &PhotonSource<'_>| {
        let mut means = vec![PassStatistics::default(); 1600];
        for i in 0..24 {
            let map = PhotonMap::build(
                photon_tracer_of_source(&scene, source).trace(pass_key(i), 16384, &|_| {}).deposits.surface_photons,
            );
            let mut scratch = PhotonSearchBuffers::default();
            for (p, mean) in floor_corner_points(&scene).zip(&mut means) {
                let wide = Bandwidth { radius: 0.1, k: 0 };
                let estimate = map.estimate_radiance(p, Vec3::Y, wide, Kernel::Box, &mut scratch, |_| Rgb::ONE);
                mean.add(f64::from(color::channel_mean(estimate.radiance)));
            }
        }
        means.iter().map(PassStatistics::variance).sum::<f64>()
    };
    let ratio = variance(&plain) / variance(&guided);
    assert!(ratio > 7.5, "{ratio}");
}

/// Guiding emits more paths from the visible lamp than from a lamp behind the wall.
#[test]
fn guiding_prefers_the_visible_lamp() {
    let scene = scene_with_lamps(|b| {
        let strength = LightStrength::Power(Rgb::ONE);
        b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::new(0.0, 3.0, -12.0) }, strength);
        b.add_delta_light(UnscaledDeltaLight::Point { position: LAMP }, strength);
    });
    let (guided, _) = source_guided_to_visible(&scene, &floor_corner_point_map(&scene));
    let share = guided.light_distribution.probability(1);
    assert!((share - (1.0 - 0.5 * DEFENSIVE_FRACTION as f32)).abs() < 1e-6, "{share}");
}

/// The guided pdf of primary samples is at least [`DEFENSIVE_FRACTION`] everywhere; the unguided
/// pdf is 1.
#[test]
fn guided_pdf_has_a_lower_bound() {
    for (name, scene) in scenes_by_lamp_kind() {
        let (guided, _) = source_guided_to_visible(&scene, &floor_corner_point_map(&scene));
        let density = guided.guiding[0].as_ref().unwrap();
        let mut least = f32::INFINITY;
        for i in 0..1u32 << 16 {
            let at = |shift: u32| (f32::from((i >> shift & 15) as u8) + 0.5) / 16.0;
            least = least.min(density.pdf(Vec2::new(at(0), at(4)), Vec2::new(at(8), at(12))));
        }
        assert!(least > 0.99 * DEFENSIVE_FRACTION as f32, "{name}: {least}");
    }
}

#[test]
fn pilot_without_useful_photons_leaves_source_unguided() {
    for (name, scene) in scenes_by_lamp_kind() {
        let below = floor_corner_points(&scene).map(|position| VisiblePoint {
            position,
            position_error: Vec3::ZERO,
            normal: Vec3::NEG_Y,
            weight: 1.0,
        });
        for visible in [VisiblePointMap::new(below, 0.1), VisiblePointMap::new([], 0.1)] {
            let (guided, report) = source_guided_to_visible(&scene, &visible);
            assert_eq!((report.contributing_fraction, report.variance_gain), (0.0, 1.0), "{name}");
            let plain = PhotonSource::emitting_in_all_directions(&scene).unwrap();
            for i in 0..1000 {
                let bits = |s: &PhotonSource<'_>| {
                    s.emit_photon_path::<InteriorStack>(pass_key(1), i, 1000).map(|(w, f)| (w.ray, f))
                };
                assert_eq!(bits(&guided), bits(&plain), "{name}");
            }
        }
    }
}

#[test]
fn guiding_is_deterministic() {
    let scene = square_light_scene();
    let visible = floor_corner_point_map(&scene);
    let emissions = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let pilot = EmissionGuidingPilotSettings {
                mask: MASK,
                max_bounces: BOUNCES,
                visible_points: &visible,
                paths: 1 << 15,
                seed,
            };
            let (source, report) =
                PhotonSource::emitting_in_all_directions(&scene).unwrap().with_guided_emission(&pilot);
            let emit = |i| source.emit_photon_path::<InteriorStack>(pass_key(0), i, 1000).map(|(w, f)| (w.ray, f));
            (report, (0..1000).map(emit).collect::<Vec<_>>())
        })
    };
    let one = emissions(1, 3);
    assert_eq!(one, emissions(2, 3));
    assert_eq!(one, emissions(7, 3));
    assert_ne!(one, emissions(1, 4));
}
