//! Kinds of materials in the scene language.
//!
//! This file holds all that the scene language knows of a kind: its description, its block, the
//! reading and writing of the block, and its conversion to a material of the scene. Fields that
//! take several lines to read, write and convert have files of their own, such as
//! [`refraction`](super::refraction).

use super::absorption::{DielectricAbsorption, parse_dielectric_absorption, write_dielectric_absorption};
use super::emission::EMISSION_FIELDS;
use super::metal::{MetalDescription, complex_refractive_index, parse_metal, write_metal};
use super::mix::{check_mix_components, parse_mix_component};
use super::normals::NORMAL_PERTURBATION_FIELDS;
use super::references::material_index;
use super::refraction::{
    INDEX_FIELD, MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX, RefractiveIndexDescription, parse_refraction,
    resolve_refractive_index, write_refraction,
};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, MAX_MEDIUM_COEFFICIENT, block_schema, field_schema,
};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::textures::{NON_NEGATIVE_TEXTURE_RANGE, TextureRequirements};
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::{Body, Material};
use glam::DVec3;
use std::fmt;

/// A kind of material in the scene language: its block, and what the block means.
trait MaterialBlock: Sized {
    /// Schema of the block: keyword, fields and help.
    ///
    /// A block with the field `medium` has a medium, one with `bump` a bump map or normal map.
    const BLOCK: &'static BlockSchema;

    /// Body that a surface of this material bounds.
    const BODY: BoundedBody;

    /// Converts the parsed fields of a block, without emission, normal perturbation and medium.
    ///
    /// The `parser` knows the materials before this one.
    fn parse<'a>(parser: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError>;

    /// Writes the fields of the block, without emission, normal perturbation and medium.
    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result;

    /// Converts the description to a material of the renderer, without emission, normal
    /// perturbation and medium.
    ///
    /// Adds to `requirements` the surface properties that the material's textures need.
    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError>;

    /// Returns the names of the textures that the parameters use, without those of bump maps and
    /// emission.
    fn texture_names(&self) -> Vec<&Spanned<String>>;

    /// Returns the field that may be the name of a texture or the path of a picture file; `None` if
    /// the field is absent, or if textured fields hold names only.
    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>>;
}

/// Body that a surface bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BoundedBody {
    /// No body, or for a mix the body of a component.
    None,
    /// A dielectric body.
    Dielectric,
    /// A region of a medium without a surface, which light enters unchanged.
    NullInterface,
}

/// Function that converts the parsed fields of a material block to a material.
type ParseMaterial = for<'a> fn(&Parser<'a>, &BlockFields<'a>) -> Result<MaterialKindDescription, SceneError>;

