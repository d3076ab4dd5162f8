use super::*;
use crate::camera::FilterKind;

fn parse_method_arguments(line: &str) -> MethodArguments {
    VariantFlags::try_parse_from(line.split_whitespace()).unwrap().method
}

#[test]
fn flags_of_a_variant_override_shared_flags() {
    let all = parse_method_arguments("--photons 2k --radius .5 --filter tent --seed 9 --adaptive");
    let read = VariantArguments::parse("  sppm  --photons 4k --gather-k 20 ", &all).unwrap();
    assert_eq!(read.label, "sppm --photons 4k --gather-k 20");
    let MethodArguments { integrator, photons, gather_k, radius, filter, seed, adaptive, .. } = read.method;
    assert_eq!((integrator, photons, gather_k, radius), (Algorithm::Sppm, Some(4000), Some(20), Some(0.5)));
    assert_eq!((filter, seed, adaptive), (FilterKind::Tent, 9, true));
    let variant = read.into_method_variant(EffectOverrides::NO_OVERRIDES);
    assert_eq!((variant.settings.aimed_paths, variant.settings.camera_paths.seed), (2000, 9));
    let expected = "--integrator sppm --photons 4000 --gather-k 20 --radius 0.5 --filter tent --adaptive";
    assert_eq!(variant.flags.join(" "), expected);
    assert_eq!(
        VariantArguments::from_algorithm(Algorithm::Ppm, &all).into_method_variant(EffectOverrides::NO_OVERRIDES).flags
            [..2],
        ["--integrator", "ppm"]
    );
}

#[test]
fn bad_variants_are_refused_with_a_remedy() {
    for (text, reason, remedy) in [
        ("", "it names no method", "begin with one of hybrid, path"),
        ("--gather-k 20", "there is no method `--gather-k`", "begin with"),
        ("bdpt --spp 2", "there is no method `bdpt`", "begin with one of hybrid"),
        ("sppm --seed 3", "--seed is the same for all", "give --seed to the study"),
        ("sppm --filter=box", "--filter is the same for all", "give --filter"),
        ("sppm --integrator path", "--integrator is the same", "the first word"),
        ("sppm --gather-k many", "'--gather-k <K>': `many` is not a count", "flags of methods"),
        ("sppm --radius", "--radius <R>", "flags of methods"),
        ("sppm --passes 3", "'--passes'", "flags of methods"),
        ("sppm extra", "'extra'", "flags of methods"),
    ] {
        let Err(bad) = VariantArguments::parse(text, &parse_method_arguments("")) else { panic!("`{text}` was read") };
        let message = bad.to_string();
        assert!(message.contains(&format!("--variant \"{text}\": ")) && message.contains(reason), "{message}");
        assert!(bad.remedy.contains(remedy) && !message.contains("Usage"), "{message} {}", bad.remedy);
    }
}
