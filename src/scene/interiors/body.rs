//! Bodies: volumes that light enters through a dielectric boundary.

use crate::color::Rgb;

/// A volume inside a dielectric boundary, such as glass or water: its refractive index, absorption
/// and medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Absolute refractive index; 1 is air. For a glass with dispersion, it is the index at 587.56
    /// nm (the d line).
    pub eta: f32,
    /// Absorption coefficient \[1/length].
    pub absorption: Rgb,
    /// Priority where bodies overlap: the body of highest priority fills the overlap. Among bodies
    /// of equal priority, one with a real boundary wins over one with a null interface. If that
    /// decides nothing, the body that the path entered last wins (Schmidt and Budge 2002, "Simple
    /// Nested Dielectrics in Ray Traced Images").
    pub priority: u8,
    /// Index of the dispersion formula in
    /// [`Scene::dispersion_formulas`](crate::scene::Scene::dispersion_formulas); `None` if the
    /// refractive index is the same at all wavelengths.
    pub dispersion_formula: Option<u32>,
    /// Index of the medium that fills the dielectric body, if any.
    pub medium: Option<u32>,
    /// True if the boundary is a null interface, which light crosses without reflection or
    /// refraction. If bodies of equal priority overlap, a body with a real boundary wins over one
    /// with a null interface.
    pub is_null_interface: bool,
}

impl Body {
    /// A dielectric body of absolute refractive index `eta` that neither absorbs nor scatters.
    #[must_use]
    pub fn new(eta: f32) -> Self {
        Self {
            eta,
            absorption: Rgb::ZERO,
            priority: 0,
            dispersion_formula: None,
            medium: None,
            is_null_interface: false,
        }
    }

    /// A region filled with `medium`, bounded by a null interface.
    #[must_use]
    pub fn null_interface_with_medium(medium: u32) -> Self {
        Self { medium: Some(medium), is_null_interface: true, ..Self::new(1.0) }
    }

    /// Sort key of overlapping dielectric bodies: priority, and true unless the boundary is a null
    /// interface. The body with the greatest key fills the overlap.
    pub(in crate::scene) fn overlap_priority(&self) -> (u8, bool) {
        (self.priority, !self.is_null_interface)
    }

    /// True if the dielectric body has refractive index 1, no absorption, no medium and no null
    /// interface: light cannot distinguish it from air.
    pub(in crate::scene) fn is_air(&self) -> bool {
        let Self { eta, absorption, dispersion_formula, medium, is_null_interface, priority: _ } = *self;
        eta == 1.0 && absorption == Rgb::ZERO && dispersion_formula.is_none() && medium.is_none() && !is_null_interface
    }
}
