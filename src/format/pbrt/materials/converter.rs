//! Converts one material of pbrt to a material of the scene language, or a mix to several.

use super::parameter_reader::ParameterReader;
use super::surfaces::surface_description;
use super::{FileMaterial, PbrtMaterials, mix_part_names};
use crate::format::description::{
    DiffuseDescription, MaterialDescription, MaterialKindDescription, NormalPerturbationDescription, Span, Spanned,
    TexturedValue, ThinDielectricDescription, WrapMode,
};
use crate::format::imported_materials::{MixDefect, mix_of};
use crate::format::pbrt::files::ReadResult;
use crate::format::pbrt::graphics_state::MaterialReference;
use crate::format::pbrt::parameters::Parameters;
use crate::format::pbrt::pictures::{LevelCurve, read_picture};
use crate::format::pbrt::textures::PbrtTexture;
use glam::DVec3;

/// Greatest nesting depth of mix materials.
const MAX_MIX_DEPTH: usize = 16;

/// Estimated memory of each material \[bytes].
const MEMORY_PER_MATERIAL: u64 = 2_000;

/// Converter of one pbrt material for a shape, with the tables that receive its results.
pub(super) struct PbrtMaterialConverter<'m> {
    /// Materials of the file and of the imported scene. The converter adds its results here.
    pub materials: &'m mut PbrtMaterials,
    /// Reader of the material's parameters.
    pub reader: ParameterReader<'m>,
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<&'m str>,
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
        let surface = surface_description(&mut self.reader, &kind, &parameters, self.medium.is_some())?;
        let normal = self.normal_perturbation(&parameters)?;
        let name = self.push_material(surface, normal)?;
        if kind != "uber" {
            return Ok(name);
        }
        let Some(opacity) = parameters.find("opacity") else { return Ok(name) };
        let value = self.reader.textures.parameter_value(opacity, true, place, self.reader.files)?;
        let (amount, mean) = self.reader.textured_scalar_and_mean(&value, &|alpha| alpha.clamp(0.0, 1.0))?;
        if mean < 1.0 { self.mix_with_transparent(&name, amount) } else { Ok(name) }
    }

    fn push_material(
        &mut self,
        kind: MaterialKindDescription,
        normal_perturbation: Option<NormalPerturbationDescription>,
    ) -> ReadResult<String> {
        self.reader.files.reserve_memory(MEMORY_PER_MATERIAL)?;
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
        let amount = self.reader.value_or_gray(parameters, &["amount"], false, 0.5)?;
        let (amount, mean) = self.reader.textured_scalar_and_mean(&amount, &|amount| amount.clamp(0.0, 1.0))?;
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
                self.reader.add_note("mixes of two dielectrics become the one with the larger weight", place);
                Ok(if mean > 0.5 { second } else { first })
            }
            None => self.push_material(mix_of(first, second, amount), None),
        }
    }

    /// Returns the bump map or normal map of a material; `None` if it has neither.
    fn normal_perturbation(&mut self, p: &Parameters) -> ReadResult<Option<NormalPerturbationDescription>> {
        if let Some(name) = p.text("normalmap") {
            let image = read_picture(name, LevelCurve::Linear, &p.place, self.reader.files)?.image;
            let value = PbrtTexture::Picture {
                image: image.into(),
                factor: DVec3::ONE,
                wrap: WrapMode::Repeat,
                coordinates: Default::default(),
            };
            let (value, _) = self.reader.textures.add_texture(&value, &|c| c, self.reader.files)?;
            return Ok(value.texture_name().cloned().map(NormalPerturbationDescription::NormalMap));
        }
        let Some(parameter) = p.find_any(&["displacement", "bumpmap"]) else { return Ok(None) };
        let value = self.reader.textures.parameter_value(parameter, false, &p.place, self.reader.files)?;
        let (value, _) = self.reader.textures.add_texture(&value, &|c| c, self.reader.files)?;
        let texture = value.texture_name().cloned();
        Ok(texture.map(|texture| NormalPerturbationDescription::Bump { texture, height: 1.0 }))
    }
}
