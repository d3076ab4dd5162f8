//! How much a group of lights can matter to a point (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with
//! Adaptive Tree Splitting"; Pharr, Jakob, Humphreys 2023, section 12.6.3).

use super::{Emitter, Light};
use crate::color;
use crate::math::Bounds;
use crate::shape::Shape;
use glam::{DQuat, DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Where a group of lights is, and which way it shines.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub space: Bounds,
    pub normals: Cone,
    /// How far from the normal light goes, at most π/2 \[radians].
    pub spread: f64,
    /// Emitted flux, mean over the channels \[W].
    pub flux: f64,
}

/// The directions within an angle of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    axis: DVec3,
    /// Half angle \[radians].
    angle: f64,
}

/// Unit normals in f32 are off by some ulps.
const NORMAL_ERROR: f64 = 1e-6;

impl Cone {
    const ALL: Self = Self { axis: DVec3::Z, angle: PI };

    fn union(self, other: Self) -> Self {
        let between = angle(self.axis, other.axis);
        if (between + other.angle).min(PI) <= self.angle {
            return self;
        }
        if (between + self.angle).min(PI) <= other.angle {
            return other;
        }
        let half = 0.5 * (self.angle + between + other.angle);
        let around = self.axis.cross(other.axis).try_normalize();
        match around {
            Some(around) if half < PI => {
                Self { axis: DQuat::from_axis_angle(around, half - self.angle) * self.axis, angle: half }
            }
            _ => Self::ALL,
        }
    }
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

impl LightBounds {
    /// Bounds of a light with a place, their box grown by `margin`; `None` for light from infinity.
    pub fn of(light: &Light, margin: f32) -> Option<Self> {
        let (space, normals, spread, flux) = match light {
            Light::Point { position, intensity } => {
                (Bounds::of([*position]), Cone::ALL, FRAC_PI_2, *intensity * (4.0 * std::f32::consts::PI))
            }
            Light::Spot(spot) => {
                let [inner, outer] =
                    [spot.inner, spot.outer].map(|drop| 2.0 * libm::asin((0.5 * f64::from(drop)).sqrt().min(1.0)));
                let spread = (outer - inner).min(FRAC_PI_2);
                let normals = Cone { axis: spot.axis.as_dvec3(), angle: outer - spread + NORMAL_ERROR };
                (Bounds::of([spot.position]), normals, spread, spot.power())
            }
            Light::Directional { .. } | Light::Environment(_) => return None,
            Light::Area(area) => {
                let (space, normals) = surface(&area.emitter);
                (space, normals, FRAC_PI_2, area.power())
            }
        };
        let far = space.min.abs().max(space.max.abs()).max_element();
        Some(Self { space: space.expanded(margin + far * 1e-6), normals, spread, flux: f64::from(color::mean(flux)) })
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            space: self.space.union(other.space),
            normals: self.normals.union(other.normals),
            spread: self.spread.max(other.spread),
            flux: self.flux + other.flux,
        }
    }

    /// Solid angle into which it shines, what leaves a normal at a slant weighed by the cosine \[sr].
    fn directions(&self) -> f64 {
        let o = self.normals.angle;
        let w = (o + self.spread).min(PI);
        let (sin, cos) = libm::sincos(o);
        let falloff = 2.0 * w * sin - libm::cos(o - 2.0 * w) - 2.0 * o * sin + cos;
        2.0 * PI * (1.0 - cos) + FRAC_PI_2 * falloff
    }

    /// What a group costs in a tree: its flux times the measures of where it is and where it shines.
    pub fn cost(&self) -> f64 {
        self.flux * self.directions() * f64::from(self.space.extent().length_squared())
    }
}

