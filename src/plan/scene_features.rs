//! Features of a scene that are certain without tracing a ray.

use crate::color::Rgb;
use crate::light::Light;
use crate::math::BoundingSphere;
use crate::scene::{ObjectSummary, Scene};
use glam::Vec3;

/// Features of a scene, as counts. An uncertain feature has the value that keeps its effect on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SceneFeatures {
    /// Shapes, meshes and planes with a material.
    pub objects: usize,
    /// Objects that store photons: see [`Bsdf::stores_photons`](crate::bsdf::Bsdf::stores_photons).
    pub receivers: usize,
    /// Receivers that reflect or transmit some light.
    pub scattering_receivers: usize,
    /// Caustic casters: see [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
    pub casters: usize,
    /// Casters that a light may reach directly.
    pub lit_casters: usize,
    /// Objects that bound a body which light enters.
    pub bodies: usize,
    /// Bodies of dispersive glass.
    pub dispersive: usize,
    /// Media with any coefficient above zero, in bodies or around the scene.
    pub media: usize,
    /// Media that scatter.
    pub scattering_media: usize,
    /// Media that emit.
    pub emitting_media: usize,
    /// True if a medium fills the space outside all bodies.
    pub filled: bool,
    /// True if a background is visible. It lights nothing.
    pub background: bool,
    /// Objects with textures.
    pub textured: usize,
    /// Objects with bump or normal maps.
    pub bump_mapped: usize,
    /// Lights with power.
    pub lights: usize,
    /// Lights with an extent.
    pub soft_lights: usize,
    /// True if the scene has an environment light.
    pub environment: bool,
    /// True if the camera has a lens.
    pub lens: bool,
    /// True if anything moves while the shutter is open.
    pub moving: bool,
    /// True if nothing can occlude: the scene is one flat object, and no light lies in its plane.
    pub one_flat_object: bool,
}

impl SceneFeatures {
    /// Features of `scene`.
    #[must_use]
    pub fn from_scene(scene: &Scene) -> Self {
        let objects: Vec<ObjectSummary> = scene.object_summaries().collect();
        let mut features = Self {
            objects: objects.len(),
            receivers: 0,
            scattering_receivers: 0,
            casters: 0,
            lit_casters: 0,
            bodies: 0,
            dispersive: 0,
            media: 0,
            scattering_media: 0,
            emitting_media: 0,
            filled: scene.ambient_medium().is_some(),
            background: scene.background() != Rgb::ZERO,
            textured: 0,
            bump_mapped: 0,
            lights: 0,
            soft_lights: 0,
            environment: scene.environment().is_some(),
            lens: scene.camera().lens().is_some(),
            moving: scene.has_motion(),
            one_flat_object: false,
        };
        // The domain of a scene of planes alone is a point. Light from infinity has no power there,
        // but it still lights.
        let domain = BoundingSphere { center: Vec3::ZERO, radius: 1.0 };
        let lights: Vec<&Light> = scene.lights().iter().filter(|l| l.power(domain) != Rgb::ZERO).collect();
        features.lights = lights.len();
        let media = scene.media_in_use();
        features.media = media.iter().filter(|medium| !medium.is_empty()).count();
        features.scattering_media = media.iter().filter(|medium| medium.scatters()).count();
        features.emitting_media = media.iter().filter(|medium| medium.emits()).count();
        // A moving object has another plane at another time.
        if let [ObjectSummary { plane: Some((p, n)), .. }] = objects[..]
            && !features.moving
            && features.media == 0
        {
            features.one_flat_object = lights.iter().all(|light| light.emits_nothing_in_plane(p, n));
        }
        features.soft_lights = lights.iter().filter(|l| !l.is_delta()).count();
        for object in &objects {
            let (mut receives, mut scatters, mut casts, mut bounds, mut parts) = (false, false, false, false, false);
            scene.for_each_leaf_material(object.material, &mut |leaf| {
                casts |= leaf.casts_caustics();
                if let Some(body) = leaf.bounded_body {
                    bounds = true;
                    parts |= body.glass.is_some();
                } else if leaf.bsdf.stores_photons() {
                    receives = true;
                    scatters |= !leaf.bsdf.is_black();
                }
            });
            let ball = object.ball.filter(|_| !features.moving);
            let reached = || lights.iter().any(|light| light.may_illuminate(ball, scene.photon_domain()));
            let (textured, bumpy) = scene.texture_usage(object.material);
            features.textured += usize::from(textured || object.has_emission_texture);
            features.bump_mapped += usize::from(bumpy);
            features.receivers += usize::from(receives);
            features.scattering_receivers += usize::from(scatters);
            features.casters += usize::from(casts);
            features.lit_casters += usize::from(casts && reached());
            features.bodies += usize::from(bounds);
            features.dispersive += usize::from(parts);
        }
        features
    }
}
