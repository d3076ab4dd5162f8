//! Materials, and references to them.

use std::fmt;

use super::super::description::{
    DielectricAbsorption, EmissionDescription, MaterialDescription, MaterialKindDescription, MetalDescription,
    NormalPerturbationDescription, Spanned, TexturedValue,
};
use super::super::error::SceneError;
use super::fields::{Fields, PresentField, fields};
use super::lexer::Token;
use super::names::optional_name;
use super::reader::Parser;
use super::refraction::{INDEX, MAX_INDEX, MIN_INDEX, refraction, write_refraction};
use super::schema::{Block, Entry, Field, Kind, MAX_COEFFICIENT, Range, field, find, keywords};
use super::text::clip;
use super::writer::Writer;
use glam::DVec3;

/// The materials.
pub(super) static MATERIALS: [Entry<ReadMaterial>; 8] = [
    Entry { block: &PHONG, read: phong },
    Entry { block: &DIFFUSE, read: diffuse },
    Entry { block: &MIRROR, read: mirror },
    Entry { block: &DIELECTRIC, read: dielectric },
    Entry { block: &CLEAR, read: clear },
    Entry { block: &CONDUCTOR, read: conductor },
    Entry { block: &THIN, read: thin },
    Entry { block: &MIX, read: mix },
];

/// Reader of the fields of a material; the scope holds the materials that stand before it.
type ReadMaterial = for<'a> fn(&Parser<'a>, &Fields<'a>) -> Result<MaterialKindDescription, SceneError>;

/// Greatest depth of nested mixes: each level doubles the number of leaf materials.
const MAX_MIXES: u8 = 8;

const UNIT: Range = Range::Within(0.0, 1.0);
const TRANSMITTANCE: Range = Range::UpTo(0.0, 1.0);
const COEFFICIENT: Range = Range::Within(0.0, MAX_COEFFICIENT);

const ROUGHNESS: Field = field("roughness", Kind::NumberOrTexture, UNIT, "GGX α; smooth below 0.001").or(&[0.0]);
const PRIORITY: Field =
    field("priority", Kind::Whole, Range::Within(0.0, 255.0), "where bodies overlap, the highest priority counts")
        .or(&[0.0]);

static EMISSION: [Field; 2] = [
    field("emission", Kind::ColorOrTexture, Range::NonNegative, "emitted radiance; not for `Clear`")
        .absent("0 0 0")
        .unit("W/(m² sr)"),
    field("emissionScale", Kind::Number, Range::NonNegative, "with a texture as `emission`: factor of its values")
        .absent("1"),
];

static RELIEF: [Field; 3] = [
    field("bump", Kind::Name, Range::Any, "texture or picture of heights; not for `Clear`").absent("none"),
    field("bumpHeight", Kind::Number, Range::Single, "height of the value 1 of `bump`, required with it")
        .unit("length"),
    field("normalMap", Kind::Name, Range::Any, "instead of `bump`: texture or picture of normals").absent("none"),
];

static PHONG: Block = Block {
    keyword: "PhongMaterial",
    aliases: &["Material", "Phong"],
    fields: &[
        field("diffuseColor", Kind::ColorOrTexture, Range::NonNegative, "diffuse reflectance kd")
            .or(&[1.0, 1.0, 1.0])
            .course(),
        field("specularColor", Kind::ColorOrTexture, Range::NonNegative, "specular coefficient ks")
            .or(&[0.0, 0.0, 0.0])
            .course(),
        field("shininess", Kind::Number, Range::NonNegative, "Phong exponent").or(&[0.0]).course(),
        field("texture", Kind::Name, Range::Any, "texture or picture that `diffuseColor` is multiplied by")
            .absent("none")
            .course(),
    ],
    shared: &[&RELIEF, &EMISSION],
    help: "Phong's reflection model",
    course: true,
};

static DIFFUSE: Block = Block {
    keyword: "Diffuse",
    aliases: &[],
    fields: &[field("reflectance", Kind::ColorOrTexture, UNIT, "albedo").required()],
    shared: &[&RELIEF, &EMISSION],
    help: "Lambertian reflection",
    course: false,
};

