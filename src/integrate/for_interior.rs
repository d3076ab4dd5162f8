//! Choice of the interior type of paths.

/// Calls a generic function or method with the [`Interior`](crate::scene::Interior) type that
/// `effects` require.
///
/// Paths are compiled once per type, so that scenes without bodies or media do not pay for them.
macro_rules! for_interior {
    ($effects:expr, $object:ident . $method:ident ($($argument:expr),*)) => {
        match $effects.interior_kind() {
            $crate::scene::InteriorKind::Spectral => $object.$method::<$crate::scene::SpectralInterior>($($argument),*),
            $crate::scene::InteriorKind::Bodies => $object.$method::<$crate::scene::InteriorStack>($($argument),*),
            $crate::scene::InteriorKind::Nothing => $object.$method::<$crate::scene::NoInterior>($($argument),*),
        }
    };
    ($effects:expr, $function:ident ($($argument:expr),*)) => {
        match $effects.interior_kind() {
            $crate::scene::InteriorKind::Spectral => $function::<$crate::scene::SpectralInterior>($($argument),*),
            $crate::scene::InteriorKind::Bodies => $function::<$crate::scene::InteriorStack>($($argument),*),
            $crate::scene::InteriorKind::Nothing => $function::<$crate::scene::NoInterior>($($argument),*),
        }
    };
}
pub(super) use for_interior;
