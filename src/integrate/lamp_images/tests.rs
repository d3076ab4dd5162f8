use super::*;
use crate::sampling::{Key, Purpose};

/// Returns a small oblique lamp image, and one twice as large that moves with the lens point.
fn two_images() -> Vec<PixelLampImage> {
    let small = LampImage {
        center: Vec2::new(10.3, 4.6),
        shift_per_lens_position: Mat2::ZERO,
        to_disc: Mat2::from_cols(Vec2::new(20.0, 3.0), Vec2::new(-4.0, 12.0)),
    };
    let moving = LampImage {
        center: Vec2::new(10.7, 4.2),
        shift_per_lens_position: Mat2::from_cols(Vec2::new(2.0, 0.5), Vec2::new(-0.25, 3.0)),
        to_disc: small.to_disc * 0.5,
    };
    vec![PixelLampImage { image: small, aim_probability: 0.7 }, PixelLampImage { image: moving, aim_probability: 0.3 }]
}

/// Film points aimed at lamp images, weighted by 1/pdf, integrate a smooth bump around a lamp image
/// correctly.
///
/// The weights of 2¹⁶ stratified points vary by less than a factor of 4, so the tolerance of 1 % is
/// above five standard deviations of as many independent points.
#[test]
fn aimed_points_follow_their_pdf() {
    let images = two_images();
    let key = Key::new(3).purpose_key(Purpose::Test);
    let count = 1 << 16;
    for (target, on_lens) in [(0, Vec2::ZERO), (1, Vec2::ZERO), (0, Vec2::new(0.1, -0.05)), (1, Vec2::new(0.1, -0.05))]
    {
        let image = images[target].image;
        let bump = |film: Vec2| (1.0 - image.disc_point(film, on_lens).length_squared()).max(0.0);
        let sum: f64 = (0..count)
            .map(|i| {
                let film = sample_aimed_film_point(&images, Sampler::new(key, i, count), on_lens);
                f64::from(bump(film) / aimed_pdf(&images, film, on_lens))
            })
            .sum();
        let found = sum / f64::from(count);
        // The bump has half the volume of a cylinder of height 1 over the lamp image.
        let expected = f64::from(0.5 * image.area());
        assert!((found / expected - 1.0).abs() < 0.01, "image {target} at {on_lens}: {found}, not {expected}");
    }
}

/// Most rays aimed at a lamp image fall into it.
///
/// The tolerance is 2.5 standard deviations of as many independent rays; stratified ones vary less.
#[test]
fn most_aimed_rays_fall_into_the_image() {
    let images = &two_images()[..1];
    let images = [PixelLampImage { aim_probability: 1.0, ..images[0] }];
    let key = Key::new(4).purpose_key(Purpose::Test);
    let count = 1 << 12;
    let hits = (0..count).filter(|i| {
        let film = sample_aimed_film_point(&images, Sampler::new(key, *i, count), Vec2::ZERO);
        images[0].image.disc_point(film, Vec2::ZERO).length() < 1.0
    });
    // The fraction 1/1.25² of the core falls into the unit disc, and 1/(2² + 1) of the tail.
    let expected = 0.75 / (1.25 * 1.25) + 0.25 / 5.0;
    let found = hits.count() as f64 / f64::from(count);
    assert!((found - expected).abs() < 0.02, "{found}, not {expected}");
}

#[test]
fn lamp_images_are_listed_by_pixel() {
    let images = two_images();
    let pixels = [vec![], images.clone(), vec![images[1]], vec![]];
    let all = LampImages::from_pixels(&pixels);
    assert!((0..4).all(|pixel| all.of_pixel(pixel) == pixels[pixel]));
    let some = all.in_pixels(|pixel| pixel != 1);
    assert!(some.of_pixel(1).is_empty() && some.of_pixel(2) == pixels[2]);
}

/// The longest half axis ends on the rim of the lamp image. The whole rim is within its length.
#[test]
fn longest_axes_reach_the_rim() {
    for PixelLampImage { image, .. } in two_images() {
        let axis = image.longest_half_axis();
        let length = |i: usize| {
            let (sin, cos) = libm::sincosf(TAU * i as f32 / 720.0);
            (image.to_disc.inverse() * Vec2::new(cos, sin)).length()
        };
        let longest = (0..720).map(length).fold(0.0, f32::max);
        assert!((axis.length() / longest - 1.0).abs() < 1e-3, "{axis}, not {longest} long");
        assert!(((image.to_disc * axis).length() - 1.0).abs() < 1e-4);
    }
}
