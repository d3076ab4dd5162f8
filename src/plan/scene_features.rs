//! What a scene holds, as far as it is certain without tracing a ray.

use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::light::Light;
use crate::math::Sphere;
use crate::scene::{Object, Scattering, Scene};
use glam::Vec3;

/// What decisions rest on. Where something is not certain, the fact is what keeps an effect on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SceneFeatures {
    /// Things that are made of something: shapes, meshes, planes.
    pub objects: usize,
    /// Of them, those that store photons.
    pub receivers: usize,
    /// Of the receivers, those that send some light on.
    pub scattering_receivers: usize,
    /// Mirrors, glass, smooth metal.
    pub casters: usize,
    /// Of them, those that a light may reach without a detour.
    pub lit_casters: usize,
    /// Bodies that light enters.
    pub bodies: usize,
    /// Bodies of glass that bends one wavelength more than another.
    pub dispersive: usize,
    /// Media that do something to light: in bodies, or all around.
    pub media: usize,
    /// Of them, those that scatter.
    pub scattering_media: usize,
    /// Of them, those that glow.
    pub glowing_media: usize,
    /// Whether a medium is wherever no body is.
    pub filled: bool,
    /// Whether a background is seen that lights nothing.
    pub background: bool,
    /// Things with textures.
    pub textured: usize,
    /// Things with bumps.
    pub bumpy: usize,
    /// Lights with power.
    pub lights: usize,
    /// Of them, those with an extent.
    pub soft_lights: usize,
    /// Whether light comes from all around.
    pub environment: bool,
    /// Whether the camera has a lens.
    pub lens: bool,
    /// Whether anything moves while the shutter is open.
    pub moving: bool,
    /// Whether nothing can stand before anything else: all there is is one flat object, and no light shines along it.
    pub one_flat_object: bool,
}

impl SceneFeatures {
    /// Reads a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let objects: Vec<Object> = scene.objects().collect();
        let mut facts = Self {
            objects: objects.len(),
            receivers: 0,
            scattering_receivers: 0,
            casters: 0,
            lit_casters: 0,
            bodies: 0,
            dispersive: 0,
            media: 0,
            scattering_media: 0,
            glowing_media: 0,
            filled: scene.filling().is_some(),
            background: scene.background() != Rgb::ZERO,
            textured: 0,
            bumpy: 0,
            lights: 0,
            soft_lights: 0,
            environment: scene.environment().is_some(),
            lens: scene.camera().lens().is_some(),
            moving: scene.moves(),
            one_flat_object: false,
        };
        // Where all there is are planes the domain is a point, in which light from infinity has no power, but it shines.
        let some = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let lights: Vec<&Light> = scene.lights().iter().filter(|l| l.power(some) != Rgb::ZERO).collect();
        facts.lights = lights.len();
        let media = scene.media_in_use();
        facts.media = media.iter().filter(|medium| !medium.is_empty()).count();
        facts.scattering_media = media.iter().filter(|medium| medium.scatters()).count();
        facts.glowing_media = media.iter().filter(|medium| medium.emits()).count();
        // What moves is elsewhere at another time.
        if let [Object { plane: Some((p, n)), .. }] = objects[..]
            && !facts.moving
            && facts.media == 0
        {
            facts.one_flat_object = lights.iter().all(|light| light.avoids_plane(p, n));
        }
        facts.soft_lights = lights.iter().filter(|l| !l.is_delta()).count();
        for object in &objects {
            let (mut receives, mut scatters, mut casts, mut bounds, mut parts) = (false, false, false, false, false);
            scene.scatterings(object.material, &mut |scattering| {
                casts |= scattering.casts_caustics();
                match scattering {
                    Scattering::Fixed(bsdf) if bsdf.stores_photons() => {
                        receives = true;
                        scatters |= *bsdf != Bsdf::Diffuse(Rgb::ZERO);
                    }
                    Scattering::Boundary(body) => {
                        bounds = true;
                        parts |= body.glass.is_some();
                    }
                    Scattering::Fixed(_) | Scattering::Mix { .. } => {}
                }
            });
            let ball = object.ball.filter(|_| !facts.moving);
            let reached = || lights.iter().any(|light| light.may_reach(ball, scene.domain()));
            let (textured, bumpy) = scene.wears(object.material);
            facts.textured += usize::from(textured || object.glows);
            facts.bumpy += usize::from(bumpy);
            facts.receivers += usize::from(receives);
            facts.scattering_receivers += usize::from(scatters);
            facts.casters += usize::from(casts);
            facts.lit_casters += usize::from(casts && reached());
            facts.bodies += usize::from(bounds);
            facts.dispersive += usize::from(parts);
        }
        facts
    }
}
