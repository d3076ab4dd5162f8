//! Ray cones, which give the footprint of a path for texture filtering.

use super::Effects;
use crate::bsdf::{Bsdf, DIFFUSE_CONE_SPREAD};

/// Width of the cone of a camera ray \[pixels]. It is below 1 because the pixel filter adds its own
/// blur.
const CAMERA_CONE_PIXELS: f32 = 0.5;

/// The cone around a ray over which textures are filtered (Amanatides 1984, "Ray tracing with
/// cones"; Akenine-Möller et al. 2021, "Improved shader and texture level of detail using ray
/// cones").
///
/// A camera path starts with half the width of a pixel. The cone grows with distance, and faster
/// after scattering. Light paths have no width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCone {
    /// Diameter of the cone \[length] at the point that the path has reached.
    width: f32,
    /// Growth of the cone's diameter per unit of distance along the ray.
    spread: f32,
    /// True if the cone widens along the path, as for camera paths. False for light paths, whose
    /// cones keep zero width.
    widens: bool,
    /// True if the path has been scattered by a medium or by a surface that is not specular.
    has_nonspecular_scattering: bool,
    /// The effects that the path simulates.
    pub effects: Effects,
}

impl RayCone {
    /// Creates the cone of a camera ray. `width` is the width of a pixel at the ray origin
    /// \[length], and `spread` its growth per unit of distance.
    #[inline]
    #[must_use]
    pub fn from_pixel_footprint((width, spread): (f32, f32), effects: Effects) -> Self {
        Self {
            width: width * CAMERA_CONE_PIXELS,
            spread: spread * CAMERA_CONE_PIXELS,
            widens: true,
            ..Self::zero_width_cone(effects)
        }
    }

    /// Creates a cone that has zero width and never widens, as for light paths.
    #[inline]
    #[must_use]
    pub const fn zero_width_cone(effects: Effects) -> Self {
        Self { width: 0.0, spread: 0.0, widens: false, has_nonspecular_scattering: false, effects }
    }

    /// Widens the cone as the ray travels over `distance` \[length].
    #[inline]
    pub fn widen_over_distance(&mut self, distance: f32) {
        self.width += self.spread * distance;
    }

    /// Adds the angular spread that scattering by `bsdf` causes, unless the cone keeps zero width.
    #[inline]
    pub(super) fn widen_at_surface(&mut self, bsdf: &Bsdf) {
        if self.widens {
            self.spread += bsdf.ray_cone_spread();
        }
        self.has_nonspecular_scattering |= !bsdf.is_specular();
    }

    /// Adds the angular spread that scattering in a medium causes, unless the cone keeps zero
    /// width.
    #[inline]
    pub(super) fn widen_in_medium(&mut self) {
        if self.widens {
            self.spread += DIFFUSE_CONE_SPREAD;
        }
        self.has_nonspecular_scattering = true;
    }

    /// Diameter of the cone \[length] at the point that the path has reached.
    #[inline]
    #[must_use]
    pub fn width(&self) -> f32 {
        self.width
    }

    /// Returns the cone over which emission textures are filtered.
    ///
    /// After a non-specular scattering event, its width is zero. Emission that a path hits then
    /// agrees with next-event estimation, which evaluates emission at a point.
    #[inline]
    pub(super) fn emission_texture_cone(&self) -> Self {
        if self.has_nonspecular_scattering { Self::zero_width_cone(self.effects) } else { *self }
    }
}
