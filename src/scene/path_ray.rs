//! The ray of a camera path or light path, and the loop that traces it to the next vertex.

use super::interiors::exp_neg;
use super::{
    BoundaryContext, BoundaryEvent, CurrentMedium, Effect, Effects, Hit, Interior, RayCone, Scene, SurfaceInteraction,
};
use crate::color::Rgb;
use crate::math::Ray;
use crate::medium::Medium;
use crate::sampling::{Dimension, Key};
use crate::shape::SurfacePoint;
use glam::{DVec3, Vec3};
use rand::RngExt;

/// The ray that continues a camera or light path from its last vertex, with its ray cone and the
/// bodies and media around its origin.
#[derive(Clone, Copy, Debug)]
pub struct PathRay<I> {
    /// The current ray of the path, with a unit direction.
    pub ray: Ray,
    /// The dielectric bodies and media around the origin of the ray.
    pub interior: I,
    /// Ray cone at the origin of the ray. Textures are filtered over its width.
    pub cone: RayCone,
}

/// The part of a path segment that lies in one medium.
#[derive(Clone, Copy, Debug)]
pub struct MediumSegment<'a, I> {
    /// The part of the path segment in the medium, as a ray with a unit direction. `t_max` is its
    /// length, which may be infinite.
    pub ray: Ray,
    /// Index of the medium in [`Scene::media`].
    pub medium_index: u32,
    /// The medium with index `medium_index`.
    pub medium: &'a Medium,
    /// The dielectric bodies and media around this part of the path segment.
    pub interior: I,
    /// Transmittance due to absorption in dielectric bodies, from the last path vertex to the
    /// origin of `ray`.
    pub absorption_transmittance_before: Rgb,
    /// True if the path segment, before the start of `ray`, crosses a
    /// [hidden boundary](super::BoundaryEvent::Hidden), which lies inside a body of higher
    /// priority. Such a boundary would block a shadow ray.
    pub crossed_hidden_boundary: bool,
}

/// The event that ends a path segment.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "an event is returned once for each path segment, never stored")]
pub enum PathEvent<'a> {
    /// The path reaches a surface that scatters or absorbs.
    Surface(SurfaceVertex<'a>),
    /// The path scatters in a medium. The origin of the path ray is the scattering point.
    Scattered {
        /// Transmittance of the path segment due to absorption in dielectric bodies; media are not
        /// included.
        absorption_transmittance: Rgb,
        /// True if the path segment crosses a [hidden boundary](super::BoundaryEvent::Hidden),
        /// which lies inside a body of higher priority. Such a boundary would block a shadow ray.
        crossed_hidden_boundary: bool,
    },
    /// The ray leaves the scene without hitting a surface or scattering.
    Escaped {
        /// True if the path segment crosses a [hidden boundary](super::BoundaryEvent::Hidden),
        /// which lies inside a body of higher priority. Such a boundary would block a shadow ray.
        crossed_hidden_boundary: bool,
    },
}

/// The surface at which a path segment ends.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceVertex<'a> {
    /// The surface at the vertex, with its BSDF and emission.
    pub surface: SurfaceInteraction<'a>,
    /// Transmittance of the path segment due to absorption in dielectric bodies; media are not
    /// included. If this surface is not specular and the path samples a wavelength here, the weight
    /// of the wavelength is multiplied in.
    pub absorption_and_wavelength_weight: Rgb,
    /// Length of the path segment \[length].
    pub distance: f32,
    /// True if the path segment crosses a [hidden boundary](super::BoundaryEvent::Hidden), which
    /// lies inside a body of higher priority. Such a boundary would block a shadow ray.
    pub crossed_hidden_boundary: bool,
}