/// Defines [`MaterialKindDescription`] and [`MATERIAL_BLOCK_PARSERS`] from the list of kinds:
/// variant, and type that implements [`MaterialBlock`]. The order of the list is that of the
/// language reference.
macro_rules! material_kinds {
    ($($(#[$doc:meta])* $kind:ident($description:ident),)*) => {
        /// Reflection and transmission of a material: one variant per model.
        #[derive(Clone, Debug, PartialEq)]
        pub enum MaterialKindDescription {
            $($(#[$doc])* $kind($description),)*
        }

        $(impl From<$description> for MaterialKindDescription {
            fn from(kind: $description) -> Self {
                Self::$kind(kind)
            }
        })*

        /// Material blocks of the scene language, each with the function that converts its fields.
        pub(in crate::format) static MATERIAL_BLOCK_PARSERS: &[BlockParser<ParseMaterial>] = &[
            $(BlockParser { block: $description::BLOCK, parse: |p, f| $description::parse(p, f).map(Into::into) },)*
        ];

        impl MaterialKindDescription {
            /// Returns the schema of the material's block.
            pub(super) fn block(&self) -> &'static BlockSchema {
                match self {
                    $(Self::$kind(_) => $description::BLOCK,)*
                }
            }

            fn body(&self) -> BoundedBody {
                match self {
                    $(Self::$kind(_) => $description::BODY,)*
                }
            }

            /// Writes the fields of the material's block, without emission, normal perturbation and
            /// medium.
            pub(super) fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
                match self {
                    $(Self::$kind(kind) => kind.write_fields(out),)*
                }
            }

            /// Converts the description to a material of the renderer, without emission, normal
            /// perturbation and medium.
            ///
            /// Adds to `requirements` the surface properties that the material's textures need.
            pub(in crate::format) fn resolve(
                &self,
                r: &mut Resolver<'_>,
                requirements: &mut TextureRequirements,
            ) -> Result<Material, SceneError> {
                match self {
                    $(Self::$kind(kind) => kind.resolve(r, requirements),)*
                }
            }

            /// Returns the names of the textures that this kind's parameters use, without bump maps
            /// and emission.
            pub(super) fn texture_names(&self) -> Vec<&Spanned<String>> {
                match self {
                    $(Self::$kind(kind) => kind.texture_names(),)*
                }
            }

            /// Returns the field that may be the name of a texture or the path of a picture file;
            /// `None` if it is absent, or if textured fields hold names only.
            pub(super) fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
                match self {
                    $(Self::$kind(kind) => kind.ambiguous_texture_reference_mut(),)*
                }
            }
        }
    };
}

material_kinds! {
    /// The Phong model of MIT course 6.837.
    Phong(PhongDescription),
    /// A Lambertian surface.
    Diffuse(DiffuseDescription),
    /// A perfect mirror.
    Mirror(MirrorDescription),
    /// Boundary of a body of glass, water or another dielectric.
    Dielectric(DielectricDescription),
    /// Null interface: bounds a region of a medium. Light crosses it unchanged.
    NullInterface(NullInterfaceDescription),
    /// An opaque conductor.
    Conductor(ConductorDescription),
    /// A pane without thickness: light passes straight through or is reflected.
    Thin(ThinDielectricDescription),
    /// A diffuse base under a dielectric coat, such as plastic.
    CoatedDiffuse(CoatedDiffuseDescription),
    /// Stochastic mix: one of two materials, chosen at random at each point.
    Mix(MixDescription),
}

impl MaterialKindDescription {
    /// Returns the names of the two materials of a mix; `None` for other kinds.
    #[must_use]
    pub fn mix_material_names(&self) -> Option<[&Spanned<String>; 2]> {
        if let Self::Mix(mix) = self { Some([&mix.first, &mix.second]) } else { None }
    }

    /// True if the material is the boundary of a dielectric body.
    #[must_use]
    pub fn is_dielectric(&self) -> bool {
        self.body() == BoundedBody::Dielectric
    }

    /// True if the material is a null interface, which neither reflects nor refracts light.
    #[must_use]
    pub fn is_null_interface(&self) -> bool {
        self.body() == BoundedBody::NullInterface
    }
}

const UNIT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, 1.0);
const TRANSMITTANCE_RANGE: FieldRange = FieldRange::LeftOpenInterval(0.0, 1.0);
const COEFFICIENT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, MAX_MEDIUM_COEFFICIENT);

const ROUGHNESS_FIELD: FieldSchema = field_schema("roughness", FieldKind::NumberOrTexture, "GGX α; smooth below 0.001")
    .with_range(UNIT_RANGE)
    .with_default_numbers(&[0.0]);
const MULTIPLE_SCATTERING_FIELD: FieldSchema =
    field_schema("multipleScattering", FieldKind::Word(&["yes", "no"]), "`no`: light between microfacets is lost")
        .with_default_word("yes");
const PRIORITY_FIELD: FieldSchema =
    field_schema("priority", FieldKind::WholeNumber, "where bodies overlap, the highest priority counts")
        .with_range(FieldRange::ClosedInterval(0.0, 255.0))
        .with_default_numbers(&[0.0]);

