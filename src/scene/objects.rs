//! What a scene holds, as planning sees it.

use super::{Attributes, Body, Coat, Dress, Material, Relief, Scattering, Scene};
use crate::bsdf::{Bsdf, Conductor};
use crate::light::Light;
use crate::math::{Bounds, Sphere};
use crate::medium::Medium;
use glam::Vec3;

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
    /// Whether it emits by a texture.
    pub glows: bool,
}

impl Scene {
    /// Everything that is made of something.
    pub fn objects(&self) -> impl Iterator<Item = Object> {
        let shapes = self.shapes.iter().zip(&self.shape_attributes).map(|(shape, attributes)| Object {
            ball: Some(shape.bounding_sphere()),
            plane: shape.planar_point().map(|point| (point.p, point.ng)),
            material: attributes.material,
            glows: self.glows(attributes),
        });
        let ends = self.parts.iter().skip(1).map(|(first, _)| *first).chain([self.mesh.triangles.len() as u32]);
        let parts = self.parts.iter().zip(ends).filter(|((first, _), end)| first < end);
        let meshes = parts.map(|((first, attributes), end)| {
            let corners = (*first..end).flat_map(|i| self.mesh.corners(i as usize));
            let ball = Some(Bounds::of(corners).bounding_sphere());
            Object { ball, plane: None, material: attributes.material, glows: self.glows(attributes) }
        });
        let planes = self.planes.iter().map(|(plane, attributes)| Object {
            ball: None,
            plane: Some(plane.place()),
            material: attributes.material,
            glows: false,
        });
        shapes.chain(meshes).chain(planes)
    }

    /// Whether a material is the boundary of a body, so that walks have to remember what they are inside of.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        self.bodies().next().is_some()
    }

    /// Whether walks have to remember what they are inside of: bodies, or the medium around them.
    #[must_use]
    pub fn has_interiors(&self) -> bool {
        self.filling.is_some() || self.has_bodies()
    }

    /// The bodies that materials bound.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.materials.iter().filter_map(|m| match &m.scattering {
            Scattering::Boundary(body) => Some(body),
            _ => None,
        })
    }

    fn glows(&self, attributes: &Attributes) -> bool {
        let light = attributes.light.map(|light| &self.lights[light as usize]);
        matches!(light, Some(Light::Area(area)) if area.texture.is_some())
    }

    /// Tells `hear` of every scattering that a material can stand for: one, but of a mix all its parts, and of a texture what divides
    /// one kind of scattering from another.
    pub fn scatterings(&self, material: u32, hear: &mut impl FnMut(&Scattering)) {
        let Material { scattering, dress, .. } = &self.materials[material as usize];
        match scattering {
            Scattering::Mix { first, second, .. } => {
                self.scatterings(*first, hear);
                self.scatterings(*second, hear);
            }
            scattering => hear(scattering),
        }
        if let Some(Coat::Conductor { eta, k, roughness }) = dress.map(|dress| self.dresses[dress as usize].coat) {
            let (least, most) = self.textures[roughness as usize].range();
            for alpha in [least, most] {
                hear(&Scattering::Fixed(Bsdf::Conductor(Conductor::new(eta, k, alpha))));
            }
        }
    }

    /// The media that are somewhere, each once: in what bounds a body, or wherever no body is.
    #[must_use]
    pub fn media_in_use(&self) -> Vec<&Medium> {
        let mut indices: Vec<u32> = self.filling.into_iter().collect();
        for object in self.objects() {
            self.scatterings(object.material, &mut |scattering| {
                if let Scattering::Boundary(body) = scattering {
                    indices.extend(body.medium);
                }
            });
        }
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|index| &self.media[index as usize]).collect()
    }

    /// Whether a material, or a part of a mix, has textures, and whether it has bumps.
    #[must_use]
    pub fn wears(&self, material: u32) -> (bool, bool) {
        let Material { scattering, dress, .. } = &self.materials[material as usize];
        let own = dress.map_or((false, false), |dress| {
            let Dress { coat, relief } = self.dresses[dress as usize];
            (coat != Coat::Plain, relief != Relief::Smooth)
        });
        let parts = match scattering {
            Scattering::Mix { first, second, .. } => [*first, *second].map(|part| self.wears(part)),
            _ => [(false, false); 2],
        };
        parts.iter().fold(own, |all, part| (all.0 || part.0, all.1 || part.1))
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
