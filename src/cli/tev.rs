//! Output of `--tev`: the picture of a render in the viewer tev.

use super::progress::print_message;
use crate::image::ExrLayer;
use crate::integrate::{LightGroup, SurfaceAovs};
use crate::render::{Film, RenderResult, picture_layers, rgb_layer, surface_layers};
use crate::view::{TevAddress, TevClient};

/// Picture of a render in the viewer.
pub(super) struct TevOutput {
    client: TevClient,
    /// Name of the image.
    name: String,
}

impl TevOutput {
    /// Connects to the viewer at `address`. `scene` names the image.
    pub fn start(address: &TevAddress, scene: &str) -> Self {
        let place = address.to_string();
        let report = move |error| print_message(&format!("warning: the picture is not sent to {place}: {error}"));
        Self { client: TevClient::start(address.clone(), report), name: scene.to_owned() }
    }

    /// Sends the picture and its light groups, unless the last time was too short a time ago.
    pub fn send_if_due(&mut self, rendered: &RenderResult) {
        self.client.send_if_due(&self.name, rendered.film.size(), || picture_and_group_layers(rendered));
    }

    /// Sends the last picture. If `has_layers` is true, sends the layers of `--aov` as a further
    /// image. Waits until the viewer has read them, but not for long.
    pub fn finish(self, rendered: &RenderResult, aovs: Option<&SurfaceAovs>, has_layers: bool) {
        let size = rendered.film.size();
        self.client.send(&self.name, size, picture_and_group_layers(rendered));
        if has_layers {
            let mut layers = picture_layers(rendered);
            layers.extend(aovs.into_iter().flat_map(surface_layers));
            self.client.send(&format!("{} layers", self.name), size, layers);
        }
        if !self.client.finish() {
            print_message("warning: tev reads too slowly, so it lacks the last picture");
        }
    }
}

/// Returns the picture and its light groups.
fn picture_and_group_layers(rendered: &RenderResult) -> Vec<ExrLayer> {
    let layer = |(name, film): (&str, &Film)| rgb_layer(name, &film.mean());
    let groups = LightGroup::ALL.iter().map(|group| group.name()).zip(&rendered.groups);
    std::iter::once(("", &rendered.film)).chain(groups).map(layer).collect()
}
