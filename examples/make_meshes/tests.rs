//! Checks that mesh/ holds what the generators write, and that the meshes are valid.
//!
//! An independent reader, tobj, reads the text of each file.

use super::meshes;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};

/// A mesh as read: positions, triangles of indices into them, and a normal at each corner or none.
struct Read {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
    normals: Vec<[DVec3; 3]>,
}

fn load(name: &str) -> Read {
    let (_, make) = meshes::ALL.into_iter().find(|(n, _)| *n == name).unwrap();
    let mesh = make();
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let nothing = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut mesh.to_obj().as_bytes(), &options, nothing).unwrap();
    assert_eq!(models.len(), 1, "{name}");
    let data = &models[0].mesh;
    let points = |flat: &[f64]| -> Vec<DVec3> { flat.as_chunks().0.iter().map(|c| DVec3::from_array(*c)).collect() };
    let corners = |flat: &[u32]| -> Vec<[usize; 3]> {
        flat.as_chunks().0.iter().map(|c: &[u32; 3]| c.map(|i| i as usize)).collect()
    };
    let all_normals = points(&data.normals);
    let read = Read {
        positions: points(&data.positions),
        triangles: corners(&data.indices),
        normals: corners(&data.normal_indices).iter().map(|c| c.map(|i| all_normals[i])).collect(),
    };
    assert_eq!(read.triangles.len(), mesh.triangle_count(), "{name}");
    read
}

impl Read {
    fn corners(&self, triangle: [usize; 3]) -> [DVec3; 3] {
        triangle.map(|i| self.positions[i])
    }

    /// Returns the volume by the divergence theorem: a sixth of the sum of triple products.
    fn volume(&self) -> f64 {
        let six: f64 = self.triangles.iter().map(|&t| self.corners(t)).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        six / 6.0
    }
}

fn text(name: &str) -> String {
    let (_, make) = meshes::ALL.into_iter().find(|(n, _)| *n == name).unwrap();
    make().to_obj()
}

/// Returns the vectors of all lines with a keyword, in file order, which tobj does not keep.
fn vectors(text: &str, keyword: &str) -> Vec<DVec3> {
    let lines = text.lines().filter_map(|line| line.strip_prefix(keyword));
    let numbers = |line: &str| line.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
    lines.map(|line| DVec3::from_slice(&numbers(line))).collect()
}

/// Returns the fraction of a circle's area that an inscribed polygon of n sides covers.
fn inscribed(n: f64) -> f64 {
    n / TAU * libm::sin(TAU / n)
}

fn names() -> impl Iterator<Item = &'static str> {
    meshes::ALL.into_iter().map(|(name, _)| name)
}

#[test]
fn stored_meshes_match_their_generators() {
    let mut total = 0;
    for (name, make) in meshes::ALL {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mesh").join(name);
        let text = fs::read_to_string(&path).unwrap_or_default();
        assert!(text == make().to_obj(), "{name} is not what the program makes: run the example make_meshes");
        assert!(text.len() < 1_500_000, "{name} is too large");
        total += text.len();
    }
    assert!(total < 5_000_000, "{total} bytes in all");
}

#[test]
fn meshes_are_closed_with_consistent_winding() {
    for name in names() {
        let mesh = load(name);
        let mut edges = HashSet::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                assert!(edges.insert((t[k], t[(k + 1) % 3])), "{name}: two triangles run along {:?} one way", t);
            }
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{name} has a hole");
        let used: HashSet<_> = mesh.triangles.iter().flatten().collect();
        assert_eq!(used.len(), mesh.positions.len(), "{name} has idle positions");
        let places: HashSet<_> = mesh.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        assert_eq!(places.len(), mesh.positions.len(), "{name} has positions twice");

        // Euler characteristic: 2 for a ball, 0 for a torus. Two bodies or a tunnel would give
        // another number.
        let euler = mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64;
        let expected = if ["knot.obj", "ring.obj"].contains(&name) { 0 } else { 2 };
        assert_eq!(euler, expected, "{name}");
        assert!(mesh.volume() > 0.0, "{name} is inside out");
    }
}