static MIRROR: Block = Block {
    keyword: "Mirror",
    aliases: &[],
    fields: &[field("reflectance", Kind::ColorOrTexture, UNIT, "reflectance").or(&[1.0, 1.0, 1.0])],
    shared: &[&RELIEF, &EMISSION],
    help: "perfect mirror",
    course: false,
};

static DIELECTRIC: Block = Block {
    keyword: "Dielectric",
    aliases: &[],
    fields: &[
        INDEX,
        field("abbe", Kind::Number, Range::Positive, "with `indexOfRefraction`: Abbe number")
            .absent("none: no dispersion"),
        field("glass", Kind::Name, Range::Any, "instead of `indexOfRefraction`: a glass by name"),
        field(
            "cauchy",
            Kind::Numbers,
            Range::Special("A, B \\[µm²], C \\[µm⁴]"),
            "instead of `indexOfRefraction`: Cauchy's equation; C is optional",
        ),
        field(
            "sellmeierB",
            Kind::Numbers,
            Range::Special("1 to 4"),
            "instead of `indexOfRefraction`: Sellmeier's equation",
        ),
        field("sellmeierC", Kind::Numbers, Range::Special("1 to 4"), "squared resonance wavelengths for `sellmeierB`")
            .unit("µm²"),
        field("absorption", Kind::Color, COEFFICIENT, "absorption coefficient of the inside")
            .absent("0 0 0")
            .unit("1/length"),
        field("tint", Kind::Color, TRANSMITTANCE, "instead of `absorption`: transmittance over `tintDistance`"),
        field("tintDistance", Kind::Number, Range::Positive, "distance of `tint`; the absorption is at most 1e12")
            .absent("1")
            .unit("length"),
        ROUGHNESS,
        PRIORITY,
        field("medium", Kind::Name, Range::Any, "medium that fills the body").absent("none"),
    ],
    shared: &[&RELIEF, &EMISSION],
    help: "boundary of a body of glass, water or the like",
    course: false,
};

static CLEAR: Block = Block {
    keyword: "Clear",
    aliases: &[],
    fields: &[field("medium", Kind::Name, Range::Any, "medium that fills the region").absent("none"), PRIORITY],
    shared: &[&RELIEF, &EMISSION],
    help: "null interface: boundary of a region without a surface",
    course: false,
};

static CONDUCTOR: Block = Block {
    keyword: "Conductor",
    aliases: &[],
    fields: &[
        field("metal", Kind::Name, Range::Any, "a metal by name; give this, or `eta` and `k`"),
        field(
            "eta",
            Kind::Color,
            Range::Within(MIN_INDEX, MAX_INDEX),
            "η of the complex index η + ik for red, green and blue",
        ),
        field("k", Kind::Color, Range::Within(0.0, MAX_INDEX), "k of the complex index"),
        ROUGHNESS,
    ],
    shared: &[&RELIEF, &EMISSION],
    help: "metal; opaque, reflects on both sides",
    course: false,
};

static THIN: Block = Block {
    keyword: "Thin",
    aliases: &[],
    fields: &[
        INDEX,
        field("transmittance", Kind::ColorOrTexture, TRANSMITTANCE, "transmittance of the inside at normal incidence")
            .or(&[1.0, 1.0, 1.0]),
    ],
    shared: &[&RELIEF, &EMISSION],
    help: "pane without thickness; the index is relative to the surroundings",
    course: false,
};

static MIX: Block = Block {
    keyword: "Mix",
    aliases: &[],
    fields: &[
        field("first", Kind::Name, Range::Any, "name of a material that stands before this one").required(),
        field("second", Kind::Name, Range::Any, "name of a material that stands before this one").required(),
        field("amount", Kind::NumberOrTexture, UNIT, "share of the second material").required(),
    ],
    // A mix has the relief of the material it resolves to.
    shared: &[&EMISSION],
    help: "one of two materials at each point, chosen at random",
    course: false,
};

/// Reads a `Materials` block.
pub(super) fn materials<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    if parser.scope.group_uses_materials {
        parser.scope.late_materials = Some(block);
    }
    parser.scope.clear_materials();
    parser.list(block, ("numMaterials", "material"), &keywords(&["numMaterials"], &MATERIALS), |parser, word| {
        let (name, error) = match material_name(parser) {
            Ok(name) => (name, None),
            Err(error) => (None, Some(error)),
        };
        let (material, error) = match error.map_or_else(|| material(parser, word, name.clone()), Err) {
            Ok(material) => (material, Ok(())),
            Err(error) => {
                // A material with errors keeps its index and name, so that objects can refer to it.
                let kind = MaterialKindDescription::Mirror { reflectance: DVec3::ONE.into() };
                (
                    MaterialDescription { name, kind, emission: None, normal_perturbation: None, medium: None },
                    Err(error),
                )
            }
        };
        parser.scope.add_material(Spanned::new(material, word.span()));
        error
    })
}

