//! The texture filter footprint of a ray cone on a surface.

use crate::scene::RayCone;
use crate::scene::geometry::{Geometry, Hit};
use crate::shape::{SurfacePoint, TexCoord, TextureMapping};
use crate::texture::{Texture, TextureEvalContext};
use glam::{DVec2, DVec3, Vec3};

/// Lower bound of the cosine between ray and normal when a footprint is computed. At grazing
/// angles, the footprint is thus at most 1000 times as long as wide.
const MIN_INCIDENCE_COSINE: f64 = 1e-3;

/// The footprint of a ray cone on a surface, with derivatives of the texture coordinates.
pub(in crate::scene) struct TextureFootprint<'a> {
    /// The point at which textures are looked up, with the axes of the filter ellipse.
    pub context: TextureEvalContext,
    pub coords: TexCoord,
    mapping: &'a TextureMapping,
}

impl<'a> TextureFootprint<'a> {
    /// The footprint of `cone` at `hit`: an ellipse on the surface.
    ///
    /// One axis is as long as the cone is wide. The other axis is longer by the factor 1/cos θ,
    /// where θ is the angle between ray and normal.
    pub fn new(
        geometry: &Geometry,
        mappings: &'a [TextureMapping],
        hit: &Hit,
        point: &SurfacePoint,
        wo: Vec3,
        cone: &RayCone,
    ) -> Self {
        let mapping = &mappings[geometry.object_attributes(hit.primitive).mapping as usize];
        let p = mapping.point_to_object_space(point.p);
        let coords = mapping.tex_coord_at(p, || geometry.surface_texture_coords(hit, point));
        let mut context = TextureEvalContext::unfiltered(coords.uv, p);
        let width = f64::from(cone.width());
        if width > 0.0 {
            let (wo, n) = (wo.as_dvec3(), point.ng.as_dvec3());
            let along = wo - n * wo.dot(n);
            // At normal incidence, any direction along the surface will do.
            let along = along.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
            let long = along * (width / wo.dot(n).abs().max(MIN_INCIDENCE_COSINE));
            let across = n.cross(along) * width;
            context.footprint_axes = [across, long].map(|x| DVec2::new(coords.grad_u.dot(x), coords.grad_v.dot(x)));
            let [a, b] = [across, long].map(|x| mapping.vector_to_object_space(x).length());
            context.footprint_width = (a * b).sqrt();
        }
        Self { context, coords, mapping }
    }

    /// Returns the texture lookup context at a point displaced by `step` along the surface.
    ///
    /// `step` is a world-space vector \[length].
    pub fn displaced_texture_context(&self, step: DVec3) -> TextureEvalContext {
        let uv = self.context.uv + DVec2::new(self.coords.grad_u.dot(step), self.coords.grad_v.dot(step));
        TextureEvalContext {
            uv,
            object_p: self.context.object_p + self.mapping.vector_to_object_space(step),
            ..self.context
        }
    }

    /// Length of the finite-difference step of a bump map along unit `direction` \[length].
    ///
    /// The step is [`Texture::finest_bump_step`] of `texture`, converted to a length on the
    /// surface. It is at least half of `width`, the diameter of the filter footprint \[length].
    pub fn bump_map_step(&self, texture: &Texture, direction: DVec3, width: f64) -> f64 {
        let change = if texture.is_solid_texture() {
            self.mapping.vector_to_object_space(direction).length()
        } else {
            libm::hypot(self.coords.grad_u.dot(direction), self.coords.grad_v.dot(direction))
        };
        let detail = if change > 0.0 { texture.finest_bump_step() / change } else { 0.0 };
        detail.max(0.5 * width)
    }
}
