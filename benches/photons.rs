//! Benchmarks of photon tracing, map building and density estimates on a Cornell box: `cargo bench
//! --bench photons`.

mod boxed;

use caustica::photon::{
    Bandwidth, Kernel, Photon, PhotonAttributes, PhotonMap, PhotonSearchBuffers, PhotonSource, PhotonTracer, StoreMask,
};
use caustica::sampling::{Dimension, Key, Purpose, sobol_2d};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use kiddo::leaf_strategy::VecOfArenas;
use kiddo::{Eytzinger, KdTree, SquaredEuclidean};

fn main() {
    divan::main();
}

const PATHS: u32 = 100_000;

/// Traces paths of the global map, on one thread and on two.
#[divan::bench(args = [1, 2], sample_count = 10)]
fn trace_global(bencher: Bencher, threads: usize) {
    let scene = boxed::scene();
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    trace(
        bencher,
        threads,
        &PhotonTracer { scene: &scene, source: &source, mask: StoreMask::INDIRECT, max_bounces: 100 },
    );
}

/// Traces paths of the caustic map, aimed at the balls.
#[divan::bench(args = [1, 2], sample_count = 10)]
fn trace_caustic(bencher: Bencher, threads: usize) {
    let scene = boxed::scene();
    let source = PhotonSource::aimed_at_casters(&scene).unwrap();
    trace(
        bencher,
        threads,
        &PhotonTracer { scene: &scene, source: &source, mask: StoreMask::CAUSTIC, max_bounces: 100 },
    );
}

fn trace(bencher: Bencher, threads: usize, tracer: &PhotonTracer<'_>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    bencher
        .counter(ItemsCount::new(PATHS))
        .bench_local(|| pool.install(|| tracer.trace(Key::new(1), PATHS, &|_| {}).deposits.surface_photons.len()));
}

/// Returns photons on the walls of a unit box.
fn photons(n: u32) -> Vec<Photon> {
    let place = |i: u32| {
        let key = Key::new(1).purpose_key(Purpose::Test).child_key(u64::from(i));
        let u = key.uniform_2d(Dimension::LightPosition);
        let side = (key.uniform_1d(Dimension::Light) * 6.0) as usize;
        let mut p = [u.x, u.y, u.x];
        p[side % 3] = (side / 3) as f32;
        p[(side + 1) % 3] = u.y;
        p[(side + 2) % 3] = u.x;
        let mut normal = Vec3::ZERO;
        normal[side % 3] = if side < 3 { 1.0 } else { -1.0 };
        Photon::new(Vec3::from(p), Vec3::ONE, normal, normal).unwrap()
    };
    (0..n).map(place).collect()
}

/// Builds a map on one thread, to measure processor time.
#[divan::bench(args = [100_000, 1_000_000], sample_count = 10)]
fn build(bencher: Bencher, n: u32) {
    let photons = photons(n);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    bencher
        .counter(ItemsCount::new(n))
        .with_inputs(|| photons.clone())
        .bench_local_values(|photons| pool.install(|| PhotonMap::build(photons).len()));
}

const GATHERS: u32 = 65_536;
const STORED: u32 = 1_000_000;

/// Returns points on the floor in coherent order, like the tiles of an image.
fn floor_points() -> impl Iterator<Item = Vec3> {
    (0..GATHERS).map(|i| {
        let (tile, inner) = (i / 256, i % 256);
        let (x, y) = (tile % 16 * 16 + inner % 16, tile / 16 * 16 + inner / 16);
        let jitter = sobol_2d(i, Key::new(3), Dimension::Film);
        Vec3::new((x as f32 + jitter.x) / 256.0, 0.0, (y as f32 + jitter.y) / 256.0)
    })
}

/// Returns the radius that holds `count` photons on average.
fn radius(count: f32) -> f32 {
    (count * 6.0 / STORED as f32 / std::f32::consts::PI).sqrt()
}

#[divan::bench(args = [20, 50, 200], sample_count = 10)]
fn gather_radius(bencher: Bencher, count: u32) {
    gather(bencher, Bandwidth { radius: radius(count as f32), k: 0 });
}

#[divan::bench(args = [20, 50, 200], sample_count = 10)]
fn gather_k(bencher: Bencher, count: u32) {
    gather(bencher, Bandwidth { radius: radius(count as f32 * 8.0), k: count });
}

fn gather(bencher: Bencher, bandwidth: Bandwidth) {
    let map = PhotonMap::build(photons(STORED));
    bencher.counter(ItemsCount::new(GATHERS)).bench_local(|| {
        let mut scratch = PhotonSearchBuffers::default();
        let estimate = |p| {
            map.estimate_radiance(p, Vec3::Y, bandwidth, Kernel::Epanechnikov, &mut scratch, |_| Vec3::ONE).radiance
        };
        floor_points().map(estimate).sum::<Vec3>()
    });
}

/// Estimates with kiddo's own visitor over the same points: the same flux and kernel, and nothing
/// else. It is the lower bound of [`gather_radius`].
#[divan::bench(args = [20, 50, 200], sample_count = 10)]
fn bare_visitor(bencher: Bencher, count: u32) {
    type Tree = KdTree<f32, PhotonAttributes, Eytzinger, VecOfArenas<f32, PhotonAttributes, 3, 32>, 3, 32>;
    let photons = photons(STORED);
    let tree = Tree::new_from_source(&photons, |p, axis| p.position[axis], |_, p| p.attributes).unwrap();
    let r2 = radius(count as f32) * radius(count as f32);
    bencher.counter(ItemsCount::new(GATHERS)).bench_local(|| {
        let mut sum = Vec3::ZERO;
        for p in floor_points() {
            tree.query(&p.to_array()).within::<SquaredEuclidean<f32>>(r2).unsorted().visit(|found| {
                sum += found.item.flux() * (1.0 - found.distance / r2);
            });
        }
        black_box(sum)
    });
}
