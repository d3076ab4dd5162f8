//! Converts participating media of Tungsten scenes.

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject};
use crate::format::description::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, Span, Spanned,
};
use glam::DVec3;
use serde_json::{Map, Value};
use std::collections::HashMap;

/// Greatest magnitude of the mean cosine g of a phase function; larger magnitudes are clamped to
/// it. A phase function with |g| = 1 would be a delta function.
const MAX_MEAN_COSINE: f64 = 0.999;

/// Greatest scattering or absorption coefficient, and greatest density.
const MAX_COEFFICIENT: f64 = 1e12;

/// Media of the imported scene so far.
#[derive(Default)]
pub(super) struct TungstenMedia {
    /// Media of the imported scene.
    pub descriptions: Vec<Spanned<MediumDescription>>,
    /// Names of converted media; `None` for media that are left out. The key is the medium's
    /// object.
    names: HashMap<*const Map<String, Value>, Option<String>>,
}

impl TungstenMedia {
    /// Returns the name of a medium in the imported scene; `None` if its kind is not supported. The
    /// first call for a medium converts it.
    pub fn medium_name(
        &mut self,
        context: &ImportContext<'_>,
        medium: &TungstenObject<'_>,
    ) -> ReadResult<Option<String>> {
        if let Some(name) = self.names.get(&medium.key()) {
            return Ok(name.clone());
        }
        let name = format!("medium{}", self.descriptions.len());
        let description = convert_medium(context, medium, &name)?;
        let known = description.is_some().then_some(name);
        self.descriptions.extend(description.map(|description| Spanned::new(description, Span::default())));
        self.names.insert(medium.key(), known.clone());
        Ok(known)
    }
}

/// Converts a medium. Returns `None` for an unsupported kind, and a message tells the user.
fn convert_medium(
    context: &ImportContext<'_>,
    medium: &TungstenObject<'_>,
    name: &str,
) -> ReadResult<Option<MediumDescription>> {
    let kind = medium.kind()?;
    if kind != "homogeneous" {
        context.add_whole_object_note(&format!("media of kind `{kind}` are left out"), medium);
        return Ok(None);
    }
    if let Some(transmittance) = medium.child("transmittance")
        && transmittance.kind()? != "exponential"
    {
        context.add_whole_object_note("media fade exponentially instead of by their `transmittance`", &transmittance);
    }
    let density = medium.number_in("density", 1.0, 0.0..=MAX_COEFFICIENT)?;
    let coefficient = |name: &str| -> ReadResult<DVec3> {
        let value = density * medium.vector(name)?.unwrap_or(DVec3::ZERO);
        if value.min_element() >= 0.0 && value.max_element() <= MAX_COEFFICIENT {
            return Ok(value);
        }
        Err(medium.error(format!("`{name}` is negative or too large"), "correct it"))
    };
    let (absorption, scattering) = (coefficient("sigma_a")?, coefficient("sigma_s")?);
    Ok(Some(MediumDescription {
        name: name.to_owned(),
        coefficients: MediumCoefficients::AbsorptionScattering { absorption, scattering },
        emission: DVec3::ZERO,
        phase: read_phase_function(context, medium)?,
        density: DensityDescription::Homogeneous,
    }))
}

/// Reads the phase function of a medium. A phase function of unknown kind becomes isotropic, and a
/// message tells the user.
fn read_phase_function(
    context: &ImportContext<'_>,
    medium: &TungstenObject<'_>,
) -> ReadResult<PhaseFunctionDescription> {
    let Some(phase) = medium.child("phase_function") else { return Ok(PhaseFunctionDescription::Isotropic) };
    Ok(match phase.kind()? {
        "isotropic" => PhaseFunctionDescription::Isotropic,
        "rayleigh" => PhaseFunctionDescription::Rayleigh,
        "henyey_greenstein" => {
            let mean_cosine = phase.number_in("g", 0.0, -1.0..=1.0)?;
            PhaseFunctionDescription::HenyeyGreenstein(mean_cosine.clamp(-MAX_MEAN_COSINE, MAX_MEAN_COSINE))
        }
        other => {
            context.add_whole_object_note(&format!("phase functions of kind `{other}` become isotropic"), &phase);
            PhaseFunctionDescription::Isotropic
        }
    })
}
