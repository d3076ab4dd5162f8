//! Reads pictures from files.

use std::io::{Cursor, Read};
use std::path::Path;

use ::image::DynamicImage;
use ::image::codecs::hdr::HdrDecoder;
use glam::Vec3;

use super::buffer::{Image, RgbBytes, pixel_count};
use super::error::{DecodeFailure, ReadError, check_memory, check_plausible};
use super::open::open_file;
use super::{exr, png};

const PNG_SIGNATURE: [u8; 4] = *b"\x89PNG";
const EXR_SIGNATURE: [u8; 4] = *b"\x76\x2f\x31\x01";
/// Common start of `#?RADIANCE` and `#?RGBE`.
const HDR_SIGNATURE: [u8; 3] = *b"#?R";

/// File format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFormat {
    /// PNG: display levels.
    Png,
    /// OpenEXR: radiance.
    Exr,
    /// Radiance HDR: radiance.
    Hdr,
}

impl InputFormat {
    /// Format by the signature of a file, whatever its name is.
    fn of(file: &[u8]) -> Option<Self> {
        match file {
            _ if file.starts_with(&PNG_SIGNATURE) => Some(Self::Png),
            _ if file.starts_with(&EXR_SIGNATURE) => Some(Self::Exr),
            _ if file.starts_with(&HDR_SIGNATURE) => Some(Self::Hdr),
            _ => None,
        }
    }
}

/// Reads a PNG, OpenEXR or Radiance HDR picture as linear radiance. Its signature selects the
/// format.
///
/// A PNG is decoded by its gAMA chunk if it has one and no sRGB chunk, else by the sRGB curve. Of
/// an OpenEXR file the first layer with channels R, G and B is read. The exposures that a Radiance
/// HDR file states are undone. Other exposures and tone curves are not.
///
/// # Errors
/// [`ReadError`] if the file is missing, damaged, of another format, transparent, or larger than
/// [`super::MAX_PIXELS`].
pub fn read(path: &Path) -> Result<Image, ReadError> {
    Ok(read_with_format(path)?.0)
}

/// Reads a picture like [`read`], and returns its format.
///
/// # Errors
/// [`ReadError`], see [`read`].
pub fn read_with_format(path: &Path) -> Result<(Image, InputFormat), ReadError> {
    let file = load(path, None)?;
    decode(path, &file, Meaning::Light, None)
}

/// Reads a picture like [`read`], without a transfer function for PNG: data from 0 to 1.
///
/// # Errors
/// [`ReadError`], see [`read`].
pub fn read_data(path: &Path) -> Result<Image, ReadError> {
    read_within(path, Meaning::Numbers, None)
}

/// Meaning of the samples of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Radiance. The transfer function of a PNG is undone.
    Light,
    /// Data such as roughness. Samples of a PNG are taken without a transfer function, from 0 to 1.
    Numbers,
}

/// Reads a picture like [`read`]. One that needs more than `free` bytes is refused before
/// allocation.
///
/// # Errors
/// [`ReadError`], see [`read`]; also if the memory does not suffice.
pub fn read_within(path: &Path, meaning: Meaning, free: Option<u64>) -> Result<Image, ReadError> {
    let file = load(path, free)?;
    Ok(decode(path, &file, meaning, free.map(|free| free.saturating_sub(file.len() as u64)))?.0)
}

/// Decodes the bytes of a file like [`read_within`], and returns its format. Errors name `path`.
///
/// # Errors
/// [`ReadError`], see [`read_within`].
pub fn decode(
    path: &Path,
    file: &[u8],
    meaning: Meaning,
    free: Option<u64>,
) -> Result<(Image, InputFormat), ReadError> {
    let format = InputFormat::of(file).ok_or_else(|| ReadError::UnknownFormat { path: path.to_owned() })?;
    let image = match (format, meaning) {
        (InputFormat::Png, Meaning::Light) => png::read(file, free),
        (InputFormat::Png, Meaning::Numbers) => png::read_data(file, free),
        (InputFormat::Exr, _) => exr::read(file, free),
        (InputFormat::Hdr, _) => read_hdr(file, free),
    };
    Ok((image.map_err(|failure| failure.at(path.to_owned()))?, format))
}

/// Reads the bytes of an 8-bit PNG, for exact comparisons.
///
/// # Errors
/// [`ReadError`], see [`read`]; also if the file is not an 8-bit PNG.
pub fn read_bytes(path: &Path) -> Result<RgbBytes, ReadError> {
    let file = load(path, None)?;
    let bytes = match InputFormat::of(&file) {
        Some(InputFormat::Png) => png::read_bytes(&file),
        Some(_) => Err(DecodeFailure::Reason(
            "a picture of floating-point numbers has no bytes to compare: use an 8-bit PNG".into(),
        )),
        None => return Err(ReadError::UnknownFormat { path: path.to_owned() }),
    };
    bytes.map_err(|failure| failure.at(path.to_owned()))
}

