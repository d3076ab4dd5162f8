//! Scene features that determine the plan, found without tracing rays.

use crate::color::Rgb;
use crate::light::Light;
use crate::math::BoundingSphere;
use crate::scene::{ObjectSummary, Scene};
use glam::Vec3;

/// Features of a scene that determine which effects of light a render needs.
///
/// If a feature cannot be determined with certainty, it has the value with which more effects are
/// simulated, so that no light is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SceneFeatures {
    /// Number of shapes, meshes and planes with a material.
    pub objects: usize,
    /// Number of objects that are [receivers](crate::photon::PhotonKind): objects that store
    /// photons, such as diffuse walls.
    pub receivers: usize,
    /// Number of receivers (objects that store photons) that are not black.
    pub scattering_receivers: usize,
    /// Number of caustic casters, such as mirrors and glass: see
    /// [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
    pub casters: usize,
    /// Number of caustic casters, such as mirrors and glass, that a light may reach on a straight
    /// path.
    pub lit_casters: usize,
    /// Number of objects with an interior that light enters, such as glass.
    pub bodies: usize,
    /// Number of objects of dispersive glass.
    #[serde(rename = "dispersive")]
    pub dispersive_objects: usize,
    /// Number of media that scatter, absorb or emit.
    pub media: usize,
    /// Number of media that scatter.
    pub scattering_media: usize,
    /// Number of media that emit.
    pub emitting_media: usize,
    /// True if a medium fills the space outside all objects.
    #[serde(rename = "filled")]
    pub has_ambient_medium: bool,
    /// True if the background is not black. The background is visible to the camera and lights
    /// nothing.
    #[serde(rename = "background")]
    pub has_background: bool,
    /// Number of objects with a texture of a material parameter or of emission.
    #[serde(rename = "textured")]
    pub textured_objects: usize,
    /// Number of objects with bump or normal maps.
    #[serde(rename = "bump_mapped")]
    pub bump_mapped_objects: usize,
    /// Number of lights with power.
    pub lights: usize,
    /// Number of lights with power that are not delta lights.
    pub soft_lights: usize,
    /// True if the scene has an environment light.
    #[serde(rename = "environment")]
    pub has_environment_light: bool,
    /// True if the camera has a lens; false for a pinhole camera.
    #[serde(rename = "lens")]
    pub has_lens: bool,
    /// True if an object or the camera moves while the shutter is open.
    #[serde(rename = "moving")]
    pub has_motion: bool,
    /// True if the scene is one flat object at rest, without media, and no light emits within its
    /// plane.
    ///
    /// The object can then neither shadow nor light itself. False if an area light or an
    /// environment light has power.
    #[serde(rename = "one_flat_object")]
    pub is_one_flat_object: bool,
}

impl SceneFeatures {
    /// Returns the features of `scene`.
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
            dispersive_objects: 0,
            media: 0,
            scattering_media: 0,
            emitting_media: 0,
            has_ambient_medium: scene.ambient_medium().is_some(),
            has_background: scene.background() != Rgb::ZERO,
            textured_objects: 0,
            bump_mapped_objects: 0,
            lights: 0,
            soft_lights: 0,
            has_environment_light: scene.environment_light_index().is_some(),
            has_lens: scene.camera().lens().is_some(),
            has_motion: scene.has_motion(),
            is_one_flat_object: false,
        };
        // In a scene of infinite planes, the bounding sphere may be a point. For this sphere,
        // lights at infinity would have the power 0, although they light the planes. So compute
        // powers for a unit sphere.
        let domain = BoundingSphere { center: Vec3::ZERO, radius: 1.0 };
        let lights: Vec<&Light> = scene.lights().iter().filter(|l| l.power(domain) != Rgb::ZERO).collect();
        features.lights = lights.len();
        let media = scene.media_in_use();
        features.media = media.iter().filter(|medium| !medium.is_empty()).count();
        features.scattering_media = media.iter().filter(|medium| medium.scatters()).count();
        features.emitting_media = media.iter().filter(|medium| medium.emits()).count();
        // A moving object lies in different planes at different times, so it does not count as
        // flat.
        if let [ObjectSummary { plane: Some((p, n)), .. }] = objects[..]
            && !features.has_motion
            && features.media == 0
        {
            features.is_one_flat_object = lights.iter().all(|light| light.emits_no_ray_within_plane(p, n));
        }
        features.soft_lights = lights.iter().filter(|l| !l.is_delta()).count();
        for object in &objects {
            let (mut receives, mut scatters, mut casts, mut bounds_body, mut disperses) =
                (false, false, false, false, false);
            scene.for_each_leaf_material(object.material, &mut |leaf| {
                casts |= leaf.casts_caustics();
                if let Some(body) = leaf.enclosed_body {
                    bounds_body = true;
                    disperses |= body.dispersion_formula.is_some();
                } else if leaf.bsdf.stores_photons() {
                    receives = true;
                    scatters |= !leaf.bsdf.is_black();
                }
            });
            let sphere = object.bounding_sphere.filter(|_| !features.has_motion);
            let reached = || lights.iter().any(|light| light.may_illuminate(sphere, scene.photon_domain()));
            let (textured, bumpy) = scene.material_texture_usage(object.material);
            features.textured_objects += usize::from(textured || object.has_emission_texture);
            features.bump_mapped_objects += usize::from(bumpy);
            features.receivers += usize::from(receives);
            features.scattering_receivers += usize::from(scatters);
            features.casters += usize::from(casts);
            features.lit_casters += usize::from(casts && reached());
            features.bodies += usize::from(bounds_body);
            features.dispersive_objects += usize::from(disperses);
        }
        features
    }
}
