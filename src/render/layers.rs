//! Layers of a render: the picture and maps of its estimated error.

use super::driver::RenderResult;
use super::error_estimate::{ErrorMaps, MIN_PASSES};
use crate::image::ExrLayer;
use crate::integrate::MeanGatherDisc;
use glam::Vec3;

/// Returns the layers of a picture file: the picture, whose layer has no name, and maps of its
/// estimated error if the error is estimated.
///
/// Layers `bias`, `radius` and `photons` exist only for algorithms with density estimates.
#[must_use]
pub fn picture_layers(rendered: &RenderResult) -> Vec<ExrLayer> {
    let mut layers = vec![rgb_layer("", &rendered.film.mean())];
    let estimator = rendered.estimator.as_ref().filter(|_| rendered.film.passes() >= MIN_PASSES);
    let Some(estimator) = estimator else { return layers };
    let ErrorMaps { noise, bias, caustic, indirect } = estimator.error_maps(&rendered.film);
    layers.push(rgb_layer("noise", &noise));
    if !bias.is_empty() {
        layers.push(rgb_layer("bias", &bias));
        let channels = |value: fn(&MeanGatherDisc) -> f32| {
            let map = |discs: &[MeanGatherDisc]| discs.iter().map(value).collect::<Vec<f32>>();
            vec![("caustic".to_owned(), map(&caustic)), ("global".to_owned(), map(&indirect))]
        };
        layers.push(ExrLayer { name: "radius".to_owned(), channels: channels(|d| d.radius) });
        layers.push(ExrLayer { name: "photons".to_owned(), channels: channels(|d| d.photons) });
    }
    layers
}

fn rgb_layer(name: &str, pixels: &[Vec3]) -> ExrLayer {
    let channel = |letter: &str, value: fn(&Vec3) -> f32| (letter.to_owned(), pixels.iter().map(value).collect());
    let channels = vec![channel("R", |p| p.x), channel("G", |p| p.y), channel("B", |p| p.z)];
    ExrLayer { name: name.to_owned(), channels }
}
