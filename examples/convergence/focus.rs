//! Scenes with a focus, and the light in a window around it.

use crate::read_scene;
use caustica::camera::{Camera, Filter, FilterKind};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Plane, Shape, Sphere};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Width and height of the pictures.
pub const SIZE: (u32, u32) = (40, 30);

/// A scene, and the window of its picture that holds the focus.
pub struct Focus {
    pub scene: Scene,
    columns: Range<u32>,
    rows: Range<u32>,
    /// An independent way to the light in the window.
    pub check: Check,
}

/// A way to the light in the window without light tracing.
pub enum Check {
    /// The integrator `path`.
    PathTracing,
    /// Photon estimates of a tenth of the radius.
    PhotonEstimates,
    /// The light in the window in closed form.
    ClosedForm(f64),
}

impl Focus {
    pub const NAMES: [&'static str; 3] = ["ball-lens", "goblet", "point-light"];

    pub fn new(name: &str) -> Result<Self, Box<dyn Error>> {
        match name {
            // The spot on the screen.
            "ball-lens" => {
                let scene = read_scene(name, SIZE)?.0;
                Ok(Self { scene, columns: 24..28, rows: 11..17, check: Check::PhotonEstimates })
            }
            // The spot behind the wine.
            "goblet" => {
                let scene = read_scene(name, SIZE)?.0;
                Ok(Self { scene, columns: 10..15, rows: 19..24, check: Check::PathTracing })
            }
            "point-light" => {
                let (columns, rows) = (17..23, 12..18);
                let light = window_light(&columns, &rows);
                let scene = point_light_scene().build(camera())?;
                Ok(Self { scene, columns, rows, check: Check::ClosedForm(light) })
            }
            _ => Err(format!("`{name}` is no focus: choose from {:?}", Self::NAMES).into()),
        }
    }

    /// Returns the indices of the pixels in the window.
    pub fn pixels(&self) -> impl Iterator<Item = usize> {
        let row = |y: u32| self.columns.clone().map(move |x| (y * SIZE.0 + x) as usize);
        self.rows.clone().flat_map(row)
    }

    /// Returns the sum of the channels' mean over the window.
    pub fn light(&self, pixels: &[Vec3]) -> f64 {
        self.pixels().map(|i| pixels[i].as_dvec3().element_sum() / 3.0).sum()
    }
}

// A point light, a glass ball of radius 1 below it and a screen below both.

const INDEX: f64 = 1.5;
/// Distance of the light above the ball's center. Rays near the axis meet 2 below the center.
const HEIGHT: f64 = 6.0;
/// Depth of the screen below the ball's center.
const DEPTH: f64 = 1.8;
/// A dark screen: light that returns from the ball adds less than a thousandth.
const REFLECTANCE: f64 = 0.02;
const POWER: f64 = 5000.0;
/// Height of the orthographic film \[length].
const FILM: f64 = 2.0;

fn point_light_scene() -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let glass = builder.add_material(Material::dielectric(INDEX as f32, Vec3::ZERO));
    let screen = builder.add_material(Material::diffuse(Vec3::splat(REFLECTANCE as f32)));
    builder
        .add_plane(Plane::new(DVec3::Y * -DEPTH, DVec3::Y), screen, Vec3::ZERO)
        .add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), glass, Vec3::ZERO)
        .add_delta_light(
            UnscaledDeltaLight::Point { position: DVec3::Y * HEIGHT },
            LightStrength::Power(Vec3::splat(POWER as f32)),
        );
    builder
}

/// A camera that sees the focus past the ball, at 60 degrees from the screen's normal.
fn camera() -> Camera {
    let tilt = PI / 3.0;
    let direction = DVec3::new(libm::sin(tilt), -libm::cos(tilt), 0.0);
    let eye = DVec3::Y * -DEPTH - direction * 8.0;
    Camera::orthographic(eye, direction, DVec3::Y, FILM, SIZE.0, SIZE.1).expect("the camera is valid")
}

/// Returns the light in a window of pixels by the laws of Snell and Fresnel, without light that is
/// reflected inside of the ball (at most .2 %).
fn window_light(columns: &Range<u32>, rows: &Range<u32>) -> f64 {
    const RINGS: u32 = 4000;
    const TURNS: u32 = 360;
    let camera = camera();
    let shown = |x: f32, y: f32| {
        let ray = camera.generate_ray(Vec2::new(x, y), None);
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let point = origin + direction * ((-DEPTH - origin.y) / direction.y);
        DVec2::new(point.x, point.z)
    };
    let corner = shown(0.0, 0.0);
    let (right, down) = (shown(1.0, 0.0) - corner, shown(0.0, 1.0) - corner);
    let pixel_area = right.perp_dot(down);
    let filter = Filter::new(FilterKind::default());
    let weight = |pixels: &Range<u32>, at: f64| -> f64 {
        pixels.clone().map(|pixel| f64::from(filter.normalized_axis_value((f64::from(pixel) + 0.5 - at) as f32))).sum()
    };
    let widest = libm::asin(1.0 / HEIGHT);
    let mut light = 0.0;
    for ring in 0..RINGS {
        let theta = (f64::from(ring) + 0.5) / f64::from(RINGS) * widest;
        let (radius, transmittance) = landing(theta);
        let flux = POWER / 2.0 * libm::sin(theta) * widest / f64::from(RINGS) * transmittance;
        for turn in 0..TURNS {
            let turn = (f64::from(turn) + 0.5) * TAU / f64::from(TURNS);
            let at = DVec2::new(radius * libm::cos(turn), radius * libm::sin(turn)) - corner;
            let (x, y) = (at.perp_dot(down) / pixel_area, right.perp_dot(at) / pixel_area);
            light += flux / f64::from(TURNS) * weight(columns, x) * weight(rows, y);
        }
    }
    light * REFLECTANCE / PI / pixel_area.abs()
}

/// Returns the landing radius on the screen and the transmittance of the ray at angle `theta` from
/// the axis.
fn landing(theta: f64) -> (f64, f64) {
    let h = HEIGHT * libm::sin(theta);
    let convergence = 2.0 * (libm::asin(h) - libm::asin(h / INDEX)) - theta;
    let (outside, inside) = ((1.0 - h * h).sqrt(), (1.0 - h * h / (INDEX * INDEX)).sqrt());
    let s = (outside - INDEX * inside) / (outside + INDEX * inside);
    let p = (INDEX * outside - inside) / (INDEX * outside + inside);
    let transmittance = 1.0 - 0.5 * (s * s + p * p);
    let radius = (DEPTH - h / libm::sin(convergence)).abs() * libm::tan(convergence);
    (radius, transmittance * transmittance)
}
