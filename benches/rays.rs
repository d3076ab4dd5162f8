//! Benchmarks of rays through the bounding volume hierarchy: `cargo bench --bench rays`.

use caustica::accel::{Bvh, ShapeHit};
use caustica::math::{Bounds, Frame, Ray, warp};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use std::sync::LazyLock;

fn main() {
    divan::main();
}

const SIDE: usize = 512;

/// Returns a rippled tube around a (2, 3) torus knot: `n` by `m` quads, each cut in two.
fn knot(n: usize, m: usize) -> Vec<[Vec3; 3]> {
    let circle = |x: f32| libm::sincosf(std::f32::consts::TAU * x);
    let curve = |x: f32| {
        let ((s3, c3), (s2, c2)) = (circle(3.0 * x), circle(2.0 * x));
        Vec3::new((2.0 + c3) * c2, (2.0 + c3) * s2, s3)
    };
    let point = |i: usize, j: usize| {
        let (x, y) = ((i % n) as f32 / n as f32, (j % m) as f32 / m as f32);
        let frame = Frame::from_normal((curve(x + 1e-3) - curve(x - 1e-3)).normalize());
        let (s, c) = circle(y);
        let radius = 0.5 + 0.03 * circle(60.0 * x).0 * circle(12.0 * y).0;
        curve(x) + (frame.s * c + frame.t * s) * radius
    };
    let quads = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

struct Scene {
    tree: Bvh,
    primary: Vec<Ray>,
    diffuse: Vec<Ray>,
    shadow: Vec<Ray>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let triangles = knot(2500, 200);
    let tree = Bvh::build(&triangles, &[]);
    let eye = Vec3::new(1.5, -4.0, 6.0);
    let frame = Frame::from_normal(-eye.normalize());
    let pixel = |i: usize| (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32 - 0.5;
    let aim = |p: Vec2| Ray::new(eye, (frame.s * p.x + frame.t * p.y) * 1.1 + frame.n);
    let primary: Vec<Ray> = (0..SIDE * SIDE).map(|i| aim(pixel(i))).collect();
    let mut rng = SmallRng::seed_from_u64(1);
    let (mut diffuse, mut shadow) = (Vec::new(), Vec::new());
    let lamp = Vec3::new(3.0, 5.0, 9.0);
    for ray in &primary {
        let Some(hit) = tree.closest_hit(ray, |_, _| None) else { continue };
        let caustica::accel::PrimitiveIndex::Triangle(i) = hit.primitive else { continue };
        let [a, b, c] = triangles[i as usize];
        let normal = (b - a).cross(c - a).normalize();
        let normal = if normal.dot(ray.direction) < 0.0 { normal } else { -normal };
        let origin = ray.at(hit.t) + normal * 1e-4;
        let out = Frame::from_normal(normal)
            .to_world(warp::square_to_cosine_hemisphere(Vec2::new(rng.random(), rng.random())));
        diffuse.push(Ray::new(origin, out));
        shadow.push(Ray::between_points(origin, lamp));
    }
    Scene { tree, primary, diffuse, shadow }
});

fn closest(bencher: Bencher, tree: &Bvh, rays: &[Ray]) {
    let count = |r: &&Ray| tree.closest_hit(r, |_, _| None).is_some();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| rays.iter().filter(count).count());
}

#[divan::bench]
fn primary(bencher: Bencher) {
    closest(bencher, &SCENE.tree, &SCENE.primary);
}

#[divan::bench]
fn diffuse(bencher: Bencher) {
    closest(bencher, &SCENE.tree, &SCENE.diffuse);
}

#[divan::bench]
fn shadow(bencher: Bencher) {
    let count = |r: &&Ray| SCENE.tree.occluded(r, |_, _| false);
    let rays = &SCENE.shadow;
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| rays.iter().filter(count).count());
}

/// Traces rays through a Cornell box: ten triangles and two spheres.
#[divan::bench]
fn cornell(bencher: Bencher) {
    let room = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }.corners();
    let quads = [[0, 1, 3, 2], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [4, 6, 7, 5]];
    let walls: Vec<[Vec3; 3]> =
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(|i: usize| room[i])).collect();
    let balls = [Vec3::new(-0.4, -0.65, 0.3), Vec3::new(0.4, -0.65, -0.3)];
    let boxes = balls.map(|c| Bounds { min: c, max: c }.expanded(0.35));
    let tree = Bvh::build(&walls, &boxes);
    let mut rng = SmallRng::seed_from_u64(2);
    let uniform = |rng: &mut SmallRng| Vec3::new(rng.random(), rng.random(), rng.random()) * 1.9 - 0.95;
    let rays: Vec<Ray> = (0..10_000)
        .map(|_| Ray::new(uniform(&mut rng), warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random()))))
        .collect();
    let ball = |i: u32, ray: &Ray| {
        let o = ray.origin - balls[i as usize];
        let (b, c) = (o.dot(ray.direction), o.length_squared() - 0.35 * 0.35);
        let root = (b * b - c).sqrt();
        [-b - root, -b + root]
            .into_iter()
            .find(|&t| t > 0.0 && t < ray.t_max)
            .map(|t| ShapeHit { t, shape_coords: Vec2::ZERO })
    };
    let count = |r: &&Ray| tree.closest_hit(r, ball).is_some();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| rays.iter().filter(count).count());
}

/// Builds a hierarchy over a million triangles.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn build(bencher: Bencher) {
    let triangles = knot(2500, 200);
    bencher.counter(ItemsCount::new(triangles.len())).bench_local(|| Bvh::build(&triangles, &[]));
}
