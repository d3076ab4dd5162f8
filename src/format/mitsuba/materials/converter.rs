//! Converts BSDFs of Mitsuba to materials of the scene language.

use super::conductors::conductor;
use super::context::ImportContext;
use super::dielectrics::{is_index_matched, refractive_index};
use super::files::ReadResult;
use super::meshes::TexcoordConvention;
use super::textures::{MitsubaConvertedTexture, MitsubaTextureUse, MitsubaTextures};
use super::tree::{MitsubaObject, ObjectClass};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    CoatedDiffuseDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription, EmissionDescription,
    GroupItem, MaterialDescription, MaterialKindDescription, MixDescription, NormalPerturbationDescription,
    NullInterfaceDescription, ObjectGroup, PhongDescription, Span, Spanned, TexturedValue, ThinDielectricDescription,
};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Greatest nesting depth of BSDFs.
const MAX_BSDF_DEPTH: u32 = 24;

/// Least GGX α that is converted to a Phong lobe. A smaller α would give a lobe narrower than a
/// degree.
const MIN_PHONG_ALPHA: f64 = 0.01;

/// Kind of boundary that a material makes. It decides which surfaces a shape needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MaterialBoundary {
    /// Boundary of an opaque material or of a mix.
    Opaque,
    /// Boundary of a dielectric with volume, such as a glass body.
    Body,
    /// A thin pane without volume.
    Pane,
    /// No surface: a null interface, which may bound a medium.
    Null,
}

/// A material of the imported scene, with the properties that shapes depend on.
#[derive(Clone, Debug)]
pub(super) struct MitsubaImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// Kind of boundary, which decides which surfaces a shape needs.
    pub boundary: MaterialBoundary,
    /// True if the material uses a texture, or if it is a mix.
    pub may_be_textured: bool,
}

/// Properties of a shape on which its converted material depends.
///
/// A BSDF becomes one material for each distinct value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShapeMaterialInputs {
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<String>,
    /// Emission texture: its name, and the factor from its values to radiance.
    ///
    /// `None` if the shape emits constant radiance or nothing.
    pub emission_texture: Option<(Spanned<String>, f64)>,
    /// Convention for the texture coordinates of the shape.
    pub convention: TexcoordConvention,
}

/// Materials of the imported scene so far, with tables that find materials for reuse.
#[derive(Default)]
pub(super) struct MitsubaMaterials {
    /// Materials of the imported scene. The materials of a mix are listed before it.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    names: HashSet<String>,
    converted: HashMap<(Option<*const MitsubaObject>, String), MitsubaImportedMaterial>,
    transparent_material_name: Option<String>,
    black_material_name: Option<String>,
    null_interface_names: HashMap<String, String>,
}

/// Result of the conversion of a BSDF: reflection and transmission, and a bump map or normal map.
struct ConvertedBsdf {
    kind: MaterialKindDescription,
    normal: Option<NormalPerturbationDescription>,
}

impl From<MaterialKindDescription> for ConvertedBsdf {
    fn from(kind: MaterialKindDescription) -> Self {
        Self { kind, normal: None }
    }
}

