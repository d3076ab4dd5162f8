//! Whether a render fits into memory, asked before it begins.

use crate::image::{MAX_PIXELS, SizeError};
use crate::integrate::Expected;
use crate::stats::bytes;

/// Bytes a pixel: the film (48), a pass (12) and the places of its rows (1), how rays are shared out by `--adaptive` (20); at the end, in
/// place of the pass, its mean and what is encoded of it. Measured: 85.
const PER_PIXEL: u64 = 86;

/// Bytes a pixel of the gauge: what a pass tells (48), noise (24), finer discs (48), discs (24), three pictures each of passes and of
/// finer discs (72), and what errors are relative to, while it is made (24); the rest is what reading it and maps of errors take.
/// Measured with the rest: 341, and 358 where maps are written.
const PER_GAUGED_PIXEL: u64 = 274;

/// Bytes a stored photon while its tree is built: itself (32), its sorted copy (32) and the copy's key (16), then the tree (33)
/// instead of the key; the rest is the slack of growing lists.
const PER_PHOTON: u64 = 100;

/// Why a render is refused.
#[derive(Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub(super) enum TooMuch {
    /// More pixels than a picture may have.
    #[error(transparent)]
    #[diagnostic(help("choose a smaller --size"))]
    Pixels(#[from] SizeError),
    /// More pixels than memory holds.
    #[error(
        "{} of {width} × {height} pixels {} of memory, and {} are free",
        if *count == 1 { "a picture".to_owned() } else { format!("{count} pictures") },
        format_args!("take{} {}", if *count == 1 { "s" } else { "" }, bytes(*needed)),
        bytes(*free)
    )]
    #[diagnostic(help(
        "choose a smaller --size, or let it have more memory (--memory); a render without the gauge (--no-gauge) takes a quarter"
    ))]
    Picture { count: usize, width: u32, height: u32, needed: u64, free: u64 },
    /// More photons than indices.
    #[error("a pass of {paths} photon paths would store about {stored} photons, and {} can be indexed", u32::MAX)]
    #[diagnostic(help("{REMEDY}"))]
    Indices { paths: u64, stored: u64 },
    /// More photons than memory holds.
    #[error(
        "a pass of {paths} photon paths would store about {stored} photons, which take {} of memory, and {} are free",
        bytes(*needed),
        bytes(*free)
    )]
    #[diagnostic(help("{REMEDY}"))]
    Photons { paths: u64, stored: u64, needed: u64, free: u64 },
}

const REMEDY: &str = "take fewer --photons or --caustic-photons and more --passes: photons of a pass are kept in memory, passes add up; or let it have \
     more memory (--memory)";

/// Checks that so many pictures of a size fit into `free` bytes, where that number is known, and tells the bytes that they take.
pub(super) fn check_pictures(count: usize, size: (u32, u32), free: Option<u64>) -> Result<u64, TooMuch> {
    check(count, size, PER_PIXEL, free)
}

/// As [`check_pictures`], for one with the gauge of its error.
pub(super) fn check_gauged(size: (u32, u32), free: Option<u64>) -> Result<u64, TooMuch> {
    check(1, size, PER_PIXEL + PER_GAUGED_PIXEL, free)
}

fn check(count: usize, (width, height): (u32, u32), bytes_a_pixel: u64, free: Option<u64>) -> Result<u64, TooMuch> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        return Err(SizeError::TooLarge { width, height }.into());
    }
    let needed = pixels * bytes_a_pixel * count as u64;
    match free {
        Some(free) if needed > free => Err(TooMuch::Picture { count, width, height, needed, free }),
        _ => Ok(needed),
    }
}

/// Checks that the photons of a pass can be indexed and fit into `free` bytes, where that number is known, beside `pictures` bytes that
/// are yet to be taken.
pub(super) fn check_photons(expected: Expected, pictures: u64, free: Option<u64>) -> Result<(), TooMuch> {
    let free = free.map(|free| free.saturating_sub(pictures));
    let Expected { paths, photons: stored, most } = expected;
    if most > u64::from(u32::MAX) {
        return Err(TooMuch::Indices { paths, stored: most });
    }
    let needed = stored * PER_PHOTON;
    match free {
        Some(free) if needed > free => Err(TooMuch::Photons { paths, stored, needed, free }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_held_against_the_format_and_the_memory() {
        assert_eq!(check_pictures(1, (16_384, 16_384), None), Ok(86 << 28));
        assert!(matches!(check_pictures(1, (16_385, 16_384), None), Err(TooMuch::Pixels(_))));
        assert_eq!(check_pictures(1, (1000, 1000), Some(86_000_000)), Ok(86_000_000));
        let refused = check_pictures(1, (1000, 1000), Some(85_999_999)).unwrap_err().to_string();
        assert!(refused.contains("a picture of 1000 × 1000") && refused.contains("86.0 MB"), "{refused}");
        assert!(matches!(check_gauged((1000, 1000), Some(359_999_999)), Err(TooMuch::Picture { .. })));
        assert_eq!(check_pictures(4, (500, 500), Some(86_000_000)), Ok(86_000_000));
        let refused = check_pictures(5, (500, 500), Some(86_000_000)).unwrap_err().to_string();
        assert!(refused.contains("5 pictures of 500 × 500 pixels take 107.5 MB"), "{refused}");
    }

    #[test]
    fn photons_are_held_against_the_indices_and_the_memory() {
        let index = u64::from(u32::MAX);
        let expected = |photons, most| Expected { paths: 1, photons, most };
        assert_eq!(check_photons(expected(2 * index, index), 0, None), Ok(()));
        assert!(matches!(check_photons(expected(2 * index, index + 1), 0, None), Err(TooMuch::Indices { .. })));
        assert_eq!(check_photons(expected(1000, 600), 0, Some(100_000)), Ok(()));
        assert_eq!(check_photons(expected(1000, 600), 7, Some(100_007)), Ok(()));
        assert!(check_photons(expected(1000, 600), 8, Some(100_007)).is_err());
        assert!(matches!(
            check_photons(expected(1001, 600), 0, Some(100_000)),
            Err(TooMuch::Photons { stored: 1001, .. })
        ));
    }
}
