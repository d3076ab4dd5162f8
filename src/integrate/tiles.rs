//! The pixels of a pass, in tiles.

use super::gauged::Tally;
use super::guide::Guide;
use super::{Gauged, Monitor, Stage};
use crate::camera::{Camera, Filter, FilterSample};
use crate::color::Rgb;
use crate::math::{Ray, Sum};
use crate::medium::TransmittanceCurve;
use crate::photon::{Scratch, VisiblePoint};
use crate::sampling::{Dimension, Key, Sampler};
use crate::stats::Counters;
use glam::{DVec3, Vec2};
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
    /// Whether estimates tell of their error.
    pub gauge: bool,
    /// What they tell.
    pub tally: Tally,
    /// What is left of light along a stretch of a medium.
    pub fade: TransmittanceCurve,
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
    /// How many rays each pixel gets, in parts of the mean; `None`: all alike.
    pub density: Option<&'a [f32]>,
    /// Whether estimates tell of their error.
    pub gauge: bool,
    /// One tile of so many is rendered, the rest left black; 1: all.
    pub every: u32,
}

/// A picture by rows from the top, and what it took.
pub(super) struct Rendered {
    pub image: Vec<Rgb>,
    /// What estimates tell of their error; empty where they are not asked.
    pub gauged: Vec<Gauged>,
    /// Pixels that were rendered, where tiles are left out.
    pub places: Vec<u32>,
    pub counters: Counters,
}

/// A tile of a picture that is being rendered.
struct Tile<'a> {
    /// Of all tiles, by rows from the top.
    index: u32,
    /// Its rows, where they lie in the picture.
    image: Vec<&'a mut [Rgb]>,
    /// Those of what estimates tell; none where they are not asked.
    gauged: Vec<&'a mut [Gauged]>,
}

impl<'a> Tile<'a> {
    /// Cuts a picture of so many columns of pixels, at least one.
    fn cut(image: &'a mut [Rgb], gauged: &'a mut [Gauged], width: u32) -> Vec<Self> {
        let height = image.len() as u32 / width;
        let empty = |index| Tile { index, image: Vec::new(), gauged: Vec::new() };
        let mut tiles: Vec<Self> = (0..width.div_ceil(EDGE) * height.div_ceil(EDGE)).map(empty).collect();
        pieces(image, width).for_each(|(tile, row)| tiles[tile].image.push(row));
        pieces(gauged, width).for_each(|(tile, row)| tiles[tile].gauged.push(row));
        tiles
    }
}

/// The rows of tiles, each with the index of its tile, from the top.
fn pieces<T>(picture: &mut [T], width: u32) -> impl Iterator<Item = (usize, &mut [T])> {
    let (width, edge) = (width as usize, EDGE as usize);
    let tile = move |x: usize, y: usize| y / edge * width.div_ceil(edge) + x;
    let rows = picture.chunks_mut(width).enumerate();
    rows.flat_map(move |(y, row)| row.chunks_mut(edge).enumerate().map(move |(x, piece)| (tile(x, y), piece)))
}

impl Sampling<'_> {
    /// Rays of a pixel, counted by rows from the top; one at least.
    fn rays(&self, pixel: usize) -> u32 {
        let exact = |density: &[f32]| (self.samples as f32 * density[pixel]).round().max(1.0) as u32;
        self.density.map_or(self.samples, exact)
    }
}

