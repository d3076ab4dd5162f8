//! The walk of a photon.

use super::audit::book;
use super::{Audit, Beam, Photon, PhotonKind, PhotonSource, StoreMask, THINNING, VolumePhoton};
use crate::bsdf::{Transport, deposit_factor};
use crate::color::{self, Rgb, Wavelength};
use crate::math::Ray;
use crate::medium::PhaseFunction;
use crate::sampling::{Dimension, Key};
use crate::scene::{
    Interior, InteriorKind, InteriorStack, MediumSegment, NoInterior, PathEvent, PathRay, Scene, SpectralInterior,
    SurfaceInteraction, SurfaceVertex,
};
use glam::{DVec3, Vec3};
use rand::rngs::SmallRng;
use rayon::prelude::*;

/// Optical thickness beyond which a beam is not looked at: 10⁻⁹ of it is left.
const FAINTEST: f32 = 20.0;

/// What a photon pass stored and did.
#[derive(Debug, Default)]
pub struct Traced {
    /// Stored photons of the wanted classes, in the order of their paths.
    pub photons: Vec<Photon>,
    /// What caustic photons became, where [`StoreMask::apart`] says so.
    pub after_caustic: Vec<Photon>,
    /// What was stored in media, of the classes of `photons`.
    pub volume: Volume,
    /// What was stored in media, of the classes of `after_caustic`.
    pub after_volume: Volume,
    /// Flux account.
    pub audit: Audit,
    /// Rays traced.
    pub rays: u64,
    /// Paths emitted.
    pub paths: u64,
    /// Wanted photons that carried something but could not be stored: their flux or their place is not finite, or a channel is negative.
    pub rejected: u64,
}

/// What was stored in media.
#[derive(Clone, Debug, Default)]
pub struct Volume {
    /// Ways through homogeneous media.
    pub beams: Vec<Beam>,
    /// Where light was scattered.
    pub points: Vec<VolumePhoton>,
}

impl Volume {
    /// How much is stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.beams.len() + self.points.len()
    }

    /// Whether nothing is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn extend(&mut self, other: Self) {
        self.beams.extend(other.beams);
        self.points.extend(other.points);
    }
}

impl Traced {
    /// How much is stored in all.
    #[must_use]
    pub fn stored(&self) -> usize {
        self.photons.len() + self.after_caustic.len() + self.volume.len() + self.after_volume.len()
    }
}

/// Light that a density estimate can use.
pub(super) enum Deposit<'a> {
    /// It landed on a surface.
    SurfaceInteraction(&'a SurfaceInteraction<'a>),
    /// It begins a way through a homogeneous medium, of this index.
    Beam(&'a Ray, u32),
    /// It was scattered in a medium of this index, at a place, and had travelled in a direction.
    Point(Vec3, Vec3, u32),
}

/// One pass of photons from a source.
#[derive(Debug)]
pub struct PhotonPass<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where photons come from.
    pub source: &'a PhotonSource<'a>,
    /// Which photons are stored.
    pub mask: StoreMask,
    /// Bounces after which a path is cut.
    pub max_bounces: u32,
}

/// Paths a chunk: enough to hide the cost of handing it out, few enough to keep all threads busy to the end.
const CHUNK: u32 = 4096;

