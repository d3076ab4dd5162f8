//! Random descriptions for proptest, with every feature of the language.

use glam::{DMat4, DVec2, DVec3, DVec4};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::super::description::*;
use super::media::{fill_bodies_with_random_media, random_media};
use super::refraction::random_refractive_index;
use super::values::*;

fn random_camera() -> impl Strategy<Value = CameraDescription> {
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

fn random_light() -> impl Strategy<Value = LightDescription> {
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

fn random_environment_light() -> impl Strategy<Value = LightDescription> {
    let picture = (random_name(), random_positive(), random_finite_number())
        .prop_map(|(path, scale, rotate)| EnvironmentRadiance::Picture { path: with_empty_span(path), scale, rotate });
    prop_oneof![random_color().prop_map(EnvironmentRadiance::Constant), picture].prop_map(LightDescription::Environment)
}

fn random_vec2() -> impl Strategy<Value = DVec2> {
    [random_finite_number(), random_finite_number()].prop_map(DVec2::from_array)
}

fn random_texture_kind() -> impl Strategy<Value = TextureKindDescription> {
    let part = || prop_oneof![-1e3..-1e-3, 1e-3..1e3];
    let coordinates = || {
        ([part(), part()].prop_map(DVec2::from_array), random_finite_number(), random_vec2()).prop_map(
            |(scale, rotate, offset)| TexcoordTransformDescription { scale, rotation_degrees: rotate, offset },
        )
    };
    let encoding = prop_oneof![Just(PictureEncoding::Srgb), Just(PictureEncoding::Linear)];
    let wrap = prop_oneof![Just(WrapMode::Repeat), Just(WrapMode::Clamp), Just(WrapMode::Mirror)];
    let pattern = prop_oneof![
        Just(SolidPatternDescription::Noise),
        Just(SolidPatternDescription::Marble),
        Just(SolidPatternDescription::Wood)
    ];
    let noise = (1..=16_u32, 1e-9..1e9, random_positive());
    prop_oneof![
        (random_name(), encoding, wrap, coordinates()).prop_map(|(path, encoding, wrap, uv_transform)| {
            TextureKindDescription::Image { path: with_empty_span(path), encoding, wrap, uv_transform }
        }),
        ([random_color(), random_color()], coordinates())
            .prop_map(|(colors, uv_transform)| TextureKindDescription::Checker { colors, uv_transform }),
        (pattern, [random_color(), random_color()], noise, vec(random_transform_step(), 0..3)).prop_map(
            |(pattern, colors, (octaves, frequency, amplitude), steps)| TextureKindDescription::Solid {
                pattern,
                colors,
                octaves,
                frequency,
                amplitude,
                steps,
            }
        ),
    ]
}

/// Returns a random constant, or a texture number that [`assign_texture_name`] replaces by a name.
fn random_textured_value<T: std::fmt::Debug + Clone>(
    plain: impl Strategy<Value = T>,
) -> impl Strategy<Value = TexturedValue<T>> {
    (plain, option::weighted(0.3, any::<u8>())).prop_map(|(plain, texture)| match texture {
        Some(i) => TexturedValue::Texture(with_empty_span(i.to_string())),
        None => TexturedValue::Constant(plain),
    })
}

/// Replaces a texture number by the name of one of `textures`, or by `plain` if there are none.
fn assign_texture_name<T>(value: &mut TexturedValue<T>, textures: &[Spanned<TextureDescription>], plain: T) {
    if let TexturedValue::Texture(name) = value {
        let number: usize = name.value.parse().unwrap();
        match textures.get(number % textures.len().max(1)) {
            Some(texture) => name.value = texture.value.name.clone(),
            None => *value = TexturedValue::Constant(plain),
        }
    }
}

fn assign_texture_names(material: &mut MaterialDescription, textures: &[Spanned<TextureDescription>]) {
    match &mut material.kind {
        MaterialKindDescription::Phong(PhongDescription { diffuse, specular, .. }) => {
            assign_texture_name(diffuse, textures, DVec3::ONE);
            assign_texture_name(specular, textures, DVec3::ONE);
        }
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: tint })
        | MaterialKindDescription::Mirror(MirrorDescription { reflectance: tint })
        | MaterialKindDescription::Thin(ThinDielectricDescription { transmittance: tint, .. }) => {
            assign_texture_name(tint, textures, DVec3::ONE)
        }
        MaterialKindDescription::Dielectric(DielectricDescription { roughness: degree, .. })
        | MaterialKindDescription::Mix(MixDescription { second_probability: degree, .. }) => {
            assign_texture_name(degree, textures, 0.5)
        }
        MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, .. }) => {
            if let MetalDescription::Reflectance(reflectance) = metal {
                assign_texture_name(reflectance, textures, DVec3::ONE);
            }
            assign_texture_name(roughness, textures, 0.5);
        }
        MaterialKindDescription::Principled(principled) => {
            assign_texture_name(&mut principled.base_color, textures, DVec3::ONE);
            let PrincipledDescription { metallic, roughness, transmission, clearcoat, .. } = principled;
            for number in [metallic, roughness, transmission, clearcoat] {
                assign_texture_name(number, textures, 0.5);
            }
        }
        MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription { reflectance, roughness, .. }) => {
            assign_texture_name(reflectance, textures, DVec3::ONE);
            assign_texture_name(roughness, textures, 0.5);
        }
        MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription { reflectance, transmittance }) => {
            assign_texture_name(reflectance, textures, DVec3::ONE);
            assign_texture_name(transmittance, textures, DVec3::ONE);
        }
        MaterialKindDescription::NullInterface(_) => {}
    }
    if let Some(EmissionDescription::Texture { name, .. }) = &mut material.emission {
        let number: usize = name.value.parse().unwrap();
        match textures.get(number % textures.len().max(1)) {
            Some(texture) => name.value = texture.value.name.clone(),
            None => material.emission = None,
        }
    }
}

