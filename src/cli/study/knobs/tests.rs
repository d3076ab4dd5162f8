use super::*;
use crate::cli::study::variants::default_method_arguments;

fn knob_variant_labels(algorithm: Algorithm, change: impl FnOnce(&mut MethodArguments)) -> Vec<String> {
    let mut shared = default_method_arguments();
    change(&mut shared);
    let pilot =
        PilotChosenSettings { samples_per_pixel: 1, unaimed_paths: 1000, aimed_paths: 0, gather_radius: Some(0.25) };
    let all = one_setting_variants(VariantArguments::from_algorithm(algorithm, &shared), &pilot);
    // Parsing the label of a variant gives the same variant.
    for named in &all {
        let again = VariantArguments::parse(&named.label, &all[0].method).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(format!("{:?}", again.method), format!("{:?}", named.method));
    }
    all.into_iter().map(|named| named.label).collect()
}

#[test]
fn variants_change_one_setting_each() {
    let pm = knob_variant_labels(Algorithm::Pm, |_| {});
    let ends = |label: &str| pm.iter().any(|l| l.strip_prefix("pm ") == Some(label));
    for expected in [
        "--gather-k 10",
        "--gather-k 200",
        "--radius 0.125",
        "--radius 0.25",
        "--radius 0.5",
        "--kernel box",
        "--kernel cone",
        "--photons 250 --caustic-photons 0",
        "--photons 4000 --caustic-photons 0",
        "--spp 2",
        "--adaptive",
        "--final-gathering none",
        "--final-gathering importance",
    ] {
        assert!(ends(expected), "{expected} is not in {pm:?}");
    }
    // The 17 variants: the method itself, 5 of `--gather-k`, 3 of `--radius`, 2 of `--kernel`, 2 of
    // photon counts, 1 of `--spp`, 1 of `--adaptive` and 2 of `--final-gathering`. Half of one
    // camera ray is rounded to one, so `--spp` has only one variant.
    assert_eq!((pm.len(), pm[0].as_str()), (17, "pm"));
    assert_eq!(knob_variant_labels(Algorithm::Path, |_| {}), ["path", "path --spp 2", "path --adaptive"]);
}

#[test]
fn knob_studies_do_not_repeat_a_given_setting() {
    let sppm = knob_variant_labels(Algorithm::Sppm, |method| {
        (method.gather_k, method.adaptive, method.kernel) = (Some(20), true, Kernel::Box);
    });
    assert!(sppm.iter().all(|l| !l.contains("--adaptive") && !l.ends_with("--gather-k 20") && !l.contains("box")));
    assert!(sppm.contains(&"sppm --kernel epanechnikov".to_owned()));
}
