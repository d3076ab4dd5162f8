//! Generators of random cameras for property tests.

use glam::DVec3;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::values::*;
use crate::format::description::*;

pub fn random_camera() -> impl Strategy<Value = CameraDescription> {
    let size = || 1..=65_536_u32;
    let views = (
        random_corner_and_edges(),
        any::<bool>(),
        random_projection(),
        size(),
        size(),
        vec(random_motion_step(false), 0..3),
    );
    views.prop_filter_map("no view", |((center, view, up), aimed, mut projection, width, height, motion)| {
        let lookat =
            aimed.then_some(center + view).filter(|p| (*p - center).normalize().cross(up.normalize()).length() > 1e-6);
        let aim = lookat.map_or(DirectionOrTarget::Direction(view), DirectionOrTarget::Target);
        let parallel = view.normalize().cross(up.normalize()).length() < 1e-6;
        if let ProjectionDescription::Perspective { lens: Some(lens), .. } = &mut projection
            && let FocusDescription::Point(point) = &mut lens.focus
        {
            *point = center + view;
            if (*point - center).dot(aim_direction(aim, center)) <= 0.0 {
                return None;
            }
        }
        (!parallel).then_some(CameraDescription { center, aim, up, projection, width, height, motion })
    })
}

fn aim_direction(aim: DirectionOrTarget, center: DVec3) -> DVec3 {
    match aim {
        DirectionOrTarget::Direction(direction) => direction,
        DirectionOrTarget::Target(point) => point - center,
    }
}

fn random_projection() -> impl Strategy<Value = ProjectionDescription> {
    let aperture = prop_oneof![
        prop_oneof![Just(0.0), random_positive()].prop_map(ApertureDescription::Radius),
        (random_positive(), random_positive())
            .prop_map(|(number, sensor_height)| ApertureDescription::FNumber { number, sensor_height }),
    ];
    // `random_camera` moves the point to the front of the camera.
    let focus =
        prop_oneof![random_positive().prop_map(FocusDescription::Distance), Just(FocusDescription::Point(DVec3::ZERO))];
    let blades = prop_oneof![Just(0), 3..=64_u32];
    let lens =
        (aperture, focus, blades).prop_map(|(aperture, focus, blades)| LensDescription { aperture, focus, blades });
    prop_oneof![
        (1e-9..179.999, option::of(lens))
            .prop_map(|(vertical_fov_degrees, lens)| ProjectionDescription::Perspective { vertical_fov_degrees, lens }),
        (1e-12..1e12).prop_map(|view_height| ProjectionDescription::Orthographic { view_height }),
        Just(ProjectionDescription::Panorama),
    ]
}
