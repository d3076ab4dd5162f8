//! Conversion of objects from world coordinates to scene coordinates, at mid-shutter.

use super::object::{MergedMeshes, ObjectGeometry, SceneObject};
use crate::camera::Camera;
use crate::math::Motion;
use crate::scene::BuildError;
use crate::scene::animation::{
    Animation, MID_SHUTTER, camera_at_time, plane_at_time, shape_at_time, texture_mapping_at_time,
};
use crate::scene::geometry::{self, ObjectAttributes};
use crate::shape::{Mesh, Plane, Shape, TextureMapping};
use glam::{DAffine3, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// Sorted objects, with their geometry and texture mappings in coordinates relative to
/// [`Scene::origin`](crate::scene::Scene::origin).
pub(super) struct PlacedObjects {
    /// The objects in the order of their indices, still in world coordinates.
    ///
    /// The order is: shapes at rest, moving shapes, meshes, planes at rest, moving planes.
    pub objects: Vec<SceneObject>,
    pub geometry: PlacedGeometry,
    pub mappings: PlacedTextureMappings,
    /// The moving shapes, planes and texture mappings. Lights, camera and media are added later.
    pub animation: Animation,
}

/// Geometry in coordinates relative to [`Scene::origin`](crate::scene::Scene::origin), before
/// bounding volume hierarchies are built.
pub(super) struct PlacedGeometry {
    /// All analytic shapes: shapes at rest, then moving shapes.
    pub shapes: Vec<Shape>,
    pub first_moving_shape_index: u32,
    pub planes: Vec<Plane>,
    pub mesh: Arc<Mesh>,
    /// Range of triangle indices of each mesh object.
    pub mesh_ranges: Vec<Range<u32>>,
}

/// Texture mappings in coordinates relative to [`Scene::origin`](crate::scene::Scene::origin).
pub(super) struct PlacedTextureMappings {
    /// All texture mappings. The first one is the default, for objects that define none.
    pub texture_mappings: Vec<TextureMapping>,
    /// Index in `texture_mappings` of each object's texture mapping.
    pub mapping_of_object: Vec<u32>,
}

/// Sorts the objects by [`SceneObject::object_sort_key`], and converts their geometry and texture
/// mappings to coordinates relative to `origin`, at mid-shutter.
///
/// A singular motion is the error [`BuildError::SingularMotion`].
pub(super) fn sort_and_place_objects(
    mut objects: Vec<SceneObject>,
    mesh: MergedMeshes,
    origin: DVec3,
) -> Result<PlacedObjects, BuildError> {
    objects.sort_by_key(SceneObject::object_sort_key);
    let recenter = DAffine3::from_translation(-origin);
    let mut animation = Animation::default();
    let (mut shapes, mut planes, mut mesh_ranges) = (Vec::new(), Vec::new(), Vec::new());
    for object in &objects {
        let motion = object.motion.as_ref().map(|motion| motion.followed_by_map(recenter));
        match (&object.geometry, motion) {
            (ObjectGeometry::Shape(shape), None) => shapes.push(shape.translated(-origin)),
            (ObjectGeometry::Shape(shape), Some(motion)) => {
                shapes.push(shape_at_time(shape, &motion, MID_SHUTTER).ok_or(BuildError::SingularMotion)?);
                animation.shapes.push((shape.clone(), motion));
            }
            (ObjectGeometry::Mesh(range), _) => mesh_ranges.push(range.clone()),
            (ObjectGeometry::Plane(plane), None) => planes.push(plane.translated(-origin)),
            (ObjectGeometry::Plane(plane), Some(motion)) => {
                planes.push(plane_at_time(plane, &motion, MID_SHUTTER).ok_or(BuildError::SingularMotion)?);
                animation.planes.push((*plane, motion));
            }
        }
    }
    let first_moving = (shapes.len() - animation.shapes.len()) as u32;
    let mappings = place_texture_mappings(&objects, origin, &mut animation)?;
    let mesh = Arc::new(mesh.recentered(origin));
    let geometry = PlacedGeometry { shapes, first_moving_shape_index: first_moving, planes, mesh, mesh_ranges };
    Ok(PlacedObjects { objects, geometry, mappings, animation })
}

fn place_texture_mappings(
    objects: &[SceneObject],
    origin: DVec3,
    animation: &mut Animation,
) -> Result<PlacedTextureMappings, BuildError> {
    let recenter = DAffine3::from_translation(-origin);
    let mut mappings = PlacedTextureMappings {
        texture_mappings: vec![TextureMapping::default().translated(-origin)],
        mapping_of_object: Vec::new(),
    };
    for object in objects {
        let Some((kind, motion)) = &object.mapping else {
            mappings.mapping_of_object.push(0);
            continue;
        };
        let (index, placed) = (mappings.texture_mappings.len(), motion.followed_by_map(recenter));
        mappings
            .texture_mappings
            .push(texture_mapping_at_time(*kind, &placed, MID_SHUTTER).ok_or(BuildError::SingularMotion)?);
        mappings.mapping_of_object.push(index as u32);
        if !motion.is_constant() {
            animation.mappings.push((index, *kind, placed));
        }
    }
    Ok(mappings)
}

/// The camera in coordinates relative to `origin`, at mid-shutter.
///
/// If the camera moves, its motion is added to `animation`.
pub(super) fn place_camera(
    camera: &Camera,
    motion: Option<Motion>,
    origin: DVec3,
    animation: &mut Animation,
) -> Result<Camera, BuildError> {
    let camera = camera.translated(-origin);
    let Some(motion) = motion else { return Ok(camera) };
    let motion = motion.pivoted_at_point(camera.center());
    let placed = camera_at_time(&camera, &motion, MID_SHUTTER).ok_or(BuildError::SingularMotion)?;
    animation.camera = Some((camera, motion));
    Ok(placed)
}

impl PlacedGeometry {
    /// Builds the geometry with its bounding volume hierarchies. The hierarchy over triangles and
    /// shapes at rest is taken from the scene `earlier`, if that scene has the same triangles and
    /// the same boxes of shapes.
    ///
    /// `light_of_object` holds the index of each object's area light; `None` if the object does not
    /// emit light.
    pub fn build_hierarchies(
        self,
        objects: &[SceneObject],
        mappings: &PlacedTextureMappings,
        light_of_object: &[Option<u32>],
        earlier: Option<&geometry::Geometry>,
    ) -> geometry::Geometry {
        let attributes = objects.iter().zip(light_of_object).zip(&mappings.mapping_of_object);
        let attributes = attributes.map(|((object, light), mapping)| ObjectAttributes {
            material: object.material,
            light: *light,
            mapping: *mapping,
        });
        let Self { shapes, first_moving_shape_index: first_moving, planes, mesh, mesh_ranges } = self;
        geometry::Geometry::new(attributes.collect(), shapes, first_moving, planes, mesh, mesh_ranges, earlier)
    }
}
