//! Greatest common divisor by Euclid's algorithm.

/// Greatest common divisor of `a` and `b`, by Euclid's algorithm.
#[must_use]
pub fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}
