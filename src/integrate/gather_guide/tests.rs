use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// The mean of 1/pdf over samples of the guide is the solid angle of the union of all cones.
///
/// Rounding may move a sample on the rim out of its cone, hence the tolerance of 2 in 1000.
#[test]
fn samples_follow_the_pdf() {
    let one = 1.0 / f64::from(warp::uniform_cone_pdf(ONE_MINUS_COS));
    for (directions, cones) in [(vec![Vec3::Z], 1.0), (vec![Vec3::Z, Vec3::X], 2.0), (vec![Vec3::Y, Vec3::Y], 1.0)] {
        let guide = GatherGuide { directions };
        let n = 20_000;
        let covered = (0..n).map(|i| {
            let key = Key::new(2).purpose_key(Purpose::Test).child_key(i);
            let w =
                guide.sample_direction(key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
            guide.pdf(w.unwrap()).filter(|pdf| *pdf > 0.0).map_or(0.0, |pdf| 1.0 / f64::from(pdf))
        });
        let mean = covered.sum::<f64>() / n as f64;
        assert!((mean / (cones * one) - 1.0).abs() < 2e-3, "{mean} {cones}");
    }
    assert_eq!(
        (GatherGuide::default().sample_direction(0.5, Vec2::ZERO), GatherGuide::default().pdf(Vec3::Z)),
        (None, None)
    );
}

fn uniform_random_numbers(i: u64) -> (f32, Vec2) {
    let key = Key::new(3).purpose_key(Purpose::Test).child_key(i);
    (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection))
}

/// The mean of 4π·pdf over n uniform directions is 1.
///
/// The cones cover at least a fraction c of the sphere, so the mean has a standard error below
/// √(1/(nc)).
#[test]
fn gather_guide_pdf_integrates_to_one() {
    let guide = GatherGuide { directions: vec![Vec3::Z, Vec3::X, Vec3::X] };
    let n = 200_000;
    let density = |i| f64::from(guide.pdf(warp::square_to_uniform_sphere(uniform_random_numbers(i).1)).unwrap_or(0.0));
    let whole = 4.0 * std::f64::consts::PI * (0..n).map(density).sum::<f64>() / n as f64;
    let covered = f64::from(ONE_MINUS_COS) / 2.0;
    assert!((whole - 1.0).abs() < 5.0 / (n as f64 * covered).sqrt(), "{whole}");
}

/// Each of three cones gets a third of the samples within five sigma. The cosines to the axis of a
/// cone are uniformly distributed over the cone.
#[test]
fn each_cone_is_sampled_evenly() {
    let directions = vec![Vec3::X, Vec3::Y, Vec3::Z];
    let mut guide = GatherGuide { directions: directions.clone() };
    let n = 30_000;
    let samples: Vec<Vec3> = (0..n)
        .filter_map(|i| guide.sample_direction(uniform_random_numbers(i).0, uniform_random_numbers(i).1))
        .collect();
    for direction in directions {
        let near: Vec<f64> = samples.iter().map(|w| f64::from(w.dot(direction))).filter(|cos| *cos > 0.9).collect();
        let third = n as f64 / 3.0;
        assert!((near.len() as f64 - third).abs() < 5.0 * (third * 2.0 / 3.0).sqrt(), "{}", near.len());
        let off = 1.0 - near.iter().sum::<f64>() / near.len() as f64;
        let half = f64::from(ONE_MINUS_COS) / 2.0;
        assert!((off / half - 1.0).abs() < 5.0 / (3.0 * third).sqrt(), "{off}");
    }
    guide.clear();
    assert_eq!(guide.sample_direction(0.5, Vec2::ZERO), None);
}
