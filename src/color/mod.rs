//! Linear colour, wavelengths, and dispersive indices of refraction.

mod glass;
mod rgb;
mod wavelength;

pub use glass::{GLASSES, Glass, glass};
pub use rgb::{Rgb, luminance, mean};
pub use wavelength::Wavelength;
