//! Random descriptions for proptest, with every feature of the language.

use glam::{DMat4, DVec2, DVec3, DVec4};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::super::description::*;
use super::media::{fill, media};
use super::refraction::refraction;
use super::values::*;

fn camera() -> impl Strategy<Value = CameraDescription> {
    let size = || 1..=65_536_u32;
    let views = (edges(), any::<bool>(), projection(), size(), size(), vec(grown(false), 0..3));
    views.prop_filter_map("no view", |((center, view, up), aimed, mut projection, width, height, motion)| {
        let lookat =
            aimed.then_some(center + view).filter(|p| (*p - center).normalize().cross(up.normalize()).length() > 1e-6);
        let aim = lookat.map_or(DirectionOrTarget::Direction(view), DirectionOrTarget::LookAt);
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
        DirectionOrTarget::LookAt(point) => point - center,
    }
}

fn projection() -> impl Strategy<Value = ProjectionDescription> {
    let aperture = prop_oneof![
        prop_oneof![Just(0.0), positive()].prop_map(ApertureDescription::Radius),
        (positive(), positive()).prop_map(|(number, sensor)| ApertureDescription::FNumber { number, sensor }),
    ];
    // The point is put before the camera once that is known.
    let focus =
        prop_oneof![positive().prop_map(FocusDescription::Distance), Just(FocusDescription::Point(DVec3::ZERO))];
    let blades = prop_oneof![Just(0), 3..=64_u32];
    let lens =
        (aperture, focus, blades).prop_map(|(aperture, focus, blades)| LensDescription { aperture, focus, blades });
    prop_oneof![
        (1e-9..179.999, option::of(lens)).prop_map(|(angle, lens)| ProjectionDescription::Perspective { angle, lens }),
        (1e-12..1e12).prop_map(|size| ProjectionDescription::Orthographic { size }),
        Just(ProjectionDescription::Environment),
    ]
}

fn point_strength() -> impl Strategy<Value = PointLightStrength> {
    (colour(), 0..3).prop_map(|(c, kind)| match kind {
        0 => PointLightStrength::Color(c),
        1 => PointLightStrength::Intensity(c),
        _ => PointLightStrength::Power(c),
    })
}

fn area_strength() -> impl Strategy<Value = AreaLightStrength> {
    (colour(), any::<bool>())
        .prop_map(|(c, power)| if power { AreaLightStrength::Power(c) } else { AreaLightStrength::Radiance(c) })
}

fn light() -> impl Strategy<Value = LightDescription> {
    (still_light(), option::of(vec(grown(true), 0..3))).prop_map(|(light, motion)| match motion {
        Some(maps) => LightDescription::Moving { maps, light: Box::new(spanned(light)) },
        None => light,
    })
}

fn still_light() -> impl Strategy<Value = LightDescription> {
    prop_oneof![
        (point(), point_strength()).prop_map(|(position, strength)| LightDescription::Point { position, strength }),
        (direction(), colour(), any::<bool>()).prop_map(|(direction, c, physical)| {
            let strength =
                if physical { DirectionalLightStrength::Irradiance(c) } else { DirectionalLightStrength::Color(c) };
            LightDescription::Directional { direction, strength }
        }),
        (point(), direction(), 1e-9..=360.0, 0.0..=0.5, point_strength()).prop_map(
            |(position, axis, angle, rim, strength)| {
                let aim = DirectionOrTarget::Direction(axis);
                LightDescription::Spot { position, aim, angle, penumbra: rim * angle, strength }
            }
        ),
        (point(), direction(), name(), 1e-9..180.0, colour(), 0..3u8).prop_map(
            |(position, axis, path, angle, c, kind)| {
                let path = spanned(path);
                let pattern = match kind {
                    0 => LightPattern::Picture { path, angle },
                    1 => LightPattern::Map(path),
                    _ => LightPattern::Profile(path),
                };
                let (aim, strength) = (DirectionOrTarget::Direction(axis), PointLightStrength::Intensity(c));
                LightDescription::Oriented { position, aim, up: None, pattern, strength }
            }
        ),
        (point(), positive(), area_strength()).prop_map(|(center, radius, strength)| LightDescription::Sphere {
            center,
            radius,
            strength
        }),
        (point(), direction(), positive(), area_strength())
            .prop_map(|(center, normal, radius, strength)| LightDescription::Disc { center, normal, radius, strength }),
        (edges(), area_strength()).prop_map(|((corner, edge0, edge1), strength)| LightDescription::Rectangle {
            corner,
            edge0,
            edge1,
            strength
        }),
    ]
}

fn environment() -> impl Strategy<Value = LightDescription> {
    let picture = (name(), positive(), finite()).prop_map(|(path, scale, rotate)| EnvironmentRadiance::Picture {
        path: spanned(path),
        scale,
        rotate,
    });
    prop_oneof![colour().prop_map(EnvironmentRadiance::Constant), picture].prop_map(LightDescription::Environment)
}

fn pair() -> impl Strategy<Value = DVec2> {
    [finite(), finite()].prop_map(DVec2::from_array)
}

fn texture() -> impl Strategy<Value = TextureKindDescription> {
    let part = || prop_oneof![-1e3..-1e-3, 1e-3..1e3];
    let coordinates = || {
        ([part(), part()].prop_map(DVec2::from_array), finite(), pair())
            .prop_map(|(scale, rotate, offset)| TexcoordTransformDescription { scale, rotate, offset })
    };
    let encoding = prop_oneof![Just(PictureEncoding::Srgb), Just(PictureEncoding::Linear)];
    let wrap = prop_oneof![Just(WrapMode::Repeat), Just(WrapMode::Clamp), Just(WrapMode::Mirror)];
    let pattern = prop_oneof![
        Just(SolidPatternDescription::Noise),
        Just(SolidPatternDescription::Marble),
        Just(SolidPatternDescription::Wood)
    ];
    let noise = (1..=16_u32, 1e-9..1e9, positive());
    prop_oneof![
        (name(), encoding, wrap, coordinates()).prop_map(|(path, encoding, wrap, coordinates)| {
            TextureKindDescription::Image { path: spanned(path), encoding, wrap, coordinates }
        }),
        ([colour(), colour()], coordinates())
            .prop_map(|(colors, coordinates)| TextureKindDescription::Checker { colors, coordinates }),
        (pattern, [colour(), colour()], noise, vec(map(), 0..3)).prop_map(
            |(pattern, colors, (octaves, frequency, amplitude), maps)| TextureKindDescription::Solid {
                pattern,
                colors,
                octaves,
                frequency,
                amplitude,
                maps,
            }
        ),
    ]
}

/// Numbers, or a texture by its number, to be taken modulo how many there are.
fn value<T: std::fmt::Debug + Clone>(plain: impl Strategy<Value = T>) -> impl Strategy<Value = TexturedValue<T>> {
    (plain, option::weighted(0.3, any::<u8>())).prop_map(|(plain, texture)| match texture {
        Some(i) => TexturedValue::Texture(spanned(i.to_string())),
        None => TexturedValue::Plain(plain),
    })
}

/// Turns numbers of textures into names of `textures`; without any, the value is `plain`.
fn name_texture<T>(value: &mut TexturedValue<T>, textures: &[Spanned<TextureDescription>], plain: T) {
    if let TexturedValue::Texture(name) = value {
        let number: usize = name.value.parse().unwrap();
        match textures.get(number % textures.len().max(1)) {
            Some(texture) => name.value = texture.value.name.clone(),
            None => *value = TexturedValue::Plain(plain),
        }
    }
}

fn name_textures(material: &mut MaterialDescription, textures: &[Spanned<TextureDescription>]) {
    match &mut material.kind {
        MaterialKindDescription::Phong { diffuse, specular, .. } => {
            name_texture(diffuse, textures, DVec3::ONE);
            name_texture(specular, textures, DVec3::ONE);
        }
        MaterialKindDescription::Diffuse { reflectance: tint }
        | MaterialKindDescription::Mirror { reflectance: tint }
        | MaterialKindDescription::Thin { transmittance: tint, .. } => name_texture(tint, textures, DVec3::ONE),
        MaterialKindDescription::Dielectric { roughness: degree, .. }
        | MaterialKindDescription::Conductor { roughness: degree, .. }
        | MaterialKindDescription::Mix { amount: degree, .. } => name_texture(degree, textures, 0.5),
        MaterialKindDescription::Clear { .. } => {}
    }
    if let Some(EmissionDescription::Texture { name, .. }) = &mut material.emission {
        let number: usize = name.value.parse().unwrap();
        match textures.get(number % textures.len().max(1)) {
            Some(texture) => name.value = texture.value.name.clone(),
            None => material.emission = None,
        }
    }
}

fn emission() -> impl Strategy<Value = EmissionDescription> {
    prop_oneof![
        colour().prop_map(EmissionDescription::Radiance),
        (any::<u8>(), positive())
            .prop_map(|(i, scale)| EmissionDescription::Texture { name: spanned(i.to_string()), scale }),
    ]
}

fn normal_perturbation() -> impl Strategy<Value = NormalPerturbationDescription> {
    prop_oneof![
        (name(), -1e30..1e30)
            .prop_map(|(texture, height)| NormalPerturbationDescription::Bump { texture: spanned(texture), height }),
        name().prop_map(|texture| NormalPerturbationDescription::NormalMap(spanned(texture))),
    ]
}

/// Textures of these kinds and names, all different.
fn textures(drafts: Vec<(String, TextureKindDescription)>) -> Vec<Spanned<TextureDescription>> {
    let mut textures: Vec<Spanned<TextureDescription>> = Vec::new();
    for (name, kind) in drafts {
        if textures.iter().all(|other| other.value.name != name) {
            textures.push(spanned(TextureDescription { name, kind }));
        }
    }
    textures
}

/// A material without its name and without the parts of a mix.
type Finish = (MaterialKindDescription, Option<EmissionDescription>, Option<NormalPerturbationDescription>);

fn material() -> impl Strategy<Value = Finish> {
    let attenuation = prop_oneof![
        Just(DielectricAbsorption::None),
        coefficient().prop_map(DielectricAbsorption::Coefficient),
        (share(), 1e-9..1e30).prop_map(|(color, distance)| DielectricAbsorption::Tint { color, distance }),
    ];
    let index = || 1e-3..=1e3;
    let indices = || [index(), index(), index()].prop_map(DVec3::from_array);
    let metal = prop_oneof![
        name().prop_map(|name| MetalDescription::Named(spanned(name))),
        (indices(), share()).prop_map(|(eta, k)| MetalDescription::Index { eta, k: 1e3 * k }),
    ];
    let kind = prop_oneof![
        (value(colour()), value(colour()), positive(), option::of(name())).prop_map(
            |(diffuse, specular, shininess, texture)| MaterialKindDescription::Phong {
                diffuse,
                specular,
                shininess,
                texture: texture.map(spanned),
            }
        ),
        value(share()).prop_map(|reflectance| MaterialKindDescription::Diffuse { reflectance }),
        value(share()).prop_map(|reflectance| MaterialKindDescription::Mirror { reflectance }),
        (refraction(), attenuation, value(0.0..=1.0), any::<u8>()).prop_map(
            |(refraction, attenuation, roughness, priority)| MaterialKindDescription::Dielectric {
                refraction,
                attenuation,
                roughness,
                priority
            }
        ),
        (metal, value(0.0..=1.0))
            .prop_map(|(metal, roughness)| MaterialKindDescription::Conductor { metal, roughness }),
        (index(), value(share()))
            .prop_map(|(index, transmittance)| MaterialKindDescription::Thin { index, transmittance }),
    ];
    (kind, option::of(emission()), option::of(normal_perturbation()))
}

fn curve() -> impl Strategy<Value = ProfileCurve> {
    (vec(point(), 4..7), any::<bool>()).prop_map(|(controls, bezier)| {
        let basis = if bezier { CurveBasis::Bezier } else { CurveBasis::Bspline };
        ProfileCurve { basis, controls }
    })
}

fn weighed() -> impl Strategy<Value = DVec4> {
    (point(), prop_oneof![Just(1.0), positive()]).prop_filter_map("no weight", |(p, w)| (w > 0.0).then(|| p.extend(w)))
}

fn knots(count: usize) -> impl Strategy<Value = Vec<f64>> {
    vec(finite(), count).prop_map(|mut knots| {
        knots.sort_by(f64::total_cmp);
        knots
    })
}

fn shape() -> impl Strategy<Value = ShapeDescription> {
    prop_oneof![
        (point(), positive()).prop_map(|(center, radius)| ShapeDescription::Sphere { center, radius }),
        (direction(), finite()).prop_map(|(normal, offset)| ShapeDescription::Plane { normal, offset }),
        (point(), direction(), positive()).prop_map(|(center, normal, radius)| ShapeDescription::Disc {
            center,
            normal,
            radius
        }),
        edges().prop_map(|(corner, edge0, edge1)| ShapeDescription::Rectangle { corner, edge0, edge1 }),
        (point(), [positive(), positive(), positive()]).prop_filter_map("no extent", |(min, size)| {
            let max = min + DVec3::from_array(size);
            (max.is_finite() && max.cmpgt(min).all()).then_some(ShapeDescription::Box { min, max })
        }),
        ([point(), point()], positive(), any::<bool>()).prop_filter_map("no length", |(ends, radius, is_capped)| {
            (ends[0] != ends[1]).then_some(ShapeDescription::Cylinder { ends, radius, is_capped })
        }),
        ([point(), point()], positive(), option::of(positive()), any::<bool>()).prop_filter_map(
            "no length",
            |(ends, radius, top, is_capped)| {
                let radii = [radius, top.unwrap_or(0.0)];
                (ends[0] != ends[1]).then_some(ShapeDescription::Cone { ends, radii, is_capped })
            }
        ),
        (
            [point(), point(), point()],
            option::of([direction(), direction(), direction()]),
            option::of([pair(), pair(), pair()].prop_map(Box::new))
        )
            .prop_map(|(vertices, normals, uv)| ShapeDescription::Triangle { vertices, normals, uv }),
        (mesh_path(), any::<bool>(), any::<bool>(), option::of(0.0..=180.0)).prop_map(
            |(path, uses_file_materials, ignores_normals, max_smoothing_angle)| {
                let options = MeshOptions { uses_file_materials, ignores_normals, max_smoothing_angle };
                ShapeDescription::Mesh { path: spanned(path), options }
            }
        ),
        curve().prop_map(|profile| ShapeDescription::Revolution { profile }),
        curve().prop_map(ShapeDescription::Curve),
        (vec(weighed(), 8), any::<bool>()).prop_map(|(controls, once)| {
            if once {
                ShapeDescription::Patches { degree: [3, 1], controls }
            } else {
                ShapeDescription::Patches { degree: [1, 1], controls }
            }
        }),
        (vec(weighed(), 12), option::of(knots(6)), option::of(knots(6))).prop_map(|(controls, u, v)| {
            let knots = [u.unwrap_or_default(), v.unwrap_or_default()];
            ShapeDescription::Nurbs { degree: [2, 1], count: [3, 4], knots, controls }
        }),
    ]
}

fn mesh_path() -> impl Strategy<Value = String> {
    (name(), any::<bool>()).prop_map(|(name, ply)| if ply { name + ".ply" } else { name })
}

pub fn map() -> impl Strategy<Value = TransformStep> {
    let scale = || prop_oneof![0.01..100.0, -100.0..-0.01];
    let angle = || -1e3..1e3;
    prop_oneof![
        [scale(), scale(), scale()].prop_map(|s| TransformStep::Scale(DVec3::from_array(s))),
        scale().prop_map(TransformStep::UniformScale),
        direction().prop_map(TransformStep::Translate),
        angle().prop_map(TransformStep::RotateX),
        angle().prop_map(TransformStep::RotateY),
        angle().prop_map(TransformStep::RotateZ),
        (direction(), angle()).prop_map(|(axis, angle)| TransformStep::Rotate { axis, angle }),
        ([scale(), scale(), scale()], direction()).prop_map(|(s, t)| {
            TransformStep::Matrix(DMat4::from_translation(t) * DMat4::from_scale(DVec3::from_array(s)))
        }),
    ]
}

/// A map that can grow while the shutter is open.
fn grown(scales: bool) -> impl Strategy<Value = TransformStep> {
    map().prop_filter("cannot grow", move |map| match *map {
        TransformStep::Matrix(_) => false,
        TransformStep::Scale(s) => scales && s.min_element() > 0.0,
        TransformStep::UniformScale(s) => scales && s > 0.0,
        _ => true,
    })
}

pub fn spanned<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}

