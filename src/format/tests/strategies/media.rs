//! Generators of random media for property tests.

use proptest::collection::vec;
use proptest::prelude::*;

use super::values::*;
use crate::format::description::{
    DensityDescription, DielectricDescription, MaterialDescription, MaterialKindDescription, MediumCoefficients,
    MediumDescription, MixDescription, NullInterfaceDescription, PhaseFunctionDescription, Spanned,
    TransformedBoxDescription,
};

fn random_medium_coefficients() -> impl Strategy<Value = MediumCoefficients> {
    prop_oneof![
        (random_coefficients(), random_coefficients())
            .prop_map(|(absorption, scattering)| MediumCoefficients::AbsorptionScattering { absorption, scattering }),
        (random_coefficients(), random_fractions())
            .prop_map(|(extinction, albedo)| MediumCoefficients::ExtinctionAlbedo { extinction, albedo }),
    ]
}

fn random_phase_function() -> impl Strategy<Value = PhaseFunctionDescription> {
    prop_oneof![
        Just(PhaseFunctionDescription::Isotropic),
        Just(PhaseFunctionDescription::Rayleigh),
        (-1.0 + 1e-7..=1.0 - 1e-7).prop_map(PhaseFunctionDescription::HenyeyGreenstein),
    ]
}

fn random_transformed_box() -> impl Strategy<Value = TransformedBoxDescription> {
    let corners = (random_point(), random_point()).prop_filter_map("no extent", |(a, b)| {
        let (min, max) = (a.min(b), a.max(b));
        let sides = max - min;
        (sides.min_element() > 0.0 && sides.is_finite()).then_some((min, max))
    });
    (corners, vec(random_transform_step(), 0..3)).prop_map(|((min, max), steps)| TransformedBoxDescription {
        min,
        max,
        steps,
    })
}

fn random_density() -> impl Strategy<Value = DensityDescription> {
    let shares = (0.0..=1.0, 0.0..=1.0);
    let noise = (1..=16_u32, 1e-9..1e9, any::<u32>(), 2..=512_u32);
    prop_oneof![
        2 => Just(DensityDescription::Homogeneous),
        1 => (random_name(), 1e-9..1e9, random_transformed_box())
            .prop_map(|(path, scale, extent)| DensityDescription::Grid { path: with_empty_span(path), scale, extent }),
        1 => (shares, noise, random_transformed_box()).prop_map(|((cover, softness), (octaves, frequency, seed, resolution), extent)| {
            DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent }
        }),
    ]
}

/// Returns random media with distinct names.
pub fn random_media() -> impl Strategy<Value = Vec<Spanned<MediumDescription>>> {
    let medium =
        (random_name(), random_medium_coefficients(), random_coefficients(), random_phase_function(), random_density())
            .prop_map(|(name, coefficients, emission, phase, density)| MediumDescription {
                name,
                coefficients,
                emission,
                phase,
                density,
            });
    vec(medium, 0..4).prop_map(|drafts| {
        let mut media: Vec<Spanned<MediumDescription>> = Vec::new();
        for medium in drafts {
            if media.iter().all(|other| other.value.name != medium.name) {
                media.push(with_empty_span(medium));
            }
        }
        media
    })
}

/// Fills random dielectric bodies with `media`, and turns some bodies into null interfaces.
///
/// A body whose material is part of a mix stays a dielectric.
pub fn fill_bodies_with_random_media(
    materials: &mut [Spanned<MaterialDescription>],
    media: &[Spanned<MediumDescription>],
    fills: &[Option<prop::sample::Index>],
) {
    let parts: Vec<String> = materials
        .iter()
        .filter_map(|m| match &m.kind {
            MaterialKindDescription::Mix(MixDescription { first, second, .. }) => {
                Some([first.value.clone(), second.value.clone()])
            }
            _ => None,
        })
        .flatten()
        .collect();
    for (material, fill) in materials.iter_mut().zip(fills) {
        let material = &mut material.value;
        let MaterialKindDescription::Dielectric(DielectricDescription { priority, .. }) = material.kind else {
            continue;
        };
        material.medium = fill.filter(|_| !media.is_empty()).map(|i| with_empty_span(i.get(media).value.name.clone()));
        if priority % 2 == 0 && material.name.as_ref().is_none_or(|name| !parts.contains(name)) {
            material.kind = MaterialKindDescription::NullInterface(NullInterfaceDescription { priority });
            (material.emission, material.normal_perturbation) = (None, None);
        }
    }
}
