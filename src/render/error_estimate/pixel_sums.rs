//! Sums over the pixels of a picture, in parallel.

use rayon::prelude::*;

/// Smallest number of pixels of one task in parallel loops.
pub(super) const MIN_PIXELS_PER_TASK: usize = 2048;

/// Number of pixels that one Rayon task sums.
const CHUNK: usize = 1024;

/// Sums over the pixels from 0 to `pixels` − 1 in parallel. `add` adds one pixel to a partial sum.
/// `join` adds the partial sum of one chunk of pixels to that of the chunks before it.
///
/// Chunks of pixels have a fixed size and are joined in order. So the result does not depend on the
/// number of threads.
pub(super) fn sum_over_pixels<S: Default + Send>(
    pixels: usize,
    add: impl Fn(&mut S, usize) + Sync,
    join: impl Fn(&mut S, S),
) -> S {
    let chunk_sum = |chunk: usize| {
        let mut sum = S::default();
        (chunk * CHUNK..pixels.min((chunk + 1) * CHUNK)).for_each(|pixel| add(&mut sum, pixel));
        sum
    };
    let chunks: Vec<S> = (0..pixels.div_ceil(CHUNK)).into_par_iter().map(chunk_sum).collect();
    let mut chunks = chunks.into_iter();
    let mut total = chunks.next().unwrap_or_default();
    chunks.for_each(|chunk| join(&mut total, chunk));
    total
}

/// Sums the `N` numbers `values(i)` over the pixels i from 0 to `pixels` − 1.
pub(super) fn sums_of_values<const N: usize>(pixels: usize, values: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N]
where
    [f64; N]: Default,
{
    let add =
        |sums: &mut [f64; N], values: [f64; N]| sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    sum_over_pixels(pixels, |sums, pixel| add(sums, values(pixel)), add)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over any number of pixels count each pixel once. They are equal bit for bit on one
    /// thread and on five.
    #[test]
    fn sums_count_each_pixel_once_on_any_threads() {
        for pixels in [0, 1, CHUNK - 1, CHUNK, CHUNK + 1, 5 * CHUNK + 7] {
            let n = pixels as f64;
            assert_eq!(sums_of_values(pixels, |i| [i as f64, 1.0]), [n * (n - 1.0).max(0.0) / 2.0, n]);
            let sums = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| sums_of_values(pixels, |i| [1.0 / (1.0 + i as f64)]))
            };
            assert_eq!(sums(1), sums(5));
        }
    }
}
