//! The resolved scene: everything looked up, checked, converted, re-centred, in typed arrays. Renderers see only this.

mod builder;
mod dress;
mod effects;
mod error;
mod immersed;
mod inside;
mod interior;
mod light_contact;
mod material;
mod middle;
mod movement;
mod neighbours;
mod nothing;
mod objects;
mod path_ray;
mod ray_cone;
mod settle;
mod source;
mod surface;
mod touching;
mod wardrobe;

pub use builder::SceneBuilder;
pub use dress::{Coat, Dress, Relief, Tint};
pub use effects::{Effect, Effects};
pub use error::BuildError;
pub use immersed::SpectralInterior;
pub use inside::InteriorStack;
pub use interior::{BoundaryEvent, Filling, Interior, InteriorKind, NoInterior};
pub use material::{Body, Material, PhongAppearance, Scattering};
pub use objects::Object;
pub use path_ray::{MediumSegment, PathEvent, PathRay, SurfaceVertex};
pub use ray_cone::RayCone;
pub use source::{LightStrength, SourceKind};
pub use surface::SurfaceInteraction;

use crate::accel::{Hierarchy, Primitive};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::color::{Glass, Rgb};
use crate::light::Light;
use crate::math::{Bounds, Ray, Sphere};
use crate::medium::Medium;
use crate::shape::{Mesh, Plane, Shape, SurfacePoint, TextureMapping};
use crate::texture::Texture;
use glam::{DVec3, Vec2, Vec3};
use movement::Movement;
use neighbours::Neighbours;
use std::sync::Arc;
use touching::Touching;

/// What a surface is made of, and which light it is.
#[derive(Clone, Copy, Debug)]
struct Attributes {
    material: u32,
    light: Option<u32>,
    /// How textures lie on it.
    chart: u32,
}

/// A light as the course's shading sees it: a direction or a place, and a colour that does not fall off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LegacyLight {
    /// From a place.
    Point(Vec3, Rgb),
    /// Along a unit direction of travel.
    Directional(Vec3, Rgb),
}

/// A scene ready to be rendered, as it stands at one time. Coordinates are relative to its own middle.
#[derive(Clone)]
pub struct Scene {
    camera: Camera,
    background: Rgb,
    materials: Vec<Material>,
    /// Indices of refraction that depend on the wavelength.
    glasses: Vec<Glass>,
    media: Vec<Medium>,
    /// The medium that is wherever no body is.
    filling: Option<u32>,
    /// Where that ends.
    filled: Sphere,
    dresses: Vec<Dress>,
    textures: Vec<Arc<Texture>>,
    /// The first is that of what has none of its own.
    charts: Vec<TextureMapping>,
    lights: Vec<Light>,
    /// The lights with their mean radiance; none where no light follows a texture.
    mean_lights: Vec<Light>,
    legacy_lights: Vec<LegacyLight>,
    /// Over triangles, and the shapes that do not move.
    hierarchy: Arc<Hierarchy>,
    /// Over the shapes that move: those from `first_moving` on.
    moving: Option<Arc<Hierarchy>>,
    first_moving: u32,
    movement: Option<Arc<Movement>>,
    /// Around what does not move.
    still: Bounds,
    shapes: Vec<Shape>,
    shape_attributes: Vec<Attributes>,
    planes: Vec<(Plane, Attributes)>,
    mesh: Arc<Mesh>,
    /// First triangle of each mesh with its attributes, ascending.
    parts: Vec<(u32, Attributes)>,
    /// The part of each triangle.
    triangle_part: Arc<[u32]>,
    domain: Sphere,
    middle: DVec3,
    /// What the camera is inside of.
    camera_inside: InteriorStack,
    /// What each light is inside of.
    light_inside: Vec<InteriorStack>,
    /// How near to a surface each light is taken to stand in it.
    light_contact: Vec<f32>,
    /// Which boundaries of bodies may coincide.
    neighbours: Neighbours,
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene")
            .field("triangles", &self.triangle_count())
            .field("shapes", &self.shape_count())
            .field("lights", &self.lights)
            .field("materials", &self.materials)
            .finish_non_exhaustive()
    }
}

/// A crossing of a ray with the scene, not yet looked at.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    kind: HitKind,
}

#[derive(Clone, Copy, Debug)]
enum HitKind {
    Triangle(u32, Vec2),
    Shape(u32, Vec2),
    Plane(u32),
}

impl Scene {
    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Radiance of rays that meet nothing where there is no environment: it is seen, but lights nothing.
    #[must_use]
    pub fn background(&self) -> Rgb {
        self.background
    }

