//! Bounds of lights in space and direction, and estimates of the light that arrives at a point.
//!
//! Sources: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting"; Pharr, Jakob, Humphreys 2023, section 12.6.3.

use crate::color::{self, Rgb};
use crate::math::Bounds;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bounds for one or more lights, as in a node of a light BVH: for their positions, and for the
/// directions in which they emit.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// Box around the positions of the lights, in world space.
    pub space: Bounds,
    /// Cone that contains the directions from which `spread` is measured. For emitting surfaces,
    /// these are their outer normals. For a light at a point, they are its axes of emission. Each
    /// emitted direction lies within the angle `spread` of one of these directions.
    normal_cone: DirectionCone,
    /// Largest angle \[radians] between an emitted direction and the nearest direction in
    /// `normal_cone`, at most π/2.
    spread: f64,
    /// Total flux of the lights \[W], averaged over the color channels.
    flux: f64,
}

/// A cone: the set of all directions within a half angle around an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionCone {
    /// Unit axis of the cone.
    pub axis: DVec3,
    /// Half angle of the cone \[radians].
    pub half_angle: f64,
}

/// Upper bound of the angle \[radians] by which rounding to f32 turns a unit vector.
pub(super) const NORMAL_ERROR: f64 = 1e-6;

impl DirectionCone {
    /// The cone of all directions.
    pub const ALL: Self = Self { axis: DVec3::Z, half_angle: PI };

    /// Returns a cone that contains both `self` and `other`.
    fn union(self, other: Self) -> Self {
        let between = angle_between(self.axis, other.axis);
        if (between + other.half_angle).min(PI) <= self.half_angle {
            return self;
        }
        if (between + self.half_angle).min(PI) <= other.half_angle {
            return other;
        }
        let half = 0.5 * (self.half_angle + between + other.half_angle);
        let around = self.axis.cross(other.axis).try_normalize();
        match around {
            Some(around) if half < PI => {
                Self { axis: DQuat::from_axis_angle(around, half - self.half_angle) * self.axis, half_angle: half }
            }
            Some(_) | None => Self::ALL,
        }
    }
}

/// Angle between two unit vectors \[radians].
pub(super) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

impl LightBounds {
    /// Creates the bounds of one light, whose positions lie in the box `space`, and whose flux is
    /// `flux` \[W].
    ///
    /// `normal_cone` contains all surface normals of the light. For a light at a point, it contains
    /// the axes from which emitted directions are measured. `spread` is the largest angle
    /// \[radians] between an emitted direction and the nearest direction in `normal_cone`.
    pub fn new(space: Bounds, normal_cone: DirectionCone, spread: f64, flux: Rgb) -> Self {
        Self { space, normal_cone, spread, flux: f64::from(color::channel_mean(flux)) }
    }

    /// Returns the bounds, with their box expanded by `margin` \[length] and by the rounding errors
    /// of its coordinates.
    pub fn expanded(self, margin: f32) -> Self {
        let far = self.space.min.abs().max(self.space.max.abs()).max_element();
        Self { space: self.space.expanded(margin + far * 1e-6), ..self }
    }

    /// Returns bounds that contain all lights of `self` and `other`.
    pub fn union(self, other: Self) -> Self {
        Self {
            space: self.space.union(other.space),
            normal_cone: self.normal_cone.union(other.normal_cone),
            spread: self.spread.max(other.spread),
            flux: self.flux + other.flux,
        }
    }

    /// Returns the solid angle Ω \[sr] for which flux ≈ Ω · intensity along the normals: the
    /// integral of the relative intensity over all directions.
    ///
    /// The relative intensity is 1 inside the cone of normals. Up to the angle `spread` outside of
    /// the cone, it is the cosine of the angle to the cone. Beyond, it is 0.
    fn weighted_solid_angle(&self) -> f64 {
        let o = self.normal_cone.half_angle;
        let w = (o + self.spread).min(PI);
        let (sin, cos) = libm::sincos(o);
        let falloff = 2.0 * w * sin - libm::cos(o - 2.0 * w) - 2.0 * o * sin + cos;
        2.0 * PI * (1.0 - cos) + FRAC_PI_2 * falloff
    }

    /// Cost of a light BVH node with these bounds: flux × solid angle of the emission × squared
    /// diagonal of the box.
    pub fn bvh_node_cost(&self) -> f64 {
        self.flux * self.weighted_solid_angle() * f64::from(self.space.extent().length_squared())
    }
}

