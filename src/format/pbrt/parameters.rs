//! Reads the arguments of pbrt directives: names, numbers, and parameters `"type name" [values]`.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::tokens::{PbrtToken, TokenKind, Tokenizer};
use glam::DVec3;

/// Estimated memory of each parameter \[bytes].
const MEMORY_PER_PARAMETER: u64 = 200;

/// Help text of errors about a parameter whose values are missing or malformed.
const VALUE_HELP: &str = "write the values as `\"float radius\" [ 1 ]`";

/// A parameter of a pbrt directive, such as `"float radius" [ 1 ]`.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// Type as the file writes it, such as `rgb`.
    pub kind: String,
    /// Name of the parameter.
    pub name: String,
    /// Numbers among the values, in order.
    pub numbers: Vec<f64>,
    /// Texts among the values, in order, including `true` and `false`.
    pub texts: Vec<String>,
}

/// All parameters of a pbrt directive, with the position of the directive.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// Position of the directive.
    pub place: PbrtSourceLocation,
    list: Vec<Parameter>,
}

impl Parameters {
    /// Returns number parameters from pairs of a name and values.
    #[cfg(test)]
    pub fn of_numbers(place: PbrtSourceLocation, numbers: &[(&str, &[f64])]) -> Self {
        let parameter = |(name, numbers): &(&str, &[f64])| Parameter {
            kind: "float".to_owned(),
            name: (*name).to_owned(),
            numbers: numbers.to_vec(),
            texts: Vec::new(),
        };
        Self { place, list: numbers.iter().map(parameter).collect() }
    }

    /// Reads all parameters of the directive at `place`. Stops before the next directive.
    pub fn read(tokens: &mut Tokenizer<'_>, place: PbrtSourceLocation, files: &PbrtSceneFiles<'_>) -> ReadResult<Self> {
        let mut list = Vec::new();
        while let Some(token) = tokens.peek_token()? {
            let TokenKind::Quoted(declaration) = &token.kind else { break };
            let place = PbrtSourceLocation { file: place.file.clone(), line: token.line };
            let mut words = declaration.split_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let message = format!("`{declaration}` is not a type and a name");
                return Err(place.error(message, VALUE_HELP));
            };
            let mut parameter =
                Parameter { kind: kind.to_owned(), name: name.to_owned(), numbers: Vec::new(), texts: Vec::new() };
            tokens.next_token()?;
            parameter.read_values(tokens, &place)?;
            let texts: usize = parameter.texts.iter().map(|text| text.len() + 24).sum();
            files.reserve_memory(MEMORY_PER_PARAMETER + 8 * parameter.numbers.len() as u64 + texts as u64)?;
            list.push(parameter);
        }
        Ok(Self { place, list })
    }

    /// Returns the parameter `name`; `None` if the directive has none.
    pub fn find(&self, name: &str) -> Option<&Parameter> {
        self.list.iter().find(|parameter| parameter.name == name)
    }

    /// Returns the first of the parameters `names` that the directive has; `None` if it has none.
    pub fn find_any(&self, names: &[&str]) -> Option<&Parameter> {
        names.iter().find_map(|name| self.find(name))
    }

    /// Returns the numbers of the parameter `name`; empty if the directive has no such parameter.
    pub fn numbers(&self, name: &str) -> &[f64] {
        self.find(name).map_or(&[], |parameter| &parameter.numbers)
    }

    /// Returns the first number of the parameter `name`; `None` if there is no number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// Returns the first number of the parameter `name`, or `default` if there is no number.
    pub fn number_or(&self, name: &str, default: f64) -> f64 {
        self.number(name).unwrap_or(default)
    }

    /// Returns the first text of the parameter `name`; `None` if there is no text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.find(name)?.texts.first().map(String::as_str)
    }

    /// Returns the truth value of the parameter `name`; `None` if the parameter has no text.
    ///
    /// The text `true` is true, and any other text is false.
    pub fn flag(&self, name: &str) -> Option<bool> {
        self.text(name).map(|text| text == "true")
    }

    /// Returns the first point or vector of the parameter `name`; `None` for fewer than three
    /// numbers.
    pub fn point(&self, name: &str) -> Option<DVec3> {
        match self.numbers(name) {
            [x, y, z, ..] => Some(DVec3::new(*x, *y, *z)),
            _ => None,
        }
    }

    /// Returns the points of the parameter `name`, three numbers each; empty if there are none.
    pub fn points(&self, name: &str) -> ReadResult<Vec<DVec3>> {
        let numbers = self.numbers(name);
        if !numbers.len().is_multiple_of(3) {
            let message = format!("`{name}` has {} numbers, which is not a multiple of 3", numbers.len());
            return Err(self.place.error(message, "give three numbers for each point"));
        }
        Ok(numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect())
    }
}

