//! How noise is spread over a picture: how many independent values it is worth.

use crate::color::Rgb;

/// Learns from pictures of the same, one at a time, the variance of one and in how many independent parts it comes.
///
/// The difference of two pictures over √2 has their noise and nothing else. The mean of its squares is the variance v; the product of two
/// such differences, which share no picture, has mean zero and the variance tr Σ²: v² over the number of independent values of equal
/// variance that would scatter as much (Satterthwaite).
#[derive(Clone, Debug, Default)]
pub(super) struct Spread {
    pictures: u32,
    before: Vec<Rgb>,
    /// The last two differences, in turns.
    differences: [Vec<Rgb>; 2],
    variances: Moments,
    products: Moments,
}

/// Before products are known, noise is taken to come in so many independent values, and that counts as two products.
const FEW_VALUES: f64 = 100.0;
const KNOWN: f64 = 2.0;

/// Mean and variance of a stream (Welford).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f64,
    mean: f64,
    m2: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        let delta = x - self.mean;
        self.mean += delta / self.count;
        self.m2 += delta * (x - self.mean);
    }
}

impl Spread {
    /// Adds a picture; `weights` say how a squared difference counts, and no pixel counts for more than `most`.
    pub fn add(&mut self, picture: impl Iterator<Item = Rgb>, weights: &[f64], most: f64) {
        self.pictures += 1;
        if self.pictures == 1 {
            self.before.extend(picture);
            return;
        }
        let n = weights.len() as f64;
        let (mut square, mut product) = (0.0, 0.0);
        let old = &mut self.differences[self.pictures as usize % 2];
        old.resize(weights.len(), Rgb::ZERO);
        for (((value, before), old), weight) in picture.zip(&mut self.before).zip(old).zip(weights) {
            let mut difference = (value - *before) * std::f32::consts::FRAC_1_SQRT_2;
            *before = value;
            let counts = weight * difference.as_dvec3().length_squared();
            if counts > most {
                difference *= (most / counts).sqrt() as f32;
            }
            square += counts.min(most);
            product += weight * difference.as_dvec3().dot(old.as_dvec3());
            *old = difference;
        }
        self.variances.add(square / n);
        // The difference before the last is the last that shares no picture with this one.
        if self.pictures > 3 {
            let product = product / n;
            self.products.add(product * product);
        }
    }

    /// Relative variance of the squared error of the mean of pictures about its expectation, were their noise Gaussian: 2 over the number of
    /// independent values.
    pub fn scatter(&self) -> f64 {
        let v = self.variances.mean;
        if v <= 0.0 {
            return 0.0;
        }
        let Moments { count, mean, .. } = self.products;
        2.0 * ((mean / (v * v) * count + KNOWN / FEW_VALUES) / (count + KNOWN)).min(1.0)
    }

    /// Relative variance of the variance that so many pictures tell, as they show it: rare bright pixels make it large.
    pub fn doubt(&self) -> f64 {
        let Moments { count, mean, m2 } = self.variances;
        if count < 2.0 || mean <= 0.0 {
            return if mean > 0.0 { 2.0 } else { 0.0 };
        }
        // Differences that follow each other share a picture, which leaves them two thirds of their number.
        1.5 * m2 / (count - 1.0) / count / (mean * mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose};

    /// Uniform noise of variance 1/12 a channel in blocks of `block` equal pixels.
    fn learn(block: usize, pixels: usize, pictures: u64) -> Spread {
        let mut spread = Spread::default();
        let weights = vec![1.0; pixels];
        for picture in 0..pictures {
            let key = Key::new(9).purpose(Purpose::Test).with(picture);
            let value = |i: usize| Rgb::X * key.with((i / block) as u64).uniform(Dimension::Film);
            spread.add((0..pixels).map(value), &weights, f64::INFINITY);
        }
        spread
    }

    /// 240 pixels in blocks of b are 240/b values. tr Σ² is known to √(2/K) over K products that share nothing, 397/2 or more: five sigma.
    #[test]
    fn blocks_of_equal_pixels_are_one_value_each() {
        for block in [1, 4, 24] {
            let spread = learn(block, 240, 400);
            assert!((spread.variances.mean * 12.0 - 1.0).abs() < 5.0 * (3.0 * block as f64 / 240.0 / 399.0).sqrt());
            let independent = 2.0 / spread.scatter();
            let expected = 240.0 / block as f64;
            assert!((independent / expected - 1.0).abs() < 5.0 * (2.0 / 198f64).sqrt(), "{independent} {expected}");
        }
    }

    #[test]
    fn few_pictures_know_little_and_black_ones_all() {
        assert_eq!((learn(1, 10, 1).scatter(), learn(1, 10, 3).scatter()), (0.0, 2.0 / FEW_VALUES));
        assert_eq!(learn(1, 10, 2).doubt(), 2.0);
        assert!(learn(10, 10, 12).scatter() > 10.0 * 2.0 / FEW_VALUES);
        let mut black = Spread::default();
        (0..8).for_each(|_| black.add(std::iter::repeat_n(Rgb::ZERO, 4), &[1.0; 4], 1.0));
        assert_eq!((black.scatter(), black.doubt()), (0.0, 0.0));
    }
}
