//! Suggests command line flags for the rendering settings of a Tungsten scene.

use super::object::{ReadResult, TungstenObject};

/// Integrators of Tungsten, each with the most similar algorithm of Caustica.
const INTEGRATOR_NAMES: [(&str, &str); 8] = [
    ("path_tracer", "path"),
    ("kelemen_mlt", "path"),
    ("multiplexed_mlt", "path"),
    ("reversible_jump_mlt", "path"),
    ("light_tracer", "hybrid"),
    ("bidirectional_path_tracer", "hybrid"),
    ("photon_map", "pm"),
    ("progressive_photon_map", "sppm"),
];

/// Pixel filters of Tungsten, each with the most similar filter of `caustica render --filter`.
const FILTER_NAMES: [(&str, &str); 7] = [
    ("dirac", "box"),
    ("box", "box"),
    ("tent", "tent"),
    ("gaussian", "gaussian"),
    ("mitchell_netravali", "mitchell"),
    ("catmull_rom", "mitchell"),
    ("lanczos", "mitchell"),
];

/// Returns the flags of `caustica render` that correspond to the integrator and the pixel filter of
/// the `scene`, with spaces between; empty if neither has a corresponding flag.
///
/// Tungsten counts the points of a path at which lights are sampled. Caustica counts the bounces
/// between them: one less.
pub(super) fn suggested_flags(scene: &TungstenObject<'_>) -> ReadResult<String> {
    let mut flags = Vec::new();
    if let Some(integrator) = scene.child("integrator") {
        integrator.mark_as_read();
        let name = integrator.kind()?;
        if let Some((_, algorithm)) = INTEGRATOR_NAMES.iter().find(|(known, _)| *known == name) {
            flags.push(format!("--integrator {algorithm}"));
        }
        if let Some(depth) = integrator.number("max_bounces")?.filter(|depth| *depth >= 1.0) {
            flags.push(format!("--max-bounces {}", depth.min(1e6) as u32 - 1));
        }
    }
    if let Some(camera) = scene.child("camera")
        && let Some(name) = camera.text("reconstruction_filter")?
        && let Some((_, filter)) = FILTER_NAMES.iter().find(|(known, _)| *known == name)
    {
        flags.push(format!("--filter {filter}"));
    }
    Ok(flags.join(" "))
}