/// The Phong model of MIT course 6.837.
#[derive(Clone, Debug, PartialEq)]
pub struct PhongDescription {
    /// Diffuse color kd.
    pub diffuse: TexturedValue<DVec3>,
    /// Specular color ks.
    pub specular: TexturedValue<DVec3>,
    /// Phong exponent, at least 0.
    pub shininess: f64,
    /// Name of a texture that multiplies kd. If no texture has the name, it is the path of a
    /// picture.
    pub texture: Option<Spanned<String>>,
}

static PHONG: BlockSchema = block_schema("PhongMaterial", "Phong's reflection model")
    .with_fields(&[
        field_schema("diffuseColor", FieldKind::ColorOrTexture, "diffuse reflectance kd")
            .with_default_numbers(&[1.0, 1.0, 1.0])
            .mark_as_mit_6837_syntax(),
        field_schema("specularColor", FieldKind::ColorOrTexture, "specular coefficient ks")
            .with_default_numbers(&[0.0, 0.0, 0.0])
            .mark_as_mit_6837_syntax(),
        field_schema("shininess", FieldKind::Number, "Phong exponent")
            .with_range(FieldRange::NonNegative)
            .with_default_numbers(&[0.0])
            .mark_as_mit_6837_syntax(),
        field_schema("texture", FieldKind::Name, "texture or picture that `diffuseColor` is multiplied by")
            .make_optional("none")
            .mark_as_mit_6837_syntax(),
    ])
    .with_aliases(&["Material", "Phong"])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS])
    .mark_as_mit_6837_syntax();

impl MaterialBlock for PhongDescription {
    const BLOCK: &'static BlockSchema = &PHONG;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            diffuse: f.value_or_default("diffuseColor")?,
            specular: f.value_or_default("specularColor")?,
            shininess: f.value_or_default("shininess")?,
            texture: f.optional_value("texture"),
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("diffuseColor", &self.diffuse)?;
        out.write_color_or_texture("specularColor", &self.specular)?;
        out.write_number("shininess", self.shininess)?;
        self.texture.as_ref().map_or(Ok(()), |name| out.write_name_field("texture", name))
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let diffuse = r.resolve_phong_diffuse_parameter(&self.diffuse, self.texture.as_ref(), requirements)?;
        let specular = r.resolve_color_parameter(&self.specular, &NON_NEGATIVE_TEXTURE_RANGE, requirements)?;
        Ok(Material::phong(diffuse, specular, self.shininess as f32))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        [self.diffuse.texture_name(), self.specular.texture_name(), self.texture.as_ref()]
            .into_iter()
            .flatten()
            .collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        self.texture.as_mut()
    }
}

/// A Lambertian surface.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseDescription {
    /// Reflectance, inside [0, 1].
    pub reflectance: TexturedValue<DVec3>,
}

static DIFFUSE: BlockSchema = block_schema("Diffuse", "Lambertian reflection")
    .with_fields(&[field_schema("reflectance", FieldKind::ColorOrTexture, "albedo")
        .with_range(UNIT_RANGE)
        .make_required()])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for DiffuseDescription {
    const BLOCK: &'static BlockSchema = &DIFFUSE;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self { reflectance: f.value_or_default("reflectance")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("reflectance", &self.reflectance)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        Ok(Material::diffuse(r.resolve_reflectance_parameter(&self.reflectance, requirements)?))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.reflectance.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// A perfect mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorDescription {
    /// Reflectance, inside [0, 1].
    pub reflectance: TexturedValue<DVec3>,
}

static MIRROR: BlockSchema = block_schema("Mirror", "perfect mirror")
    .with_fields(&[field_schema("reflectance", FieldKind::ColorOrTexture, "reflectance")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[1.0, 1.0, 1.0])])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for MirrorDescription {
    const BLOCK: &'static BlockSchema = &MIRROR;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self { reflectance: f.value_or_default("reflectance")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("reflectance", &self.reflectance)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        Ok(Material::mirror(r.resolve_reflectance_parameter(&self.reflectance, requirements)?))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.reflectance.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Boundary of a body of glass, water or another dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct DielectricDescription {
    /// Index of refraction of the body.
    pub refraction: RefractiveIndexDescription,
    /// Absorption inside the body.
    pub absorption: DielectricAbsorption,
    /// GGX α, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
    /// Priority where bodies overlap (Schmidt and Budge 2002): the highest wins. Among equal
    /// priorities, the body that was entered last wins.
    pub priority: u8,
}

