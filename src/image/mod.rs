//! Pictures: pixel buffers, tone mapping, picture files, and error metrics.
//!
//! PNG and OpenEXR can be read and written; Radiance HDR can be read.

mod buffer;
mod error;
mod exr;
pub mod flip;
mod layers;
pub mod metrics;
mod open;
mod options;
mod png;
mod ramp;
mod read;
mod relative;
mod replace;
mod rgba;
mod tone;
mod write;

pub use buffer::{Image, MAX_PIXELS, PictureSizeError, Raster, Rgb8Image};
pub use error::{ReadError, WriteError};
pub use layers::{ExrLayer, check_layers_path, write_layers};
pub(crate) use open::open_file;
pub use options::{BitDepth, ExrPrecision, WriteOptions};
pub use ramp::{diverging_color, sequential_color};
pub use read::{
    InputFormat, PixelMeaning, decode, read, read_and_detect_format, read_non_color, read_rgb8, read_with_memory_limit,
};
pub use relative::RelativeErrorWeights;
pub(crate) use replace::parent_folder;
pub use replace::{canonical_output_path, check_replaceable, replace_file, replace_file_with};
pub(crate) use rgba::{QuantizedRgba, decode_quantized_rgba};
pub(crate) use tone::srgb_decode;
pub use tone::{ClippedPixelReport, MAX_EXPOSURE_STOPS, ToneCurve, ToneMap, UnknownToneCurve};
pub use write::{OutputFormat, check_writable, encode, write};