impl MitsubaMaterials {
    /// Returns the material of a shape. Converts the shape's BSDF, unless an equal one was
    /// converted for equal inputs.
    ///
    /// A shape without a BSDF has a gray diffuse material.
    pub fn imported_material(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        bsdf: Option<&Rc<MitsubaObject>>,
        inputs: &ShapeMaterialInputs,
    ) -> ReadResult<MitsubaImportedMaterial> {
        let key = (bsdf.map(Rc::as_ptr), format!("{inputs:?}"));
        if let Some(known) = self.converted.get(&key) {
            return Ok(known.clone());
        }
        let ShapeMaterialInputs { medium, emission_texture: emission, convention } = inputs;
        let wanted = bsdf.and_then(|bsdf| bsdf.id.clone()).unwrap_or_else(|| "material".to_owned());
        let name = self.unique_name(&wanted);
        let mut converter =
            MitsubaMaterialConverter { materials: self, textures, context, convention: *convention, name: &name };
        let surface = match bsdf {
            Some(bsdf) => converter.convert_bsdf(bsdf, 0)?,
            None => diffuse_description(DVec3::splat(0.5)).into(),
        };
        let ConvertedBsdf { mut kind, normal } = surface;
        let emission = emission.clone().map(|(name, scale)| EmissionDescription::Texture { name, scale });
        if kind.is_null_interface() && emission.is_some() {
            kind = diffuse_description(DVec3::ZERO);
        }
        let boundary = if kind.is_dielectric() {
            MaterialBoundary::Body
        } else if kind.is_null_interface() {
            MaterialBoundary::Null
        } else if let MaterialKindDescription::Thin(_) = kind {
            MaterialBoundary::Pane
        } else {
            MaterialBoundary::Opaque
        };
        let fills = matches!(boundary, MaterialBoundary::Body | MaterialBoundary::Null);
        let medium = medium.clone().filter(|_| fills).map(|name| Spanned::new(name, Span::default()));
        let description =
            MaterialDescription { name: Some(name.clone()), kind, emission, normal_perturbation: normal, medium };
        let is_textured = !description.texture_names().is_empty() || description.kind.mix_material_names().is_some();
        self.descriptions.push(Spanned::new(description, Span::default()));
        let imported = MitsubaImportedMaterial { name, boundary, may_be_textured: is_textured };
        if !imported.may_be_textured {
            // Without textures, the convention for texture coordinates makes no difference.
            for convention in [TexcoordConvention::Same, TexcoordConvention::FlippedV] {
                let inputs = ShapeMaterialInputs { convention, ..inputs.clone() };
                self.converted.insert((key.0, format!("{inputs:?}")), imported.clone());
            }
        }
        self.converted.insert(key, imported.clone());
        Ok(imported)
    }

    /// Returns the name of the null-interface material that bounds `medium`. Adds it at its first
    /// use.
    pub fn null_interface_name(&mut self, medium: &str) -> String {
        if let Some(name) = self.null_interface_names.get(medium) {
            return name.clone();
        }
        let name = self.unique_name("boundary");
        let kind = MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 });
        let filling = Some(Spanned::new(medium.to_owned(), Span::default()));
        self.push_material(name.clone(), kind, None, filling);
        self.null_interface_names.insert(medium.to_owned(), name.clone());
        name
    }

    /// Returns the name of a material that reflects and transmits nothing. Adds it at its first
    /// use.
    pub fn black_material_name(&mut self) -> String {
        if let Some(name) = &self.black_material_name {
            return name.clone();
        }
        let name = self.unique_name("black");
        self.push_material(name.clone(), diffuse_description(DVec3::ZERO), None, None);
        self.black_material_name = Some(name.clone());
        name
    }

    /// Keeps only the materials that an object uses, directly or through a mix.
    ///
    /// Returns the names of the textures that these materials use.
    pub fn remove_unused(&mut self, objects: &ObjectGroup) -> HashSet<String> {
        let mut used = HashSet::new();
        collect_material_names(objects, &mut used);
        // The materials of a mix are listed before it, so one backward pass finds all.
        for material in self.descriptions.iter().rev() {
            if material.name.as_ref().is_some_and(|name| used.contains(name)) {
                used.extend(material.kind.mix_material_names().into_iter().flatten().map(|part| part.value.clone()));
            }
        }
        self.descriptions.retain(|material| material.name.as_ref().is_some_and(|name| used.contains(name)));
        self.descriptions.iter().flat_map(|m| m.texture_names()).map(|name| name.value.clone()).collect()
    }

    fn push_material(
        &mut self,
        name: String,
        kind: MaterialKindDescription,
        normal_perturbation: Option<NormalPerturbationDescription>,
        medium: Option<Spanned<String>>,
    ) {
        let material = MaterialDescription { name: Some(name), kind, emission: None, normal_perturbation, medium };
        self.descriptions.push(Spanned::new(material, Span::default()));
    }

    /// Reserves and returns a material name that is not in use: `wanted`, or `wanted` with a
    /// number.
    ///
    /// Control characters and quotes become spaces.
    fn unique_name(&mut self, wanted: &str) -> String {
        let clean: String = wanted.chars().map(|c| if c.is_control() || c == '"' { ' ' } else { c }).collect();
        let clean = clean.trim();
        let base = if clean.is_empty() { "material" } else { clean };
        let numbered = (self.names.len() + 1..).map(|i| format!("{base} {i}"));
        let mut candidates = std::iter::once(base.to_owned()).chain(numbered);
        let name = candidates.find(|name| !self.names.contains(name)).unwrap_or_default();
        self.names.insert(name.clone());
        name
    }

    /// Returns the name of a material that transmits all light unchanged. Adds it at its first use.
    fn transparent_material_name(&mut self) -> String {
        if let Some(name) = &self.transparent_material_name {
            return name.clone();
        }
        let name = self.unique_name("clear");
        let kind =
            MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.0, transmittance: DVec3::ONE.into() });
        self.push_material(name.clone(), kind, None, None);
        self.transparent_material_name = Some(name.clone());
        name
    }
}

