//! Tests of the albedos of coats against quadrature.

use super::*;

/// Cosine-weighted mean of `albedo(cosθ)` over the hemisphere, by the midpoint rule in √cosθ, which
/// resolves the horizon.
fn mean_by_quadrature(albedo: impl Fn(f64) -> f64) -> f64 {
    let steps = 20_000;
    let t = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
    t.map(|t| 4.0 * t * t * t * albedo(t * t)).sum::<f64>() / f64::from(steps)
}

#[test]
fn mean_fresnel_reflectance_matches_quadrature() {
    for eta in [1.0001, 1.01, 1.33, 1.5, 2.4, 4.0] {
        let (closed, sum) =
            (mean_fresnel_reflectance(eta), mean_by_quadrature(|cos| fresnel_reflectance_and_cosine(cos, eta).0));
        assert!((closed - sum).abs() < 1e-6, "{eta}: {closed} {sum}");
    }
}

#[test]
fn mean_albedos_match_their_directional_albedos() {
    for (eta, alpha) in [(1.5, 0.07), (1.5, 1.0), (1.1, 0.3), (3.7, 0.5)] {
        let sum = mean_by_quadrature(|cos| f64::from(coat_albedo(cos as f32, eta, alpha)));
        assert!((f64::from(mean_coat_albedo(eta, alpha)) - sum).abs() < 1e-5, "{eta} {alpha}: {sum}");
    }
}

/// Between nodes, the interpolated table matches an integral with about a hundred times as many
/// points.
#[test]
fn tabulated_albedos_match_fine_quadrature() {
    for (eta, alpha, cos) in [(1.5, 0.1, 0.9), (1.33, 0.02, 0.05), (1.5, 0.37, 0.3), (2.2, 0.8, 0.02), (3.9, 0.2, 0.5)]
    {
        let (ggx, wo) = (Ggx::new(alpha), DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos));
        let (mut sum, steps) = (0.0, 240);
        for i in 0..steps * steps {
            let u = (Vec2::new((i % steps) as f32, (i / steps) as f32) + 0.5) / steps as f32;
            let m = ggx.sample_visible_normal(wo, Vec3::Z, u);
            let wi = m * (2.0 * wo.dot(m)) - wo;
            if wi.z > 0.0 {
                let g = ggx.reflection_g2_over_cosines(cos, wi.z) * ggx.unshadowed_microfacet_fraction(1.0, cos, wi.z);
                sum += fresnel_reflectance_and_cosine(wo.dot(m).min(1.0), f64::from(eta)).0 * g;
            }
        }
        let (exact, table) = (sum / f64::from(steps * steps), coat_albedo(cos as f32, eta, alpha));
        assert!((exact - f64::from(table)).abs() < 2e-3, "{eta} {alpha} {cos}: {exact} {table}");
    }
}
