//! Compact storage of surface photons: 32 bytes for position, flux, incident direction, tangent
//! plane and wavelength.

use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// RGB flux \[W] in 8 bytes: the sum of the channels in f32, and the fractions of red and green in
/// this sum in 16 bits each.
///
/// Between 10⁻³⁷ and 10³⁸ W, the sum has relative precision 2⁻²⁴. With light tracing, its lowest
/// four bits store the fraction of the flux that density estimates use, and the precision falls to
/// 2⁻¹⁹. Each channel is precise to 1.5·10⁻⁵ of the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct PackedFlux {
    channel_sum: f32,
    red_fraction: u16,
    green_fraction: u16,
}

impl PackedFlux {
    /// Packs a flux \[W]; `None` if it is zero or not finite, or if a channel is negative.
    #[inline]
    pub fn new(flux: Rgb) -> Option<Self> {
        let sum = flux.x + flux.y + flux.z;
        if !(sum > 0.0 && sum.is_finite() && flux.min_element() >= 0.0) {
            return None;
        }
        let fraction = |c: f32| (c / sum * 65_535.0 + 0.5) as u16;
        Some(Self { channel_sum: sum, red_fraction: fraction(flux.x), green_fraction: fraction(flux.y) })
    }

    /// Returns a copy in which the lowest four bits of the channel sum hold `steps`, a number from
    /// 0 to [`SHARE_STEPS`].
    ///
    /// Density estimates use the fraction `steps`/[`SHARE_STEPS`] of the flux. Storing `steps`
    /// changes the flux by a fraction below 2⁻¹⁹.
    #[inline]
    fn with_packed_share(self, steps: u8) -> Self {
        Self { channel_sum: f32::from_bits(self.channel_sum.to_bits() & !15 | u32::from(steps)), ..self }
    }

    /// Returns the unpacked flux \[W].
    #[inline]
    pub fn flux(self) -> Rgb {
        let (red, green) = (f32::from(self.red_fraction), f32::from(self.green_fraction));
        // Multiplying by the sum first would give subnormal numbers if the sum is very small.
        Rgb::new(red, green, (65_535.0 - red - green).max(0.0)) * (1.0 / 65_535.0) * self.channel_sum
    }
}

/// Data of a stored photon except its position, in 20 bytes: flux, incident direction, tangent
/// plane and wavelength.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct PhotonAttributes {
    flux: PackedFlux,
    /// Direction towards the previous path vertex, in octahedral coordinates.
    incident: [u16; 2],
    /// Geometric normal times [`NORMAL_SCALE`], rounded.
    normal: [i8; 3],
    /// Wavelength of the photon as [`Wavelength::byte_code`](crate::color::Wavelength::byte_code);
    /// 0 if it carries all wavelengths.
    wavelength_code: u8,
    /// Signed distance of the photon's tangent plane from the origin: normal · position \[length].
    plane_offset: f32,
}

/// A photon stored on a surface, in 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Position on the surface.
    pub position: Vec3,
    /// Incident direction, tangent plane, flux and wavelength.
    pub attributes: PhotonAttributes,
}