impl PhotonPass<'_> {
    /// Traces `paths` paths; `done` hears how many more are done, from any thread.
    ///
    /// The result is the same for any number of threads: chunks are fixed and joined in order.
    pub fn trace(&self, pass: Key, paths: u32, done: &(dyn Fn(u64) + Sync)) -> Traced {
        match self.source.memory() {
            InteriorKind::Spectral => self.trace_in::<SpectralInterior>(pass, paths, done),
            InteriorKind::Bodies => self.trace_in::<InteriorStack>(pass, paths, done),
            InteriorKind::Nothing => self.trace_in::<NoInterior>(pass, paths, done),
        }
    }

    fn trace_in<I: Interior>(&self, pass: Key, paths: u32, done: &(dyn Fn(u64) + Sync)) -> Traced {
        let chunks: Vec<Traced> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..paths.min((chunk + 1).saturating_mul(CHUNK));
                let mut traced = Traced { paths: u64::from(range.end - range.start), ..Traced::default() };
                let Traced { photons, after_caustic, volume, after_volume, audit, rays, rejected, .. } = &mut traced;
                for index in range {
                    if let Some((walk, flux)) = self.source.emit::<I>(pass, index, paths) {
                        let store = |class, deposit: Deposit<'_>, flux, wavelength: Option<Wavelength>| {
                            let apart = self.mask.apart && class == PhotonKind::AfterCaustic;
                            let (on, within) = if apart {
                                (&mut *after_caustic, &mut *after_volume)
                            } else {
                                (&mut *photons, &mut *volume)
                            };
                            let code = wavelength.map_or(0, Wavelength::code);
                            let stored = match deposit {
                                Deposit::SurfaceInteraction(surface) => {
                                    let photon =
                                        Photon::new(surface.point.p, flux, surface.wo, surface.facing_normal());
                                    photon.map(|photon| on.push(photon.with_wavelength(code)))
                                }
                                Deposit::Beam(ray, medium) => {
                                    let length = self.end_of_beam(ray, medium);
                                    let (start, along) = (ray.origin, ray.direction);
                                    let beam = Beam::new(start, along, length, flux, medium, code);
                                    // What ends where it begins has no length, and carries nothing.
                                    beam.map(|beam| within.beams.push(beam)).or((length == 0.0).then_some(()))
                                }
                                Deposit::Point(p, direction, medium) => {
                                    let photon = VolumePhoton::new(p, flux, direction, medium, code);
                                    photon.map(|photon| within.points.push(photon))
                                }
                            };
                            *rejected += u64::from(stored.is_none() && flux != Rgb::ZERO);
                        };
                        self.follow(walk, flux, pass.path(index), (audit, rays), store);
                    }
                }
                done(traced.paths);
                traced
            })
            .collect();
        let mut total = Traced::default();
        total.photons.reserve_exact(chunks.iter().map(|c| c.photons.len()).sum());
        total.after_caustic.reserve_exact(chunks.iter().map(|c| c.after_caustic.len()).sum());
        for chunk in chunks {
            total.photons.extend_from_slice(&chunk.photons);
            total.after_caustic.extend_from_slice(&chunk.after_caustic);
            total.volume.extend(chunk.volume);
            total.after_volume.extend(chunk.after_volume);
            total.audit += chunk.audit;
            total.rays += chunk.rays;
            total.paths += chunk.paths;
            total.rejected += chunk.rejected;
        }
        total
    }

    /// Where a beam along `ray` ends that has nothing to end at: where next to nothing is left of it, or far outside.
    fn end_of_beam(&self, ray: &Ray, medium: u32) -> f32 {
        if ray.t_max.is_finite() {
            return ray.t_max;
        }
        let domain = self.scene.domain();
        let far = 2.0 * ((domain.center - ray.origin).length() + domain.radius);
        let least = self.scene.media()[medium as usize].extinction().min_element();
        if least > 0.0 { (FAINTEST / least).min(far) } else { far }
    }

    /// Follows one photon until it is absorbed, escapes or is stopped. `deposit` hears of all light of a wanted class where a
    /// density estimate can use it, with its flux \[W] and its wavelength.
    #[inline]
    pub(super) fn follow<I: Interior>(
        &self,
        mut walk: PathRay<I>,
        mut flux: Rgb,
        path: Key,
        (audit, rays): (&mut Audit, &mut u64),
        mut deposit: impl FnMut(PhotonKind, Deposit<'_>, Rgb, Option<Wavelength>),
    ) {
        let mut class = PhotonKind::Direct;
        book(&mut audit.emitted, flux);
        for bounce in 0.. {
            *rays += 1;
            let key = path.bounce(bounce);
            let sent = flux;
            let mut phase = PhaseFunction::Isotropic;
            let step = if I::IMMERSED {
                let (mut rng, mut passed) = (key.rng(), DVec3::ONE);
                let step = walk.next_vertex(self.scene, key, |stretch| {
                    let class = if stretch.crossed { class.beyond_casters() } else { class };
                    phase = stretch.medium.phase;
                    self.through(stretch, class, flux, &mut passed, &mut rng, &mut deposit)
                });
                flux *= passed.as_vec3();
                step
            } else {
                walk.next_vertex(self.scene, key, |_| None)
            };
            if flux != sent {
                book(&mut audit.absorbed, sent - flux);
            }
            let (surface, transmittance, crossed) = match step {
                PathEvent::Escaped { .. } => return book(&mut audit.escaped, flux),
                PathEvent::Surface(SurfaceVertex { surface, transmittance, crossed, .. }) => {
                    (Some(surface), transmittance, crossed)
                }
                PathEvent::Scattered { transmittance, crossed } => (None, transmittance, crossed),
            };
            let left = flux * transmittance;
            book(&mut audit.absorbed, flux - left);
            flux = left;
            if crossed {
                class = class.beyond_casters();
            }

            let stores = surface.as_ref().is_none_or(|surface| surface.bsdf.stores_photons());
            if let Some(surface) = &surface
                && stores
                && self.mask.has(class)
            {
                let landed = flux * deposit_factor(surface.wo, surface.point.ns, surface.point.ng);
                deposit(class, Deposit::SurfaceInteraction(surface), landed, walk.inside.wavelength());
            }
            let next = class.after(stores);
            if bounce == self.max_bounces || !self.mask.may_follow(next) {
                return book(&mut audit.stopped, flux);
            }
            if self.mask.apart && class == PhotonKind::Caustic && stores {
                book(&mut audit.roulette, flux);
                if key.uniform(Dimension::Worth) * THINNING as f32 >= 1.0 {
                    return;
                }
                flux *= THINNING as f32;
                book(&mut audit.roulette, -flux);
            }

            // Scatter.
            let before = color::mean(flux);
            let ratio = if let Some(surface) = &surface {
                let (lobe, u) = (key.uniform(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
                let Some(sample) = surface.sample(lobe, u, Transport::Importance) else {
                    return book(&mut audit.absorbed, flux);
                };
                let adjoint = sample.adjoint(surface.wo, surface.point.ns, surface.point.ng);
                let chosen = walk.leave(surface, sample.wi, sample.transmitted);
                let scattered = flux * sample.weight * adjoint * chosen;
                book(&mut audit.absorbed, flux - scattered);
                flux = scattered;
                color::mean(scattered) / before
            } else {
                let (direction, _) = phase.sample(walk.ray.direction, key.uniform_2d(Dimension::Phase));
                walk.turn(direction);
                // What was absorbed on the way is no loss of this moment, but roulette may have its say.
                before / color::mean(sent)
            };

            // Roulette on the ratio of throughputs keeps stored photons alike in power.
            if ratio.is_nan() || key.uniform(Dimension::Roulette) >= ratio {
                return book(&mut audit.roulette, flux);
            }
            let kept = flux / ratio.min(1.0);
            book(&mut audit.roulette, flux - kept);
            flux = kept;
            class = next;
        }
    }

    /// Takes `flux` through a stretch of a medium, and tells where it is scattered, if it is. `passed` is what it is multiplied by for the
    /// stretches before.
    #[inline]
    fn through<I: Interior>(
        &self,
        stretch: &MediumSegment<'_, I>,
        class: PhotonKind,
        flux: Rgb,
        passed: &mut DVec3,
        rng: &mut SmallRng,
        deposit: &mut impl FnMut(PhotonKind, Deposit<'_>, Rgb, Option<Wavelength>),
    ) -> Option<f32> {
        let MediumSegment { ray, medium, index, .. } = stretch;
        let wavelength = stretch.inside.wavelength();
        if !medium.scatters() {
            *passed *= medium.transmittance_f64(ray, ray.t_max, rng);
            return None;
        }
        let stored = self.mask.has_in_media(class);
        let as_beam = self.mask.beams && medium.is_homogeneous();
        if stored && as_beam {
            deposit(class, Deposit::Beam(ray, *index), flux * passed.as_vec3() * stretch.left, wavelength);
        }
        let distance_sample = medium.distance_sample(ray, ray.t_max, flux * passed.as_vec3(), rng);
        *passed *= distance_sample.weight.as_dvec3();
        if let Some(t) = distance_sample.scattered
            && stored
            && !as_beam
        {
            deposit(
                class,
                Deposit::Point(ray.at(t), ray.direction, *index),
                flux * passed.as_vec3() * stretch.left,
                wavelength,
            );
        }
        distance_sample.scattered
    }
}
