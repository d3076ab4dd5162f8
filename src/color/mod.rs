//! Linear RGB colors, spectra, sampled wavelengths, and refractive indices by wavelength.

mod glass;
mod rgb;
mod spectrum;
mod wavelength;

pub use glass::{DispersionFormula, GLASSES, glass_by_name};
pub use rgb::{Rgb, channel_mean, luminance, xyz_to_rgb};
pub use spectrum::{Spectrum, conductor_refractive_index, illuminant_rgb};
pub use wavelength::Wavelength;
