//! Converts one material of pbrt to a material of the scene language.

use super::glasses::{glass_description, glass_name, index_of_glass};
use super::{FileMaterial, PbrtMaterials, mix_part_names};
use crate::bsdf::{LossyCoat, MAX_COAT_INDEX, metal_refractive_index};
use crate::color::conductor_refractive_index;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription,
    DiffuseTransmissionDescription, MaterialDescription, MaterialKindDescription, MetalDescription, MirrorDescription,
    NormalPerturbationDescription, NullInterfaceDescription, PhongDescription, PrincipledDescription,
    RefractiveIndexDescription, Span, Spanned, TexturedValue, ThinDielectricDescription,
};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::{MixDefect, mix_of};
use crate::format::pbrt::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use crate::format::pbrt::graphics_state::MaterialReference;
use crate::format::pbrt::parameters::{Parameter, Parameters};
use crate::format::pbrt::pictures::{LevelCurve, read_picture};
use crate::format::pbrt::spectra::{SpectralValue, spectral_value};
use crate::format::pbrt::textures::{PbrtTexture, PbrtTextures};
use glam::DVec3;

/// Greatest nesting depth of mix materials.
const MAX_MIX_DEPTH: usize = 16;

/// Least GGX α of a rough surface. pbrt treats a smaller α as smooth.
const MIN_ROUGH_ALPHA: f64 = 1e-3;

/// Refractive index of pbrt's materials if the file states none, and of `plastic`.
const DEFAULT_REFRACTIVE_INDEX: f64 = 1.5;

/// Thickness of the coat of `coateddiffuse` if the file states none.
///
/// The thickness is also the optical depth of the coat, because pbrt's coats have extinction 1.
const DEFAULT_COAT_THICKNESS: f64 = 0.01;

/// Estimated memory of each material \[bytes].
const MEMORY_PER_MATERIAL: u64 = 2_000;

/// Converter of one pbrt material for a shape, with the tables that receive its results.
pub(super) struct PbrtMaterialConverter<'m> {
    /// Materials of the file and of the imported scene. The converter adds its results here.
    pub materials: &'m mut PbrtMaterials,
    /// Textures of the file and of the imported scene.
    pub textures: &'m mut PbrtTextures,
    /// Access to the files of the scene, within a memory limit.
    pub files: &'m PbrtSceneFiles<'m>,
    /// Messages about content that is ignored or approximated.
    pub notes: &'m mut ImportNotes,
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<&'m str>,
}

/// Map from a roughness of pbrt to GGX α. If the parameter `remaproughness` is false, the roughness
/// is α itself.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RoughnessMap {
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
struct Roughness {
    alpha: TexturedValue<f64>,
    /// Mean of α over the pixels of the texture.
    mean: f64,
}

