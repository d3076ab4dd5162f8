//! Random textures, and parameters that may refer to them.

use glam::DVec2;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::values::*;
use crate::format::description::*;

pub fn random_texture_kind() -> impl Strategy<Value = TextureKindDescription> {
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

/// Returns the textures with the names and kinds of `drafts`. Of several drafts with one name, only
/// the first becomes a texture.
pub fn textures_with_unique_names(drafts: Vec<(String, TextureKindDescription)>) -> Vec<Spanned<TextureDescription>> {
    let mut textures: Vec<Spanned<TextureDescription>> = Vec::new();
    for (name, kind) in drafts {
        if textures.iter().all(|other| other.value.name != name) {
            textures.push(with_empty_span(TextureDescription { name, kind }));
        }
    }
    textures
}

/// Returns a random constant, or a texture number that [`assign_texture_name`] replaces by a name.
pub fn random_textured_value<T: std::fmt::Debug + Clone>(
    plain: impl Strategy<Value = T>,
) -> impl Strategy<Value = TexturedValue<T>> {
    (plain, option::weighted(0.3, any::<u8>())).prop_map(|(plain, texture)| match texture {
        Some(i) => TexturedValue::Texture(with_empty_span(i.to_string())),
        None => TexturedValue::Constant(plain),
    })
}

/// Replaces a texture number by the name of one of `textures`, or by `plain` if there are none.
pub fn assign_texture_name<T>(value: &mut TexturedValue<T>, textures: &[Spanned<TextureDescription>], plain: T) {
    if let TexturedValue::Texture(name) = value {
        let number: usize = name.value.parse().unwrap();
        match textures.get(number % textures.len().max(1)) {
            Some(texture) => name.value = texture.value.name.clone(),
            None => *value = TexturedValue::Constant(plain),
        }
    }
}