/// An entry of a group; materials are numbers to be taken modulo how many there are.
fn item() -> impl Strategy<Value = GroupItem> {
    let leaf =
        (shape(), option::of(colour())).prop_map(|(shape, emission)| ObjectDescription::Shape { shape, emission });
    let object = leaf.prop_recursive(4, 24, 4, |inner| {
        let grouped = prop_oneof![
            3 => inner.clone().prop_map(|object| GroupItem::Object(spanned(object))),
            1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(spanned(i))),
        ];
        prop_oneof![
            vec(grouped, 0..4).prop_map(|items| ObjectDescription::Group(Group { items })),
            (vec(map(), 0..3), inner.clone())
                .prop_map(|(maps, object)| ObjectDescription::Transform { maps, object: Box::new(spanned(object)) }),
            (vec(grown(true), 0..3), inner)
                .prop_map(|(maps, object)| ObjectDescription::Moving { maps, object: Box::new(spanned(object)) }),
        ]
    });
    prop_oneof![
        3 => object.prop_map(|object| GroupItem::Object(spanned(object))),
        1 => any::<u32>().prop_map(|i| GroupItem::MaterialIndex(spanned(i))),
    ]
}

/// Turns numbers of materials into indices and names of `materials`.
fn name_materials(group: &mut Group, materials: &[Spanned<MaterialDescription>]) {
    fn enter(object: &mut ObjectDescription, materials: &[Spanned<MaterialDescription>]) {
        match object {
            ObjectDescription::Group(group) => name_materials(group, materials),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                enter(&mut object.value, materials)
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    group.items.retain(|item| !materials.is_empty() || matches!(item, GroupItem::Object(_)));
    for item in &mut group.items {
        if let GroupItem::MaterialIndex(number) = item {
            let index = number.value as usize % materials.len();
            match &materials[index].value.name {
                Some(name) if number.value & (1 << 20) == 0 => *item = GroupItem::MaterialName(spanned(name.clone())),
                _ => number.value = index as u32,
            }
        } else if let GroupItem::Object(object) = item {
            enter(&mut object.value, materials);
        }
    }
}

/// Name, look, and the parts of a mix.
type Outline = (Option<String>, Finish, Option<(prop::sample::Index, prop::sample::Index, TexturedValue<f64>)>);

/// Materials of these kinds and names; a requested mix, if possible, replaces the kind.
fn materials(drafts: Vec<Outline>, textures: &[Spanned<TextureDescription>]) -> Vec<Spanned<MaterialDescription>> {
    let mut materials: Vec<Spanned<MaterialDescription>> = Vec::new();
    let mut names: Vec<(String, Option<usize>)> = Vec::new();
    for (i, (name, (mut kind, emission, mut normal_perturbation), mix)) in drafts.into_iter().enumerate() {
        let mut body = matches!(kind, MaterialKindDescription::Dielectric { .. }).then_some(i);
        if let (Some((first, second, amount)), false) = (mix, names.is_empty()) {
            let [(first, a), (second, b)] = [first, second].map(|part| &names[part.index(names.len())]);
            if a.is_none() || b.is_none() || a == b {
                let [first, second] = [first, second].map(|name| spanned(name.clone()));
                (kind, body, normal_perturbation) =
                    (MaterialKindDescription::Mix { first, second, amount }, a.or(*b), None);
            }
        }
        let name = name.filter(|name| names.iter().all(|(other, _)| other != name));
        names.extend(name.clone().map(|name| (name, body)));
        let mut material = MaterialDescription { name, kind, emission, normal_perturbation, medium: None };
        name_textures(&mut material, textures);
        materials.push(spanned(material));
    }
    materials
}

pub fn description() -> impl Strategy<Value = SceneDescription> {
    let part = any::<prop::sample::Index>;
    let drafts = vec((option::of(name()), material(), option::of((part(), part(), value(0.0..=1.0)))), 0..6);
    let textured = vec((name(), texture()), 0..4);
    let lights = (vec(light(), 0..4), option::of((environment(), part())));
    let filled = (media(), vec(option::of(part()), 6), option::of(part()));
    let parts = (camera(), colour(), lights, textured, filled, drafts, vec(item(), 0..4));
    parts.prop_map(|(camera, background, (mut lights, environment), textured, filled, drafts, items)| {
        if let Some((environment, at)) = environment {
            lights.insert(at.index(lights.len() + 1), environment);
        }
        let textures = textures(textured);
        let mut materials = materials(drafts, &textures);
        let (media, fills, ambient_medium) = filled;
        fill(&mut materials, &media, &fills);
        let ambient_medium =
            ambient_medium.filter(|_| !media.is_empty()).map(|i| spanned(i.get(&media).value.name.clone()));
        let mut root = Group { items };
        name_materials(&mut root, &materials);
        let lights = lights.into_iter().map(spanned).collect();
        SceneDescription {
            camera: spanned(camera),
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
