//! Random media for proptest.

use proptest::collection::vec;
use proptest::prelude::*;

use super::super::description::{
    DensityDescription, MaterialDescription, MaterialKindDescription, MediumCoefficients, MediumDescription,
    PhaseFunctionDescription, Spanned, TransformedBoxDescription,
};
use super::strategies::{map, spanned};
use super::values::{coefficient, name, point, share};

fn coefficients() -> impl Strategy<Value = MediumCoefficients> {
    prop_oneof![
        (coefficient(), coefficient())
            .prop_map(|(absorption, scattering)| MediumCoefficients::AbsorptionScattering { absorption, scattering }),
        (coefficient(), share())
            .prop_map(|(extinction, albedo)| MediumCoefficients::ExtinctionAlbedo { extinction, albedo }),
    ]
}

fn phase() -> impl Strategy<Value = PhaseFunctionDescription> {
    prop_oneof![
        Just(PhaseFunctionDescription::Isotropic),
        Just(PhaseFunctionDescription::Rayleigh),
        (-1.0 + 1e-7..=1.0 - 1e-7).prop_map(PhaseFunctionDescription::HenyeyGreenstein),
    ]
}

fn extent() -> impl Strategy<Value = TransformedBoxDescription> {
    let corners = (point(), point()).prop_filter_map("no extent", |(a, b)| {
        let (min, max) = (a.min(b), a.max(b));
        let sides = max - min;
        (sides.min_element() > 0.0 && sides.is_finite()).then_some((min, max))
    });
    (corners, vec(map(), 0..3)).prop_map(|((min, max), maps)| TransformedBoxDescription { min, max, maps })
}

fn density() -> impl Strategy<Value = DensityDescription> {
    let shares = (0.0..=1.0, 0.0..=1.0);
    let noise = (1..=16_u32, 1e-9..1e9, any::<u32>(), 2..=512_u32);
    prop_oneof![
        2 => Just(DensityDescription::Homogeneous),
        1 => (name(), 1e-9..1e9, extent())
            .prop_map(|(path, scale, extent)| DensityDescription::Grid { path: spanned(path), scale, extent }),
        1 => (shares, noise, extent()).prop_map(|((cover, softness), (octaves, frequency, seed, resolution), extent)| {
            DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent }
        }),
    ]
}

/// Media with distinct names.
pub fn media() -> impl Strategy<Value = Vec<Spanned<MediumDescription>>> {
    let medium = (name(), coefficients(), coefficient(), phase(), density()).prop_map(
        |(name, coefficients, emission, phase, density)| MediumDescription {
            name,
            coefficients,
            emission,
            phase,
            density,
        },
    );
    vec(medium, 0..4).prop_map(|drafts| {
        let mut media: Vec<Spanned<MediumDescription>> = Vec::new();
        for medium in drafts {
            if media.iter().all(|other| other.value.name != medium.name) {
                media.push(spanned(medium));
            }
        }
        media
    })
}

/// Fills bodies with `media`, and makes some otherwise unused ones `Clear`.
pub fn fill(
    materials: &mut [Spanned<MaterialDescription>],
    media: &[Spanned<MediumDescription>],
    fills: &[Option<prop::sample::Index>],
) {
    let parts: Vec<String> = materials
        .iter()
        .filter_map(|m| match &m.kind {
            MaterialKindDescription::Mix { first, second, .. } => Some([first.value.clone(), second.value.clone()]),
            _ => None,
        })
        .flatten()
        .collect();
    for (material, fill) in materials.iter_mut().zip(fills) {
        let material = &mut material.value;
        let MaterialKindDescription::Dielectric { priority, .. } = material.kind else { continue };
        material.medium = fill.filter(|_| !media.is_empty()).map(|i| spanned(i.get(media).value.name.clone()));
        if priority % 2 == 0 && material.name.as_ref().is_none_or(|name| !parts.contains(name)) {
            material.kind = MaterialKindDescription::Clear { priority };
            (material.emission, material.normal_perturbation) = (None, None);
        }
    }
}
