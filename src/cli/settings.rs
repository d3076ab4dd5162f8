//! Conversion of command-line arguments to [`Settings`], and back to flags.

use super::args::MethodArguments;
use crate::camera::{Filter, FilterKind};
use crate::integrate::{
    Algorithm, CameraPathSettings, DEFAULT_ALPHA, FinalGathering, IndirectPhotons, LightTracing, Settings,
    VolumeEstimator,
};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::scene::Effect;
use clap::ValueEnum;
use clap::builder::PossibleValue;

impl ValueEnum for Algorithm {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(match self {
            Self::Hybrid => {
                "Path tracing with next-event estimation; photons carry caustics and a share of other indirect light"
            }
            Self::Path => "Path tracing",
            Self::Sppm => "Stochastic progressive photon mapping",
            Self::Ppm => "Progressive photon mapping with fixed hit points",
            Self::Pm => "Photon mapping with an indirect and a caustic map, and final gathering",
            Self::Distributed => {
                "Distributed ray tracing: soft shadows and glossy reflections, no diffuse interreflection"
            }
            Self::Whitted => "Whitted ray tracing: mirrors, glass, hard shadows",
            Self::Raycast => "Ray casting with the Phong model: no shadows, no bounces",
        }))
    }
}

impl ValueEnum for FinalGathering {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::None, Self::Bsdf, Self::Importance]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::None => {
                PossibleValue::new("none").help("Density estimate of the indirect map at the visible surface")
            }
            Self::Bsdf => PossibleValue::new("bsdf").help("Gather rays sampled from the BSDF"),
            Self::Importance => PossibleValue::new("importance").help("Gather rays guided by photons"),
        })
    }
}

impl ValueEnum for LightTracing {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Off, Self::Weighted, Self::Full]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Off => PossibleValue::new("off").help("Photon estimates carry all caustics"),
            Self::Weighted => PossibleValue::new("weighted").help("Each pixel weights both techniques"),
            Self::Full => PossibleValue::new("full").help("Light tracing carries all directly visible caustics"),
        })
    }
}

impl ValueEnum for IndirectPhotons {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Off, Self::Weighted, Self::Full]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Off => {
                PossibleValue::new("off").help("Camera paths carry all indirect light except that of caustics")
            }
            Self::Weighted => PossibleValue::new("weighted").help("Both techniques with weights that a pilot finds"),
            Self::Full => PossibleValue::new("full").help("Photon estimates carry all of it"),
        })
    }
}

impl ValueEnum for VolumeEstimator {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Beams, Self::BeamRadiance, Self::Points]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            Self::Beams => "beams",
            Self::BeamRadiance => "beam-radiance",
            Self::Points => "points",
        }))
    }
}

/// Returns the settings that the arguments describe. Error estimates, light groups, crop window and
/// clamping are off: the caller sets them.
pub(super) fn settings_from_arguments(arguments: &MethodArguments, effects: EffectOverrides) -> Settings {
    let unaimed_paths = arguments.photons.unwrap_or(Settings::default().unaimed_paths);
    Settings {
        camera_paths: CameraPathSettings {
            samples_per_pixel: arguments.spp,
            max_bounces: arguments.max_bounces,
            seed: arguments.seed,
            filter: Filter::new(arguments.filter),
            adaptive: arguments.adaptive,
            estimate_error: false,
            groups_light: false,
            crop: None,
            clamp: None,
            effects,
        },
        unaimed_paths,
        aimed_paths: arguments.caustic_photons.unwrap_or(unaimed_paths / 2),
        allows_ray_photon_balance: arguments.photons.is_none()
            && arguments.caustic_photons.is_none()
            && arguments.gather_k.is_none(),
        gather_k: arguments.gather_k,
        initial_gather_radius: arguments.radius,
        alpha: arguments.alpha.unwrap_or(DEFAULT_ALPHA),
        kernel: arguments.kernel,
        volume_estimator: arguments.volume,
        allows_prefix_rays: !arguments.no_prefix_rays,
        allows_environment_guiding: !arguments.no_environment_guiding,
        allows_scatter_point_guiding: !arguments.no_scatter_point_guiding,
        light_tracing: arguments.light_tracing,
        indirect_photons: arguments.indirect_photons,
        final_gathering: arguments.final_gathering,
    }
}

