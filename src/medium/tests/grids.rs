//! Tests of density grids: validation, interpolation, majorants.

use super::*;
use crate::math::SingularTransformError;
use glam::{DAffine3, DQuat};
use rand::RngExt;

const HERE: DAffine3 = DAffine3::IDENTITY;

#[test]
fn invalid_grids_are_errors() {
    let refused = |size, values, place| GridDensity::new(size, values, place).unwrap_err();
    assert_eq!(refused([2, 0, 1], vec![], HERE), GridDensityError::Empty(2, 0, 1));
    assert_eq!(
        refused([2, 2, 2], vec![1.0; 7], HERE),
        GridDensityError::DensityCountMismatch { expected: 8, found: 7 }
    );
    let most = [u32::MAX; 3];
    assert_eq!(refused(most, vec![], HERE), GridDensityError::TooLarge(u32::MAX, u32::MAX, u32::MAX));
    let large = [1 << 20, 1 << 20, 1 << 20];
    assert!(matches!(GridDensity::from_fn(large, HERE, |_| 1.0), Err(GridDensityError::TooLarge(..))));
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(refused([1; 3], vec![1.0], flat), GridDensityError::SingularPlacement(SingularTransformError));
    for bad in [-1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        let mut values = vec![1.0; 24];
        // The value is that of cell (1, 2, 3) in a grid of 2 × 3 × 4 cells.
        values[1 + 2 * (2 + 3 * 3)] = bad;
        let error = refused([2, 3, 4], values, HERE);
        assert!(matches!(error, GridDensityError::InvalidDensity { x: 1, y: 2, z: 3, .. }), "{error}");
    }
}

#[test]
fn grid_values_are_at_cell_centers() {
    let size = [3, 4, 5];
    let field = GridDensity::from_fn(size, HERE, |p| (p.x * 3.0 + p.y * 400.0 + p.z * 50_000.0) as f32).unwrap();
    let middle = |x: f32, y: f32, z: f32| Vec3::new((x + 0.5) / 3.0, (y + 0.5) / 4.0, (z + 0.5) / 5.0);
    let value = |x: f32, y: f32, z: f32| x + 0.5 + 100.0 * (y + 0.5) + 10_000.0 * (z + 0.5);
    // Points are rounded to f32, which changes the steepest density by up to 0.003.
    for (x, y, z) in [(0.0, 0.0, 0.0), (2.0, 3.0, 4.0), (1.0, 2.0, 0.0), (0.5, 1.25, 3.75)] {
        let found = field.density(middle(x, y, z));
        assert!((found - value(x, y, z)).abs() < 0.02, "{x} {y} {z}: {found}");
    }
    assert!((field.density(Vec3::ZERO) - value(0.0, 0.0, 0.0)).abs() < 0.02, "the edge is as its cell");
    assert_eq!(field.density(Vec3::new(0.5, 0.5, 1.001)), 0.0);
    assert_eq!(field.density(Vec3::splat(f32::NAN)), 0.0);
    assert!(field.max_density() >= value(2.0, 3.0, 4.0) - 0.02 && field.cell_counts() == size);
    assert!(
        (240..1000).contains(&field.memory_bytes()),
        "60 densities of 4 bytes, and a little: {}",
        field.memory_bytes()
    );
}

/// Checks that the blocks along a ray cover its part inside the grid without gaps or overlaps, and
/// that their majorants bound the density up to rounding.
#[test]
fn majorants_bound_the_density_along_rays() {
    let mut random = test_rng(11);
    let size = [19, 7, 33];
    let values = (0..19 * 7 * 33).map(|_| 0.1 + random.random::<f32>() * random.random::<f32>()).collect();
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(3.0, 2.0, 1.0),
        DQuat::from_rotation_y(0.4),
        DVec3::new(5.0, -1.0, 2.0),
    );
    let field = GridDensity::new(size, values, place).unwrap();
    let mut crossed = 0;
    for i in 0..20_000 {
        let mut unit = || DVec3::new(random.random(), random.random(), random.random());
        // Every third ray runs along an axis of the grid. Every second ray starts in the box.
        let (mut a, b) = (unit() * 3.0 - 1.0, unit());
        if i % 3 == 0 {
            let axis = i % 9 / 3;
            let along = a[axis];
            a = b;
            a[axis] = along;
        }
        let (a, b) = if i % 2 == 0 { (a, b) } else { (b, a) };
        let [a, b] = [a, b].map(|p| place.transform_point3(p).as_vec3());
        let Some(direction) = (b - a).try_normalize() else { continue };
        let ray = Ray::new(a, direction);
        let blocks: Vec<_> = field.ray_in_grid(&ray, f32::INFINITY).majorant_segments().collect();
        crossed += blocks.len();
        let (start, end) = ray_interval_in_grid_box(&field, &ray);
        assert!((blocks[0].0 - start).abs() < 1e-9 && (blocks.last().unwrap().1 - end).abs() < 1e-9, "{i}");
        assert!(blocks.windows(2).all(|pair| pair[0].1 == pair[1].0), "{i}");
        let line = field.ray_in_grid(&ray, f32::INFINITY);
        for (t0, t1, majorant) in blocks {
            assert!(t1 > t0);
            for part in [0.0, 0.3, 0.7, 1.0] {
                let density = line.density(t0 + part * (t1 - t0));
                assert!(density <= majorant * (1.0 + 1e-6), "{i}: {density} above {majorant}");
            }
        }
        let short = 0.3f32;
        let last = field.ray_in_grid(&ray, short).majorant_segments().last().map_or(0.0, |b| b.1);
        assert!(last <= f64::from(short));
    }
    assert!(crossed > 60_000, "{crossed}");
}

/// Returns the interval of distances t ≥ 0 at which `ray` is inside the box of `field`.
fn ray_interval_in_grid_box(field: &GridDensity, ray: &Ray) -> (f64, f64) {
    let inverse = field.unit_cube_to_scene().inverse();
    let (o, d) = (inverse.transform_point3(ray.origin.as_dvec3()), inverse.transform_vector3(ray.direction.as_dvec3()));
    let (a, b) = (-o / d, (1.0 - o) / d);
    (a.min(b).max_element().max(0.0), a.max(b).min_element())
}

#[test]
fn density_grids_translate_there_and_back() {
    let field = GridDensity::from_fn([4; 3], HERE, |p| p.x as f32).unwrap();
    let by = DVec3::new(1e6, -2e6, 3e6);
    let back = field.translated(by).translated(-by);
    let p = Vec3::new(0.3, 0.9, 0.2);
    assert_eq!(back.density(p), field.density(p));
    assert_eq!(field.translated(DVec3::X).density(p + Vec3::X), field.density(p + Vec3::X - Vec3::X));
}
