//! Checks, before a render starts, that its pictures and photons fit into memory.

use crate::image::{MAX_PIXELS, PictureSizeError};
use crate::integrate::ExpectedPhotons;
use crate::stats::format_bytes;

/// Memory per pixel of a render that estimates no error and stores no layers besides the picture
/// \[bytes].
///
/// The film takes 50 bytes, the current pass 13, and the distribution of camera rays over the
/// pixels (`--adaptive`) 20; 5 bytes are a reserve. After the last pass, the mean picture and the
/// encoded file reuse the memory of the pass.
const BASE_BYTES_PER_PIXEL: u64 = 88;

/// Memory per pixel that an error estimate needs, in addition to [`BASE_BYTES_PER_PIXEL`] \[bytes].
///
/// The error estimator holds 284 bytes per pixel, for noise and for density estimates with smaller
/// radii. This constant and [`BASE_BYTES_PER_PIXEL`] together are 470 bytes: 445 were measured,
/// error maps take 17, and 8 are a reserve.
const ERROR_BYTES_PER_PIXEL: u64 = 382;

/// Memory per pixel that light groups need, in addition to [`BASE_BYTES_PER_PIXEL`] \[bytes].
///
/// The films of the three groups take 150 bytes, and those of the current pass 36; 24 bytes are a
/// reserve. The layers of the written file reuse the memory of the pass.
const GROUP_BYTES_PER_PIXEL: u64 = 210;

/// Memory per pixel for the light that clamping removes, in addition to [`BASE_BYTES_PER_PIXEL`]
/// \[bytes].
///
/// The film of the removed light takes 50 bytes, its sums in the error estimate 68, and the current
/// pass 12; 10 bytes are a reserve.
const CLAMPING_BYTES_PER_PIXEL: u64 = 140;

/// Memory per pixel for pictures that wait to be sent to the viewer tev, in addition to
/// [`BASE_BYTES_PER_PIXEL`] \[bytes].
///
/// Two pictures and a packet take 40 bytes. Pictures with light groups take 80 more.
const TEV_BYTES_PER_PIXEL: u64 = 120;

/// Memory per pixel that surface AOVs need after the last pass, in addition to
/// [`BASE_BYTES_PER_PIXEL`] \[bytes].
///
/// 303 bytes were measured without the AOV of motion: for the AOVs, for all layers of the picture,
/// and for the copy of the layers in the file. Motion takes 24 bytes; 37 bytes are a reserve.
const AOV_BYTES_PER_PIXEL: u64 = 364;

/// Memory of each stored photon while the photon map is built \[bytes].
///
/// A photon takes 32 bytes and its sorted copy 32. Its splat, the light that light tracing adds to
/// the film, takes 20. The sort key takes 16, and the tree that replaces the key 33. The rest is
/// unused capacity of growing lists.
const BYTES_PER_PHOTON: u64 = 120;

/// Reason why a render does not fit into memory.
#[derive(Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum MemoryError {
    /// A picture has more pixels than [`MAX_PIXELS`].
    #[error(transparent)]
    #[diagnostic(help("choose a smaller --size"))]
    Pixels(#[from] PictureSizeError),
    /// The pictures of a render need more memory than is free.
    #[error(
        "{} of {width} × {height} pixels {} of memory, and {} are free",
        if *count == 1 { "a picture".to_owned() } else { format!("{count} pictures") },
        format_args!("take{} {}", if *count == 1 { "s" } else { "" }, format_bytes(*needed)),
        format_bytes(*free)
    )]
    #[diagnostic(help(
        "choose a smaller --size, or allow more --memory; --no-error-estimate reduces the memory to a fifth"
    ))]
    Picture {
        /// Number of pictures that are in memory at a time.
        count: usize,
        /// Width of each picture \[pixels].
        width: u32,
        /// Height of each picture \[pixels].
        height: u32,
        /// Memory that all the pictures need \[bytes].
        needed: u64,
        /// Free memory \[bytes].
        free: u64,
    },
    /// Film files, when read, need more memory than is free.
    #[error(
        "{} of {width} × {height} pixels take{} {} of memory, and {} are free",
        if *count == 1 { "a film".to_owned() } else { format!("{count} films at a time") },
        if *count == 1 { "s" } else { "" },
        format_bytes(*needed),
        format_bytes(*free)
    )]
    #[diagnostic(help("allow more --memory"))]
    Films {
        /// Number of films in memory at a time.
        count: usize,
        /// Width of the picture \[pixels].
        width: u32,
        /// Height of the picture \[pixels].
        height: u32,
        /// Memory that all the films need \[bytes].
        needed: u64,
        /// Free memory \[bytes].
        free: u64,
    },
    /// One photon map would store more photons than 32-bit indices can address.
    #[error("a pass of {paths} photon paths would store about {stored} photons, and {} can be indexed", u32::MAX)]
    #[diagnostic(help("{PHOTON_MEMORY_REMEDY}"))]
    Indices {
        /// Number of photon paths of the pass.
        paths: u64,
        /// Number of photons that the pass is expected to store.
        stored: u64,
    },
    /// The photons of one pass need more memory than is free.
    #[error(
        "a pass of {paths} photon paths would store about {stored} photons, which take {} of memory, and {} are free",
        format_bytes(*needed),
        format_bytes(*free)
    )]
    #[diagnostic(help("{PHOTON_MEMORY_REMEDY}"))]
    Photons {
        /// Number of photon paths of the pass.
        paths: u64,
        /// Number of photons that the pass is expected to store.
        stored: u64,
        /// Memory that the expected photons need \[bytes].
        needed: u64,
        /// Free memory \[bytes].
        free: u64,
    },
}

