use super::*;
use crate::sampling::Sampler;

#[test]
fn numbers_depend_on_every_part_of_the_key() {
    let base = |seed: u64, pass: u64, path: u64, bounce: u64| {
        Key::new(seed).purpose(Purpose::Test).with(pass).with(path).with(bounce)
    };
    let reference = base(1, 2, 3, 4).bits(Dimension::Light);
    let others = [
        base(2, 2, 3, 4).bits(Dimension::Light),
        base(1, 3, 3, 4).bits(Dimension::Light),
        base(1, 2, 4, 4).bits(Dimension::Light),
        base(1, 2, 3, 5).bits(Dimension::Light),
        base(1, 3, 2, 4).bits(Dimension::Light),
        base(1, 2, 3, 4).bits(Dimension::Film),
        Key::new(1).purpose(Purpose::Camera).with(2).with(3).with(4).bits(Dimension::Light),
    ];
    assert!(others.iter().all(|o| *o != reference));
    assert_eq!(base(1, 2, 3, 4).bits(Dimension::Light), reference);
}

/// Chi-square test of a million points with consecutive keys over 32² cells; false-alarm rate
/// 10⁻⁴ per tail.
#[test]
fn consecutive_keys_are_uniform() {
    const CELLS: usize = 32;
    let n = 1_000_000u64;
    let key = Key::new(7).purpose(Purpose::Test);
    let mut counts = vec![0u32; CELLS * CELLS];
    for path in 0..n {
        let u = key.with(path).uniform_2d(Dimension::LightPosition);
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

/// Pins the words of the key map: other words would change every picture.
#[test]
fn named_keys_use_the_words_of_the_map() {
    let key = Key::new(5).purpose(Purpose::Test);
    assert_eq!(key.pixel(3, 7), key.with(7 << 32 | 3));
    assert_eq!(key.film_point(1, 9), key.with(1 << 32 | 9));
    assert_eq!(key.medium_tracking(4), key.with(1 << 63 | 4));
    assert_eq!((key.shared_paths(), key.fresh_paths(0)), (key.with(0), key.with(1)));
    let sampler = Sampler::new(key, 2, 8);
    assert_eq!(sampler.next_vertex(3, true), sampler.with(7));
    assert_eq!(sampler.shadow_rays(6), sampler.with(6 << 32));
    assert_eq!(sampler.light(11), sampler.with(11));
}
