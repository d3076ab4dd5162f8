//! Sums of very many samples, the order of passes, and values beyond a file format's range.

mod outputs;
mod partitions;

use crate::support::render_one_pass;
use caustica::color::Rgb;
use caustica::format::SceneFile;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::math::CompensatedSum;
use caustica::render::Film;
use caustica::sampling::{Dimension, Key, Purpose};
use glam::{DVec3, Vec3};
use std::hint::black_box;
use std::path::Path;

/// Largest relative rounding error of f64: half the distance of adjacent numbers from 1 to 2.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Radiance of each pass.
///
/// Two channels have a last bit of 1, which is rounded off in a sum that is 2²⁹ times larger.
const CONSTANT: Rgb = Rgb::new(0.1, 0.7, 3e-5);

/// The mean of 10⁹ equal passes, added one by one to a film of one pixel, is exact to rounding.
#[test]
#[ignore = "long: a billion samples"]
fn mean_of_constant_survives_billion_samples() {
    let mut film = Film::new(1, 1);
    for _ in 0..1_000_000_000u32 {
        film.add(black_box(&[CONSTANT]));
    }
    assert_eq!(film.passes(), 1_000_000_000);
    // The sum and the quotient round once each. The compensated sum of n values adds n²·2⁻¹⁰⁶ =
    // 10⁻¹⁴.
    let off = (film.pixel_means().next().unwrap() / CONSTANT.as_dvec3() - 1.0).abs().max_element();
    assert!(off <= 2.0 * UNIT_ROUNDOFF + 1e18 * UNIT_ROUNDOFF * UNIT_ROUNDOFF, "{off:e}");
    assert!(off < 1e-9);
    assert_eq!(film.mean_picture(), [CONSTANT]);
}

/// Returns `n` values of 24 bits over 40 powers of two, like an image with fireflies.
///
/// If `signed`, half of them are negative.
fn values(n: u64, signed: bool) -> Vec<Rgb> {
    let one = |i: u64| {
        let draw =
            |c: u64, dimension| Key::new(3).purpose_key(Purpose::Test).child_key(i).child_key(c).uniform_1d(dimension);
        Vec3::from_array([0, 1, 2].map(|c| {
            let size = libm::exp2f((40.0 * draw(c, Dimension::Film)).floor() - 20.0);
            let sign = if signed && draw(c, Dimension::Light) < 0.5 { -1.0 } else { 1.0 };
            sign * size * (1.0 + draw(c, Dimension::Lens))
        }))
    };
    (0..n).map(one).collect()
}

/// Returns the values in five orders: as given, backwards, ascending, descending, and shuffled.
fn orders(values: &[Rgb]) -> [Vec<Rgb>; 5] {
    let by = |key: &dyn Fn(&Rgb) -> f32| {
        let mut sorted = values.to_vec();
        sorted.sort_by(|a, b| key(a).total_cmp(&key(b)));
        sorted
    };
    let hash = |v: &Rgb| Key::new(u64::from(v.x.to_bits())).purpose_key(Purpose::Test).uniform_1d(Dimension::Film);
    [values.to_vec(), values.iter().rev().copied().collect(), by(&|v| v.x.abs()), by(&|v| -v.x.abs()), by(&hash)]
}

/// The order of passes changes no bit of a film, and its sums are accurate.
///
/// The values span 40 powers of two, and a pixel keeps at least 31 bits below its largest value. So
/// the error of each value is at most half of 2⁻³⁰ of the largest.
///
/// The reference is a sum of integers in units of 2⁻⁶⁴. The last bit of a value is at least
/// 2⁻²⁰⁻²³, and a sum of 2²⁰ values below 2²¹ needs 105 bits.
#[test]
fn pass_order_changes_no_bit() {
    for signed in [false, true] {
        let values = values(100_000, signed);
        let n = values.len() as f64;
        let exact = |c: usize| values.iter().map(|v| (f64::from(v[c]) * libm::exp2(64.0)) as i128).sum::<i128>();
        let exact = DVec3::from_array([0, 1, 2].map(|c| exact(c) as f64 / libm::exp2(64.0)));
        let magnitudes: DVec3 = values.iter().map(|v| v.as_dvec3().abs()).sum();
        // The bound covers the rounding of the sum, of the quotient and of `exact`, and the error
        // n²u² of compensated sums, where u is `UNIT_ROUNDOFF`.
        let bound = exact.abs() * 3.0 * UNIT_ROUNDOFF + magnitudes * (n * UNIT_ROUNDOFF) * (n * UNIT_ROUNDOFF);
        let largest = values.iter().fold(0.0, |most: f32, v| most.max(v.abs().max_element()));
        let film_bound = bound + n * f64::from(largest) * libm::exp2(-31.0);
        let mut first = None;
        for (order, values) in orders(&values).iter().enumerate() {
            let mut film = Film::new(1, 1);
            let mut sum = CompensatedSum::default();
            for value in values {
                film.add(&[*value]);
                sum.add(value.as_dvec3());
            }
            let off = (film.pixel_means().next().unwrap() * n - exact).abs();
            assert!(off.cmple(film_bound).all(), "order {order}, signed {signed}: {off} beyond {film_bound}");
            assert!(*first.get_or_insert(film.clone()) == film, "order {order}, signed {signed}");
            assert!((sum.value() - exact).abs().cmple(bound).all(), "order {order}");
        }
    }
}

/// Passes that are rendered in reverse order give the same image.
#[test]
fn passes_rendered_backwards_give_same_image() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/matte.txt");
    let mut file = SceneFile::read(&path).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = (24, 18);
    let scene = file.resolve().unwrap();
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(1), ..CameraPathSettings::default() };
    let integrator = Algorithm::Path.prepare(&scene, Settings { camera_paths, ..Settings::default() });
    let film = |passes: &mut dyn Iterator<Item = u32>| {
        let mut film = Film::new(24, 18);
        passes.for_each(|pass| film.add(&render_one_pass(&*integrator, pass)));
        film
    };
    let (forwards, backwards) = (film(&mut (0..40)), film(&mut (0..40).rev()));
    assert!(forwards == backwards);
    assert!(forwards.mean_picture().iter().any(|value| value.x > 0.0));
}

#[test]
fn means_of_largest_floats_stay_finite() {
    let mut film = Film::new(2, 1);
    let extremes = [Rgb::new(f32::MAX, -f32::MAX, 0.0), Rgb::splat(f32::MIN_POSITIVE)];
    (0..100_000).for_each(|_| film.add(&extremes));
    assert_eq!(film.mean_picture(), extremes);
    film.add(&[Rgb::new(f32::INFINITY, 0.0, f32::NAN), Rgb::ZERO]);
    let mean = film.mean_picture()[0];
    assert!(mean.x == f32::INFINITY && mean.y.is_finite() && mean.z.is_nan(), "{mean}: what is not finite stays seen");
}
