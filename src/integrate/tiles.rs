//! The pixels of a pass, in tiles.

use super::guide::Guide;
use super::{Monitor, Phase};
use crate::camera::{Camera, Filter};
use crate::color::Rgb;
use crate::math::Ray;
use crate::photon::{Scratch, VisiblePoint};
use crate::sampling::{Dimension, Draw, Key};
use crate::stats::Counters;
use glam::Vec2;
use rayon::prelude::*;

/// Edge of a tile in pixels: neighbours share photons and boxes in the caches.
const EDGE: u32 = 16;

/// What one tile keeps between its pixels. It starts afresh in each tile, so results do not depend on who renders it.
#[derive(Debug, Default)]
pub(super) struct Worker {
    pub counters: Counters,
    pub caustic: Scratch,
    pub smooth: Scratch,
    pub guides: Scratch,
    /// Where light comes from, for gather rays.
    pub guide: Guide,
    /// Where walks ended, for a pilot.
    pub visible: Vec<VisiblePoint>,
}

/// How a pixel is covered by samples.
pub(super) struct Sampling<'a> {
    pub camera: &'a Camera,
    /// `None`: one ray through the lower left corner of each pixel.
    pub filter: Option<&'a Filter>,
    /// Rays a pixel.
    pub samples: u32,
    /// Whether they leave all of the lens.
    pub lens: bool,
}

/// Renders all pixels: `radiance` gets a camera ray, the random numbers of its sample, and what the tile keeps: a worker, and whatever
/// else is asked for.
pub(super) fn render<T: Default>(
    sampling: &Sampling<'_>,
    key: Key,
    monitor: &dyn Monitor,
    radiance: impl Fn(&Ray, Draw, &mut Worker, &mut T) -> Rgb + Sync,
) -> (Vec<Rgb>, Counters) {
    let (width, height) = sampling.camera.size();
    let columns = width.div_ceil(EDGE);
    monitor.begin(Phase::Eye, u64::from(width) * u64::from(height));
    let tiles: Vec<(Vec<Rgb>, Counters)> = (0..columns * height.div_ceil(EDGE))
        .into_par_iter()
        .map(|tile| {
            let mut worker = Worker::default();
            let mut more = T::default();
            let mut pixels = Vec::with_capacity((EDGE * EDGE) as usize);
            for (x, y) in pixels_of(tile, columns, width, height) {
                pixels.push(pixel(sampling, x, y, key, &mut worker, |ray, draw, worker| {
                    radiance(ray, draw, worker, &mut more)
                }));
            }
            monitor.advance(pixels.len() as u64);
            (pixels, worker.counters)
        })
        .collect();

    let mut image = vec![Rgb::ZERO; width as usize * height as usize];
    let mut counters = Counters::default();
    for (tile, (pixels, counted)) in tiles.iter().enumerate() {
        for ((x, y), value) in pixels_of(tile as u32, columns, width, height).zip(pixels) {
            image[y as usize * width as usize + x as usize] = *value;
        }
        counters += *counted;
    }
    (image, counters)
}

fn pixels_of(tile: u32, columns: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let (left, top) = (tile % columns * EDGE, tile / columns * EDGE);
    (top..height.min(top + EDGE)).flat_map(move |y| (left..width.min(left + EDGE)).map(move |x| (x, y)))
}

fn pixel(
    sampling: &Sampling<'_>,
    x: u32,
    y: u32,
    key: Key,
    worker: &mut Worker,
    mut radiance: impl FnMut(&Ray, Draw, &mut Worker) -> Rgb,
) -> Rgb {
    let corner = Vec2::new(x as f32, y as f32);
    let pixel = key.with(u64::from(y) << 32 | u64::from(x));
    let mut sum = glam::DVec3::ZERO;
    for sample in 0..sampling.samples {
        let draw = Draw::new(pixel, sample, sampling.samples);
        let at = match sampling.filter {
            Some(filter) => corner + 0.5 + filter.sample(draw.two(Dimension::Film)),
            None => corner + Vec2::Y,
        };
        worker.counters.camera_rays += 1;
        let lens = sampling.lens.then(|| draw.two(Dimension::Lens));
        let value = radiance(&sampling.camera.ray(at, lens), draw, worker);
        if value.is_finite() {
            sum += value.as_dvec3();
        } else {
            worker.counters.rejected_samples += 1;
        }
    }
    (sum / f64::from(sampling.samples)).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1u32, 1u32), (16, 16), (17, 33), (100, 1)] {
            let columns = width.div_ceil(EDGE);
            let mut seen = vec![0; (width * height) as usize];
            for tile in 0..columns * height.div_ceil(EDGE) {
                for (x, y) in pixels_of(tile, columns, width, height) {
                    seen[(y * width + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
        }
    }
}
