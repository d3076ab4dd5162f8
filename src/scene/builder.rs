//! Building a resolved scene from parts in world coordinates.

use super::middle::{Extent, middle, sight};
use super::movement::{MIDDLE, Movement, constant_strength, plane_at, shape_at, source_at};
use super::neighbours::Neighbours;
use super::source::{course_area_light, resolve_source};
use super::wardrobe::{Place, Wardrobe};
use super::{Attributes, BuildError, InteriorStack, LightStrength, Material, Scene, SourceKind};
use crate::accel::Hierarchy;
use crate::camera::Camera;
use crate::color::{self, Glass, Rgb};
use crate::light::{AreaLight, EnvironmentLight, Light, LightSurface};
use crate::math::{Bounds, Motion, Sphere, Transform};
use crate::medium::Medium;
use crate::sampling::Discrete;
use crate::shape::{Mesh, Plane, Shape, Triangle};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// Squares and products of three coordinates must stay finite.
const FARTHEST: f32 = 1e12;

/// 2⁻³⁹: what single precision tells apart there, 2⁻²⁴ of it, has a square of 2⁻¹²⁶, the least normal number.
const LEAST: f32 = 1.0 / 549_755_813_888.0;

/// Gathers the parts of a scene.
#[derive(Debug, Default)]
pub struct SceneBuilder {
    background: Rgb,
    environment: Option<EnvironmentLight>,
    pub(super) materials: Vec<Material>,
    glasses: Vec<Glass>,
    media: Vec<Medium>,
    pub(super) filling: Option<u32>,
    pub(super) shapes: Vec<(Shape, u32, Rgb)>,
    pub(super) planes: Vec<(Plane, u32)>,
    pub(super) positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) parts: Vec<(u32, u32, Rgb)>,
    sources: Vec<(SourceKind, LightStrength)>,
    pub(super) moving_shapes: Vec<(Shape, Motion, u32, Rgb)>,
    pub(super) moving_planes: Vec<(Plane, Motion, u32)>,
    moving_sources: Vec<(SourceKind, LightStrength, Motion)>,
    moving_camera: Option<Motion>,
    emissive_plane: bool,
    pub(super) wardrobe: Wardrobe,
}

impl SceneBuilder {
    /// No parts yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the radiance that is seen where nothing is.
    pub fn background(&mut self, color: Rgb) -> &mut Self {
        self.background = color;
        self
    }

    /// Sets the light from all around, in place of an earlier one; it is seen instead of the background.
    pub fn environment(&mut self, environment: EnvironmentLight) -> &mut Self {
        self.environment = Some(environment);
        self
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a refractive index that depends on the wavelength, and returns its index.
    pub fn glass(&mut self, glass: Glass) -> u32 {
        self.glasses.push(glass);
        self.glasses.len() as u32 - 1
    }

    /// Adds a medium, and returns its index.
    pub fn medium(&mut self, medium: Medium) -> u32 {
        self.media.push(medium);
        self.media.len() as u32 - 1
    }

    /// Fills whatever no body fills with the medium of index `medium`: see [`Scene::filling`].
    pub fn filled_with(&mut self, medium: u32) -> &mut Self {
        self.filling = Some(medium);
        self
    }

    /// Adds a shape; an `emission` above zero \[W/(m² sr)] makes it an area light.
    pub fn shape(&mut self, shape: Shape, material: u32, emission: Rgb) -> &mut Self {
        self.wardrobe.last = Some(Place::Shape(self.shapes.len()));
        self.shapes.push((shape, material, emission));
        self
    }

    /// Adds an unbounded plane.
    pub fn plane(&mut self, plane: Plane, material: u32, emission: Rgb) -> &mut Self {
        self.emissive_plane |= emission != Rgb::ZERO;
        self.wardrobe.last = Some(Place::Plane(self.planes.len()));
        self.planes.push((plane, material));
        self
    }

    /// Adds a mesh: corners, unit normals (one a corner, or none), and triangles whose indices count from its first corner.
    /// Triangles without area are left out: no ray can hit them.
    pub fn mesh(
        &mut self,
        positions: &[DVec3],
        normals: &[Vec3],
        triangles: &[Triangle],
        material: u32,
        emission: Rgb,
    ) -> &mut Self {
        let base = self.positions.len() as u32;
        self.wardrobe.last = Some(Place::Part(self.parts.len()));
        self.parts.push((self.triangles.len() as u32, material, emission));
        self.positions.extend_from_slice(positions);
        if !normals.is_empty() {
            self.normals.resize(base as usize, Vec3::ZERO);
            self.normals.extend_from_slice(normals);
        }
        let area = |t: &Triangle| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(c - a).length_squared()
        };
        self.triangles.extend(triangles.iter().filter(|t| area(t) > 0.0).map(|t| t.map(|v| v + base)));
        self
    }

