use super::*;
use crate::camera::{Camera, FilterKind};
use crate::integrate::pass::SilentMonitor;
use crate::sampling::Purpose;

/// Renders one row of 12 pixels through filter `kind`. `scene` gives the radiance at film position
/// x. Returns the mean of each pixel over 400 passes, and its standard error.
fn render_filtered_row(kind: FilterKind, samples: u32, scene: impl Fn(f32) -> f32 + Sync) -> Vec<(f64, f64)> {
    let camera = Camera::orthographic(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1.0, 12, 1).unwrap();
    let filter = Filter::new(kind);
    let sampling = FilmSampling::of_camera(&camera, Some(&filter), samples, false);
    let passes = 400u32;
    let mut sums = vec![(0.0, 0.0); 12];
    for pass in 0..passes {
        let key = Key::new(8).purpose_key(Purpose::Test).pass_key(pass);
        let FilmImage { image, .. } = render_tiles(&sampling, key, &SilentMonitor, |camera_ray, _, (): &mut ()| {
            Rgb::splat(scene(camera_ray.ray.origin.x + 6.0))
        });
        for (sum, value) in sums.iter_mut().zip(image) {
            let value = f64::from(value.x);
            *sum = (sum.0 + value, sum.1 + value * value);
        }
    }
    let n = f64::from(passes);
    sums.into_iter().map(|(s, q)| (s / n, ((q / n - s * s / n / n).max(0.0) / (n - 1.0)).sqrt())).collect()
}

#[test]
fn signed_filters_are_unbiased_and_noiseless_in_flat_areas() {
    for samples in [2, 3, 16] {
        let even = render_filtered_row(FilterKind::Mitchell, samples, |_| 0.7);
        assert!(even.iter().all(|(mean, error)| (mean - 0.7).abs() < 1e-6 && *error < 1e-6), "{even:?}");
        let edge = render_filtered_row(FilterKind::Mitchell, samples, |x| if x < 6.3 { 1.0 } else { 0.0 });
        // The filter's table misplaces at most a thousandth of the weight.
        for (x, (mean, error)) in edge.iter().enumerate() {
            let weight = |y: f64| FilterKind::Mitchell.unnormalized_axis_value(y);
            let (mut left, mut all) = (0.0, 0.0);
            for i in 0..4000 {
                let y = -2.0 + (f64::from(i) + 0.5) / 1000.0;
                all += weight(y);
                left += if x as f64 + 0.5 + y < 6.3 { weight(y) } else { 0.0 };
            }
            let expected = left / all;
            assert!((mean - expected).abs() < 5.0 * error + 2e-3, "{samples}, {x}: {mean} ± {error}, {expected}");
        }
        // Check that some pixels are negative: else the test could not tell the filter from its
        // positive part.
        assert!(samples < 16 || edge.iter().any(|(mean, error)| *mean < -5.0 * error));
    }
}

#[test]
fn rendered_tiles_cover_all_columns() {
    for size in [(96u32, 72u32), (640, 480), (1920, 1080), (16, 16), (4000, 16)] {
        let (columns, rows) = (size.0.div_ceil(TILE_SIZE), size.1.div_ceil(TILE_SIZE));
        let stride = rendered_tile_stride(size, 48);
        let rendered: Vec<u32> = (0..columns * rows).filter(|tile| is_tile_rendered(*tile, columns, stride)).collect();
        assert!(rendered.len() as u32 >= 40.min(columns * rows / 2).max(1), "{size:?} {stride}: {}", rendered.len());
        let columns_rendered: std::collections::HashSet<u32> = rendered.iter().map(|tile| tile % columns).collect();
        assert!(rows < stride || columns_rendered.len() as u32 == columns, "{size:?} {stride}");
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    for (width, height) in [(1u32, 1u32), (16, 16), (17, 33), (100, 1)] {
        let columns = width.div_ceil(TILE_SIZE);
        let mut seen = vec![Rgb::ZERO; (width * height) as usize];
        for mut tile in Tile::split_image_into_tiles(&mut seen, &mut [], &mut [], &mut [], width) {
            for (x, y) in tile_pixels(tile.index, columns, width, height) {
                tile.image[(y % TILE_SIZE) as usize][(x % TILE_SIZE) as usize] += Rgb::new(1.0, x as f32, y as f32);
            }
        }
        let expected = |i| Rgb::new(1.0, (i % width) as f32, (i / width) as f32);
        assert!((0..width * height).all(|i| seen[i as usize] == expected(i)));
    }
}
