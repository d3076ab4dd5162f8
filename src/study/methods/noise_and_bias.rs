//! Separates the error of a method into noise and bias.

use super::ReferencePictures;
use crate::color::Rgb;
use glam::DVec3;

/// Error, noise and bias of a method at one checkpoint.
///
/// [`ConvergenceCheckpoint`](super::ConvergenceCheckpoint) describes the fields.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoiseAndBias {
    pub squared_errors: Vec<f64>,
    pub squared_noises: Vec<f64>,
    pub squared_noise: f64,
    pub squared_bias: f64,
    pub rmse: f64,
}

/// Estimates error, noise and bias from at least two pictures of one method with different seeds.
///
/// Let I be a picture, and A and B two references, all with independent noise. The mean of the
/// product (I − A)(I − B) is the squared bias plus the variance of I: the noise of A and B cancels.
/// All results but `rmse` are relative. The relative squared error of each pixel is clamped to
/// \[−1, 1].
pub(super) fn separate_noise_and_bias(references: &ReferencePictures, pictures: &[Vec<Rgb>]) -> NoiseAndBias {
    let seeds = pictures.len() as f64;
    let (mut squared_errors, mut squared_noises) = (vec![0.0; pictures.len()], vec![0.0; pictures.len()]);
    let mut squared_error_sum = 0.0;
    let scale = references.relative_error_weights();
    let count = scale.pixel_weights().len();
    // Bessel's correction: the mean over seeds contains each picture, so squared differences from
    // this mean are too small by the factor (S − 1)/S for S seeds.
    let bessel_factor = seeds / (seeds - 1.0);
    for i in 0..count {
        let mean = mean_pixel_over_pictures(pictures, i);
        for ((square, noise), picture) in squared_errors.iter_mut().zip(&mut squared_noises).zip(pictures) {
            let pixel = picture[i].as_dvec3();
            let error = references.unbiased_squared_error(i, pixel);
            *square += scale.clamped_relative_squared_error(i, error);
            *noise += scale.clamped_relative_squared_error(i, bessel_factor * (pixel - mean).length_squared());
            squared_error_sum += error;
        }
    }
    let pixels = count as f64;
    squared_errors.iter_mut().chain(&mut squared_noises).for_each(|sum| *sum /= pixels);
    let noise2 = squared_noises.iter().sum::<f64>() / seeds;
    let bias2 = squared_errors.iter().sum::<f64>() / seeds - noise2;
    let rmse = (squared_error_sum / (3.0 * pixels * seeds)).max(0.0).sqrt();
    NoiseAndBias { squared_errors, squared_noises, squared_noise: noise2, squared_bias: bias2, rmse }
}

/// Returns the color of pixel `i`, as a mean over `pictures`.
pub(super) fn mean_pixel_over_pictures(pictures: &[Vec<Rgb>], i: usize) -> DVec3 {
    pictures.iter().map(|picture| picture[i].as_dvec3()).sum::<DVec3>() / pictures.len() as f64
}

/// Returns the relative error of each pixel, as a root mean square over seeds.
///
/// The relative squared error of each seed is clamped to \[−1, 1]. If the estimated mean square is
/// negative, the error of the pixel is 0.
pub(super) fn relative_pixel_errors(references: &ReferencePictures, pictures: &[Vec<Rgb>]) -> Vec<f32> {
    let scale = references.relative_error_weights();
    let square = |i: usize| {
        let clamped_error = |picture: &Vec<Rgb>| {
            scale.clamped_relative_squared_error(i, references.unbiased_squared_error(i, picture[i].as_dvec3()))
        };
        (pictures.iter().map(clamped_error).sum::<f64>() / pictures.len() as f64).max(0.0).sqrt() as f32
    };
    (0..scale.pixel_weights().len()).map(square).collect()
}
