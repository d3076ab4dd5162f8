//! Textured area lights: a light with one black half equals a light of half the size.

use super::direct::mesh_light_surface;
use super::*;
use crate::math::Transform;
use crate::shape::{Mesh, TextureMapping, TextureMappingKind};
use crate::texture::{Checkerboard, Texture, UvTransform};
use glam::DVec2;
use std::sync::Arc;

const BRIGHT: f32 = 3.0;

/// A texture that is white where u < ½ and v < 1, and black elsewhere.
fn half_white_texture() -> Arc<Texture> {
    let colors = [Rgb::ONE, Rgb::ZERO];
    Arc::new(Texture::Checkerboard(Checkerboard { colors }, UvTransform::new(DVec2::new(2.0, 1.0), 0.0, DVec2::ZERO)))
}

fn textured_area_light(emitter: LightSurface, kind: TextureMappingKind) -> Light {
    let texture = half_white_texture();
    let scale = Rgb::splat(BRIGHT);
    let radiance = texture.mean() * scale;
    let glow = Arc::new(super::super::EmissionTexture {
        texture,
        mapping: TextureMapping::new(kind, Transform::IDENTITY),
        scale,
    });
    Light::Area(AreaLight { surface: emitter, radiance, texture: Some(glow) })
}

/// Pairs of a light whose second half is textured black, and an untextured light of half the size.
///
/// The lights are above the origin and emit downwards. Texture coordinate u runs along x.
fn textured_and_equivalent_lights() -> Vec<(Light, Light)> {
    let (corner, e0, e1) = (DVec3::new(-1.0, 2.0, -0.5), DVec3::X * 2.0, DVec3::Z);
    let rectangle = |e0| LightSurface::Shape(Shape::Rectangle(Rectangle::new(corner, e0, e1)));
    let mesh = |width: f32| {
        let at = |u: f32, v: f32| Vec3::new(-1.0 + width * u, 2.0, -0.5 + v);
        Arc::new(Mesh {
            positions: vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
            texcoords: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        })
    };
    let even = |emitter| Light::Area(AreaLight::with_uniform_radiance(emitter, Rgb::splat(BRIGHT)));
    vec![
        (
            textured_area_light(rectangle(e0), TextureMappingKind::rectangle_mapping(corner, e0, e1)),
            even(rectangle(e0 * 0.5)),
        ),
        (
            textured_area_light(mesh_light_surface(mesh(2.0)), TextureMappingKind::Uv),
            even(mesh_light_surface(mesh(1.0))),
        ),
    ]
}

fn means_differ_significantly(a: (f64, f64), b: (f64, f64)) -> bool {
    (a.0 - b.0).abs() > 5.0 * (a.1 + b.1).sqrt() + 1e-6 * a.0
}

#[test]
fn half_textured_light_equals_half_sized_light() {
    for (whole, half) in textured_and_equivalent_lights() {
        // At the first two points, rectangles are sampled by solid angle. At the last point, which
        // is far away, they are sampled by area.
        for p in [Vec3::ZERO, Vec3::new(1.0, 1.5, 0.2), Vec3::new(-3.0, -9.0, 1.0)] {
            let [a, b] = [&whole, &half].map(|light| estimate_irradiance(light, p, Vec3::Y));
            assert!(!means_differ_significantly(a, b) && b.0 > 0.0, "{p}: {a:?} {b:?}");
        }
    }
}

#[test]
fn half_textured_light_emits_half_the_flux() {
    let domain = BoundingSphere { center: Vec3::ZERO, radius: 4.0 };
    let ball = BoundingSphere { center: Vec3::new(0.3, 0.0, 0.1), radius: 0.7 };
    let aim = PhotonAim::new([ball]);
    for (whole, half) in textured_and_equivalent_lights() {
        // The powers are equal, and so is the mean flux of photons.
        assert!((whole.power(domain) - half.power(domain)).abs().max_element() < 1e-5);
        let draw = |k: Key| (k.uniform_2d(Dimension::LightPosition), k.uniform_2d(Dimension::LightDirection));
        for aimed in [false, true] {
            let [a, b] = [&whole, &half].map(|light| {
                estimate_mean_and_variance(100_000, |k| {
                    let (position, direction) = draw(k);
                    let emission = if aimed {
                        light.sample_le_towards(&aim, domain, position, direction)
                    } else {
                        light.sample_le(domain, position, direction)
                    };
                    emission.map_or(0.0, |e| f64::from(e.weight.x))
                })
            });
            assert!(!means_differ_significantly(a, b) && b.0 > 0.0, "aimed: {aimed}: {a:?} {b:?}");
        }
    }
}
