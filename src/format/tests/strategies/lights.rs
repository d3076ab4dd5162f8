//! Generators of random lights, still and moving, for property tests.

use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::values::*;
use crate::format::description::*;

pub fn random_light() -> impl Strategy<Value = LightDescription> {
    (random_still_light(), option::of(vec(random_motion_step(true), 0..3))).prop_map(|(light, motion)| match motion {
        Some(steps) => LightDescription::Moving { steps, light: Box::new(with_empty_span(light)) },
        None => light,
    })
}

fn random_still_light() -> impl Strategy<Value = LightDescription> {
    prop_oneof![
        (random_point(), random_point_light_strength())
            .prop_map(|(position, strength)| LightDescription::Point(PointLightDescription { position, strength })),
        (random_direction(), random_color(), any::<bool>()).prop_map(|(direction, c, physical)| {
            let strength = if physical {
                DirectionalLightStrength::Irradiance(c)
            } else {
                DirectionalLightStrength::Mit6837Color(c)
            };
            LightDescription::Directional(DirectionalLightDescription { direction, strength })
        }),
        (random_point(), random_direction(), 1e-9..=360.0, 0.0..=0.5, random_point_light_strength()).prop_map(
            |(position, axis, full_cone_angle_degrees, rim, strength)| {
                let aim = DirectionOrTarget::Direction(axis);
                LightDescription::Spot(SpotLightDescription {
                    position,
                    aim,
                    full_cone_angle_degrees,
                    penumbra_degrees: rim * full_cone_angle_degrees,
                    strength,
                })
            }
        ),
        (random_point(), random_direction(), random_name(), 1e-9..180.0, random_color(), 0..3u8).prop_map(
            |(position, axis, path, vertical_fov_degrees, c, kind)| {
                let path = with_empty_span(path);
                let pose = LightPose { position, aim: DirectionOrTarget::Direction(axis), up: None };
                let strength = PointLightStrength::Intensity(c);
                let distribution = match kind {
                    0 => return ProjectorLightDescription { pose, vertical_fov_degrees, path, strength }.into(),
                    1 => IntensityDistribution::MapFile(path),
                    _ => IntensityDistribution::ProfileFile(path),
                };
                GoniometricLightDescription { pose, distribution, strength }.into()
            }
        ),
        (random_point(), random_positive(), random_area_light_strength()).prop_map(|(center, radius, strength)| {
            LightDescription::Sphere(SphereLightDescription { center, radius, strength })
        }),
        (random_point(), random_direction(), random_positive(), random_area_light_strength()).prop_map(
            |(center, normal, radius, strength)| LightDescription::Disc(DiscLightDescription {
                center,
                normal,
                radius,
                strength
            })
        ),
        (random_corner_and_edges(), random_area_light_strength()).prop_map(|((corner, edge0, edge1), strength)| {
            LightDescription::Rectangle(RectangleLightDescription { corner, edge0, edge1, strength })
        }),
    ]
}

fn random_point_light_strength() -> impl Strategy<Value = PointLightStrength> {
    (random_color(), 0..3).prop_map(|(c, kind)| match kind {
        0 => PointLightStrength::Mit6837Color(c),
        1 => PointLightStrength::Intensity(c),
        _ => PointLightStrength::Power(c),
    })
}

fn random_area_light_strength() -> impl Strategy<Value = AreaLightStrength> {
    (random_color(), any::<bool>())
        .prop_map(|(c, power)| if power { AreaLightStrength::Power(c) } else { AreaLightStrength::Radiance(c) })
}

pub fn random_environment_light() -> impl Strategy<Value = LightDescription> {
    let picture = (random_name(), random_positive(), random_finite_number())
        .prop_map(|(path, scale, rotate)| EnvironmentRadiance::Picture { path: with_empty_span(path), scale, rotate });
    prop_oneof![random_color().prop_map(EnvironmentRadiance::Constant), picture].prop_map(LightDescription::Environment)
}
