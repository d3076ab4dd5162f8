//! Errors, split into noise and bias.

use super::References;
use crate::color::Rgb;
use glam::DVec3;

/// What pictures of several seeds tell of a method's error; see [`Checkpoint`](super::Checkpoint).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Split {
    pub squares: Vec<f64>,
    pub noise2: f64,
    pub bias2: f64,
    pub rmse: f64,
}

/// Splits the error of two pictures or more, which differ by their seeds.
///
/// With I a picture and A and B references, all three independent of each other, E[(I − A)(I − B)] = bias² + variance of I: the noise
/// of the references cancels. That of the mean of S pictures is bias² + variance/S.
pub(super) fn split(references: &References, pictures: &[Vec<Rgb>]) -> Split {
    let seeds = pictures.len() as f64;
    let mut squares = vec![0.0; pictures.len()];
    let (mut apart, mut of_mean, mut plain) = (0.0, 0.0, 0.0);
    let scale = references.scale();
    let count = scale.weights().len();
    for i in 0..count {
        let mean = mean(pictures, i);
        for (square, picture) in squares.iter_mut().zip(pictures) {
            let pixel = picture[i].as_dvec3();
            let error = references.square(i, pixel);
            *square += scale.counts(i, error);
            plain += error;
        }
        let spread: f64 = pictures.iter().map(|picture| (picture[i].as_dvec3() - mean).length_squared()).sum();
        apart += scale.counts(i, spread / (seeds - 1.0));
        of_mean += scale.counts(i, references.square(i, mean));
    }
    let pixels = count as f64;
    squares.iter_mut().for_each(|square| *square /= pixels);
    let noise2 = apart / pixels;
    let rmse = (plain / (3.0 * pixels * seeds)).max(0.0).sqrt();
    Split { squares, noise2, bias2: of_mean / pixels - noise2 / seeds, rmse }
}

/// Mean of pixel `i`.
pub(super) fn mean(pictures: &[Vec<Rgb>], i: usize) -> DVec3 {
    pictures.iter().map(|picture| picture[i].as_dvec3()).sum::<DVec3>() / pictures.len() as f64
}

/// Root of the relative squared error of each pixel, mean over seeds; zero where noise hides it.
pub(super) fn by_pixel(references: &References, pictures: &[Vec<Rgb>]) -> Vec<f32> {
    let scale = references.scale();
    let square = |i: usize| {
        let counts = |picture: &Vec<Rgb>| scale.counts(i, references.square(i, picture[i].as_dvec3()));
        (pictures.iter().map(counts).sum::<f64>() / pictures.len() as f64).max(0.0).sqrt() as f32
    };
    (0..scale.weights().len()).map(square).collect()
}
