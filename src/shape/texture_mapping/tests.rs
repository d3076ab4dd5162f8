use super::*;
use glam::{DAffine3, DQuat};

/// Texture gradients agree with differences of the coordinates over steps of 10⁻⁶.
#[test]
fn texture_gradients_match_coordinate_differences() {
    let squash = Transform::new(DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 0.5, -2.0),
        DQuat::from_rotation_z(0.7),
        DVec3::new(3.0, -1.0, 2.0),
    ))
    .unwrap();
    let kinds = [
        TextureMappingKind::Spherical { center: DVec3::new(0.1, 0.2, 0.3) },
        TextureMappingKind::plane_mapping(DVec3::new(1.0, 2.0, 0.5)),
        TextureMappingKind::disc_mapping(DVec3::X, DVec3::Y, 2.0),
        TextureMappingKind::rectangle_mapping(DVec3::ONE, DVec3::new(2.0, 0.1, 0.0), DVec3::new(0.3, 1.0, 0.5)),
    ];
    for kind in kinds {
        let mapping = TextureMapping::new(kind, squash);
        let at = |p: DVec3| mapping.tex_coord_at(squash.inverse().transform_point3(p), TexCoord::default);
        let p = squash.transform_point(DVec3::new(0.8, 0.9, -0.4));
        for step in [DVec3::X, DVec3::Y, DVec3::Z] {
            let change = (at(p + step * 1e-6).uv - at(p).uv) * 1e6;
            let here = at(p);
            let expected = DVec2::new(here.grad_u.dot(step), here.grad_v.dot(step));
            assert!((change - expected).length() < 1e-4, "{kind:?} {change} {expected}");
        }
    }
}

#[test]
fn texture_coordinates_have_known_values() {
    let at = |kind, p| TextureMapping::new(kind, Transform::IDENTITY).tex_coord_at(p, TexCoord::default).uv;
    let close = |kind, p: [f64; 3], uv: [f64; 2]| {
        let found = at(kind, DVec3::from(p));
        assert!((found - DVec2::from(uv)).length() < 1e-12, "{kind:?} {p:?}: {found}");
    };
    let globe = TextureMappingKind::Spherical { center: DVec3::new(1.0, 0.0, 0.0) };
    close(globe, [1.0, 0.0, 2.0], [0.5, 0.5]);
    close(globe, [3.0, 0.0, 0.0], [0.75, 0.5]);
    close(globe, [-1.0, 0.0, 0.0], [0.25, 0.5]);
    close(globe, [1.0, 1.0, 1.0], [0.5, 0.75]);
    let pole = |y: f64| at(globe, DVec3::new(1.0, y, 0.0)).y;
    assert!((pole(2.0) - 1.0).abs() < 1e-12 && pole(-2.0).abs() < 1e-12);
    // u and v on the floor grow towards +x and −z, as on a map with north at −z. Pictures on walls
    // are upright seen from outside.
    close(TextureMappingKind::plane_mapping(DVec3::Y), [2.0, 0.0, -3.0], [2.0, 3.0]);
    close(TextureMappingKind::plane_mapping(DVec3::Z * 5.0), [2.0, 3.0, 0.0], [2.0, 3.0]);
    close(TextureMappingKind::plane_mapping(DVec3::X), [0.0, 3.0, -2.0], [2.0, 3.0]);
    close(TextureMappingKind::plane_mapping(DVec3::NEG_Z), [2.0, 3.0, 0.0], [-2.0, 3.0]);
    let disc = TextureMappingKind::disc_mapping(DVec3::new(0.0, 0.0, 4.0), DVec3::Z, 2.0);
    close(disc, [0.0, 0.0, 4.0], [0.5, 0.5]);
    close(disc, [2.0, 0.0, 4.0], [1.0, 0.5]);
    close(disc, [0.0, -2.0, 4.0], [0.5, 0.0]);
    // The ground of the reference scene `lens`: u = (x + 5)/10, v = (5 − z)/10.
    let ground = TextureMappingKind::rectangle_mapping(DVec3::new(-5.0, 0.0, 5.0), DVec3::X * 10.0, DVec3::Z * -10.0);
    close(ground, [-5.0, 0.0, 5.0], [0.0, 0.0]);
    close(ground, [1.0, 0.0, -4.0], [0.6, 0.9]);
}