impl<I: Interior> PathRay<I> {
    /// Traces the ray to the next vertex of the path, and returns the event there.
    ///
    /// The ray passes through null interfaces and hidden boundaries. `key` is the random key of the
    /// next vertex. `sample_scattering` is called, in order, for each part of the path segment that
    /// lies in one medium. It returns the distance \[length] from the start of this part to the
    /// point where the path scatters, or `None` if the path does not scatter in this part.
    #[inline]
    pub fn next_vertex<'a>(
        &mut self,
        scene: &'a Scene,
        key: Key,
        mut sample_scattering: impl FnMut(&MediumSegment<'a, I>) -> Option<f32>,
    ) -> PathEvent<'a> {
        // Sums of optical depths keep digits that products of transmittances near 1 would lose.
        let mut optical_depth = DVec3::ZERO;
        let mut transmittance = Rgb::ONE;
        let mut distance = 0.0;
        let mut crossed_hidden_boundary = false;
        let (mut crossed_boundary_count, mut mix_choice_count) = (0, 0);
        loop {
            // Find the nearest surface along the ray.
            let hit = scene.geometry.intersect(&self.ray);
            let cone = self.cone;
            let mut surface = None;
            if let Some(hit) = &hit {
                self.cone.widen_over_distance(hit.t);
                // Each mix along the segment chooses independently.
                let choose = || {
                    mix_choice_count += 1;
                    key.nth_mix_choice_key(mix_choice_count - 1).uniform_1d(Dimension::Mix)
                };
                let found = scene.surface_interaction(&self.ray, hit, &self.cone, choose);
                self.interior.infer_starting_body(&found);
                surface = Some((found, hit.t));
            }

            // Scatter in the medium before this surface.
            if I::HAS_MEDIA_OR_WAVELENGTH
                && let Some((index, ray, from)) =
                    clip_ray_to_medium(scene, &self.ray, hit.map_or(f32::INFINITY, |hit| hit.t), &self.interior)
            {
                let (medium, interior) = (&scene.media[index as usize], self.interior);
                let segment = MediumSegment {
                    ray,
                    medium_index: index,
                    medium,
                    interior,
                    absorption_transmittance_before: transmittance,
                    crossed_hidden_boundary,
                };
                if let Some(t) = sample_scattering(&segment) {
                    self.ray = Ray::new(ray.at(t), ray.direction);
                    self.cone = cone;
                    self.cone.widen_over_distance(from + t);
                    return PathEvent::Scattered { absorption_transmittance: transmittance, crossed_hidden_boundary };
                }
            }

            // Escape if there is no surface, else absorb along the segment.
            let Some((surface, t)) = &mut surface else { return PathEvent::Escaped { crossed_hidden_boundary } };
            distance += *t;
            let segment_depth = self.interior.absorption_optical_depth(scene, *t);
            if segment_depth != Rgb::ZERO {
                optical_depth += segment_depth.as_dvec3();
                transmittance = exp_neg(optical_depth.as_vec3());
            }

            // Stop if the surface scatters or absorbs.
            let context = BoundaryContext { key, crossed_boundary_count, cone: self.cone };
            match self.interior.resolve_boundary(scene, surface, &context) {
                BoundaryEvent::Surface => {
                    transmittance *= self.interior.wavelength_weight_before_scattering(surface);
                    return PathEvent::Surface(SurfaceVertex {
                        surface: *surface,
                        absorption_and_wavelength_weight: transmittance,
                        distance,
                        crossed_hidden_boundary,
                    });
                }
                BoundaryEvent::Hidden => crossed_hidden_boundary = true,
                BoundaryEvent::NullInterface => {}
            }

            // Pass through a boundary that does not scatter.
            self.ray = surface.spawn_ray(self.ray.direction);
            self.interior.cross_boundary(surface, self.ray.direction);
            crossed_boundary_count += 1;
        }
    }

    /// Continues the path from `surface` in unit `direction`; `transmitted` is true if the path
    /// crosses the surface.
    ///
    /// Returns the factor on the path throughput. If the path sampled a wavelength at this surface,
    /// it is the weight of that wavelength, or a factor with which a reflected path continues with
    /// all wavelengths. Otherwise it is 1.
    #[inline]
    pub fn leave_surface_with_wavelength_weight(
        &mut self,
        surface: &SurfaceInteraction<'_>,
        direction: Vec3,
        transmitted: bool,
    ) -> Rgb {
        self.ray = surface.spawn_ray(direction);
        self.cone.widen_at_surface(&surface.bsdf);
        if transmitted {
            self.interior.cross_boundary(surface, direction);
        }
        self.interior.wavelength_weight_after_scattering(surface, transmitted)
    }

    /// Continues the path in unit `direction` after a scattering event in a medium. The event is at
    /// the origin of the ray.
    #[inline]
    pub fn scatter_towards(&mut self, direction: Vec3) {
        self.ray = Ray::new(self.ray.origin, direction);
        self.cone.widen_in_medium();
    }
}

