//! Output of `--tev`: the picture of a render in the viewer tev.

use super::progress::print_message;
use crate::image::ExrLayer;
use crate::integrate::{LightGroup, SurfaceAovs};
use crate::render::{Film, RenderResult, picture_layers, rgb_layer, surface_layers};
use crate::view::{TevAddress, TevClient};

/// Connection that shows the picture of a render in the viewer tev.
pub(super) struct TevOutput {
    client: TevClient,
    /// Name of the image in the viewer: the path of the scene file.
    name: String,
}

impl TevOutput {
    /// Connects to the viewer at `address`. The image gets the name `scene`.
    pub fn start(address: &TevAddress, scene: &str) -> Self {
        let place = address.to_string();
        let report = move |error| print_message(&format!("warning: the picture is not sent to {place}: {error}"));
        Self { client: TevClient::start(address.clone(), report), name: scene.to_owned() }
    }

    /// Sends the picture and its light groups to the viewer if an update is due; see
    /// [`TevClient::queue_image_if_due`].
    pub fn send_if_due(&mut self, rendered: &RenderResult) {
        self.client.queue_image_if_due(&self.name, rendered.film.size(), || picture_and_group_layers(rendered));
    }

    /// Sends the final picture to the viewer. If `has_layers` is true, also sends the layers of
    /// `--aov` as a second image.
    ///
    /// Waits at most a few seconds for the viewer to read the images. Prints a warning if the
    /// viewer is slower.
    pub fn finish(self, rendered: &RenderResult, aovs: Option<&SurfaceAovs>, has_layers: bool) {
        let size = rendered.film.size();
        self.client.queue_image(&self.name, size, picture_and_group_layers(rendered));
        if has_layers {
            let mut layers = picture_layers(rendered);
            layers.extend(aovs.into_iter().flat_map(surface_layers));
            self.client.queue_image(&format!("{} layers", self.name), size, layers);
        }
        if !self.client.finish() {
            print_message("warning: tev reads too slowly, so it lacks the last picture");
        }
    }
}

/// Returns the layers that the viewer shows during the render: the mean of the passes so far, and
/// its light groups.
fn picture_and_group_layers(rendered: &RenderResult) -> Vec<ExrLayer> {
    let layer = |(name, film): (&str, &Film)| rgb_layer(name, &film.mean_picture());
    let groups = LightGroup::ALL.iter().map(|group| group.name()).zip(&rendered.light_group_films);
    std::iter::once(("", &rendered.film)).chain(groups).map(layer).collect()
}
