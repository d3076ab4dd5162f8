//! The variants that the command line names.

use crate::cli::args::MethodArguments;
use crate::cli::settings::{flags, settings};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use crate::study::methods::Variant;
use clap::{Parser, ValueEnum};

/// Flags that all variants share, as pictures made with others have another truth or other noise.
const SHARED: [&str; 3] = ["--integrator", "--filter", "--seed"];

/// A `--variant` that cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--variant \"{text}\": {reason}")]
#[diagnostic(help("{remedy}"))]
pub(super) struct BadVariant {
    text: String,
    reason: String,
    remedy: String,
}

/// The flags of a variant.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, args_override_self = true, disable_help_flag = true)]
struct Flags {
    #[command(flatten)]
    method: MethodArguments,
}

/// A label with its arguments.
pub(super) struct Named {
    pub label: String,
    pub method: MethodArguments,
}

impl Named {
    /// A method with the flags given to all.
    pub fn plain(algorithm: Algorithm, shared: &MethodArguments) -> Self {
        let method = MethodArguments { integrator: algorithm, ..shared.clone() };
        Self { label: algorithm.name().to_owned(), method }
    }

    /// Reads a method and its flags, which go before those given to all.
    pub fn read(text: &str, shared: &MethodArguments) -> Result<Self, BadVariant> {
        let bad = |reason: String, remedy: String| BadVariant { text: text.to_owned(), reason, remedy };
        let words: Vec<&str> = text.split_whitespace().collect();
        let names = Algorithm::ALL.map(Algorithm::name).join(", ");
        let remedy = || format!("begin with one of {names}, as in --variant \"sppm --gather-k 20\"");
        let (first, rest) = words.split_first().ok_or_else(|| bad("it names no method".to_owned(), remedy()))?;
        let known = Algorithm::from_str(first, false);
        let algorithm = known.map_err(|_| bad(format!("there is no method `{first}`"), remedy()))?;
        let told = |flag: &&&str| rest.iter().any(|word| word.split('=').next() == Some(**flag));
        if let Some(flag) = SHARED.iter().find(told) {
            let remedy = match *flag {
                "--integrator" => "the first word names the method".to_owned(),
                _ => format!("give {flag} to the study itself"),
            };
            return Err(bad(format!("{flag} is the same for all methods"), remedy));
        }
        let mut line =
            flags(&MethodArguments { integrator: algorithm, ..shared.clone() }, "", EffectOverrides::PLANNED);
        line.extend(rest.iter().map(|&word| word.to_owned()));
        let read = Flags::try_parse_from(line).map_err(|error| {
            let error = error.render().to_string();
            let told = error.split("\n\nUsage").next().unwrap_or_default().split("\n\nFor more").next();
            let told = told.unwrap_or_default().trim_start_matches("error: ").trim();
            bad(told.to_owned(), "a variant takes the flags of light of `caustica render`".to_owned())
        })?;
        Ok(Self {
            label: words.join(" "),
            method: MethodArguments { seed: shared.seed, filter: shared.filter, ..read.method },
        })
    }

    pub fn variant(self, wishes: EffectOverrides) -> Variant {
        Variant {
            label: self.label,
            algorithm: self.method.integrator,
            settings: settings(&self.method, wishes),
            flags: flags(&self.method, "--effects", wishes),
        }
    }
}

/// What all variants share where nothing is said.
#[cfg(test)]
pub(super) fn defaults() -> MethodArguments {
    Flags::try_parse_from([""; 0]).unwrap().method
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::FilterKind;

    fn shared(line: &str) -> MethodArguments {
        Flags::try_parse_from(line.split_whitespace()).unwrap().method
    }

    #[test]
    fn flags_of_a_variant_go_before_those_of_all() {
        let all = shared("--photons 2k --radius .5 --filter tent --seed 9 --adaptive");
        let read = Named::read("  sppm  --photons 4k --gather-k 20 ", &all).unwrap();
        assert_eq!(read.label, "sppm --photons 4k --gather-k 20");
        let MethodArguments { integrator, photons, gather_k, radius, filter, seed, adaptive, .. } = read.method;
        assert_eq!((integrator, photons, gather_k, radius), (Algorithm::Sppm, Some(4000), Some(20), Some(0.5)));
        assert_eq!((filter, seed, adaptive), (FilterKind::Tent, 9, true));
        let variant = read.variant(EffectOverrides::PLANNED);
        assert_eq!((variant.settings.caustic_photons, variant.settings.eye.seed), (2000, 9));
        let told = "--integrator sppm --photons 4000 --gather-k 20 --radius 0.5 --filter tent --adaptive";
        assert_eq!(variant.flags.join(" "), told);
        assert_eq!(
            Named::plain(Algorithm::Ppm, &all).variant(EffectOverrides::PLANNED).flags[..2],
            ["--integrator", "ppm"]
        );
    }

    #[test]
    fn what_is_no_variant_is_refused_with_place_and_remedy() {
        for (text, reason, remedy) in [
            ("", "it names no method", "begin with one of hybrid, path"),
            ("--gather-k 20", "there is no method `--gather-k`", "begin with"),
            ("bdpt --spp 2", "there is no method `bdpt`", "begin with one of hybrid"),
            ("sppm --seed 3", "--seed is the same for all", "give --seed to the study"),
            ("sppm --filter=box", "--filter is the same for all", "give --filter"),
            ("sppm --integrator path", "--integrator is the same", "the first word"),
            ("sppm --gather-k many", "'--gather-k <K>': `many` is no count", "flags of light"),
            ("sppm --radius", "--radius <R>", "flags of light"),
            ("sppm --passes 3", "'--passes'", "flags of light"),
            ("sppm extra", "'extra'", "flags of light"),
        ] {
            let Err(bad) = Named::read(text, &shared("")) else { panic!("`{text}` was read") };
            let told = bad.to_string();
            assert!(told.contains(&format!("--variant \"{text}\": ")) && told.contains(reason), "{told}");
            assert!(bad.remedy.contains(remedy) && !told.contains("Usage"), "{told} {}", bad.remedy);
        }
    }
}