#[test]
fn normals_are_unit_and_point_outward() {
    for name in names() {
        let mesh = load(name);
        assert_eq!(mesh.normals.is_empty(), ["brilliant.obj", "gem.obj"].contains(&name), "{name}");
        for (&triangle, normals) in mesh.triangles.iter().zip(&mesh.normals) {
            let [a, b, c] = mesh.corners(triangle);
            let face = (b - a).cross(c - a);
            assert!(face.length() > 1e-8, "{name}: a triangle without area at {a}");
            for n in normals {
                // Four digits round each coordinate by at most ½·10⁻⁴.
                assert!((n.length() - 1.0).abs() < 0.5e-4 * f64::sqrt(3.0), "{name}: {n}");
                // Adjacent triangles of a smooth part differ by at most 45°.
                assert!(n.dot(face.normalize()) > libm::cos(FRAC_PI_4), "{name}: {n} on {face} at {a} {b} {c}");
            }
        }
    }
}

#[test]
fn normals_follow_the_surface() {
    for name in names() {
        let text = text(name);
        let (positions, normals) = (vectors(&text, "v "), vectors(&text, "vn "));
        for face in text.lines().filter_map(|line| line.strip_prefix("f ")) {
            let corners = face.split(' ').filter_map(|corner| corner.split_once("//"));
            let index = |i: &str| i.parse::<usize>().unwrap() - 1;
            let (p, n): (Vec<_>, Vec<_>) = corners.map(|(p, n)| (positions[index(p)], normals[index(n)])).unzip();
            if let [a, b, c, d] = p[..] {
                // A quad turns by at most .35 rad (20°), and its middle deviates in second order,
                // .35²/8.
                let (plane, mean) = ((c - a).cross(d - b), n.iter().sum::<DVec3>());
                assert!(plane.angle_between(mean) < 0.35 * 0.35 / 8.0, "{name}: {mean} on {plane} at {a}");
            }
        }
    }
}

