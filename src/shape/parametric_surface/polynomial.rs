//! Polynomials on \[−1, 1] in the power basis.
//!
//! On a short piece of a curve or surface, coefficients decrease quickly with the power. The power
//! basis is then as stable as the Bernstein basis and faster to evaluate.

/// Largest degree of a curve or surface; stack memory grows with its square.
pub const MAX_DEGREE: usize = 24;

/// A polynomial coefficient that is a vector with `N` components.
pub type Coefficient<const N: usize> = [f64; N];

/// The sum a + s·b of two coefficients, component by component.
#[inline]
fn add_scaled<const N: usize>(a: Coefficient<N>, b: Coefficient<N>, s: f64) -> Coefficient<N> {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Control points of the two curves into which a Bézier curve is divided at the parameter `s`.
///
/// `s` is in \[0, 1]. The algorithm is de Casteljau's.
pub fn split_bezier<const N: usize>(controls: &[Coefficient<N>], s: f64) -> (Vec<Coefficient<N>>, Vec<Coefficient<N>>) {
    let mut points = controls.to_vec();
    let (mut first, mut last) = (Vec::new(), Vec::new());
    while let (Some(a), Some(b)) = (points.first(), points.last()) {
        first.push(*a);
        last.push(*b);
        // Each half starts from its nearer end, so a division at 0 or 1 moves nothing.
        points = points.windows(2).map(|w| std::array::from_fn(|i| (1.0 - s) * w[0][i] + s * w[1][i])).collect();
    }
    last.reverse();
    (first, last)
}

/// Converts Bernstein coefficients on \[0, 1] to the power basis on \[−1, 1], in place.
///
/// The coefficients b₀, b₁, … are `c[first]`, `c[first + stride]`, … For the degree n, the
/// coefficient of xᵏ is 2⁻ⁿ C(n, k) Σᵢ C(n − k, i) Δᵏbᵢ, where Δᵏ is the k-th forward difference.
pub fn bernstein_to_power_basis<const N: usize>(c: &mut [Coefficient<N>], first: usize, stride: usize, degree: usize) {
    let mut differences = [[0.0; N]; MAX_DEGREE + 1];
    for (i, d) in differences[..=degree].iter_mut().enumerate() {
        *d = c[first + i * stride];
    }
    let scale = 1.0 / (1u64 << degree) as f64;
    for k in 0..=degree {
        let rest = degree - k;
        let mut sum = [0.0; N];
        for (i, d) in differences[..=rest].iter().enumerate() {
            sum = add_scaled(sum, *d, binomial_coefficient(rest, i));
        }
        c[first + k * stride] = sum.map(|x| x * (scale * binomial_coefficient(degree, k)));
        for i in 0..rest {
            differences[i] = add_scaled(differences[i + 1], differences[i], -1.0);
        }
    }
}

/// Binomial coefficient C(n, k).
fn binomial_coefficient(n: usize, k: usize) -> f64 {
    (0..k).fold(1u64, |b, i| b * (n - i) as u64 / (i as u64 + 1)) as f64
}

/// Replaces the polynomial a(x) by a(`middle` + `half`·x), with the algorithm of Shaw and Traub.
#[inline]
pub fn reparametrize<const N: usize>(a: &mut [Coefficient<N>], middle: f64, half: f64) {
    let mut scale = 1.0;
    for i in 0..a.len() {
        let mut above = [0.0; N];
        for c in a[i..].iter_mut().rev() {
            above = add_scaled(*c, above, middle);
            *c = above;
        }
        a[i] = a[i].map(|x| x * scale);
        scale *= half;
    }
}

/// Replaces the polynomial a(x, y) by a(`middle` + `half`·x, y).
///
/// Each row of `columns` coefficients holds the powers of y for one power of x.
#[inline]
pub fn reparametrize_rows<const N: usize>(a: &mut [Coefficient<N>], columns: usize, middle: f64, half: f64) {
    let rows = a.len() / columns;
    let mut scale = 1.0;
    for i in 0..rows {
        for k in (i..rows - 1).rev() {
            let (low, high) = a.split_at_mut((k + 1) * columns);
            for (c, above) in low[k * columns..].iter_mut().zip(&*high) {
                *c = add_scaled(*c, *above, middle);
            }
        }
        a[i * columns..(i + 1) * columns].iter_mut().flatten().for_each(|x| *x *= scale);
        scale *= half;
    }
}

/// Value and derivative of a polynomial at `x`, by Horner's scheme.
#[inline]
pub fn evaluate_with_derivative<const N: usize>(a: &[Coefficient<N>], x: f64) -> (Coefficient<N>, Coefficient<N>) {
    let (mut value, mut slope) = ([0.0; N], [0.0; N]);
    for c in a.iter().rev() {
        slope = add_scaled(value, slope, x);
        value = add_scaled(*c, value, x);
    }
    (value, slope)
}

/// Value, ∂/∂x and ∂/∂y at (x, y) of the polynomial Σ aᵢⱼ xⁱ yʲ.
///
/// Each row of `columns` coefficients holds the powers of y for one power of x.
#[inline]
pub fn evaluate_2d_with_derivatives<const N: usize>(
    a: &[Coefficient<N>],
    columns: usize,
    x: f64,
    y: f64,
) -> [Coefficient<N>; 3] {
    let (mut value, mut along_x, mut along_y) = ([0.0; N], [0.0; N], [0.0; N]);
    for row in a.chunks_exact(columns).rev() {
        let (v, slope) = evaluate_with_derivative(row, y);
        along_x = add_scaled(value, along_x, x);
        value = add_scaled(v, value, x);
        along_y = add_scaled(slope, along_y, x);
    }
    [value, along_x, along_y]
}

#[cfg(test)]
mod tests;