/// Estimates the transmittance of a shadow ray: see [`Scene::shadow_transmittance`].
pub(super) fn shadow_transmittance<I: Interior>(
    scene: &Scene,
    ray: &Ray,
    mut interior: I,
    effects: Effects,
    key: Key,
) -> Rgb {
    let target = ray.at(ray.t_max);
    let ends = ray.t_max.is_finite();
    let (mut optical_depth, mut media_transmittance) = (DVec3::ZERO, DVec3::ONE);
    let mut sheet_transmittance = Rgb::ONE;
    let mut ray = *ray;
    let mut rng = key.rng();
    let mut context = BoundaryContext { key, crossed_boundary_count: 0, cone: RayCone::zero_width_cone(effects) };
    loop {
        let length = ray.direction.length();
        let unit = Ray::new(ray.origin, ray.direction / length);
        let hit = scene.geometry.intersect(&ray).map(|hit| Hit { t: hit.t * length, ..hit });
        let mut surface = None;
        if let Some(hit) = &hit {
            let found = scene.surface_interaction(&unit, hit, &context.cone, || rng.random());
            interior.infer_starting_body(&found);
            surface = Some(found);
        }
        let distance = hit.map_or(ray.t_max * length, |hit| hit.t);
        optical_depth += interior.absorption_optical_depth(scene, finite_or_zero(distance)).as_dvec3();
        if let Some((index, part, _)) = clip_ray_to_medium(scene, &unit, distance, &interior) {
            media_transmittance *= scene.media[index as usize].transmittance_f64(&part, part.t_max, &mut rng);
        }
        let transmittance = exp_neg(optical_depth.as_vec3()) * media_transmittance.as_vec3() * sheet_transmittance;
        let Some(mut surface) = surface else { return transmittance };
        if transmittance == Rgb::ZERO {
            return Rgb::ZERO;
        }
        match interior.resolve_boundary(scene, &mut surface, &context) {
            BoundaryEvent::NullInterface => {}
            BoundaryEvent::Hidden => return Rgb::ZERO,
            BoundaryEvent::Surface => {
                let SurfacePoint { ns, ng, .. } = surface.point;
                match surface.bsdf.straight_transmittance(surface.wo, ns, ng) {
                    Some(sheet) if effects.has(Effect::Specular) => sheet_transmittance *= sheet,
                    Some(_) | None => return Rgb::ZERO,
                }
            }
        }
        ray = if ends { surface.spawn_ray_to(target, unit.direction) } else { surface.spawn_ray(unit.direction) };
        interior.cross_boundary(&surface, unit.direction);
        context.crossed_boundary_count += 1;
    }
}

/// Estimates the transmittance of `ray` through bodies and media, ignoring surfaces: see
/// [`Scene::interior_transmittance`].
#[inline]
pub(super) fn interior_transmittance<I: Interior>(scene: &Scene, ray: &Ray, interior: &I, key: Key) -> Rgb {
    let bodies = interior.absorption_transmittance(scene, finite_or_zero(ray.t_max));
    match clip_ray_to_medium(scene, ray, ray.t_max, interior) {
        Some((index, part, _)) => bodies * scene.media[index as usize].transmittance(&part, part.t_max, &mut key.rng()),
        None => bodies,
    }
}