fn random_emission() -> impl Strategy<Value = EmissionDescription> {
    prop_oneof![
        random_color().prop_map(EmissionDescription::Constant),
        (any::<u8>(), random_positive())
            .prop_map(|(i, scale)| EmissionDescription::Texture { name: with_empty_span(i.to_string()), scale }),
    ]
}

fn random_normal_perturbation() -> impl Strategy<Value = NormalPerturbationDescription> {
    prop_oneof![
        (random_name(), -1e30..1e30).prop_map(|(texture, height)| NormalPerturbationDescription::Bump {
            texture: with_empty_span(texture),
            height
        }),
        random_name().prop_map(|texture| NormalPerturbationDescription::NormalMap(with_empty_span(texture))),
    ]
}

/// Returns the textures of `drafts`, without those that repeat a name.
fn textures_with_unique_names(drafts: Vec<(String, TextureKindDescription)>) -> Vec<Spanned<TextureDescription>> {
    let mut textures: Vec<Spanned<TextureDescription>> = Vec::new();
    for (name, kind) in drafts {
        if textures.iter().all(|other| other.value.name != name) {
            textures.push(with_empty_span(TextureDescription { name, kind }));
        }
    }
    textures
}

/// Kind, emission and normal perturbation of a material.
type MaterialParts = (MaterialKindDescription, Option<EmissionDescription>, Option<NormalPerturbationDescription>);

