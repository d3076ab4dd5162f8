use super::*;

/// Point `i` of a quasirandom sequence, with coordinates above −1000.
fn quasirandom_point(i: u32) -> DVec3 {
    DVec3::new(0.618_034, 0.414_214, 0.732_051) * f64::from(i) - 1e3
}

/// Checks that values stay in \[−1, 1] and that their mean is 0. With a standard deviation below ½,
/// the tolerance 5/(2√n) of the mean over n points is five standard errors.
#[test]
fn noise_is_bounded_with_zero_mean() {
    let n = 100_000;
    let values: Vec<f64> = (0..n).map(|i| gradient_noise(quasirandom_point(i))).collect();
    assert!(values.iter().all(|x| x.abs() <= 1.0));
    let mean = values.iter().sum::<f64>() / f64::from(n);
    let square = values.iter().map(|x| x * x).sum::<f64>() / f64::from(n);
    assert!(mean.abs() < 2.5 / f64::from(n).sqrt() && (0.04..0.2).contains(&square), "{mean} {square}");
    assert_eq!(
        [
            gradient_noise(DVec3::ZERO),
            gradient_noise(DVec3::new(-3.0, 5.0, 7.0)),
            gradient_noise(DVec3::splat(f64::NAN))
        ],
        [0.0; 3]
    );
}

/// Compares values at points 10⁻⁶ apart, across cell faces and elsewhere. They differ by less than
/// 4·10⁻⁶, because the slope is below 4.
#[test]
fn noise_is_continuous() {
    for i in 0..1000 {
        let p = quasirandom_point(i);
        for face in [p, DVec3::new(p.x.round(), p.y, p.z), DVec3::new(p.x, p.y, p.z.round())] {
            let step = DVec3::splat(5e-7);
            assert!((gradient_noise(face + step) - gradient_noise(face - step)).abs() < 4e-6, "{face}");
        }
    }
}

#[test]
fn noise_octaves_fade_as_the_footprint_grows() {
    let p = DVec3::new(0.3, 0.7, 0.2);
    assert_eq!(fractal_noise(p, 0.0, 1), gradient_noise(p));
    assert_eq!(fractal_noise(p, 0.125, 2), fractal_noise(p, 0.0, 2), "two octaves are coarse enough");
    assert!(fractal_noise(p, 0.125, 3) != fractal_noise(p, 0.0, 3), "the third is not");
    assert_eq!(fractal_noise(p, 0.5, 9), fractal_noise(p, 0.5, 1), "finer octaves are gone");
    assert_eq!(fractal_noise(p, 1.0, 9), 0.0);
}
