use super::*;

fn place() -> PbrtSourceLocation {
    PbrtSourceLocation { file: "test".into(), line: 1 }
}

/// pbrt's camera looks along +z, with +x to the right.
#[test]
fn look_at_maps_the_view_to_z() {
    let map = directive_transform("LookAt", &[1.0, 2.0, 3.0, 1.0, 2.0, 13.0, 0.0, 1.0, 0.0], &place()).unwrap();
    assert!(map.transform_point3(DVec3::new(1.0, 2.0, 8.0)).abs_diff_eq(5.0 * DVec3::Z, 1e-12));
    assert!(map.transform_vector3(DVec3::X).abs_diff_eq(DVec3::X, 1e-12));
}

#[test]
fn matrices_are_in_column_order() {
    let mut numbers = DMat4::IDENTITY.to_cols_array();
    numbers[12..15].copy_from_slice(&[1.0, 2.0, 3.0]);
    let map = directive_transform("Transform", &numbers, &place()).unwrap();
    assert_eq!(map.translation, DVec3::new(1.0, 2.0, 3.0));
    numbers[3] = 1.0;
    assert!(directive_transform("Transform", &numbers, &place()).is_err());
}

#[test]
fn motions_are_split_into_translation_and_rotation() {
    let start = DAffine3::from_translation(DVec3::X);
    let end = DAffine3::from_translation(DVec3::new(1.0, 4.0, 0.0)) * DAffine3::from_rotation_z(0.5);
    let motion = object_motion(&MovingTransform([start, end])).unwrap();
    assert_eq!((motion.rotation_center, motion.omits_deformation), (DVec3::X, false));
    let around = DAffine3::from_translation(motion.rotation_center);
    let full = around * TransformStep::composed_matrix(&motion.steps) * around.inverse() * start;
    assert!(full.abs_diff_eq(end, 1e-12));
    let scaled = MovingTransform([start, start * DAffine3::from_scale(DVec3::splat(2.0))]);
    assert!(object_motion(&scaled).unwrap().omits_deformation);
    assert!(object_motion(&MovingTransform([start; 2])).is_none());
}

#[test]
fn motion_within_the_shutter_has_constant_speed() {
    let at = |time: f64| {
        let turn = DAffine3::from_rotation_z((90.0 * time).to_radians());
        DAffine3::from_translation(4.0 * time * DVec3::Y) * turn * DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0))
    };
    let within = MovingTransform([at(0.0), at(1.0)]).at_fractions([0.25, 0.75]);
    assert!(within.0[0].abs_diff_eq(at(0.25), 1e-12) && within.0[1].abs_diff_eq(at(0.75), 1e-12), "{within:?}");
    // Objects rest before fraction 0 and after fraction 1.
    let whole = MovingTransform([at(0.0), at(1.0)]);
    assert_eq!(whole.at_fractions([-1.0, 2.0]), whole);
    assert!(whole.at_fractions([1.0, 2.0]).is_still());
}
