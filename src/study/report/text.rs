//! Formats numbers for reports and messages.

/// Returns the text of a count with SI prefix, such as `250`, `1.9 k`, `12 M` or `-3.4 G`.
#[must_use]
pub fn count_text(n: f64) -> String {
    // A value that would be rounded to 1000 of a unit uses the next larger unit.
    let (scale, unit) = match n.abs() {
        999.5e6.. => (1e9, " G"),
        999.5e3.. => (1e6, " M"),
        999.5.. => (1e3, " k"),
        _ => (1.0, ""),
    };
    let scaled = n / scale;
    // Adding zero turns −0 into 0.
    if scale > 1.0 && scaled.abs() < 9.95 {
        format!("{scaled:.1}{unit}")
    } else {
        format!("{:.0}{unit}", scaled.round() + 0.0)
    }
}

/// Numbers whose absolute value is below this limit are rounded to 0.0 when they are written with
/// one decimal place.
const HALF_STEP: f64 = 0.05;

/// Returns the text of a count with its sign, such as `+1.9 k`, `0` or `-12`.
#[must_use]
pub fn signed_count_text(n: f64) -> String {
    if n >= 0.5 { format!("+{}", count_text(n)) } else { count_text(n) }
}

/// Returns the text of a time difference in milliseconds with its sign, such as `+1.9`, `0.0` or
/// `-12.0`.
#[must_use]
pub fn signed_milliseconds_text(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    if ms.abs() < HALF_STEP { "0.0".to_owned() } else { format!("{ms:+.1}") }
}

/// Returns the text of a fraction in percent, such as `0 %`, `< 0.1 %`, `2.3 %` or `120 %`. The
/// argument `part` is 1 for 100 %.
#[must_use]
pub fn percent_text(part: f64) -> String {
    match 100.0 * part {
        0.0 => "0 %".to_owned(),
        p if p.abs() < HALF_STEP => "< 0.1 %".to_owned(),
        p if p.abs() < 9.95 => format!("{p:.1} %"),
        p => format!("{p:.0} %"),
    }
}

/// Returns the text of a relative error in percent with three significant digits, such as `12.3 %`
/// or `0.0450 %`. The argument `part` is 1 for 100 %.
#[must_use]
pub fn error_percent_text(part: f64) -> String {
    format!("{} %", three_digit_text(100.0 * part))
}

/// Returns the square root of `square` in percent as text; `≈ 0` if `square` is not positive.
pub(super) fn square_root_percent_text(square: f64) -> String {
    if square > 0.0 { error_percent_text(square.sqrt()) } else { "≈ 0".to_owned() }
}

/// Returns the text of a slope with two decimals and a typographic minus, such as `−0.50` or
/// `0.00`.
#[must_use]
pub fn slope_text(slope: f64) -> String {
    // Adding zero turns −0 into 0.
    format!("{:.2}", (100.0 * slope).round() / 100.0 + 0.0).replace('-', "−")
}

/// Returns the text of a duration, such as `0.250 s`, `12.3 s`, `4 min 10 s`, `2 h 5 min` or `3
/// days`.
#[must_use]
pub fn duration_text(seconds: f64) -> String {
    // A value that would be rounded to 60 of a unit uses the next larger unit.
    match seconds {
        s if s.is_nan() || s < 59.95 => format!("{} s", three_digit_text(s)),
        s if s < 3599.5 => two_unit_duration_text(s.round(), "min", "s"),
        s if s < 172_770.0 => two_unit_duration_text((s / 60.0).round(), "h", "min"),
        s if s.is_finite() => format!("{:.0} days", s / 86_400.0),
        _ => "∞".to_owned(),
    }
}

/// Returns the text of a duration in two units, such as `4 min 10 s`.
///
/// `small` is the whole duration in `small_unit`. One `large_unit` is 60 times as long.
fn two_unit_duration_text(small: f64, large_unit: &str, small_unit: &str) -> String {
    let (large, rest) = ((small / 60.0).floor(), small % 60.0);
    if rest == 0.0 {
        format!("{large:.0} {large_unit}")
    } else {
        format!("{large:.0} {large_unit} {rest:.0} {small_unit}")
    }
}

/// Returns the text of a number with three significant digits, such as `0`, `0.0123`, `12.3` or
/// `1.23e-7`.
#[must_use]
pub fn three_digit_text(x: f64) -> String {
    let scientific = format!("{x:.2e}");
    // The rounded number selects the format: rounding may reach the next power of ten.
    let rounded = scientific.parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        1000.0.. | ..0.001 => scientific,
        ..0.01 => format!("{x:.5}"),
        ..0.1 => format!("{x:.4}"),
        ..1.0 => format!("{x:.3}"),
        ..10.0 => format!("{x:.2}"),
        ..100.0 => format!("{x:.1}"),
        _ => format!("{x:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_si_prefixes() {
        let cases = [
            (0.0, "0"),
            (-0.3, "0"),
            (999.0, "999"),
            (999.6, "1.0 k"),
            (1940.0, "1.9 k"),
            (9960.0, "10 k"),
            (-12.4e6, "-12 M"),
            (999_600_000.0, "1.0 G"),
        ];
        for (n, text) in cases {
            assert_eq!(count_text(n), text);
        }
        assert_eq!([1500.0, 0.0, -1500.0].map(signed_count_text), ["+1.5 k", "0", "-1.5 k"]);
    }

    #[test]
    fn durations_have_readable_units() {
        let times = [0.25, 12.34, 59.96, 250.0, 3599.9, 7500.0, 3e5, f64::INFINITY].map(duration_text);
        assert_eq!(times, ["0.250 s", "12.3 s", "1 min", "4 min 10 s", "1 h", "2 h 5 min", "3 days", "∞"]);
        assert_eq!([-0.333, -0.001, 0.5].map(slope_text), ["−0.33", "0.00", "0.50"]);
        assert_eq!([0.1234, 4.5e-4].map(error_percent_text), ["12.3 %", "0.0450 %"]);
    }

    #[test]
    fn percents_and_numbers_have_few_digits() {
        assert_eq!([0.0, 1e-5, -0.023, 1.2].map(percent_text), ["0 %", "< 0.1 %", "-2.3 %", "120 %"]);
        assert_eq!([1.23e-3, -4e-5, -0.5].map(signed_milliseconds_text), ["+1.2", "0.0", "-500.0"]);
        let numbers = [0.0, 1.234e-7, 0.00123, 0.0123, 0.123, 1.234, 12.34, 123.4, 12340.0].map(three_digit_text);
        assert_eq!(numbers, ["0", "1.23e-7", "0.00123", "0.0123", "0.123", "1.23", "12.3", "123", "1.23e4"]);
        let below_powers_of_ten = [9.996e-4, 0.9996, 9.996, -99.96, 999.6, f64::INFINITY].map(three_digit_text);
        assert_eq!(below_powers_of_ten, ["0.00100", "1.00", "10.0", "-100", "1.00e3", "inf"]);
    }
}
