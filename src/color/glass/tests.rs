//! Tests of refractive indices.

use super::*;

/// Compares the refractive indices of BK7 with the manufacturer's catalogue, to its last digit.
#[test]
fn borosilicate_crown_matches_the_catalogue() {
    let bk7 = glass_by_name("BK7").unwrap();
    for (nm, n) in [(486.13, 1.522376), (587.56, 1.516800), (656.27, 1.514322)] {
        assert!((f64::from(bk7.refractive_index(nm)) - n).abs() < 6e-7, "{nm}: {}", bk7.refractive_index(nm));
    }
    assert_eq!(bk7.refractive_index_at_d_line(), bk7.refractive_index(587.56));
    assert!((bk7.abbe_number() - 64.167).abs() < 5e-3, "{}", bk7.abbe_number());
}

/// Compares refractive indices at the d line and Abbe numbers with catalogues and tables, to their
/// last digit.
#[test]
fn glasses_match_published_refractive_indices() {
    let known = [
        ("BK7", 1.51680, 5e-6, 64.17, 0.01),
        ("F2", 1.62004, 5e-6, 36.37, 0.01),
        ("LAK9", 1.69100, 5e-6, 54.71, 0.01),
        ("SF10", 1.72828, 5e-6, 28.53, 0.01),
        ("SF11", 1.78472, 5e-6, 25.68, 0.01),
        ("diamond", 2.4175, 5e-4, 55.3, 0.5),
        ("fusedSilica", 1.45846, 5e-6, 67.8, 0.05),
        ("sapphire", 1.7682, 5e-5, 72.2, 0.2),
        ("water", 1.3334, 5e-5, 55.7, 0.2),
    ];
    assert_eq!(known.map(|k| k.0), GLASSES.map(|g| g.0));
    for (name, nd, tolerance, vd, slack) in known {
        let glass = glass_by_name(name).unwrap();
        assert!(
            (glass.refractive_index_at_d_line() - nd).abs() < tolerance,
            "{name}: {}",
            glass.refractive_index_at_d_line()
        );
        assert!((glass.abbe_number() - vd).abs() < slack, "{name}: {}", glass.abbe_number());
    }
    assert_eq!(glass_by_name("bk7"), None);
}

#[test]
fn index_range_bounds_all_refractive_indices() {
    let made =
        [DispersionFormula::from_abbe_number(1.5, 20.0), DispersionFormula::Cauchy { a: 1.5, b: -0.01, c: 0.001 }];
    for glass in GLASSES.iter().map(|g| g.1).chain(made) {
        let [least, most] = glass.refractive_index_range().unwrap();
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for step in 0..=3400 {
            let n = glass.refractive_index_f64(380.0 + f64::from(step) * 0.1);
            assert!((least - 1e-15..=most + 1e-15).contains(&n) && n > 1.0, "{glass:?} {n}");
            (low, high) = (low.min(n), high.max(n));
        }
        // Bounds are computed per interval of one nanometer and per term. Each term changes by less
        // than 0.001 in an interval. Terms with opposite changes make the bounds wider by up to
        // 0.002.
        assert!(low - least < 2e-3 && most - high < 2e-3, "{glass:?}");
    }
}

#[test]
fn resonances_and_invalid_refractive_indices_have_no_range() {
    let resonance = |c: f64| three_term_sellmeier([0.01, 1.2, 0.0], [c, 0.01, 0.0]);
    // The resonance at 600.0005 nm is so narrow that samples at whole nanometers miss it.
    assert_eq!(resonance(squared_micrometres(600.0005)).refractive_index_range(), None);
    assert!(resonance(squared_micrometres(900.0)).refractive_index_range().is_some());
    assert_eq!(three_term_sellmeier([-3.0, 0.0, 0.0], [0.01, 0.0, 0.0]).refractive_index_range(), None);
    assert_eq!(DispersionFormula::Cauchy { a: 1.0, b: -0.2, c: 0.0 }.refractive_index_range(), None);
    assert_eq!(DispersionFormula::Cauchy { a: f64::NAN, b: 0.0, c: 0.0 }.refractive_index_range(), None);
    assert_eq!(DispersionFormula::Cauchy { a: f64::MAX, b: f64::MAX, c: 0.0 }.refractive_index_range(), None);
}

#[test]
fn abbe_number_round_trips() {
    for (nd, vd) in [(1.5, 64.2), (1.9, 12.0), (1.333, 55.7), (0.7, 30.0)] {
        let glass = DispersionFormula::from_abbe_number(nd, vd);
        // The tolerance is the rounding of the result to f32.
        assert!(
            (f64::from(glass.refractive_index_at_d_line()) - nd).abs() < 1e-7 * nd
                && (glass.abbe_number() / vd as f32 - 1.0).abs() < 1e-6
        );
    }
}
