//! Checks the lines of an MTL file and rewrites them for the parser `tobj`.

use super::super::line_error::{MessageAndRemedy, escaped_excerpt};
use std::fmt::Write;

const REPAIR_REMEDY: &str = "repair it or export the materials anew";

/// Returns the lines of an MTL file that Caustica uses, rewritten for `tobj`.
///
/// An error holds the number of the first invalid line, from 1, with a message and a remedy.
pub(super) fn check_and_rewrite_mtl(text: &str) -> Result<String, (usize, MessageAndRemedy)> {
    let mut valid_lines = String::new();
    let mut named = false;
    for (i, line) in text.lines().enumerate() {
        append_valid_mtl_line(line.trim(), &mut named, &mut valid_lines).map_err(|problem| (i + 1, problem))?;
    }
    Ok(valid_lines)
}

fn append_valid_mtl_line(line: &str, named: &mut bool, valid_lines: &mut String) -> Result<(), MessageAndRemedy> {
    let (keyword, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
    let rest = rest.trim();
    // Writing to a string cannot fail.
    match keyword {
        "newmtl" => {
            if rest.is_empty() {
                return Err(("`newmtl` gives no name".to_owned(), "write a name after it"));
            }
            *named = true;
            let _ = writeln!(valid_lines, "newmtl {rest}");
            return Ok(());
        }
        "Kd" | "Ks" | "Ke" | "Tf" | "Ns" | "Ni" | "d" | "Tr" | "illum" | "map_Kd" if !*named => {
            return Err((format!("`{keyword}` stands before any `newmtl`"), "put `newmtl` and a name before it"));
        }
        "Kd" | "Ks" | "Ke" | "Tf" => {
            let [r, g, b] = parse_color_or_grey(keyword, rest)?;
            let _ = writeln!(valid_lines, "{keyword} {r} {g} {b}");
        }
        // Some exporters write a negative exponent if there is no highlight.
        "Ns" => {
            let _ = writeln!(valid_lines, "Ns {}", parse_single_precision(keyword, rest)?.max(0.0));
        }
        "Ni" => {
            let _ = writeln!(valid_lines, "Ni {}", parse_finite_number(keyword, rest)?);
        }
        "d" | "Tr" => {
            let written = parse_finite_number(keyword, rest.strip_prefix("-halo").unwrap_or(rest))?;
            if !(0.0..=1.0).contains(&written) {
                return Err((format!("`{keyword}` is {written}"), "it must lie between 0 and 1"));
            }
            let _ = writeln!(valid_lines, "d {}", if keyword == "d" { written } else { 1.0 - written });
        }
        "illum" => {
            let model = rest.split_ascii_whitespace().next().unwrap_or_default();
            if !model.parse::<u8>().is_ok_and(|model| model <= 10) {
                return Err((
                    format!("`{}` is no illumination model", escaped_excerpt(model)),
                    "it must be one of 0 to 10",
                ));
            }
            let _ = writeln!(valid_lines, "illum {model}");
        }
        "map_Kd" => {
            let path = picture_path_after_options(rest);
            if path.is_empty() {
                return Err(("`map_Kd` names no picture".to_owned(), "write its path after it"));
            }
            let _ = writeln!(valid_lines, "map_Kd {path}");
        }
        _ => {}
    }
    Ok(())
}

fn parse_finite_number(keyword: &str, rest: &str) -> Result<f64, MessageAndRemedy> {
    let word = rest.split_ascii_whitespace().next().unwrap_or_default();
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err((format!("`{}` of `{keyword}` is not a finite number", escaped_excerpt(word)), REPAIR_REMEDY)),
    }
}

/// Parses a finite number whose magnitude is at most `f32::MAX`.
fn parse_single_precision(keyword: &str, rest: &str) -> Result<f64, MessageAndRemedy> {
    match parse_finite_number(keyword, rest)? {
        number if number.abs() <= f64::from(f32::MAX) => Ok(number),
        number => Err((format!("`{keyword}` holds {number:e}"), "single precision holds numbers below 3.4e38")),
    }
}

/// Parses an RGB colour of three numbers, or a grey of one number; none may be negative.
fn parse_color_or_grey(keyword: &str, rest: &str) -> Result<[f64; 3], MessageAndRemedy> {
    let words: Vec<&str> = rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#')).collect();
    let numbers = match words[..] {
        [one] => [parse_single_precision(keyword, one)?; 3],
        [r, g, b, ..] if r != "xyz" && r != "spectral" => [
            parse_single_precision(keyword, r)?,
            parse_single_precision(keyword, g)?,
            parse_single_precision(keyword, b)?,
        ],
        _ => return Err((format!("`{keyword}` holds no RGB colour"), "write it as red, green and blue")),
    };
    match numbers.iter().find(|number| **number < 0.0) {
        Some(negative) => Err((format!("`{keyword}` holds {negative}"), "colours must not be negative")),
        None => Ok(numbers),
    }
}

/// Returns the picture path of an MTL texture line. `rest` holds the options and then the path.
fn picture_path_after_options(mut rest: &str) -> &str {
    let next = |text: &str| text.split_ascii_whitespace().next().unwrap_or_default().to_owned();
    let after = |text: &'_ str, word: &str| text[word.len()..].trim_start().len();
    loop {
        let option = next(rest);
        let most = match option.as_str() {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost" | "-imfchan" | "-type" => 1,
            _ => return rest,
        };
        rest = &rest[rest.len() - after(rest, &option)..];
        for k in 0..most {
            let value = next(rest);
            // The first argument is required. Options such as `-o` and `-s` may have fewer than
            // three numbers.
            if k > 0 && value.parse::<f64>().is_err() {
                break;
            }
            rest = &rest[rest.len() - after(rest, &value)..];
        }
    }
}
