//! The resolved scene: everything looked up, checked, converted, re-centred, in typed arrays. Renderers see only this.

mod builder;
mod inside;
mod interior;
mod material;
mod movement;
mod source;
mod surface;
mod walk;

pub use builder::{BuildError, SceneBuilder};
pub use inside::Inside;
pub use interior::{Interior, Open};
pub use material::{Body, Look, Material, Scattering};
pub use source::{LightStrength, SourceKind};
pub use surface::Surface;
pub use walk::{Arrival, Walk};

use crate::accel::{Hierarchy, Primitive};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::light::Light;
use crate::math::{Bounds, Ray, Sphere};
use crate::shape::{Mesh, Plane, Shape, SurfacePoint};
use glam::{DVec3, Vec2, Vec3};
use movement::Movement;
use std::sync::Arc;

/// What a surface is made of, and which light it is.
#[derive(Clone, Copy, Debug)]
struct Attributes {
    material: u32,
    light: Option<u32>,
}

/// A light as the course's shading sees it: a direction or a place, and a colour that does not fall off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CourseLight {
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
    lights: Vec<Light>,
    course_lights: Vec<CourseLight>,
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
    camera_inside: Inside,
    /// What each light is inside of.
    light_inside: Vec<Inside>,
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

    /// The lights as the course's shading sees them, in the same order. An environment is none of them.
    #[must_use]
    pub fn course_lights(&self) -> &[CourseLight] {
        &self.course_lights
    }

    /// The materials.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
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

    /// The surface at a crossing of `ray`, whose direction must be of unit length; `chance` in \[0, 1) chooses where materials are
    /// mixed. A boundary of a body scatters as if nothing else were around.
    #[inline]
    #[must_use]
    pub fn surface(&self, ray: &Ray, hit: &Hit, chance: impl FnOnce() -> f32) -> Surface<'_> {
        let (point, attributes) = self.point(ray, hit);
        let wo = -ray.direction;
        let emission = match attributes.light.map(|l| &self.lights[l as usize]) {
            Some(Light::Area(area)) if wo.dot(point.ng) > 0.0 => area.radiance,
            _ => Rgb::ZERO,
        };
        let mut index = attributes.material;
        let mut material = &self.materials[index as usize];
        if let Scattering::Mix { .. } = material.scattering {
            index = self.chosen(index, chance());
            material = &self.materials[index as usize];
        }
        let bsdf = match material.scattering {
            Scattering::Fixed(bsdf) => bsdf,
            Scattering::Boundary(body) => Bsdf::dielectric(body.index, body.roughness),
            Scattering::Mix { .. } => Bsdf::Black,
        };
        Surface { point, wo, material, index, bsdf, light: attributes.light, emission }
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

    /// What a mix stands for this time.
    fn chosen(&self, mut index: u32, mut chance: f32) -> u32 {
        while let Scattering::Mix { first, second, amount } = self.materials[index as usize].scattering {
            // What is left of the number inside the chosen part is uniform again.
            (index, chance) =
                if chance < amount { (second, chance / amount) } else { (first, (chance - amount) / (1.0 - amount)) };
        }
        index
    }

    /// A walk from the camera along `ray`.
    #[inline]
    #[must_use]
    pub fn walk_from_camera<I: Interior>(&self, ray: Ray) -> Walk<I> {
        Walk { ray, inside: I::at_camera(self) }
    }

    /// A walk from a light along `ray`.
    #[inline]
    #[must_use]
    pub fn walk_from_light<I: Interior>(&self, light: usize, ray: Ray) -> Walk<I> {
        Walk { ray, inside: I::at_light(self, light) }
    }

    /// Whether a material is the boundary of a body, so that walks have to remember what they are inside of.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        self.materials.iter().any(|m| matches!(m.scattering, Scattering::Boundary(_)))
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

    /// Everything that is made of something.
    pub fn objects(&self) -> impl Iterator<Item = Object> {
        let shapes = self.shapes.iter().zip(&self.shape_attributes).map(|(shape, attributes)| Object {
            ball: Some(bounding_ball(shape)),
            plane: match shape {
                Shape::Disc(_) | Shape::Rectangle(_) => {
                    let middle = shape.sample(Vec2::splat(0.5)).point;
                    Some((middle.p, middle.ng))
                }
                Shape::Sphere(_) | Shape::Ellipsoid(_) | Shape::Instance(_) => None,
            },
            material: attributes.material,
        });
        let ends = self.parts.iter().skip(1).map(|(first, _)| *first).chain([self.mesh.triangles.len() as u32]);
        let parts = self.parts.iter().zip(ends).filter(|((first, _), end)| first < end);
        let meshes = parts.map(|((first, attributes), end)| {
            let corners = (*first..end).flat_map(|i| self.mesh.corners(i as usize));
            let ball = Some(Bounds::of(corners).bounding_sphere());
            Object { ball, plane: None, material: attributes.material }
        });
        let planes = self.planes.iter().map(|(plane, attributes)| Object {
            ball: None,
            plane: Some(plane.place()),
            material: attributes.material,
        });
        shapes.chain(meshes).chain(planes)
    }

    /// Tells `hear` of every scattering that a material can stand for: one, but of a mix all its parts.
    pub fn scatterings(&self, material: u32, hear: &mut impl FnMut(&Scattering)) {
        match &self.materials[material as usize].scattering {
            Scattering::Mix { first, second, .. } => {
                self.scatterings(*first, hear);
                self.scatterings(*second, hear);
            }
            scattering => hear(scattering),
        }
    }

    /// Balls around everything that casts caustics, for aiming photons; `None` where such a thing is unbounded.
    #[must_use]
    pub fn caster_balls(&self) -> Option<Vec<Sphere>> {
        self.objects().filter(|o| self.casts_caustics(o.material)).map(|o| o.ball).collect()
    }

    fn casts_caustics(&self, material: u32) -> bool {
        let mut casts = false;
        self.scatterings(material, &mut |scattering| casts |= scattering.casts_caustics());
        casts
    }
}

/// A shape, a mesh or a plane, as planning sees it.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// A ball around it, tight for spheres; `None` where it is unbounded.
    pub ball: Option<Sphere>,
    /// A point and the unit normal of the plane that it lies in; `None` where it is not flat for certain. No part of what is flat
    /// sees another.
    pub plane: Option<(Vec3, Vec3)>,
    /// Index of its material.
    pub material: u32,
}

/// A ball around a shape, tight for spheres.
fn bounding_ball(shape: &Shape) -> Sphere {
    match shape {
        Shape::Sphere(s) => Sphere { center: s.center.as_vec3(), radius: s.radius as f32 },
        other => other.bounds().bounding_sphere(),
    }
}
