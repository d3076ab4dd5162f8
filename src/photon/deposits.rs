//! Photons, photon beams and splats that a photon pass stores.

use super::concatenation::concatenate;
use super::{Photon, PhotonBeam, PhotonKind, PhotonTracer, VolumePhoton};
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use crate::scene::SurfaceInteraction;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Optical depth, measured from the beam's start, at which a photon beam ends if its ray never
/// leaves the medium. There, the flux is exp(−20) = 2·10⁻⁹ of the flux at the start.
const MAX_OPTICAL_DEPTH: f32 = 20.0;

/// Photon beams and photon points stored in participating media.
#[derive(Clone, Debug, Default)]
pub struct VolumePhotons {
    /// Photon beams, in homogeneous media.
    pub beams: Vec<PhotonBeam>,
    /// Photons at scattering points, in heterogeneous media. If the pass stores no beams, the list
    /// holds the photons of homogeneous media too.
    pub points: Vec<VolumePhoton>,
}

impl VolumePhotons {
    /// Number of beams and points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len() + self.points.len()
    }

    /// True if there are no beams and no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Concatenates the photons of `parts`.
    fn concatenate(parts: &[&Self]) -> Self {
        Self {
            beams: concatenated_lists(parts, |part| &part.beams),
            points: concatenated_lists(parts, |part| &part.points),
        }
    }
}

/// Photons and splats that a photon pass stored, in the order of path indices.
#[derive(Debug, Default)]
pub struct Deposits {
    /// Photons on surfaces, except the photons in `after_caustic_surface_photons`.
    pub surface_photons: Vec<Photon>,
    /// Surface photons of the indirect light that caustics cause ([`PhotonKind::AfterCaustic`]).
    ///
    /// If [`StoreMask::separates_after_caustic`](super::StoreMask) is not set, `surface_photons`
    /// holds these photons instead, and this list is empty.
    pub after_caustic_surface_photons: Vec<Photon>,
    /// Photons in media, except the photons in `after_caustic_volume_photons`.
    pub volume_photons: VolumePhotons,
    /// Volume photons of the indirect light that caustics cause ([`PhotonKind::AfterCaustic`]).
    ///
    /// If [`StoreMask::separates_after_caustic`](super::StoreMask) is not set, `volume_photons`
    /// holds these photons instead, and this list is empty.
    pub after_caustic_volume_photons: VolumePhotons,
    /// Number of deposits that were not stored because their flux or position was invalid.
    ///
    /// Invalid values are not finite; the flux of a photon is also invalid if it is negative.
    /// Deposits of zero flux do not count.
    pub rejected_deposits: u64,
    /// Splats of caustic photons on the film; the list is empty without light tracing.
    pub splats: Vec<Splat>,
}

impl Deposits {
    /// Total number of stored photons and beams, on surfaces and in media; splats do not count.
    #[must_use]
    pub fn len(&self) -> usize {
        self.surface_photons.len()
            + self.after_caustic_surface_photons.len()
            + self.volume_photons.len()
            + self.after_caustic_volume_photons.len()
    }

    /// True if the pass stored no photon and no beam; it may have stored splats.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Concatenates the deposits of consecutive chunks of photon paths.
    pub(super) fn concatenate(chunks: Vec<Self>) -> Self {
        let volumes = |volume: fn(&Self) -> &VolumePhotons| -> VolumePhotons {
            VolumePhotons::concatenate(&chunks.iter().map(volume).collect::<Vec<_>>())
        };
        let all = Self {
            surface_photons: concatenated_lists(&chunks, |chunk| &chunk.surface_photons),
            after_caustic_surface_photons: concatenated_lists(&chunks, |chunk| &chunk.after_caustic_surface_photons),
            volume_photons: volumes(|chunk| &chunk.volume_photons),
            after_caustic_volume_photons: volumes(|chunk| &chunk.after_caustic_volume_photons),
            rejected_deposits: chunks.iter().map(|chunk| chunk.rejected_deposits).sum(),
            splats: concatenated_lists(&chunks, |chunk| &chunk.splats),
        };
        // Freeing large lists takes as long as copying them, so it is done in parallel too.
        chunks.into_par_iter().for_each(drop);
        all
    }