impl PbrtMaterialConverter<'_> {
    /// Converts a pbrt material, adds it to the imported scene, and returns its name there.
    ///
    /// `depth` is the number of mixes that contain this material, directly or through other mixes.
    pub(super) fn convert_material(&mut self, material: &MaterialReference, depth: usize) -> ReadResult<String> {
        let number = self.materials.number(material)?;
        let found = self.materials.numbered.get(number).cloned().flatten();
        let Some(FileMaterial { kind, parameters, mix_parts }) = found else {
            return self.push_material(
                MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::splat(0.5).into() }),
                None,
            );
        };
        let place = &parameters.place;
        if kind == "mix" {
            return self.convert_mix(&parameters, mix_parts, depth);
        }
        let surface = self.surface_description(&kind, &parameters)?;
        let normal = self.normal_perturbation(&parameters)?;
        let name = self.push_material(surface, normal)?;
        if kind != "uber" {
            return Ok(name);
        }
        let Some(opacity) = parameters.find("opacity") else { return Ok(name) };
        let value = self.textures.parameter_value(opacity, true, place, self.files)?;
        let (amount, mean) = self.textured_scalar_and_mean(&value, &|alpha| alpha.clamp(0.0, 1.0))?;
        if mean < 1.0 { self.mix_with_transparent(&name, amount) } else { Ok(name) }
    }

    fn push_material(
        &mut self,
        kind: MaterialKindDescription,
        normal_perturbation: Option<NormalPerturbationDescription>,
    ) -> ReadResult<String> {
        self.files.reserve_memory(MEMORY_PER_MATERIAL)?;
        let name = format!("material{}", self.materials.descriptions.len());
        let has_body = kind.is_dielectric() || kind.is_null_interface();
        let medium = self.medium.filter(|_| has_body).map(|name| Spanned::new(name.to_owned(), Span::default()));
        let material =
            MaterialDescription { name: Some(name.clone()), kind, emission: None, normal_perturbation, medium };
        self.materials.mix_limits.add(&material);
        self.materials.descriptions.push(Spanned::new(material, Span::default()));
        Ok(name)
    }

    /// Adds a mix that makes the material `name` partly transparent, and returns the name of the
    /// mix.
    ///
    /// `opacity` is the weight of the material in the mix. The rest transmits all light unchanged.
    pub(super) fn mix_with_transparent(&mut self, name: &str, opacity: TexturedValue<f64>) -> ReadResult<String> {
        let clear =
            MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.0, transmittance: DVec3::ONE.into() });
        let clear = self.push_material(clear, None)?;
        self.push_material(mix_of(clear, name.to_owned(), opacity), None)
    }

    /// Converts a pbrt `mix` of two named materials, adds it, and returns its name.
    ///
    /// `parts` are the indices of the two materials. `None` stands for a material that the file
    /// defines only after the mix. `depth` is the number of mixes that contain this one.
    fn convert_mix(&mut self, parameters: &Parameters, parts: [Option<usize>; 2], depth: usize) -> ReadResult<String> {
        let place = &parameters.place;
        if depth >= MAX_MIX_DEPTH {
            return Err(place.error("mixes of materials nest too deep", "let no mix contain itself"));
        }
        let names = mix_part_names(parameters)
            .ok_or_else(|| place.error("a mix has no two materials", "name two materials: `\"string materials\"`"))?;
        let amount = match parameters.find("amount") {
            Some(parameter) => self.textures.parameter_value(parameter, false, place, self.files)?,
            None => PbrtTexture::Constant(DVec3::splat(0.5)),
        };
        let (amount, mean) = self.textured_scalar_and_mean(&amount, &|amount| amount.clamp(0.0, 1.0))?;
        let reference = |number: Option<usize>, name: String| match number {
            Some(number) => MaterialReference::Numbered(number),
            None => MaterialReference::Named(name.into(), place.clone()),
        };
        let [first_name, second_name] = names;
        let (first, second) = (reference(parts[0], first_name), reference(parts[1], second_name));
        let first = self.convert_material(&first, depth + 1)?;
        let second = self.convert_material(&second, depth + 1)?;
        match self.materials.mix_limits.mix_defect(&first, &second) {
            Some(MixDefect::TooDeep) => Err(place.error("mixes of materials nest too deep", "nest at most 8 mixes")),
            Some(MixDefect::TwoDielectrics) => {
                self.add_note("mixes of two dielectrics become the one with the larger weight", place);
                Ok(if mean > 0.5 { second } else { first })
            }
            None => self.push_material(mix_of(first, second, amount), None),
        }
    }

    /// Converts the reflection and transmission of the pbrt material `kind` with the parameters
    /// `p`.
    fn surface_description(&mut self, kind: &str, p: &Parameters) -> ReadResult<MaterialKindDescription> {
        let place = &p.place;
        let diffuse =
            |reflectance: TexturedValue<DVec3>| MaterialKindDescription::Diffuse(DiffuseDescription { reflectance });
        Ok(match kind {
            "diffuse" => diffuse(self.textured_color_and_mean(p, "reflectance", 0.5, &|c| c)?.0),
            "matte" => {
                if p.find("sigma").is_some_and(|sigma| sigma.numbers != [0.0]) {
                    self.add_note("rough diffuse surfaces (`sigma`) are Lambertian", place);
                }
                diffuse(self.textured_color_and_mean(p, "Kd", 0.5, &|c| c)?.0)
            }
            "coateddiffuse" => {
                let index = self.refractive_index(p, &["eta"])?.clamp(1.0, f64::from(MAX_COAT_INDEX));
                let roughness = self.roughness(p, 0.0, RoughnessMap::SquareRoot)?;
                if p.find("albedo").is_some_and(|albedo| albedo.numbers.iter().any(|a| *a != 0.0)) {
                    self.add_note("scattering inside coats (`albedo`) is left out: they absorb only", place);
                }
                let thickness = p.number_or("thickness", DEFAULT_COAT_THICKNESS).max(0.0);
                let coat = LossyCoat::new(index, roughness.mean, thickness);
                let under_coat = |c: DVec3| c.map(|reflectance| coat.equivalent_lossless_reflectance(reflectance));
                let (reflectance, _) = self.textured_color_and_mean(p, "reflectance", 0.5, &under_coat)?;
                let roughness = roughness.alpha;
                MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
                    reflectance,
                    eta: index,
                    roughness,
                    is_nonlinear: true,
                })
            }
            "disney" => self.disney_description(p)?,
            "plastic" | "uber" | "substrate" => {
                let default = if kind == "substrate" { 0.5 } else { 0.25 };
                let message = format!("`{kind}` is a diffuse surface and a Phong lobe of constant strength");
                self.add_note(&message, place);
                if p.find_any(&["Kr", "Kt"]).is_some() {
                    self.add_note("mirrors and transmission of `uber` (Kr, Kt) are left out", place);
                }
                let (_, gloss) = self.textured_color_and_mean(p, "Ks", default, &|c| c)?;
                let f0 = match kind {
                    "plastic" => normal_reflectance(DEFAULT_REFRACTIVE_INDEX) * gloss,
                    "uber" => normal_reflectance(self.refractive_index(p, &["eta", "index"])?) * gloss,
                    _ => gloss,
                };
                let diffuse_share = DVec3::splat(1.0 - f0.max_element());
                let (diffuse, _) = self.textured_color_and_mean(p, "Kd", default, &|c| c * diffuse_share)?;
                let roughness = self.roughness(p, 0.1, RoughnessMap::Polynomial)?;
                MaterialKindDescription::Phong(PhongDescription::in_place_of_ggx(diffuse, f0, roughness.mean))
            }
            "mirror" => MaterialKindDescription::Mirror(MirrorDescription {
                reflectance: self.textured_color_and_mean(p, "Kr", 0.9, &|c| c)?.0,
            }),
            "glass" | "dielectric" => {
                let is_one = |color: &Parameter| color.texts.is_empty() && color.numbers.iter().all(|c| *c == 1.0);
                if ["Kr", "Kt"].iter().any(|name| p.find(name).is_some_and(|color| !is_one(color))) {
                    self.add_note("colors of glass (Kr, Kt) are ignored", place);
                }
                let map = if kind == "glass" { RoughnessMap::PolynomialOrSmooth } else { RoughnessMap::SquareRoot };
                let roughness = self.roughness(p, 0.0, map)?;
                MaterialKindDescription::Dielectric(DielectricDescription {
                    refraction: self.refractive_index_description(p)?,
                    absorption: DielectricAbsorption::None,
                    roughness: roughness.alpha,
                    has_multiple_scattering: false,
                    priority: 0,
                })
            }
            "thindielectric" => MaterialKindDescription::Thin(ThinDielectricDescription {
                eta: self.refractive_index(p, &["eta"])?,
                transmittance: DVec3::ONE.into(),
            }),
            "conductor" | "metal" => {
                let (default, map) = match kind {
                    "metal" => (0.01, RoughnessMap::Polynomial),
                    _ => (0.0, RoughnessMap::SquareRoot),
                };
                let roughness = self.roughness(p, default, map)?;
                self.conductor_description(p, ["reflectance", "eta", "k"], roughness.alpha)?
            }
            "coatedconductor" => {
                self.add_note("coats of conductors are left out: the conductor is bare", place);
                let names = ["conductor.uroughness", "conductor.vroughness"];
                let alpha = self.roughness_from_names(p, names, 0.0, RoughnessMap::SquareRoot)?.alpha;
                self.conductor_description(p, ["reflectance", "conductor.eta", "conductor.k"], alpha)?
            }
            "diffusetransmission" => {
                let scale = p.number_or("scale", 1.0);
                let scaled = |c: DVec3| (c * scale).clamp(DVec3::ZERO, DVec3::ONE);
                MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
                    reflectance: self.textured_color_and_mean(p, "reflectance", 0.25, &scaled)?.0,
                    transmittance: self.textured_color_and_mean(p, "transmittance", 0.25, &scaled)?.0,
                })
            }
            "translucent" => {
                if p.find("Ks").is_none_or(|gloss| gloss.numbers.iter().any(|ks| *ks != 0.0)) {
                    self.add_note("the gloss of `translucent` (Ks) is left out", place);
                }
                let mut part_of_kd = |name: &str| -> ReadResult<TexturedValue<DVec3>> {
                    let (_, share) = self.textured_color_and_mean(p, name, 0.5, &|c| c)?;
                    Ok(self.textured_color_and_mean(p, "Kd", 0.25, &|c| c * share)?.0)
                };
                MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
                    reflectance: part_of_kd("reflect")?,
                    transmittance: part_of_kd("transmit")?,
                })
            }
            "interface" | "none" | "" => {
                if self.medium.is_none() {
                    // Without a medium inside, the boundary has no effect.
                    return Ok(MaterialKindDescription::Thin(ThinDielectricDescription {
                        eta: 1.0,
                        transmittance: DVec3::ONE.into(),
                    }));
                }
                MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 })
            }
            "subsurface" | "kdsubsurface" => {
                self.add_note("subsurface scattering is left out: surfaces are diffuse", place);
                let name = if kind == "kdsubsurface" { "Kd" } else { "reflectance" };
                diffuse(self.textured_color_and_mean(p, name, 0.5, &|c| c)?.0)
            }
            _ => {
                let message = format!("the material `{kind}` is not supported");
                return Err(place.error(message, "replace it, for example by a `diffuse` or `conductor` material"));
            }
        })
    }

    /// Converts the material `disney` of pbrt-v3.
    fn disney_description(&mut self, p: &Parameters) -> ReadResult<MaterialKindDescription> {
        let place = &p.place;
        // The list lacks `sheentint`, which has no effect without `sheen`.
        for name in ["anisotropic", "speculartint", "sheen", "flatness", "difftrans", "scatterdistance"] {
            if p.find(name).is_some_and(|value| value.numbers.iter().any(|number| *number != 0.0)) {
                self.add_note(&format!("`{name}` of `disney` is ignored"), place);
            }
        }
        if p.flag("thin") == Some(true) {
            self.add_note("`thin` of `disney` is ignored", place);
        }
        let mut scalar = |name: &str, default: f64, map: &dyn Fn(f64) -> f64| {
            let value = match p.find(name) {
                Some(parameter) => self.textures.parameter_value(parameter, false, place, self.files)?,
                None => PbrtTexture::Constant(DVec3::splat(default)),
            };
            self.textured_scalar_and_mean(&value, &|number| map(number.clamp(0.0, 1.0)))
        };
        let metallic = scalar("metallic", 0.0, &|share| share)?.0;
        let roughness = scalar("roughness", 0.5, &|roughness| roughness * roughness)?.0;
        let transmission = scalar("spectrans", 0.0, &|share| share)?.0;
        // pbrt's clear coat of strength 1 reflects only a quarter as much as a full coat.
        let clearcoat = scalar("clearcoat", 0.0, &|strength| 0.25 * strength)?.0;
        let clearcoat_roughness = scalar("clearcoatgloss", 1.0, &|gloss| 0.1 + (0.001 - 0.1) * gloss)?.1;
        if transmission != TexturedValue::Constant(0.0) {
            self.add_note("glass of `disney` is not colored by `color`", place);
        }
        Ok(MaterialKindDescription::Principled(PrincipledDescription {
            base_color: self.textured_color_and_mean(p, "color", 0.5, &|c| c)?.0,
            metallic,
            roughness,
            eta: self.refractive_index(p, &["eta"])?.clamp(1.0, f64::from(MAX_COAT_INDEX)),
            transmission,
            absorption: DielectricAbsorption::None,
            clearcoat,
            clearcoat_roughness,
            has_multiple_scattering: false,
        }))
    }

    /// Returns the conductor that the parameters `p` describe, by its reflectance at normal
    /// incidence or else by its complex index η + ik.
    ///
    /// `[reflectance, eta, k]` are the names of these parameters. Missing η and k are copper's.
    fn conductor_description(
        &mut self,
        p: &Parameters,
        [reflectance, eta, k]: [&str; 3],
        roughness: TexturedValue<f64>,
    ) -> ReadResult<MaterialKindDescription> {
        let place = &p.place;
        let conductor = |metal| {
            let has_multiple_scattering = false;
            MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, has_multiple_scattering })
        };
        if p.find(reflectance).is_some() {
            let (value, _) = self.textured_color_and_mean(p, reflectance, 0.5, &|c| c)?;
            return Ok(conductor(match value {
                TexturedValue::Constant(color) => MetalDescription::with_clamped_reflectance(color),
                texture @ TexturedValue::Texture(_) => MetalDescription::Reflectance(texture),
            }));
        }
        let mut value = |name: &str, is_eta: bool| match p.find(name) {
            Some(parameter) if parameter.kind == "texture" => {
                let value = self.textures.parameter_value(parameter, true, place, self.files)?;
                Ok(SpectralValue::Rgb(self.textures.add_texture(&value, &|c| c, self.files)?.1))
            }
            Some(parameter) => spectral_value(parameter, place, self.files),
            None => {
                let copper = metal_refractive_index("copper").unwrap_or_default();
                Ok(SpectralValue::Rgb(if is_eta { copper.0 } else { copper.1 }.as_dvec3()))
            }
        };
        let (eta, k) = match (value(eta, true)?, value(k, false)?) {
            (SpectralValue::Spectrum(eta), SpectralValue::Spectrum(k)) => conductor_refractive_index(&eta, &k),
            (eta, k) => (eta.mean_rgb(), k.mean_rgb()),
        };
        if !(eta.min_element() > 0.0 && k.min_element() >= 0.0) {
            return Err(place.error("the index of the metal is not positive", "give η above 0, and k of at least 0"));
        }
        Ok(conductor(MetalDescription::with_clamped_index(eta, k)))
    }

    /// Returns the refractive index of a pbrt dielectric: constant, or with the dispersion of a
    /// glass that pbrt knows by name.
    fn refractive_index_description(&mut self, p: &Parameters) -> ReadResult<RefractiveIndexDescription> {
        if let Some(glass) = p.find("eta").and_then(glass_name).and_then(glass_description) {
            return Ok(glass);
        }
        self.refractive_index(p, &["eta", "index"]).map(RefractiveIndexDescription::Constant)
    }

    /// Returns the refractive index from the first of the parameters `names` that exists; 1.5 if
    /// none does.
    ///
    /// A named glass gives its index at 587.56 nm. Any other spectrum gives its mean, weighted by
    /// the response of the green channel. A texture gives 1.5, and a message tells the user.
    fn refractive_index(&mut self, p: &Parameters, names: &[&str]) -> ReadResult<f64> {
        let place = &p.place;
        let index = match p.find_any(names) {
            None => DEFAULT_REFRACTIVE_INDEX,
            Some(parameter) if parameter.kind == "texture" => {
                self.add_note("textures of the index of refraction are 1.5", place);
                DEFAULT_REFRACTIVE_INDEX
            }
            Some(parameter) if let Some(index) = glass_name(parameter).and_then(index_of_glass) => {
                self.add_note("panes and coats of glass have one index for all wavelengths", place);
                index
            }
            Some(parameter) => spectral_value(parameter, place, self.files)?.mean_rgb().y,
        };
        if !(0.01..=100.0).contains(&index) {
            return Err(place.error("the index of refraction is not between 0.01 and 100", "correct `eta`"));
        }
        Ok(index)
    }

    /// Returns GGX α from pbrt's parameters `roughness`, `uroughness` and `vroughness`.
    ///
    /// `default` is the value of a missing parameter. `map` is the map from roughness to α.
    fn roughness(&mut self, p: &Parameters, default: f64, map: RoughnessMap) -> ReadResult<Roughness> {
        self.roughness_from_names(p, ["uroughness", "vroughness"], default, map)
    }

    /// Returns GGX α from the two roughness parameters named `u` and `v`. If one is missing, the
    /// isotropic parameter, such as `roughness`, counts instead; if that is missing too, `default`.
    ///
    /// `map` is the map from roughness to α. If the mean of α along u differs from the mean along
    /// v, the result is isotropic and constant: `alpha` and `mean` are the geometric mean of these
    /// two means.
    fn roughness_from_names(
        &mut self,
        p: &Parameters,
        [u, v]: [&str; 2],
        default: f64,
        map: RoughnessMap,
    ) -> ReadResult<Roughness> {
        let place = &p.place;
        let prefix = u.strip_suffix("uroughness").unwrap_or_default();
        let common = format!("{prefix}roughness");
        let value = |name: &str| match p.find_any(&[name, &common]) {
            Some(parameter) => self.textures.parameter_value(parameter, false, place, self.files),
            None => Ok(PbrtTexture::Constant(DVec3::splat(default))),
        };
        let (first, second) = (value(u)?, value(v)?);
        let remaps = p.flag("remaproughness") != Some(false);
        let alpha = move |r: f64| {
            let alpha = if remaps { map.ggx_alpha(r) } else { r };
            if alpha < MIN_ROUGH_ALPHA { 0.0 } else { alpha.min(1.0) }
        };
        let (textured, mean) = self.textured_scalar_and_mean(&first, &alpha)?;
        let (_, other) = self.textured_scalar_and_mean(&second, &alpha)?;
        if (mean - other).abs() <= 1e-9 {
            return Ok(Roughness { alpha: textured, mean });
        }
        self.add_note("roughness that differs by direction is even: the geometric mean", place);
        let even = (mean * other).sqrt();
        Ok(Roughness { alpha: TexturedValue::Constant(even), mean: even })
    }

    /// Returns the color parameter `name`, as a constant or a texture, and its mean over the
    /// texture.
    ///
    /// Colors are clamped to \[0, 1], and then mapped by `map`. `default` is the gray value of a
    /// missing parameter.
    fn textured_color_and_mean(
        &mut self,
        p: &Parameters,
        name: &str,
        default: f64,
        map: &dyn Fn(DVec3) -> DVec3,
    ) -> ReadResult<(TexturedValue<DVec3>, DVec3)> {
        let value = match p.find(name) {
            Some(parameter) => self.textures.parameter_value(parameter, true, &p.place, self.files)?,
            None => PbrtTexture::Constant(DVec3::splat(default)),
        };
        let unit = |color: DVec3| map(color.clamp(DVec3::ZERO, DVec3::ONE));
        self.textures.add_texture(&value, &unit, self.files)
    }

    /// Converts a texture to a number parameter. Returns it as a constant or a texture, and its
    /// mean over the texture.
    ///
    /// Each color gives one number: `map` applied to the mean of the color's channels.
    pub(super) fn textured_scalar_and_mean(
        &mut self,
        value: &PbrtTexture,
        map: &dyn Fn(f64) -> f64,
    ) -> ReadResult<(TexturedValue<f64>, f64)> {
        let mean = |c: DVec3| if c.x == c.y && c.y == c.z { c.x } else { c.element_sum() / 3.0 };
        let gray = |color: DVec3| DVec3::splat(map(mean(color)));
        let (value, mean) = self.textures.add_texture(value, &gray, self.files)?;
        Ok(match value {
            TexturedValue::Constant(value) => (TexturedValue::Constant(value.x), value.x),
            TexturedValue::Texture(name) => (TexturedValue::Texture(name), mean.x),
        })
    }

    /// Returns the bump map or normal map of a material; `None` if it has neither.
    fn normal_perturbation(&mut self, p: &Parameters) -> ReadResult<Option<NormalPerturbationDescription>> {
        if let Some(name) = p.text("normalmap") {
            let image = read_picture(name, LevelCurve::Linear, &p.place, self.files)?.image;
            let coordinates = Default::default();
            let value = PbrtTexture::Picture {
                image: image.into(),
                factor: DVec3::ONE,
                wrap: crate::format::description::WrapMode::Repeat,
                coordinates,
            };
            let (value, _) = self.textures.add_texture(&value, &|c| c, self.files)?;
            return Ok(value.texture_name().cloned().map(NormalPerturbationDescription::NormalMap));
        }
        let Some(parameter) = p.find_any(&["displacement", "bumpmap"]) else { return Ok(None) };
        let value = self.textures.parameter_value(parameter, false, &p.place, self.files)?;
        let (value, _) = self.textures.add_texture(&value, &|c| c, self.files)?;
        let texture = value.texture_name().cloned();
        Ok(texture.map(|texture| NormalPerturbationDescription::Bump { texture, height: 1.0 }))
    }

    fn add_note(&mut self, message: &str, place: &PbrtSourceLocation) {
        self.notes.add_unsupported(message, place.position_text());
    }
}

/// Returns the Fresnel reflectance at normal incidence of a dielectric with a given index.
fn normal_reflectance(index: f64) -> f64 {
    let root = (index - 1.0) / (index + 1.0);
    root * root
}
