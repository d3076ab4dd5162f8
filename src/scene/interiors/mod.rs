//! Nested dielectrics: the bodies and media around a point of a path.

mod body;
mod boundary_context;
mod coincident;
mod locate;
mod spectral;
mod stack;
mod with_interior_type;

pub use body::Body;
pub use boundary_context::BoundaryContext;
pub(super) use coincident::{
    CoincidentFace, CoincidentFaces, CoincidentFlags, coincident_faces_at, flag_coincident_primitives,
};
pub(super) use locate::interior_stack_at;
pub use spectral::SpectralInterior;
pub(super) use stack::BodyInterface;
pub use stack::InteriorStack;
pub(crate) use with_interior_type::with_interior_type;

use super::{Effects, Scene, SurfaceInteraction};
use crate::bsdf::Bsdf;
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use coincident::{BoundarySides, boundary_sides};
use glam::Vec3;

/// Selects the type that implements [`Interior`] for the paths of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InteriorKind {
    /// [`NoInterior`]: paths track neither bodies nor media.
    Nothing,
    /// [`InteriorStack`]: paths track dielectric bodies, without media or a wavelength.
    Bodies,
    /// [`SpectralInterior`]: paths track dielectric bodies, and media or a wavelength or both.
    Spectral,
}

/// The event when a path meets a surface, which may be the boundary of a dielectric body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryEvent {
    /// The path scatters at the surface, or is absorbed there.
    Surface,
    /// The path passes unchanged, because another dielectric body of higher priority fills both
    /// sides of the boundary. Shadow rays are blocked nevertheless, so light that passes the
    /// boundary counts as a caustic.
    Hidden,
    /// Paths and shadow rays pass unchanged, because the boundary is a null interface.
    NullInterface,
}

/// The medium around a point of a path, and whether it is the ambient medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurrentMedium {
    /// Index of the medium in [`Scene::media`].
    pub medium_index: u32,
    /// True for the ambient medium, false for the medium of a dielectric body.
    pub ambient: bool,
}

/// The dielectric bodies and media around the current point of a path: [`SpectralInterior`],
/// [`InteriorStack`] or [`NoInterior`].
///
/// Path loops are compiled for each type, so that scenes without bodies or media pay nothing.
pub trait Interior: Copy + std::fmt::Debug + Send + Sync {
    /// True if paths may pass through media or carry a wavelength: for [`SpectralInterior`] alone.
    const HAS_MEDIA_OR_WAVELENGTH: bool;

    /// The interior (surrounding bodies and media) at the origin of `ray`, which starts a camera
    /// path.
    fn interior_at_camera(scene: &Scene, ray: &Ray, effects: Effects) -> Self;

    /// The interior (surrounding bodies and media) at the origin of `ray`, which starts a light
    /// path on light `light`.
    fn interior_at_light(scene: &Scene, light: usize, ray: &Ray, effects: Effects) -> Self;

    /// Sets the uniform number in \[0, 1) from which the path samples its first wavelength.
    ///
    /// The closure `sample` returns this number. It is called only if the path can meet dispersive
    /// surfaces. If this method is not called, the path samples its first wavelength with a number
    /// from the random key of the vertex.
    #[inline]
    fn set_wavelength_sample(&mut self, _: &Scene, _sample: impl FnOnce() -> f32) {}

    /// The medium at the current point of the path; `None` outside of media.
    #[inline]
    fn current_medium(&self, _: &Scene) -> Option<CurrentMedium> {
        None
    }

    /// The wavelength that the path has sampled; `None` while the path carries all wavelengths.
    #[inline]
    fn wavelength(&self) -> Option<Wavelength> {
        None
    }

    /// Optical depth over `distance` \[length] due to absorption in the dielectric body that fills
    /// the space around the path; media are not included.
    fn absorption_optical_depth(&self, scene: &Scene, distance: f32) -> Rgb;

    /// Transmittance over `distance` \[length] due to absorption in the dielectric body that fills
    /// the space around the path; media are not included.
    #[inline]
    fn absorption_transmittance(&self, scene: &Scene, distance: f32) -> Rgb {
        exp_neg(self.absorption_optical_depth(scene, distance))
    }

    /// Adds to the interior the dielectric body that `surface` bounds, if the path leaves this body
    /// without having entered it.
    ///
    /// Such a path must have started inside the body.
    fn infer_starting_body(&mut self, surface: &SurfaceInteraction<'_>);

    /// Returns the event for a path that meets `surface`.
    ///
    /// If `surface` bounds a dielectric body and is no null interface, the method also sets the
    /// BSDF of `surface` for the refractive indices on both sides.
    fn resolve_boundary(
        &mut self,
        scene: &Scene,
        surface: &mut SurfaceInteraction<'_>,
        context: &BoundaryContext,
    ) -> BoundaryEvent;

    /// Updates the interior for a path that crosses `surface` in unit `direction`: enters or leaves
    /// the dielectric body that `surface` bounds, if any.
    fn cross_boundary(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3);

    /// Returns the factor by which the path throughput changes on arrival at `surface`, before
    /// scattering.
    ///
    /// The factor is the weight of the wavelength if the path samples one at `surface` and the
    /// surface is not specular. In all other cases, the factor is 1.
    #[inline]
    fn wavelength_weight_before_scattering(&mut self, _: &SurfaceInteraction<'_>) -> Rgb {
        Rgb::ONE
    }

    /// Returns the factor by which the path throughput changes after scattering at `surface`.
    ///
    /// The factor is the weight of the wavelength if the path has sampled one at `surface` and the
    /// surface is specular. A reflected path may instead get a factor with which it continues with
    /// all wavelengths. In all other cases, the factor is 1. The last argument is true if the path
    /// is transmitted through the surface.
    #[inline]
    fn wavelength_weight_after_scattering(&mut self, _: &SurfaceInteraction<'_>, _: bool) -> Rgb {
        Rgb::ONE
    }
}

/// Transmittance exp(−depth) of an optical depth.
#[inline]
pub(super) fn exp_neg(depth: Rgb) -> Rgb {
    if depth == Rgb::ZERO { Rgb::ONE } else { (-depth).map(libm::expf) }
}

/// The [`Interior`] of paths that ignore dielectric bodies: no body absorbs light, and the outer
/// side of each boundary is air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoInterior;

impl Interior for NoInterior {
    const HAS_MEDIA_OR_WAVELENGTH: bool = false;