impl Parameter {
    /// Reads the values after a parameter's type and name: a single value, or values in brackets.
    fn read_values(&mut self, tokens: &mut Tokenizer<'_>, place: &PbrtSourceLocation) -> ReadResult<()> {
        let missing = |name: &str| place.error(format!("the parameter `{name}` has no values"), VALUE_HELP);
        let first = tokens.next_token()?.ok_or_else(|| missing(&self.name))?;
        if first.kind != TokenKind::OpenBracket {
            return self.push_value(&first.kind, place);
        }
        loop {
            let token =
                tokens.next_token()?.ok_or_else(|| place.error("a bracket is not closed", "close it with `]`"))?;
            match &token.kind {
                TokenKind::CloseBracket => return Ok(()),
                kind @ (TokenKind::OpenBracket | TokenKind::Unquoted(_) | TokenKind::Quoted(_)) => {
                    self.push_value(kind, place)?
                }
            }
        }
    }

    fn push_value(&mut self, kind: &TokenKind<'_>, place: &PbrtSourceLocation) -> ReadResult<()> {
        match kind {
            TokenKind::Quoted(text) => self.texts.push(text.clone().into_owned()),
            TokenKind::Unquoted(word @ ("true" | "false")) => self.texts.push((*word).to_owned()),
            TokenKind::Unquoted(word) => self.numbers.push(parse_number(word, place)?),
            TokenKind::OpenBracket | TokenKind::CloseBracket => {
                return Err(place.error(format!("a bracket is misplaced in `{}`", self.name), VALUE_HELP));
            }
        }
        Ok(())
    }
}

/// Parses a number. Fails if it is not finite, or if its magnitude exceeds 10³⁰.
pub(super) fn parse_number(word: &str, place: &PbrtSourceLocation) -> ReadResult<f64> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() && number.abs() <= 1e30 => Ok(number),
        Ok(_) => Err(place.error(format!("the number {word} is too large"), "use numbers up to 1e30")),
        Err(_) => Err(place.error(format!("`{word}` is not a number"), VALUE_HELP)),
    }
}

/// Reads a text in quotes, and returns it without the quotes. Fails if the next token is anything
/// else.
pub(super) fn read_quoted(tokens: &mut Tokenizer<'_>, place: &PbrtSourceLocation) -> ReadResult<String> {
    match tokens.next_token()? {
        Some(PbrtToken { kind: TokenKind::Quoted(text), .. }) => Ok(text.into_owned()),
        _ => {
            Err(place.error("a name in quotes is missing", "write the name after the directive, as `Shape \"sphere\"`"))
        }
    }
}

/// Reads exactly `count` numbers, with or without brackets around them.
pub(super) fn read_numbers(
    tokens: &mut Tokenizer<'_>,
    count: usize,
    place: &PbrtSourceLocation,
) -> ReadResult<Vec<f64>> {
    let mut numbers = Vec::with_capacity(count);
    let missing = || place.error(format!("the directive needs {count} numbers"), "add the missing numbers");
    let mut is_open = false;
    while numbers.len() < count {
        match tokens.next_token()?.ok_or_else(missing)?.kind {
            TokenKind::OpenBracket if numbers.is_empty() && !is_open => is_open = true,
            TokenKind::Unquoted(word) => numbers.push(parse_number(word, place)?),
            TokenKind::OpenBracket | TokenKind::CloseBracket | TokenKind::Quoted(_) => return Err(missing()),
        }
    }
    if is_open && !matches!(tokens.next_token()?, Some(PbrtToken { kind: TokenKind::CloseBracket, .. })) {
        return Err(place.error("a bracket is not closed", "close it with `]`"));
    }
    Ok(numbers)
}