/// Finds the part of `ray` that lies in the medium around its origin, up to distance `end`; `None`
/// outside of media.
///
/// Returns the index of the medium, the part as a ray, and the distance \[length] from the ray's
/// origin to the part. `ray` must have a unit direction.
#[inline]
fn clip_ray_to_medium<I: Interior>(scene: &Scene, ray: &Ray, end: f32, interior: &I) -> Option<(u32, Ray, f32)> {
    let CurrentMedium { medium_index: medium, ambient } = interior.current_medium(scene)?;
    let whole = Ray { t_max: end, ..*ray };
    if !ambient {
        return Some((medium, whole, 0.0));
    }
    let extent = scene.derived.ambient_medium_sphere;
    let (o, d) = ((ray.origin - extent.center).as_dvec3(), ray.direction.as_dvec3());
    let radius = f64::from(extent.radius);
    let middle = -o.dot(d);
    let half = (radius * radius - (o + d * middle).length_squared()).sqrt();
    // `half` is NaN if the ray misses the ball, so the comparison below must be false for NaN.
    let (from, to) = ((middle - half).max(0.0) as f32, ((middle + half) as f32).min(end));
    if !(half > 0.0 && from < to) {
        return None;
    }
    let part = if from > 0.0 { Ray { origin: ray.at(from), ..whole } } else { whole };
    Some((medium, Ray { t_max: to - from, ..part }, from))
}

/// Returns `distance` if it is finite, else 0.
///
/// A ray that never leaves a dielectric body entered it through a boundary that is not closed. With
/// distance 0 instead of an infinite distance, this body absorbs nothing.
fn finite_or_zero(distance: f32) -> f32 {
    if distance.is_finite() { distance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::sampling::Purpose;
    use crate::scene::{Body, InteriorStack, Material, SceneBuilder};
    use crate::shape::{Rectangle, Shape, Sphere};

    /// Each of two faces inside a glass of higher priority absorbs the path with probability p. The
    /// path passes both with probability (1 − p)².
    ///
    /// The standard error over 4096 random keys is 0.0078. The tolerance is 5.5 times as large.
    #[test]
    fn mixes_at_hidden_boundaries_choose_independently() {
        const COUNT: u64 = 4096;
        let absorption_probability = 0.3;
        let mut builder = SceneBuilder::new();
        let around = builder.add_material(Material::smooth_boundary(Body { priority: 1, ..Body::new(1.5) }));
        let hidden = builder.add_material(Material::dielectric(1.3, Rgb::ZERO));
        let black = builder.add_material(Material::black());
        let mix = builder.add_material(Material::mix(hidden, black, absorption_probability));
        builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 10.0)), around, Rgb::ZERO);
        for x in [1.0, 2.0] {
            let face = Rectangle::new(DVec3::new(x, -1.0, -1.0), DVec3::Z * 2.0, DVec3::Y * 2.0);
            builder.add_shape(Shape::Rectangle(face), mix, Rgb::ZERO);
        }
        let scene = builder.build(Camera::perspective(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0, 1, 1).unwrap()).unwrap();
        let key = Key::new(1).purpose_key(Purpose::Test);
        let passes = |i: &u64| {
            let ray = Ray::new(scene.camera().center().as_vec3(), Vec3::X);
            let mut path = scene.start_camera_path::<InteriorStack>(ray, Effects::NONE);
            match path.next_vertex(&scene, key.child_key(*i), |_| None) {
                PathEvent::Surface(vertex) => vertex.distance > 5.0,
                PathEvent::Scattered { .. } | PathEvent::Escaped { .. } => false,
            }
        };
        let share = (0..COUNT).filter(passes).count() as f64 / COUNT as f64;
        let pass_probability = 1.0 - f64::from(absorption_probability);
        let expected = pass_probability * pass_probability;
        assert!((share - expected).abs() < 0.043, "{share}");
    }
}
