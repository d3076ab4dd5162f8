//! Shading normals perturbed by textures: bump maps and normal maps.

use super::TextureFootprint;
use crate::math::Frame;
use crate::shape::{SurfacePoint, TexCoord};
use crate::texture::Texture;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Least cosine between perturbed shading normal and geometric normal. A shading normal with a
/// smaller cosine is turned back until it has this one.
const MIN_SHADING_NORMAL_COSINE: f32 = 0.05;

/// The way in which a material perturbs shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalPerturbation {
    /// Shading normals are not perturbed.
    None,
    /// A bump map: a texture of heights (Blinn 1978, "Simulation of Wrinkled Surfaces").
    BumpMap {
        /// Index of the height texture.
        texture: u32,
        /// Height \[length] of the displaced surface where the texture has the value 1.
        height: f32,
    },
    /// A normal map in tangent space; holds the index of its texture.
    ///
    /// Red points along increasing u, green along increasing v, blue outwards. Channel values in
    /// \[0, 1] map to \[−1, 1].
    NormalMap(u32),
}

/// Returns the unit shading normal at `point`, perturbed by `perturbation`.
///
/// A perturbed normal that tilts too far is turned back until its cosine with the geometric normal
/// is [`MIN_SHADING_NORMAL_COSINE`]. `width` is the diameter of the texture filter footprint
/// \[length].
pub(in crate::scene) fn perturbed_normal(
    perturbation: NormalPerturbation,
    textures: &[Arc<Texture>],
    point: &SurfacePoint,
    footprint: &TextureFootprint<'_>,
    width: f64,
) -> Vec3 {
    let n = point.ns.as_dvec3();
    let perturbed = match perturbation {
        NormalPerturbation::None => return point.ns,
        NormalPerturbation::BumpMap { texture, height } => {
            let texture = &*textures[texture as usize];
            let frame = Frame::from_normal(point.ns);
            let slope = |direction: Vec3| {
                let direction = direction.as_dvec3();
                let step = direction * footprint.bump_map_step(texture, direction, width);
                let value =
                    |step: DVec3| f64::from(texture.evaluate_scalar(&footprint.displaced_texture_context(step)));
                let slope = f64::from(height) * (value(step) - value(-step)) / (2.0 * step.length());
                if slope.is_finite() { direction * slope } else { DVec3::ZERO }
            };
            // Normal (not normalized) of the displaced surface p + h(p)·n, by the gradient of the
            // height h along the surface.
            n - slope(frame.s) - slope(frame.t)
        }
        NormalPerturbation::NormalMap(texture) => {
            let color = textures[texture as usize].evaluate_color(&footprint.context);
            let [x, y, z] = (color.as_dvec3() * 2.0 - 1.0).to_array();
            match texture_tangents(&footprint.coords, n) {
                Some([u, v]) => u * x + v * y + n * z,
                None => n,
            }
        }
    };
    let (ns, ng) = (perturbed.try_normalize().unwrap_or(n).as_vec3(), point.ng);
    let cos = ns.dot(ng);
    if cos >= MIN_SHADING_NORMAL_COSINE {
        return ns;
    }
    // Keep the direction in which `ns` is tilted, and limit the tilt.
    let along = (ns - ng * cos).normalize_or_zero();
    (along * (1.0 - MIN_SHADING_NORMAL_COSINE * MIN_SHADING_NORMAL_COSINE).sqrt() + ng * MIN_SHADING_NORMAL_COSINE)
        .normalize()
}

/// Returns two unit tangents that follow the texture coordinates (u, v) along the surface. They are
/// perpendicular to `n` and to each other.
///
/// The first tangent points along increasing u at constant v. The second points towards increasing
/// v. Returns `None` if v is constant along the surface.
fn texture_tangents(coords: &TexCoord, n: DVec3) -> Option<[DVec3; 2]> {
    let across = coords.grad_v.cross(n).try_normalize()?;
    let u = if across.dot(coords.grad_u) < 0.0 { -across } else { across };
    let v = n.cross(u);
    Some([u, if v.dot(coords.grad_v) < 0.0 { -v } else { v }])
}
