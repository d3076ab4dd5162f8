//! Chains of specular vertices that camera rays follow, traced with their derivatives.
//!
//! The derivatives predict where lamp images lie: film regions where camera rays meet a small lamp.
//! Finite differences give the derivatives: a [`RayBundle`] holds a camera ray and its neighbours
//! on the film and on the lens, and traces them over the same vertices.

use crate::bsdf::TransportMode;
use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Effects, Interior, PathEvent, PathRay, Scene, SurfaceInteraction, SurfaceVertex};
use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};

/// Distance on the film between the camera ray of a [`RayBundle`] and its neighbours \[pixels].
const FILM_STEP: f32 = 0.02;

/// Distance on the lens between the camera ray of a [`RayBundle`] and its neighbours, relative to
/// the radius of the lens.
const RELATIVE_LENS_STEP: f64 = 0.02;

/// Number of rays of a [`RayBundle`]: a camera ray, two neighbours on the film, and two on the
/// lens.
const BUNDLE_RAYS: usize = 5;

/// Largest number of vertices of a chain of specular vertices.
const MAX_VERTICES: u32 = 24;

/// Choices between reflection and transmission at the vertices of a chain of specular surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct SpecularChain {
    /// Number of vertices of the chain.
    length: u32,
    /// Bit i is set if the chain transmits at vertex i, and clear if it reflects there.
    transmitted_bits: u32,
}

impl SpecularChain {
    /// Returns the chain with one more vertex at its end, which transmits or reflects.
    fn with_vertex(self, is_transmitted: bool) -> Self {
        Self {
            length: self.length + 1,
            transmitted_bits: self.transmitted_bits | u32::from(is_transmitted) << self.length,
        }
    }

    /// True if the chain transmits at vertex `vertex`, counted from 0.
    fn is_transmitted_at(self, vertex: u32) -> bool {
        self.transmitted_bits >> vertex & 1 == 1
    }
}

/// Film point and lens point through which a camera ray goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraPoint {
    /// Film point \[pixels from the top left].
    pub film: Vec2,
    /// Point on the lens \[length right and up from its center]; `None` if all camera rays start at
    /// the lens center.
    pub on_lens: Option<DVec2>,
}

impl CameraPoint {
    /// Returns the point on the lens \[length right and up from its center]; zero if all camera
    /// rays start at the lens center.
    pub fn lens_point(&self) -> Vec2 {
        self.on_lens.map_or(Vec2::ZERO, |on_lens| on_lens.as_vec2())
    }
}

/// A camera ray with its close neighbours on the film and on the lens, traced over the same
/// specular vertices. Finite differences of the rays give derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayBundle<I> {
    /// The camera ray, its neighbours right and below on the film, and its neighbours right and up
    /// on the lens.
    rays: [PathRay<I>; BUNDLE_RAYS],
    /// Number of rays that are traced: all five, or the first three if all camera rays start at the
    /// lens center.
    traced_ray_count: usize,
    /// Distance on the lens between the camera ray and its neighbours \[length].
    lens_step: f64,
    /// Factor from radiance that arrives along the camera ray to radiance of the pixel.
    pub throughput: Rgb,
    /// Chain of the specular vertices that the rays have passed.
    pub chain: SpecularChain,
    /// Sampler of the next vertex's random decisions.
    sampler: Sampler,
}

/// Sphere that stands for an area light: around the center of its bounding box, with half the
/// longest edge of the box as radius. The corners of the box may lie outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct LampSphere {
    pub center: DVec3,
    pub radius: f64,
    /// Index of the light in the scene.
    pub light: u32,
}

/// Position of a lamp relative to a camera ray, as a linear function of the ray's film and lens
/// point.
#[derive(Clone, Copy, Debug)]
pub(super) struct LampPassage {
    /// Distance between the camera ray and the center of the lamp, relative to the radius of the
    /// sphere that stands for the lamp ([`LampSphere`]). Below 1, the ray meets this sphere.
    pub relative_miss: f64,
    /// Vector on the film from the camera ray to the center of the lamp image \[pixels]. The lamp
    /// image is the film region where camera rays meet the lamp.
    pub to_image: DVec2,
    /// Shift of the lamp image (film region where camera rays meet the lamp) per shift of the lens
    /// point \[pixels/length].
    pub shift_per_lens_position: DMat2,
    /// Map from vectors on the film \[pixels] to coordinates in which the lamp image (film region
    /// where camera rays meet the lamp) is the unit disc.
    pub to_disc: DMat2,
}

