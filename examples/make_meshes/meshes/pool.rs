//! A block of water with waves on top.

use glam::DVec3;

use super::mesh::Mesh;

const CELLS: usize = 90;
const DEPTH: f64 = 0.5;
/// Waves: amplitude, wave numbers along x and z, phase.
///
/// A crest of curvature κ focuses light from above n / ((n - 1) κ) below it, 4 / κ in water.
/// Curvatures, sums of amplitude times squared wave number, reach 11, so foci lie on both sides of
/// the floor.
const WAVES: [(f64, f64, f64, f64); 5] = [
    (0.0120, 7.1, 5.2, 0.4),
    (0.0100, -8.8, 11.1, 1.9),
    (0.0075, 16.9, 6.0, 3.1),
    (0.0060, 5.5, -20.6, 5.2),
    (0.0045, -24.2, -13.6, 0.9),
];

/// Maps a number of cells along a side to the grid position of a vertex.
type Side = fn(usize) -> (usize, usize);

/// Returns the block: x and z in [-1, 1], bottom at y = 0, waves about y = 0.5.
pub fn pool() -> Mesh {
    let mut mesh = Mesh::new("Block of water with waves", 5, 5);
    let coordinate = |i: usize| -1.0 + 2.0 * i as f64 / CELLS as f64;
    let mut top = Vec::new();
    for k in 0..=CELLS {
        for i in 0..=CELLS {
            let (height, normal) = surface(coordinate(i), coordinate(k));
            let position = mesh.position(DVec3::new(coordinate(i), height, coordinate(k)));
            top.push((position, mesh.normal(normal)));
        }
    }
    let at = |i: usize, k: usize| top[k * (CELLS + 1) + i];
    for k in 0..CELLS {
        for i in 0..CELLS {
            mesh.smooth_face(&[at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)]);
        }
    }

    // The border of the top, side by side in one turn: -z, +x, +z, -x.
    let sides: [(DVec3, Side); 4] = [
        (DVec3::NEG_Z, |s| (s, 0)),
        (DVec3::X, |s| (CELLS, s)),
        (DVec3::Z, |s| (CELLS - s, CELLS)),
        (DVec3::NEG_X, |s| (0, CELLS - s)),
    ];
    let mut floor = Vec::new();
    for (_, grid) in sides {
        for s in 0..CELLS {
            let (i, k) = grid(s);
            floor.push(mesh.position(DVec3::new(coordinate(i), 0.0, coordinate(k))));
        }
    }
    let down = mesh.normal(DVec3::NEG_Y);
    let middle = mesh.position(DVec3::ZERO);
    for (side, (outward, grid)) in sides.into_iter().enumerate() {
        let n = mesh.normal(outward);
        for s in 0..CELLS {
            let ((i0, k0), (i1, k1)) = (grid(s), grid(s + 1));
            let (low, next) = (floor[side * CELLS + s], floor[(side * CELLS + s + 1) % floor.len()]);
            mesh.smooth_face(&[(low, n), (at(i0, k0).0, n), (at(i1, k1).0, n), (next, n)]);
            mesh.smooth_face(&[(middle, down), (low, down), (next, down)]);
        }
    }
    mesh
}

/// Returns the water's height at (x, z) and its upward normal.
fn surface(x: f64, z: f64) -> (f64, DVec3) {
    let (mut height, mut normal) = (DEPTH, DVec3::Y);
    for (amplitude, kx, kz, phase) in WAVES {
        let (sin, cos) = libm::sincos(kx * x + kz * z + phase);
        height += amplitude * sin;
        normal -= DVec3::new(kx, 0.0, kz) * (amplitude * cos);
    }
    (height, normal)
}