/// Reads the name of a material, if it has one.
fn material_name(parser: &mut Parser<'_>) -> Result<Option<String>, SceneError> {
    let Some(name) = optional_name(parser, "material")? else { return Ok(None) };
    if parser.scope.names.contains_key(&name.value) {
        let message = format!("two materials are called `{}`", clip(&name.value));
        return Err(parser.lexer.error(name.span, message, "the second", "give it another name".to_owned()));
    }
    parser.scope.names.insert(name.value.clone(), parser.scope.materials.len());
    Ok(Some(name.value))
}

/// Reads the fields of a material.
fn material<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    name: Option<String>,
) -> Result<MaterialDescription, SceneError> {
    let Some(Entry { block, read }) = find(&MATERIALS, word.text) else {
        return Err(parser.unexpected(word, &keywords(&[], &MATERIALS)));
    };
    let f = &fields(parser, word, block)?;
    let kind = read(parser, f)?;
    let medium = match block.field("medium").and_then(|_| f.get("medium")).map(|medium| medium.text()) {
        Some(name) => {
            parser.scope.check_medium(parser.lexer, &name, "ahead of the Materials")?;
            Some(name)
        }
        None => None,
    };
    let normal_perturbation = if block.field("bump").is_some() { normal_perturbation(f)? } else { None };
    Ok(MaterialDescription { name, kind, emission: emission(f)?, normal_perturbation, medium })
}

fn phong(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Phong {
        diffuse: f.color_or_texture("diffuseColor")?,
        specular: f.color_or_texture("specularColor")?,
        shininess: f.number("shininess")?,
        texture: f.get("texture").map(|texture| texture.text()),
    })
}

fn diffuse(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Diffuse { reflectance: f.color_or_texture("reflectance")? })
}

fn mirror(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Mirror { reflectance: f.color_or_texture("reflectance")? })
}

fn dielectric(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Dielectric {
        refraction: refraction(f)?,
        attenuation: attenuation(f)?,
        roughness: f.number_or_texture("roughness")?,
        priority: f.whole("priority")? as u8,
    })
}

fn clear(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    let advice = "needs a surface, and `Clear` has none: ";
    f.refuse(&["emission", "emissionScale"], &format!("{advice}give `emission` to its medium"))?;
    f.refuse(&["bump", "bumpHeight", "normalMap"], &format!("{advice}leave it out"))?;
    Ok(MaterialKindDescription::Clear { priority: f.whole("priority")? as u8 })
}

fn conductor(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Conductor { metal: metal(f)?, roughness: f.number_or_texture("roughness")? })
}

fn thin(_: &Parser<'_>, f: &Fields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Thin {
        index: f.number("indexOfRefraction")?,
        transmittance: f.color_or_texture("transmittance")?,
    })
}

/// Returns the absorption of a dielectric.
fn attenuation(f: &Fields<'_>) -> Result<DielectricAbsorption, SceneError> {
    f.exclude("absorption", "tint")?;
    let Some(tint) = f.get("tint") else {
        f.refuse(&["tintDistance"], "has no effect without `tint`")?;
        return Ok(f
            .get("absorption")
            .map_or(DielectricAbsorption::None, |a| DielectricAbsorption::Coefficient(a.vector())));
    };
    let color = tint.vector();
    let Some(distance) = f.get("tintDistance") else { return Ok(DielectricAbsorption::Tint { color, distance: 1.0 }) };
    let attenuation = DielectricAbsorption::Tint { color, distance: distance.number() };
    let ok = attenuation.coefficient().max_element() <= MAX_COEFFICIENT;
    distance.ensure(ok, "must be longer: over it, `tint` is an absorption above 1e12")?;
    Ok(attenuation)
}