impl<I: Interior> RayBundle<I> {
    /// Returns the bundle of the camera ray through `point`, before its first vertex.
    pub fn from_camera(scene: &Scene, effects: Effects, point: CameraPoint, sampler: Sampler) -> Self {
        let camera = scene.camera();
        let lens_step = camera.lens().map_or(0.0, |lens| lens.radius * RELATIVE_LENS_STEP);
        let count = if point.on_lens.is_some() { BUNDLE_RAYS } else { 3 };
        let ray = |film: Vec2, on_lens: DVec2| {
            let ray = match point.on_lens {
                None => camera.generate_ray(point.film + film, None),
                Some(at) => camera.generate_ray_through_lens_point(point.film + film, at + on_lens),
            };
            let mut path: PathRay<I> = scene.start_camera_path(ray, effects);
            path.interior.set_wavelength_sample(scene, || sampler.get_1d(Dimension::Wavelength));
            path
        };
        let rays = [
            ray(Vec2::ZERO, DVec2::ZERO),
            ray(Vec2::X * FILM_STEP, DVec2::ZERO),
            ray(Vec2::Y * FILM_STEP, DVec2::ZERO),
            ray(Vec2::ZERO, DVec2::X * lens_step),
            ray(Vec2::ZERO, DVec2::Y * lens_step),
        ];
        Self {
            rays,
            traced_ray_count: count,
            lens_step,
            throughput: Rgb::ONE,
            chain: SpecularChain::default(),
            sampler,
        }
    }

