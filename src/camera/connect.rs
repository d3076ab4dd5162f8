//! Connections from points of the scene to the film, for light tracing.

use super::{Camera, CameraProjection};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Connection of a scene point to the camera: the camera ray through the point, its film position,
/// and its importance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraConnection {
    /// Film position \[pixels from the top left]; may lie outside the film.
    pub film_position: Vec2,
    /// Origin of the camera ray through the scene point.
    pub ray_origin: Vec3,
    /// Unit direction from the scene point to `ray_origin`.
    pub direction_to_camera: Vec3,
    /// Film area \[pixels²] per scene area \[length²] at the scene point. The scene area is
    /// measured perpendicular to `direction_to_camera`.
    pub importance: f32,
}

impl Camera {
    /// Connects the world-space point `p` to the camera; `None` if `p` is behind or at the camera.
    ///
    /// The result is also `None` if the importance is not finite, as at the poles of a panorama.
    ///
    /// `lens` in \[0, 1)² samples a point of the lens, as in [`Camera::generate_ray`]; `None` is
    /// the lens center. The connection is the camera ray from this lens point through `p`. Pixels
    /// average radiance over the film without a cosine. The importance is therefore the Jacobian
    /// alone: film area per scene area (Veach 1997, section 8.3.2).
    #[must_use]
    pub fn connect_to_point(&self, p: Vec3, lens: Option<Vec2>) -> Option<CameraConnection> {
        let p = p.as_dvec3();
        match self.projection {
            CameraProjection::Perspective(thin) => {
                let (offset, focus) = match (thin, lens) {
                    (Some(thin), Some(u)) => {
                        let on_lens = thin.sample(u) / self.pixel_size;
                        (self.pixel_right * on_lens.x + self.pixel_up * on_lens.y, thin.focus_distance)
                    }
                    _ => (DVec3::ZERO, 1.0),
                };
                let to_point = p - self.center - offset;
                let depth = to_point.dot(self.forward);
                if depth <= 0.0 {
                    return None;
                }
                let in_focus = offset + to_point * (focus / depth);
                let distance = to_point.length();
                // A pixel spans the solid angle pixel_size²·cos³θ, where cos θ is depth over
                // distance.
                let importance = distance / (self.pixel_size * self.pixel_size * depth * depth * depth);
                self.connection_from_ray_origin(
                    self.film_offset_from_center(in_focus / focus),
                    self.center + offset,
                    p,
                    importance,
                )
            }
            CameraProjection::Orthographic => {
                let to_point = p - self.center;
                let depth = to_point.dot(self.forward);
                if depth <= 0.0 {
                    return None;
                }
                let importance = 1.0 / (self.pixel_size * self.pixel_size);
                self.connection_from_ray_origin(
                    self.film_offset_from_center(to_point),
                    p - self.forward * depth,
                    p,
                    importance,
                )
            }
            CameraProjection::Panorama => {
                let to_point = p - self.center;
                let distance = to_point.length();
                let (right, up, forward) =
                    (to_point.dot(self.pixel_right), to_point.dot(self.pixel_up), to_point.dot(self.forward));
                let level = right.hypot(forward);
                let (width, height) = (f64::from(self.width), f64::from(self.height));
                let offset =
                    DVec2::new(libm::atan2(right, forward) * width / TAU, libm::atan2(up, level) * height / PI);
                // A pixel spans the solid angle (2π/width)·(π/height)·cos(latitude).
                let importance = width * height / (TAU * PI * distance * level);
                self.connection_from_ray_origin(offset, self.center, p, importance)
            }
        }
    }

    /// Returns the motion vector on the film \[pixels to the right and down]: from the film
    /// position of point `p` in this camera to the film position of point `q` in the camera
    /// `later`.
    ///
    /// A lens counts as a pinhole. In a panorama, the motion vector takes the shorter way around.
    /// Returns `None` if a camera does not connect to its point; see [`Camera::connect_to_point`].
    #[must_use]
    pub fn film_displacement(&self, p: Vec3, later: &Self, q: Vec3) -> Option<Vec2> {
        let mut by = later.connect_to_point(q, None)?.film_position - self.connect_to_point(p, None)?.film_position;
        if self.projection == CameraProjection::Panorama {
            let turn = self.width as f32;
            by.x -= turn * (by.x / turn).round();
        }
        Some(by)
    }

    /// Returns the motion vector of a point at infinity in unit `direction`: its displacement on
    /// the film from this camera to the camera `later` \[pixels to the right and down].
    ///
    /// Returns `None` if the point is behind a camera or at a pole of a panorama, or if the
    /// projection is orthographic.
    #[must_use]
    pub fn film_displacement_at_infinity(&self, direction: Vec3, later: &Self) -> Option<Vec2> {
        if self.is_orthographic() {
            return None;
        }
        // Move the camera to the origin: from there, it sees the point `direction` at the film
        // position of the point at infinity.
        let turned = |camera: &Self| Self { center: DVec3::ZERO, ..*camera };
        turned(self).film_displacement(direction, &turned(later), direction)
    }

    /// Calls `visit` with every other film position that has the same camera ray as `position`, and
    /// lies on the film or at most `margin` \[pixels] outside.
    ///
    /// Only panoramas have such positions: the picture repeats across its left and right edges, and
    /// continues beyond a pole, mirrored and shifted by half a turn. `position` must lie on the
    /// film.
    pub fn for_each_other_film_position(&self, position: Vec2, margin: f32, mut visit: impl FnMut(Vec2)) {
        if self.projection != CameraProjection::Panorama {
            return;
        }
        let size = Vec2::new(self.width as f32, self.height as f32);
        let reach = (margin / size).ceil().as_ivec2() + 1;
        let is_near = |x: f32, extent: f32| x >= -margin && x <= extent + margin;
        for poles in -reach.y..=reach.y {
            let (y, shift) = if poles % 2 == 0 {
                (position.y + poles as f32 * size.y, 0.0)
            } else {
                ((poles + 1) as f32 * size.y - position.y, 0.5 * size.x)
            };
            if !is_near(y, size.y) {
                continue;
            }
            for turns in -reach.x..=reach.x {
                let x = position.x + shift + turns as f32 * size.x;
                if is_near(x, size.x) && (poles, turns) != (0, 0) {
                    visit(Vec2::new(x, y));
                }
            }
        }
    }

    /// Returns the film position of a camera ray, relative to the film's center
    /// \[pixels right and up].
    ///
    /// `v` is the vector from the camera center to a point of the ray. For a perspective camera,
    /// this is the point at depth 1; for an orthographic camera, any point.
    fn film_offset_from_center(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.pixel_right), v.dot(self.pixel_up)) / (self.pixel_size * self.pixel_size)
    }

    /// Makes the connection of `p` to the camera ray that starts at `origin`; `None` if `p` and
    /// `origin` coincide, or if the film position or `importance` is not finite.
    ///
    /// `offset` is the film position relative to the film's center \[pixels right and up].
    fn connection_from_ray_origin(
        &self,
        offset: DVec2,
        origin: DVec3,
        p: DVec3,
        importance: f64,
    ) -> Option<CameraConnection> {
        let film_position = DVec2::new(0.5 * f64::from(self.width) + offset.x, 0.5 * f64::from(self.height) - offset.y);
        let direction = (origin - p).try_normalize()?;
        let connection = CameraConnection {
            film_position: film_position.as_vec2(),
            ray_origin: origin.as_vec3(),
            direction_to_camera: direction.as_vec3(),
            importance: importance as f32,
        };
        (connection.film_position.is_finite() && connection.importance.is_finite()).then_some(connection)
    }
}

#[cfg(test)]
mod tests;
