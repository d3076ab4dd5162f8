//! Generators of random materials and mixes for property tests.

use glam::DVec3;
use proptest::array::uniform4;
use proptest::option;
use proptest::prelude::*;

use super::textures::{assign_texture_name, random_textured_value};
use super::values::*;
use crate::color::DispersionFormula;
use crate::format::description::*;

/// Draft of a material: name, parts, and for a mix both component numbers and the amount.
type MaterialDraft =
    (Option<String>, MaterialParts, Option<(prop::sample::Index, prop::sample::Index, TexturedValue<f64>)>);

/// Builds materials from `drafts`.
///
/// A draft with a mix becomes a mix of two earlier materials, unless they contain two different
/// dielectrics.
pub fn build_materials(
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

/// Kind, emission and normal perturbation of a material.
type MaterialParts = (MaterialKindDescription, Option<EmissionDescription>, Option<NormalPerturbationDescription>);

pub fn random_material_parts() -> impl Strategy<Value = MaterialParts> {
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

fn random_refractive_index() -> impl Strategy<Value = RefractiveIndexDescription> {
    let cauchy = (0.5..3.0, -0.05..0.1, -0.01..0.01).prop_map(|(a, b, c)| DispersionFormula::Cauchy { a, b, c });
    let strength = prop_oneof![Just(0.0), -0.1..2.0];
    let resonance = prop_oneof![Just(0.0), -1.0..0.1, 0.6..200.0];
    let sellmeier = (uniform4(strength), uniform4(resonance)).prop_map(|(b, c)| DispersionFormula::Sellmeier { b, c });
    let within = |glass: &DispersionFormula| {
        glass.refractive_index_range().is_some_and(|[least, most]| least >= 1e-3 && most <= 1e3)
    };
    prop_oneof![
        (1e-3..=1e3).prop_map(RefractiveIndexDescription::Constant),
        random_name().prop_map(|name| RefractiveIndexDescription::NamedGlass(with_empty_span(name))),
        (1.0..=3.0, 9.0..=1e9).prop_map(|(index, abbe)| RefractiveIndexDescription::Abbe { index, abbe }),
        prop_oneof![cauchy, sellmeier].prop_filter("no index", within).prop_map(RefractiveIndexDescription::Formula),
    ]
}
