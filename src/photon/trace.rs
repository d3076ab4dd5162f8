//! The walk of a photon.

use super::{Photon, PhotonSource};
use crate::bsdf::{Transport, deposit_factor, shading_normal_factor};
use crate::color::{self, Rgb};
use crate::sampling::{Dimension, Key};
use crate::scene::{Arrival, Inside, Interior, Open, Scene, Step, Surface, Walk};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::AddAssign;

/// History of a stored photon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Straight from a light.
    Direct,
    /// By bounces off casters only: see [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
    Caustic,
    /// As a caustic to a surface that stores photons, and on from there.
    AfterCaustic,
    /// Straight from a light to a surface that stores photons, and on from there.
    Global,
}

/// Which classes are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wants {
    /// Store direct photons.
    pub direct: bool,
    /// Store caustic photons.
    pub caustic: bool,
    /// Store what caustic photons become.
    pub after_caustic: bool,
    /// Store global photons.
    pub global: bool,
    /// Keep what caustic photons become apart from the others; as it is smooth, only one of [`THINNING`] is followed, with the flux
    /// of all.
    pub apart: bool,
}

impl Wants {
    /// Direct photons only.
    pub const DIRECT: Self = Self { direct: true, ..Self::NONE };
    /// Caustic photons only: a path ends at the first surface that stores photons.
    pub const CAUSTIC: Self = Self { caustic: true, ..Self::NONE };
    /// Photons that met a surface that stores photons before.
    pub const GLOBAL: Self = Self { after_caustic: true, global: true, ..Self::NONE };
    /// Nothing.
    pub const NONE: Self = Self { direct: false, caustic: false, after_caustic: false, global: false, apart: false };
    /// All classes.
    pub const ALL: Self = Self { direct: true, caustic: true, after_caustic: true, global: true, apart: false };

    fn has(self, class: Class) -> bool {
        match class {
            Class::Direct => self.direct,
            Class::Caustic => self.caustic,
            Class::AfterCaustic => self.after_caustic,
            Class::Global => self.global,
        }
    }

    /// Whether anything wanted can follow on a photon of `class` that goes on.
    fn may_follow(self, class: Class) -> bool {
        match class {
            Class::Direct => true,
            Class::Caustic => self.caustic || self.after_caustic,
            Class::AfterCaustic => self.after_caustic,
            Class::Global => self.global,
        }
    }
}

/// Of photons that go on after a caustic, so many are followed as one where they are kept apart.
pub const THINNING: u32 = 8;

impl Class {
    /// The class after a surface.
    fn after(self, stores: bool) -> Self {
        match (stores, self) {
            (false, Self::Direct) => Self::Caustic,
            (false, other) => other,
            (true, Self::Direct | Self::Global) => Self::Global,
            (true, Self::Caustic | Self::AfterCaustic) => Self::AfterCaustic,
        }
    }
}

/// Where the emitted flux went \[W]. Emitted = absorbed + escaped + stopped + roulette, to rounding; the mean of `roulette` is
/// zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Audit {
    /// Flux that left the lights.
    pub emitted: [f64; 3],
    /// Flux taken up by surfaces and bodies.
    pub absorbed: [f64; 3],
    /// Flux that left the scene.
    pub escaped: [f64; 3],
    /// Flux of paths cut by the bounce limit, or ended because what would follow is not wanted.
    pub stopped: [f64; 3],
    /// Flux removed by Russian roulette less flux it added.
    pub roulette: [f64; 3],
}

impl AddAssign for Audit {
    fn add_assign(&mut self, other: Self) {
        let pairs = [
            (&mut self.emitted, other.emitted),
            (&mut self.absorbed, other.absorbed),
            (&mut self.escaped, other.escaped),
            (&mut self.stopped, other.stopped),
            (&mut self.roulette, other.roulette),
        ];
        for (mine, theirs) in pairs {
            *mine = (DVec3::from(*mine) + DVec3::from(theirs)).to_array();
        }
    }
}

fn book(account: &mut [f64; 3], flux: Rgb) {
    *account = (DVec3::from(*account) + flux.as_dvec3()).to_array();
}

