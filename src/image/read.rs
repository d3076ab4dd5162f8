//! Pictures from files.

use std::fs;
use std::path::Path;

use super::buffer::{Image, RgbBytes};
use super::error::{DecodeFailure, ReadError};
use super::{exr, png};

const PNG_SIGNATURE: [u8; 4] = *b"\x89PNG";
const EXR_SIGNATURE: [u8; 4] = *b"\x76\x2f\x31\x01";

/// Reads a PNG or OpenEXR picture, told apart by its first bytes, as linear radiance.
///
/// A PNG is decoded by its gAMA chunk where it has one and no sRGB chunk, else by the sRGB curve. Of an OpenEXR file the
/// first layer with channels R, G and B is read. Exposure and tone curve are not undone.
///
/// # Errors
/// [`ReadError`] where the file is missing, damaged, of another format, transparent, or beyond [`super::MAX_PIXELS`].
pub fn read(path: &Path) -> Result<Image, ReadError> {
    let file = load(path)?;
    let image = if file.starts_with(&PNG_SIGNATURE) {
        png::read(&file)
    } else if file.starts_with(&EXR_SIGNATURE) {
        exr::read(&file)
    } else {
        return Err(ReadError::UnknownFormat { path: path.to_owned() });
    };
    image.map_err(|failure| failure.at(path.to_owned()))
}

/// Reads the bytes of an 8-bit PNG as they stand, for exact comparisons.
///
/// # Errors
/// [`ReadError`] as for [`read`], and where the file is no PNG or has 16 bits a channel.
pub fn read_bytes(path: &Path) -> Result<RgbBytes, ReadError> {
    let file = load(path)?;
    let bytes = if file.starts_with(&EXR_SIGNATURE) {
        Err(DecodeFailure::Reason("an OpenEXR picture has no bytes to compare: use an 8-bit PNG".into()))
    } else if file.starts_with(&PNG_SIGNATURE) {
        png::read_bytes(&file)
    } else {
        return Err(ReadError::UnknownFormat { path: path.to_owned() });
    };
    bytes.map_err(|failure| failure.at(path.to_owned()))
}

fn load(path: &Path) -> Result<Vec<u8>, ReadError> {
    fs::read(path).map_err(|source| ReadError::Io { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_content_and_others_refused() {
        let folder = tempfile::tempdir().unwrap();
        let text = folder.path().join("text.png");
        fs::write(&text, "P3 1 1 255 0 0 0").unwrap();
        assert!(matches!(read(&text), Err(ReadError::UnknownFormat { .. })));
        assert!(matches!(read_bytes(&text), Err(ReadError::UnknownFormat { .. })));
        assert!(matches!(read(&folder.path().join("none.png")), Err(ReadError::Io { .. })));

        let image = Image::new(2, 3).unwrap();
        let misnamed = folder.path().join("misnamed.png");
        fs::write(&misnamed, exr::encode(&image, &[]).unwrap().0).unwrap();
        assert_eq!(read(&misnamed).unwrap(), image);
        assert!(read_bytes(&misnamed).unwrap_err().to_string().contains("8-bit PNG"));
    }
}
