use super::*;
use crate::math::warp;
use crate::sampling::{Dimension, Key, Purpose};
use glam::Vec3;

fn random_key(i: u64) -> Key {
    Key::new(11).purpose_key(Purpose::Test).child_key(i)
}

/// Pseudorandom point `i` of the unit cube.
fn random_point_in_unit_cube(i: u64) -> Vec3 {
    random_key(i).uniform_2d(Dimension::LightPosition).extend(random_key(i).uniform_1d(Dimension::Light))
}

/// Indices of all boxes that [`BoxTree`] finds along `ray`.
fn boxes_along_ray(boxes: &BoxTree, ray: &Ray) -> Vec<u32> {
    let mut all = Vec::new();
    boxes.visit_boxes_along_ray(ray, &mut |i| all.push(i));
    all
}

/// True if `ray`, from t = 0 to `t_max`, crosses the box, up to rounding in f64.
fn segment_crosses_box(b: &Bounds, ray: &Ray) -> bool {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
    let (mut near, mut far) = (0.0f64, f64::from(ray.t_max));
    for axis in 0..3 {
        if d[axis] == 0.0 {
            if o[axis] < min[axis] || o[axis] > max[axis] {
                return false;
            }
        } else {
            let (a, b) = ((min[axis] - o[axis]) / d[axis], (max[axis] - o[axis]) / d[axis]);
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
    }
    near <= far
}

/// Asserts that a [`BoxTree`] finds each crossed box exactly once, for each of the `rays`.
///
/// Returns the number of boxes found. A ray may miss a found box by at most 10⁻⁵ of the largest
/// coordinate.
fn assert_box_queries_agree_with_brute_force(bounds: &[Bounds], rays: impl Iterator<Item = Ray>) -> usize {
    let boxes = BoxTree::build(bounds);
    let size =
        bounds.iter().filter(|b| !b.is_empty()).fold(0f32, |s, b| s.max(b.min.abs().max(b.max.abs()).max_element()));
    let mut count = 0;
    for ray in rays {
        let mut all = boxes_along_ray(&boxes, &ray);
        all.sort_unstable();
        assert!(all.windows(2).all(|w| w[0] < w[1]), "a box was found twice");
        let margin = 1e-5 * size.max(ray.origin.abs().max_element());
        for (i, b) in bounds.iter().enumerate() {
            let is_found = all.binary_search(&(i as u32)).is_ok();
            let empty = b.is_empty();
            assert!(is_found || empty || !segment_crosses_box(b, &ray), "lost {i}: {b:?} on {ray:?}");
            assert!(
                !is_found || !empty && segment_crosses_box(&b.expanded(margin), &ray),
                "{i} was found: {b:?} on {ray:?}"
            );
        }
        count += all.len();
    }
    count
}

/// Rays through points of the unit cube, which is scaled by `scale` and then moved by `shift`.
///
/// Rays start inside, outside or far away, and are long or short.
fn cube_test_rays(n: u64, scale: f32, shift: Vec3) -> impl Iterator<Item = Ray> {
    (0..n).map(move |i| {
        let i = i + 1_000_000;
        let target = random_point_in_unit_cube(i);
        let direction = match i % 3 {
            0 => [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z][i as usize / 3 % 6],
            _ => warp::square_to_uniform_sphere(random_key(i).uniform_2d(Dimension::LightDirection)),
        };
        let origin = target - direction * [0.1, 3.0, 100.0][i as usize / 18 % 3];
        let t_max = [f32::INFINITY, 3.2 * scale, 0.05 * scale][i as usize / 54 % 3];
        Ray { origin: origin * scale + shift, direction, t_max }
    })
}

#[test]
fn box_queries_agree_with_brute_force() {
    // Most numbers of boxes are near powers of 8, where the tree gets one more level.
    for n in [0, 1, 2, 7, 8, 9, 64, 65, 513, 2000] {
        for (scale, shift) in [(1.0, Vec3::ZERO), (1e-25, Vec3::ZERO), (1e15, Vec3::ZERO), (1.0, Vec3::splat(-3e3))] {
            let bounds: Vec<Bounds> = (0..n)
                .map(|i| {
                    let size = random_point_in_unit_cube(i + 50_000) * [0.02, 0.3, 0.0][i as usize % 3];
                    Bounds {
                        min: random_point_in_unit_cube(i) * scale + shift,
                        max: (random_point_in_unit_cube(i) + size) * scale + shift,
                    }
                })
                .collect();
            let count = assert_box_queries_agree_with_brute_force(&bounds, cube_test_rays(300, scale, shift));
            assert!(count > 0 || n < 64, "{n} {scale}");
        }
    }
}

/// Rays in the planes of flat boxes, along their edges and through point-like boxes find the boxes.
#[test]
fn flat_boxes_are_found_by_rays_along_them() {
    let at = |i: u32| [-1.0, 0.0, 1.0, 1e-3, -0.0][i as usize % 5];
    let corner = |i: u32| Vec3::new(at(i), at(i / 5), at(i / 25));
    let flat = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let bounds: Vec<Bounds> =
        (0..1000).map(|i| Bounds { min: corner(i % 125), max: corner(i % 125) + flat(i / 125) }).collect();
    let ways = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.6, -0.0, 0.8)];
    let rays = (0..125).flat_map(|i| ways.map(|d| Ray::new(corner(i) - d * 1e6, d)));
    let count = assert_box_queries_agree_with_brute_force(
        &bounds,
        rays.chain((0..125).flat_map(|i| ways.map(|d| Ray::new(corner(i) - d * 5.0, d)))),
    );
    assert!(count > 1000, "{count}");
}

