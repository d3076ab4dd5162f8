//! Photon tracing: follows photon paths from the lights and stores photons.

use super::audit::add_flux;
use super::deposits::{Deposit, DepositPlace};
use super::light_tracing::LightTracer;
use super::{AFTER_CAUSTIC_THINNING, Deposits, EnergyAudit, PhotonKind, PhotonSource, StoreMask};
use crate::bsdf::{TransportMode, deposit_shading_normal_correction};
use crate::color::{self, Rgb};
use crate::medium::PhaseFunction;
use crate::sampling::{Dimension, Key};
use crate::scene::{Interior, MediumSegment, PathEvent, PathRay, Scene, SurfaceVertex, with_interior_type};
use glam::DVec3;
use rand::rngs::SmallRng;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Result of tracing photon paths: stored photons, splats, energy audit and counts.
#[derive(Debug, Default)]
pub struct TracedPhotons {
    /// Photons and splats that the photon paths stored.
    pub deposits: Deposits,
    /// Energy audit: the flux \[W] that the photon paths emitted, and the flux that they lost by
    /// absorption, escape, early end of a path and Russian roulette.
    pub audit: EnergyAudit,
    /// Number of traced rays: segments of photon paths, and connections to the camera.
    pub rays: u64,
    /// Number of photon paths that the caller requested, including paths without flux.
    pub paths: u64,
}

/// Energy audit and number of rays, summed over several photon paths while they are traced.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PhotonTracingTotals {
    /// Energy audit: the flux \[W] that the photon paths emitted, and the flux that they lost by
    /// absorption, escape, early end of a path and Russian roulette.
    pub audit: EnergyAudit,
    /// Number of rays that the photon paths traced, including connections to the camera.
    pub rays: u64,
}

/// Tracer of photon paths: their scene and source, their largest number of scattering events, and
/// the kinds of photons to store.
#[derive(Debug)]
pub struct PhotonTracer<'a> {
    /// Scene in which photons are traced.
    pub scene: &'a Scene,
    /// Source that samples the light and emitted ray of each photon path.
    pub source: &'a PhotonSource<'a>,
    /// Kinds of photons to store.
    pub mask: StoreMask,
    /// Largest number of scattering events per photon path.
    pub max_bounces: u32,
}

/// Number of photon paths that one Rayon task traces. Tasks are large enough to amortise
/// scheduling, and small enough to balance the load.
const PATHS_PER_TASK: u32 = 4096;