fn random_material_parts() -> impl Strategy<Value = MaterialParts> {
    let absorption = || {
        prop_oneof![
            Just(DielectricAbsorption::None),
            random_coefficients().prop_map(DielectricAbsorption::Coefficient),
            (random_fractions(), 1e-9..1e30)
                .prop_map(|(color, distance)| DielectricAbsorption::Tint { color, distance }),
        ]
    };
    let share = || random_textured_value(0.0..=1.0);
    let index = || 1e-3..=1e3;
    let indices = || [index(), index(), index()].prop_map(DVec3::from_array);
    let metal = prop_oneof![
        random_name().prop_map(|name| MetalDescription::Named(with_empty_span(name))),
        (indices(), random_fractions()).prop_map(|(eta, k)| MetalDescription::Index { eta, k: 1e3 * k }),
        random_textured_value(random_fractions()).prop_map(MetalDescription::Reflectance),
    ];
    let kind = prop_oneof![
        (
            random_textured_value(random_color()),
            random_textured_value(random_color()),
            random_positive(),
            option::of(random_name())
        )
            .prop_map(|(diffuse, specular, shininess, texture)| MaterialKindDescription::Phong(
                PhongDescription { diffuse, specular, shininess, texture: texture.map(with_empty_span) }
            )),
        random_textured_value(random_fractions())
            .prop_map(|reflectance| MaterialKindDescription::Diffuse(DiffuseDescription { reflectance })),
        (
            random_textured_value(random_fractions()),
            [share(), share(), share(), share()],
            (1.0..=4.0, 0.0..=1.0),
            absorption(),
            any::<bool>()
        )
            .prop_map(
                |(
                    base_color,
                    [metallic, roughness, transmission, clearcoat],
                    (eta, clearcoat_roughness),
                    absorption,
                    has_multiple_scattering,
                )| {
                    PrincipledDescription {
                        base_color,
                        metallic,
                        roughness,
                        eta,
                        transmission,
                        absorption,
                        clearcoat,
                        clearcoat_roughness,
                        has_multiple_scattering,
                    }
                    .into()
                }
            ),
        (random_textured_value(random_fractions()), random_textured_value(random_fractions())).prop_map(
            |(reflectance, transmittance)| { DiffuseTransmissionDescription { reflectance, transmittance }.into() }
        ),
        random_textured_value(random_fractions())
            .prop_map(|reflectance| MaterialKindDescription::Mirror(MirrorDescription { reflectance })),
        (random_refractive_index(), absorption(), random_textured_value(0.0..=1.0), any::<(bool, u8)>()).prop_map(
            |(refraction, absorption, roughness, (has_multiple_scattering, priority))| {
                MaterialKindDescription::Dielectric(DielectricDescription {
                    refraction,
                    absorption,
                    roughness,
                    has_multiple_scattering,
                    priority,
                })
            }
        ),
        (metal, random_textured_value(0.0..=1.0), any::<bool>()).prop_map(
            |(metal, roughness, has_multiple_scattering)| {
                MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, has_multiple_scattering })
            }
        ),
        (index(), random_textured_value(random_fractions())).prop_map(|(eta, transmittance)| {
            MaterialKindDescription::Thin(ThinDielectricDescription { eta, transmittance })
        }),
        (random_textured_value(random_fractions()), 1.0..=4.0, random_textured_value(0.0..=1.0), any::<bool>())
            .prop_map(|(reflectance, eta, roughness, is_nonlinear)| MaterialKindDescription::CoatedDiffuse(
                CoatedDiffuseDescription { reflectance, eta, roughness, is_nonlinear }
            )),
    ];
    (kind, option::of(random_emission()), option::of(random_normal_perturbation()))
}

fn random_curve() -> impl Strategy<Value = ProfileCurve> {
    (vec(random_point(), 4..7), any::<bool>()).prop_map(|(controls, bezier)| {
        let basis = if bezier { CurveBasis::Bezier } else { CurveBasis::Bspline };
        ProfileCurve { basis, controls }
    })
}

fn random_weighted_point() -> impl Strategy<Value = DVec4> {
    (random_point(), prop_oneof![Just(1.0), random_positive()])
        .prop_filter_map("no weight", |(p, w)| (w > 0.0).then(|| p.extend(w)))
}

fn random_knots(count: usize) -> impl Strategy<Value = Vec<f64>> {
    vec(random_finite_number(), count).prop_map(|mut knots| {
        knots.sort_by(f64::total_cmp);
        knots
    })
}

fn random_shape() -> impl Strategy<Value = ShapeDescription> {
    prop_oneof![
        (random_point(), random_positive())
            .prop_map(|(center, radius)| ShapeDescription::Sphere(SphereDescription { center, radius })),
        (random_direction(), random_finite_number())
            .prop_map(|(normal, offset)| ShapeDescription::Plane(PlaneDescription { normal, offset })),
        (random_point(), random_direction(), random_positive())
            .prop_map(|(center, normal, radius)| ShapeDescription::Disc(DiscDescription { center, normal, radius })),
        random_corner_and_edges().prop_map(|(corner, edge0, edge1)| ShapeDescription::Rectangle(
            RectangleDescription { corner, edge0, edge1 }
        )),
        (random_point(), [random_positive(), random_positive(), random_positive()]).prop_filter_map(
            "no extent",
            |(min, size)| {
                let max = min + DVec3::from_array(size);
                (max.is_finite() && max.cmpgt(min).all()).then_some(ShapeDescription::Box(BoxDescription { min, max }))
            }
        ),
        ([random_point(), random_point()], random_positive(), any::<bool>()).prop_filter_map(
            "no length",
            |(ends, radius, is_capped)| {
                (ends[0] != ends[1]).then_some(ShapeDescription::Cylinder(CylinderDescription {
                    ends,
                    radius,
                    is_capped,
                }))
            }
        ),
        ([random_point(), random_point()], random_positive(), option::of(random_positive()), any::<bool>())
            .prop_filter_map("no length", |(ends, radius, top, is_capped)| {
                let radii = [radius, top.unwrap_or(0.0)];
                (ends[0] != ends[1]).then_some(ShapeDescription::Cone(ConeDescription { ends, radii, is_capped }))
            }),
        (
            [random_point(), random_point(), random_point()],
            option::of([random_direction(), random_direction(), random_direction()]),
            option::of([random_vec2(), random_vec2(), random_vec2()].prop_map(Box::new))
        )
            .prop_map(|(vertices, normals, texcoords)| ShapeDescription::Triangle(TriangleDescription {
                vertices,
                normals,
                texcoords
            })),
        (random_mesh_path(), any::<bool>(), any::<bool>(), option::of(0.0..=180.0)).prop_map(
            |(path, uses_file_materials, ignores_normals, max_smoothing_angle)| {
                let options = MeshOptions { uses_file_materials, ignores_normals, max_smoothing_angle };
                ShapeDescription::Mesh(MeshDescription { path: with_empty_span(path), options })
            }
        ),
        random_curve().prop_map(|profile| ShapeDescription::Revolution(RevolutionDescription { profile })),
        vec(random_point(), 4..7).prop_map(|controls| BezierCurveDescription { controls }.into()),
        vec(random_point(), 4..7).prop_map(|controls| BsplineCurveDescription { controls }.into()),
        (vec(random_weighted_point(), 8), any::<bool>()).prop_map(|(controls, once)| {
            if once {
                ShapeDescription::Patches(BezierPatchesDescription { degree: [3, 1], controls })
            } else {
                ShapeDescription::Patches(BezierPatchesDescription { degree: [1, 1], controls })
            }
        }),
        (vec(random_weighted_point(), 12), option::of(random_knots(6)), option::of(random_knots(6))).prop_map(
            |(controls, u, v)| {
                let knots = [u.unwrap_or_default(), v.unwrap_or_default()];
                ShapeDescription::Nurbs(NurbsDescription { degree: [2, 1], control_counts: [3, 4], knots, controls })
            }
        ),
    ]
}