/// Lower limit of d²/r², where d is the distance from the lit point to the center of the bounding
/// sphere of a group of lights, and r is the radius of this sphere. The limit keeps the importance
/// of the group, which is proportional to 1/d², finite for points among the lights.
///
/// With this limit, 1/d² is at most 6/r². This is about the mean of 1/d² over the cube inscribed in
/// the sphere. A ball of the same volume has the radius R ≈ r/√2, and the mean of 1/d² over it is
/// 3/R².
const MIN_RELATIVE_SQUARED_DISTANCE: f64 = 1.0 / 6.0;

/// Bounds of one or more lights, stored so that their importance at a point is computed fast.
///
/// A bounding sphere replaces the box of [`LightBounds`], and cosines replace angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompactLightBounds {
    /// Center of the bounding sphere of all lights.
    center: Vec3,
    /// Squared radius of the bounding sphere of all lights \[length²], above 0.
    radius_squared: f64,
    /// Unit axis of the cone that contains all surface normals, or the emission axes of lights at a
    /// point.
    axis: Vec3,
    /// Cosine and sine of the half angle of the cone around `axis`.
    normal_half_angle: CosSin,
    /// Cosine of the largest angle between an emitted direction and the nearest direction in the
    /// cone around `axis`.
    cos_spread: f64,
    /// Approximate radiant intensity \[W/sr] of all lights together, in directions inside the cone
    /// around `axis`. Other directions have lower intensity.
    intensity: f64,
}

/// Cosine and sine, in this order, of an angle between 0 and π.
#[derive(Clone, Copy, Debug)]
struct CosSin(f64, f64);

impl CosSin {
    /// Creates the angle in \[0, π] with the given cosine.
    fn from_cos(cos: f64) -> Self {
        Self(cos, (1.0 - cos * cos).max(0.0).sqrt())
    }

    /// Returns the angle `self` − `other`, or the angle 0 if `other` is larger.
    #[inline]
    fn subtract_clamped(self, other: Self) -> Self {
        if self.0 >= other.0 {
            return Self(1.0, 0.0);
        }
        Self(self.0 * other.0 + self.1 * other.1, self.1 * other.0 - self.0 * other.1)
    }
}

impl From<LightBounds> for CompactLightBounds {
    fn from(bounds: LightBounds) -> Self {
        let sphere = bounds.space.bounding_sphere();
        // The radius includes the rounding errors of the sphere. It must be positive, because it
        // limits a divisor from below.
        let radius = (f64::from(sphere.radius) * (1.0 + 1e-6)).max(f64::from(f32::MIN_POSITIVE));
        let (sin, cos) = libm::sincos(bounds.normal_cone.half_angle);
        Self {
            center: sphere.center,
            radius_squared: radius * radius,
            axis: bounds.normal_cone.axis.as_vec3(),
            normal_half_angle: CosSin(cos, sin),
            cos_spread: libm::cos(bounds.spread),
            intensity: bounds.flux / bounds.weighted_solid_angle(),
        }
    }
}

impl CompactLightBounds {
    /// Importance of the lights for light sampling at `p`: the approximate irradiance \[W/m²] that
    /// they cause there.
    ///
    /// If the unit normal `n` of a surface at `p` is given, only light that arrives on the side to
    /// which `n` points counts. The result is 0 only if no light can arrive.
    #[inline]
    pub fn importance_at(&self, p: Vec3, n: Option<Vec3>) -> f64 {
        let to = p.as_dvec3() - self.center.as_dvec3();
        let d2 = to.length_squared();
        let (w, subtended) = if d2 <= self.radius_squared {
            (to, CosSin(-1.0, 0.0))
        } else {
            (to / d2.sqrt(), CosSin((1.0 - self.radius_squared / d2).sqrt(), (self.radius_squared / d2).sqrt()))
        };
        let angle = |cos: f64| CosSin::from_cos(cos.clamp(-1.0, 1.0));
        let emitted =
            angle(w.dot(self.axis.as_dvec3())).subtract_clamped(self.normal_half_angle).subtract_clamped(subtended).0;
        // The comparison is `<`, not `<=`: with zero spread, a direction inside the cone has the
        // cosine 1 = `cos_spread`.
        if emitted < self.cos_spread {
            return 0.0;
        }
        let received = n.map_or(1.0, |n| angle(-w.dot(n.as_dvec3())).subtract_clamped(subtended).0);
        if received <= 0.0 {
            return 0.0;
        }
        self.intensity * emitted * received / d2.max(self.radius_squared * MIN_RELATIVE_SQUARED_DISTANCE)
    }
}
