//! Transforms of condition number 10⁸, and milder ones, for tests of shapes and instances.

use caustica::math::rotation_matrix;
use glam::{DAffine3, DMat3, DVec3};

fn turned(k: u32) -> DMat3 {
    let axis = [DVec3::new(1.0, 2.0, -0.7), DVec3::new(-0.3, 1.0, 0.8), DVec3::new(0.9, -0.2, 1.1)][k as usize];
    rotation_matrix(axis.normalize(), 0.8 + f64::from(k))
}

fn centred((name, m): (&'static str, DMat3)) -> (&'static str, DAffine3) {
    (name, DAffine3::from_mat3(m))
}

/// Returns the test transforms with their names.
pub fn maps() -> Vec<(&'static str, DAffine3)> {
    let [r, s] = [turned(0), turned(1)];
    let wide = DMat3::from_diagonal(DVec3::new(1e4, 1.0, 1e-4));
    let needle = DMat3::from_diagonal(DVec3::new(1e8, 1.0, 1.0));
    let pancake = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1e-8));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(1e4, 1.0, 0.0), DVec3::Z);
    let close = DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1e-8, 0.0), DVec3::new(0.3, 0.4, 1.0));
    let mirror = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    let place = DVec3::new(3.0, -2.0, 1.0);
    [
        ("turned", r),
        ("mirrored", r * mirror),
        ("stretched and mirrored", r * DMat3::from_diagonal(DVec3::new(-3.0, 0.5, 1.0)) * s),
        ("turned, then squeezed", wide * r),
        ("squeezed, then turned", r * wide),
        ("squeezed between turns", r * wide * s),
        ("mirrored and squeezed between turns", r * wide * mirror * s),
        ("a needle between turns", r * needle * s),
        ("turned, then a needle", needle * s),
        ("a pancake between turns", r * pancake * s),
        ("turned, then a pancake", pancake * s),
        ("sheared", shear),
        ("sheared between turns", r * shear * s),
        ("close columns", close),
    ]
    .into_iter()
    .map(|(name, m)| (name, DAffine3::from_mat3_translation(m, place)))
    // Near the origin, the rounding of coordinates to f32 is small, so it does not hide errors of a
    // transform.
    .chain([("squeezed around the origin", wide * r), ("a pancake around the origin", pancake * s)].map(centred))
    .collect()
}