/// Reads a Radiance HDR picture (Ward 1991, "Real Pixels") and divides it by its stated exposure.
fn read_hdr(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    let reason = |error: ::image::ImageError| DecodeFailure::Reason(error.to_string());
    // Strict decoding accepts only one of the two signatures.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(file)).map_err(reason)?;
    let header = decoder.metadata();
    // A run of at most 127 bytes takes two, far below the bound of DEFLATE.
    let pixels = pixel_count(header.width, header.height)?;
    check_plausible(4 * pixels as u64, file.len())?;
    check_memory(pixels, free)?;
    let exposure = header.exposure.unwrap_or(1.0);
    if !(exposure > 0.0 && exposure.is_finite()) {
        return Err(DecodeFailure::Reason(format!("the exposure is {exposure}, which is not above zero")));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(reason)?.into_rgb32f();
    let pixels = picture.pixels().map(|p| Vec3::from(p.0) / exposure).collect();
    Ok(Image::from_pixels(header.width, header.height, pixels)?)
}

/// Reads a file of at most `free` bytes.
fn load(path: &Path, free: Option<u64>) -> Result<Vec<u8>, ReadError> {
    let refused = |source| ReadError::Io { path: path.to_owned(), source };
    let (mut file, needed) = open_file(path).map_err(refused)?;
    if let Some(free) = free.filter(|free| needed > *free) {
        return Err(ReadError::Memory { path: path.to_owned(), needed, free });
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(refused)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::FloatDepth;
    use std::fs;

    #[test]
    fn signatures_select_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let text = folder.path().join("text.png");
        fs::write(&text, "P3 1 1 255 0 0 0").unwrap();
        assert!(matches!(read(&text), Err(ReadError::UnknownFormat { .. })));
        assert!(matches!(read_bytes(&text), Err(ReadError::UnknownFormat { .. })));
        assert!(matches!(read(&folder.path().join("none.png")), Err(ReadError::Io { .. })));

        let image = Image::new(2, 3).unwrap();
        let misnamed = folder.path().join("misnamed.png");
        fs::write(&misnamed, exr::encode(&image, FloatDepth::Single, &[]).unwrap().0).unwrap();
        assert_eq!(read(&misnamed).unwrap(), image);
        assert!(read_bytes(&misnamed).unwrap_err().to_string().contains("8-bit PNG"));
    }

    /// Two RGBE pixels: mantissa / 256 · 2^(exponent − 128).
    fn hdr(header: &str) -> Vec<u8> {
        let mut file = format!("{header}\n\n-Y 1 +X 2\n").into_bytes();
        file.extend([128, 64, 32, 129, 200, 100, 50, 138]);
        file
    }

    #[test]
    fn radiance_hdr_exposures_are_undone() {
        let read =
            |header| read_hdr(&hdr(header), None).unwrap_or_else(|failure| panic!("{}", failure.at("memory".into())));
        let plain = read("#?RADIANCE\nFORMAT=32-bit_rle_rgbe");
        assert_eq!(plain.pixels(), [Vec3::new(1.0, 0.5, 0.25), Vec3::new(800.0, 400.0, 200.0)]);
        let exposed = read("#?RGBE\nEXPOSURE=2\nEXPOSURE=4");
        assert_eq!(exposed.pixels()[0] * 8.0, plain.pixels()[0]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sky.hdr");
        fs::write(&path, hdr("#?RADIANCE")).unwrap();
        assert_eq!(super::read(&path).unwrap(), plain);
        assert!(read_bytes(&path).unwrap_err().to_string().contains("8-bit PNG"));
    }

    #[test]
    fn damaged_radiance_hdr_is_refused() {
        let good = hdr("#?RADIANCE");
        for cut in 0..good.len() {
            assert!(read_hdr(&good[..cut], None).is_err(), "cut at {cut}");
        }
        let huge = |size: &str| [b"#?RADIANCE\n\n".as_slice(), size.as_bytes(), b"\n\x01\x01\x01\x80"].concat();
        for size in ["-Y 16000 +X 16000", "-Y 99999999 +X 99999999", "-Y 0 +X 5", "-Y -1 +X 5"] {
            assert!(read_hdr(&huge(size), None).is_err(), "{size}");
        }
        for header in ["#?RADIANCE\nEXPOSURE=0", "#?RADIANCE\nEXPOSURE=inf", "#?RADIANCE\nFORMAT=32-bit_rle_xyze"] {
            assert!(read_hdr(&hdr(header), None).is_err(), "{header}");
        }
    }
}