const PHOTON_MEMORY_REMEDY: &str = "choose fewer --photons or --caustic-photons and more --passes: only one pass of photons is in memory at a time; \
     or allow more --memory";

/// Returns the memory \[bytes] that `count` pictures need while they are rendered without error
/// estimates.
///
/// `size` is the width and height of a picture \[pixels]. `free` is the free memory \[bytes];
/// `None` if unknown.
///
/// # Errors
/// [`MemoryError`] if the pictures need more than `free` bytes, or one has too many pixels.
pub fn check_picture_memory(count: usize, size: (u32, u32), free: Option<u64>) -> Result<u64, MemoryError> {
    check_pixel_memory(count, size, BASE_BYTES_PER_PIXEL, free)
}

/// Returns the memory \[bytes] that `count` pictures need while they are rendered with error
/// estimates.
///
/// `size` is the width and height of a picture \[pixels]. `free` is the free memory \[bytes];
/// `None` if unknown.
///
/// # Errors
/// [`MemoryError`] if the pictures need more than `free` bytes, or one has too many pixels.
pub fn check_picture_and_error_memory(count: usize, size: (u32, u32), free: Option<u64>) -> Result<u64, MemoryError> {
    check_pixel_memory(count, size, BASE_BYTES_PER_PIXEL + ERROR_BYTES_PER_PIXEL, free)
}

/// Layers that a render stores in addition to its picture, for the estimate of its memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerSelection {
    /// True if the render estimates the error of its picture.
    pub estimates_error: bool,
    /// True if the render stores a picture for each light group.
    pub groups_light: bool,
    /// True if the render clamps light, and stores the light that clamping removes.
    pub clamps_light: bool,
    /// True if the render sends pictures to the viewer tev.
    pub sends_to_tev: bool,
    /// True if surface AOVs are rendered after the last pass.
    pub renders_aovs: bool,
}

impl LayerSelection {
    /// Returns the memory per pixel of the picture and these layers together \[bytes].
    fn bytes_per_pixel(self) -> u64 {
        let bytes_if = |is_wanted: bool, bytes: u64| if is_wanted { bytes } else { 0 };
        BASE_BYTES_PER_PIXEL
            + bytes_if(self.estimates_error, ERROR_BYTES_PER_PIXEL)
            + bytes_if(self.groups_light, GROUP_BYTES_PER_PIXEL)
            + bytes_if(self.clamps_light, CLAMPING_BYTES_PER_PIXEL)
            + bytes_if(self.sends_to_tev, TEV_BYTES_PER_PIXEL)
            + bytes_if(self.renders_aovs, AOV_BYTES_PER_PIXEL)
    }
}

/// Returns the memory \[bytes] that a picture of `size` (width, height) pixels needs while it is
/// rendered with `layers`.
///
/// `free` is the free memory \[bytes]; `None` if unknown.
///
/// # Errors
/// [`MemoryError`] if the picture needs more than `free` bytes, or has too many pixels.
pub fn check_layered_picture_memory(
    size: (u32, u32),
    layers: LayerSelection,
    free: Option<u64>,
) -> Result<u64, MemoryError> {
    check_pixel_memory(1, size, layers.bytes_per_pixel(), free)
}

/// Checks that `count` films of `size` (width, height) pixels with `layers` fit into memory
/// together.
///
/// `free` is the free memory \[bytes]; `None` if unknown. Reading a film takes no more memory than
/// rendering it.
///
/// # Errors
/// [`MemoryError`] if the films need more than `free` bytes, or have too many pixels.
pub fn check_films_memory(
    count: usize,
    size: (u32, u32),
    layers: LayerSelection,
    free: Option<u64>,
) -> Result<(), MemoryError> {
    check_pixel_memory(count, size, layers.bytes_per_pixel(), free).map(drop).map_err(|error| match error {
        MemoryError::Picture { count, width, height, needed, free } => {
            MemoryError::Films { count, width, height, needed, free }
        }
        other @ (MemoryError::Pixels(_)
        | MemoryError::Films { .. }
        | MemoryError::Indices { .. }
        | MemoryError::Photons { .. }) => other,
    })
}

fn check_pixel_memory(
    count: usize,
    (width, height): (u32, u32),
    bytes_per_pixel: u64,
    free: Option<u64>,
) -> Result<u64, MemoryError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        return Err(PictureSizeError::TooLarge { width, height }.into());
    }
    let needed = pixels * bytes_per_pixel * count as u64;
    match free {
        Some(free) if needed > free => Err(MemoryError::Picture { count, width, height, needed, free }),
        _ => Ok(needed),
    }
}

/// Checks that the photons of a pass fit into memory and that 32-bit indices can address them.
///
/// `free` is the free memory \[bytes]; `None` if unknown. `picture_bytes` of the free bytes are
/// reserved for pictures.
///
/// # Errors
/// [`MemoryError`] if there are too many photons.
pub fn check_photon_memory(
    expected: ExpectedPhotons,
    picture_bytes: u64,
    free: Option<u64>,
) -> Result<(), MemoryError> {
    let free = free.map(|free| free.saturating_sub(picture_bytes));
    let ExpectedPhotons { paths, memory_in_photons: stored, largest_map_in_photons: largest_map } = expected;
    if largest_map > u64::from(u32::MAX) {
        return Err(MemoryError::Indices { paths, stored: largest_map });
    }
    let needed = stored * BYTES_PER_PHOTON;
    match free {
        Some(free) if needed > free => Err(MemoryError::Photons { paths, stored, needed, free }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
