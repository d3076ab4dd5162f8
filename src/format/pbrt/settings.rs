//! Suggests command line flags for the rendering settings of a pbrt scene.

use super::parameters::Parameters;

/// Integrators of pbrt-v3 and pbrt-v4, each with the Caustica algorithm that finds the same light
/// paths.
const INTEGRATOR_NAMES: [(&str, &str); 13] = [
    ("path", "path"),
    ("volpath", "path"),
    ("simplepath", "path"),
    ("simplevolpath", "path"),
    ("randomwalk", "path"),
    ("mlt", "path"),
    ("bdpt", "hybrid"),
    ("lightpath", "hybrid"),
    ("sppm", "sppm"),
    ("photonmap", "pm"),
    ("exphotonmap", "pm"),
    ("whitted", "whitted"),
    ("directlighting", "whitted"),
];

/// Pixel filters of pbrt, each with its name in `caustica render --filter`.
const FILTERS: [(&str, &str); 4] =
    [("box", "box"), ("triangle", "tent"), ("gaussian", "gaussian"), ("mitchell", "mitchell")];

/// Value of `maxdepth` if a pbrt scene does not state it.
const DEFAULT_MAX_DEPTH: f64 = 5.0;

/// Flags of `caustica render` that correspond to settings in a pbrt file.
///
/// A later directive replaces the flags of an earlier one of its kind.
#[derive(Default)]
pub(super) struct SuggestedFlags {
    integrator: Vec<String>,
    filter: Option<String>,
    sampler: Option<String>,
}

impl SuggestedFlags {
    /// Converts the directive of an integrator, a pixel filter or a sampler to flags. Ignores other
    /// directives.
    ///
    /// `name` is the type after the directive, such as `path` in `Integrator "path"`.
    pub fn add_directive(&mut self, directive: &str, name: &str, parameters: &Parameters) {
        match directive {
            "Integrator" | "SurfaceIntegrator" => {
                self.integrator.clear();
                let algorithm = INTEGRATOR_NAMES.iter().find(|(pbrt_name, _)| *pbrt_name == name);
                let Some((_, algorithm)) = algorithm else { return };
                self.integrator.push(format!("--integrator {algorithm}"));
                // pbrt counts the points of a path at which lights are sampled. Caustica counts the
                // bounces between them: one less.
                let depth = parameters.number_or("maxdepth", DEFAULT_MAX_DEPTH);
                if depth >= 1.0 && *algorithm != "whitted" {
                    self.integrator.push(format!("--max-bounces {}", depth.min(1e6) as u32 - 1));
                }
                if let Some(radius) = parameters.number("radius").filter(|radius| *radius > 0.0 && name == "sppm") {
                    self.integrator.push(format!("--radius {radius}"));
                }
            }
            "PixelFilter" => {
                let filter = FILTERS.iter().find(|(pbrt_name, _)| *pbrt_name == name);
                self.filter = filter.map(|(_, caustica_name)| format!("--filter {caustica_name}"));
            }
            "Sampler" => {
                let samples = parameters.number("pixelsamples").filter(|samples| *samples >= 1.0);
                self.sampler = samples.map(|samples| format!("--spp {}", samples.min(1e6) as u32));
            }
            // Other directives, such as `Accelerator`, have no flag.
            _ => {}
        }
    }

    /// Returns all flags, with spaces between; empty if the file has no settings.
    pub fn flags_text(&self) -> String {
        let flags = self.integrator.iter().chain(&self.filter).chain(&self.sampler);
        flags.map(String::as_str).collect::<Vec<_>>().join(" ")
    }
}