    fn interior_at_camera(_: &Scene, _: &Ray, _: Effects) -> Self {
        Self
    }

    fn interior_at_light(_: &Scene, _: usize, _: &Ray, _: Effects) -> Self {
        Self
    }

    #[inline]
    fn absorption_optical_depth(&self, _: &Scene, _: f32) -> Rgb {
        Rgb::ZERO
    }

    #[inline]
    fn infer_starting_body(&mut self, _: &SurfaceInteraction<'_>) {}

    #[inline]
    fn resolve_boundary(&mut self, _: &Scene, _: &mut SurfaceInteraction<'_>, _: &BoundaryContext) -> BoundaryEvent {
        BoundaryEvent::Surface
    }

    #[inline]
    fn cross_boundary(&mut self, _: &SurfaceInteraction<'_>, _: Vec3) {}
}

impl Interior for InteriorStack {
    const HAS_MEDIA_OR_WAVELENGTH: bool = false;

    fn interior_at_camera(scene: &Scene, ray: &Ray, _: Effects) -> Self {
        if scene.camera.is_orthographic() {
            interior_stack_at(scene, ray.origin)
        } else {
            scene.derived.camera_interior
        }
    }

    fn interior_at_light(scene: &Scene, light: usize, ray: &Ray, _: Effects) -> Self {
        if scene.derived.lights_across_boundaries[light] {
            interior_stack_at(scene, ray.origin)
        } else {
            scene.derived.light_interiors[light]
        }
    }

    #[inline]
    fn absorption_optical_depth(&self, scene: &Scene, distance: f32) -> Rgb {
        match self.dominant_body(&scene.materials) {
            Some((_, body)) if body.absorption != Rgb::ZERO => body.absorption * distance,
            _ => Rgb::ZERO,
        }
    }

    #[inline]
    fn infer_starting_body(&mut self, surface: &SurfaceInteraction<'_>) {
        if surface.material.enclosed_body().is_some()
            && !surface.is_entering()
            && !self.contains(surface.material_index)
        {
            self.insert_outermost_body(surface.material_index);
        }
    }

    #[inline]
    fn resolve_boundary(
        &mut self,
        scene: &Scene,
        surface: &mut SurfaceInteraction<'_>,
        context: &BoundaryContext,
    ) -> BoundaryEvent {
        let Some(body) = surface.material.enclosed_body() else { return BoundaryEvent::Surface };
        let (event, body, interface) = resolve_interface(self, scene, surface, *body, context);
        if event != BoundaryEvent::NullInterface {
            let eta = interface.relative_eta(&body, |body| body.eta);
            surface.bsdf =
                Bsdf::dielectric(eta, surface.boundary_roughness, surface.material.boundary_microfacet_scattering());
        }
        event
    }

    #[inline]
    fn cross_boundary(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3) {
        if surface.material.enclosed_body().is_none() {
            return;
        }
        if surface.coincident.is_empty() {
            self.enter_or_leave_body(surface.material_index, direction, surface.point.ng);
        } else {
            let entering = direction.dot(surface.point.ng) < 0.0;
            *self = self.stack_after_crossing(CoincidentFace::from_surface(surface, entering), &surface.coincident);
        }
    }
}

/// Resolves the boundary `surface`, which a path meets. Returns three values: the event for the
/// path, the dielectric body on the inner side of `surface`, and the interface between both sides.
///
/// Argument `body` is the body that `surface` bounds. Other boundaries that coincide with `surface`
/// may change the bodies on both sides. `surface` gets the greatest roughness of all these
/// boundaries.
#[inline]
fn resolve_interface(
    stack: &InteriorStack,
    scene: &Scene,
    surface: &mut SurfaceInteraction<'_>,
    body: Body,
    context: &BoundaryContext,
) -> (BoundaryEvent, Body, BodyInterface) {
    let wo = surface.wo;
    surface.coincident = coincident_faces_at(scene, surface, &|hit, point, group| {
        context.leaf_material_at(scene, hit, (point, wo), group)
    });
    let entering = surface.is_entering();
    if !surface.coincident.is_empty() {
        let BoundarySides { near, far, is_null_interface, roughness } =
            boundary_sides(stack, scene, surface, &body, entering);
        surface.boundary_roughness = roughness;
        let (inner, outer) = if entering { (far, near) } else { (near, far) };
        let is_hidden = inner.map(|(material, _)| material) == outer.map(|(material, _)| material);
        let interface = BodyInterface { is_hidden, outside: outer.map(|(_, body)| *body) };
        let inner = inner.map_or_else(|| Body::new(1.0), |(_, body)| *body);
        return (
            if is_null_interface { BoundaryEvent::NullInterface } else { interface.boundary_event() },
            inner,
            interface,
        );
    }
    let interface = stack.interface_at_boundary(surface.material_index, &body, entering, &scene.materials);
    (if body.is_null_interface { BoundaryEvent::NullInterface } else { interface.boundary_event() }, body, interface)
}
