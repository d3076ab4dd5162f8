//! Layers of a render: the picture, light groups, maps of its estimated error, and surface AOVs.

use super::driver::RenderResult;
use super::error_estimate::{ErrorMaps, MIN_ERROR_ESTIMATE_PASSES};
use crate::image::ExrLayer;
use crate::integrate::{LightGroup, MeanGatherDisc, SurfaceAovs};
use glam::Vec3;
use std::ops::Index;

/// Returns the layers of a picture file: the picture (an unnamed layer), light groups, the radiance
/// that clamping removed, and maps of the estimated error.
///
/// Light groups and removed radiance are included only if `rendered` has them. Error maps are
/// included only if the error is estimated, after at least [`MIN_ERROR_ESTIMATE_PASSES`] passes.
/// The error maps `bias`, `radius` and `photons` exist only for algorithms with density estimates.
#[must_use]
pub fn picture_layers(rendered: &RenderResult) -> Vec<ExrLayer> {
    let mut layers = vec![rgb_layer("", &rendered.film.mean_picture())];
    let groups = LightGroup::ALL.iter().zip(&rendered.light_group_films);
    layers.extend(groups.map(|(group, film)| rgb_layer(group.name(), &film.mean_picture())));
    layers.extend(rendered.clamping_loss_film.iter().map(|film| rgb_layer("clamped", &film.mean_picture())));
    let estimator = rendered.estimator.as_ref().filter(|_| rendered.film.passes() >= MIN_ERROR_ESTIMATE_PASSES);
    let Some(estimator) = estimator else { return layers };
    let ErrorMaps { noise, blur: bias, caustic_discs, indirect_discs } = estimator.error_maps(&rendered.film);
    layers.push(rgb_layer("noise", &noise));
    if !bias.is_empty() {
        layers.push(rgb_layer("bias", &bias));
        let channels = |value: fn(&MeanGatherDisc) -> f32| {
            let map = |discs: &[MeanGatherDisc]| discs.iter().map(value).collect::<Vec<f32>>();
            vec![("caustic".to_owned(), map(&caustic_discs)), ("global".to_owned(), map(&indirect_discs))]
        };
        layers.push(ExrLayer { name: "radius".to_owned(), channels: channels(|d| d.radius) });
        layers.push(ExrLayer { name: "photons".to_owned(), channels: channels(|d| d.mean_count) });
    }
    layers
}

/// Returns the layers `albedo`, `normal`, `depth`, `position`, `object`, `material` and `motion`.
///
/// Colors have the channels R, G and B; vectors X, Y and Z. Depth has the channel Z, as OpenEXR
/// recommends. Identifiers have the channel X, as in files of Blender. Motion has X and Y.
#[must_use]
pub fn surface_layers(aovs: &SurfaceAovs) -> Vec<ExrLayer> {
    let numbers = |name: &str, channel: &str, values: Vec<f32>| ExrLayer {
        name: name.to_owned(),
        channels: vec![(channel.to_owned(), values)],
    };
    let identifiers = |values: &[u32]| values.iter().map(|id| *id as f32).collect();
    vec![
        rgb_layer("albedo", &aovs.albedo),
        vector_layer("normal", ["X", "Y", "Z"], &aovs.normal),
        numbers("depth", "Z", aovs.depth.clone()),
        vector_layer("position", ["X", "Y", "Z"], &aovs.position),
        numbers("object", "X", identifiers(&aovs.object_id)),
        numbers("material", "X", identifiers(&aovs.material_id)),
        vector_layer("motion", ["X", "Y"], &aovs.motion),
    ]
}

/// Returns the layer `name` with the channels R, G and B of `pixels`.
#[must_use]
pub fn rgb_layer(name: &str, pixels: &[Vec3]) -> ExrLayer {
    vector_layer(name, ["R", "G", "B"], pixels)
}

fn vector_layer<V: Copy + Index<usize, Output = f32>, const N: usize>(
    name: &str,
    letters: [&str; N],
    pixels: &[V],
) -> ExrLayer {
    let channel = |(i, letter): (usize, &str)| (letter.to_owned(), pixels.iter().map(|pixel| pixel[i]).collect());
    ExrLayer { name: name.to_owned(), channels: letters.into_iter().enumerate().map(channel).collect() }
}