/// Returns the metal of a conductor.
fn metal(f: &Fields<'_>) -> Result<MetalDescription, SceneError> {
    for index in ["eta", "k"] {
        f.exclude("metal", index)?;
    }
    if let Some(name) = f.get("metal") {
        return Ok(MetalDescription::Named(name.text()));
    }
    if f.get("k").is_none() {
        // If both are absent, the error names both.
        f.one_of(&["metal", "eta"])?;
    }
    Ok(MetalDescription::Index { eta: f.vector("eta")?, k: f.vector("k")? })
}

/// Returns a mix, whose parts must stand before it.
fn mix<'a>(parser: &Parser<'a>, f: &Fields<'a>) -> Result<MaterialKindDescription, SceneError> {
    let first = part(parser, f.require("first")?)?;
    let second = part(parser, f.require("second")?)?;
    let amount: TexturedValue<f64> = f.number_or_texture("amount")?;
    let scope = &parser.scope;
    for part in [&first, &second] {
        if scope.contents(part).mixes == MAX_MIXES {
            let message = format!("mixes nest more than {MAX_MIXES} deep");
            let help = "mix fewer materials, or materials that are no mixes".to_owned();
            return Err(f.error(part.span, message, "the deepest that may be", help));
        }
        let index = scope.names.get(&part.value).copied();
        if index.is_some_and(|index| matches!(scope.materials[index].kind, MaterialKindDescription::Clear { .. })) {
            let message = "a mix cannot be `Clear`, which has no surface".to_owned();
            let help = "mix a `Dielectric { indexOfRefraction 1 … }` of the same medium instead".to_owned();
            return Err(f.error(part.span, message, "no surface", help));
        }
    }
    // A path could enter one body and leave the other, and would keep the first on its interior
    // stack for ever.
    if let (Some(a), Some(b)) = (scope.contents(&first).dielectric, scope.contents(&second).dielectric)
        && a != b
    {
        let message = "a mix cannot be two different Dielectrics".to_owned();
        let help = "mix a Dielectric with an opaque material, or with itself".to_owned();
        return Err(f.error(second.span, message, "the second body", help));
    }
    Ok(MaterialKindDescription::Mix { first, second, amount })
}

/// Returns the name of a material that stands before the one that is read.
fn part<'a>(parser: &Parser<'a>, field: PresentField<'_, 'a>) -> Result<Spanned<String>, SceneError> {
    let name = field.text();
    let help = "a mix is made of materials that stand before it";
    parser.scope.check_material(parser.lexer, &name, help)?;
    if parser.scope.names.get(&name.value).is_some_and(|index| *index == parser.scope.materials.len()) {
        let message = format!("`{}` is a part of itself", clip(&name.value));
        let help = format!("name a material that stands before it as `{}`", field.name());
        return Err(parser.lexer.error(name.span, message, "this mix", help));
    }
    Ok(name)
}

/// Returns `emission` with `emissionScale`.
fn emission(f: &Fields<'_>) -> Result<Option<EmissionDescription>, SceneError> {
    let Some(emission) = f.get("emission") else {
        f.refuse(&["emissionScale"], "has no effect without a texture as `emission`")?;
        return Ok(None);
    };
    let Some(name) = emission.texture() else {
        f.refuse(&["emissionScale"], "has no effect without a texture as `emission`")?;
        return Ok(Some(EmissionDescription::Radiance(emission.vector())));
    };
    Ok(Some(EmissionDescription::Texture { name, scale: f.get("emissionScale").map_or(1.0, |scale| scale.number()) }))
}

/// Returns `bump` with its height, or `normalMap`.
fn normal_perturbation(f: &Fields<'_>) -> Result<Option<NormalPerturbationDescription>, SceneError> {
    if f.get("bump").is_none() {
        f.refuse(&["bumpHeight"], "has no effect without `bump`")?;
        return Ok(f.get("normalMap").map(|map| NormalPerturbationDescription::NormalMap(map.text())));
    }
    let bump = f.one_of(&["bump", "normalMap"])?;
    Ok(Some(NormalPerturbationDescription::Bump { texture: bump.text(), height: f.number("bumpHeight")? }))
}

