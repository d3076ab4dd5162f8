//! Storage of the photons that a pass deposits.

use super::{Photon, PhotonBeam, PhotonKind, PhotonPass, VolumePhoton};
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use crate::scene::SurfaceInteraction;
use glam::Vec3;

/// Optical depth at which a beam without an end is cut: 2·10⁻⁹ of its flux is left.
const MAX_OPTICAL_DEPTH: f32 = 20.0;

/// Photons stored in participating media.
#[derive(Clone, Debug, Default)]
pub struct VolumePhotons {
    /// Photon beams through homogeneous media.
    pub beams: Vec<PhotonBeam>,
    /// Photon points where media scattered light.
    pub points: Vec<VolumePhoton>,
}

impl VolumePhotons {
    /// Number of beams and points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len() + self.points.len()
    }

    /// True if nothing is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn extend(&mut self, other: Self) {
        self.beams.extend(other.beams);
        self.points.extend(other.points);
    }
}

/// Photons that a pass stored, in the order of their paths.
#[derive(Debug, Default)]
pub struct Deposits {
    /// Photons on surfaces.
    pub photons: Vec<Photon>,
    /// Photons on surfaces of paths that continued after a caustic, if
    /// [`StoreMask::separates_after_caustic`](super::StoreMask) is set.
    pub after_caustic: Vec<Photon>,
    /// Photons in media, of the kinds of `photons`.
    pub volume: VolumePhotons,
    /// Photons in media, of the kinds of `after_caustic`.
    pub after_volume: VolumePhotons,
    /// Number of invalid photons that were not stored: flux or position is not finite, or a channel
    /// is negative.
    pub rejected: u64,
}

impl Deposits {
    /// Total number of stored photons.
    #[must_use]
    pub fn len(&self) -> usize {
        self.photons.len() + self.after_caustic.len() + self.volume.len() + self.after_volume.len()
    }

    /// True if nothing is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Concatenates the deposits of consecutive chunks of paths.
    pub(super) fn concatenate(chunks: Vec<Self>) -> Self {
        let mut all = Self::default();
        all.photons.reserve_exact(chunks.iter().map(|chunk| chunk.photons.len()).sum());
        all.after_caustic.reserve_exact(chunks.iter().map(|chunk| chunk.after_caustic.len()).sum());
        for chunk in chunks {
            all.photons.extend_from_slice(&chunk.photons);
            all.after_caustic.extend_from_slice(&chunk.after_caustic);
            all.volume.extend(chunk.volume);
            all.after_volume.extend(chunk.after_volume);
            all.rejected += chunk.rejected;
        }
        all
    }

    /// Stores one deposit of `pass`, unless it is invalid.
    #[inline]
    pub(super) fn store_deposit(&mut self, pass: &PhotonPass<'_>, deposit: &Deposit<'_>) {
        let thinned = pass.mask.separates_after_caustic && deposit.kind == PhotonKind::AfterCaustic;
        let (photons, volume) = if thinned {
            (&mut self.after_caustic, &mut self.after_volume)
        } else {
            (&mut self.photons, &mut self.volume)
        };
        let flux = deposit.flux;
        let code = deposit.wavelength.map_or(0, Wavelength::code);
        let stored = match deposit.place {
            DepositPlace::Surface(surface) => {
                let photon = Photon::new(surface.point.p, flux, surface.wo, surface.facing_normal());
                photon.map(|photon| photons.push(photon.with_wavelength(code)))
            }
            DepositPlace::PhotonBeam { ray, medium } => {
                let length = beam_length(pass, ray, medium);
                let beam = PhotonBeam::new(ray.origin, ray.direction, length, flux, medium, code);
                // A beam of zero length carries nothing, and is no error.
                beam.map(|beam| volume.beams.push(beam)).or((length == 0.0).then_some(()))
            }
            DepositPlace::Point { position, direction, medium } => {
                let photon = VolumePhoton::new(position, flux, direction, medium, code);
                photon.map(|photon| volume.points.push(photon))
            }
        };
        self.rejected += u64::from(stored.is_none() && flux != Rgb::ZERO);
    }
}

/// Flux that a density estimate can use.
pub(super) struct Deposit<'a> {
    /// History of the path.
    pub kind: PhotonKind,
    /// Surface, beam or point that receives the flux.
    pub place: DepositPlace<'a>,
    /// Flux \[W].
    pub flux: Rgb,
    /// Wavelength of a path that chose one.
    pub wavelength: Option<Wavelength>,
}

/// Surface, beam or point at which a photon path deposits flux.
pub(super) enum DepositPlace<'a> {
    /// On a surface.
    Surface(&'a SurfaceInteraction<'a>),
    /// Along a ray through a homogeneous medium.
    PhotonBeam {
        /// The ray, of unit direction.
        ray: &'a Ray,
        /// Index of the medium.
        medium: u32,
    },
    /// At a scattering point in a medium.
    Point {
        /// The point.
        position: Vec3,
        /// Unit direction of travel before scattering.
        direction: Vec3,
        /// Index of the medium.
        medium: u32,
    },
}

/// Length of a beam along `ray`.
///
/// A ray without an end is cut where almost no flux is left, or far outside the scene.
fn beam_length(pass: &PhotonPass<'_>, ray: &Ray, medium: u32) -> f32 {
    if ray.t_max.is_finite() {
        return ray.t_max;
    }
    let domain = pass.scene.domain();
    let far = 2.0 * ((domain.center - ray.origin).length() + domain.radius);
    let extinction = pass.scene.media()[medium as usize].extinction().min_element();
    if extinction > 0.0 { (MAX_OPTICAL_DEPTH / extinction).min(far) } else { far }
}
