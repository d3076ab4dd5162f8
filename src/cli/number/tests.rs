use super::*;

#[test]
fn counts_take_suffixes() {
    assert_eq!(count("250000"), Ok(250_000));
    assert_eq!(count("250k"), Ok(250_000));
    assert_eq!(count("2.5M"), Ok(2_500_000));
    assert_eq!(count("0"), Ok(0));
    for bad in ["", "k", "-1", "1.5", "0.0001k", "1e3", "5000M", "inf", "NaN", "é"] {
        assert!(count(bad).is_err(), "{bad}");
    }
    assert!(positive_count("0").is_err());
    assert_eq!(["0", "2", "4000M"].map(gather_count), [0, 2, 4_000_000_000].map(Ok));
    assert!(gather_count("1").unwrap_err().contains("at least 2, or 0"));
}

#[test]
fn memory_takes_suffixes() {
    assert_eq!(["4G", "512M", "1.5k", "1T", "77"].map(bytes), [4e9, 512e6, 1500.0, 1e12, 77.0].map(|x| Ok(x as u64)));
    for bad in ["", "G", "0", "0G", "-1G", "4GB", "4g", "1e9", "NaN", "inf", "9999T", "much", "é"] {
        assert!(bytes(bad).is_err(), "{bad}");
    }
}

#[test]
fn times_sizes_and_exposures_have_ranges() {
    assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
    assert_eq!(duration("60s"), duration("60"));
    assert!(duration("-1s").is_err() && duration("soon").is_err() && duration("").is_err());
    assert_eq!(size("1280x720"), Ok((1280, 720)));
    assert!(size("0x5").is_err() && size("1280").is_err() && size("70000x2").is_err());
    for bad in ["NaN", "inf", "-inf", "64.1", "-65", "bright", ""] {
        assert!(stops(bad).is_err(), "{bad}");
    }
    assert_eq!((stops("+1.5"), stops("-64")), (Ok(1.5), Ok(-64.0)));
    assert!(threads("0").is_err() && threads("1025").is_err() && threads("1k") == Ok(1000));
    assert!(["0", "1.01", "NaN"].iter().all(|text| alpha(text).is_err()) && alpha("1") == Ok(1.0));
    assert!(length("0").is_err() && length("NaN").is_err() && length("0.5").is_ok());
}

#[test]
fn errors_and_confidences_are_fractions() {
    assert!(
        error("2%") == Ok(0.02)
            && error("150%") == Ok(1.5)
            && error("0").is_err()
            && error("-1%").is_err()
            && error("inf").is_err()
    );
    assert_eq!(confidence("90%").map(Confidence::probability), Ok(0.9));
    assert!(["49%", "100%", "NaN", "sure"].iter().all(|text| confidence(text).is_err()));
}

#[test]
fn an_error_of_two_asks_for_two_percent() {
    assert!(error("2").unwrap_err().contains("do you mean 2 %? Write 2%, or 200%"));
    assert!(error("0.5") == Ok(0.5) && error("1").is_err());
}

#[test]
fn seeds_are_whole_numbers_of_64_bits() {
    assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
    for bad in ["18446744073709551616", "-1", "1.5", "many", ""] {
        assert!(seed(bad).unwrap_err().contains("from 0 to 18446744073709551615"), "{bad}");
    }
}

#[test]
fn fractions_and_bounds_have_ranges() {
    assert_eq!([fraction("2%"), fraction("0.02"), fraction("2 %")], [Ok(0.02), Ok(0.02), Ok(0.02)]);
    assert_eq!([fraction("0"), fraction("150%"), fraction("1e-3%")], [Ok(0.0), Ok(1.5), Ok(1e-5)]);
    for bad in ["", "%", "2%%", "-1%", "-0.1", "nan", "inf%", "two", "2% of it"] {
        assert!(fraction(bad).is_err(), "{bad}");
    }
    assert!(bound("0") == Ok(0.0) && bound("1e-3") == Ok(1e-3) && bound("-1").is_err() && bound("NaN").is_err());
    assert!(pixels_per_degree("67.02") == Ok(67.02) && pixels_per_degree("0.9").is_err());
}

#[test]
fn points_lengths_and_angles_have_ranges() {
    assert_eq!(point("1,-2.5, 3e2"), Ok(DVec3::new(1.0, -2.5, 300.0)));
    assert!(["1,2", "1,2,3,4", "1,2,x", "1,2,inf", ""].iter().all(|text| point(text).is_err()));
    assert!(distance("0") == Ok(0.0) && distance("-1").is_err() && distance("nan").is_err());
    assert!(above_zero("0").is_err() && above_zero("1e-3") == Ok(1e-3));
    assert!(degrees("180") == Ok(180.0) && degrees("181").is_err());
}