fn random_mesh_path() -> impl Strategy<Value = String> {
    (random_name(), any::<bool>()).prop_map(|(name, ply)| if ply { name + ".ply" } else { name })
}

pub fn random_transform_step() -> impl Strategy<Value = TransformStep> {
    let scale = || prop_oneof![0.01..100.0, -100.0..-0.01];
    let angle = || -1e3..1e3;
    prop_oneof![
        [scale(), scale(), scale()].prop_map(|s| TransformStep::Scale(DVec3::from_array(s))),
        scale().prop_map(TransformStep::UniformScale),
        random_direction().prop_map(TransformStep::Translate),
        angle().prop_map(TransformStep::RotateX),
        angle().prop_map(TransformStep::RotateY),
        angle().prop_map(TransformStep::RotateZ),
        (random_direction(), angle()).prop_map(|(axis, angle)| TransformStep::Rotate { axis, angle }),
        ([scale(), scale(), scale()], random_direction()).prop_map(|(s, t)| {
            TransformStep::Matrix(DMat4::from_translation(t) * DMat4::from_scale(DVec3::from_array(s)))
        }),
    ]
}

/// Returns a random step of a motion. If `scales` is false, it is no scale.
fn random_motion_step(scales: bool) -> impl Strategy<Value = TransformStep> {
    random_transform_step().prop_filter("cannot grow", move |map| match *map {
        TransformStep::Matrix(_) => false,
        TransformStep::Scale(s) => scales && s.min_element() > 0.0,
        TransformStep::UniformScale(s) => scales && s > 0.0,
        _ => true,
    })
}

pub fn with_empty_span<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}

/// Returns a random group item. [`replace_material_numbers`] replaces its random material number.
fn random_group_item() -> impl Strategy<Value = GroupItem> {
    let leaf = (random_shape(), option::of(random_color()))
        .prop_map(|(shape, emission)| ObjectDescription::Shape { shape, emission });
    let object = leaf.prop_recursive(4, 24, 4, |inner| {
        let grouped = prop_oneof![
            3 => inner.clone().prop_map(|object| GroupItem::Object(with_empty_span(object))),
            1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(with_empty_span(i))),
        ];
        prop_oneof![
            vec(grouped, 0..4).prop_map(|items| ObjectDescription::Group(ObjectGroup { items })),
            (vec(random_transform_step(), 0..3), inner.clone()).prop_map(|(steps, object)| {
                ObjectDescription::Transform { steps, object: Box::new(with_empty_span(object)) }
            }),
            (vec(random_motion_step(true), 0..3), inner).prop_map(|(steps, object)| ObjectDescription::Moving {
                steps,
                object: Box::new(with_empty_span(object))
            }),
        ]
    });
    prop_oneof![
        3 => object.prop_map(|object| GroupItem::Object(with_empty_span(object))),
        1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(with_empty_span(i))),
    ]
}