    /// Adds a light without a surface.
    pub fn source(&mut self, kind: SourceKind, strength: LightStrength) -> &mut Self {
        self.sources.push((kind, strength));
        self
    }

    /// Adds a shape that moves while the shutter is open.
    pub fn moving_shape(&mut self, shape: Shape, motion: Motion, material: u32, emission: Rgb) -> &mut Self {
        self.wardrobe.last = Some(Place::MovingShape(self.moving_shapes.len()));
        self.moving_shapes.push((shape, motion, material, emission));
        self
    }

    /// Adds an unbounded plane that moves while the shutter is open.
    pub fn moving_plane(&mut self, plane: Plane, motion: Motion, material: u32, emission: Rgb) -> &mut Self {
        self.emissive_plane |= emission != Rgb::ZERO;
        self.wardrobe.last = Some(Place::MovingPlane(self.moving_planes.len()));
        self.moving_planes.push((plane, motion, material));
        self
    }

    /// Adds a light without a surface that moves while the shutter is open, by maps that act as if its own place were the origin.
    pub fn moving_source(&mut self, kind: SourceKind, strength: LightStrength, motion: &Motion) -> &mut Self {
        let motion = kind.place().map_or_else(|| motion.clone(), |place| motion.about(place));
        self.moving_sources.push((kind, strength, motion));
        self
    }

    /// Lets the camera turn and move while the shutter is open, by maps that act as if its own place were the origin.
    pub fn moving_camera(&mut self, motion: Motion) -> &mut Self {
        self.moving_camera = Some(motion);
        self
    }