/// Renders pixels: `radiance` gets a camera ray, the random numbers of its sample, and what the tile keeps: a worker, and whatever
/// else is asked for.
pub(super) fn render<T: Default>(
    sampling: &Sampling<'_>,
    key: Key,
    monitor: &dyn Monitor,
    radiance: impl Fn(&Ray, Sampler, &mut Worker, &mut T) -> Rgb + Sync,
) -> Rendered {
    let (width, height) = sampling.camera.size();
    let (columns, every) = (width.div_ceil(EDGE), sampling.every);
    let pixels = width as usize * height as usize;
    monitor.begin(Stage::Eye, pixels as u64 / u64::from(every));
    let mut image = vec![Rgb::ZERO; pixels];
    let mut gauged = vec![Gauged::default(); if sampling.gauge { pixels } else { 0 }];
    let mut tiles = Tile::cut(&mut image, &mut gauged, width);
    tiles.retain(|tile| is_wanted(tile.index, columns, every));
    let places = |tile: &Tile<'_>| pixels_of(tile.index, columns, width, height).map(|(x, y)| y * width + x);
    let places = if every > 1 { tiles.iter().flat_map(places).collect() } else { Vec::new() };
    let work = tiles.into_par_iter().map(|mut tile| {
        let mut worker = Worker { gauge: sampling.gauge, ..Worker::default() };
        let mut more = T::default();
        let mut rendered = 0;
        for (x, y) in pixels_of(tile.index, columns, width, height) {
            let (i, j) = ((x % EDGE) as usize, (y % EDGE) as usize);
            tile.image[j][i] =
                pixel(sampling, x, y, key, &mut worker, |ray, draw, worker| radiance(ray, draw, worker, &mut more));
            if sampling.gauge {
                tile.gauged[j][i] = worker.tally.end_pixel(sampling.rays((y * width + x) as usize));
            }
            rendered += 1;
        }
        monitor.advance(rendered);
        worker.counters
    });
    let counters = work.reduce(Counters::default, |mut a, b| {
        a += b;
        a
    });
    Rendered { image, gauged, places, counters }
}

/// One tile of so many leaves about `wanted` of a picture, but no more than half.
pub(super) fn every((width, height): (u32, u32), wanted: u32) -> u32 {
    (width.div_ceil(EDGE) * height.div_ceil(EDGE) / wanted).max(2)
}

/// Whether a tile is one of those that are rendered: they lie on slanting lines, so that rows and columns have alike.
fn is_wanted(tile: u32, columns: u32, every: u32) -> bool {
    // A slant that shares a factor with the step would leave columns out.
    let slant = (1..=every.div_ceil(2)).rev().find(|slant| gcd(*slant, every) == 1).unwrap_or(1);
    (tile % columns + tile / columns * slant).is_multiple_of(every)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
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
    mut radiance: impl FnMut(&Ray, Sampler, &mut Worker) -> Rgb,
) -> Rgb {
    let corner = Vec2::new(x as f32, y as f32);
    let pixel = key.with(u64::from(y) << 32 | u64::from(x));
    let mut sum = Samples::default();
    let samples = sampling.rays(y as usize * sampling.camera.size().0 as usize + x as usize);
    for sample in 0..samples {
        let draw = Sampler::new(pixel, sample, samples);
        let (at, weight) = match sampling.filter {
            Some(filter) => {
                // What makes up for signs is without bias where samples are independent.
                let film = if filter.is_signed() {
                    draw.key().uniform_2d(Dimension::Film)
                } else {
                    draw.get_2d(Dimension::Film)
                };
                let FilterSample { offset, weight } = filter.sample(film);
                (corner + 0.5 + offset, weight)
            }
            None => (corner + Vec2::Y, 1.0),
        };
        worker.counters.camera_rays += 1;
        let lens = sampling.lens.then(|| draw.get_2d(Dimension::Lens));
        let value = radiance(&sampling.camera.ray(at, lens), draw, worker);
        let finite = value.is_finite();
        if finite {
            sum.add(value, weight);
        } else {
            worker.counters.rejected_samples += 1;
        }
        if sampling.gauge {
            worker.tally.end_ray(finite.then_some(weight));
        }
    }
    let mean = if sampling.filter.is_some_and(Filter::is_signed) { sum.weighted() } else { sum.plain() };
    (mean / f64::from(samples)).as_vec3()
}

/// The sums of a pixel.
#[derive(Default)]
struct Samples {
    /// Of values.
    values: Sum,
    /// Of weights times values.
    weighted: Sum,
    /// Of weights, less 1 each.
    excess: f64,
    count: u32,
}

impl Samples {
    #[inline]
    fn add(&mut self, value: Rgb, weight: f32) {
        let value = value.as_dvec3();
        self.values.add(value);
        self.weighted.add(value * f64::from(weight));
        self.excess += f64::from(weight - 1.0);
        self.count += 1;
    }

    fn plain(&self) -> DVec3 {
        self.values.value()
    }

