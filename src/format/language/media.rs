//! Participating media.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, Spanned,
    TransformedBoxDescription,
};
use super::super::error::SceneError;
use super::fields::{Fields, fields};
use super::lexer::Token;
use super::maps::write_bare_maps;
use super::names::required_name;
use super::reader::Parser;
use super::schema::{Block, Entry, Field, Kind, MAX_COEFFICIENT, Range, field, find, keywords};
use super::writer::Writer;

/// The media.
pub(super) static MEDIA: [Entry<ReadDensity>; 2] =
    [Entry { block: &MEDIUM, read: grid }, Entry { block: &CLOUD, read: cloud }];

/// Reader of the density of a medium.
type ReadDensity = fn(&Fields<'_>) -> Result<DensityDescription, SceneError>;

const COEFFICIENT: Range = Range::Within(0.0, MAX_COEFFICIENT);

static OPTICS: [Field; 7] = [
    field("absorption", Kind::Color, COEFFICIENT, "absorption coefficient σa").absent("0 0 0").unit("1/length"),
    field("scattering", Kind::Color, COEFFICIENT, "scattering coefficient σs").absent("0 0 0").unit("1/length"),
    field("extinction", Kind::Color, COEFFICIENT, "σa + σs, together with `albedo` instead of both").unit("1/length"),
    field("albedo", Kind::Color, Range::Within(0.0, 1.0), "σs/(σa + σs), together with `extinction`"),
    field("emission", Kind::Color, COEFFICIENT, "radiance gained per length")
        .or(&[0.0, 0.0, 0.0])
        .unit("W/(m² sr)/length"),
    field("phase", Kind::Word(&["isotropic", "rayleigh", "henyey-greenstein"]), Range::Any, "phase function")
        .absent("`isotropic`; with `anisotropy`, `henyey-greenstein`"),
    field("anisotropy", Kind::Number, Range::Special("−1 < g < 1"), "mean cosine g; above 0 scatters forward"),
];

static EXTENT: [Field; 3] = [
    field("min", Kind::Point, Range::Any, "least corner of the box; required, but for a `Medium` without `grid`"),
    field("max", Kind::Point, Range::Any, "greatest corner, above `min` in each component"),
    field("Transform", Kind::Maps, Range::Any, "maps from the space of the box to the world").absent("none"),
];

static MEDIUM: Block = Block {
    keyword: "Medium",
    aliases: &[],
    fields: &[
        field("grid", Kind::Name, Range::Any, "file of densities").absent("none: density 1 everywhere"),
        field("densityScale", Kind::Number, Range::Positive, "with `grid`: factor of its densities").absent("1"),
    ],
    shared: &[&OPTICS, &EXTENT],
    help: "a medium of constant density, or with the densities of a grid",
    course: false,
};

static CLOUD: Block = Block {
    keyword: "Cloud",
    aliases: &[],
    fields: &[
        field("cover", Kind::Number, Range::Within(0.0, 1.0), "amount of noise: 0 is empty, 1 is noise everywhere")
            .or(&[0.5]),
        field("softness", Kind::Number, Range::Within(0.0, 1.0), "share of the radius over which the edge fades")
            .or(&[0.3]),
        field("octaves", Kind::Whole, Range::Within(1.0, 16.0), "octaves of noise").or(&[5.0]),
        field("frequency", Kind::Number, Range::Positive, "periods of the first octave along a side of the box")
            .or(&[4.0]),
        field("seed", Kind::Whole, Range::Any, "seed of the noise").or(&[0.0]),
        field("resolution", Kind::Whole, Range::Within(2.0, 512.0), "grid cells along the longest side").or(&[96.0]),
    ],
    shared: &[&OPTICS, &EXTENT],
    help: "a medium with noise as density, from 0 to 1, in the ellipsoid inscribed in its box",
    course: false,
};

/// Reads a `Media` block.
pub(super) fn media<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    if !parser.scope.materials.is_empty() {
        let message = "`Media` stand behind the `Materials` that may use them".to_owned();
        let help = "put the Media ahead of the Materials".to_owned();
        return Err(parser.lexer.error(block.span(), message, "too late", help));
    }
    parser.scope.media.clear();
    parser.list(block, ("numMedia", "medium"), &keywords(&["numMedia"], &MEDIA), |parser, word| {
        let taken = |parser: &Parser<'a>, name: &str| parser.scope.media.iter().any(|m| m.value.name == name);
        let name = required_name(parser, word, ("medium", "media"), taken)?;
        let (medium, error) = match medium(parser, word, &name) {
            Ok(medium) => (medium, Ok(())),
            // A medium with errors still defines its name, so that materials can refer to it.
            Err(error) => (placeholder(&name), Err(error)),
        };
        parser.scope.media.push(Spanned::new(medium, word.span()));
        error
    })
}

/// Returns an empty medium.
fn placeholder(name: &str) -> MediumDescription {
    let coefficients = MediumCoefficients::AbsorptionScattering { absorption: DVec3::ZERO, scattering: DVec3::ZERO };
    let (emission, phase, density) =
        (DVec3::ZERO, PhaseFunctionDescription::Isotropic, DensityDescription::Homogeneous);
    MediumDescription { name: name.to_owned(), coefficients, emission, phase, density }
}

