use super::*;
use glam::DVec3;

/// Returns the number of rays in each slice, summed over 64 × 64 pixels, and true if each pixel has
/// rays in as many slices as possible.
fn slice_ray_counts_and_spread_flag(slices: usize, rays: u32, pass: u32) -> (Vec<u32>, bool) {
    let camera = Camera::orthographic(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1.0, 64, 64).unwrap();
    let key = Key::new(5).purpose_key(Purpose::Shutter);
    let cameras = SlicedCameras { cameras: vec![&camera; slices], key, pass };
    let (mut counts, mut spread_widely) = (vec![0; slices], true);
    for pixel in 0..64 * 64 {
        let division = cameras.divide_rays(pixel % 64, pixel / 64, rays);
        let mut own = vec![0; slices];
        (0..rays).for_each(|ray| own[division.slice(ray)] += 1);
        spread_widely &= own.iter().filter(|n| **n > 0).count() == division.used_slice_count() as usize;
        counts.iter_mut().zip(own).for_each(|(sum, n)| *sum += n);
    }
    (counts, spread_widely)
}

/// Each pixel has rays in as many slices as possible. The number of a pixel's rays in a slice has a
/// variance of at most ¼.
#[test]
fn pixel_rays_spread_over_shutter_slices() {
    for (slices, rays, pass) in [(8, 8, 0), (4, 8, 3), (32, 8, 1), (8, 2, 9), (7, 15, 2), (64, 1, 4)] {
        let (counts, spread_widely) = slice_ray_counts_and_spread_flag(slices, rays, pass);
        assert!(spread_widely, "{slices} slices, {rays} rays");
        let expected = 4096.0 * f64::from(rays) / slices as f64;
        let tolerance = if (rays as usize).is_multiple_of(slices) { 0.0 } else { 5.0 * (0.25 * 4096.0f64).sqrt() };
        assert!(counts.iter().all(|n| (f64::from(*n) - expected).abs() <= tolerance), "{counts:?}");
    }
}

#[test]
fn slice_times_of_passes_interleave() {
    let times = |count: u32, passes: u32| {
        let slice = |i: u32| ShutterSlice { index: i % count, count }.time(3, i / count);
        let mut times: Vec<f64> = (0..count * passes).map(slice).collect();
        times.sort_by(f64::total_cmp);
        times
    };
    for (count, passes) in [(1, 8), (5, 4), (8, 16)] {
        let step = 1.0 / f64::from(count * passes);
        for pair in times(count, passes).windows(2) {
            assert!((pair[1] - pair[0] - step).abs() < 1e-12, "{count} {passes}: {pair:?}");
        }
    }
}
