//! Variants of methods, as named by `--variant`.

use crate::cli::args::MethodArguments;
use crate::cli::settings::{flags, settings};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use crate::study::methods::Variant;
use clap::{Parser, ValueEnum};

/// Flags that all variants must share, because they change the true picture or the noise.
const SHARED: [&str; 3] = ["--integrator", "--filter", "--seed"];

/// A `--variant` that cannot be parsed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--variant \"{text}\": {reason}")]
#[diagnostic(help("{remedy}"))]
pub(super) struct BadVariant {
    text: String,
    reason: String,
    remedy: String,
}

/// Parser of the flags of a variant.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, args_override_self = true, disable_help_flag = true)]
struct Flags {
    #[command(flatten)]
    method: MethodArguments,
}

/// A variant: its label and its arguments.
pub(super) struct Named {
    pub label: String,
    pub method: MethodArguments,
}

impl Named {
    /// A method with the flags of all methods.
    pub fn plain(algorithm: Algorithm, shared: &MethodArguments) -> Self {
        let method = MethodArguments { integrator: algorithm, ..shared.clone() };
        Self { label: algorithm.name().to_owned(), method }
    }

    /// Parses a method and its flags, which override the flags of all methods.
    ///
    /// # Errors
    /// [`BadVariant`] if there is no such method, or a flag is unknown or shared.
    pub fn read(text: &str, shared: &MethodArguments) -> Result<Self, BadVariant> {
        let bad = |reason: String, remedy: String| BadVariant { text: text.to_owned(), reason, remedy };
        let words: Vec<&str> = text.split_whitespace().collect();
        let names = Algorithm::ALL.map(Algorithm::name).join(", ");
        let remedy = || format!("begin with one of {names}, as in --variant \"sppm --gather-k 20\"");
        let (first, rest) = words.split_first().ok_or_else(|| bad("it names no method".to_owned(), remedy()))?;
        let known = Algorithm::from_str(first, false);
        let algorithm = known.map_err(|_| bad(format!("there is no method `{first}`"), remedy()))?;
        let given = |flag: &&&str| rest.iter().any(|word| word.split('=').next() == Some(**flag));
        if let Some(flag) = SHARED.iter().find(given) {
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
            let reason = error.split("\n\nUsage").next().unwrap_or_default().split("\n\nFor more").next();
            let reason = reason.unwrap_or_default().trim_start_matches("error: ").trim();
            bad(reason.to_owned(), "a variant takes the flags of methods, which `caustica render` lists".to_owned())
        })?;
        Ok(Self {
            label: words.join(" "),
            method: MethodArguments { seed: shared.seed, filter: shared.filter, ..read.method },
        })
    }

    /// The variant for a study.
    pub fn variant(self, overrides: EffectOverrides) -> Variant {
        Variant {
            label: self.label,
            algorithm: self.method.integrator,
            settings: settings(&self.method, overrides),
            flags: flags(&self.method, "--effects", overrides),
        }
    }
}

/// The default arguments of all variants.
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
    fn flags_of_a_variant_override_shared_flags() {
        let all = shared("--photons 2k --radius .5 --filter tent --seed 9 --adaptive");
        let read = Named::read("  sppm  --photons 4k --gather-k 20 ", &all).unwrap();
        assert_eq!(read.label, "sppm --photons 4k --gather-k 20");
        let MethodArguments { integrator, photons, gather_k, radius, filter, seed, adaptive, .. } = read.method;
        assert_eq!((integrator, photons, gather_k, radius), (Algorithm::Sppm, Some(4000), Some(20), Some(0.5)));
        assert_eq!((filter, seed, adaptive), (FilterKind::Tent, 9, true));
        let variant = read.variant(EffectOverrides::PLANNED);
        assert_eq!((variant.settings.caustic_photons, variant.settings.eye.seed), (2000, 9));
        let expected = "--integrator sppm --photons 4000 --gather-k 20 --radius 0.5 --filter tent --adaptive";
        assert_eq!(variant.flags.join(" "), expected);
        assert_eq!(
            Named::plain(Algorithm::Ppm, &all).variant(EffectOverrides::PLANNED).flags[..2],
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
            let Err(bad) = Named::read(text, &shared("")) else { panic!("`{text}` was read") };
            let message = bad.to_string();
            assert!(message.contains(&format!("--variant \"{text}\": ")) && message.contains(reason), "{message}");
            assert!(bad.remedy.contains(remedy) && !message.contains("Usage"), "{message} {}", bad.remedy);
        }
    }
}