/// Replaces the random material numbers in `group` by valid indices and names of `materials`.
fn replace_material_numbers(group: &mut ObjectGroup, materials: &[Spanned<MaterialDescription>]) {
    fn replace_material_numbers_in_object(object: &mut ObjectDescription, materials: &[Spanned<MaterialDescription>]) {
        match object {
            ObjectDescription::Group(group) => replace_material_numbers(group, materials),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                replace_material_numbers_in_object(&mut object.value, materials)
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    group.items.retain(|item| !materials.is_empty() || matches!(item, GroupItem::Object(_)));
    for item in &mut group.items {
        if let GroupItem::MaterialIndex(number) = item {
            let index = number.value as usize % materials.len();
            match &materials[index].value.name {
                Some(name) if number.value & (1 << 20) == 0 => {
                    *item = GroupItem::MaterialName(with_empty_span(name.clone()))
                }
                _ => number.value = index as u32,
            }
        } else if let GroupItem::Object(object) = item {
            replace_material_numbers_in_object(&mut object.value, materials);
        }
    }
}

/// Draft of a material: name, parts, and for a mix both component numbers and the amount.
type MaterialDraft =
    (Option<String>, MaterialParts, Option<(prop::sample::Index, prop::sample::Index, TexturedValue<f64>)>);

/// Builds materials from `drafts`.
///
/// A draft with a mix becomes a mix of two earlier materials, unless they contain two different
/// dielectrics.
fn build_materials(
    drafts: Vec<MaterialDraft>,
    textures: &[Spanned<TextureDescription>],
) -> Vec<Spanned<MaterialDescription>> {
    let mut materials: Vec<Spanned<MaterialDescription>> = Vec::new();
    let mut names: Vec<(String, Option<usize>)> = Vec::new();
    for (i, (name, (mut kind, emission, mut normal_perturbation), mix)) in drafts.into_iter().enumerate() {
        let mut body = matches!(kind, MaterialKindDescription::Dielectric(_) | MaterialKindDescription::Principled(_))
            .then_some(i);
        if let (Some((first, second, amount)), false) = (mix, names.is_empty()) {
            let [(first, a), (second, b)] = [first, second].map(|part| &names[part.index(names.len())]);
            if a.is_none() || b.is_none() || a == b {
                let [first, second] = [first, second].map(|name| with_empty_span(name.clone()));
                (kind, body, normal_perturbation) = (
                    MaterialKindDescription::Mix(MixDescription { first, second, second_probability: amount }),
                    a.or(*b),
                    None,
                );
            }
        }
        let name = name.filter(|name| names.iter().all(|(other, _)| other != name));
        names.extend(name.clone().map(|name| (name, body)));
        let mut material = MaterialDescription { name, kind, emission, normal_perturbation, medium: None };
        assign_texture_names(&mut material, textures);
        materials.push(with_empty_span(material));
    }
    materials
}

pub fn random_description() -> impl Strategy<Value = SceneDescription> {
    let part = any::<prop::sample::Index>;
    let drafts = vec(
        (
            option::of(random_name()),
            random_material_parts(),
            option::of((part(), part(), random_textured_value(0.0..=1.0))),
        ),
        0..6,
    );
    let textured = vec((random_name(), random_texture_kind()), 0..4);
    let lights = (vec(random_light(), 0..4), option::of((random_environment_light(), part())));
    let filled = (random_media(), vec(option::of(part()), 6), option::of(part()));
    let parts = (random_camera(), random_color(), lights, textured, filled, drafts, vec(random_group_item(), 0..4));
    parts.prop_map(|(camera, background, (mut lights, environment), textured, filled, drafts, items)| {
        if let Some((environment, at)) = environment {
            lights.insert(at.index(lights.len() + 1), environment);
        }
        let textures = textures_with_unique_names(textured);
        let mut materials = build_materials(drafts, &textures);
        let (media, fills, ambient_medium) = filled;
        fill_bodies_with_random_media(&mut materials, &media, &fills);
        let ambient_medium =
            ambient_medium.filter(|_| !media.is_empty()).map(|i| with_empty_span(i.get(&media).value.name.clone()));
        let mut root = ObjectGroup { items };
        replace_material_numbers(&mut root, &materials);
        let lights = lights.into_iter().map(with_empty_span).collect();
        SceneDescription {
            camera: with_empty_span(camera),
            background,
            ambient_medium,
            lights,
            textures,
            media,
            materials,
            root,
        }
    })
}
