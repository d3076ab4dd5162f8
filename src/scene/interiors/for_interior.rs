//! Choice of the interior type of camera and photon paths.

/// Calls a generic function or method with the [`Interior`](crate::scene::Interior) type that
/// `$needs` requires: a value with a method `interior_kind`, for example the effects.
///
/// Paths are compiled once per type, so that scenes without bodies or media do not pay for them.
macro_rules! for_interior {
    ($needs:expr, $object:ident . $method:ident ($($argument:expr),*)) => {
        match $needs.interior_kind() {
            $crate::scene::InteriorKind::Spectral => $object.$method::<$crate::scene::SpectralInterior>($($argument),*),
            $crate::scene::InteriorKind::Bodies => $object.$method::<$crate::scene::InteriorStack>($($argument),*),
            $crate::scene::InteriorKind::Nothing => $object.$method::<$crate::scene::NoInterior>($($argument),*),
        }
    };
    ($needs:expr, $function:ident ($($argument:expr),*)) => {
        match $needs.interior_kind() {
            $crate::scene::InteriorKind::Spectral => $function::<$crate::scene::SpectralInterior>($($argument),*),
            $crate::scene::InteriorKind::Bodies => $function::<$crate::scene::InteriorStack>($($argument),*),
            $crate::scene::InteriorKind::Nothing => $function::<$crate::scene::NoInterior>($($argument),*),
        }
    };
}
pub(crate) use for_interior;
