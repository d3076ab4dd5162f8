//! Tests of media and references to them.

use super::*;
use crate::format::description::{
    DensityDescription, MediumCoefficients, MediumDescription, NullInterfaceDescription, PhaseFunctionDescription,
    TransformStep, TransformedBoxDescription,
};

fn parse_media(body: &str) -> Vec<MediumDescription> {
    let d = parse_with_camera(&format!("Media {{ {body} }} Group {{ }}")).unwrap();
    d.media.into_iter().map(|m| m.value).collect()
}

#[track_caller]
fn assert_media_error(body: &str, message: &str, help: &str) {
    assert_first_error(&format!("Media {{ {body} }}"), message, help);
}

#[test]
fn media_read_all_their_fields() {
    let media = parse_media(
        "numMedia 4 Medium a { } Medium \"b c\" { scattering 1 2 3 absorption 4 5 6 emission 7 8 9 phase rayleigh }
         Medium d { albedo 1 .5 0 extinction 10 20 30 anisotropy -.5 } Medium e { phase henyey-greenstein anisotropy .99 }",
    );
    let parts = |absorption, scattering| MediumCoefficients::AbsorptionScattering { absorption, scattering };
    let nothing = parts(DVec3::ZERO, DVec3::ZERO);
    let a = MediumDescription {
        name: "a".to_owned(),
        coefficients: nothing,
        emission: DVec3::ZERO,
        phase: PhaseFunctionDescription::Isotropic,
        density: DensityDescription::Homogeneous,
    };
    let b = MediumDescription {
        name: "b c".to_owned(),
        coefficients: parts(DVec3::new(4.0, 5.0, 6.0), DVec3::new(1.0, 2.0, 3.0)),
        emission: DVec3::new(7.0, 8.0, 9.0),
        phase: PhaseFunctionDescription::Rayleigh,
        ..a.clone()
    };
    let (extinction, albedo) = (DVec3::new(10.0, 20.0, 30.0), DVec3::new(1.0, 0.5, 0.0));
    let d = MediumDescription {
        name: "d".to_owned(),
        coefficients: MediumCoefficients::ExtinctionAlbedo { extinction, albedo },
        phase: PhaseFunctionDescription::HenyeyGreenstein(-0.5),
        ..a.clone()
    };
    let e = MediumDescription {
        name: "e".to_owned(),
        phase: PhaseFunctionDescription::HenyeyGreenstein(0.99),
        ..a.clone()
    };
    assert_eq!(media, [a, b, d, e]);
}

#[test]
fn densities_come_from_grids_or_noise() {
    let [smoke, plain, cloud] = &parse_media(
        "Medium smoke { grid dir/s.grid densityScale 3 min -1 0 1 max 1 2 3 Transform { YRotate 30 } }
         Cloud plain { min 0 0 0 max 1 1 1 }
         Cloud full { cover 1 softness 0 octaves 16 frequency 2.5 seed 4294967295 resolution 512 min 0 0 0 max 1 1 1 }",
    )[..] else {
        panic!()
    };
    let extent = TransformedBoxDescription {
        min: DVec3::new(-1.0, 0.0, 1.0),
        max: DVec3::new(1.0, 2.0, 3.0),
        steps: vec![TransformStep::RotateY(30.0)],
    };
    assert_eq!(
        smoke.density,
        DensityDescription::Grid { path: name_with_empty_span("dir/s.grid"), scale: 3.0, extent }
    );
    let extent = TransformedBoxDescription { min: DVec3::ZERO, max: DVec3::ONE, steps: vec![] };
    let expected = |cover, softness, octaves, frequency, seed, resolution| {
        let extent = extent.clone();
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent }
    };
    assert_eq!(plain.density, expected(0.5, 0.3, 5, 4.0, 0, 96));
    assert_eq!(cloud.density, expected(1.0, 0.0, 16, 2.5, u32::MAX, 512));
}

#[test]
fn materials_and_background_refer_to_media() {
    let text = "Background { medium fog color 0 0 0 } Media { Medium fog { } Medium milk { } }
        Materials { Dielectric { medium milk } Clear c { medium \"fog\" priority 255 } Clear { } } Group { }";
    let d = parse_with_camera(text).unwrap();
    assert_eq!((d.background, d.ambient_medium.as_ref()), (DVec3::ZERO, Some(&name_with_empty_span("fog"))));
    let found: Vec<_> = d.materials.iter().map(|m| (&m.kind, m.medium.clone())).collect();
    assert!(matches!(found[0].0, MaterialKindDescription::Dielectric(_)));
    assert_eq!(found[0].1, Some(name_with_empty_span("milk")));
    assert_eq!(
        found[1],
        (
            &MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 255 }),
            Some(name_with_empty_span("fog"))
        )
    );
    assert_eq!(found[2], (&MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 }), None));
    let again = parse_with_camera("Background { medium fog } Background { } Group { }").unwrap();
    assert_eq!(again.ambient_medium, None, "a block that comes again replaces the one before");
}

