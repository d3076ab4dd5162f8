//! Writes OpenEXR files with several layers.

use super::buffer::pixel_count;
use super::error::WriteError;
use super::exr::{REC_709, layer_attributes};
use super::options::check_metadata;
use super::replace::{check_replaceable, replace_file};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, SmallVec, Text, WritableImage,
};
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;

/// Longest name of a channel in OpenEXR \[bytes].
const MAX_CHANNEL_NAME_BYTES: usize = 255;

/// A layer of an OpenEXR file: a named group of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrLayer {
    /// Name of the layer. The name is empty for the main picture, which picture viewers show.
    pub name: String,
    /// Channels of the layer: pairs of a channel name and one value per pixel, in rows from the
    /// top.
    ///
    /// The unnamed layer should have channels `R`, `G` and `B`, because picture viewers show it.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl ExrLayer {
    /// Returns the name that `channel` has in the file. The name of the layer is its prefix, such
    /// as `noise.R`. A channel of the unnamed layer has no prefix.
    #[must_use]
    pub fn full_channel_name(&self, channel: &str) -> String {
        if self.name.is_empty() { channel.to_owned() } else { format!("{}.{channel}", self.name) }
    }
}

/// Checks whether [`write_layers`] can write to `path`, without changing a file.
///
/// # Errors
/// [`WriteError::LayersNotSupported`] if the extension is not `.exr`. Otherwise, the errors of
/// [`check_replaceable`].
pub fn check_layers_path(path: &Path) -> Result<(), WriteError> {
    check_exr_extension(path)?;
    check_replaceable(path)
}

fn check_exr_extension(path: &Path) -> Result<(), WriteError> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        Ok(())
    } else {
        Err(WriteError::LayersNotSupported { path: path.to_owned() })
    }
}

/// Writes `layers` of `size` (width, height) as an OpenEXR file with 32-bit channels.
///
/// Returns the number of values that are NaN or infinite. The file is replaced atomically, see
/// [`replace_file`]. All layers are in one part of the file. Each channel has the name of its layer
/// as prefix, see [`ExrLayer::full_channel_name`].
///
/// # Errors
/// [`WriteError`]; an existing file is then unchanged. [`WriteError::Channel`] if the name of a
/// channel is empty, too long or not unique. Also if a channel does not have one value per pixel.
pub fn write_layers(
    path: &Path,
    size: (u32, u32),
    layers: &[ExrLayer],
    metadata: &[(String, String)],
) -> Result<usize, WriteError> {
    check_exr_extension(path)?;
    check_metadata(metadata)?;
    replace_file(path, &encode(size, layers, metadata)?)?;
    let values = layers.iter().flat_map(|layer| &layer.channels).flat_map(|(_, values)| values);
    Ok(values.filter(|value| !value.is_finite()).count())
}

fn encode(size: (u32, u32), layers: &[ExrLayer], metadata: &[(String, String)]) -> Result<Vec<u8>, WriteError> {
    let failed = |error: &dyn ToString| WriteError::Encode(error.to_string());
    let pixels = pixel_count(size.0, size.1).map_err(|e| failed(&e))?;
    let mut names = BTreeSet::new();
    let mut channels = SmallVec::new();
    for (layer, (channel, values)) in layers.iter().flat_map(|layer| layer.channels.iter().map(move |c| (layer, c))) {
        let name = layer.full_channel_name(channel);
        let violated = if channel.is_empty() || name.len() > MAX_CHANNEL_NAME_BYTES || name.contains('\0') {
            Some("its name must have 1 to 255 bytes, and no NUL")
        } else if values.len() != pixels {
            Some("it must have one value per pixel")
        } else if !names.insert(name.clone()) {
            Some("its name is not unique")
        } else {
            None
        };
        if let Some(reason) = violated {
            return Err(WriteError::Channel { channel: name, reason });
        }
        let name = Text::from_slice_unchecked(name.as_bytes());
        channels.push(AnyChannel::new(name, FlatSamples::F32(values.clone())));
    }
    if channels.is_empty() {
        return Err(WriteError::Encode("there are no channels".to_owned()));
    }
    let size = (size.0 as usize, size.1 as usize);
    // OpenEXR requires channels in the order of their names.
    let channels = AnyChannels::sort(channels);
    let mut file =
        ExrImage::from_layer(Layer::new(size, layer_attributes(metadata), Encoding::SMALL_LOSSLESS, channels));
    file.attributes.chromaticities = Some(REC_709);
    let mut bytes = Cursor::new(Vec::new());
    file.write().non_parallel().to_buffered(&mut bytes).map_err(|e| failed(&e))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests;
