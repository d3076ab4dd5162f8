//! Linear colour, wavelengths and the glasses that part them.

mod glass;
mod rgb;
mod wavelength;

pub use glass::{GLASSES, Glass, glass};
pub use rgb::{Rgb, luminance, mean};
pub use wavelength::Wavelength;