impl Photon {
    /// Packs a photon that arrives at `position` with `flux` \[W].
    ///
    /// `incident` is the unit direction towards the previous path vertex. `normal` is the unit
    /// geometric normal on the side of `incident`. Returns `None` if the position is not finite, if
    /// the flux is zero or not finite, or if a channel is negative.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, flux: Rgb, incident: Vec3, normal: Vec3) -> Option<Self> {
        let flux = PackedFlux::new(flux).filter(|_| position.is_finite())?;
        let mut data = PhotonAttributes {
            flux,
            incident: encode_octahedral(incident),
            normal: [normal.x, normal.y, normal.z].map(|c| (c * NORMAL_SCALE).round() as i8),
            wavelength_code: 0,
            plane_offset: 0.0,
        };
        data.plane_offset = data.normal().dot(position);
        Some(Self { position, attributes: data })
    }

    /// Returns the photon with `wavelength_code`, a
    /// [`Wavelength::byte_code`](crate::color::Wavelength::byte_code); 0 means all wavelengths.
    #[inline]
    #[must_use]
    pub fn with_wavelength_code(self, wavelength_code: u8) -> Self {
        Self { attributes: PhotonAttributes { wavelength_code, ..self.attributes }, ..self }
    }

    /// Returns the photon with the fraction of its flux that density estimates use set to
    /// `steps`/`SHARE_STEPS`. Light tracing has splatted the rest on the film. `steps` is from 0 to
    /// `SHARE_STEPS`; see [`PhotonAttributes::density_estimate_share`].
    #[inline]
    #[must_use]
    pub fn with_density_estimate_share(self, steps: u8) -> Self {
        Self {
            attributes: PhotonAttributes { flux: self.attributes.flux.with_packed_share(steps), ..self.attributes },
            ..self
        }
    }
}

/// Largest value of a photon's density-estimate share: the fraction of its flux that density
/// estimates use, stored as an integer in four bits. `SHARE_STEPS` stands for the whole flux.
pub(super) const SHARE_STEPS: u8 = 15;

/// Factor from a unit normal to its stored components, which are 8-bit integers.
const NORMAL_SCALE: f32 = 127.0;

/// Tangent plane at the query point of a density estimate, scaled so that dot products with the
/// 8-bit normals of photons need no division.
#[derive(Clone, Copy, Debug)]
pub struct TangentPlane {
    /// Query point, divided by [`NORMAL_SCALE`]. Its dot product with the stored normal of a photon
    /// is the component of the query point along that normal \[length].
    scaled_point: Vec3,
    /// Unit normal, divided by [`NORMAL_SCALE`]. Its dot product with the stored normal of a photon
    /// is a cosine.
    scaled_normal: Vec3,
}

impl TangentPlane {
    /// Creates the plane through `point` that is perpendicular to the unit vector `normal`.
    #[inline]
    #[must_use]
    pub fn new(point: Vec3, normal: Vec3) -> Self {
        Self { scaled_point: point / NORMAL_SCALE, scaled_normal: normal / NORMAL_SCALE }
    }
}

impl PhotonAttributes {
    /// Returns two numbers: the cosine between the photon's normal and the normal of `plane`, and
    /// the signed height \[length] of the query point over the photon's tangent plane.
    ///
    /// `plane` is the tangent plane at the query point of a density estimate.
    #[inline]
    #[must_use]
    pub fn normal_cosine_and_height(&self, plane: &TangentPlane) -> (f32, f32) {
        let normal = Vec3::from(self.normal.map(f32::from));
        (normal.dot(plane.scaled_normal), normal.dot(plane.scaled_point) - self.plane_offset)
    }

    /// Returns the flux that the photon carries \[W].
    #[inline]
    #[must_use]
    pub fn flux(&self) -> Rgb {
        self.flux.flux()
    }

    /// Fraction of the flux that density estimates use, in \[0, 1]. Light tracing has splatted the
    /// rest on the film.
    ///
    /// The value is meaningful only if [`Photon::with_density_estimate_share`] has set it.
    #[inline]
    #[must_use]
    pub fn density_estimate_share(&self) -> f32 {
        f32::from(self.density_estimate_share_steps()) * (1.0 / SHARE_STEPS as f32)
    }

    /// Fraction of the flux that density estimates use, as an integer from 0 to [`SHARE_STEPS`],
    /// which stands for the whole flux.
    pub(super) fn density_estimate_share_steps(&self) -> u8 {
        (self.flux.channel_sum.to_bits() & 15) as u8
    }

    /// Wavelength of the photon as [`Wavelength::byte_code`](crate::color::Wavelength::byte_code);
    /// 0 if it carries all wavelengths.
    #[inline]
    #[must_use]
    pub fn wavelength_code(&self) -> u8 {
        self.wavelength_code
    }

