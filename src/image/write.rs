//! Pictures to files.

use std::path::Path;

use super::buffer::Image;
use super::error::WriteError;
use super::replace::{check_place, replace_file};
use super::tone::{ToneMap, WriteReport};
use super::{exr, png};

/// A format that pictures are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// PNG, 8 or 16 bits a channel, after the tone map.
    Png,
    /// OpenEXR, float RGB of 16 or 32 bits, linear radiance as it is.
    Exr,
}

impl OutputFormat {
    /// The format that a path's extension names, in upper or lower case.
    ///
    /// # Errors
    /// [`WriteError::Extension`] where it is neither `.png` nor `.exr`.
    pub fn from_path(path: &Path) -> Result<Self, WriteError> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("png") => Ok(Self::Png),
            Some(extension) if extension.eq_ignore_ascii_case("exr") => Ok(Self::Exr),
            _ => Err(WriteError::Extension { path: path.to_owned() }),
        }
    }
}

/// Bits a channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 levels.
    #[default]
    Eight,
    /// 65,536 levels.
    Sixteen,
}

/// Bits a channel of an OpenEXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatDepth {
    /// 11 digits of two, up to 65504.
    Half,
    /// Single precision.
    #[default]
    Single,
}

/// How a picture is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// Exposure and curve; OpenEXR ignores both.
    pub tone: ToneMap,
    /// Bits a channel; OpenEXR ignores it.
    pub depth: BitDepth,
    /// Bits a channel of OpenEXR; PNG ignores it.
    pub floats: FloatDepth,
    /// Pairs of key and text: text chunks of a PNG, lines `key: text` of an OpenEXR file's `comments`. A key has 1 to 79
    /// characters of printable ASCII without spaces at its ends or in a row; a text has no NUL.
    pub metadata: Vec<(String, String)>,
}

/// The bytes of the file that [`write`](fn@write) would make.
///
/// # Errors
/// [`WriteError::Exposure`], [`WriteError::Metadata`] where an option is out of range; [`WriteError::Encode`].
pub fn encode(
    format: OutputFormat,
    image: &Image,
    options: &WriteOptions,
) -> Result<(Vec<u8>, WriteReport), WriteError> {
    check_metadata(&options.metadata)?;
    match format {
        OutputFormat::Png => png::encode(image, options),
        OutputFormat::Exr => exr::encode(image, options.floats, &options.metadata),
    }
}

/// Writes a picture in the format that the path's extension names, whole or not at all (see [`replace_file`]).
///
/// The report tells what the format could not hold; a caller should pass it on to the user.
///
/// # Errors
/// [`WriteError`]; the file that stood at the path before is then untouched.
pub fn write(path: &Path, image: &Image, options: &WriteOptions) -> Result<WriteReport, WriteError> {
    let (file, report) = encode(OutputFormat::from_path(path)?, image, options)?;
    replace_file(path, &file)?;
    Ok(report)
}

/// Checks before a long render that [`write`](fn@write) will be able to use `path`: its extension is known, its folder
/// exists and takes new files, and nothing there must not be replaced. Leaves no trace.
///
/// # Errors
/// [`WriteError`], as [`write`](fn@write) would give.
pub fn check_writable(path: &Path) -> Result<(), WriteError> {
    OutputFormat::from_path(path)?;
    check_place(path)
}

/// The rules of PNG keywords (ISO/IEC 15948, 11.3.4.2), narrowed to ASCII; for OpenEXR too, so that a pair fits both or none.
pub(super) fn check_metadata(metadata: &[(String, String)]) -> Result<(), WriteError> {
    for (key, text) in metadata {
        let broken = if !(1..=79).contains(&key.len()) {
            Some("a key must have 1 to 79 characters")
        } else if !key.bytes().all(|byte| (32..127).contains(&byte)) {
            Some("a key must be of printable ASCII characters")
        } else if key.starts_with(' ') || key.ends_with(' ') || key.contains("  ") {
            Some("a key must not have spaces at its ends or in a row")
        } else if text.contains('\0') {
            Some("its text contains a NUL character")
        } else {
            None
        };
        if let Some(reason) = broken {
            return Err(WriteError::Metadata { key: key.clone(), reason });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Curve, read};
    use glam::Vec3;
    use std::fs;

    #[test]
    fn the_extension_chooses_the_format() {
        let format = |path: &str| OutputFormat::from_path(Path::new(path)).ok();
        assert_eq!([format("a.png"), format("b/c.EXR")], [Some(OutputFormat::Png), Some(OutputFormat::Exr)]);
        for path in ["a.jpg", "png", ".png", ""] {
            let message = check_writable(Path::new(path)).unwrap_err().to_string();
            assert!(message.contains(".png") && message.contains(".exr"), "{message}");
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let image = Image::from_pixels(2, 1, vec![Vec3::new(1.0, 0.0, 4.0), Vec3::splat(f32::NAN)]).unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        let options = WriteOptions::default();
        let report = write(&png, &image, &options).unwrap();
        assert_eq!(report, WriteReport { non_finite: 1, too_bright: 1, negative: 0 });
        assert_eq!(read(&png).unwrap().pixels(), [Vec3::new(1.0, 0.0, 1.0), Vec3::ZERO]);
        assert_eq!(write(&exr, &image, &options).unwrap().non_finite, 1);
        assert_eq!(read(&exr).unwrap().pixels()[0], image.pixels()[0]);
    }

    #[test]
    fn bad_options_leave_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let image = Image::new(1, 1).unwrap();
        let long = "k".repeat(80);
        for (key, text) in [("", "x"), (long.as_str(), "x"), (" k", "x"), ("Ω", "x"), ("a  b", "x"), ("k", "a\0b")] {
            let options = WriteOptions { metadata: vec![(key.to_owned(), text.to_owned())], ..Default::default() };
            assert!(matches!(write(&path, &image, &options), Err(WriteError::Metadata { .. })), "{key:?} {text:?}");
        }
        let tone = ToneMap { curve: Curve::Srgb, exposure_stops: f32::NAN };
        let options = WriteOptions { tone, ..Default::default() };
        assert!(matches!(write(&path, &image, &options), Err(WriteError::Exposure { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn the_longest_key_is_stored_in_both_formats() {
        let image = Image::new(1, 1).unwrap();
        let options = WriteOptions { metadata: vec![("k".repeat(79), "line\nline".to_owned())], ..Default::default() };
        for format in [OutputFormat::Png, OutputFormat::Exr] {
            encode(format, &image, &options).unwrap();
        }
    }
}
