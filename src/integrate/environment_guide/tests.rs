use super::*;
use crate::image::Image;
use crate::math::warp::square_to_uniform_sphere;
use crate::sampling::{Dimension, Key, Purpose};
use std::f64::consts::PI;

fn test_key(i: u64) -> Key {
    Key::new(8).purpose_key(Purpose::Test).child_key(i)
}

/// Returns positions for which the planes of the grid divide the unit cube into 8 × 8 × 8 equal
/// cells.
fn unit_cube() -> Vec<Vec3> {
    (0..64).map(|i| Vec3::splat(i as f32 / 64.0)).collect()
}

/// Returns a sky with a bright upper half.
fn sky() -> EnvironmentLight {
    let pixels = (0..32).map(|i| Vec3::splat(if i < 16 { 2.0 } else { 0.5 } + 0.1 * (i % 5) as f32));
    EnvironmentLight::new(Image::from_pixels(8, 4, pixels.collect()).unwrap(), 0.3, Vec3::ONE).unwrap()
}

/// Returns a guide fitted to rays that contribute only if p.x < 1/2 and u.x < 1/4. Here p is the
/// start of a ray, and u is the point of the unit square that the environment light maps to the
/// direction of the ray.
fn half_lit_guide() -> EnvironmentGuide {
    let mut fit = EnvironmentGuideFitter::new(&unit_cube());
    for i in 0..200_000 {
        let (p, u) = (test_key(i).uniform_2d(Dimension::Film), test_key(i).uniform_2d(Dimension::LightPosition));
        let square = if u.x < 0.25 && p.x < 0.5 { 4.0 } else { 0.0 };
        fit.add(Vec3::new(p.x, p.y, 0.5), u, square);
    }
    fit.fitted_guide().unwrap()
}

/// The pdf of guided directions integrates to 1. Guided samples, weighted by 1/pdf, integrate a
/// function over the sphere. The tolerance of both is five standard errors.
#[test]
fn guided_directions_follow_their_pdf() {
    let (guide, sky) = (half_lit_guide(), sky());
    let radiance = |w: Vec3| f64::from(sky.radiance(w).x * (1.0 + w.z));
    let mean_and_error = |value: &dyn Fn(Vec2) -> f64| {
        const N: u64 = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..N {
            let x = value(test_key(i).uniform_2d(Dimension::LightDirection));
            sum += x;
            squares += x * x;
        }
        let (n, mean) = (N as f64, sum / N as f64);
        (mean, ((squares / n - mean * mean) / n).sqrt())
    };
    let (integral, integral_error) = mean_and_error(&|u| 4.0 * PI * radiance(square_to_uniform_sphere(u)));
    for p in [Vec3::new(0.1, 0.2, 0.5), Vec3::new(0.9, 0.2, 0.5), Vec3::splat(-7.0)] {
        let pdf = |w: Vec3| f64::from(guide.pdf_li(&sky, p, w));
        let (total, error) = mean_and_error(&|u| 4.0 * PI * pdf(square_to_uniform_sphere(u)));
        assert!((total - 1.0).abs() < 5.0 * error && error < 0.02, "{p}: {total} ± {error}");
        let (mean, error) = mean_and_error(&|u| {
            guide.sample_li(&sky, p, u).map_or(0.0, |sample| {
                assert_eq!(sample.pdf.map(f64::from), Some(pdf(sample.wi)));
                f64::from(sample.weight.x * (1.0 + sample.wi.z))
            })
        });
        let tolerance = 5.0 * error.hypot(integral_error);
        assert!((mean - integral).abs() < tolerance && tolerance < 0.05 * integral, "{p}: {mean} and {integral}");
    }
}

/// Guided samples lie where rays contributed: if only a quarter of the unit square lights a cell,
/// 85 % of the cell's guided samples lie in that quarter. The pdf of the other points stays at
/// least 0.2.
#[test]
fn guided_samples_lie_where_rays_contributed() {
    let guide = half_lit_guide();
    let share = |p: Vec3| {
        let lit = |i| guide.sample_unit_square(p, test_key(i).uniform_2d(Dimension::LightPosition)).0.x < 0.25;
        (0..10_000).filter(|i| lit(*i)).count() as f64 / 10_000.0
    };
    // The quarter gets the guided 4/5 of the samples, and 1/4 of the uniform 1/5.
    assert!((share(Vec3::new(0.1, 0.5, 0.5)) - 0.85).abs() < 0.02);
    assert!(guide.sample_unit_square(Vec3::new(0.1, 0.5, 0.5), Vec2::splat(0.99)).1 >= 0.2 - 1e-6);
}

#[test]
fn rays_without_contribution_give_no_guide() {
    let mut fit = EnvironmentGuideFitter::new(&unit_cube());
    assert!(fit.fitted_guide().is_none());
    fit.add(Vec3::splat(0.5), Vec2::splat(0.5), 0.0);
    assert!(fit.fitted_guide().is_none());
    fit.add(Vec3::splat(0.5), Vec2::splat(0.5), 1.0);
    assert!(fit.fitted_guide().is_some());
}

/// A bin of any level holds 32 bins of the next finer level: 8 cells of 4 bins.
#[test]
fn parent_bins_have_32_children() {
    for level in (1..=REFINEMENTS).map(RefinementLevel) {
        let mut children = vec![0; RefinementLevel(level.0 - 1).bin_count()];
        (0..level.bin_count()).for_each(|bin| children[level.parent_bin(bin)] += 1);
        assert!(children.iter().all(|n| *n == 32), "{level:?}");
    }
    let ones = vec![1.0; RefinementLevel(REFINEMENTS).bin_count()];
    assert_eq!(RefinementLevel(0).bin_sums(&ones), vec![32.0 * 32.0 * 32.0; RefinementLevel(0).bin_count()]);
}

#[test]
fn cells_of_points_outside_are_the_nearest() {
    let grid = SceneCellGrid::new(&unit_cube());
    assert_eq!(grid.cell_index(Vec3::new(0.45, 0.2, 0.0)), 8 + 3);
    assert_eq!(grid.cell_index(Vec3::new(-9.0, 99.0, 0.0)), 7 * 8);
    assert!(grid.cell_index(Vec3::NAN) < 512);
    let empty = SceneCellGrid::new(&[]);
    assert_eq!(empty.cell_index(Vec3::ONE), empty.cell_index(Vec3::splat(2.0)));
}

/// A few far positions, such as those on a large ground plane, do not widen the cells around the
/// other positions.
#[test]
fn far_points_do_not_widen_other_cells() {
    let mut points = unit_cube();
    points.extend([Vec3::splat(-1000.0), Vec3::splat(1000.0)]);
    let grid = SceneCellGrid::new(&points);
    let cells: std::collections::BTreeSet<usize> =
        (0..16).map(|i| grid.cell_index(Vec3::new((i as f32 + 0.5) / 16.0, 0.5, 0.5))).collect();
    assert_eq!(cells.len(), 8);
}