#[test]
fn empty_boxes_and_invalid_rays_have_no_hits() {
    let whole = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    let nothing = Bounds { min: Vec3::NAN, max: Vec3::ONE };
    let boxes = BoxTree::build(&[Bounds::EMPTY, whole, nothing]);
    let ray = Ray::new(Vec3::splat(0.5), Vec3::X);
    assert_eq!(boxes_along_ray(&boxes, &ray), [1]);
    for t_max in [-1.0, f32::NAN] {
        assert!(boxes_along_ray(&boxes, &Ray { t_max, ..ray }).is_empty());
    }
    for useless in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        assert!(boxes_along_ray(&boxes, &Ray { direction: useless, ..ray }).is_empty());
    }
    assert!(boxes_along_ray(&boxes, &Ray { origin: Vec3::NAN, ..ray }).is_empty());
    assert!(boxes_along_ray(&BoxTree::build(&[Bounds::EMPTY]), &ray).is_empty());
}

#[test]
fn a_hundred_thousand_equal_boxes_are_all_found() {
    let b = Bounds { min: Vec3::splat(0.25), max: Vec3::splat(0.5) };
    let boxes = BoxTree::build(&vec![b; 100_000]);
    let mut all = boxes_along_ray(&boxes, &Ray::new(Vec3::new(0.3, 0.3, -1.0), Vec3::Z));
    all.sort_unstable();
    assert!(all.iter().copied().eq(0..100_000));
    assert!(boxes_along_ray(&boxes, &Ray::new(Vec3::new(0.6, 0.3, -1.0), Vec3::Z)).is_empty());
}

#[test]
fn box_trees_are_equal_for_any_thread_count() {
    let bounds: Vec<Bounds> = (0..20_000)
        .map(|i| Bounds { min: random_point_in_unit_cube(i % 7000), max: random_point_in_unit_cube(i % 7000) + 0.1 })
        .collect();
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let boxes = pool.install(|| BoxTree::build(&bounds));
        cube_test_rays(50, 1.0, Vec3::ZERO).map(|ray| boxes_along_ray(&boxes, &ray)).collect::<Vec<_>>()
    };
    assert_eq!(with(1), with(3));
}