    /// Radiance that a ray in unit `direction` which meets nothing finds: the environment's, else the background.
    #[inline]
    #[must_use]
    pub fn escaping(&self, direction: Vec3) -> Rgb {
        match self.lights.last() {
            Some(Light::Environment(environment)) => environment.radiance(direction),
            _ => self.background,
        }
    }

    /// The index of the environment among the lights, if there is one.
    #[must_use]
    pub fn environment(&self) -> Option<usize> {
        matches!(self.lights.last(), Some(Light::Environment(_))).then(|| self.lights.len() - 1)
    }

    /// The lights; an environment comes last.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The lights, each with the same radiance everywhere.
    #[must_use]
    pub fn mean_lights(&self) -> &[Light] {
        if self.mean_lights.is_empty() { &self.lights } else { &self.mean_lights }
    }

    /// The lights as the course's shading sees them, in the same order. An environment is none of them.
    #[must_use]
    pub fn legacy_lights(&self) -> &[LegacyLight] {
        &self.legacy_lights
    }

    /// The materials.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The refractive indices that depend on the wavelength.
    #[must_use]
    pub fn glasses(&self) -> &[Glass] {
        &self.glasses
    }

    /// The media.
    #[must_use]
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// Index of the medium that is wherever no body is, in a ball twice as large as one around the bounded shapes, the camera and the lights.
    #[must_use]
    pub fn filling(&self) -> Option<u32> {
        self.filling
    }

    /// The ball in which photons of light from infinity are followed: it holds all bounded shapes, with room around them where an
    /// unbounded plane catches light.
    #[must_use]
    pub fn domain(&self) -> Sphere {
        self.domain
    }

