//! Building a resolved scene from parts in world coordinates.

use super::{Attributes, CourseLight, Dress, Inside, Material, Scene};
use crate::accel::Hierarchy;
use crate::camera::Pinhole;
use crate::color::Rgb;
use crate::light::{Area, Emitter, Environment, Glow, Light, Spot};
use crate::math::{Bounds, Sphere};
use crate::sampling::Discrete;
use crate::shape::{Chart, Mesh, Plane, Shape, Triangle};
use crate::texture::Texture;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// How far light from infinity is followed beyond the bounded shapes, in their radii, where unbounded planes catch it.
const OPEN_DOMAIN: f32 = 4.0;

/// Why parts do not make a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// An unbounded plane cannot emit: its power would be infinite.
    #[error("an infinite plane cannot emit light: use a rectangle or a disc")]
    EmissivePlane,
    /// After re-centring, a coordinate does not fit single precision.
    #[error("the scene spans more than single precision can hold: the farthest coordinate is {0:e} from its middle")]
    TooLarge(f64),
    /// Light counted from 0 whose power does not fit single precision.
    #[error("light {0} (counted from 0) is stronger than single precision can hold")]
    TooBright(usize),
    /// More triangles than indices.
    #[error("{0} triangles are more than the 2³¹ that can be indexed")]
    TooManyTriangles(usize),
}

/// How strong a point, spot or directional light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightStrength {
    /// The course's colour: what a white, matt surface that faces the light reflects, at the middle of the scene.
    Course(Rgb),
    /// Intensity \[W/sr], or irradiance \[W/m²] for parallel light.
    Physical(Rgb),
    /// Flux \[W]; for points and spots.
    Power(Rgb),
}

/// A light without a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceKind {
    /// Everywhere alike from a place.
    Point {
        /// Place.
        position: DVec3,
    },
    /// Into a cone.
    Spot {
        /// Place.
        position: DVec3,
        /// Middle of the beam, of any length above zero.
        axis: DVec3,
        /// Half angle of full strength \[radians].
        inner: f64,
        /// Half angle where it ends \[radians].
        outer: f64,
    },
    /// Parallel.
    Directional {
        /// Direction of travel, of any length above zero.
        direction: DVec3,
    },
}

/// Gathers the parts of a scene.
#[derive(Debug, Default)]
pub struct SceneBuilder {
    background: Rgb,
    environment: Option<Environment>,
    materials: Vec<Material>,
    shapes: Vec<(Shape, u32, Rgb)>,
    planes: Vec<(Plane, u32)>,
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    triangles: Vec<Triangle>,
    parts: Vec<(u32, u32, Rgb)>,
    texcoords: Vec<Vec2>,
    sources: Vec<(SourceKind, LightStrength)>,
    emissive_plane: bool,
    textures: Vec<Arc<Texture>>,
    dresses: Vec<Dress>,
    /// Of the objects that have one.
    charts: Vec<(Place, Chart)>,
    /// Textures and scales of the objects that emit by one.
    glows: Vec<(Place, u32, Rgb)>,
    last: Option<Place>,
}