    /// Traces the camera ray to its next vertex, and returns the event there.
    pub fn next_vertex<'a>(&mut self, scene: &'a Scene) -> PathEvent<'a> {
        self.rays[0].next_vertex(scene, self.sampler.sample_key(), |_| None)
    }

    /// Returns the bundles that continue from `vertex`, the next vertex of the camera ray: first
    /// the reflected, then the transmitted one. A bundle is `None` if its throughput, as a mean
    /// over RGB, is below `min_throughput`, or if the surface of a ray does not scatter that way.
    ///
    /// Both are `None` if `vertex` or a neighbour's next vertex is not on a specular surface, or if
    /// the chain already has [`MAX_VERTICES`] vertices.
    pub fn scatter(self, scene: &Scene, vertex: &SurfaceVertex<'_>, min_throughput: f32) -> [Option<Self>; 2] {
        if self.chain.length >= MAX_VERTICES || !is_specular(&vertex.surface) {
            return [None; 2];
        }
        let mut traced = self;
        let mut neighbours = [None; BUNDLE_RAYS - 1];
        for (neighbour, ray) in neighbours.iter_mut().zip(&mut traced.rays[1..self.traced_ray_count]) {
            match ray.next_vertex(scene, self.sampler.sample_key(), |_| None) {
                PathEvent::Surface(vertex) if is_specular(&vertex.surface) => *neighbour = Some(vertex.surface),
                PathEvent::Surface(_) | PathEvent::Scattered { .. } | PathEvent::Escaped { .. } => return [None; 2],
            }
        }
        [false, true].map(|is_transmitted| {
            let (direction, weight) = scattered_direction(&vertex.surface, is_transmitted, self.sampler)?;
            let mut next = traced;
            let factor = next.rays[0].leave_surface_with_wavelength_weight(&vertex.surface, direction, is_transmitted);
            next.throughput *= vertex.absorption_and_wavelength_weight * weight * factor;
            if crate::color::channel_mean(next.throughput) < min_throughput {
                return None;
            }
            for (ray, surface) in next.rays[1..self.traced_ray_count].iter_mut().zip(neighbours.iter().flatten()) {
                let (direction, _) = scattered_direction(surface, is_transmitted, self.sampler)?;
                ray.leave_surface_with_wavelength_weight(surface, direction, is_transmitted);
            }
            next.chain = self.chain.with_vertex(is_transmitted);
            next.sampler = self.sampler.next_vertex_sampler(self.chain.length, is_transmitted);
            Some(next)
        })
    }

    /// Traces the bundle of the camera ray through `point` along the vertices of `chain`. Returns
    /// `None` if the bundle cannot follow the chain.
    pub fn follow(
        scene: &Scene,
        effects: Effects,
        point: CameraPoint,
        sampler: Sampler,
        chain: SpecularChain,
    ) -> Option<Self> {
        let mut bundle = Self::from_camera(scene, effects, point, sampler);
        for i in 0..chain.length {
            let PathEvent::Surface(vertex) = bundle.next_vertex(scene) else { return None };
            bundle = bundle.scatter(scene, &vertex, 0.0)[usize::from(chain.is_transmitted_at(i))]?;
        }
        Some(bundle)
    }

    /// True if the rays carry a single wavelength, because they have met dispersive glass.
    pub fn has_wavelength(&self) -> bool {
        self.rays[0].interior.wavelength().is_some()
    }

    /// Returns how closely the rays pass `lamp` after their last vertex. Returns `None` if the lamp
    /// lies behind the vertex or beyond `max_distance` \[length], or if the linear approximation is
    /// singular.
    pub fn lamp_passage(&self, lamp: &LampSphere, max_distance: f64) -> Option<LampPassage> {
        let Ray { origin, direction, .. } = self.rays[0].ray;
        let distance = (lamp.center - origin.as_dvec3()).dot(direction.as_dvec3());
        if !(distance > 0.0 && distance < max_distance + 2.0 * lamp.radius) {
            return None;
        }
        let frame = Frame::from_normal(direction);
        // Points in the plane through the center of the lamp, perpendicular to the camera ray,
        // relative to the radius of the lamp.
        let in_plane = |ray: &Ray| {
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let along = direction.as_dvec3();
            let t = (lamp.center - o).dot(along) / d.dot(along);
            let p = (o + d * t - lamp.center) / lamp.radius;
            (t > 0.0).then(|| DVec2::new(p.dot(frame.s.as_dvec3()), p.dot(frame.t.as_dvec3())))
        };
        let at = in_plane(&self.rays[0].ray)?;
        let derivative = |i: usize, step: f64| in_plane(&self.rays[i].ray).map(|p| (p - at) / step);
        let to_disc = DMat2::from_cols(derivative(1, FILM_STEP.into())?, derivative(2, FILM_STEP.into())?);
        let from_disc = to_disc.inverse();
        if !from_disc.is_finite() {
            return None;
        }
        let by_lens = if self.traced_ray_count > 3 {
            DMat2::from_cols(derivative(3, self.lens_step)?, derivative(4, self.lens_step)?)
        } else {
            DMat2::ZERO
        };
        Some(LampPassage {
            relative_miss: at.length(),
            to_image: -(from_disc * at),
            shift_per_lens_position: -(from_disc * by_lens),
            to_disc,
        })
    }
}

/// True if `surface` scatters light only into delta lobes.
fn is_specular(surface: &SurfaceInteraction<'_>) -> bool {
    surface.bsdf.is_specular()
}

/// Returns the direction in which a camera ray leaves the specular surface `surface`, reflected or
/// transmitted, and the weight of this direction. Returns `None` if the surface does not scatter
/// the ray that way.
fn scattered_direction(
    surface: &SurfaceInteraction<'_>,
    is_transmitted: bool,
    sampler: Sampler,
) -> Option<(Vec3, Rgb)> {
    let (ns, ng) = (surface.point.ns, surface.point.ng);
    if let Some(split) = surface.bsdf.reflect_and_refract(surface.wo, ns, ng, TransportMode::Radiance) {
        let (direction, weight) = if is_transmitted {
            (split.transmitted.0, split.transmitted.1 / split.transmitted_radiance_divisor)
        } else {
            split.reflected
        };
        return (weight > 0.0).then_some((direction, Rgb::splat(weight)));
    }
    let (lobe, u) = (sampler.get_1d(Dimension::BsdfLobe), sampler.get_2d(Dimension::BsdfDirection));
    let sample = surface.sample(lobe, u, TransportMode::Radiance)?;
    (sample.is_transmitted == is_transmitted).then_some((sample.wi, sample.weight))
}
