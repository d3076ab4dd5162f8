//! `--aov`: what the gauge knows of each pixel, as layers of one OpenEXR file.

use crate::image::ExrLayer;
use crate::integrate::Discs;
use crate::render::Rendered;
use crate::render::error_estimate::{ErrorMaps, MIN_PASSES};
use glam::Vec3;

/// The picture and the maps of its error, where passes are enough to tell it; those of estimates where there are estimates.
pub(super) fn layers(rendered: &Rendered) -> Vec<ExrLayer> {
    let mut layers = vec![rgb("", &rendered.film.mean())];
    let Some(gauge) = rendered.estimator.as_ref().filter(|_| rendered.film.passes() >= MIN_PASSES) else {
        return layers;
    };
    let ErrorMaps { noise, bias, caustic, global } = gauge.maps(&rendered.film);
    layers.push(rgb("noise", &noise));
    if !bias.is_empty() {
        layers.push(rgb("bias", &bias));
        let both = |of: fn(&Discs) -> f32| {
            let map = |discs: &[Discs]| discs.iter().map(of).collect::<Vec<f32>>();
            vec![("caustic".to_owned(), map(&caustic)), ("global".to_owned(), map(&global))]
        };
        layers.push(ExrLayer { name: "radius".to_owned(), channels: both(|d| d.radius) });
        layers.push(ExrLayer { name: "photons".to_owned(), channels: both(|d| d.photons) });
    }
    layers
}

fn rgb(name: &str, pixels: &[Vec3]) -> ExrLayer {
    let channel = |letter: &str, of: fn(&Vec3) -> f32| (letter.to_owned(), pixels.iter().map(of).collect());
    let channels = vec![channel("R", |p| p.x), channel("G", |p| p.y), channel("B", |p| p.z)];
    ExrLayer { name: name.to_owned(), channels }
}
