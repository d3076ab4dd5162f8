//! Coverage of kernels in media: the part of a kernel that surfaces do not hide from its center.
//! Division by the coverage corrects boundary bias.

use super::coverage::MIN_COVERAGE;
use crate::math::{Frame, Ray};
use crate::scene::Scene;
use glam::Vec3;
use std::f32::consts::FRAC_1_SQRT_2;

/// Largest number of probe rays in a [`KernelProbes`]: a kernel in three dimensions needs 12.
/// Kernels in one or two dimensions need fewer.
const MAX_PROBES: usize = 12;

/// Probe rays that measure how much of a kernel in a medium is visible from its center. For each
/// probe ray, the distance to the first surface within the kernel's radius is stored; infinity if
/// there is none.
///
/// Kernels of volumetric density estimates have one, two or three dimensions. The probe rays lie on
/// the line, in the plane or in the space of the kernel.
#[derive(Clone, Copy, Debug)]
pub struct KernelProbes {
    distances: [f32; MAX_PROBES],
    count: usize,
    dimensions: u32,
}

impl KernelProbes {
    /// Traces probe rays of length `radius` \[length] from the kernel's center, which is the origin
    /// of `towards`. The first probe ray has the direction of `towards`.
    ///
    /// A kernel in `dimensions` dimensions has these probe rays:
    /// - One: two rays in opposite directions; `axis` is not used.
    /// - Two: eight rays at equal angles about the unit vector `axis`, which is perpendicular to
    ///   `towards`.
    /// - Three: twelve rays to the corners of an icosahedron; `axis` is not used.
    #[must_use]
    pub fn trace(scene: &Scene, towards: &Ray, axis: Vec3, dimensions: u32, radius: f32) -> Self {
        let mut probes = Self { distances: [f32::INFINITY; MAX_PROBES], count: 0, dimensions };
        let mut trace = |direction| {
            let ray = Ray { t_max: radius, ..Ray::new(towards.origin, direction) };
            probes.distances[probes.count] = scene.intersect(&ray).map_or(f32::INFINITY, |hit| hit.t);
            probes.count += 1;
        };
        let first = towards.direction;
        match dimensions {
            1 => [first, -first].into_iter().for_each(&mut trace),
            2 => {
                let second = axis.cross(first);
                let diagonals = [(first + second) * FRAC_1_SQRT_2, (first - second) * FRAC_1_SQRT_2];
                [first, second, diagonals[0], diagonals[1]]
                    .into_iter()
                    .for_each(|v| [v, -v].into_iter().for_each(&mut trace));
            }
            _ => icosahedron_diagonal_directions(first)
                .into_iter()
                .for_each(|v| [v, -v].into_iter().for_each(&mut trace)),
        }
        probes
    }

    /// True if no surface lies within `distance` \[length] of the kernel's center along the first
    /// probe ray. If this ray points at a photon, the result tells if the photon is visible from
    /// the center.
    #[must_use]
    pub fn first_probe_is_clear(&self, distance: f32) -> bool {
        self.distances[0] > distance
    }

    /// Returns the fraction of the kernel's integral that is visible from the kernel's center, but
    /// at least 1/20.
    ///
    /// The kernel has the radius `radius` \[length]. The fraction is a mean over the probe rays,
    /// and exactly 1 if none of them hits a surface within `radius`.
    #[must_use]
    pub fn visible_fraction(&self, radius: f32) -> f32 {
        let parts = self.distances[..self.count].iter().map(|d| kernel_fraction_within(d / radius, self.dimensions));
        (parts.sum::<f32>() / self.count as f32).max(MIN_COVERAGE)
    }
}

/// Returns the fraction of a kernel's integral that lies within the distance `x`·r of its center,
/// where r is the kernel's radius and `x` ≥ 0.
///
/// Kernels in one and three `dimensions` are proportional to 1 − x², kernels in two to (1 − x²)².
fn kernel_fraction_within(x: f32, dimensions: u32) -> f32 {
    let x = x.min(1.0);
    let x2 = x * x;
    match dimensions {
        1 => 0.5 * x * (3.0 - x2),
        2 => x2 * (3.0 - x2 * (3.0 - x2)),
        _ => 0.5 * x * x2 * (5.0 - 3.0 * x2),
    }
}

/// Returns unit vectors from the center of a regular icosahedron to six of its twelve corners, one
/// of each opposite pair. The first vector is `first`.
fn icosahedron_diagonal_directions(first: Vec3) -> [Vec3; 6] {
    // cos 72°, sin 72°, cos 144° and sin 144°.
    const TURNS: [(f32, f32); 5] = [
        (1.0, 0.0),
        (0.309_017, 0.951_056_5),
        (-0.809_017, 0.587_785_25),
        (-0.809_017, -0.587_785_25),
        (0.309_017, -0.951_056_5),
    ];
    // 1/√5 and 2/√5.
    let (up, out) = (0.447_213_6, 0.894_427_2);
    let frame = Frame::from_normal(first);
    let ring = TURNS.map(|(cos, sin)| first * up + (frame.s * cos + frame.t * sin) * out);
    [first, ring[0], ring[1], ring[2], ring[3], ring[4]]
}