    /// Unit direction towards the previous path vertex, precise to 10⁻⁴ rad.
    #[inline]
    #[must_use]
    pub fn incident_direction(&self) -> Vec3 {
        decode_octahedral(self.incident)
    }

    /// Geometric normal on the side where the photon arrived. It differs from the unit normal by at
    /// most 0.01, because it is quantized.
    #[inline]
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        Vec3::from(self.normal.map(f32::from)) / NORMAL_SCALE
    }

    /// Returns a copy of this photon data with the tangent plane of `other`, which must have an
    /// equal quantized normal.
    pub(super) fn with_plane_offset_of(self, other: &Self) -> Self {
        Self { plane_offset: other.plane_offset, ..self }
    }

    /// The stored geometric normal: unit normal times 127, rounded to integers.
    pub(super) fn quantized_normal(&self) -> [i8; 3] {
        self.normal
    }
}

/// Encodes a unit vector as two 16-bit octahedral coordinates (Cigolle et al. 2014, JCGT 3(2)).
#[inline]
pub(super) fn encode_octahedral(v: Vec3) -> [u16; 2] {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    let p = if v.z < 0.0 { fold_octahedron(p) } else { p };
    [p.x, p.y].map(|c| ((c * 0.5 + 0.5) * 65_535.0 + 0.5) as u16)
}

/// Decodes the unit vector that [`encode_octahedral`] has encoded, up to rounding.
#[inline]
pub(super) fn decode_octahedral(e: [u16; 2]) -> Vec3 {
    let [x, y] = e.map(|c| f32::from(c) * (2.0 / 65_535.0) - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let p = if z < 0.0 { fold_octahedron(Vec2::new(x, y)) } else { Vec2::new(x, y) };
    p.extend(z).normalize()
}

/// Mirrors a vector in the plane z = 0: converts its octahedral coordinates to those of its mirror
/// image.
#[inline]
fn fold_octahedron(p: Vec2) -> Vec2 {
    Vec2::new((1.0 - p.y.abs()) * 1f32.copysign(p.x), (1.0 - p.x.abs()) * 1f32.copysign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp;
    use crate::sampling::{Dimension, Key, Purpose};

    #[test]
    fn photon_record_sizes_are_fixed() {
        assert_eq!((size_of::<PhotonAttributes>(), size_of::<Photon>()), (20, 32));
    }

    #[test]
    fn packing_preserves_direction_hue_and_power() {
        for i in 0..10_000u64 {
            let key = Key::new(1).purpose_key(Purpose::Test).child_key(i);
            let from = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
            let normal = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightPosition));
            let scale = [1e-33, 1.0, 1e30][i as usize % 3];
            let flux = key.uniform_2d(Dimension::Film).extend(key.uniform_1d(Dimension::Light)) * scale;
            let packed = Photon::new(normal, flux, from, normal).unwrap().attributes;
            assert!((packed.incident_direction() - from).length() < 1e-4);
            assert!((packed.normal() - normal).length() < 0.01);
            let (cosine, height) = packed.normal_cosine_and_height(&TangentPlane::new(normal * 3.0, -normal));
            assert!((cosine + 1.0).abs() < 0.01 && (height - 2.0).abs() < 0.02);
            let sum = flux.x + flux.y + flux.z;
            assert!(((packed.flux() - flux) / sum).abs().max_element() < 2e-5);
            assert!(((packed.flux().element_sum() - sum) / sum).abs() < 1e-6);
        }
    }

    #[test]
    fn invalid_flux_and_positions_are_rejected() {
        for bad in
            [Rgb::ZERO, Rgb::new(f32::NAN, 1.0, 1.0), Rgb::new(f32::INFINITY, 0.0, 0.0), Rgb::new(-1.0, 2.0, 0.0)]
        {
            assert!(Photon::new(Vec3::ZERO, bad, Vec3::Z, Vec3::Z).is_none(), "{bad}");
        }
        for nowhere in [Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)] {
            assert!(Photon::new(nowhere, Rgb::ONE, Vec3::Z, Vec3::Z).is_none());
        }
    }
}