static DIELECTRIC: BlockSchema = block_schema("Dielectric", "boundary of a body of glass, water or the like")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("abbe", FieldKind::Number, "with `indexOfRefraction`: Abbe number")
            .with_range(FieldRange::Positive)
            .make_optional("none: no dispersion"),
        field_schema("glass", FieldKind::Name, "instead of `indexOfRefraction`: a glass by name"),
        field_schema(
            "cauchy",
            FieldKind::NumberList,
            "instead of `indexOfRefraction`: Cauchy's equation; C is optional",
        )
        .with_range(FieldRange::DescribedOnly("A, B \\[µm²], C \\[µm⁴]")),
        field_schema("sellmeierB", FieldKind::NumberList, "instead of `indexOfRefraction`: Sellmeier's equation")
            .with_range(FieldRange::DescribedOnly("1 to 4")),
        field_schema("sellmeierC", FieldKind::NumberList, "squared resonance wavelengths for `sellmeierB`")
            .with_range(FieldRange::DescribedOnly("1 to 4"))
            .with_unit("µm²"),
        field_schema("absorption", FieldKind::Color, "absorption coefficient of the inside")
            .with_range(COEFFICIENT_RANGE)
            .make_optional("0 0 0")
            .with_unit("1/length"),
        field_schema("tint", FieldKind::Color, "instead of `absorption`: transmittance over `tintDistance`")
            .with_range(TRANSMITTANCE_RANGE),
        field_schema("tintDistance", FieldKind::Number, "distance of `tint`; the absorption is at most 1e12")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0])
            .with_unit("length"),
        ROUGHNESS_FIELD,
        MULTIPLE_SCATTERING_FIELD,
        PRIORITY_FIELD,
        field_schema("medium", FieldKind::Name, "medium that fills the body").make_optional("none"),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for DielectricDescription {
    const BLOCK: &'static BlockSchema = &DIELECTRIC;
    const BODY: BoundedBody = BoundedBody::Dielectric;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            refraction: parse_refraction(f)?,
            absorption: parse_dielectric_absorption(f)?,
            roughness: f.value_or_default("roughness")?,
            has_multiple_scattering: f.field_word_or_default("multipleScattering")? == "yes",
            priority: f.value_or_default::<u32>("priority")? as u8,
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_refraction(out, &self.refraction)?;
        write_dielectric_absorption(out, self.absorption)?;
        out.write_number_or_texture("roughness", &self.roughness)?;
        write_multiple_scattering(out, self.has_multiple_scattering)?;
        out.write_field("priority", self.priority)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        let (index, glass) = resolve_refractive_index(r, &self.refraction)?;
        let absorption = rgb(self.absorption.absorption_coefficient());
        let body = Body { absorption, priority: self.priority, glass, ..Body::new(index) };
        Ok(with_multiple_scattering(Material::rough_boundary(body, roughness), self.has_multiple_scattering))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.roughness.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Null interface: bounds a region of a medium. Light crosses it unchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct NullInterfaceDescription {
    /// Priority where bodies overlap: the highest wins.
    pub priority: u8,
}

static NULL_INTERFACE: BlockSchema = block_schema("Clear", "null interface: boundary of a region without a surface")
    .with_fields(&[
        field_schema("medium", FieldKind::Name, "medium that fills the region").make_optional("none"),
        PRIORITY_FIELD,
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for NullInterfaceDescription {
    const BLOCK: &'static BlockSchema = &NULL_INTERFACE;
    const BODY: BoundedBody = BoundedBody::NullInterface;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        let advice = "needs a surface, and `Clear` has none: ";
        f.forbid_fields(&["emission", "emissionScale"], &format!("{advice}give `emission` to its medium"))?;
        f.forbid_fields(&["bump", "bumpHeight", "normalMap"], &format!("{advice}leave it out"))?;
        Ok(Self { priority: f.value_or_default::<u32>("priority")? as u8 })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_field("priority", self.priority)
    }

    fn resolve(&self, _: &mut Resolver<'_>, _: &mut TextureRequirements) -> Result<Material, SceneError> {
        let body = Body { priority: self.priority, is_null_interface: true, ..Body::new(1.0) };
        Ok(Material::smooth_boundary(body))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        Vec::new()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// An opaque conductor.
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorDescription {
    /// Complex index of refraction.
    pub metal: MetalDescription,
    /// GGX α, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
}

static CONDUCTOR: BlockSchema = block_schema("Conductor", "metal; opaque, reflects on both sides")
    .with_fields(&[
        field_schema("metal", FieldKind::Name, "a metal by name; give this, or `eta` and `k`"),
        field_schema("eta", FieldKind::Color, "η of the complex index η + ik for red, green and blue")
            .with_range(FieldRange::ClosedInterval(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX)),
        field_schema("k", FieldKind::Color, "k of the complex index")
            .with_range(FieldRange::ClosedInterval(0.0, MAX_REFRACTIVE_INDEX)),
        ROUGHNESS_FIELD,
        MULTIPLE_SCATTERING_FIELD,
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for ConductorDescription {
    const BLOCK: &'static BlockSchema = &CONDUCTOR;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            metal: parse_metal(f)?,
            roughness: f.value_or_default("roughness")?,
            has_multiple_scattering: f.field_word_or_default("multipleScattering")? == "yes",
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_metal(out, &self.metal)?;
        out.write_number_or_texture("roughness", &self.roughness)?;
        write_multiple_scattering(out, self.has_multiple_scattering)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let (eta, k) = complex_refractive_index(r, &self.metal)?;
        let metal = Material::conductor(eta, k, r.resolve_fraction_parameter(&self.roughness, requirements)?);
        Ok(with_multiple_scattering(metal, self.has_multiple_scattering))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.roughness.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// A pane without thickness: light passes straight through or is reflected.
#[derive(Clone, Debug, PartialEq)]
pub struct ThinDielectricDescription {
    /// Index of refraction relative to the surroundings.
    pub eta: f64,
    /// Transmittance of the pane's interior at normal incidence, inside (0, 1].
    pub transmittance: TexturedValue<DVec3>,
}

static THIN: BlockSchema = block_schema("Thin", "pane without thickness; the index is relative to the surroundings")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("transmittance", FieldKind::ColorOrTexture, "transmittance of the inside at normal incidence")
            .with_range(TRANSMITTANCE_RANGE)
            .with_default_numbers(&[1.0, 1.0, 1.0]),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for ThinDielectricDescription {
    const BLOCK: &'static BlockSchema = &THIN;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self { eta: f.value_or_default("indexOfRefraction")?, transmittance: f.value_or_default("transmittance")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_number("indexOfRefraction", self.eta)?;
        out.write_color_or_texture("transmittance", &self.transmittance)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let transmittance = r.resolve_reflectance_parameter(&self.transmittance, requirements)?;
        Ok(Material::thin_dielectric(self.eta as f32, transmittance))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.transmittance.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// A diffuse base under a dielectric coat, such as plastic.
#[derive(Clone, Debug, PartialEq)]
pub struct CoatedDiffuseDescription {
    /// Reflectance of the base, inside [0, 1].
    pub reflectance: TexturedValue<DVec3>,
    /// Index of refraction of the coat relative to the surroundings, inside [1, 4].
    pub eta: f64,
    /// GGX α of the coat, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// True to account for color shifts by interreflection between coat and base, like `nonlinear`
    /// of Mitsuba's `plastic`.
    pub is_nonlinear: bool,
}

static COATED_DIFFUSE: BlockSchema =
    block_schema("CoatedDiffuse", "diffuse base under a dielectric coat: plastic, varnish, glaze")
        .with_fields(&[
            field_schema("reflectance", FieldKind::ColorOrTexture, "albedo of the base")
                .with_range(UNIT_RANGE)
                .make_required(),
            field_schema("indexOfRefraction", FieldKind::Number, "index of the coat relative to the surroundings")
                .with_range(FieldRange::ClosedInterval(1.0, MAX_COAT_INDEX as f64))
                .with_default_numbers(&[1.5]),
            ROUGHNESS_FIELD,
            field_schema(
                "nonlinear",
                FieldKind::Word(&["yes", "no"]),
                "`no`: light between coat and base does not make colors deeper",
            )
            .with_default_word("yes"),
        ])
        .with_aliases(&["Plastic"])
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for CoatedDiffuseDescription {
    const BLOCK: &'static BlockSchema = &COATED_DIFFUSE;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: f.value_or_default("reflectance")?,
            eta: f.value_or_default("indexOfRefraction")?,
            roughness: f.value_or_default("roughness")?,
            is_nonlinear: f.field_word_or_default("nonlinear")? == "yes",
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("reflectance", &self.reflectance)?;
        out.write_number("indexOfRefraction", self.eta)?;
        out.write_number_or_texture("roughness", &self.roughness)?;
        out.write_field("nonlinear", if self.is_nonlinear { "yes" } else { "no" })
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let reflectance = r.resolve_reflectance_parameter(&self.reflectance, requirements)?;
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        Ok(Material::coated_diffuse(reflectance, self.eta as f32, roughness, self.is_nonlinear))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        [self.reflectance.texture_name(), self.roughness.texture_name()].into_iter().flatten().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Stochastic mix: one of two materials, chosen at random at each point.
#[derive(Clone, Debug, PartialEq)]
pub struct MixDescription {
    /// Name of the first material, which the scene file defines before the mix.
    pub first: Spanned<String>,
    /// Name of the second material, which the scene file defines before the mix.
    pub second: Spanned<String>,
    /// Probability of the second material, inside [0, 1].
    pub second_probability: TexturedValue<f64>,
}

static MIX: BlockSchema = block_schema("Mix", "one of two materials at each point, chosen at random")
    .with_fields(&[
        field_schema("first", FieldKind::Name, "name of a material that stands before this one").make_required(),
        field_schema("second", FieldKind::Name, "name of a material that stands before this one").make_required(),
        field_schema("amount", FieldKind::NumberOrTexture, "share of the second material")
            .with_range(UNIT_RANGE)
            .make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

impl MaterialBlock for MixDescription {
    const BLOCK: &'static BlockSchema = &MIX;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(parser: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        let first = parse_mix_component(parser, f.require_field("first")?)?;
        let second = parse_mix_component(parser, f.require_field("second")?)?;
        let amount = f.value_or_default("amount")?;
        check_mix_components(parser, f, &first, &second)?;
        Ok(Self { first, second, second_probability: amount })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_name_field("first", &self.first)?;
        out.write_name_field("second", &self.second)?;
        out.write_number_or_texture("amount", &self.second_probability)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let (first, second) = (material_index(r, &self.first)?, material_index(r, &self.second)?);
        Ok(Material::mix(first, second, r.resolve_fraction_parameter(&self.second_probability, requirements)?))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.second_probability.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Writes the field `multipleScattering`, unless it has its default.
fn write_multiple_scattering(out: &mut SceneWriter<'_, '_>, multiple_scattering: bool) -> fmt::Result {
    if multiple_scattering { Ok(()) } else { out.write_field("multipleScattering", "no") }
}

/// Returns `material`, with light that several microfacets scatter if `multiple_scattering` is
/// true.
fn with_multiple_scattering(material: Material, multiple_scattering: bool) -> Material {
    if multiple_scattering { material } else { material.with_single_microfacet_scattering() }
}
