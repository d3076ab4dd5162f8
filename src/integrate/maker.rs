//! Making the photon maps of any pass.

use super::maps::{Maps, Needs, PhotonEstimator, Schedule};
use super::pilot::{Blurs, auto_radius, narrowest, pilot_paths, volume_blurs};
use super::progressive::shrink_in;
use super::visible::visible;
use super::volume::{VolumeEstimate, VolumeMap};
use super::{
    Expected, EyeSettings, GuidingReports, Monitor, Pass, PhotonReport, Radii, RadiusLaw, Settings, Stage, shrink,
};
use crate::photon::{
    Bandwidth, GuidingPilot, Photon, PhotonMap, PhotonPass, PhotonSource, StoreMask, THINNING, Traced, VolumePhotons,
};
use crate::plan::{Effect, Effects};
use crate::sampling::{Key, Purpose};
use crate::scene::Scene;
use std::time::Instant;

/// Most photons of a caustic estimate, where the user does not say.
pub const CAUSTIC_K: u32 = 50;

/// Photons that most discs of the global map should hold, where the user does not say.
const GLOBAL_COUNT: u32 = 100;

/// The same for the map of what caustics become, a smaller part of the light.
const AFTER_COUNT: u32 = 50;

/// Radius within which a photon counts for what is seen, before the maps' own radii are known, in radii of the scene.
const SEEN_WITHIN: f32 = 0.01;

/// Radius of a map of which the pilot found no photon, in radii of the scene.
const UNSEEN: f32 = 0.01;

/// Learned emission is used where it would take at least so many times as many paths to do without.
const LEAST_GAIN: f64 = 1.5;

/// Gather rays are guided by one photon path of so many of the global map.
const GUIDING: u32 = 16;

/// Wavelengths that count as one in the first pass \[nm], where walks and photons both have one: some twentieth of all.
const BAND: f32 = 20.0;

/// An estimate over fewer photons is noise, however many passes have shrunk it.
const FEWEST: f64 = 8.0;

/// A beam with the boxes of its pieces takes as much memory as so many photons.
const BEAM: usize = 4;

/// Fewest photons that tell a density: the k-th only bounds the disc, and (k − 1)/(πr²) of one is nothing.
const LEAST_K: u32 = 2;

/// Paths that tell how many photons a path stores.
const PROBE: u32 = 4096;

/// Paths of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    /// Of the global map.
    pub photons: u32,
    /// Aimed at casters.
    pub caustic_photons: u32,
}

impl Counts {
    /// One of so many.
    pub fn divided(self, part: u32) -> Self {
        Self { photons: self.photons.div_ceil(part), caustic_photons: self.caustic_photons.div_ceil(part) }
    }
}

/// Most photons of an estimate where one of `part` paths is traced; 0 stays no limit.
fn most_of(k: u32, part: u32) -> u32 {
    if k == 0 { 0 } else { k.div_ceil(part).max(LEAST_K) }
}

/// What maps are made from.
#[derive(Clone, Copy, Debug)]
pub(super) struct PilotBudget {
    /// Of all passes.
    pub key: Key,
    pub pass: u32,
    /// One path of so many of a pass is traced.
    pub part: u32,
    /// Whether estimates take a limited number of photons; else all within the radius.
    pub limited: bool,
}

/// Makes the maps of any pass.
#[derive(Debug)]
pub(super) struct PhotonMapBuilder<'a> {
    scene: &'a Scene,
    settings: Settings,
    effects: Effects,
    pub needs: Needs,
    global: Option<PhotonSource<'a>>,
    caustic: Option<PhotonSource<'a>>,
    pub counts: Counts,
    /// `None` where there is no map.
    pub radii: Option<Radii>,
    /// Radii of blurs in media, of caustics and of the rest.
    blurs: [Blurs; 2],
    /// The narrowest disc of the first pass \[length].
    least: f32,
    pub lessons: GuidingReports,
}

