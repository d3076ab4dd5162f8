//! Choice of the interior type of camera and photon paths.

/// Evaluates an expression with the [`Interior`](crate::scene::Interior) type that `$needs`
/// requires. `$needs` is a value with a method `interior_kind`, for example
/// [`Effects`](crate::scene::Effects).
///
/// `with_interior_type!(effects, <I> trace::<I>(scene))` names the type `I`. Path loops are
/// compiled for each type, so that scenes without dielectric bodies or media do not pay for them.
macro_rules! with_interior_type {
    ($needs:expr, <$interior:ident> $body:expr) => {
        match $needs.interior_kind() {
            $crate::scene::InteriorKind::Spectral => {
                type $interior = $crate::scene::SpectralInterior;
                $body
            }
            $crate::scene::InteriorKind::Bodies => {
                type $interior = $crate::scene::InteriorStack;
                $body
            }
            $crate::scene::InteriorKind::Nothing => {
                type $interior = $crate::scene::NoInterior;
                $body
            }
        }
    };
}
pub(crate) use with_interior_type;
