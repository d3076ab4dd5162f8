//! Notes that explain a black picture, or a render that stored no photon.

use super::value_parsers::count_with_noun;
use crate::color::Rgb;
use crate::photon::EnergyAudit;
use crate::render::RenderResult;
use crate::scene::Scene;
use crate::study::text::percent_text;
use glam::DVec3;

/// True if the scene has lights, but none of them has any power.
pub(super) fn all_lights_are_black(scene: &Scene) -> bool {
    !scene.lights().is_empty() && scene.lights().iter().all(|light| light.power(scene.photon_domain()) == Rgb::ZERO)
}

/// Returns a note if the passes emitted photons but stored none.
pub(super) fn no_photon_stored_note(rendered: &RenderResult) -> Option<String> {
    let (unaimed, aimed) = (&rendered.unaimed, &rendered.aimed);
    let emitted = unaimed.emitted_paths + aimed.emitted_paths;
    if emitted == 0 || unaimed.stored_photons + aimed.stored_photons > 0 {
        return None;
    }
    let mut audit = unaimed.audit;
    audit += aimed.audit;
    let paths = count_with_noun(emitted as usize, "photon path", "photon paths");
    Some(format!("note: {paths}, no photon stored: {}", flux_fractions_text(&audit)))
}

/// Returns a text with three fractions of the emitted photon flux: absorbed, escaped from the
/// scene, and stopped.
///
/// A render stops a photon path at the bounce limit, or where no later photon of the path would be
/// stored.
fn flux_fractions_text(audit: &EnergyAudit) -> String {
    let sum = |flux: [f64; 3]| DVec3::from(flux).element_sum();
    let emitted = sum(audit.emitted);
    if emitted <= 0.0 {
        return "the lights emitted no flux".to_owned();
    }
    let [absorbed, escaped, stopped] =
        [audit.absorbed, audit.escaped, audit.stopped].map(|flux| percent_text(sum(flux) / emitted));
    format!(
        "of their flux {absorbed} was absorbed, {escaped} left the scene, {stopped} was on paths that could store none later"
    )
}

/// Returns a note that explains why all pixels are black. `lights` is the number of lights, and
/// `lights_are_black` is true if they have no power.
pub(super) fn black_picture_note(lights: usize, lights_are_black: bool) -> &'static str {
    match (lights, lights_are_black) {
        (0, _) => "note: every pixel is black: the scene has no light",
        (_, true) => "note: every pixel is black: no light has any power",
        (_, false) => "note: every pixel is black: no light reaches what the camera sees",
    }
}
