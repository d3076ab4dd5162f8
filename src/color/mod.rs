//! Linear RGB colors, sampled wavelengths, and refractive indices by wavelength.

mod glass;
mod rgb;
mod wavelength;

pub use glass::{DispersionFormula, GLASSES, glass_by_name};
pub use rgb::{Rgb, channel_mean, luminance};
pub use wavelength::Wavelength;