    /// Weights that differ make noise even where all values are alike. So each sample stands for its weight, and for what its weight lacks of
    /// 1 the mean of the others stands in: that is without bias, and exact where values are alike.
    fn weighted(&self) -> DVec3 {
        let (values, weighted) = (self.values.value(), self.weighted.value());
        let others = f64::from(self.count) - 1.0;
        if others < 1.0 {
            return weighted;
        }
        // Σ (1 − wᵢ)(S − Lᵢ)/(n − 1), by the sums that are there.
        let lacks = (weighted - values) - values * self.excess;
        weighted + lacks / others
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::FilterKind;
    use crate::sampling::Purpose;

    /// The mean over passes of a picture of `look` through `kind`, and its standard error.
    fn looked(kind: FilterKind, samples: u32, look: impl Fn(f32) -> f32 + Sync) -> Vec<(f64, f64)> {
        let camera = Camera::orthographic(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1.0, 12, 1).unwrap();
        let filter = Filter::new(kind);
        let sampling = Sampling {
            camera: &camera,
            filter: Some(&filter),
            samples,
            lens: false,
            density: None,
            gauge: false,
            every: 1,
        };
        let passes = 400u32;
        let mut sums = vec![(0.0, 0.0); 12];
        for pass in 0..passes {
            let key = Key::new(8).purpose(Purpose::Test).with(u64::from(pass));
            let Rendered { image, .. } = render(&sampling, key, &super::super::Silent, |ray, _, _, (): &mut ()| {
                Rgb::splat(look(ray.origin.x + 6.0))
            });
            for (sum, value) in sums.iter_mut().zip(image) {
                let value = f64::from(value.x);
                *sum = (sum.0 + value, sum.1 + value * value);
            }
        }
        let n = f64::from(passes);
        sums.into_iter().map(|(s, q)| (s / n, ((q / n - s * s / n / n).max(0.0) / (n - 1.0)).sqrt())).collect()
    }

    #[test]
    fn filters_with_negative_parts_show_what_is_even_without_noise_and_edges_without_bias() {
        for samples in [2, 3, 16] {
            let even = looked(FilterKind::Mitchell, samples, |_| 0.7);
            assert!(even.iter().all(|(mean, error)| (mean - 0.7).abs() < 1e-6 && *error < 1e-6), "{even:?}");
            let edge = looked(FilterKind::Mitchell, samples, |x| if x < 6.3 { 1.0 } else { 0.0 });
            // Cells of the table misplace a thousandth of the weight at most.
            for (x, (mean, error)) in edge.iter().enumerate() {
                let weight = |y: f64| FilterKind::Mitchell.weight(y);
                let (mut left, mut all) = (0.0, 0.0);
                for i in 0..4000 {
                    let y = -2.0 + (f64::from(i) + 0.5) / 1000.0;
                    all += weight(y);
                    left += if x as f64 + 0.5 + y < 6.3 { weight(y) } else { 0.0 };
                }
                let expected = left / all;
                assert!((mean - expected).abs() < 5.0 * error + 2e-3, "{samples}, {x}: {mean} ± {error}, {expected}");
            }
            // Blunter tests could not tell the filter from its positive part.
            assert!(samples < 16 || edge.iter().any(|(mean, error)| *mean < -5.0 * error));
        }
    }

    #[test]
    fn tiles_that_are_left_are_enough_and_in_all_columns() {
        for size in [(96u32, 72u32), (640, 480), (1920, 1080), (16, 16), (4000, 16)] {
            let (columns, rows) = (size.0.div_ceil(EDGE), size.1.div_ceil(EDGE));
            let every = every(size, 48);
            let left: Vec<u32> = (0..columns * rows).filter(|tile| is_wanted(*tile, columns, every)).collect();
            assert!(left.len() as u32 >= 40.min(columns * rows / 2).max(1), "{size:?} {every}: {}", left.len());
            let taken: std::collections::HashSet<u32> = left.iter().map(|tile| tile % columns).collect();
            assert!(rows < every || taken.len() as u32 == columns, "{size:?} {every}");
        }
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1u32, 1u32), (16, 16), (17, 33), (100, 1)] {
            let columns = width.div_ceil(EDGE);
            let mut seen = vec![Rgb::ZERO; (width * height) as usize];
            for mut tile in Tile::cut(&mut seen, &mut [], width) {
                for (x, y) in pixels_of(tile.index, columns, width, height) {
                    tile.image[(y % EDGE) as usize][(x % EDGE) as usize] += Rgb::new(1.0, x as f32, y as f32);
                }
            }
            let expected = |i| Rgb::new(1.0, (i % width) as f32, (i / width) as f32);
            assert!((0..width * height).all(|i| seen[i as usize] == expected(i)));
        }
    }
}
