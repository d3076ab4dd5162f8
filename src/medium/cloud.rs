//! Procedural clouds: density of fractal noise inside a ball.

use crate::sampling::Key;
use crate::texture::noise::fractal_noise;
use glam::DVec3;
use rand::RngExt;

/// A procedural cloud: fractal noise inside the ball that is inscribed in the unit cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cloud {
    /// Number of noise octaves; each has half the wavelength and half the amplitude of the previous
    /// one.
    pub octaves: u32,
    /// Number of wavelengths of the first noise octave along each side of the unit cube.
    pub frequency: f64,
    /// Cloud cover from 0 to 1: the upper fraction of the range of noise values that becomes cloud.
    ///
    /// At 0 the unit cube is empty. At 1 all of the inscribed ball is cloud, except at its soft
    /// edge.
    pub cover: f64,
    /// Width of the cloud's soft edge, as a fraction of the ball's radius, from 0 to 1. At 0 the
    /// edge is hard.
    pub softness: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Cloud {
    /// Returns a function that maps a point of the unit cube to the cloud's density there, in \[0,
    /// 1].
    ///
    /// `width` is the width of the noise filter, as a fraction of the side of the cube. The filter
    /// removes noise finer than its width; 0 filters nothing.
    pub fn density_function(&self, width: f64) -> impl Fn(DVec3) -> f32 + Sync + use<> {
        let mut rng = Key::new(self.seed).rng();
        // The shift separates the noise of different seeds. It is small enough for coordinates to
        // keep their digits.
        let shift = DVec3::from_array(std::array::from_fn(|_| 65536.0 * rng.random::<f64>()));
        let Self { octaves, frequency: scale, cover, softness, .. } = *self;
        move |p| {
            let inwards = 1.0 - (2.0 * p - 1.0).length();
            let edge = if inwards > 0.0 { smoothstep(inwards / softness.max(f64::MIN_POSITIVE)) } else { 0.0 };
            // Near the edge, the cover decreases instead of the density. So the cloud breaks up at
            // its edge instead of fading.
            let cover = cover.clamp(0.0, 1.0) * edge;
            if cover <= 0.0 {
                return 0.0;
            }
            let height = (0.5 + fractal_noise(p * scale + shift, width * scale, octaves)).clamp(0.0, 1.0);
            ((height - (1.0 - cover)) / cover).max(0.0) as f32
        }
    }
}

/// Cubic step from 0 at `x` ≤ 0 to 1 at `x` ≥ 1.
fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOUD: Cloud = Cloud { octaves: 5, frequency: 4.0, cover: 0.7, softness: 0.4, seed: 1 };

    fn unit_cube_grid_points() -> impl Iterator<Item = DVec3> {
        (0..20u32.pow(3)).map(|i| (DVec3::from([i % 20, i / 20 % 20, i / 400].map(f64::from)) + 0.5) / 20.0)
    }

    fn mean_density(cloud: Cloud) -> f64 {
        let density = cloud.density_function(0.0);
        unit_cube_grid_points().map(|p| f64::from(density(p))).sum::<f64>() / 8000.0
    }

    #[test]
    fn cloud_density_is_bounded_and_inside_the_ball() {
        for softness in [0.0, 0.4, 1.0] {
            let density = Cloud { softness, cover: 1.0, ..CLOUD }.density_function(0.0);
            for p in unit_cube_grid_points() {
                let d = density(p);
                assert!((0.0..=1.0).contains(&d), "{p} {d}");
                assert!(d == 0.0 || (2.0 * p - 1.0).length() < 1.0, "{p} {d}");
            }
            assert_eq!([density(DVec3::ZERO), density(DVec3::splat(f64::NAN))], [0.0; 2]);
        }
    }

    /// The mean density is π/12 at full cover, increases with cover, decreases with softness, and
    /// depends on the seed.
    ///
    /// The ball fills π/6 of the cube, and the mean of the noise is ½. The noise has about 4π/3·2³
    /// = 34 independent values in the ball, with standard deviation ¼. The tolerance is five
    /// standard errors of their mean.
    #[test]
    fn cover_softness_and_seed_change_cloud_density() {
        let full = mean_density(Cloud { cover: 1.0, softness: 0.0, ..CLOUD });
        let truth = std::f64::consts::PI / 12.0;
        assert!((full / truth - 1.0).abs() < 5.0 * 0.5 / 34f64.sqrt(), "{full}");
        let covers = [0.0, 0.3, 0.6, 0.9].map(|cover| mean_density(Cloud { cover, ..CLOUD }));
        assert!(covers[0] == 0.0 && covers.is_sorted() && covers[3] > covers[1], "{covers:?}");
        assert!(mean_density(Cloud { softness: 0.8, ..CLOUD }) < mean_density(Cloud { softness: 0.2, ..CLOUD }));
        let [one, same, other] = [CLOUD, CLOUD, Cloud { seed: 2, ..CLOUD }].map(mean_density);
        assert!(one == same && one != other, "{one} {other}");
    }
}