/// Box and normals.
fn surface(emitter: &Emitter) -> (Bounds, Cone) {
    match emitter {
        Emitter::Shape(
            shape @ (Shape::Sphere(_)
            | Shape::Ellipsoid(_)
            | Shape::Instance(_)
            | Shape::Revolution(_)
            | Shape::Patch(_)),
        ) => (shape.bounds(), Cone::ALL),
        Emitter::Shape(shape @ (Shape::Disc(_) | Shape::Rectangle(_))) => {
            let axis = shape.sample(Vec2::splat(0.5)).point.ng.as_dvec3();
            (shape.bounds(), Cone { axis, angle: NORMAL_ERROR })
        }
        Emitter::Triangles { mesh, first, choice } => {
            let triangles = || *first as usize..*first as usize + choice.len();
            // Shading normals choose the side: at all corners alike, or nothing is known.
            let normal = |i| {
                let [a, b, c] = [Vec2::ZERO, Vec2::X, Vec2::Y].map(|b| mesh.surface(i, b).ng);
                (a == b && b == c).then(|| a.as_dvec3())
            };
            let sum: Option<DVec3> = triangles().map(|i| normal(i).map(|n| n * mesh.area(i))).sum();
            let around = |axis: DVec3| {
                let widest = triangles().filter_map(normal).map(|n| angle(n, axis)).fold(0.0, f64::max);
                Cone { axis, angle: (widest + NORMAL_ERROR).min(PI) }
            };
            let normals = sum.and_then(DVec3::try_normalize).map_or(Cone::ALL, around);
            (Bounds::of(triangles().flat_map(|i| mesh.corners(i))), normals)
        }
    }
}

/// Squared distances count for at least this part of a group's squared radius: the mean of 1/d² over a ball around a point is
/// 3/R², and a box has the volume of a ball of 0.7 of its half diagonal.
const NEAR: f64 = 1.0 / 6.0;

/// Bounds as they are asked: a ball instead of the box, and cosines instead of angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Importance {
    center: Vec3,
    radius2: f64,
    axis: Vec3,
    normals: Angle,
    cos_spread: f64,
    /// About the radiant intensity along the normals \[W/sr].
    intensity: f64,
}

/// Cosine and sine of an angle between 0 and π.
#[derive(Clone, Copy, Debug)]
struct Angle(f64, f64);

impl Angle {
    fn of_cos(cos: f64) -> Self {
        Self(cos, (1.0 - cos * cos).max(0.0).sqrt())
    }

    /// Less by `other`, but not below zero.
    #[inline]
    fn less(self, other: Self) -> Self {
        if self.0 >= other.0 {
            return Self(1.0, 0.0);
        }
        Self(self.0 * other.0 + self.1 * other.1, self.1 * other.0 - self.0 * other.1)
    }
}

impl From<LightBounds> for Importance {
    fn from(bounds: LightBounds) -> Self {
        let ball = bounds.space.bounding_sphere();
        // Rounding of the ball itself; never nothing, as squared distances are divided by it.
        let radius = (f64::from(ball.radius) * (1.0 + 1e-6)).max(f64::from(f32::MIN_POSITIVE));
        let (sin, cos) = libm::sincos(bounds.normals.angle);
        Self {
            center: ball.center,
            radius2: radius * radius,
            axis: bounds.normals.axis.as_vec3(),
            normals: Angle(cos, sin),
            cos_spread: libm::cos(bounds.spread),
            intensity: bounds.flux / bounds.directions(),
        }
    }
}

impl Importance {
    /// About the irradiance at `p`, and never 0 where there can be any; with a normal `n`, on its side.
    #[inline]
    pub fn at(&self, p: Vec3, n: Option<Vec3>) -> f64 {
        let to = p.as_dvec3() - self.center.as_dvec3();
        let d2 = to.length_squared();
        let (w, ball) = if d2 <= self.radius2 {
            (to, Angle(-1.0, 0.0))
        } else {
            (to / d2.sqrt(), Angle((1.0 - self.radius2 / d2).sqrt(), (self.radius2 / d2).sqrt()))
        };
        let least = |cos: f64| Angle::of_cos(cos.clamp(-1.0, 1.0));
        let emitted = least(w.dot(self.axis.as_dvec3())).less(self.normals).less(ball).0;
        // Without a spread the cone itself still counts.
        if emitted < self.cos_spread {
            return 0.0;
        }
        let received = n.map_or(1.0, |n| least(-w.dot(n.as_dvec3())).less(ball).0);
        if received <= 0.0 {
            return 0.0;
        }
        self.intensity * emitted * received / d2.max(self.radius2 * NEAR)
    }
}