/// What a photon pass stored and did.
#[derive(Debug, Default)]
pub struct Traced {
    /// Stored photons of the wanted classes, in the order of their paths.
    pub photons: Vec<Photon>,
    /// What caustic photons became, where [`Wants::apart`] says so.
    pub after_caustic: Vec<Photon>,
    /// Flux account.
    pub audit: Audit,
    /// Rays traced.
    pub rays: u64,
    /// Paths emitted.
    pub paths: u64,
}

/// One pass of photons from a source.
#[derive(Debug)]
pub struct PhotonPass<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where photons come from.
    pub source: &'a PhotonSource<'a>,
    /// Which photons are stored.
    pub wants: Wants,
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
        if self.source.interiors {
            self.trace_in::<Inside>(pass, paths, done)
        } else {
            self.trace_in::<Open>(pass, paths, done)
        }
    }

    fn trace_in<I: Interior>(&self, pass: Key, paths: u32, done: &(dyn Fn(u64) + Sync)) -> Traced {
        let chunks: Vec<Traced> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..paths.min((chunk + 1).saturating_mul(CHUNK));
                let mut traced = Traced { paths: u64::from(range.end - range.start), ..Traced::default() };
                let Traced { photons, after_caustic, audit, rays, .. } = &mut traced;
                for index in range {
                    if let Some((walk, flux)) = self.source.emit::<I>(pass, index, paths) {
                        let store = |class, surface: &Surface<'_>, flux| {
                            let apart = self.wants.apart && class == Class::AfterCaustic;
                            let kept = if apart { &mut *after_caustic } else { &mut *photons };
                            kept.extend(Photon::new(surface.point.p, flux, surface.wo, surface.facing_normal()));
                        };
                        self.follow(walk, flux, pass.with(u64::from(index)), (audit, rays), store);
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
            total.audit += chunk.audit;
            total.rays += chunk.rays;
            total.paths += chunk.paths;
        }
        total
    }

    /// Follows one photon until it is absorbed, escapes or is stopped. `deposit` hears of every landing of a wanted class where a
    /// density estimate can use it, with its flux \[W].
    #[inline]
    pub(super) fn follow<I: Interior>(
        &self,
        mut walk: Walk<I>,
        mut flux: Rgb,
        path: Key,
        (audit, rays): (&mut Audit, &mut u64),
        mut deposit: impl FnMut(Class, &Surface<'_>, Rgb),
    ) {
        let mut class = Class::Direct;
        book(&mut audit.emitted, flux);
        for bounce in 0.. {
            *rays += 1;
            let key = path.with(bounce.into());
            let Step::Arrived(Arrival { surface, transmittance, crossed, .. }) =
                walk.advance(self.scene, key, |_| None)
            else {
                return book(&mut audit.escaped, flux);
            };
            let left = flux * transmittance;
            book(&mut audit.absorbed, flux - left);
            flux = left;
            if crossed && class == Class::Direct {
                class = Class::Caustic;
            }

            let stores = surface.bsdf.stores_photons();
            if stores && self.wants.has(class) {
                deposit(class, &surface, flux * deposit_factor(surface.wo, surface.point.ns, surface.point.ng));
            }
            let next = class.after(stores);
            if bounce == self.max_bounces || !self.wants.may_follow(next) {
                return book(&mut audit.stopped, flux);
            }
            if self.wants.apart && class == Class::Caustic && stores {
                book(&mut audit.roulette, flux);
                if key.uniform(Dimension::Worth) * THINNING as f32 >= 1.0 {
                    return;
                }
                flux *= THINNING as f32;
                book(&mut audit.roulette, -flux);
            }

            // Scatter.
            let (lobe, u) = (key.uniform(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
            let Some(sample) = surface.sample(lobe, u, Transport::Importance) else {
                return book(&mut audit.absorbed, flux);
            };
            let adjoint = shading_normal_factor(surface.wo, sample.wi, surface.point.ns, surface.point.ng);
            let scattered = flux * sample.weight * adjoint;
            book(&mut audit.absorbed, flux - scattered);

            // Roulette on the ratio of throughputs keeps stored photons alike in power.
            let ratio = color::mean(scattered) / color::mean(flux);
            if ratio.is_nan() || key.uniform(Dimension::Roulette) >= ratio {
                return book(&mut audit.roulette, scattered);
            }
            flux = scattered / ratio.min(1.0);
            book(&mut audit.roulette, scattered - flux);

            class = next;
            walk.leave(&surface, sample.wi, sample.transmitted);
        }
    }
}