    /// What was subtracted from all coordinates of the description.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.middle
    }

    /// How many triangles there are, those of meshes that are placed again counted again.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        let placed = |shape: &Shape| if let Shape::Instance(instance) = shape { instance.triangles() } else { 0 };
        self.mesh.triangles.len() + self.shapes.iter().map(placed).sum::<usize>()
    }

    /// How many analytic shapes there are, planes included.
    #[must_use]
    pub fn shape_count(&self) -> usize {
        let placed = |shape: &&Shape| !matches!(shape, Shape::Instance(_));
        self.shapes.iter().filter(placed).count() + self.planes.len()
    }

    /// The nearest crossing.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let bounded = self.hierarchy.closest(ray, |i, ray| self.shapes[i as usize].intersect(ray));
        let mut hit = bounded.map(|h| Hit {
            t: h.t,
            kind: match h.primitive {
                Primitive::Triangle(i) => HitKind::Triangle(i, Vec2::new(h.u, h.v)),
                Primitive::Other(i) => HitKind::Shape(i, Vec2::new(h.u, h.v)),
            },
        });
        if let Some(moving) = &self.moving {
            let within = Ray { t_max: hit.map_or(ray.t_max, |h| h.t), ..*ray };
            let first = self.first_moving;
            if let Some(h) = moving.closest(&within, |i, ray| self.shapes[(first + i) as usize].intersect(ray))
                && let Primitive::Other(i) = h.primitive
            {
                hit = Some(Hit { t: h.t, kind: HitKind::Shape(first + i, Vec2::new(h.u, h.v)) });
            }
        }
        for (i, (plane, _)) in self.planes.iter().enumerate() {
            let within = Ray { t_max: hit.map_or(ray.t_max, |h| h.t), ..*ray };
            if let Some((t, ..)) = plane.intersect(&within) {
                hit = Some(Hit { t, kind: HitKind::Plane(i as u32) });
            }
        }
        hit
    }

    /// Whether anything lies within the ray.
    #[inline]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.planes.iter().any(|(plane, _)| plane.intersect(ray).is_some())
            || self.hierarchy.occluded(ray, |i, ray| self.shapes[i as usize].occludes(ray))
            || self.moving.as_ref().is_some_and(|moving| {
                let first = self.first_moving;
                moving.occluded(ray, |i, ray| self.shapes[(first + i) as usize].occludes(ray))
            })
    }

    /// The surface at a crossing of `ray`, whose direction must be of unit length, with textures blurred over `cone`; `chance` in
    /// \[0, 1) chooses where materials are mixed. A boundary of a body scatters as if nothing else were around.
    #[inline]
    #[must_use]
    pub fn surface(
        &self,
        ray: &Ray,
        hit: &Hit,
        cone: &RayCone,
        chance: impl FnOnce() -> f32,
    ) -> SurfaceInteraction<'_> {
        let (point, attributes) = self.point(ray, hit);
        let wo = -ray.direction;
        let emission = match attributes.light.map(|l| &self.lights[l as usize]) {
            Some(Light::Area(area)) if wo.dot(point.ng) > 0.0 => match &area.texture {
                Some(glow) if cone.effects.has(Effect::Textures) => self.glow(glow, hit, &point, wo, cone),
                _ => area.radiance,
            },
            _ => Rgb::ZERO,
        };
        let mut index = attributes.material;
        let mut material = &self.materials[index as usize];
        if let Scattering::Mix { .. } = material.scattering {
            index = if cone.effects.has(Effect::Textures) && !self.dresses.is_empty() {
                self.chosen_by_texture(index, chance(), &|| self.place(hit, &point, wo, cone))
            } else {
                self.chosen(index, chance(), |_, amount| amount)
            };
            material = &self.materials[index as usize];
        }
        let (bsdf, roughness) = match material.scattering {
            Scattering::Fixed(bsdf) => (bsdf, 0.0),
            Scattering::Boundary(body) => (Bsdf::dielectric(body.index, body.roughness), body.roughness),
            Scattering::Mix { .. } => (Bsdf::Black, 0.0),
        };
        let (light, touching) = (attributes.light, Touching::NONE);
        let crowded = self.neighbours.may(hit.kind).then(|| self.thing_of(hit.kind));
        let mut surface =
            SurfaceInteraction { point, wo, material, index, bsdf, roughness, crowded, touching, light, emission };
        if let Some(dress) = material.dress {
            self.put_on(dress, &mut surface, hit, cone);
        }
        surface
    }

    #[inline]
    fn point(&self, ray: &Ray, hit: &Hit) -> (SurfacePoint, Attributes) {
        match hit.kind {
            HitKind::Triangle(i, b) => {
                let part = self.triangle_part[i as usize] as usize;
                (self.mesh.surface(i as usize, b), self.parts[part].1)
            }
            HitKind::Shape(i, uv) => {
                (self.shapes[i as usize].surface(ray, hit.t, uv), self.shape_attributes[i as usize])
            }
            HitKind::Plane(i) => {
                let (plane, attributes) = &self.planes[i as usize];
                (plane.surface(ray, hit.t), *attributes)
            }
        }
    }

    /// The geometric normal at a crossing of `ray`, whose direction must be of unit length.
    #[inline]
    #[must_use]
    pub fn normal_at(&self, ray: &Ray, hit: &Hit) -> Vec3 {
        self.point(ray, hit).0.ng
    }

    /// What a mix stands for this time; `share` gives the share of the second of each mix on the way, of which it gets the material and the
    /// amount that is the same everywhere.
    fn chosen(&self, mut index: u32, mut chance: f32, share: impl Fn(&Material, f32) -> f32) -> u32 {
        while let material = &self.materials[index as usize]
            && let Scattering::Mix { first, second, amount } = material.scattering
        {
            let amount = share(material, amount);
            // What is left of the number inside the chosen part is uniform again.
            (index, chance) =
                if chance < amount { (second, chance / amount) } else { (first, (chance - amount) / (1.0 - amount)) };
        }
        index
    }

    /// A camera subpath that starts along `ray` and simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_camera_path<I: Interior>(&self, ray: Ray, effects: Effects) -> PathRay<I> {
        PathRay { ray, inside: I::at_camera(self, &ray, effects), cone: self.camera_cone(effects) }
    }

    /// The cone of a ray from the camera.
    #[inline]
    #[must_use]
    pub fn camera_cone(&self, effects: Effects) -> RayCone {
        RayCone::of_pixel(self.camera.pixel(), effects)
    }

    /// A light subpath that starts at `light` along `ray` and simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_light_path<I: Interior>(&self, light: usize, ray: Ray, effects: Effects) -> PathRay<I> {
        PathRay { ray, inside: I::at_light(self, light, effects), cone: RayCone::point(effects) }
    }

    /// The ray with its start moved back to where nothing unbounded lies behind it: light from infinity comes from beyond all planes.
    #[must_use]
    pub(crate) fn starting_beyond_planes(&self, ray: Ray) -> Ray {
        let back = Ray::new(ray.origin, -ray.direction);
        let crossings = self.planes.iter().filter_map(|(plane, _)| plane.intersect(&back));
        let farthest = crossings.map(|(t, ..)| t).fold(0.0, f32::max);
        if farthest == 0.0 {
            return ray;
        }
        // As far again as the domain is wide, so that the crossing itself is not lost to rounding.
        Ray { origin: back.at(farthest * 1.001 + self.domain.radius), ..ray }
    }
}
