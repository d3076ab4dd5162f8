//! Polynomials on \[−1, 1] in powers of the distance from the middle.
//!
//! On a short piece of a curve or surface the powers fall off quickly, so that they are as stable as Bernstein's form, cheaper to
//! evaluate, and bound themselves: what lies beyond the linear terms is at most the sum of its coefficients.

/// The largest degree of a curve or surface: what evaluation keeps on the stack grows with its square.
pub const MAX_DEGREE: usize = 24;

/// Coefficients, each of `N` components.
pub type Vector<const N: usize> = [f64; N];

#[inline]
fn combine<const N: usize>(a: Vector<N>, b: Vector<N>, s: f64) -> Vector<N> {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Both halves of a Bézier curve cut at `s` in \[0, 1] (de Casteljau).
pub fn split<const N: usize>(controls: &[Vector<N>], s: f64) -> (Vec<Vector<N>>, Vec<Vector<N>>) {
    let mut points = controls.to_vec();
    let (mut first, mut last) = (Vec::new(), Vec::new());
    while let (Some(a), Some(b)) = (points.first(), points.last()) {
        first.push(*a);
        last.push(*b);
        // Each from its nearer end: a cut at 0 or 1 then moves nothing.
        points = points.windows(2).map(|w| std::array::from_fn(|i| (1.0 - s) * w[0][i] + s * w[1][i])).collect();
    }
    last.reverse();
    (first, last)
}

/// From Bernstein's form to powers around the middle, for the controls at `first`, `first + stride`, … of `c`.
///
/// The k-th coefficient is 2⁻ⁿ C(n, k) Σᵢ C(n − k, i) Δᵏbᵢ.
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

/// Turns a(x) into a(`middle` + `half`·x) (Shaw and Traub's shift).
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

/// The same in x of a(x, y), whose rows are polynomials in y.
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
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose};

    fn random(i: u64) -> f64 {
        f64::from(Key::new(8).purpose(Purpose::Test).with(i).uniform(Dimension::LightPosition)) * 2.0 - 1.0
    }

    fn bezier(degree: usize) -> Vec<Vector<2>> {
        (0..=degree as u64).map(|i| [random(2 * i), random(2 * i + 1)]).collect()
    }

    /// By repeated halving of the interval, which rounds once a step.
    fn reference(controls: &[Vector<2>], s: f64) -> Vector<2> {
        split(controls, s).1[0]
    }

    /// Whole curves of degree 24 are far from short: coefficients grow to C(24, 12) there, and lose as many ulps.
    #[test]
    fn powers_agree_with_de_casteljau() {
        for degree in 1..=MAX_DEGREE {
            let controls = bezier(degree);
            let mut a = controls.clone();
            to_powers(&mut a, 0, 1, degree);
            for i in 0..=20 {
                let x = f64::from(i) / 10.0 - 1.0;
                let ([px, py], slope) = evaluate(&a, x);
                let truth = reference(&controls, 0.5 + 0.5 * x);
                let bound = f64::EPSILON * 4.0 * binomial(degree, degree / 2);
                assert!((px - truth[0]).abs().max((py - truth[1]).abs()) < bound, "{degree} {x}");
                let step = 1e-5;
                let [before, after] = [x - step, x + step].map(|x| evaluate(&a, x).0);
                let difference = (after[0] - before[0]) / (2.0 * step);
                assert!((slope[0] - difference).abs() < 1e-6 * (1.0 + bound / f64::EPSILON), "{degree} {x}");
            }
        }
    }

    #[test]
    fn shifted_polynomials_are_the_same_elsewhere() {
        let mut a = bezier(7);
        to_powers(&mut a, 0, 1, 7);
        let mut b = a.clone();
        recentre(&mut b, 0.25, 0.5);
        for i in 0..=10 {
            let x = f64::from(i) / 5.0 - 1.0;
            let (p, q) = (evaluate(&a, 0.25 + 0.5 * x).0, evaluate(&b, x).0);
            assert!((p[0] - q[0]).abs() < 1e-13 && (p[1] - q[1]).abs() < 1e-13);
        }
        let mut c = bezier(7);
        let mut d = c.clone();
        recentre(&mut c, -0.5, 0.25);
        recentre_rows(&mut d, 1, -0.5, 0.25);
        assert_eq!(c, d);
    }

    #[test]
    fn surfaces_evaluate_as_curves_of_curves() {
        let (p, q) = (3, 5);
        let mut a: Vec<Vector<1>> = (0..24).map(|i| [random(i)]).collect();
        let rows = a.clone();
        (0..=p).for_each(|i| to_powers(&mut a, i * (q + 1), 1, q));
        (0..=q).for_each(|j| to_powers(&mut a, j, q + 1, p));
        let at = |x: f64, y: f64| {
            let column: Vec<Vector<1>> = rows.chunks(q + 1).map(|row| split(row, 0.5 + 0.5 * y).1[0]).collect();
            split(&column, 0.5 + 0.5 * x).1[0][0]
        };
        let (x, y, h) = (0.3, -0.6, 1e-6);
        let [[v], [vx], [vy]] = evaluate_2d(&a, q + 1, x, y);
        assert!((v - at(x, y)).abs() < 1e-14);
        assert!((vx - (at(x + h, y) - at(x - h, y)) / (2.0 * h)).abs() < 1e-8);
        assert!((vy - (at(x, y + h) - at(x, y - h)) / (2.0 * h)).abs() < 1e-8);
    }
}