#[test]
fn medium_errors_have_position_and_remedy() {
    assert_media_error("‹Medium› { }", "this `Medium` has no name", "`Medium name {");
    assert_media_error("Medium a { } Cloud ‹a› { }", "two media are called `a`", "another name");
    assert_media_error("‹Mediun› a { }", "unexpected `Mediun` in `Media`", "did you mean `Medium`?");
    assert_media_error("numMedia ‹2› Medium a { }", "`numMedia` is 2, but 1 medium follows", "`numMedia 1`");
    assert_media_error("Medium a { ‹scatering› 1 1 1 }", "unexpected `scatering`", "did you mean `scattering`?");
    for field in ["scattering", "absorption", "emission", "albedo 1 1 1 extinction"] {
        let name = field.rsplit(' ').next().unwrap();
        for value in ["-1 0 0", "0 0 1e13"] {
            assert_media_error(
                &format!("Medium a {{ {field} ‹{value}› }}"),
                &format!("`{name}` of `Medium`"),
                "between 0 and 1e12",
            );
        }
        assert_media_error(&format!("Medium a {{ {field} ‹nan› 1 1 }}"), "not a finite number", "finite");
    }
    assert_media_error("Medium a { extinction 1 1 1 albedo ‹1 1.5 1› }", "`albedo` of `Medium`", "between 0 and 1");
    assert_media_error("‹Medium› a { extinction 1 1 1 }", "`Medium` has no `albedo`", "add `albedo`");
    assert_media_error("Medium a { albedo ‹1 1 1› }", "`albedo` of `Medium`", "without `extinction`");
    assert_media_error(
        "Medium a { absorption 1 1 1 ‹extinction› 1 1 1 }",
        "both `absorption` and `extinction`",
        "keep one of",
    );
    assert_media_error("Medium a { albedo 1 1 1 ‹scattering› 1 1 1 }", "both `albedo` and `scattering`", "keep one of");
    assert_media_error("Medium a { phase ‹mie› }", "`phase` of `Medium` cannot be `mie`", "`isotropic`, `rayleigh`");
    for g in ["1", "-1", "2", ".99999999"] {
        assert_media_error(&format!("Medium a {{ anisotropy ‹{g}› }}"), "`anisotropy` of `Medium`", "inside -1 … 1");
    }
    assert_media_error(
        "Medium a { phase rayleigh anisotropy ‹.5› }",
        "`anisotropy` of `Medium`",
        "leave one of both out",
    );
    assert_media_error("‹Medium› a { phase henyey-greenstein }", "`Medium` has no `anisotropy`", "add `anisotropy`");
}

#[test]
fn density_errors_have_position_and_remedy() {
    let extent = "min 0 0 0 max 1 1 1";
    for field in ["min ‹0 0 0›", "max ‹0 0 0›", "densityScale ‹2›"] {
        assert_media_error(&format!("Medium a {{ {field} }}"), "of `Medium` cannot be", "has no effect without `grid`");
    }
    assert_media_error("‹Medium› a { grid b }", "`Medium` has no `min`", "add `min`");
    assert_media_error(
        "Medium a { grid b min 0 0 0 max ‹1 0 1› }",
        "`max` of `Medium`",
        "above `min` in each component",
    );
    assert_media_error("Medium a { grid b min 0 0 -1.7e308 max ‹1 1 1.7e308› }", "`max` of `Medium`", "above `min`");
    assert_media_error(
        &format!("Medium a {{ grid b {extent} densityScale ‹0› }}"),
        "`densityScale` of `Medium`",
        "above 0",
    );
    assert_media_error(
        &format!("Medium a {{ ‹cover› 1 grid b {extent} }}"),
        "unexpected `cover` in `Medium`",
        "may hold",
    );
    assert_media_error(&format!("Cloud a {{ ‹grid› b {extent} }}"), "unexpected `grid` in `Cloud`", "may hold");
    assert_media_error("‹Cloud› a { min 0 0 0 }", "`Cloud` has no `max`", "add `max`");
    let cloud = |field: &str, help: &str| {
        assert_media_error(&format!("Cloud a {{ {extent} {field} }}"), "of `Cloud` cannot be", help)
    };
    cloud("cover ‹1.5›", "between 0 and 1");
    cloud("softness ‹-.1›", "between 0 and 1");
    cloud("octaves ‹0›", "from 1 to 16");
    cloud("octaves ‹17›", "from 1 to 16");
    cloud("frequency ‹0›", "above 0");
    cloud("resolution ‹1›", "from 2 to 512");
    cloud("resolution ‹513›", "from 2 to 512");
}

#[test]
fn medium_reference_errors_have_position_and_remedy() {
    assert_first_error("Materials { Mirror { } } ‹Media› { }", "behind the `Materials`", "ahead of the Materials");
    let fill = |name: &str| {
        format!("Media {{ Medium fog {{ }} Medium milk {{ }} }} Materials {{ Clear {{ medium {name} }} }}")
    };
    assert_first_error(&fill("‹fogg›"), "no medium is called `fogg`", "did you mean `fog`?");
    assert_first_error(&fill("‹water›"), "no medium is called `water`", "known are fog, milk");
    assert_first_error(
        "Materials { Dielectric { medium ‹fog› } }",
        "no medium is called `fog`",
        "`Media { Medium name",
    );
    assert_first_error(
        "Background { medium ‹frog› } Media { Medium fog { } } Group { }",
        "called `frog`",
        "did you mean `fog`?",
    );
    assert_first_error("Background { medium ‹fog› } Group { }", "no medium is called `fog`", "in the file");
    let clear = |field: &str, help: &str| {
        assert_first_error(&format!("Materials {{ Clear {{ {field} }} }}"), "of `Clear`", help)
    };
    clear("emission ‹1 1 1›", "give `emission` to its medium");
    clear("emissionScale ‹2›", "give `emission` to its medium");
    clear("bump ‹lumps› bumpHeight 1", "leave it out");
    clear("normalMap ‹lumps›", "leave it out");
    clear("priority ‹256›", "from 0 to 255");
    assert_first_error("Materials { Clear { ‹roughness› 1 } }", "unexpected `roughness` in `Clear`", "may hold");
    assert_first_error("Materials { Mirror { ‹medium› fog } }", "unexpected `medium` in `Mirror`", "may hold");
    let mix = "Materials { Clear a { } Mirror b { } Mix { first b second ‹a› amount 1 } }";
    assert_first_error(mix, "a mix cannot be `Clear`", "`Dielectric { indexOfRefraction 1 … }`");
}
