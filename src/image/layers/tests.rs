use super::*;
use crate::image::{Image, InputFormat, read_and_detect_format};
use exr::prelude::read_first_flat_layer_from_file;
use glam::Vec3;

const SIZE: (u32, u32) = (37, 21);

fn layer_with_numbered_values(name: &str, channels: &[&str]) -> ExrLayer {
    let values = |k: usize| (0..SIZE.0 * SIZE.1).map(|i| (i as f32 * 0.1 + k as f32) * name.len() as f32).collect();
    let channels = channels.iter().enumerate().map(|(k, c)| ((*c).to_owned(), values(k))).collect();
    ExrLayer { name: name.to_owned(), channels }
}

fn image_and_its_exr_layer() -> (Image, ExrLayer) {
    let pixels: Vec<Vec3> = (0..SIZE.0 * SIZE.1).map(|i| Vec3::new(i as f32, 0.5, -(i as f32)) / 7.0).collect();
    let channel = |name: &str, k: usize| (name.to_owned(), pixels.iter().map(|p| p[k]).collect());
    let channels = vec![channel("R", 0), channel("G", 1), channel("B", 2)];
    (Image::from_pixels(SIZE.0, SIZE.1, pixels.clone()).unwrap(), ExrLayer { name: String::new(), channels })
}

#[test]
fn layers_are_stored_and_the_picture_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let (image, first) = image_and_its_exr_layer();
    // In the order of names, the channels of `Noise` stand between the channels G and R of the
    // picture. The reader must find the picture nevertheless.
    let layers = [
        first,
        layer_with_numbered_values("Noise", &["R", "G", "B"]),
        layer_with_numbered_values("radius", &["caustic", "a channel of a long name"]),
    ];
    let pairs = [("Seed".to_owned(), "7".to_owned())];
    write_layers(&path, SIZE, &layers, &pairs).unwrap();
    assert_eq!(read_and_detect_format(&path).unwrap(), (image, InputFormat::Exr));

    let file = read_first_flat_layer_from_file(&path).unwrap().layer_data;
    assert_eq!((file.size.0, file.size.1), (37, 21));
    assert_eq!(file.attributes.comments.as_ref().unwrap().to_string(), "Seed: 7");
    let mut expected: Vec<(String, &Vec<f32>)> = Vec::new();
    for layer in &layers {
        expected.extend(layer.channels.iter().map(|(name, values)| (layer.full_channel_name(name), values)));
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
    let layers = [image_and_its_exr_layer().1, layer_with_numbered_values("noise", &["R", "G", "B"])];
    let pairs = [("Seed".to_owned(), "7".to_owned()), ("Scene".to_owned(), "a".to_owned())];
    let once = encode(SIZE, &layers, &pairs).unwrap();
    assert!((0..8).all(|_| encode(SIZE, &layers, &pairs).unwrap() == once));
}

#[test]
fn invalid_layers_leave_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, "old").unwrap();
    let mut short = layer_with_numbered_values("noise", &["R", "G"]);
    short.channels[1].1.pop();
    let twice = [layer_with_numbered_values("noise", &["R"]), layer_with_numbered_values("noise", &["R"])];
    let long = [layer_with_numbered_values(&"n".repeat(254), &["R"])];
    for (layers, word) in [
        ([short].as_slice(), "`noise.G`"),
        (&twice, "not unique"),
        (&long, "255"),
        (&[layer_with_numbered_values("a", &[""])], "1 to 255"),
    ] {
        let message = write_layers(&path, SIZE, layers, &[]).unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
    }
    assert!(write_layers(&path, SIZE, &[], &[]).is_err() && write_layers(&path, (0, 1), &twice[..1], &[]).is_err());
    let bad = [(String::new(), String::new())];
    assert!(matches!(write_layers(&path, SIZE, &twice[..1], &bad), Err(WriteError::Metadata { .. })));
    let message = check_layers_path(Path::new("a.png")).unwrap_err().to_string();
    assert!(message.contains("`a.png`") && message.contains(".exr"), "{message}");
    assert!(matches!(
        write_layers(Path::new("a.png"), SIZE, &twice[..1], &[]),
        Err(WriteError::LayersNotSupported { .. })
    ));
    assert!(check_layers_path(&path).is_ok());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
}