    /// Checks, re-centres and indexes everything.
    ///
    /// # Errors
    /// [`BuildError`] where the parts cannot be rendered.
    pub fn build(mut self, camera: Camera) -> Result<Scene, BuildError> {
        if self.emissive_plane {
            return Err(BuildError::EmissivePlane);
        }
        if self.triangles.len() > i32::MAX as usize {
            return Err(BuildError::TooManyTriangles(self.triangles.len()));
        }
        self.leave_out_nothing();
        let middle = self.middle(&camera)?;
        let movement = self.movement(&camera, middle);
        // Of surfaces in one plane the first is met. That is the one that shines, as those who ask it take for granted.
        let mut order: Vec<usize> = (0..self.shapes.len()).collect();
        order.sort_by_key(|i| self.shapes[*i].2 == Rgb::ZERO);
        self.shapes = order.iter().map(|i| self.shapes[*i].clone()).collect();
        let mut shapes: Vec<Shape> = self.shapes.iter().map(|(s, ..)| s.translated(-middle)).collect();
        let still = shapes.len();
        for (shape, motion) in &movement.shapes {
            shapes.push(shape_at(shape, motion, MIDDLE).ok_or(BuildError::Flattened)?);
        }
        let mut planes: Vec<Plane> = self.planes.iter().map(|(p, _)| p.translated(-middle)).collect();
        for (plane, motion) in &movement.planes {
            planes.push(plane_at(plane, motion, MIDDLE).ok_or(BuildError::Flattened)?);
        }
        let part_ends = self.ends_of_parts();
        let mut normals = self.normals;
        if !normals.is_empty() {
            normals.resize(self.positions.len(), Vec3::ZERO);
        }
        let positions: Vec<Vec3> = self.positions.iter().map(|p| (*p - middle).as_vec3()).collect();
        let mut texcoords = std::mem::take(&mut self.wardrobe.texcoords);
        if !texcoords.is_empty() {
            texcoords.resize(positions.len(), Vec2::ZERO);
        }
        let mesh = Arc::new(Mesh { positions, normals, texcoords, triangles: self.triangles });
        let wardrobe = self.wardrobe;
        let charts = wardrobe.charts(middle)?;

        let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let boxes: Vec<Bounds> = shapes.iter().map(Shape::bounds).collect();
        let at = |time| {
            movement.shapes.iter().filter_map(move |(shape, motion)| Some(shape_at(shape, motion, time)?.bounds()))
        };
        let ends: Vec<Bounds> = at(0.0).chain(at(1.0)).collect();
        let farthest = corners
            .iter()
            .flatten()
            .copied()
            .chain(boxes.iter().chain(&ends).flat_map(|b| [b.min, b.max]))
            .flat_map(|p| p.abs().to_array())
            // What is no number is the farthest of all.
            .max_by(f32::total_cmp);
        match farthest {
            Some(far) if !far.is_finite() => return Err(BuildError::TooLarge(f64::INFINITY)),
            Some(far) if far > FARTHEST => return Err(BuildError::TooLarge(f64::from(far))),
            Some(far) if far < LEAST => return Err(BuildError::TooSmall(f64::from(far))),
            _ => {}
        }
        let bounds = boxes[..still].iter().copied().fold(Bounds::of(corners.iter().flatten().copied()), Bounds::union);

        let mut lights = Vec::new();
        let mut legacy_lights = Vec::new();
        for (kind, strength) in &self.sources {
            let (light, course) = resolve_source(kind, *strength, middle);
            lights.push(light);
            legacy_lights.push(course);
        }
        for (_, kind, strength, motion) in &movement.sources {
            let kind = source_at(kind, motion, MIDDLE).ok_or(BuildError::Flattened)?;
            let (light, course) = resolve_source(&kind, *strength, DVec3::ZERO);
            lights.push(light);
            legacy_lights.push(course);
        }
        let mut area_light = |surface: LightSurface, radiance: Rgb, place: Place| {
            (radiance != Rgb::ZERO).then(|| {
                let glow = wardrobe.glow_of(place, &charts);
                let light = Light::Area(AreaLight { surface, radiance, texture: glow });
                legacy_lights.push(course_area_light(&light));
                lights.push(light);
                lights.len() as u32 - 1
            })
        };
        let still_looks = self.shapes.iter().map(|(_, material, radiance)| (*material, *radiance));
        let moving_looks = self.moving_shapes.iter().map(|(.., material, radiance)| (*material, *radiance));
        let shape_attributes = shapes
            .iter()
            .zip(still_looks.chain(moving_looks))
            .enumerate()
            .map(|(i, (shape, (material, radiance)))| {
                let place = if i < still { Place::Shape(order[i]) } else { Place::MovingShape(i - still) };
                let light = area_light(LightSurface::Shape(shape.clone()), radiance, place);
                Attributes { material, light, chart: wardrobe.chart_of(place) }
            })
            .collect();
        let mut parts = Vec::new();
        let mut triangle_part = Vec::with_capacity(mesh.triangles.len());
        for ((first, material, radiance), end) in self.parts.iter().zip(part_ends) {
            let areas = (*first..end).map(|i| mesh.area(i as usize));
            let choice = if *radiance == Rgb::ZERO { None } else { Discrete::new(areas) };
            let light = choice.and_then(|choice| {
                let place = Place::Part(parts.len());
                area_light(LightSurface::Triangles { mesh: mesh.clone(), first: *first, choice }, *radiance, place)
            });
            triangle_part.resize(end as usize, parts.len() as u32);
            let chart = wardrobe.chart_of(Place::Part(parts.len()));
            parts.push((*first, Attributes { material: *material, light, chart }));
        }
        // Last, as the course's lights know nothing of it.
        lights.extend(self.environment.map(|sky| Light::Environment(Arc::new(sky))));
        let plane_materials = self.planes.iter().map(|(_, m)| *m).chain(self.moving_planes.iter().map(|(.., m)| *m));
        let still_planes = self.planes.len();
        let plane_attributes = plane_materials.enumerate().map(|(i, material)| {
            let place = if i < still_planes { Place::Plane(i) } else { Place::MovingPlane(i - still_planes) };
            Attributes { material, light: None, chart: wardrobe.chart_of(place) }
        });
        let planes = planes.into_iter().zip(plane_attributes).collect();
        let mean_lights = wardrobe.even(&lights);
        let camera = match &movement.camera {
            Some((camera, motion)) => {
                camera.moved(&Transform::new(motion.at(MIDDLE)).map_err(|_| BuildError::Flattened)?)
            }
            None => camera.translated(-middle),
        };
        let mut scene = Scene {
            camera,
            background: self.background,
            materials: self.materials,
            glasses: self.glasses,
            media: self.media.iter().map(|medium| medium.translated(-middle)).collect(),
            filling: self.filling,
            filled: Sphere { center: Vec3::ZERO, radius: 0.0 },
            hierarchy: Arc::new(Hierarchy::build(&corners, &boxes[..still])),
            moving: None,
            first_moving: still as u32,
            movement: (!movement.is_none()).then(|| Arc::new(movement)),
            still: bounds,
            planes,
            dresses: wardrobe.dresses,
            textures: wardrobe.textures,
            charts,
            lights,
            mean_lights,
            legacy_lights,
            shapes,
            shape_attributes,
            mesh,
            parts,
            triangle_part: triangle_part.into(),
            domain: Sphere { center: Vec3::ZERO, radius: 0.0 },
            middle,
            camera_inside: InteriorStack::NOTHING,
            light_inside: Vec::new(),
            neighbours: Neighbours::default(),
            light_contact: Vec::new(),
        };
        scene.neighbours = scene.find_neighbours();
        scene.settle(bounds);
        // Lights are chosen by the mean of their channels, whose sum must be a number too.
        match scene.lights.iter().position(|light| !color::mean(light.power(scene.domain)).is_finite()) {
            Some(i) => Err(BuildError::TooBright(i)),
            None => Ok(scene),
        }
    }

