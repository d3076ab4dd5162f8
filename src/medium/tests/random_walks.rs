//! Tests of random walks in unbounded media.

use super::*;
use glam::{DAffine3, Vec2};
use rand::RngExt;

/// Simulates a random walk from the origin, in which Russian roulette decides on absorption.
/// Returns the number of collisions and the end position.
fn random_walk(medium: &Medium, random: &mut SmallRng) -> (f64, DVec3) {
    let (mut p, mut direction, mut collisions) = (Vec3::ZERO, Vec3::X, 0.0);
    loop {
        let distance_sample = medium.distance_sample(&Ray::new(p, direction), f32::INFINITY, Vec3::ONE, random);
        let t = distance_sample.scattering_distance.expect("the medium has no end");
        p += direction * t;
        collisions += 1.0;
        if random.random::<f32>() >= distance_sample.weight.x {
            return (collisions, p.as_dvec3());
        }
        direction = medium.phase.sample(direction, Vec2::new(random.random(), random.random())).0;
    }
}

/// Compares simulated random walks with closed forms for albedo a and mean cosine g.
///
/// The mean number of collisions is 1/(1−a). The mean squared distance from the origin at
/// absorption is 2/(σt²(1−a)(1−ag)).
fn assert_random_walk_moments(medium: &Medium, sigma: f64, albedo: f64) {
    let mut random = test_rng(5);
    let (mut collisions, mut square) = (RunningMean::default(), RunningMean::default());
    for _ in 0..100_000 {
        let (n, p) = random_walk(medium, &mut random);
        collisions.add_sample(DVec3::splat(n));
        square.add_sample(DVec3::splat(p.length_squared()));
    }
    let g = f64::from(medium.phase.mean_cosine());
    collisions.assert_near(DVec3::splat(1.0 / (1.0 - albedo)), "collisions");
    square.assert_near(DVec3::splat(2.0 / (sigma * sigma * (1.0 - albedo) * (1.0 - albedo * g))), "r²");
}

#[test]
fn homogeneous_random_walks_match_diffusion() {
    let phases = [PhaseFunction::Isotropic, PhaseFunction::Rayleigh].into_iter();
    for phase in phases.chain([-0.5, 0.7, 0.99, -0.99].map(PhaseFunction::HenyeyGreenstein)) {
        let medium = Medium::homogeneous(Vec3::splat(0.5), Vec3::splat(2.0), Vec3::ZERO, phase);
        assert_random_walk_moments(&medium, 2.5, 0.8);
    }
}

/// Simulates walks in a grid so large that a walk leaves it with a probability of only e⁻⁵⁰⁰.
#[test]
fn grid_random_walks_match_diffusion() {
    let place = DAffine3::from_scale(DVec3::splat(400.0)) * DAffine3::from_translation(DVec3::splat(-0.5));
    let field = Arc::new(GridDensity::new([33, 20, 9], vec![2.5; 33 * 20 * 9], place).unwrap());
    let medium = Medium::heterogeneous(
        Vec3::splat(0.2),
        Vec3::splat(0.8),
        Vec3::ZERO,
        PhaseFunction::HenyeyGreenstein(0.7),
        field,
    );
    assert_random_walk_moments(&medium, 2.5, 0.8);
}
