//! Variants of methods, as named by `--variant`.

use crate::cli::args::MethodArguments;
use crate::cli::settings::{flags, settings};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use crate::study::methods::MethodVariant;
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
struct VariantFlags {
    #[command(flatten)]
    method: MethodArguments,
}

/// A variant: its label and its arguments.
pub(super) struct NamedVariant {
    pub label: String,
    pub method: MethodArguments,
}

impl NamedVariant {
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
        let read = VariantFlags::try_parse_from(line).map_err(|error| {
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
    pub fn variant(self, overrides: EffectOverrides) -> MethodVariant {
        MethodVariant {
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
    VariantFlags::try_parse_from([""; 0]).unwrap().method
}

#[cfg(test)]
mod tests;