#[test]
fn meshes_fill_their_stated_bounds() {
    let table = f64::from(3) / 100.0 + 0.47 * libm::tan(34.5_f64.to_radians());
    let culet = -0.03 - libm::tan(40.75_f64.to_radians());
    let cap = 0.02 + 2.5 - f64::sqrt(2.5 * 2.5 - 1.0);
    let boxes = HashMap::from([
        ("brilliant.obj", [-1.0, culet, -1.0, 1.0, table, 1.0]),
        ("gem.obj", [-1.0, culet, -1.0, 1.0, table, 1.0]),
        ("goblet.obj", [-0.58, 0.0, -0.58, 0.58, 2.0, 0.58]),
        ("knot.obj", [-0.82, -0.42, -0.94, 0.98, 0.42, 0.94]),
        ("lens.obj", [-1.0, -cap, -1.0, 1.0, cap, 1.0]),
        ("pool.obj", [-1.0, 0.0, -1.0, 1.0, 0.54, 1.0]),
        ("ring.obj", [-1.08, 0.0, -1.08, 1.08, 0.8, 1.08]),
        ("vase.obj", [-0.54, 0.0, -0.54, 0.54, 1.82, 0.54]),
        ("wine.obj", [-0.525, 0.935, -0.525, 0.525, 1.36, 0.525]),
    ]);
    for name in names() {
        let mesh = load(name);
        let (low, high) = mesh.positions.iter().fold((DVec3::MAX, DVec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
        let [x0, y0, z0, x1, y1, z1] = boxes[name];
        let (least, most) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
        let slack = 1e-6;
        assert!(low.cmpge(least - slack).all() && high.cmple(most + slack).all(), "{name}: {low} {high}");
        // Vertices miss the extremes of ripples and knots by at most one step of the mesh.
        assert!((low - least).max_element() < 0.03 && (most - high).max_element() < 0.03, "{name}: {low} {high}");
        assert!((low.y - y0).abs() < 0.005, "{name} starts at {}", low.y);
    }
}

#[test]
fn mesh_volumes_match_closed_form() {
    // Band: Pappus for a rectangle with each rounded edge a polygon of two chords.
    let (e, chord) = (0.02, FRAC_PI_4);
    let area = 0.08 * 0.8 - (4.0 - PI) * e * e - 4.0 * e * e * (chord - libm::sin(chord));
    let band = TAU * 1.04 * area * inscribed(512.0);
    assert!((load("ring.obj").volume() / band - 1.0).abs() < 1e-5);

    // Lens: two caps and the rim. Chords of the arcs lose at most their sagitta over both caps.
    let cap = 2.5 - f64::sqrt(2.5 * 2.5 - 1.0);
    let lens = 2.0 * PI * cap * cap * (7.5 - cap) / 3.0 + PI * 0.04;
    let step = libm::asin(0.4) / 22.0;
    let sagitta = 2.5 * (1.0 - libm::cos(step / 2.0));
    let volume = load("lens.obj").volume();
    assert!(volume < lens && volume > lens * inscribed(120.0) - 2.0 * TAU * 2.5 * cap * sagitta, "{volume} {lens}");

    // Pool: waves change the volume by at most their amplitudes over the area of 4.
    assert!((load("pool.obj").volume() - 2.0).abs() < 4.0 * 0.04);

    // Knot: πr² times the length of its axis. Diagonals of the twisted mesh span at most .205 rad
    // of the tube and lose .205²/6. The axis bends by at most .06 rad a step and loses .06²/8.
    let centres = knot_centres();
    let length: f64 = (0..320).map(|i| centres[i].distance(centres[(i + 1) % 320])).sum();
    let ratio = load("knot.obj").volume() / (PI * 0.16 * 0.16 * length);
    assert!(ratio < 1.0 && ratio > 1.0 - 0.205 * 0.205 / 6.0 - 0.06 * 0.06 / 8.0, "{ratio}");
}

fn knot_centres() -> Vec<DVec3> {
    vectors(&text("knot.obj"), "v ").chunks_exact(40).map(|ring| ring.iter().sum::<DVec3>() / 40.0).collect()
}

#[test]
fn knot_strands_do_not_touch() {
    let centres = knot_centres();
    for i in 0..320_usize {
        for j in 0..i {
            // Within 20 steps along the knot it is the same strand.
            let steps = (i - j).min(320 + j - i);
            let distance = centres[i].distance(centres[j]);
            assert!(steps <= 20 || distance > 2.0 * 0.16 + 0.05, "rings {i} and {j} are {distance} apart");
        }
    }
}

#[test]
fn gem_is_convex_with_57_facets() {
    let mesh = load("gem.obj");
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle);
        let n = (b - a).cross(c - a).normalize();
        for p in &mesh.positions {
            // Nine digits, and facets no thinner than .01.
            assert!(n.dot(*p - a) < 1e-6, "{p} lies outside of a facet at {a}");
        }
        if !planes.iter().any(|(m, _)| m.dot(n) > 1.0 - 1e-9) {
            planes.push((n, n.dot(a)));
        }
    }
    assert_eq!(planes.len(), 57 + 96);
    assert_eq!(planes.iter().filter(|(n, _)| n.y.abs() < 1e-6).count(), 96);
    assert_eq!(planes.iter().filter(|(n, _)| n.y < -1e-6).count(), 24);
}

/// Returns the positions in the half-plane z = 0, x ≥ 0, one of each ring.
fn outline(name: &str) -> Vec<DVec2> {
    let half_plane = vectors(&text(name), "v ").into_iter().filter(|p| p.z == 0.0 && p.x >= 0.0);
    half_plane.map(|p| DVec2::new(p.x, p.y)).collect()
}

#[test]
fn wine_fills_glass_without_touching() {
    let (glass, wine) = (outline("goblet.obj"), outline("wine.obj"));
    // A polygon of 112 sides comes nearer than the wall's circle by .53 (1 - cos(π/112)) = .0002.
    // The wine's polygon is inside its own circle.
    let distance = |p: DVec2, a: DVec2, b: DVec2| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, along))
    };
    // The last one is the center of the surface.
    for p in &wine[..wine.len() - 1] {
        let least = glass.windows(2).map(|w| distance(*p, w[0], w[1])).fold(f64::MAX, f64::min);
        assert!(least > 0.001 && least < 0.008, "{p} is {least} from the glass");
        assert!(p.y > 0.9, "{p} is not in the bowl");
    }
}

#[test]
fn walls_do_not_cross() {
    for name in ["goblet.obj", "vase.obj", "ring.obj", "lens.obj"] {
        let outline = outline(name);
        assert!(outline.len() > 10, "{name}");
        let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
        for i in 1..outline.len() {
            for j in i + 2..outline.len() {
                let (a, b, c, d) = (outline[i - 1], outline[i], outline[j - 1], outline[j]);
                let crossing = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
                assert!(!crossing, "{name}: the wall crosses itself near {a}");
            }
        }
    }
}
