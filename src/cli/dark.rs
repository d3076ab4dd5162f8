//! Why a picture is black, or photons light nothing.

use super::plan::counted;
use crate::color::Rgb;
use crate::photon::Audit;
use crate::render::Rendered;
use crate::scene::Scene;
use crate::study::text::percent;
use glam::DVec3;

/// Whether there are lights, but none of them has any power.
pub(super) fn is_powerless(scene: &Scene) -> bool {
    !scene.lights().is_empty() && scene.lights().iter().all(|light| light.power(scene.domain()) == Rgb::ZERO)
}

/// What to say of photons where all passes together stored none; nothing where no photons were sent out.
pub(super) fn without_photons(rendered: &Rendered) -> Option<String> {
    let (global, caustic) = (&rendered.global, &rendered.caustic);
    let emitted = global.emitted + caustic.emitted;
    if emitted == 0 || global.stored + caustic.stored > 0 {
        return None;
    }
    let mut audit = global.audit;
    audit += caustic.audit;
    let paths = counted(emitted as usize, "photon path", "photon paths");
    Some(format!("note: {paths}, no photon stored: {}", fate(&audit)))
}

/// What became of the light of photons.
fn fate(audit: &Audit) -> String {
    let sum = |flux: [f64; 3]| DVec3::from(flux).element_sum();
    let emitted = sum(audit.emitted);
    if emitted <= 0.0 {
        return "no light left the lights".to_owned();
    }
    let [absorbed, escaped, stopped] =
        [audit.absorbed, audit.escaped, audit.stopped].map(|flux| percent(sum(flux) / emitted));
    format!(
        "of their light {absorbed} was absorbed, {escaped} left the scene, {stopped} fell where no photon is wanted"
    )
}

/// What to say of a picture without any light.
pub(super) fn black(lights: usize, powerless: bool) -> &'static str {
    match (lights, powerless) {
        (0, _) => "note: every pixel is black: nothing shines",
        (_, true) => "note: every pixel is black: no light has any power",
        _ => "note: every pixel is black: no light comes from what the camera sees",
    }
}
