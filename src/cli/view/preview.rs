//! Preview, the first picture of a render: few paths through few pixels, without pilots
//! (simulations before the first pass).

use crate::color::Rgb;
use crate::integrate::{Algorithm, ProgressMonitor, Settings};
use crate::scene::Scene;

/// Largest number of pixels of a preview. The actual number may be slightly larger, because width
/// and height are rounded.
const MAX_PIXELS: f64 = 20_000.0;

/// Number of camera paths per pixel of a preview.
const SAMPLES_PER_PIXEL: u32 = 2;

/// Returns the width and height of a preview for a picture of `width` × `height` pixels.
///
/// A preview has about the same shape and at most about [`MAX_PIXELS`] pixels.
fn preview_size((width, height): (u32, u32)) -> (u32, u32) {
    let pixels = f64::from(width) * f64::from(height);
    let factor = (MAX_PIXELS / pixels).sqrt().min(1.0);
    let shrunk = |side: u32| ((f64::from(side) * factor).round() as u32).max(1);
    // The preview of a very long picture is one pixel wide, so its length must be limited too.
    let (width, height) = (shrunk(width), shrunk(height));
    (width.min(MAX_PIXELS as u32), height.min(MAX_PIXELS as u32))
}

/// Renders a preview of `scene` by path tracing. Returns the width and height of the preview, and
/// the radiance of its pixels \[W/(m² sr)].
///
/// `settings` are the settings of the full render. The preview takes fewer samples per pixel and
/// makes no simulations before the first pass. The preview lacks caustics that only photons find.
pub(super) fn render_preview(
    scene: &Scene,
    settings: &Settings,
    monitor: &dyn ProgressMonitor,
) -> ((u32, u32), Vec<Rgb>) {
    let (width, height) = preview_size(scene.camera().size());
    let small = scene.with_camera(&scene.camera_in_description().with_size(width, height));
    let mut settings = Settings {
        allows_ray_photon_balance: false,
        allows_prefix_rays: false,
        allows_environment_guiding: false,
        allows_scatter_point_guiding: false,
        ..settings.clone()
    };
    settings.camera_paths.samples_per_pixel = Some(SAMPLES_PER_PIXEL);
    settings.camera_paths.adaptive = false;
    settings.camera_paths.estimate_error = false;
    let integrator = Algorithm::Path.prepare(&small, settings);
    ((width, height), integrator.render_pass(0, monitor).image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_small_and_keep_the_shape() {
        assert_eq!(preview_size((960, 720)), (163, 122));
        assert_eq!(preview_size((100, 80)), (100, 80));
        assert_eq!(preview_size((1 << 28, 1)), (20_000, 1));
        for size in [(1, 1), (1920, 1080), (16_384, 16_384), (3, 1 << 20)] {
            let (width, height) = preview_size(size);
            assert!(width >= 1 && height >= 1 && width * height <= 20_300, "{size:?}");
        }
    }
}
