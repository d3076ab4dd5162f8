//! Method variants of a study: an algorithm with its own flags, such as `sppm --gather-k 20`.

use crate::cli::args::MethodArguments;
use crate::cli::settings::{method_flags, settings_from_arguments};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use crate::study::methods::MethodVariant;
use clap::{Parser, ValueEnum};

/// Flags that must be equal for all variants of the study, so that the text of a variant may not
/// contain them.
const STUDY_WIDE_FLAGS: [&str; 3] = ["--integrator", "--filter", "--seed"];

/// Error: the value of `--variant` cannot be parsed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--variant \"{text}\": {reason}")]
#[diagnostic(help("{remedy}"))]
pub(super) struct VariantParseError {
    text: String,
    reason: String,
    remedy: String,
}

/// Command-line flags of one variant of a method.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, args_override_self = true, disable_help_flag = true)]
struct VariantFlags {
    #[command(flatten)]
    method: MethodArguments,
}

/// A method of a study: a label, and the arguments that select its algorithm and settings.
pub(super) struct VariantArguments {
    pub label: String,
    pub method: MethodArguments,
}

impl VariantArguments {
    /// Makes a variant of `algorithm` with the `shared` flags of the study and no flags of its own.
    pub fn from_algorithm(algorithm: Algorithm, shared: &MethodArguments) -> Self {
        let method = MethodArguments { integrator: algorithm, ..shared.clone() };
        Self { label: algorithm.name().to_owned(), method }
    }

    /// Parses a method with its own flags, such as `sppm --gather-k 20`. These flags override the
    /// `shared` flags.
    ///
    /// # Errors
    /// [`VariantParseError`] if there is no such method, or if a flag is unknown or in
    /// [`STUDY_WIDE_FLAGS`].
    pub fn parse(text: &str, shared: &MethodArguments) -> Result<Self, VariantParseError> {
        let bad = |reason: String, remedy: String| VariantParseError { text: text.to_owned(), reason, remedy };
        let words: Vec<&str> = text.split_whitespace().collect();
        let names = Algorithm::ALL.map(Algorithm::name).join(", ");
        let remedy = || format!("begin with one of {names}, as in --variant \"sppm --gather-k 20\"");
        let (first, rest) = words.split_first().ok_or_else(|| bad("it names no method".to_owned(), remedy()))?;
        let known = Algorithm::from_str(first, false);
        let algorithm = known.map_err(|_| bad(format!("there is no method `{first}`"), remedy()))?;
        let given = |flag: &&&str| rest.iter().any(|word| word.split('=').next() == Some(**flag));
        if let Some(flag) = STUDY_WIDE_FLAGS.iter().find(given) {
            let remedy = match *flag {
                "--integrator" => "the first word names the method".to_owned(),
                _ => format!("give {flag} to the study itself"),
            };
            return Err(bad(format!("{flag} is the same for all methods"), remedy));
        }
        let mut line = method_flags(
            &MethodArguments { integrator: algorithm, ..shared.clone() },
            "",
            EffectOverrides::NO_OVERRIDES,
        );
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

    /// Converts the arguments to a [`MethodVariant`]. `overrides` forces effects on or off.
    pub fn into_method_variant(self, overrides: EffectOverrides) -> MethodVariant {
        MethodVariant {
            label: self.label,
            algorithm: self.method.integrator,
            settings: settings_from_arguments(&self.method, overrides),
            flags: method_flags(&self.method, "--effects", overrides),
        }
    }
}

/// Returns the method arguments with default values.
#[cfg(test)]
pub(super) fn default_method_arguments() -> MethodArguments {
    VariantFlags::try_parse_from([""; 0]).unwrap().method
}

#[cfg(test)]
mod tests;
