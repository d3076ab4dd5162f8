//! Parsers of numbers on the command line.

use crate::image::MAX_EXPOSURE_STOPS;
use crate::image::flip::PIXELS_PER_DEGREE_RANGE;
use crate::render::error_estimate::Confidence;
use glam::DVec3;
use std::time::Duration;

/// Parses a count with an optional suffix k (thousand) or M (million), such as `2.5M`.
pub(super) fn parse_count(text: &str) -> Result<u32, String> {
    let (digits, scale) = match text.char_indices().last() {
        Some((i, 'k' | 'K')) => (&text[..i], 1e3),
        Some((i, 'm' | 'M')) => (&text[..i], 1e6),
        _ => (text, 1.0),
    };
    let plain = !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit() || c == '.');
    let value = digits.parse::<f64>().ok().filter(|_| plain).map(|x| x * scale);
    // The product of a decimal fraction and its scale may differ from a whole number by rounding.
    let is_whole = |x: f64| (x - x.round()).abs() <= 1e-12 * x;
    match value {
        Some(x) if is_whole(x) && x <= f64::from(u32::MAX) => Ok(x.round() as u32),
        Some(x) if x > f64::from(u32::MAX) => Err(format!("`{text}` is too large: the largest count is {}", u32::MAX)),
        _ => Err(format!("`{text}` is not a count: write a whole number such as 250000, 250k or 2.5M")),
    }
}

/// Parses a number of bytes with an optional decimal suffix k, M, G or T, such as `1.5G`.
pub(super) fn parse_bytes(text: &str) -> Result<u64, String> {
    let (digits, scale) = match text.char_indices().last() {
        Some((i, 'k' | 'K')) => (&text[..i], 1e3),
        Some((i, 'M')) => (&text[..i], 1e6),
        Some((i, 'G')) => (&text[..i], 1e9),
        Some((i, 'T')) => (&text[..i], 1e12),
        _ => (text, 1.0),
    };
    let plain = !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit() || c == '.');
    // No machine has 10¹⁵ bytes, and f64 holds all whole numbers below it.
    let value = digits.parse::<f64>().ok().map(|x| x * scale).filter(|x| plain && (1.0..=1e15).contains(x));
    value.map(|x| x as u64).ok_or_else(|| format!("`{text}` is not an amount of memory: write it as 4G or 512M"))
}

/// Parses a count of at least one, such as a number of passes.
pub(super) fn parse_positive_count(text: &str) -> Result<u32, String> {
    match parse_count(text)? {
        0 => Err("it must be at least 1".to_owned()),
        n => Ok(n),
    }
}

/// Parses the largest number of photons in a density estimate. Refuses 1.
///
/// The farthest of these photons only sets the radius of the gather disc, and the estimate leaves
/// out its flux. So an estimate with one photon would be 0.
pub(super) fn parse_gather_count(text: &str) -> Result<u32, String> {
    match parse_count(text)? {
        1 => Err(
            "the last photon only bounds the disc, so 1 gives no light: write at least 2, or 0 for all photons within \
                  the radius"
                .to_owned(),
        ),
        n => Ok(n),
    }
}

/// Largest accepted number of threads.
const MAX_THREADS: u32 = 1024;

/// Parses the seed of all random numbers.
pub(super) fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("`{text}` is not a seed: write a whole number from 0 to {}", u64::MAX))
}

/// Largest accepted number of seeds of a study.
const MAX_SEEDS: u32 = 1000;

/// Parses the number of seeds of a study, from 2 to [`MAX_SEEDS`].
pub(super) fn parse_seed_count(text: &str) -> Result<u32, String> {
    match parse_count(text)? {
        0 | 1 => Err("it must be at least 2: one picture cannot separate noise from bias".to_owned()),
        n @ ..=MAX_SEEDS => Ok(n),
        _ => Err(format!("it must be at most {MAX_SEEDS}")),
    }
}

/// Parses a number of threads, from 1 to [`MAX_THREADS`].
pub(super) fn parse_threads(text: &str) -> Result<u32, String> {
    match parse_positive_count(text)? {
        n @ ..=MAX_THREADS => Ok(n),
        _ => Err(format!("it must be at most {MAX_THREADS}")),
    }
}

/// Returns a count with its noun in the singular or plural, such as `2 passes`.
pub(super) fn count_with_noun(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Parses an exposure in stops, such as `+1` or `-0.5`.
pub(super) fn parse_exposure_stops(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|x| x.abs() <= MAX_EXPOSURE_STOPS);
    value.ok_or_else(|| {
        format!("`{text}` is not an exposure: write a number from -{MAX_EXPOSURE_STOPS} to {MAX_EXPOSURE_STOPS}")
    })
}

/// Parses a time in seconds, minutes or hours, such as `90`, `90s`, `1.5m` or `2h`.
pub(super) fn parse_duration(text: &str) -> Result<Duration, String> {
    let (digits, scale) = match text.char_indices().last() {
        Some((i, 's')) => (&text[..i], 1.0),
        Some((i, 'm')) => (&text[..i], 60.0),
        Some((i, 'h')) => (&text[..i], 3600.0),
        _ => (text, 1.0),
    };
    let seconds = digits.parse::<f64>().ok().map(|x| x * scale).filter(|x| (0.0..=1e9).contains(x));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| format!("`{text}` is not a time: write 60s, 1.5m or 2h"))
}

