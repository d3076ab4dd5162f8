//! `sppm` against a Mitsuba 3 reference, tile by tile, with the standard errors of both.

use crate::support::*;
use caustica::color;
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use glam::Vec3;

const EDGE: usize = 128;
const TILE: usize = 4;
const TILES: usize = EDGE / TILE;

/// Returns, for each tile, the mean over its pixels that are true in `kept`.
fn tile_means(pixels: &[f64], kept: &[bool]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); TILES * TILES];
    for (i, value) in pixels.iter().enumerate().filter(|(i, _)| kept[*i]) {
        let sum = &mut sums[i / EDGE / TILE * TILES + i % EDGE / TILE];
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    sums.iter().map(|(sum, n)| if *n > 0.0 { sum / n } else { 0.0 }).collect()
}

fn channel_means(image: &[Vec3]) -> Vec<f64> {
    image.iter().map(|v| f64::from(color::channel_mean(*v))).collect()
}

/// Renders of `sppm` match a Mitsuba 3 reference in each of 1024 tiles.
///
/// The kernel causes a bias, proportional to r² in smooth light and to r at edges, where r is the
/// radius. A second render at twice the radius, with the same photons and camera rays, measures it.
/// The bias is between a third of the difference and the whole difference; the tolerance is the
/// whole difference. Noise is measured between passes (t with 15 degrees of freedom), and the
/// reference has its own standard error. 1024 tiles at 10⁻⁷ each give a false-alarm rate of 10⁻⁴.
#[test]
#[ignore = "long: t-tests of 1024 tiles"]
fn sppm_matches_caustic_reference_by_tiles() {
    let (mean, error) = (reference_image("cbox-caustic.exr"), reference_image("cbox-caustic-stderr.exr"));
    let (reference, error) = (channel_means(mean.pixels()), channel_means(error.pixels()));
    let kept: Vec<bool> = reference.iter().zip(&error).map(|(r, e)| *e <= 0.5 * r).collect();
    let left_out = kept.iter().filter(|k| !**k).count();
    assert!(left_out < EDGE * EDGE / 100, "{left_out} fireflies in the reference");

    let scene = scene_from_file("tests/scenes/cbox-caustic.txt", (EDGE as u32, EDGE as u32));
    let render = |radius: f64| -> Vec<Vec<f64>> {
        let settings = Settings {
            camera_paths: camera_ray_settings(8, 1000).camera_paths,
            ..fixed_radius_settings(50_000, 150_000, radius)
        };
        let method = Algorithm::Sppm.prepare(&scene, settings);
        (0..PASSES).map(|i| channel_means(&method.render_pass(i, &SilentMonitor).image)).collect()
    };
    let (narrow, wide) = (render(0.012), render(0.024));
    let by_pass = |passes: &[Vec<f64>]| passes.iter().map(|p| tile_means(p, &kept)).collect::<Vec<_>>();
    let (narrow_tiles, wide_tiles) = (by_pass(&narrow), by_pass(&wide));
    let expected = tile_means(&reference, &kept);
    // The errors of color channels may be correlated. So the error of the channel mean is at most
    // the mean of the channel errors.
    let variance = tile_means(&error.iter().map(|e| e * e).collect::<Vec<_>>(), &kept);
    let (mut beyond_two, mut worst) = (0, 1.0f64);
    for tile in 0..TILES * TILES {
        let column = |passes: &[Vec<f64>]| passes.iter().map(|p| p[tile]).collect::<Vec<f64>>();
        let (ours, sigma) = mean_and_error(&column(&narrow_tiles));
        let (blurred, _) = mean_and_error(&column(&wide_tiles));
        let sigma = (sigma * sigma + variance[tile] / (TILE * TILE) as f64).sqrt();
        let excess = ((ours - expected[tile]).abs() - (blurred - ours).abs()).max(0.0);
        let p = student_t_tail(excess / sigma, f64::from(PASSES - 1));
        beyond_two += u32::from((ours - expected[tile]).abs() > 2.0 * sigma);
        worst = worst.min(p);
        assert!(
            p >= 1e-7,
            "tile {}, {}: {ours} ± {sigma}, bias within {}, reference {}",
            tile % TILES,
            tile / TILES,
            blurred - ours,
            expected[tile]
        );
    }
    eprintln!("{left_out} fireflies left out; {beyond_two} of 1024 tiles beyond 2σ; smallest p {worst:.1e}");

    // The comparison is repeated for a window around the caustic and for the whole image.
    let window = |image: &[f64]| {
        let rows = (105..=108).flat_map(|y| (89..=94).map(move |x| y * EDGE + x));
        rows.map(|i| image[i]).sum::<f64>() / (4.0 * 6.0)
    };
    let whole = |image: &[f64]| image.iter().sum::<f64>() / (EDGE * EDGE) as f64;
    let compare = |what: &str, part: &dyn Fn(&[f64]) -> f64, max_relative_error: f64| {
        let of = |passes: &[Vec<f64>]| passes.iter().map(|p| part(p)).collect::<Vec<f64>>();
        let (ours, blurred) = (of(&narrow), mean_and_error(&of(&wide)).0);
        let bias = (blurred - mean_and_error(&ours).0).abs();
        let truth = part(&reference);
        eprintln!("{what}: bias within {bias:.1e}, ratio {}", mean_and_error(&ours).0 / truth);
        assert_mean(what, &ours, truth, bias, max_relative_error);
    };
    compare("caustic window", &window, 0.01);
    compare("whole picture", &whole, 2e-3);
}
