//! Collecting the lights of a scene.

use super::object::{ObjectGeometry, SceneObject};
use super::place::{PlacedGeometry, PlacedTextureMappings};
use crate::light::{AreaLight, EmissionTexture, EnvironmentLight, Light, LightSurface};
use crate::math::Motion;
use crate::sampling::DiscreteDistribution;
use crate::scene::animation::{MID_SHUTTER, delta_light_at_time, physical_light_strength_at_mid_shutter};
use crate::scene::delta_light::{mit_6837_area_light, place_delta_light};
use crate::scene::{BuildError, LightStrength, Mit6837Light, UnscaledDeltaLight};
use crate::texture::Texture;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// A delta light with its strength and motion, in world coordinates.
#[derive(Debug)]
pub(super) struct DeltaLight {
    pub kind: UnscaledDeltaLight,
    pub strength: LightStrength,
    /// Motion of the light in world coordinates; `None` if it rests.
    pub motion: Option<Motion>,
}

/// The lights in coordinates relative to [`Scene::origin`](crate::scene::Scene::origin). Their
/// order is: delta lights at rest, moving delta lights, area lights, environment light.
pub(super) struct CollectedLights {
    pub lights: Vec<Light>,
    /// Index of the environment light in `lights`; `None` if there is none.
    pub environment_light_index: Option<usize>,
    pub mit_6837_lights: Vec<Mit6837Light>,
    /// Moving delta lights: index in `lights`, light before its motion is applied, strength and
    /// motion.
    pub moving_delta_lights: Vec<(usize, UnscaledDeltaLight, LightStrength, Motion)>,
    /// Index of the area light of each object; `None` if the object does not emit light.
    pub area_light_of_object: Vec<Option<u32>>,
}

/// Collects delta lights, area lights of emissive objects, and the environment light.
///
/// Lights are in coordinates relative to `origin`, at mid-shutter. A singular motion is the error
/// [`BuildError::SingularMotion`].
pub(super) fn collect_lights(
    delta_lights: &[DeltaLight],
    objects: &[SceneObject],
    geometry: &PlacedGeometry,
    mappings: &PlacedTextureMappings,
    textures: &[Arc<Texture>],
    environment: Option<EnvironmentLight>,
    origin: DVec3,
) -> Result<CollectedLights, BuildError> {
    let mut found = CollectedLights {
        lights: Vec::new(),
        environment_light_index: None,
        mit_6837_lights: Vec::new(),
        moving_delta_lights: Vec::new(),
        area_light_of_object: Vec::new(),
    };
    for source in delta_lights.iter().filter(|source| source.motion.is_none()) {
        found.add_light(place_delta_light(&source.kind, source.strength, origin));
    }
    for source in delta_lights {
        let Some(motion) = &source.motion else { continue };
        let motion = motion.followed_by_map(DAffine3::from_translation(-origin));
        let strength = physical_light_strength_at_mid_shutter(&source.kind, source.strength, &motion);
        let placed = delta_light_at_time(&source.kind, &motion, MID_SHUTTER).ok_or(BuildError::SingularMotion)?;
        found.moving_delta_lights.push((found.lights.len(), source.kind.clone(), strength, motion));
        found.add_light(place_delta_light(&placed, strength, DVec3::ZERO));
    }
    let mut shapes = geometry.shapes.iter();
    for (object, mapping) in objects.iter().zip(&mappings.mapping_of_object) {
        let surface = match &object.geometry {
            ObjectGeometry::Shape(_) => {
                let placed = shapes.next();
                placed.filter(|_| object.emits()).cloned().map(LightSurface::Shape)
            }
            ObjectGeometry::Mesh(range) if object.emits() => {
                let areas = range.clone().map(|i| geometry.mesh.triangle_area(i as usize));
                let mesh = geometry.mesh.clone();
                DiscreteDistribution::new(areas).map(|choice| LightSurface::Triangles {
                    mesh,
                    first_triangle: range.start,
                    triangle_distribution: choice,
                })
            }
            ObjectGeometry::Mesh(_) | ObjectGeometry::Plane(_) => None,
        };
        let light = surface.map(|surface| {
            let mapping = mappings.texture_mappings[*mapping as usize];
            let texture = object.emission_texture.map(|(texture, scale)| {
                Arc::new(EmissionTexture { texture: textures[texture as usize].clone(), mapping, scale })
            });
            let light = Light::Area(AreaLight { surface, radiance: object.emission, texture });
            let mit_6837 = mit_6837_area_light(&light);
            found.add_light((light, mit_6837))
        });
        found.area_light_of_object.push(light);
    }
    // Add the environment light last, because it has no [`Mit6837Light`]: so all other lights have
    // the same index in both lists.
    assert_eq!(found.mit_6837_lights.len(), found.lights.len());
    if let Some(environment) = environment {
        found.environment_light_index = Some(found.lights.len());
        found.lights.push(Light::Environment(Arc::new(environment)));
    }
    Ok(found)
}

impl CollectedLights {
    /// Adds a light, and the [`Mit6837Light`] that stands for it in algorithm `raycast`. Returns
    /// the index of the light, which is the same in both lists.
    fn add_light(&mut self, (light, mit_6837): (Light, Mit6837Light)) -> u32 {
        self.lights.push(light);
        self.mit_6837_lights.push(mit_6837);
        self.lights.len() as u32 - 1
    }
}

/// Returns `lights` with each emission texture replaced by its mean radiance. Empty if no light has
/// an emission texture.
pub(in crate::scene) fn mean_emission_lights(lights: &[Light]) -> Vec<Light> {
    if !lights.iter().any(Light::has_emission_texture) {
        return Vec::new();
    }
    lights.iter().map(Light::with_mean_emission).collect()
}