/// Returns the flags that reproduce `arguments` and `overrides`: first `--integrator`, then all
/// flags whose value is not the default. Leaves out the seed.
///
/// `effects_flag` is the name of the flag that stands for `overrides`: `--effects` or `--simulate`.
pub(super) fn method_flags(arguments: &MethodArguments, effects_flag: &str, overrides: EffectOverrides) -> Vec<String> {
    let MethodArguments {
        kernel, final_gathering, volume, light_tracing, indirect_photons, max_bounces, filter, ..
    } = *arguments;
    let number = |n: Option<u32>| n.map(|n| n.to_string());
    let unless_default = |is_default: bool, value: String| (!is_default).then_some(value);
    let named = [
        ("--integrator", Some(arguments.integrator.name().to_owned())),
        ("--photons", number(arguments.photons)),
        ("--caustic-photons", number(arguments.caustic_photons)),
        ("--spp", number(arguments.spp)),
        ("--gather-k", number(arguments.gather_k)),
        ("--radius", arguments.radius.map(|r| r.to_string())),
        ("--alpha", arguments.alpha.map(|alpha| alpha.to_string())),
        ("--kernel", unless_default(kernel == Kernel::default(), kernel_name(kernel).to_owned())),
        (
            "--final-gathering",
            unless_default(final_gathering == FinalGathering::default(), value_enum_name(final_gathering)),
        ),
        ("--light-tracing", unless_default(light_tracing == LightTracing::default(), value_enum_name(light_tracing))),
        (
            "--indirect-photons",
            unless_default(indirect_photons == IndirectPhotons::default(), value_enum_name(indirect_photons)),
        ),
        ("--volume", unless_default(volume == VolumeEstimator::default(), value_enum_name(volume))),
        (
            "--max-bounces",
            unless_default(max_bounces == CameraPathSettings::default().max_bounces, max_bounces.to_string()),
        ),
        ("--filter", unless_default(filter == FilterKind::default(), filter_name(filter).to_owned())),
        (effects_flag, effect_overrides_text(overrides)),
    ];
    let mut words: Vec<String> =
        named.into_iter().filter_map(|(flag, value)| Some([flag.to_owned(), value?])).flatten().collect();
    if arguments.adaptive {
        words.push("--adaptive".to_owned());
    }
    if arguments.no_prefix_rays {
        words.push("--no-prefix-rays".to_owned());
    }
    if arguments.no_environment_guiding {
        words.push("--no-environment-guiding".to_owned());
    }
    if arguments.no_scatter_point_guiding {
        words.push("--no-scatter-point-guiding".to_owned());
    }
    words
}

/// Returns the name of an enum's value on the command line.
fn value_enum_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned())
}

/// Returns the name of a density-estimation kernel on the command line.
pub(super) fn kernel_name(kernel: Kernel) -> &'static str {
    match kernel {
        Kernel::Box => "box",
        Kernel::Cone => "cone",
        Kernel::Epanechnikov => "epanechnikov",
    }
}

/// Returns the name of a pixel reconstruction filter on the command line.
fn filter_name(filter: FilterKind) -> &'static str {
    match filter {
        FilterKind::Box => "box",
        FilterKind::Tent => "tent",
        FilterKind::Gaussian => "gaussian",
        FilterKind::BlackmanHarris => "blackman-harris",
        FilterKind::Mitchell => "mitchell",
    }
}

/// Returns effect overrides as text, such as `+lens,-caustics`; `None` if no effect is forced on or
/// off.
fn effect_overrides_text(overrides: EffectOverrides) -> Option<String> {
    let signed =
        |e: Effect| overrides.effect_override(e).map(|on| format!("{}{}", if on { '+' } else { '-' }, e.name()));
    let words: Vec<String> = Effect::ALL.into_iter().filter_map(signed).collect();
    (!words.is_empty()).then(|| words.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Arguments, Command};
    use clap::Parser;

    fn parse_render_arguments(line: &str) -> (MethodArguments, EffectOverrides) {
        let words = ["caustica", "render", "a.txt", "-o", "a.png"].into_iter().chain(line.split_whitespace());
        match Arguments::try_parse_from(words).unwrap().command {
            Command::Render(render) => (render.method, render.effects.effects),
            _ => unreachable!("it is `render`"),
        }
    }

    #[test]
    fn printed_flags_parse_to_the_same_arguments() {
        let all = "--integrator pm --photons 2000 --caustic-photons 30 --spp 3 --gather-k 20 --radius 0.012345679 --alpha 0.7 --kernel cone \
                   --final-gathering importance --volume beam-radiance --light-tracing full --max-bounces 7 --filter mitchell --effects \
                   -caustics,+lens --adaptive";
        let (method, overrides) = parse_render_arguments(all);
        let written = method_flags(&method, "--effects", overrides).join(" ");
        let (again, same) = parse_render_arguments(&written);
        assert_eq!((format!("{again:?}"), same), (format!("{method:?}"), overrides), "{written}");
        for flag in all.split_whitespace().filter(|word| word.starts_with("--")) {
            assert!(written.split(' ').any(|word| word == flag), "{flag} is not in {written}");
        }
        assert_eq!(
            method_flags(&parse_render_arguments("").0, "--effects", EffectOverrides::NO_OVERRIDES),
            ["--integrator", "hybrid"]
        );
        for kind in ["box", "cone", "epanechnikov"] {
            assert_eq!(kernel_name(kind.parse().unwrap()), kind);
        }
        for kind in ["box", "tent", "gaussian", "blackman-harris", "mitchell"] {
            assert_eq!(filter_name(kind.parse().unwrap()), kind);
        }
    }
}
