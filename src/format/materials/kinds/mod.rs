//! Kinds of materials in the scene language.
//!
//! Each kind of material has a file with its description, its fields, and its conversion to a
//! material of the scene. Most kinds state their fields in a table, which also reads and writes
//! them. The list in this file is the only other place that names the kind.

mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod fields;
mod mirror;
mod mix;
mod null_interface;
mod phong;
mod principled;
mod thin_dielectric;

pub use coated_diffuse::CoatedDiffuseDescription;
pub use conductor::ConductorDescription;
pub use dielectric::DielectricDescription;
pub use diffuse::DiffuseDescription;
pub use diffuse_transmission::DiffuseTransmissionDescription;
pub use mirror::MirrorDescription;
pub(in crate::format) use mix::MAX_MIX_DEPTH;
pub use mix::MixDescription;
pub use null_interface::NullInterfaceDescription;
pub use phong::PhongDescription;
pub use principled::PrincipledDescription;
pub use thin_dielectric::ThinDielectricDescription;

use crate::format::error::SceneError;
use crate::format::language::field_table::BlockCodec;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockParser, BlockSchema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::scene::Material;
use std::fmt;

/// A kind of material in the scene language: the schema of its block, and its conversion to a
/// material of the renderer.
trait MaterialBlock: BlockCodec {
    /// Schema of the block: keyword, fields and help.
    ///
    /// If the schema has the field `medium`, materials of this kind may have a medium. If it has
    /// the field `bump`, they may have a bump map or a normal map.
    const BLOCK: &'static BlockSchema;

    /// Kind of body that a surface of this material encloses.
    const ENCLOSED_BODY: EnclosedBody;

    /// Converts the parsed fields of this kind's own parameters. The caller handles the fields that
    /// several kinds share: emission, bump or normal map, and medium.
    ///
    /// A mix looks up its components in the parser, which knows all earlier materials of the text.
    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Self::parse_fields(f)
    }

    /// Converts the description to a material of the renderer. The caller adds emission, bump or
    /// normal map, and medium.
    ///
    /// Adds to `requirements` what the material's textures need of a surface, such as texture
    /// coordinates.
    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError>;

    /// Returns the names of the textures in this kind's own parameters. The caller adds those of
    /// bump maps, normal maps and emission.
    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.field_textures()
    }

    /// Returns the name in the field `texture` of a `Phong` material. It is the name of a texture
    /// or, if no texture has this name, the path of a picture file.
    ///
    /// `None` if the field is absent, and for all other kinds of materials.
    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Kind of body that a closed surface encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EnclosedBody {
    /// No body. The components of a mix or of a `Principled` material may still enclose one.
    None,
    /// A dielectric body.
    Dielectric,
    /// A region of a medium, bounded by a null interface: light crosses the boundary unchanged.
    NullInterface,
}

/// Function that converts the parsed fields of a material block to a material.
type ParseMaterial = for<'a> fn(&Parser<'a>, &BlockFields<'a>) -> Result<MaterialKindDescription, SceneError>;

/// Defines [`MaterialKindDescription`] and [`MATERIAL_BLOCK_PARSERS`] from a list of all kinds of
/// materials. Each entry states the enum variant and the type that implements [`MaterialBlock`].
/// The language reference has the same order as the list.
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

            fn enclosed_body(&self) -> EnclosedBody {
                match self {
                    $(Self::$kind(_) => $description::ENCLOSED_BODY,)*
                }
            }

            /// Writes the fields of this kind's own parameters. The caller writes emission, bump or
            /// normal map, and medium.
            pub(super) fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
                match self {
                    $(Self::$kind(kind) => kind.write_fields(out),)*
                }
            }

            /// Converts the description to a material of the renderer. The caller adds emission,
            /// bump or normal map, and medium.
            ///
            /// Adds to `requirements` what the material's textures need of a surface, such as
            /// texture coordinates.
            pub(in crate::format) fn resolve(
                &self,
                r: &mut Resolver<'_>,
                requirements: &mut TextureRequirements,
            ) -> Result<Material, SceneError> {
                match self {
                    $(Self::$kind(kind) => kind.resolve(r, requirements),)*
                }
            }

            /// Returns the names of the textures in this kind's own parameters. The caller adds
            /// those of bump maps, normal maps and emission.
            pub(super) fn texture_names(&self) -> Vec<&Spanned<String>> {
                match self {
                    $(Self::$kind(kind) => kind.texture_names(),)*
                }
            }

            /// Returns the name in the field `texture` of a `Phong` material. It is the name of a
            /// texture or, if no texture has this name, the path of a picture file.
            ///
            /// `None` if the field is absent, and for all other kinds of materials.
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
    /// A thin sheet that scatters light diffusely to both sides.
    DiffuseTransmission(DiffuseTransmissionDescription),
    /// Metallic-roughness model: a mix of metal, glass and a coated diffuse base.
    Principled(PrincipledDescription),
    /// Stochastic mix of two materials: wherever a ray hits the surface, one of them is chosen at
    /// random.
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
        self.enclosed_body() == EnclosedBody::Dielectric
    }

    /// True for a `Dielectric`, which bounds a dielectric body, and for a `Principled` material
    /// with transmission, which does so with its glass component. False for mixes, whatever they
    /// mix.
    pub(in crate::format) fn bounds_dielectric(&self) -> bool {
        self.is_dielectric() || self.has_dielectric_component()
    }

    /// True for a `Principled` material with transmission: its glass component bounds a dielectric
    /// body. False for all other kinds, including `Dielectric`.
    pub(super) fn has_dielectric_component(&self) -> bool {
        if let Self::Principled(principled) = self { principled.transmits() } else { false }
    }

    /// True if the material is a null interface, which neither reflects nor refracts light.
    #[must_use]
    pub fn is_null_interface(&self) -> bool {
        self.enclosed_body() == EnclosedBody::NullInterface
    }
}