    /// Of each mesh, the triangle after its last.
    pub(super) fn ends_of_parts(&self) -> Vec<u32> {
        self.parts.iter().skip(1).map(|(first, ..)| *first).chain([self.triangles.len() as u32]).collect()
    }

    /// The box around triangles; `None` where there are none.
    pub(super) fn extent_of(&self, triangles: std::ops::Range<u32>) -> Option<Extent> {
        let corners = self.triangles[triangles.start as usize..triangles.end as usize].iter().flatten();
        let points = corners.map(|v| self.positions[*v as usize]).map(|p| (p, p));
        points.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    pub(super) fn corner_count(&self) -> usize {
        self.positions.len()
    }

    /// All that moves, in coordinates around `middle`.
    fn movement(&self, camera: &Camera, middle: DVec3) -> Movement {
        let back = DAffine3::from_translation(-middle);
        let first = self.sources.len();
        let sources = self.moving_sources.iter().zip(first..);
        let still = camera.translated(-middle);
        Movement {
            shapes: self.moving_shapes.iter().map(|(s, motion, ..)| (s.clone(), motion.followed_by(back))).collect(),
            planes: self.moving_planes.iter().map(|(p, motion, _)| (*p, motion.followed_by(back))).collect(),
            sources: sources
                .map(|((kind, strength, motion), i)| {
                    let motion = motion.followed_by(back);
                    (i, kind.clone(), constant_strength(kind, *strength, &motion), motion)
                })
                .collect(),
            camera: self.moving_camera.as_ref().map(|motion| (still, motion.about(still.center()))),
            charts: self.wardrobe.motions(middle),
        }
    }

    /// Where coordinates are to count from (see [`middle`]); the eye where there is nothing.
    fn middle(&self, camera: &Camera) -> Result<DVec3, BuildError> {
        let mut boxes: Vec<Extent> = self.shapes.iter().map(|(shape, ..)| shape.extent()).collect();
        let both = |(a, b): Extent, (c, d): Extent| (a.min(c), b.max(d));
        for (shape, motion, ..) in &self.moving_shapes {
            let at = |time| Some(shape_at(shape, motion, time)?.extent());
            let [start, half, end] = [0.0, MIDDLE, 1.0].map(at);
            boxes.push(start.zip(half).zip(end).map(|((a, b), c)| both(both(a, b), c)).ok_or(BuildError::Flattened)?);
        }
        let parts = self.parts.iter().zip(self.ends_of_parts());
        boxes.extend(parts.filter_map(|((first, ..), end)| self.extent_of(*first..end)));
        Ok(middle(&boxes, sight(camera, self.shapes.iter().map(|(shape, ..)| shape))).unwrap_or(camera.center()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Sphere as Ball;

    fn camera() -> Camera {
        Camera::perspective(DVec3::new(0.0, 0.0, 9.0), DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap()
    }

    fn ball(builder: &mut SceneBuilder, center: DVec3, emission: Rgb) {
        let material = builder.material(Material::diffuse(Rgb::ONE));
        builder.shape(Shape::Sphere(Ball::new(center, 1.0)), material, emission);
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let mut far = SceneBuilder::new();
        ball(&mut far, DVec3::ZERO, Rgb::ZERO);
        ball(&mut far, DVec3::new(1e15, 0.0, 0.0), Rgb::ZERO);
        assert!(matches!(far.build(camera()), Err(BuildError::TooLarge(_))));
        let mut bright = SceneBuilder::new();
        ball(&mut bright, DVec3::ZERO, Rgb::splat(f32::MAX));
        assert_eq!(bright.build(camera()).err(), Some(BuildError::TooBright(0)));
        let mut source = SceneBuilder::new();
        source.source(SourceKind::Point { position: DVec3::ZERO }, LightStrength::Power(Rgb::INFINITY));
        assert_eq!(source.build(camera()).err(), Some(BuildError::TooBright(0)));
    }

    #[test]
    fn what_escapes_finds_the_environment_or_the_background() {
        let scene = |environments: &[f32]| {
            let mut builder = SceneBuilder::new();
            builder.background(Rgb::splat(0.5));
            for radiance in environments {
                builder.environment(EnvironmentLight::constant(Rgb::splat(*radiance)).unwrap());
            }
            ball(&mut builder, DVec3::ZERO, Rgb::ONE);
            builder.build(camera()).unwrap()
        };
        let (without, with) = (scene(&[]), scene(&[2.0, 3.0]));
        assert_eq!((without.environment(), without.escaping(Vec3::X)), (None, Rgb::splat(0.5)));
        assert_eq!((with.environment(), with.escaping(Vec3::X)), (Some(1), Rgb::splat(3.0)));
        assert_eq!((with.lights().len(), with.legacy_lights().len()), (2, 1));
    }

    #[test]
    fn a_scene_is_centred_on_its_shapes() {
        let mut builder = SceneBuilder::new();
        let place = DVec3::new(1e6, 2e6, -3e6);
        ball(&mut builder, place, Rgb::ZERO);
        let scene = builder.build(camera().translated(place)).unwrap();
        assert_eq!(scene.middle(), place);
        assert_eq!(scene.camera().center(), DVec3::new(0.0, 0.0, 9.0));
        assert_eq!(scene.domain().center, Vec3::ZERO);
    }
}
