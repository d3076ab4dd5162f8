//! Roughness of pbrt materials, converted to GGX α.

use super::parameter_reader::ParameterReader;
use crate::format::description::TexturedValue;
use crate::format::pbrt::files::ReadResult;
use crate::format::pbrt::parameters::Parameters;

/// Least GGX α of a rough surface. pbrt treats a smaller α as smooth.
const MIN_ROUGH_ALPHA: f64 = 1e-3;

/// Map from a roughness of pbrt to GGX α. If the parameter `remaproughness` is false, the roughness
/// is α itself.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RoughnessMap {
    /// Square root of the roughness, as in pbrt-v4.
    SquareRoot,
    /// Polynomial in the logarithm of the roughness, as in pbrt-v3. Its least α is 0.047, at
    /// roughness 0.001 and below.
    Polynomial,
    /// Polynomial of pbrt-v3 for roughness above 0; roughness 0 gives a smooth surface. pbrt-v3's
    /// `glass` has this map.
    PolynomialOrSmooth,
}

impl RoughnessMap {
    fn ggx_alpha(self, roughness: f64) -> f64 {
        match self {
            Self::SquareRoot => roughness.max(0.0).sqrt(),
            Self::PolynomialOrSmooth if roughness <= 0.0 => 0.0,
            Self::Polynomial | Self::PolynomialOrSmooth => {
                let x = libm::log(roughness.max(1e-3));
                1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
            }
        }
    }
}

/// GGX α of a surface, as a constant or a texture, and its mean.
pub(super) struct Roughness {
    /// GGX α.
    pub alpha: TexturedValue<f64>,
    /// Mean of α over the pixels of the texture.
    pub mean: f64,
}

/// Returns GGX α from pbrt's parameters `roughness`, `uroughness` and `vroughness`.
///
/// `default` is the value of a missing parameter. `map` is the map from roughness to α.
pub(super) fn roughness(
    r: &mut ParameterReader<'_>,
    p: &Parameters,
    default: f64,
    map: RoughnessMap,
) -> ReadResult<Roughness> {
    roughness_from_names(r, p, ["uroughness", "vroughness"], default, map)
}

/// Returns GGX α from the two roughness parameters named `u` and `v`. If one is missing, the
/// isotropic parameter, such as `roughness`, counts instead; if that is missing too, `default`.
///
/// `map` is the map from roughness to α. If the mean of α along u differs from the mean along
/// v, the result is isotropic and constant: `alpha` and `mean` are the geometric mean of these
/// two means.
pub(super) fn roughness_from_names(
    r: &mut ParameterReader<'_>,
    p: &Parameters,
    [u, v]: [&str; 2],
    default: f64,
    map: RoughnessMap,
) -> ReadResult<Roughness> {
    let prefix = u.strip_suffix("uroughness").unwrap_or_default();
    let common = format!("{prefix}roughness");
    let first = r.value_or_gray(p, &[u, &common], false, default)?;
    let second = r.value_or_gray(p, &[v, &common], false, default)?;
    let remaps = p.flag("remaproughness") != Some(false);
    let alpha = move |roughness: f64| {
        let alpha = if remaps { map.ggx_alpha(roughness) } else { roughness };
        if alpha < MIN_ROUGH_ALPHA { 0.0 } else { alpha.min(1.0) }
    };
    let (textured, mean) = r.textured_scalar_and_mean(&first, &alpha)?;
    let (_, other) = r.textured_scalar_and_mean(&second, &alpha)?;
    if (mean - other).abs() <= 1e-9 {
        return Ok(Roughness { alpha: textured, mean });
    }
    r.add_note("roughness that differs by direction is even: the geometric mean", &p.place);
    let even = (mean * other).sqrt();
    Ok(Roughness { alpha: TexturedValue::Constant(even), mean: even })
}