/// Adds the names of the materials that objects in `group` use to `names`.
fn collect_material_names(group: &ObjectGroup, names: &mut HashSet<String>) {
    for item in &group.items {
        match item {
            GroupItem::MaterialName(name) => drop(names.insert(name.value.clone())),
            GroupItem::MaterialIndex(_) | GroupItem::Object(_) => {}
        }
    }
}

fn diffuse_description(reflectance: DVec3) -> MaterialKindDescription {
    MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: reflectance.into() })
}

/// Converter of one BSDF to a material, with the state of the conversion.
struct MitsubaMaterialConverter<'c, 'a> {
    materials: &'c mut MitsubaMaterials,
    textures: &'c mut MitsubaTextures,
    context: &'c ImportContext<'a>,
    convention: TexcoordConvention,
    /// Name of the material in the imported scene. The names of materials in a mix begin with it.
    name: &'c str,
}

impl MitsubaMaterialConverter<'_, '_> {
    fn convert_bsdf(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        if depth > MAX_BSDF_DEPTH {
            return Err(bsdf.place.error("BSDFs are nested too deep, or contain themselves", "nest them less deep"));
        }
        let context = self.context;
        Ok(match bsdf.plugin.as_str() {
            "diffuse" | "lambertian" => {
                let reflectance = self.textured_color(bsdf, "reflectance", 0.5)?;
                MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }).into()
            }
            "roughdiffuse" | "difftrans" => {
                context.add_whole_object_note(&format!("`{}` becomes diffuse", bsdf.plugin), bsdf);
                let reflectance = self.textured_color(bsdf, "reflectance", 0.5)?;
                MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }).into()
            }
            "dielectric" | "roughdielectric" => self.convert_dielectric(bsdf)?,
            "thindielectric" => {
                self.note_tints(bsdf)?;
                let index = refractive_index(context, bsdf)?;
                let transmittance = DVec3::ONE.into();
                MaterialKindDescription::Thin(ThinDielectricDescription { eta: index, transmittance }).into()
            }
            "conductor" | "roughconductor" => {
                let roughness = if bsdf.plugin == "conductor" { 0.0.into() } else { self.roughness(bsdf)? };
                let tint =
                    self.convert_texture_parameter(bsdf, "specular_reflectance", 1.0, MitsubaTextureUse::Color)?;
                conductor(context, bsdf, tint, roughness)?.into()
            }
            "plastic" | "roughplastic" => self.convert_plastic(bsdf)?,
            "principled" | "principledthin" => self.convert_principled(bsdf)?,
            "phong" => self.convert_phong(bsdf)?,
            "twosided" => {
                let sides = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                if sides.len() > 1 {
                    context.add_note("surfaces with two BSDFs have the first one on both sides", bsdf);
                }
                self.convert_first_nested(bsdf, &sides, depth)?
            }
            "mask" => {
                let opacity =
                    self.convert_texture_parameter(bsdf, "opacity", 0.5, MitsubaTextureUse::Fraction)?.into_number();
                let sides = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                let solid = self.convert_first_nested(bsdf, &sides, depth)?;
                self.mix_with_transparent(solid, opacity)
            }
            "blendbsdf" | "mixturebsdf" => self.convert_blend(bsdf, depth)?,
            "bumpmap" | "bump" => {
                let sides = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                let mut surface = self.convert_first_nested(bsdf, &sides, depth)?;
                let scale = bsdf.number("scale").unwrap_or(1.0);
                let heights = context.children_of_class(bsdf, ObjectClass::Texture)?;
                if let Some((_, texture)) = heights.first() {
                    let wanted = (MitsubaTextureUse::Height, self.convention);
                    if let MitsubaConvertedTexture::Texture(texture, _) =
                        self.textures.convert_texture(context, texture, wanted, 1.0, 0)?
                    {
                        surface.normal = Some(NormalPerturbationDescription::Bump { texture, height: scale });
                    }
                }
                self.without_mix_perturbation(bsdf, surface)
            }
            "normalmap" => {
                let sides = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                let mut surface = self.convert_first_nested(bsdf, &sides, depth)?;
                let wanted = (MitsubaTextureUse::Normal, self.convention);
                let values = match context.children_of_class(bsdf, ObjectClass::Texture)?.first() {
                    Some((_, texture)) => Some(self.textures.convert_texture(context, texture, wanted, 1.0, 0)?),
                    // A fork of Mitsuba names the picture file in the BSDF itself.
                    None if bsdf.values.contains_key("filename") => {
                        Some(self.textures.convert_bitmap(context, bsdf, wanted, 1.0)?)
                    }
                    None => None,
                };
                if let Some(MitsubaConvertedTexture::Texture(name, _)) = values {
                    surface.normal = Some(NormalPerturbationDescription::NormalMap(name));
                }
                self.without_mix_perturbation(bsdf, surface)
            }
            "null" => MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 }).into(),
            "coating" | "roughcoating" => {
                context.add_whole_object_note(&format!("the coat of `{}` is ignored", bsdf.plugin), bsdf);
                let sides = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                self.convert_first_nested(bsdf, &sides, depth)?
            }
            other => {
                context.add_whole_object_note(&format!("BSDFs of kind `{other}` become diffuse gray"), bsdf);
                diffuse_description(DVec3::splat(0.5)).into()
            }
        })
    }

    /// Converts the first of the nested BSDFs `sides`; an error if the list is empty.
    ///
    /// `bsdf` is the BSDF around them, at nesting depth `depth`.
    fn convert_first_nested(
        &mut self,
        bsdf: &Rc<MitsubaObject>,
        sides: &[(String, Rc<MitsubaObject>)],
        depth: u32,
    ) -> ReadResult<ConvertedBsdf> {
        let Some((_, inner)) = sides.first() else {
            let message = format!("`{}` has no nested BSDF", bsdf.plugin);
            return Err(bsdf.place.error(message, "nest a `bsdf` in it, or refer to one"));
        };
        self.convert_bsdf(inner, depth + 1)
    }

    fn convert_dielectric(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        self.note_tints(bsdf)?;
        let index = refractive_index(self.context, bsdf)?;
        let roughness = if bsdf.plugin == "dielectric" { 0.0.into() } else { self.roughness(bsdf)? };
        let (refraction, attenuation) = (index.into(), DielectricAbsorption::None);
        if is_index_matched(index) && roughness == TexturedValue::Constant(0.0) {
            return Ok(MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 }).into());
        }
        let multiple_scattering = false;
        let kind = MaterialKindDescription::Dielectric(DielectricDescription {
            refraction,
            absorption: attenuation,
            roughness,
            has_multiple_scattering: multiple_scattering,
            priority: 0,
        });
        Ok(kind.into())
    }

    /// Adds a message for each specular tint of a dielectric that is not 1. Tints are ignored.
    fn note_tints(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<()> {
        for name in ["specular_reflectance", "specular_transmittance"] {
            if self.convert_texture_parameter(bsdf, name, 1.0, MitsubaTextureUse::Color)?.mean() != DVec3::ONE {
                self.context.add_note(&format!("`{name}` of dielectrics is ignored: it is 1"), bsdf);
            }
        }
        Ok(())
    }

    fn convert_plastic(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let index = refractive_index(self.context, bsdf)?;
        let base = self.convert_texture_parameter(bsdf, "diffuse_reflectance", 0.5, MitsubaTextureUse::Color)?;
        let tint = self.convert_texture_parameter(bsdf, "specular_reflectance", 1.0, MitsubaTextureUse::Color)?.mean();
        let alpha = if bsdf.plugin == "plastic" { 0.0 } else { self.mean_roughness(bsdf)? };
        if tint != DVec3::ONE {
            self.context.add_note("`specular_reflectance` of plastic is ignored", bsdf);
        }
        let kind = MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
            reflectance: base.into_color(),
            eta: index.clamp(1.0, f64::from(MAX_COAT_INDEX)),
            roughness: alpha.into(),
            is_nonlinear: bsdf.boolean("nonlinear", false),
        });
        Ok(kind.into())
    }

    fn convert_principled(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let context = self.context;
        for name in ["clearcoat", "sheen", "flatness", "anisotropic", "spec_tint"] {
            if bsdf.number(name).is_some_and(|strength| strength != 0.0) {
                context.add_note(&format!("`{name}` of `principled` is ignored"), bsdf);
            }
        }
        let base = self.convert_texture_parameter(bsdf, "base_color", 0.5, MitsubaTextureUse::Color)?;
        let metallic =
            self.convert_texture_parameter(bsdf, "metallic", 0.0, MitsubaTextureUse::Fraction)?.into_number();
        let rough = self.convert_texture_parameter(bsdf, "roughness", 0.5, MitsubaTextureUse::Fraction)?.mean().x;
        let transmission =
            self.convert_texture_parameter(bsdf, "spec_trans", 0.0, MitsubaTextureUse::Fraction)?.into_number();
        let index = match bsdf.number("eta") {
            Some(eta) if eta > 1.0 => eta,
            _ => {
                // The parameter `specular` from 0 to 1 stands for a normal reflectance from 0 to
                // 0.08.
                let root = (0.08 * bsdf.number("specular").unwrap_or(0.5).clamp(0.0, 1.0)).sqrt();
                (1.0 + root) / (1.0 - root)
            }
        };
        let alpha = rough * rough;
        context.add_note("the gloss of `principled` is a Phong lobe, which does not grow towards grazing angles", bsdf);
        let mut kind = phong_description(base.clone().into_color(), DVec3::splat(normal_reflectance(index)), alpha);
        if transmission != TexturedValue::Constant(0.0) {
            let glass = MaterialKindDescription::Dielectric(DielectricDescription {
                refraction: index.into(),
                absorption: DielectricAbsorption::None,
                roughness: alpha.into(),
                has_multiple_scattering: false,
                priority: 0,
            });
            kind = self.mix_surfaces(kind, glass, transmission);
        }
        if metallic != TexturedValue::Constant(0.0) {
            let metal = super::conductors::conductor_from_reflectance(base.mean(), alpha.into());
            if matches!(base, MitsubaConvertedTexture::Texture(..)) {
                context.add_note("metals with a texture of color have its mean", bsdf);
            }
            kind = self.mix_surfaces(kind, metal, metallic);
        }
        Ok(kind.into())
    }

    fn convert_phong(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let diffuse = self.textured_color(bsdf, "diffuse_reflectance", 0.5)?;
        let specular =
            self.convert_texture_parameter(bsdf, "specular_reflectance", 0.2, MitsubaTextureUse::Color)?.mean();
        let shininess = bsdf.number("exponent").unwrap_or(30.0).clamp(0.0, 1e6);
        let specular = specular * phong_normalization_factor(shininess);
        Ok(MaterialKindDescription::Phong(PhongDescription {
            diffuse,
            specular: specular.into(),
            shininess,
            texture: None,
        })
        .into())
    }

    fn convert_blend(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        let weight = if bsdf.plugin == "mixturebsdf" {
            let weights = bsdf.text("weights").and_then(super::color::parse_numbers).unwrap_or_default();
            match weights[..] {
                [a, b] if a >= 0.0 && b >= 0.0 && a + b > 0.0 => {
                    if (a + b - 1.0).abs() > 1e-6 {
                        self.context.add_note("weights of mixtures are scaled to the sum 1", bsdf);
                    }
                    (b / (a + b)).into()
                }
                _ => return Err(bsdf.place.error("this mixture has not two weights", "give `weights` of two BSDFs")),
            }
        } else {
            self.convert_texture_parameter(bsdf, "weight", 0.5, MitsubaTextureUse::Fraction)?.into_number()
        };
        let parts = self.context.children_of_class(bsdf, ObjectClass::Bsdf)?;
        let [(_, first), (_, second)] = &parts[..] else {
            return Err(bsdf.place.error("a blend needs two BSDFs", "nest two `bsdf` elements in it"));
        };
        let (first, second) = (self.convert_bsdf(first, depth + 1)?, self.convert_bsdf(second, depth + 1)?);
        let names = [self.add_mix_component("first", first), self.add_mix_component("second", second)];
        Ok(mix_description(names, weight).into())
    }

    /// Returns a mix of `solid`, with the weight `opacity`, and a fully transparent material.
    ///
    /// If `opacity` is 1, returns `solid`.
    fn mix_with_transparent(&mut self, solid: ConvertedBsdf, opacity: TexturedValue<f64>) -> ConvertedBsdf {
        if opacity == TexturedValue::Constant(1.0) {
            return solid;
        }
        let names = [self.materials.transparent_material_name(), self.add_mix_component("solid", solid)];
        mix_description(names, opacity).into()
    }

    /// Returns `surface`; if it is a mix, without its own bump map or normal map.
    ///
    /// Only the parts of a mix can have such maps. Adds a message if a map is removed.
    fn without_mix_perturbation(&mut self, bsdf: &MitsubaObject, surface: ConvertedBsdf) -> ConvertedBsdf {
        if surface.kind.mix_material_names().is_some() && surface.normal.is_some() {
            self.context.add_note("bump maps and normal maps of mixes are ignored", bsdf);
            return surface.kind.into();
        }
        surface
    }

    fn mix_surfaces(
        &mut self,
        first: MaterialKindDescription,
        second: MaterialKindDescription,
        amount: TexturedValue<f64>,
    ) -> MaterialKindDescription {
        if amount == TexturedValue::Constant(1.0) {
            return second;
        }
        let names = [self.add_mix_component("first", first.into()), self.add_mix_component("second", second.into())];
        mix_description(names, amount)
    }

    /// Adds a part of a mix as a material, and returns the material's name.
    ///
    /// For a null interface, returns the fully transparent material instead.
    fn add_mix_component(&mut self, suffix: &str, surface: ConvertedBsdf) -> String {
        if surface.kind.is_null_interface() {
            return self.materials.transparent_material_name();
        }
        let name = self.materials.unique_name(&format!("{} {suffix}", self.name));
        self.materials.push_material(name.clone(), surface.kind, surface.normal, None);
        name
    }

    /// Returns GGX α of a BSDF.
    ///
    /// A constant α of a Beckmann distribution is multiplied by √ln 2. Then GGX has the same median
    /// slope.
    fn roughness(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<TexturedValue<f64>> {
        let is_ggx = bsdf.text("distribution").unwrap_or("beckmann") == "ggx";
        if !is_ggx {
            self.context.add_note("Beckmann distributions become GGX with the same median slope", bsdf);
        }
        let factor = if is_ggx { 1.0 } else { std::f64::consts::LN_2.sqrt() };
        let _ = bsdf.boolean("sample_visible", true);
        if bsdf.values.contains_key("alpha_u") || bsdf.values.contains_key("alpha_v") {
            self.context.add_note("anisotropic roughness becomes isotropic", bsdf);
            let [u, v] = ["alpha_u", "alpha_v"]
                .map(|name| self.convert_texture_parameter(bsdf, name, 0.1, MitsubaTextureUse::Fraction));
            return Ok((factor * (u?.mean().x * v?.mean().x).sqrt()).into());
        }
        Ok(match self.convert_texture_parameter(bsdf, "alpha", 0.1, MitsubaTextureUse::Fraction)?.into_number() {
            TexturedValue::Constant(alpha) => (factor * alpha).into(),
            texture @ TexturedValue::Texture(_) => texture,
        })
    }

    fn mean_roughness(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<f64> {
        match self.roughness(bsdf)? {
            TexturedValue::Constant(alpha) => Ok(alpha),
            TexturedValue::Texture(_) => {
                Ok(self.convert_texture_parameter(bsdf, "alpha", 0.1, MitsubaTextureUse::Fraction)?.mean().x)
            }
        }
    }

    fn convert_texture_parameter(
        &mut self,
        bsdf: &MitsubaObject,
        name: &str,
        default: f64,
        wanted: MitsubaTextureUse,
    ) -> ReadResult<MitsubaConvertedTexture> {
        self.textures.convert_texture_parameter(self.context, bsdf, (name, default), (wanted, self.convention))
    }

    fn textured_color(&mut self, bsdf: &MitsubaObject, name: &str, default: f64) -> ReadResult<TexturedValue<DVec3>> {
        Ok(self.convert_texture_parameter(bsdf, name, default, MitsubaTextureUse::Color)?.into_color())
    }
}

fn mix_description([first, second]: [String; 2], amount: TexturedValue<f64>) -> MaterialKindDescription {
    let [first, second] = [first, second].map(|name| Spanned::new(name, Span::default()));
    MaterialKindDescription::Mix(MixDescription { first, second, second_probability: amount })
}

/// Returns the reflectance at normal incidence of a dielectric with a given refractive index.
fn normal_reflectance(index: f64) -> f64 {
    let root = (index - 1.0) / (index + 1.0);
    root * root
}

/// Returns a diffuse surface with a Phong lobe whose total reflectance is `specular`.
///
/// The lobe's exponent is 2/α² − 2, where α = `alpha` is a GGX roughness.
fn phong_description(diffuse: TexturedValue<DVec3>, specular: DVec3, alpha: f64) -> MaterialKindDescription {
    let alpha = alpha.clamp(MIN_PHONG_ALPHA, 1.0);
    let shininess = 2.0 / (alpha * alpha) - 2.0;
    let specular = (specular * phong_normalization_factor(shininess)).into();
    MaterialKindDescription::Phong(PhongDescription { diffuse, specular, shininess, texture: None })
}

/// Returns the specular coefficient with which a Phong lobe reflects all light at normal incidence.
///
/// `shininess` is the exponent of the lobe.
fn phong_normalization_factor(shininess: f64) -> f64 {
    0.5 * (shininess + 2.0)
}