    /// Stores `deposit`, which a photon path of `tracer` left behind, in the list for its place and
    /// kind. If its position or flux is invalid, only counts it in `rejected_deposits`.
    #[inline]
    pub(super) fn store_deposit(&mut self, tracer: &PhotonTracer<'_>, deposit: &Deposit<'_>) {
        let is_separate = tracer.mask.separates_after_caustic && deposit.kind == PhotonKind::AfterCaustic;
        let (photons, volume) = if is_separate {
            (&mut self.after_caustic_surface_photons, &mut self.after_caustic_volume_photons)
        } else {
            (&mut self.surface_photons, &mut self.volume_photons)
        };
        let flux = deposit.flux;
        let code = deposit.wavelength.map_or(0, Wavelength::byte_code);
        let stored = match deposit.place {
            DepositPlace::Surface(surface, share) => {
                let photon = Photon::new(surface.point.p, flux, surface.wo, surface.facing_normal());
                let photon = photon.map(|photon| photon.with_wavelength_code(code));
                photon
                    .map(|photon| photons.push(share.map_or(photon, |steps| photon.with_density_estimate_share(steps))))
            }
            DepositPlace::Film(film_position) => {
                let is_valid = flux.is_finite() && flux != Rgb::ZERO;
                is_valid.then(|| self.splats.push(Splat { film_position, integrated_radiance: flux }))
            }
            DepositPlace::Beam { ray, medium } => {
                let length = beam_length(tracer, ray, medium);
                let beam = PhotonBeam::new(ray.origin, ray.direction, length, flux, medium, code);
                // A beam of zero length contributes nothing, so it is not an error.
                beam.map(|beam| volume.beams.push(beam)).or((length == 0.0).then_some(()))
            }
            DepositPlace::Point { position, direction, medium } => {
                let photon = VolumePhoton::new(position, flux, direction, medium, code);
                photon.map(|photon| volume.points.push(photon))
            }
        };
        self.rejected_deposits += u64::from(stored.is_none() && flux != Rgb::ZERO);
    }
}

/// Concatenates the lists of all `owners`, in the order of the owners. `list` returns the list of
/// one owner.
fn concatenated_lists<'a, O, T: Copy + Send + Sync + 'a>(
    owners: &'a [O],
    list: impl Fn(&'a O) -> &'a Vec<T>,
) -> Vec<T> {
    let parts: Vec<&[T]> = owners.iter().map(|owner| list(owner).as_slice()).collect();
    concatenate(&parts)
}

/// Light of one caustic photon that is added directly to the film (light tracing).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Film position that receives the light \[pixels from the top left].
    pub film_position: Vec2,
    /// Radiance times film area \[W/(m² sr)·pixel²]: the amount of light that the splat spreads
    /// over pixels.
    pub integrated_radiance: Rgb,
}

/// Flux that a photon path deposits at one place: on a surface, in a medium or on the film.
pub(super) struct Deposit<'a> {
    /// Kind of the photon that carries the flux.
    pub kind: PhotonKind,
    /// Surface point, medium or film position that receives the flux.
    pub place: DepositPlace<'a>,
    /// Deposited light. For a photon or beam, it is the flux \[W]; for a splat, the radiance times
    /// film area \[W/(m² sr)·pixel²].
    pub flux: Rgb,
    /// Wavelength of the path; `None` if the path carries all wavelengths.
    pub wavelength: Option<Wavelength>,
}

/// Place where a photon path deposits flux: on a surface, in a medium or on the film.
pub(super) enum DepositPlace<'a> {
    /// A point on a surface. With light tracing, also the share of a caustic photon: the fraction
    /// of its flux that density estimates use. The photon's splat gets the rest.
    ///
    /// The share is in units of 1/[`SHARE_STEPS`](super::surface_photon::SHARE_STEPS). It is `None`
    /// without light tracing, and for photons that are not caustic.
    Surface(&'a SurfaceInteraction<'a>, Option<u8>),
    /// A film position \[pixels from the top left], where a splat is recorded.
    Film(Vec2),
    /// A photon beam: a ray segment in a homogeneous medium.
    Beam {
        /// The segment of the photon path in the medium, with unit direction.
        ray: &'a Ray,
        /// Index of the medium in [`Scene::media`](crate::scene::Scene::media).
        medium: u32,
    },
    /// A scattering point in a medium.
    Point {
        /// Position of the scattering point.
        position: Vec3,
        /// Unit direction in which the photon travels before it scatters.
        direction: Vec3,
        /// Index of the medium in [`Scene::media`](crate::scene::Scene::media).
        medium: u32,
    },
}

/// Returns the length of the photon beam along `ray` in the medium with index `medium` \[length].
///
/// The beam of a finite ray ends at the ray's end. The beam of an infinite ray ends at
/// [`MAX_OPTICAL_DEPTH`], or outside the scene's bounding sphere if that is nearer.
fn beam_length(tracer: &PhotonTracer<'_>, ray: &Ray, medium: u32) -> f32 {
    if ray.t_max.is_finite() {
        return ray.t_max;
    }
    let domain = tracer.scene.photon_domain();
    let far = 2.0 * ((domain.center - ray.origin).length() + domain.radius);
    let extinction = tracer.scene.media()[medium as usize].extinction().min_element();
    if extinction > 0.0 { (MAX_OPTICAL_DEPTH / extinction).min(far) } else { far }
}
