//! Writes several layers into one OpenEXR file.

use super::buffer::pixel_count;
use super::error::WriteError;
use super::exr::{REC_709, attributes};
use super::replace::{check_place, replace_file};
use super::write::check_metadata;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, SmallVec, Text, WritableImage,
};
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;

/// Longest name of a channel in OpenEXR \[bytes].
const MAX_NAME: usize = 255;

/// A named group of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrLayer {
    /// Name of the layer; empty for the picture itself.
    pub name: String,
    /// Names and values of the channels, in rows from the top. The picture has `R`, `G` and `B`.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl ExrLayer {
    /// Name of a channel in the file: `noise.R`, or `R` in the unnamed layer.
    fn full_name(&self, channel: &str) -> String {
        if self.name.is_empty() { channel.to_owned() } else { format!("{}.{channel}", self.name) }
    }
}

/// Checks before a long render that [`write_layers`] can write to `path`. Leaves no trace.
///
/// # Errors
/// [`WriteError::NoLayers`] if the extension is not `.exr`, or the error of [`check_place`].
pub fn check_layers_path(path: &Path) -> Result<(), WriteError> {
    check_extension(path)?;
    check_place(path)
}

fn check_extension(path: &Path) -> Result<(), WriteError> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        Ok(())
    } else {
        Err(WriteError::NoLayers { path: path.to_owned() })
    }
}

/// Writes layers of `size` (width, height) as 32-bit floats into one part of an OpenEXR file.
///
/// Returns the number of values that are NaN or infinite. The file is replaced atomically (see
/// [`replace_file`]). Viewers take the text before the last dot of a channel's name as its layer.
///
/// # Errors
/// [`WriteError`]; an existing file is then unchanged. [`WriteError::Channel`] if a name is empty,
/// too long, or repeated, or if the number of values is not the number of pixels.
pub fn write_layers(
    path: &Path,
    size: (u32, u32),
    layers: &[ExrLayer],
    metadata: &[(String, String)],
) -> Result<usize, WriteError> {
    check_extension(path)?;
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
        let name = layer.full_name(channel);
        let violated = if channel.is_empty() || name.len() > MAX_NAME || name.contains('\0') {
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
    // The format requires channels in the order of their names.
    let channels = AnyChannels::sort(channels);
    let mut file = ExrImage::from_layer(Layer::new(size, attributes(metadata), Encoding::SMALL_LOSSLESS, channels));
    file.attributes.chromaticities = Some(REC_709);
    let mut bytes = Cursor::new(Vec::new());
    file.write().non_parallel().to_buffered(&mut bytes).map_err(|e| failed(&e))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, InputFormat, read_with_format};
    use exr::prelude::read_first_flat_layer_from_file;
    use glam::Vec3;

    const SIZE: (u32, u32) = (37, 21);

    fn layer(name: &str, channels: &[&str]) -> ExrLayer {
        let values = |k: usize| (0..SIZE.0 * SIZE.1).map(|i| (i as f32 * 0.1 + k as f32) * name.len() as f32).collect();
        let channels = channels.iter().enumerate().map(|(k, c)| ((*c).to_owned(), values(k))).collect();
        ExrLayer { name: name.to_owned(), channels }
    }

    fn picture() -> (Image, ExrLayer) {
        let pixels: Vec<Vec3> = (0..SIZE.0 * SIZE.1).map(|i| Vec3::new(i as f32, 0.5, -(i as f32)) / 7.0).collect();
        let channel = |name: &str, k: usize| (name.to_owned(), pixels.iter().map(|p| p[k]).collect());
        let channels = vec![channel("R", 0), channel("G", 1), channel("B", 2)];
        (Image::from_pixels(SIZE.0, SIZE.1, pixels.clone()).unwrap(), ExrLayer { name: String::new(), channels })
    }

    #[test]
    fn layers_are_stored_and_the_picture_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, first) = picture();
        // `Noise` sorts before the channels of the picture.
        let layers =
            [first, layer("Noise", &["R", "G", "B"]), layer("radius", &["caustic", "a channel of a long name"])];
        let pairs = [("Seed".to_owned(), "7".to_owned())];
        write_layers(&path, SIZE, &layers, &pairs).unwrap();
        assert_eq!(read_with_format(&path).unwrap(), (image, InputFormat::Exr));

        let file = read_first_flat_layer_from_file(&path).unwrap().layer_data;
        assert_eq!((file.size.0, file.size.1), (37, 21));
        assert_eq!(file.attributes.comments.as_ref().unwrap().to_string(), "Seed: 7");
        let mut expected: Vec<(String, &Vec<f32>)> = Vec::new();
        for layer in &layers {
            expected.extend(layer.channels.iter().map(|(name, values)| (layer.full_name(name), values)));
        }
        assert_eq!((expected[3].0.as_str(), expected[6].0.as_str()), ("Noise.R", "radius.caustic"));
        expected.sort_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(file.channel_data.list.len(), expected.len());
        for (found, (name, values)) in file.channel_data.list.iter().zip(expected) {
            assert_eq!(found.name.to_string(), name);
            assert_eq!(found.sample_data, FlatSamples::F32(values.clone()), "{name}");
        }
    }

    #[test]
    fn encoding_is_deterministic() {
        let layers = [picture().1, layer("noise", &["R", "G", "B"])];
        let pairs = [("Seed".to_owned(), "7".to_owned()), ("Scene".to_owned(), "a".to_owned())];
        let once = encode(SIZE, &layers, &pairs).unwrap();
        assert!((0..8).all(|_| encode(SIZE, &layers, &pairs).unwrap() == once));
    }

    #[test]
    fn invalid_layers_leave_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, "old").unwrap();
        let mut short = layer("noise", &["R", "G"]);
        short.channels[1].1.pop();
        let twice = [layer("noise", &["R"]), layer("noise", &["R"])];
        let long = [layer(&"n".repeat(254), &["R"])];
        for (layers, word) in [
            ([short].as_slice(), "`noise.G`"),
            (&twice, "not unique"),
            (&long, "255"),
            (&[layer("a", &[""])], "1 to 255"),
        ] {
            let message = write_layers(&path, SIZE, layers, &[]).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        assert!(write_layers(&path, SIZE, &[], &[]).is_err() && write_layers(&path, (0, 1), &twice[..1], &[]).is_err());
        let bad = [(String::new(), String::new())];
        assert!(matches!(write_layers(&path, SIZE, &twice[..1], &bad), Err(WriteError::Metadata { .. })));
        let message = check_layers_path(Path::new("a.png")).unwrap_err().to_string();
        assert!(message.contains("`a.png`") && message.contains(".exr"), "{message}");
        assert!(matches!(write_layers(Path::new("a.png"), SIZE, &twice[..1], &[]), Err(WriteError::NoLayers { .. })));
        assert!(check_layers_path(&path).is_ok());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
    }
}
