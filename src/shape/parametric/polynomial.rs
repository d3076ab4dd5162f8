//! Polynomials on \[−1, 1] in powers of the distance from the centre.
//!
//! On a short piece of a curve or surface, coefficients decrease quickly with the power. This form
//! is then as stable as the Bernstein form and faster to evaluate. The sum of the coefficients
//! beyond the linear terms bounds these terms.

/// Largest degree of a curve or surface; the stack used by evaluation grows with its square.
pub const MAX_DEGREE: usize = 24;

/// Coefficients with `N` components.
pub type Vector<const N: usize> = [f64; N];

#[inline]
fn combine<const N: usize>(a: Vector<N>, b: Vector<N>, s: f64) -> Vector<N> {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Halves of a Bézier curve divided at `s` in \[0, 1], by de Casteljau's algorithm.
pub fn split<const N: usize>(controls: &[Vector<N>], s: f64) -> (Vec<Vector<N>>, Vec<Vector<N>>) {
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

/// Converts Bernstein coefficients to powers around the centre, in place.
///
/// The coefficients are at `first`, `first + stride`, … of `c`. The k-th result is 2⁻ⁿ C(n, k) Σᵢ
/// C(n − k, i) Δᵏbᵢ.
pub fn to_powers<const N: usize>(c: &mut [Vector<N>], first: usize, stride: usize, degree: usize) {
    let mut differences = [[0.0; N]; MAX_DEGREE + 1];
    for (i, d) in differences[..=degree].iter_mut().enumerate() {
        *d = c[first + i * stride];
    }
    let scale = 1.0 / (1u64 << degree) as f64;
    for k in 0..=degree {
        let rest = degree - k;
        let mut sum = [0.0; N];
        for (i, d) in differences[..=rest].iter().enumerate() {
            sum = combine(sum, *d, binomial(rest, i));
        }
        c[first + k * stride] = sum.map(|x| x * (scale * binomial(degree, k)));
        for i in 0..rest {
            differences[i] = combine(differences[i + 1], differences[i], -1.0);
        }
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1u64, |b, i| b * (n - i) as u64 / (i as u64 + 1)) as f64
}

/// Replaces a(x) by a(`middle` + `half`·x), by the shift of Shaw and Traub.
#[inline]
pub fn recentre<const N: usize>(a: &mut [Vector<N>], middle: f64, half: f64) {
    let mut scale = 1.0;
    for i in 0..a.len() {
        let mut above = [0.0; N];
        for c in a[i..].iter_mut().rev() {
            above = combine(*c, above, middle);
            *c = above;
        }
        a[i] = a[i].map(|x| x * scale);
        scale *= half;
    }
}

/// Replaces a(x, y) by a(`middle` + `half`·x, y); the rows are polynomials in y.
#[inline]
pub fn recentre_rows<const N: usize>(a: &mut [Vector<N>], columns: usize, middle: f64, half: f64) {
    let rows = a.len() / columns;
    let mut scale = 1.0;
    for i in 0..rows {
        for k in (i..rows - 1).rev() {
            let (low, high) = a.split_at_mut((k + 1) * columns);
            for (c, above) in low[k * columns..].iter_mut().zip(&*high) {
                *c = combine(*c, *above, middle);
            }
        }
        a[i * columns..(i + 1) * columns].iter_mut().flatten().for_each(|x| *x *= scale);
        scale *= half;
    }
}

/// Value and derivative at `x`.
#[inline]
pub fn evaluate<const N: usize>(a: &[Vector<N>], x: f64) -> (Vector<N>, Vector<N>) {
    let (mut value, mut slope) = ([0.0; N], [0.0; N]);
    for c in a.iter().rev() {
        slope = combine(value, slope, x);
        value = combine(*c, value, x);
    }
    (value, slope)
}

/// Value and both partial derivatives at (x, y) of Σ aᵢⱼ xⁱ yʲ, of degree `columns − 1` in y.
#[inline]
pub fn evaluate_2d<const N: usize>(a: &[Vector<N>], columns: usize, x: f64, y: f64) -> [Vector<N>; 3] {
    let (mut value, mut along_x, mut along_y) = ([0.0; N], [0.0; N], [0.0; N]);
    for row in a.chunks_exact(columns).rev() {
        let (v, slope) = evaluate(row, y);
        along_x = combine(value, along_x, x);
        value = combine(v, value, x);
        along_y = combine(slope, along_y, x);
    }
    [value, along_x, along_y]
}

#[cfg(test)]
mod tests;