/// Parses a width and height in pixels, such as `1280x720`.
pub(super) fn parse_picture_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((w @ 1..=65_536, h @ 1..=65_536)) => Ok((w, h)),
        Some(_) => Err("each side must be from 1 to 65536 pixels".to_owned()),
        None => Err(format!("`{text}` is not a size: write it as 1280x720")),
    }
}

/// Parses a radiance above zero, in W/(m² sr).
pub(super) fn parse_radiance_limit(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|x| *x > 0.0 && x.is_finite());
    value.ok_or_else(|| format!("`{text}` is not a radiance: write a number above 0"))
}

/// Parses a length above zero, in scene units.
pub(super) fn parse_positive_length(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|x| *x > 0.0 && x.is_finite());
    value.ok_or_else(|| format!("`{text}` is not a length: write a number above 0, in scene units"))
}

/// Parses a length of at least zero, such as the distance of `--weld`.
pub(super) fn parse_nonnegative_length(text: &str) -> Result<f64, String> {
    parse_number_where(text, |x| x >= 0.0)
        .ok_or_else(|| format!("`{text}` is not a length: write a number of at least 0"))
}

/// Parses a scale factor above zero.
pub(super) fn parse_positive_factor(text: &str) -> Result<f64, String> {
    parse_number_where(text, |x| x > 0.0).ok_or_else(|| format!("`{text}` is not a factor: write a number above 0"))
}

/// Parses the parameter α of progressive photon mapping, in (0, 1]. Gather radii shrink faster for
/// smaller α. For α = 1, they stay constant.
pub(super) fn parse_alpha(text: &str) -> Result<f64, String> {
    parse_number_where(text, |x| x > 0.0 && x <= 1.0)
        .ok_or_else(|| format!("`{text}` is not an exponent of the radii: write a number above 0 and at most 1"))
}

/// Parses a fraction of at least zero, such as `2%` or `0.02`.
pub(super) fn parse_fraction(text: &str) -> Result<f64, String> {
    let (digits, scale) = text.strip_suffix('%').map_or((text, 1.0), |digits| (digits.trim_end(), 100.0));
    let value = parse_number_where(digits, |x| x >= 0.0).map(|x| x / scale);
    value.ok_or_else(|| format!("`{text}` is not a fraction: write it as 2% or 0.02"))
}

/// Parses a relative error above zero, such as `2%` or `0.02`.
///
/// A number of at least 1 without a percent sign is refused: `2` is more likely 2 % than 200 %.
pub(super) fn parse_relative_error(text: &str) -> Result<f64, String> {
    match parse_fraction(text) {
        Ok(x) if x >= 1.0 && !text.ends_with('%') => {
            let percent = 100.0 * x;
            Err(format!("`{text}` is {percent} %: do you mean {text} %? Write {text}%, or {percent}% if you mean that"))
        }
        Ok(x) if x > 0.0 => Ok(x),
        Ok(_) | Err(_) => Err(format!("`{text}` is not an error: write it as 2% or 0.02")),
    }
}

/// Parses a confidence from 50 % to less than 100 %.
pub(super) fn parse_confidence(text: &str) -> Result<Confidence, String> {
    let part = parse_fraction(text).ok().filter(|x| (0.5..1.0).contains(x)).and_then(Confidence::new);
    part.ok_or_else(|| format!("`{text}` is not a confidence: write a fraction from 50% to less than 100%"))
}

/// Parses an angle from 0 to 180 degrees.
pub(super) fn parse_degrees(text: &str) -> Result<f64, String> {
    parse_number_where(text, |x| (0.0..=180.0).contains(&x))
        .ok_or_else(|| format!("`{text}` is not an angle between faces: write degrees from 0 to 180"))
}

/// Parses a limit above which a flag such as `--max-rmse` reports a failure: a number of at least
/// zero.
pub(super) fn parse_upper_bound(text: &str) -> Result<f64, String> {
    parse_number_where(text, |x| x >= 0.0)
        .ok_or_else(|| format!("`{text}` is not a bound: write a number of at least 0"))
}

/// Parses the viewer's resolution for FLIP, in pixels per degree of the visual angle.
pub(super) fn parse_pixels_per_degree(text: &str) -> Result<f64, String> {
    let (least, most) = (PIXELS_PER_DEGREE_RANGE.start(), PIXELS_PER_DEGREE_RANGE.end());
    parse_number_where(text, |x| PIXELS_PER_DEGREE_RANGE.contains(&x)).ok_or_else(|| {
        format!("`{text}` is not a resolution: write a number of pixels per degree from {least} to {most}")
    })
}

/// Parses the coordinates of a point: three numbers separated by commas.
pub(super) fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| parse_number_where(part.trim(), |_| true)).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("`{text}` is not a point: write three numbers such as 0,1.5,-2")),
    }
}

/// Parses a finite number for which `rule` is true; `None` for any other text.
fn parse_number_where(text: &str, rule: impl Fn(f64) -> bool) -> Option<f64> {
    text.parse::<f64>().ok().filter(|x| x.is_finite() && rule(*x))
}

#[cfg(test)]
mod tests;