/// Reads the index after `MaterialIndex`.
pub(super) fn material_by_index<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<u32>, SceneError> {
    parser.scope.group_uses_materials = true;
    let index = parser.integer(word)?;
    let count = parser.scope.materials.len();
    if (index.value as usize) < count {
        return Ok(index);
    }
    let message = format!("there is no material {}", index.value);
    let help = match count {
        0 => "no material stands before this line: put `Materials { … }` ahead of the Group".to_owned(),
        1 => "the one material is number 0".to_owned(),
        n => format!("materials are numbered from 0 to {}", n - 1),
    };
    Err(parser.lexer.error(index.span, message, "out of range", help))
}

/// Reads the name after `MaterialName`.
pub(super) fn material_by_name<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<String>, SceneError> {
    parser.scope.group_uses_materials = true;
    let name = parser.name(word)?;
    let help = "name it ahead of the Group: `Materials { Diffuse name { … } }`";
    parser.scope.check_material(parser.lexer, &name, help)?;
    Ok(name)
}

/// Prints a material.
pub(super) fn write_material(out: &mut Writer<'_, '_>, material: &MaterialDescription) -> fmt::Result {
    let block = match material.kind {
        MaterialKindDescription::Phong { .. } => &PHONG,
        MaterialKindDescription::Diffuse { .. } => &DIFFUSE,
        MaterialKindDescription::Mirror { .. } => &MIRROR,
        MaterialKindDescription::Dielectric { .. } => &DIELECTRIC,
        MaterialKindDescription::Clear { .. } => &CLEAR,
        MaterialKindDescription::Conductor { .. } => &CONDUCTOR,
        MaterialKindDescription::Thin { .. } => &THIN,
        MaterialKindDescription::Mix { .. } => &MIX,
    };
    match &material.name {
        None => out.start(block)?,
        Some(name) => out.start_named(block, name)?,
    }
    match &material.kind {
        MaterialKindDescription::Phong { diffuse, specular, shininess, texture } => {
            out.color_or_texture("diffuseColor", diffuse)?;
            out.color_or_texture("specularColor", specular)?;
            out.number("shininess", *shininess)?;
            texture.as_ref().map_or(Ok(()), |name| out.name("texture", name))?;
        }
        MaterialKindDescription::Diffuse { reflectance } | MaterialKindDescription::Mirror { reflectance } => {
            out.color_or_texture("reflectance", reflectance)?;
        }
        MaterialKindDescription::Dielectric { refraction, attenuation, roughness, priority } => {
            write_refraction(out, refraction)?;
            match *attenuation {
                DielectricAbsorption::None => {}
                DielectricAbsorption::Coefficient(absorption) => out.vector("absorption", absorption)?,
                DielectricAbsorption::Tint { color, distance } => {
                    out.vector("tint", color)?;
                    out.number("tintDistance", distance)?;
                }
            }
            out.number_or_texture("roughness", roughness)?;
            out.field("priority", priority)?;
        }
        MaterialKindDescription::Clear { priority } => out.field("priority", priority)?,
        MaterialKindDescription::Conductor { metal, roughness } => {
            match metal {
                MetalDescription::Named(name) => out.name("metal", name)?,
                MetalDescription::Index { eta, k } => {
                    out.vector("eta", *eta)?;
                    out.vector("k", *k)?;
                }
            }
            out.number_or_texture("roughness", roughness)?;
        }
        MaterialKindDescription::Thin { index, transmittance } => {
            out.number("indexOfRefraction", *index)?;
            out.color_or_texture("transmittance", transmittance)?;
        }
        MaterialKindDescription::Mix { first, second, amount } => {
            out.name("first", first)?;
            out.name("second", second)?;
            out.number_or_texture("amount", amount)?;
        }
    }
    material.medium.as_ref().map_or(Ok(()), |medium| out.name("medium", medium))?;
    match &material.normal_perturbation {
        None => {}
        Some(NormalPerturbationDescription::Bump { texture, height }) => {
            out.name("bump", texture)?;
            out.number("bumpHeight", *height)?;
        }
        Some(NormalPerturbationDescription::NormalMap(texture)) => out.name("normalMap", texture)?,
    }
    match &material.emission {
        None => {}
        Some(EmissionDescription::Radiance(radiance)) => out.vector("emission", *radiance)?,
        Some(EmissionDescription::Texture { name, scale }) => {
            out.texture("emission", name)?;
            out.number("emissionScale", *scale)?;
        }
    }
    out.close()
}