/// Where an object stands among those of its sort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Shape(usize),
    Plane(usize),
    Part(usize),
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
    pub fn environment(&mut self, environment: Environment) -> &mut Self {
        self.environment = Some(environment);
        self
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a texture and returns its index.
    pub fn texture(&mut self, texture: Texture) -> u32 {
        self.textures.push(Arc::new(texture));
        self.textures.len() as u32 - 1
    }

    /// Adds a material that wears `dress`, of textures that were added, and returns its index.
    pub fn dressed(&mut self, material: Material, dress: Dress) -> u32 {
        self.dresses.push(dress);
        self.material(Material { dress: Some(self.dresses.len() as u32 - 1), ..material })
    }

    /// Lays texture coordinates on the object that was added last, and says what space solid textures of it are in; else coordinates
    /// are its own parameters, and space is the world.
    pub fn chart(&mut self, chart: Chart) -> &mut Self {
        self.charts.extend(self.last.map(|last| (last, chart)));
        self
    }

    /// The emission of the object that was added last, a mean, follows `texture` times `scale` \[W/(m² sr)].
    pub fn glow(&mut self, texture: u32, scale: Rgb) -> &mut Self {
        self.glows.extend(self.last.map(|last| (last, texture, scale)));
        self
    }

    /// Gives the corners of the mesh that was added last texture coordinates, one each.
    pub fn texcoords(&mut self, texcoords: &[DVec2]) -> &mut Self {
        self.texcoords.resize(self.positions.len().saturating_sub(texcoords.len()), Vec2::ZERO);
        self.texcoords.extend(texcoords.iter().map(|t| t.as_vec2()));
        self
    }

    /// Adds a shape; an `emission` above zero \[W/(m² sr)] makes it an area light.
    pub fn shape(&mut self, shape: Shape, material: u32, emission: Rgb) -> &mut Self {
        self.last = Some(Place::Shape(self.shapes.len()));
        self.shapes.push((shape, material, emission));
        self
    }

    /// Adds an unbounded plane.
    pub fn plane(&mut self, plane: Plane, material: u32, emission: Rgb) -> &mut Self {
        self.emissive_plane |= emission != Rgb::ZERO;
        self.last = Some(Place::Plane(self.planes.len()));
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
        self.last = Some(Place::Part(self.parts.len()));
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

    /// Checks, re-centres and indexes everything.
    ///
    /// # Errors
    /// [`BuildError`] where the parts cannot be rendered.
    pub fn build(self, camera: Pinhole) -> Result<Scene, BuildError> {
        if self.emissive_plane {
            return Err(BuildError::EmissivePlane);
        }
        if self.triangles.len() > i32::MAX as usize {
            return Err(BuildError::TooManyTriangles(self.triangles.len()));
        }
        let middle = self.middle(&camera);
        let shapes: Vec<Shape> = self.shapes.iter().map(|(s, ..)| s.translated(-middle)).collect();
        let planes: Vec<Plane> = self.planes.iter().map(|(p, _)| p.translated(-middle)).collect();
        let mut normals = self.normals;
        if !normals.is_empty() {
            normals.resize(self.positions.len(), Vec3::ZERO);
        }
        let positions: Vec<Vec3> = self.positions.iter().map(|p| (*p - middle).as_vec3()).collect();
        let mut texcoords = self.texcoords;
        if !texcoords.is_empty() {
            texcoords.resize(positions.len(), Vec2::ZERO);
        }
        let mesh = Arc::new(Mesh { positions, normals, texcoords, triangles: self.triangles });
        let charts: Vec<Chart> = std::iter::once(Chart::default())
            .chain(self.charts.iter().map(|(_, c)| *c))
            .map(|c| c.translated(-middle))
            .collect();
        // Of several for one place the last counts.
        let chart_of = |place: Place| self.charts.iter().rposition(|(p, _)| *p == place).map_or(0, |i| i as u32 + 1);
        let glow_of = |place: Place| {
            let (_, texture, scale) = self.glows.iter().rfind(|(p, ..)| *p == place)?;
            let (texture, chart) = (self.textures[*texture as usize].clone(), charts[chart_of(place) as usize]);
            Some(Arc::new(Glow { texture, chart, scale: *scale }))
        };

        let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let boxes: Vec<Bounds> = shapes.iter().map(Shape::bounds).collect();
        let farthest = corners
            .iter()
            .flatten()
            .map(|p| p.abs().max_element())
            .chain(boxes.iter().map(|b| b.min.abs().max(b.max.abs()).max_element()))
            .fold(0.0, f32::max);
        // Squares and products of three coordinates must stay finite.
        if farthest.is_nan() || farthest > 1e12 {
            return Err(BuildError::TooLarge(f64::from(farthest)));
        }
        let bounds = boxes.iter().copied().fold(Bounds::of(corners.iter().flatten().copied()), Bounds::union);
        let domain = domain(bounds, !planes.is_empty());

        let mut lights = Vec::new();
        let mut course_lights = Vec::new();
        for (kind, strength) in &self.sources {
            let (light, course) = resolve_source(kind, *strength, middle);
            lights.push(light);
            course_lights.push(course);
        }
        let mut area_light = |emitter: Emitter, radiance: Rgb, place: Place| {
            (radiance != Rgb::ZERO).then(|| {
                let light = Light::Area(Area { emitter, radiance, glow: glow_of(place) });
                course_lights.push(course_area_light(&light));
                lights.push(light);
                lights.len() as u32 - 1
            })
        };
        let shape_attributes = shapes
            .iter()
            .zip(&self.shapes)
            .enumerate()
            .map(|(i, (shape, (_, material, radiance)))| Attributes {
                material: *material,
                light: area_light(Emitter::Shape(shape.clone()), *radiance, Place::Shape(i)),
                chart: chart_of(Place::Shape(i)),
            })
            .collect();
        let ends: Vec<u32> =
            self.parts.iter().skip(1).map(|(first, ..)| *first).chain([mesh.triangles.len() as u32]).collect();
        let mut parts = Vec::new();
        let mut triangle_part = Vec::with_capacity(mesh.triangles.len());
        for ((first, material, radiance), end) in self.parts.iter().zip(ends) {
            let areas = (*first..end).map(|i| mesh.area(i as usize));
            let choice = if *radiance == Rgb::ZERO { None } else { Discrete::new(areas) };
            let light = choice.and_then(|choice| {
                let place = Place::Part(parts.len());
                area_light(Emitter::Triangles { mesh: mesh.clone(), first: *first, choice }, *radiance, place)
            });
            triangle_part.resize(end as usize, parts.len() as u32);
            let chart = chart_of(Place::Part(parts.len()));
            parts.push((*first, Attributes { material: *material, light, chart }));
        }
        // Last, as the course's lights know nothing of it.
        lights.extend(self.environment.map(Light::Environment));
        if let Some(i) = lights.iter().position(|light| !light.power(domain).is_finite()) {
            return Err(BuildError::TooBright(i));
        }
        let even_lights = if self.glows.is_empty() { Vec::new() } else { lights.iter().map(evened).collect() };
        let planes = planes.into_iter().zip(&self.planes).enumerate().map(|(i, (plane, (_, material)))| {
            (plane, Attributes { material: *material, light: None, chart: chart_of(Place::Plane(i)) })
        });
        let planes = planes.collect();
        let mut scene = Scene {
            camera: camera.translated(-middle),
            background: self.background,
            materials: self.materials,
            hierarchy: Hierarchy::build(&corners, &boxes),
            planes,
            dresses: self.dresses,
            textures: self.textures,
            charts,
            lights,
            even_lights,
            course_lights,
            shapes,
            shape_attributes,
            mesh,
            parts,
            triangle_part,
            domain,
            middle,
            camera_inside: Inside::NOTHING,
            light_inside: Vec::new(),
        };
        if scene.has_bodies() {
            scene.camera_inside = scene.inside_at(scene.camera.center().as_vec3());
            scene.light_inside =
                scene.lights.iter().map(|l| l.start().map_or(Inside::NOTHING, |p| scene.inside_at(p))).collect();
        } else {
            scene.light_inside = vec![Inside::NOTHING; scene.lights.len()];
        }
        Ok(scene)
    }

    /// The middle of the box around the bounded shapes, or the eye where there are none.
    fn middle(&self, camera: &Pinhole) -> DVec3 {
        let mut min = DVec3::INFINITY;
        let mut max = DVec3::NEG_INFINITY;
        for (shape, ..) in &self.shapes {
            let (lo, hi) = shape.extent();
            (min, max) = (min.min(lo), max.max(hi));
        }
        for v in self.triangles.iter().flatten() {
            let p = self.positions[*v as usize];
            (min, max) = (min.min(p), max.max(p));
        }
        if min.cmple(max).all() { min * 0.5 + max * 0.5 } else { camera.center() }
    }
}

fn domain(bounds: Bounds, open: bool) -> Sphere {
    let ball = bounds.bounding_sphere();
    Sphere { center: ball.center, radius: if open { ball.radius * OPEN_DOMAIN } else { ball.radius } }
}

/// The light with the same radiance everywhere.
fn evened(light: &Light) -> Light {
    match light {
        Light::Area(area) => Light::Area(Area { glow: None, ..area.clone() }),
        other => other.clone(),
    }
}

/// The light and its course colour. A course colour c means irradiance π·c on a facing surface at the middle, so that a white
/// matt surface there reflects radiance c.
fn resolve_source(kind: &SourceKind, strength: LightStrength, middle: DVec3) -> (Light, CourseLight) {
    // A light at the very middle is taken to be one unit away.
    let distance2 = |p: &DVec3| {
        let d2 = (*p - middle).length_squared() as f32;
        if d2 > 0.0 { d2 } else { 1.0 }
    };
    let to_intensity = |position: &DVec3, watts_to_intensity: f32| match strength {
        LightStrength::Course(c) => (c * (PI * distance2(position)), c),
        LightStrength::Physical(i) => (i, i / (PI * distance2(position))),
        LightStrength::Power(w) => (w * watts_to_intensity, w * (watts_to_intensity / (PI * distance2(position)))),
    };
    match kind {
        SourceKind::Point { position } => {
            let (intensity, color) = to_intensity(position, 1.0 / (4.0 * PI));
            let place = (*position - middle).as_vec3();
            (Light::Point { position: place, intensity }, CourseLight::Point(place, color))
        }
        SourceKind::Spot { position, axis, inner, outer } => {
            let place = (*position - middle).as_vec3();
            let mut spot = Spot {
                position: place,
                axis: axis.normalize().as_vec3(),
                cos_inner: libm::cos(*inner) as f32,
                cos_outer: libm::cos(*outer) as f32,
                peak: Rgb::ONE,
            };
            let (peak, color) = to_intensity(position, 1.0 / spot.power().x);
            spot.peak = peak;
            (Light::Spot(spot), CourseLight::Point(place, color))
        }
        SourceKind::Directional { direction } => {
            let (irradiance, color) = match strength {
                LightStrength::Course(c) => (c * PI, c),
                LightStrength::Physical(e) | LightStrength::Power(e) => (e, e / PI),
            };
            let direction = direction.normalize().as_vec3();
            (Light::Directional { direction, irradiance }, CourseLight::Directional(direction, color))
        }
    }
}

/// An area light as a point at its middle, as strong at the scene's middle as if it faced it.
fn course_area_light(light: &Light) -> CourseLight {
    let center = light.center().unwrap_or(Vec3::ZERO);
    let nowhere = Sphere { center: Vec3::ZERO, radius: 0.0 };
    let d2 = center.length_squared();
    let color = light.power(nowhere) / (PI * PI * if d2 > 0.0 { d2 } else { 1.0 });
    CourseLight::Point(center, color)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Sphere as Ball;

    fn camera() -> Pinhole {
        Pinhole::new(DVec3::new(0.0, 0.0, 9.0), DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap()
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
                builder.environment(Environment::constant(Rgb::splat(*radiance)).unwrap());
            }
            ball(&mut builder, DVec3::ZERO, Rgb::ONE);
            builder.build(camera()).unwrap()
        };
        let (without, with) = (scene(&[]), scene(&[2.0, 3.0]));
        assert_eq!((without.environment(), without.escaping(Vec3::X)), (None, Rgb::splat(0.5)));
        assert_eq!((with.environment(), with.escaping(Vec3::X)), (Some(1), Rgb::splat(3.0)));
        assert_eq!((with.lights().len(), with.course_lights().len()), (2, 1));
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
