use super::*;

#[test]
fn counts_take_suffixes() {
    assert_eq!(parse_count("250000"), Ok(250_000));
    assert_eq!(parse_count("250k"), Ok(250_000));
    assert_eq!(parse_count("2.5M"), Ok(2_500_000));
    assert_eq!(parse_count("0"), Ok(0));
    // In f64, the products 4.1 · 10⁶ and 2.01 · 10³ are rounded to numbers that are not whole. The
    // parser accepts them nevertheless.
    assert_eq!((parse_count("4.1M"), parse_count("2.01k")), (Ok(4_100_000), Ok(2_010)));
    for bad in ["", "k", "-1", "1.5", "0.0001k", "1e3", "5000M", "inf", "NaN", "é"] {
        assert!(parse_count(bad).is_err(), "{bad}");
    }
    assert!(parse_positive_count("0").is_err());
    assert_eq!(["0", "2", "4000M"].map(parse_gather_count), [0, 2, 4_000_000_000].map(Ok));
    assert!(parse_gather_count("1").unwrap_err().contains("at least 2, or 0"));
}

#[test]
fn memory_sizes_take_suffixes() {
    assert_eq!(
        ["4G", "512M", "1.5k", "1T", "77"].map(parse_bytes),
        [4e9, 512e6, 1500.0, 1e12, 77.0].map(|x| Ok(x as u64))
    );
    for bad in ["", "G", "0", "0G", "-1G", "4GB", "4g", "1e9", "NaN", "inf", "9999T", "much", "é"] {
        assert!(parse_bytes(bad).is_err(), "{bad}");
    }
}

#[test]
fn times_sizes_and_exposures_have_ranges() {
    assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
    assert_eq!(parse_duration("60s"), parse_duration("60"));
    assert!(parse_duration("-1s").is_err() && parse_duration("soon").is_err() && parse_duration("").is_err());
    assert_eq!(parse_picture_size("1280x720"), Ok((1280, 720)));
    assert!(
        parse_picture_size("0x5").is_err()
            && parse_picture_size("1280").is_err()
            && parse_picture_size("70000x2").is_err()
    );
    for bad in ["NaN", "inf", "-inf", "64.1", "-65", "bright", ""] {
        assert!(parse_exposure_stops(bad).is_err(), "{bad}");
    }
    assert_eq!((parse_exposure_stops("+1.5"), parse_exposure_stops("-64")), (Ok(1.5), Ok(-64.0)));
    assert!(parse_threads("0").is_err() && parse_threads("1025").is_err() && parse_threads("1k") == Ok(1000));
    assert!(["0", "1.01", "NaN"].iter().all(|text| parse_alpha(text).is_err()) && parse_alpha("1") == Ok(1.0));
    assert!(
        parse_positive_length("0").is_err()
            && parse_positive_length("NaN").is_err()
            && parse_positive_length("0.5").is_ok()
    );
}

#[test]
fn errors_and_confidences_are_fractions() {
    assert!(
        parse_relative_error("2%") == Ok(0.02)
            && parse_relative_error("150%") == Ok(1.5)
            && parse_relative_error("0").is_err()
            && parse_relative_error("-1%").is_err()
            && parse_relative_error("inf").is_err()
    );
    assert_eq!(parse_confidence("90%").map(Confidence::probability), Ok(0.9));
    assert!(["49%", "100%", "NaN", "sure"].iter().all(|text| parse_confidence(text).is_err()));
}

#[test]
fn a_relative_error_of_two_is_refused_as_ambiguous() {
    assert!(parse_relative_error("2").unwrap_err().contains("do you mean 2 %? Write 2%, or 200%"));
    assert!(parse_relative_error("0.5") == Ok(0.5) && parse_relative_error("1").is_err());
}

#[test]
fn seeds_are_unsigned_integers() {
    assert_eq!(parse_seed("18446744073709551615"), Ok(u64::MAX));
    for bad in ["18446744073709551616", "-1", "1.5", "many", ""] {
        assert!(parse_seed(bad).unwrap_err().contains("from 0 to 18446744073709551615"), "{bad}");
    }
}

#[test]
fn fractions_and_bounds_have_ranges() {
    assert_eq!([parse_fraction("2%"), parse_fraction("0.02"), parse_fraction("2 %")], [Ok(0.02), Ok(0.02), Ok(0.02)]);
    assert_eq!([parse_fraction("0"), parse_fraction("150%"), parse_fraction("1e-3%")], [Ok(0.0), Ok(1.5), Ok(1e-5)]);
    for bad in ["", "%", "2%%", "-1%", "-0.1", "nan", "inf%", "two", "2% of it"] {
        assert!(parse_fraction(bad).is_err(), "{bad}");
    }
    assert!(
        parse_upper_bound("0") == Ok(0.0)
            && parse_upper_bound("1e-3") == Ok(1e-3)
            && parse_upper_bound("-1").is_err()
            && parse_upper_bound("NaN").is_err()
    );
    assert!(parse_pixels_per_degree("67.02") == Ok(67.02) && parse_pixels_per_degree("0.9").is_err());
}

#[test]
fn points_lengths_and_angles_have_ranges() {
    assert_eq!(parse_point("1,-2.5, 3e2"), Ok(DVec3::new(1.0, -2.5, 300.0)));
    assert!(["1,2", "1,2,3,4", "1,2,x", "1,2,inf", ""].iter().all(|text| parse_point(text).is_err()));
    assert!(
        parse_nonnegative_length("0") == Ok(0.0)
            && parse_nonnegative_length("-1").is_err()
            && parse_nonnegative_length("nan").is_err()
    );
    assert!(parse_positive_factor("0").is_err() && parse_positive_factor("1e-3") == Ok(1e-3));
    assert!(parse_degrees("180") == Ok(180.0) && parse_degrees("181").is_err());
}