/// Reads the fields of a medium.
fn medium<'a>(parser: &mut Parser<'a>, word: Token<'a>, name: &str) -> Result<MediumDescription, SceneError> {
    let Some(entry) = find(&MEDIA, word.text) else {
        return Err(parser.unexpected(word, &keywords(&[], &MEDIA)));
    };
    let f = &fields(parser, word, entry.block)?;
    Ok(MediumDescription {
        name: name.to_owned(),
        coefficients: coefficients(f)?,
        emission: f.vector("emission")?,
        phase: phase(f)?,
        density: (entry.read)(f)?,
    })
}

fn coefficients(f: &Fields<'_>) -> Result<MediumCoefficients, SceneError> {
    for whole in ["extinction", "albedo"] {
        for part in ["absorption", "scattering"] {
            f.exclude(part, whole)?;
        }
    }
    let Some(extinction) = f.get("extinction") else {
        f.refuse(&["albedo"], "has no effect without `extinction`")?;
        let part = |name| f.get(name).map_or(DVec3::ZERO, |c| c.vector());
        return Ok(MediumCoefficients::AbsorptionScattering {
            absorption: part("absorption"),
            scattering: part("scattering"),
        });
    };
    Ok(MediumCoefficients::ExtinctionAlbedo { extinction: extinction.vector(), albedo: f.vector("albedo")? })
}

fn phase(f: &Fields<'_>) -> Result<PhaseFunctionDescription, SceneError> {
    let (phase, anisotropy) = (f.get("phase"), f.get("anisotropy"));
    let word = phase.map(|phase| phase.text().value);
    match (word.as_deref(), anisotropy) {
        (None | Some("isotropic"), None) => Ok(PhaseFunctionDescription::Isotropic),
        (Some("rayleigh"), None) => Ok(PhaseFunctionDescription::Rayleigh),
        (None | Some("henyey-greenstein"), Some(g)) => {
            g.ensure(g.number().abs() <= 1.0 - 1e-7, "must lie inside -1 … 1, by 1e-7 at least")?;
            Ok(PhaseFunctionDescription::HenyeyGreenstein(g.number()))
        }
        (Some(_), Some(g)) => {
            g.ensure(false, "belongs to `phase henyey-greenstein`: leave one of both out")?;
            Ok(PhaseFunctionDescription::Isotropic)
        }
        (Some(_), None) => Ok(PhaseFunctionDescription::HenyeyGreenstein(f.number("anisotropy")?)),
    }
}

fn grid(f: &Fields<'_>) -> Result<DensityDescription, SceneError> {
    let Some(grid) = f.get("grid") else {
        f.refuse(&["min", "max", "Transform", "densityScale"], "has no effect without `grid`")?;
        return Ok(DensityDescription::Homogeneous);
    };
    let scale = f.get("densityScale").map_or(1.0, |scale| scale.number());
    Ok(DensityDescription::Grid { path: grid.text(), scale, extent: extent(f)? })
}

fn cloud(f: &Fields<'_>) -> Result<DensityDescription, SceneError> {
    Ok(DensityDescription::Cloud {
        cover: f.number("cover")?,
        softness: f.number("softness")?,
        octaves: f.whole("octaves")?,
        frequency: f.number("frequency")?,
        seed: f.whole("seed")?,
        resolution: f.whole("resolution")?,
        extent: extent(f)?,
    })
}

fn extent(f: &Fields<'_>) -> Result<TransformedBoxDescription, SceneError> {
    let (min, max) = (f.vector("min")?, f.require("max")?);
    let sides = max.vector() - min;
    max.ensure(sides.min_element() > 0.0 && sides.is_finite(), "must be above `min` in each component")?;
    Ok(TransformedBoxDescription { min, max: max.vector(), maps: f.maps("Transform") })
}

/// Prints a medium.
pub(super) fn write_medium(out: &mut Writer<'_, '_>, medium: &MediumDescription) -> fmt::Result {
    let block = match medium.density {
        DensityDescription::Homogeneous | DensityDescription::Grid { .. } => &MEDIUM,
        DensityDescription::Cloud { .. } => &CLOUD,
    };
    out.start_named(block, &medium.name)?;
    match medium.coefficients {
        MediumCoefficients::AbsorptionScattering { absorption, scattering } => {
            out.vector("absorption", absorption)?;
            out.vector("scattering", scattering)?;
        }
        MediumCoefficients::ExtinctionAlbedo { extinction, albedo } => {
            out.vector("extinction", extinction)?;
            out.vector("albedo", albedo)?;
        }
    }
    if medium.emission != DVec3::ZERO {
        out.vector("emission", medium.emission)?;
    }
    match medium.phase {
        PhaseFunctionDescription::Isotropic => {}
        PhaseFunctionDescription::Rayleigh => out.field("phase", "rayleigh")?,
        PhaseFunctionDescription::HenyeyGreenstein(g) => out.number("anisotropy", g)?,
    }
    match &medium.density {
        DensityDescription::Homogeneous => {}
        DensityDescription::Grid { path, scale, extent } => {
            out.name("grid", path)?;
            out.number("densityScale", *scale)?;
            write_extent(out, extent)?;
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            out.number("cover", *cover)?;
            out.number("softness", *softness)?;
            out.field("octaves", octaves)?;
            out.number("frequency", *frequency)?;
            out.field("seed", seed)?;
            out.field("resolution", resolution)?;
            write_extent(out, extent)?;
        }
    }
    out.close()
}

fn write_extent(out: &mut Writer<'_, '_>, extent: &TransformedBoxDescription) -> fmt::Result {
    out.vector("min", extent.min)?;
    out.vector("max", extent.max)?;
    write_bare_maps(out, &extent.maps)
}
