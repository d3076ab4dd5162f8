//! Enums that list their own variants.

/// Defines an enum without data, and its constant `ALL`: an array of all variants in the order of
/// definition. The macro builds both from one list, so `ALL` lacks no variant.
macro_rules! enum_with_all {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $name:ident {
            $($(#[$variant_attribute:meta])* $variant:ident,)*
        }
    ) => {
        $(#[$attribute])*
        $visibility enum $name {
            $($(#[$variant_attribute])* $variant,)*
        }

        impl $name {
            /// All variants, in the order of definition.
            $visibility const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];
        }
    };
}
