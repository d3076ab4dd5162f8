//! Data derived from the placement of objects, lights and camera, such as the ball onto which
//! lights at infinity emit photons.

use super::light_contact_distance::light_contact_distance;
use super::lights_across_boundaries::find_lights_across_boundaries;
use crate::light::Light;
use crate::math::{BoundingSphere, Bounds};
use crate::scene::Scene;
use crate::scene::interiors::{InteriorStack, interior_stack_at};
use glam::Vec3;

/// Factor by which the radius of the [photon domain](Scene::photon_domain) grows if the scene has
/// unbounded planes. The domain is the ball onto which lights at infinity emit photons. Without
/// planes, it is the bounding sphere of all bounded objects.
const OPEN_DOMAIN_FACTOR: f32 = 4.0;

/// Radius of the ball that the ambient medium fills, divided by a distance d.
///
/// d is the greatest distance from the center of the photon domain (the ball onto which lights at
/// infinity emit photons) to a light, the camera or the domain's edge. The medium is limited,
/// because an unbounded one would scatter most photons far away from the objects.
const AMBIENT_RADIUS_FACTOR: f32 = 2.0;

/// Scene data that is computed from the placement of objects, lights and camera at one time.
#[derive(Clone, Debug)]
pub(in crate::scene) struct DerivedSceneData {
    /// The ball onto which lights at infinity emit photons: see [`Scene::photon_domain`].
    pub photon_domain: BoundingSphere,
    /// The ball that the [ambient medium](Scene::ambient_medium) fills.
    pub ambient_medium_sphere: BoundingSphere,
    /// The dielectric bodies that contain the camera.
    pub camera_interior: InteriorStack,
    /// The dielectric bodies that contain each light, by light index. Only one point of the light
    /// is tested; `lights_across_boundaries` tells whether other points may lie in other bodies.
    pub light_interiors: Vec<InteriorStack>,
    /// One flag for each light: true if the light may lie partly inside a dielectric body.
    /// Different points of such a light may lie in different bodies.
    pub lights_across_boundaries: Vec<bool>,
    /// Distance \[length] below which a surface point counts as touching a light, by light index:
    /// see [`Scene::light_contact_distance`].
    pub light_contact_distances: Vec<f32>,
}

impl Default for DerivedSceneData {
    fn default() -> Self {
        let nowhere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
        Self {
            photon_domain: nowhere,
            ambient_medium_sphere: nowhere,
            camera_interior: InteriorStack::EMPTY,
            light_interiors: Vec::new(),
            lights_across_boundaries: Vec::new(),
            light_contact_distances: Vec::new(),
        }
    }
}

/// Computes the [`DerivedSceneData`] of `scene` from its geometry, lights and camera.
pub(in crate::scene) fn derive_scene_data(scene: &Scene) -> DerivedSceneData {
    let planes = scene.geometry.planes.iter().map(|plane| plane.point_and_normal().0.length());
    let domain = photon_domain(scene.geometry.bounds(), planes);
    let camera = scene.camera.center().as_vec3();
    let positions = scene.lights.iter().filter_map(Light::representative_point).chain([camera]);
    let farthest = positions.map(|p| p.distance(domain.center)).fold(domain.radius, f32::max);
    let (mut camera_interior, mut light_interiors) =
        (InteriorStack::EMPTY, vec![InteriorStack::EMPTY; scene.lights.len()]);
    let mut lights_across_boundaries = vec![false; scene.lights.len()];
    if scene.bodies().next().is_some() {
        camera_interior = interior_stack_at(scene, camera);
        let start =
            |light: &Light| light.representative_point().map_or(InteriorStack::EMPTY, |p| interior_stack_at(scene, p));
        light_interiors = scene.lights.iter().map(start).collect();
        lights_across_boundaries = find_lights_across_boundaries(scene);
    }
    DerivedSceneData {
        photon_domain: domain,
        ambient_medium_sphere: BoundingSphere { center: domain.center, radius: farthest * AMBIENT_RADIUS_FACTOR },
        camera_interior,
        light_interiors,
        lights_across_boundaries,
        light_contact_distances: scene
            .lights
            .iter()
            .map(|light| light_contact_distance(scene, domain, light))
            .collect(),
    }
}

/// The ball onto which lights at infinity emit photons: see [`Scene::photon_domain`].
///
/// `bounds` is the box around all bounded objects. `planes` are the distances of unbounded planes
/// from the origin \[length]. Without planes, the ball is the bounding sphere of the box. With
/// planes, the radius is multiplied by [`OPEN_DOMAIN_FACTOR`]. If there are planes but the box is
/// empty or a point, the greatest distance of a plane replaces the radius of the box. A distance of
/// 0 then counts as 1.
fn photon_domain(bounds: Bounds, planes: impl Iterator<Item = f32>) -> BoundingSphere {
    let ball = bounds.bounding_sphere();
    let Some(farthest) = planes.reduce(f32::max) else { return ball };
    let radius = if ball.radius > 0.0 {
        ball.radius
    } else if farthest > 0.0 {
        farthest
    } else {
        1.0
    };
    BoundingSphere { center: ball.center, radius: radius * OPEN_DOMAIN_FACTOR }
}