impl<'a> PhotonMapBuilder<'a> {
    /// Weighs the lights and finds radii where none is set.
    pub fn new(scene: &'a Scene, settings: Settings, effects: Effects, needs: Needs) -> Self {
        let needs = needs.within(effects);
        let source = |wanted: StoreMask, paths: u32, made: &dyn Fn() -> Option<PhotonSource<'a>>| {
            if paths == 0 || wanted == StoreMask::NONE {
                return None;
            }
            restricted(made()?, effects)
        };
        // Caustics that are simulated though nothing calls for them come from everywhere.
        let aimed = || PhotonSource::aimed(scene).or_else(|| PhotonSource::everywhere(scene));
        let caustic = source(needs.by_casters(), settings.caustic_photons, &aimed);
        let global = source(needs.global, settings.photons, &|| PhotonSource::everywhere(scene));
        let lessons = GuidingReports::default();
        let (photons, caustic_photons) = (settings.photons, settings.caustic_photons);
        let counts = Counts { photons, caustic_photons };
        let blurs = [Blurs::default(); 2];
        let (radii, least) = (None, 0.0);
        let mut maker = Self { scene, settings, effects, needs, global, caustic, counts, radii, blurs, least, lessons };
        if maker.has_photons() {
            maker.least = narrowest(scene);
        }
        maker.learn();
        maker.radii = maker.has_photons().then(|| maker.find_radii());
        if maker.lights_media() {
            maker.blurs = maker.find_blurs();
        }
        maker
    }

    /// The same for fewer effects, with what pilots found for all.
    pub fn within(&self, effects: Effects, needs: Needs) -> Self {
        let needs = needs.within(effects);
        let keep = |source: &Option<PhotonSource<'a>>, wanted: StoreMask| {
            let source = source.clone().filter(|_| wanted != StoreMask::NONE)?;
            restricted(source, effects)
        };
        Self {
            settings: self.settings.clone(),
            effects,
            needs,
            global: keep(&self.global, needs.global),
            caustic: keep(&self.caustic, needs.by_casters()),
            ..*self
        }
    }

    /// The same for `scene`, which is the maker's own at another time.
    pub fn at<'b>(&self, scene: &'b Scene) -> PhotonMapBuilder<'b> {
        let placed = |source: &Option<PhotonSource<'a>>| source.as_ref().map(|source| source.at(scene));
        PhotonMapBuilder {
            scene,
            settings: self.settings.clone(),
            global: placed(&self.global),
            caustic: placed(&self.caustic),
            ..*self
        }
    }

    /// Aims emission at what is seen, where that is much better.
    fn learn(&mut self) {
        // What is seen of media, no point on a surface tells.
        if (self.caustic.is_none() && self.global.is_none()) || self.lights_media() {
            return;
        }
        let (scene, settings) = (self.scene, &self.settings);
        let seen = visible(scene, &settings.eye, self.effects, scene.domain().radius * SEEN_WITHIN);
        let learn = |source: &mut Option<PhotonSource<'a>>, wants: StoreMask, paths: u32| {
            let unlearned = source.take()?;
            let EyeSettings { max_bounces, seed, .. } = settings.eye;
            let paths = pilot_paths(paths, GuidingPilot::PATHS);
            let pilot = GuidingPilot { mask: wants, max_bounces, visible: &seen, paths, seed };
            let (learned, lesson) = unlearned.clone().guided(&pilot);
            // Paths that are seen take longer: little gain is none.
            *source = Some(if lesson.gain > LEAST_GAIN { learned } else { unlearned });
            Some(lesson)
        };
        self.lessons.caustic = learn(&mut self.caustic, self.needs.by_casters(), settings.caustic_photons);
        // Gather rays look at the global map from everywhere.
        if !self.needs.global.direct {
            self.lessons.global = learn(&mut self.global, self.needs.global, settings.photons);
        }
    }

    /// Radii that hold enough photons in most places.
    fn find_radii(&self) -> Radii {
        let settings = &self.settings;
        let radius = |source: &Option<PhotonSource<'a>>, wants: StoreMask, paths: u32, fallback: u32| {
            let k = settings.gather_k.filter(|k| *k > 0).unwrap_or(fallback);
            let found = || {
                let source = source.as_ref()?;
                let pass = PhotonPass { scene: self.scene, source, mask: wants, max_bounces: settings.eye.max_bounces };
                auto_radius(&pass, paths, k, settings.eye.seed, self.least)
            };
            // A pilot may find none where others will, as of things that move.
            settings.radius.or_else(found).unwrap_or(self.scene.domain().radius * UNSEEN)
        };
        let smooth = if self.needs.after_caustic {
            let after = StoreMask { after_caustic: true, ..StoreMask::NONE };
            radius(&self.caustic, after, settings.caustic_photons / THINNING, AFTER_COUNT)
        } else {
            radius(&self.global, self.needs.global, settings.photons, GLOBAL_COUNT)
        };
        let caustic = radius(&self.caustic, StoreMask::CAUSTIC, settings.caustic_photons, CAUSTIC_K);
        Radii { global: smooth, caustic }
    }

    /// Whether photons are stored in media.
    fn lights_media(&self) -> bool {
        let media = self.effects.has(Effect::Media) && self.effects.has(Effect::Interiors);
        media && self.has_photons() && self.scene.media_in_use().iter().any(|medium| medium.scatters())
    }

    /// Radii that hold enough of what is stored in media along most rays.
    fn find_blurs(&self) -> [Blurs; 2] {
        let settings = &self.settings;
        let found = |source: &Option<PhotonSource<'a>>, wants: StoreMask, paths: u32| {
            let source = source.as_ref()?;
            let pass = PhotonPass { scene: self.scene, source, mask: wants, max_bounces: settings.eye.max_bounces };
            volume_blurs(&pass, self.effects, paths, settings)
        };
        let of = |source, wants, paths| {
            if let Some(radius) = settings.radius {
                return Blurs { beams: radius, points: radius };
            }
            let unseen = self.scene.domain().radius * UNSEEN;
            found(source, self.stored(wants), paths).unwrap_or(Blurs { beams: unseen, points: unseen })
        };
        let caustic = of(&self.caustic, StoreMask::CAUSTIC, settings.caustic_photons);
        let rest = if self.needs.after_caustic {
            of(&self.caustic, StoreMask { after_caustic: true, ..StoreMask::NONE }, settings.caustic_photons / THINNING)
        } else {
            of(&self.global, StoreMask { direct: false, ..self.needs.global }, settings.photons)
        };
        [caustic, rest]
    }

    /// What is wanted, in the form that estimates in media take.
    fn stored(&self, wants: StoreMask) -> StoreMask {
        StoreMask { beams: self.settings.volume == VolumeEstimate::Beams, ..wants }
    }

    /// How radii go from pass to pass.
    pub fn law(&self) -> RadiusLaw {
        let alpha = match self.needs.schedule {
            Schedule::Shrinking => self.settings.alpha,
            Schedule::Fixed => 1.0,
        };
        RadiusLaw { alpha, kernel: self.settings.kernel }
    }

    /// Whether a pass has photons.
    pub fn has_photons(&self) -> bool {
        self.caustic.is_some() || self.global.is_some()
    }

    /// What a pass will store.
    pub fn expected(&self) -> Expected {
        let settings = &self.settings;
        let key = Key::new(settings.eye.seed).purpose(Purpose::Pilot);
        let of = |source: &Option<PhotonSource<'a>>, wants: StoreMask, paths: u32| {
            let Some(source) = source.as_ref().filter(|_| paths > 0) else { return Expected::default() };
            let probe = paths.min(PROBE);
            let pass = PhotonPass { scene: self.scene, source, mask: wants, max_bounces: settings.eye.max_bounces };
            let traced = pass.trace(key, probe, &|_| {});
            let scale = |n: usize| (n as f64 * f64::from(paths) / f64::from(probe)) as u64;
            let in_media = |volume: &VolumePhotons| volume.points.len() + BEAM * volume.beams.len();
            let one = scale(traced.deposits.photons.len() + in_media(&traced.deposits.volume));
            let other = scale(traced.deposits.after_caustic.len() + in_media(&traced.deposits.after_volume));
            Expected { paths: paths.into(), photons: one + other, most: one.max(other) }
        };
        let guides = if self.needs.guides { self.counts.photons / GUIDING } else { 0 };
        let maps = [
            of(&self.caustic, self.needs.by_casters(), self.counts.caustic_photons),
            of(&self.global, self.needs.global, self.counts.photons),
            of(&self.global, StoreMask::GLOBAL, guides),
        ];
        maps.into_iter().fold(Expected::default(), |all, map| Expected {
            paths: all.paths + map.paths,
            photons: all.photons + map.photons,
            most: all.most.max(map.most),
        })
    }

    /// Traces and indexes the photons of pass `pass`, and books the work in `out`.
    pub fn make(&self, pass: u32, monitor: &dyn Monitor, out: &mut Pass) -> Maps<'a> {
        let key = Key::new(self.settings.eye.seed);
        self.make_from(&PilotBudget { key, pass, part: 1, limited: true }, monitor, out)
    }

    /// The same of a draft.
    pub fn make_from(&self, draft: &PilotBudget, monitor: &dyn Monitor, out: &mut Pass) -> Maps<'a> {
        let PilotBudget { pass, part, .. } = *draft;
        let counts = self.counts.divided(part);
        let key = |purpose| draft.key.purpose(purpose).with(u64::from(pass));
        let job = (self.needs.by_casters(), counts.caustic_photons);
        let traced = self.trace(self.caustic.as_ref(), job, key(Purpose::CausticPhotons), monitor, out);
        out.caustic = report(&traced);
        let caustic = (index(traced.deposits.photons, monitor, out), traced.deposits.volume);
        let smooth = if self.needs.after_caustic {
            (index(traced.deposits.after_caustic, monitor, out), traced.deposits.after_volume)
        } else {
            let job = (self.needs.global, counts.photons);
            let traced = self.trace(self.global.as_ref(), job, key(Purpose::GlobalPhotons), monitor, out);
            out.global = report(&traced);
            (index(traced.deposits.photons, monitor, out), traced.deposits.volume)
        };
        let guides = if self.needs.guides {
            let job = (StoreMask::GLOBAL, counts.photons / GUIDING);
            let traced = self.trace(self.global.as_ref(), job, key(Purpose::Guides), monitor, out);
            index(traced.deposits.photons, monitor, out)
        } else {
            PhotonMap::build(Vec::new())
        };
        // Without maps nothing asks for a radius.
        let radii = self.radii.unwrap_or(Radii { global: 1.0, caustic: 1.0 });
        // Discs keep their size when counts are balanced, so they hold more photons or fewer.
        let ratio = f64::from(self.counts.caustic_photons) / f64::from(self.settings.caustic_photons.max(1));
        let usual = (f64::from(CAUSTIC_K) * ratio).round().max(1.0) as u32;
        let k = most_of(self.settings.gather_k.unwrap_or(usual), part);
        let smooth_k = most_of(self.settings.gather_k.unwrap_or(0), part);
        Maps {
            guides,
            caustic: self.gathering(caustic, (radii.caustic, self.blurs[0]), k, draft),
            smooth: self.gathering(smooth, (radii.global, self.blurs[1]), smooth_k, draft),
        }
    }

    fn gathering(
        &self,
        (map, volume): (PhotonMap, VolumePhotons),
        (radius, blurs): (f32, Blurs),
        most: u32,
        draft: &PilotBudget,
    ) -> PhotonEstimator<'a> {
        let (pass, RadiusLaw { alpha, kernel }) = (draft.pass, self.law());
        let area = shrink(alpha, pass);
        let estimate = self.settings.volume;
        let (of_beams, of_points) = estimate.dimensions();
        let blurs = (blurs.beams * shrink_in(of_beams, alpha, pass), blurs.points * shrink_in(of_points, alpha, pass));
        let band = BAND * area.sqrt() as f32;
        let volume = VolumeMap::build(volume, blurs, estimate, band);
        let most = if draft.limited { most } else { 0 };
        let k = (f64::from(most) * area).round().max(FEWEST) as u32;
        let bandwidth = Bandwidth { radius: radius * area.sqrt() as f32, k: k.min(most) };
        let map = map.with_min_radius(self.least * area.sqrt() as f32);
        PhotonEstimator { scene: self.scene, map, bandwidth, kernel, volume }
    }

    fn trace(
        &self,
        source: Option<&PhotonSource<'_>>,
        (wants, paths): (StoreMask, u32),
        key: Key,
        monitor: &dyn Monitor,
        out: &mut Pass,
    ) -> Traced {
        let Some(source) = source else { return Traced::default() };
        let start = Instant::now();
        monitor.begin(Stage::Photons, u64::from(paths));
        let (wants, max_bounces) = (self.stored(wants), self.settings.eye.max_bounces);
        let pass = PhotonPass { scene: self.scene, source, mask: wants, max_bounces };
        let traced = pass.trace(key, paths, &|n| monitor.advance(n));
        out.counters.photon_rays += traced.rays;
        out.counters.rejected_photons += traced.deposits.rejected;
        out.seconds.photons += start.elapsed().as_secs_f64();
        traced
    }
}

/// A source as effects allow it.
fn restricted<'a>(source: PhotonSource<'a>, effects: Effects) -> Option<PhotonSource<'a>> {
    let source = source.with_effects(effects);
    if effects.has(Effect::Environment) { Some(source) } else { source.without_environment() }
}

fn report(traced: &Traced) -> PhotonReport {
    PhotonReport { emitted: traced.paths, stored: traced.deposits.len() as u64, audit: traced.audit }
}

fn index(photons: Vec<Photon>, monitor: &dyn Monitor, out: &mut Pass) -> PhotonMap {
    let start = Instant::now();
    let count = photons.len() as u64;
    monitor.begin(Stage::Trees, count);
    let map = PhotonMap::build(photons);
    monitor.advance(count);
    out.seconds.trees += start.elapsed().as_secs_f64();
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_few_photons_still_tells_a_density() {
        assert_eq!([0, 1, 2, 5, 50].map(|k| most_of(k, 4)), [0, 2, 2, 2, 13]);
        assert_eq!([0, 2, 50].map(|k| most_of(k, 1)), [0, 2, 50]);
    }
}
