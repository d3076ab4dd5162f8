use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// Returns random point number `i` in \[0, 1)³.
fn random_point(i: u64) -> Vec3 {
    let key = Key::new(3).purpose_key(Purpose::Test).child_key(i);
    let (xy, z) = (key.uniform_2d(Dimension::LightPosition), key.uniform_2d(Dimension::Light).x);
    xy.extend(z)
}

/// Returns a guide over the box from (0, 0, 0) to (4, 2, 1), fitted to light in the part x > 3
/// only.
fn guide_of_lit_end() -> ScatterPointGuide {
    let size = Vec3::new(4.0, 2.0, 1.0);
    let mut fit = ScatterPointGuideFitter::new([Vec3::ZERO, size].into_iter(), 2).unwrap();
    for i in 0..400_000 {
        let p = random_point(i) * size;
        fit.add(&InScatteringSample {
            light: 1,
            p,
            scattered_radiance: if p.x > 3.0 { 2.0 } else { 0.0 },
            contribution: 0.0,
        });
    }
    fit.fitted_guide()
}

#[test]
fn guided_distances_cover_the_lit_part() {
    let guide = guide_of_lit_end();
    let mut distances = GuidedDistanceDistribution::default();
    let ray = Ray::new(Vec3::new(-1.0, 1.0, 0.5), Vec3::X);
    guide.distances_along(1, &ray, 0.0, &mut distances);
    // A cell is (8 / 24,000)^(1/3) = 0.07 long, and cells next to the light have a share of it.
    let lit = (0..1000).filter(|i| distances.sample(*i as f32 / 1000.0) > 4.0).count();
    assert!(lit > 900, "{lit}");
    assert!(distances.sample(0.0) > 3.85);
    // There is no guide for other lights, for rays away from the lit part, or outside the grid.
    for (light, ray) in [
        (0, ray),
        (1, Ray::new(Vec3::new(2.5, 1.0, 0.5), -Vec3::X)),
        (1, Ray::new(Vec3::new(3.5, 5.0, 0.5), Vec3::X)),
        (2, ray),
    ] {
        guide.distances_along(light, &ray, 0.0, &mut distances);
        assert_eq!(distances.total_weight(), 0.0);
    }
}

#[test]
fn guided_distances_match_their_pdf() {
    let guide = guide_of_lit_end();
    let mut distances = GuidedDistanceDistribution::default();
    let mut checked = 0;
    for i in 0..200 {
        let (from, to) = (random_point(i) * 8.0 - 2.0, random_point(1000 + i) * Vec3::new(4.0, 2.0, 1.0));
        let ray = Ray { t_max: 6.0, ..Ray::new(from, (to - from).normalize()) };
        guide.distances_along(1, &ray, 0.3, &mut distances);
        if distances.total_weight() == 0.0 {
            continue;
        }
        checked += 1;
        // The pdf integrates to 1. Its integral up to the end of a piece is the fraction of samples
        // below that end.
        let (mut integral, mut from) = (0.0, distances.start);
        let n = 4000;
        let samples: Vec<f32> = (0..n).map(|i| distances.sample((i as f32 + 0.5) / n as f32)).collect();
        for end in &distances.ends {
            integral += distances.pdf(0.5 * (from + end)) * (end - from);
            from = *end;
            let below = samples.iter().filter(|t| **t <= *end).count() as f32 / n as f32;
            assert!((below - integral).abs() < 2e-3, "{below} {integral}");
        }
        assert!((integral - 1.0).abs() < 1e-4, "{integral}");
        assert!(samples.iter().all(|t| distances.pdf(*t) > 0.0 && *t <= ray.t_max));
    }
    assert!(checked > 30, "{checked}");
}

/// The grid cells that a ray visits follow each other along the ray without gaps, and cover the
/// part of the ray in the grid. Each cell contains the middle of its own piece of the ray.
#[test]
fn rays_cross_all_cells_on_their_way() {
    let grid = MediumCellGrid::new(&Bounds::from_points([Vec3::splat(-1.0), Vec3::new(1.0, 0.5, 3.0)])).unwrap();
    assert!((12_000..=24_000).contains(&grid.len()), "{}", grid.len());
    for i in 0..2000 {
        let direction = random_point(i) - 0.5;
        // Some rays are perpendicular to the x axis.
        let direction = if i % 4 == 0 { Vec3::new(0.0, direction.y, direction.z) } else { direction };
        let ray = Ray::new((random_point(5000 + i) - 0.5) * 6.0, direction.normalize());
        let (mut last, mut length, mut pieces) = (None, 0.0, 0);
        grid.for_each_cell(&ray, |cell, from, to| {
            assert!(last.is_none_or(|last| last == from) && to > from);
            let middle = ray.at(0.5 * (from + to));
            assert!(cell == grid.cell_index(middle) || to - from < 1e-4, "{middle}");
            (last, length, pieces) = (Some(to), length + (to - from), pieces + 1);
        });
        // Measure the length within the box by small steps.
        let inside = |t: f32| {
            let p = ray.at(t);
            p.cmpge(Vec3::splat(-1.0)).all() && p.cmple(Vec3::new(1.0, 0.5, 3.0)).all()
        };
        let steps = (0..4000).filter(|j| inside(0.0025 * (*j as f32 + 0.5))).count();
        assert!((length - 0.0025 * steps as f32).abs() < 0.01, "{length} {steps}");
        assert!(pieces < 200);
    }
    // A flat box gives a grid; a single point and an empty box give none.
    assert!(MediumCellGrid::new(&Bounds::from_points([Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0)])).is_some());
    assert!(MediumCellGrid::new(&Bounds::from_points([Vec3::ZERO])).is_none());
    assert!(MediumCellGrid::new(&Bounds::from_points([])).is_none());
}
