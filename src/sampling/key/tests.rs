use super::*;
use crate::sampling::Sampler;

#[test]
fn random_numbers_depend_on_every_key_part() {
    let base = |seed: u64, pass: u64, path: u64, bounce: u64| {
        Key::new(seed).purpose_key(Purpose::Test).child_key(pass).child_key(path).child_key(bounce)
    };
    let reference = base(1, 2, 3, 4).random_bits(Dimension::Light);
    let others = [
        base(2, 2, 3, 4).random_bits(Dimension::Light),
        base(1, 3, 3, 4).random_bits(Dimension::Light),
        base(1, 2, 4, 4).random_bits(Dimension::Light),
        base(1, 2, 3, 5).random_bits(Dimension::Light),
        base(1, 3, 2, 4).random_bits(Dimension::Light),
        base(1, 2, 3, 4).random_bits(Dimension::Film),
        Key::new(1)
            .purpose_key(Purpose::CameraPaths)
            .child_key(2)
            .child_key(3)
            .child_key(4)
            .random_bits(Dimension::Light),
    ];
    assert!(others.iter().all(|o| *o != reference));
    assert_eq!(base(1, 2, 3, 4).random_bits(Dimension::Light), reference);
}

/// A million points with consecutive random keys pass a chi-square test over 32² cells. The
/// false-alarm rate of the test is 5·10⁻⁵ per tail.
#[test]
fn random_points_of_consecutive_keys_are_uniform() {
    const CELLS: usize = 32;
    let n = 1_000_000u64;
    let key = Key::new(7).purpose_key(Purpose::Test);
    let mut counts = vec![0u32; CELLS * CELLS];
    for path in 0..n {
        let u = key.child_key(path).uniform_2d(Dimension::LightPosition);
        assert!(u.cmpge(Vec2::ZERO).all() && u.cmplt(Vec2::ONE).all());
        counts[(u.y * CELLS as f32) as usize * CELLS + (u.x * CELLS as f32) as usize] += 1;
    }
    let expected = n as f64 / (CELLS * CELLS) as f64;
    let chi2: f64 = counts.iter().map(|c| (f64::from(*c) - expected) * (f64::from(*c) - expected) / expected).sum();
    // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance
    // 2/(9ν).
    let nu = (CELLS * CELLS - 1) as f64;
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    assert!(z.abs() < 3.9, "z = {z}");
}

/// Keys hash the numbers that the table in the module documentation lists. Other numbers would
/// change every picture.
#[test]
fn named_keys_match_the_key_map() {
    let key = Key::new(5).purpose_key(Purpose::Test);
    assert_eq!(key.pixel_key(3, 7), key.child_key(7 << 32 | 3));
    assert_eq!(key.film_point_key(1, 9), key.child_key(1 << 32 | 9));
    assert_eq!(key.medium_tracking_key(4), key.child_key(1 << 63 | 4));
    assert_eq!(key.coincident_face_key(4, 2), key.child_key(1 << 62 | 4 << 32 | 2));
    assert_eq!((key.nth_mix_choice_key(0), key.nth_mix_choice_key(3)), (key, key.child_key(1 << 61 | 3)));
    assert_eq!((key.shared_camera_paths_key(), key.unshared_camera_paths_key(0)), (key.child_key(0), key.child_key(1)));
    let sampler = Sampler::new(key, 2, 8);
    assert_eq!(sampler.next_vertex_sampler(3, true), sampler.child_sampler(7));
    assert_eq!(sampler.shadow_ray_sampler(6), sampler.child_sampler(6 << 32));
    assert_eq!(sampler.nth_shadow_ray_sampler(11), sampler.child_sampler(11));
}