impl PhotonTracer<'_> {
    /// Traces `paths` photon paths with random numbers from `pass_key`; returns their photons,
    /// energy audit and counts.
    ///
    /// Calls `done` after each chunk of paths, from any thread, with the number of paths in the
    /// chunk. The result does not depend on the number of threads: chunks have a fixed size and are
    /// joined in order.
    pub fn trace(&self, pass_key: Key, paths: u32, done: &(dyn Fn(u64) + Sync)) -> TracedPhotons {
        let done = |paths| {
            done(paths);
            ControlFlow::Continue(())
        };
        self.trace_and_connect(pass_key, paths, None, &done)
    }

    /// Traces photon paths as [`PhotonTracer::trace`] does. With a `light_tracer`, also connects
    /// their caustic photons to the camera, which adds splats to the result.
    ///
    /// If `done` returns [`ControlFlow::Break`], chunks of paths that have not begun are skipped.
    /// The result is then incomplete, but its field `paths` still counts the skipped paths.
    pub fn trace_and_connect(
        &self,
        pass_key: Key,
        paths: u32,
        light_tracer: Option<&LightTracer<'_>>,
        done: &(dyn Fn(u64) -> ControlFlow<()> + Sync),
    ) -> TracedPhotons {
        let is_cancelled = AtomicBool::new(false);
        let chunks: Vec<(Deposits, PhotonTracingTotals)> = (0..paths.div_ceil(PATHS_PER_TASK))
            .into_par_iter()
            .map(|chunk| {
                if is_cancelled.load(Ordering::Relaxed) {
                    return Default::default();
                }
                let range = chunk * PATHS_PER_TASK..paths.min((chunk + 1).saturating_mul(PATHS_PER_TASK));
                let emitted = u64::from(range.end - range.start);
                let (mut deposits, mut tally) = (Deposits::default(), PhotonTracingTotals::default());
                with_interior_type!(self.source, <I> for index in range {
                    if let Some((ray, flux)) = self.source.emit_photon_path::<I>(pass_key, index, paths) {
                        let key = pass_key.photon_path_key(index);
                        self.follow_photon_path(ray, flux, key, light_tracer, &mut tally, |deposit| {
                            deposits.store_deposit(self, &deposit)
                        });
                    }
                });
                if done(emitted).is_break() {
                    is_cancelled.store(true, Ordering::Relaxed);
                }
                (deposits, tally)
            })
            .collect();
        let (chunks, tallies): (Vec<Deposits>, Vec<PhotonTracingTotals>) = chunks.into_iter().unzip();
        let mut tally = PhotonTracingTotals::default();
        for chunk in tallies {
            tally.audit += chunk.audit;
            tally.rays += chunk.rays;
        }
        let PhotonTracingTotals { audit, rays } = tally;
        TracedPhotons { deposits: Deposits::concatenate(chunks), audit, rays, paths: u64::from(paths) }
    }

    /// Follows one photon path until it is absorbed, escapes or is stopped. Adds its flux and its
    /// number of rays to `tally`.
    ///
    /// Calls `deposit` for each photon that `mask` stores, on a surface or in a medium, and for
    /// each splat on the film. `flux` \[W] is the flux at emission.
    #[inline]
    pub(super) fn follow_photon_path<I: Interior>(
        &self,
        mut path_ray: PathRay<I>,
        mut flux: Rgb,
        photon_path_key: Key,
        light_tracer: Option<&LightTracer<'_>>,
        tally: &mut PhotonTracingTotals,
        mut deposit: impl FnMut(Deposit<'_>),
    ) {
        let PhotonTracingTotals { audit, rays } = tally;
        let mut kind = PhotonKind::Direct;
        add_flux(&mut audit.emitted, flux);
        let mut bounce_count = 0;
        for vertex in 0.. {
            *rays += 1;
            let key = photon_path_key.photon_vertex_key(vertex);

            // Find the next vertex, and deposit photons in media on the way.
            let flux_before_segment = flux;
            let mut phase_function = PhaseFunction::Isotropic;
            let event = if I::HAS_MEDIA_OR_WAVELENGTH {
                let (mut rng, mut weight) = (key.rng(), DVec3::ONE);
                let event = path_ray.next_vertex(self.scene, key, |segment| {
                    let kind = if segment.crossed_hidden_boundary { kind.kind_after_crossed_caster() } else { kind };
                    phase_function = segment.medium.phase;
                    self.sample_distance_and_deposit(segment, kind, flux, &mut weight, &mut rng, &mut deposit)
                });
                flux *= weight.as_vec3();
                event
            } else {
                path_ray.next_vertex(self.scene, key, |_| None)
            };
            if flux != flux_before_segment {
                add_flux(&mut audit.absorbed, flux_before_segment - flux);
            }
            let (surface, transmittance, crossed_hidden_boundary) = match event {
                PathEvent::Escaped { .. } => return add_flux(&mut audit.escaped, flux),
                PathEvent::Surface(SurfaceVertex {
                    surface,
                    absorption_and_wavelength_weight: transmittance,
                    crossed_hidden_boundary,
                    ..
                }) => (Some(surface), transmittance, crossed_hidden_boundary),
                PathEvent::Scattered { absorption_transmittance: transmittance, crossed_hidden_boundary } => {
                    (None, transmittance, crossed_hidden_boundary)
                }
            };

            // Attenuate the flux by the bodies through which the ray went.
            let transmitted = flux * transmittance;
            add_flux(&mut audit.absorbed, flux - transmitted);
            flux = transmitted;
            if crossed_hidden_boundary {
                kind = kind.kind_after_crossed_caster();
            }

            // Deposit a photon on a surface.
            if let Some(surface) = &surface
                && surface.stores_photons()
                && self.mask.stores_on_surfaces(kind)
            {
                let stored_flux =
                    flux * deposit_shading_normal_correction(surface.wo, surface.point.ns, surface.point.ng);
                let wavelength = path_ray.interior.wavelength();
                let share = light_tracer.filter(|_| kind == PhotonKind::Caustic).map(|tracer| {
                    tracer.splat_and_return_share(surface, stored_flux, &path_ray, key, rays, &mut deposit)
                });
                deposit(Deposit { kind, place: DepositPlace::Surface(surface, share), flux: stored_flux, wavelength });
            }

            // Stop at the bounce limit, or if the mask stores no later photon of this path.
            let receives = surface.as_ref().is_none_or(|surface| surface.bsdf.stores_photons());
            let scattered_kind = kind.kind_after_scattering(receives);
            let stops_if_scattered =
                bounce_count == self.max_bounces || !self.mask.can_reach_stored_kind(scattered_kind);
            let may_cross_straight = surface.as_ref().is_some_and(|surface| surface.bsdf.transmits_straight());
            if stops_if_scattered && !may_cross_straight {
                return add_flux(&mut audit.stopped, flux);
            }

            // Thin out the paths that continue after a caustic photon: the indirect light of
            // caustics is smooth, so few photons suffice.
            if self.mask.separates_after_caustic && kind == PhotonKind::Caustic && receives {
                add_flux(&mut audit.net_roulette_loss, flux);
                if key.uniform_1d(Dimension::ShadingRoulette) * AFTER_CAUSTIC_THINNING as f32 >= 1.0 {
                    return;
                }
                flux *= AFTER_CAUSTIC_THINNING as f32;
                add_flux(&mut audit.net_roulette_loss, -flux);
            }

            // Sample the next direction.
            let before = color::channel_mean(flux);
            let mut crosses_straight = false;
            let ratio = if let Some(surface) = &surface {
                let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
                let Some(sample) = surface.sample(lobe, u, TransportMode::Importance) else {
                    return add_flux(&mut audit.absorbed, flux);
                };
                crosses_straight = may_cross_straight && sample.is_transmitted;
                if stops_if_scattered && !crosses_straight {
                    return add_flux(&mut audit.stopped, flux);
                }
                let adjoint = sample.adjoint_correction(surface.wo, surface.point.ns, surface.point.ng);
                let interior_weight =
                    path_ray.leave_surface_with_wavelength_weight(surface, sample.wi, sample.is_transmitted);
                let scattered = flux * sample.weight * adjoint * interior_weight;
                add_flux(&mut audit.absorbed, flux - scattered);
                flux = scattered;
                color::channel_mean(scattered) / before
            } else {
                let (direction, _) = phase_function.sample(path_ray.ray.direction, key.uniform_2d(Dimension::Phase));
                path_ray.scatter_towards(direction);
                // In a medium, the throughput ratio includes absorption along the segment.
                before / color::channel_mean(flux_before_segment)
            };

            // Russian roulette by the throughput ratio keeps the fluxes of stored photons similar.
            if ratio.is_nan() || key.uniform_1d(Dimension::Roulette) >= ratio {
                return add_flux(&mut audit.net_roulette_loss, flux);
            }
            let kept = flux / ratio.min(1.0);
            add_flux(&mut audit.net_roulette_loss, flux - kept);
            flux = kept;
            // Light that crosses a thin sheet straight on counts as if the sheet were not there.
            if !crosses_straight {
                kind = scattered_kind;
                bounce_count += 1;
            }
        }
    }

    /// Samples the distance \[length] along `segment` at which a path scatters in the medium;
    /// `None` if the path passes through without scattering.
    ///
    /// Calls `deposit` with a beam or a point if `mask` stores photons of kind `kind` in media.
    /// `flux` \[W] is the flux at the last vertex. `weight` is the factor by which distance
    /// sampling has changed this flux since that vertex; the function multiplies `weight` by the
    /// factor of this segment.
    #[inline]
    fn sample_distance_and_deposit<I: Interior>(
        &self,
        segment: &MediumSegment<'_, I>,
        kind: PhotonKind,
        flux: Rgb,
        weight: &mut DVec3,
        rng: &mut SmallRng,
        deposit: &mut impl FnMut(Deposit<'_>),
    ) -> Option<f32> {
        let MediumSegment { ray, medium, medium_index: index, .. } = segment;
        let wavelength = segment.interior.wavelength();
        if !medium.scatters() {
            *weight *= medium.transmittance_f64(ray, ray.t_max, rng);
            return None;
        }
        let stored = self.mask.stores_in_media(kind);
        let as_beam = self.mask.stores_beams && medium.is_homogeneous();
        if stored && as_beam {
            let flux = flux * weight.as_vec3() * segment.absorption_transmittance_before;
            deposit(Deposit { kind, place: DepositPlace::Beam { ray, medium: *index }, flux, wavelength });
        }
        let sample = medium.distance_sample(ray, ray.t_max, flux * weight.as_vec3(), rng);
        *weight *= sample.weight.as_dvec3();
        if let Some(t) = sample.scattering_distance
            && stored
            && !as_beam
        {
            let flux = flux * weight.as_vec3() * segment.absorption_transmittance_before;
            let place = DepositPlace::Point { position: ray.at(t), direction: ray.direction, medium: *index };
            deposit(Deposit { kind, place, flux, wavelength });
        }
        sample.scattering_distance
    }
}
