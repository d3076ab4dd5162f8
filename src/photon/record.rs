//! Packed photon records.

use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// Flux \[W] in 8 bytes: the sum of the channels in f32, and two fractions of 16 bits.
///
/// Relative precision from 10⁻³⁷ to 10³⁸ W: 2⁻²⁴ in power, 1.5·10⁻⁵ in hue.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct PackedFlux {
    sum: f32,
    red: u16,
    green: u16,
}

impl PackedFlux {
    /// Packs a flux \[W]; `None` if it is not finite, zero or negative.
    #[inline]
    pub fn new(flux: Rgb) -> Option<Self> {
        let sum = flux.x + flux.y + flux.z;
        if !(sum > 0.0 && sum.is_finite() && flux.min_element() >= 0.0) {
            return None;
        }
        let fraction = |c: f32| (c / sum * 65_535.0 + 0.5) as u16;
        Some(Self { sum, red: fraction(flux.x), green: fraction(flux.y) })
    }

    /// The flux \[W].
    #[inline]
    pub fn flux(self) -> Rgb {
        let (red, green) = (f32::from(self.red), f32::from(self.green));
        // The last product comes last: a fraction of a very small sum would be subnormal.
        Rgb::new(red, green, (65_535.0 - red - green).max(0.0)) * (1.0 / 65_535.0) * self.sum
    }
}

/// Direction, tangent plane and flux of a stored photon, in 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct PhotonData {
    power: PackedFlux,
    from: [u16; 2],
    normal: [i8; 3],
    /// Wavelength code; 0 for all wavelengths.
    wavelength: u8,
    /// normal · position: offset of the tangent plane from the origin.
    offset: f32,
}

/// A photon deposited on a surface, in 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Position.
    pub position: Vec3,
    /// Direction, tangent plane and flux.
    pub data: PhotonData,
}

impl Photon {
    /// Packs a position, flux \[W], the unit direction towards the previous vertex, and the unit
    /// geometric normal on that side.
    ///
    /// `None` if position or flux is not finite, or if the flux is zero or negative.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, flux: Rgb, from: Vec3, normal: Vec3) -> Option<Self> {
        let power = PackedFlux::new(flux).filter(|_| position.is_finite())?;
        let mut data = PhotonData {
            power,
            from: encode_octahedral(from),
            normal: [normal.x, normal.y, normal.z].map(|c| (c * NORMAL_SCALE).round() as i8),
            wavelength: 0,
            offset: 0.0,
        };
        data.offset = data.normal().dot(position);
        Some(Self { position, data })
    }
}

impl Photon {
    /// The photon with a wavelength code.
    #[inline]
    #[must_use]
    pub fn with_wavelength(self, wavelength: u8) -> Self {
        Self { data: PhotonData { wavelength, ..self.data }, ..self }
    }
}

/// Scale of quantised normals.
const NORMAL_SCALE: f32 = 127.0;

/// Tangent plane of an estimate, prepared for comparison with many photons.
#[derive(Clone, Copy, Debug)]
pub struct TangentPlane {
    point: Vec3,
    normal: Vec3,
}

impl TangentPlane {
    /// The plane through `point` with unit `normal`.
    #[inline]
    #[must_use]
    pub fn new(point: Vec3, normal: Vec3) -> Self {
        Self { point: point / NORMAL_SCALE, normal: normal / NORMAL_SCALE }
    }
}

impl PhotonData {
    /// Cosine between the photon's normal and that of `plane`, and signed height \[length] of the
    /// plane's point over the photon's tangent plane.
    #[inline]
    #[must_use]
    pub fn normal_cosine_and_height(&self, plane: &TangentPlane) -> (f32, f32) {
        let normal = Vec3::from(self.normal.map(f32::from));
        (normal.dot(plane.normal), normal.dot(plane.point) - self.offset)
    }

    /// Flux \[W].
    #[inline]
    #[must_use]
    pub fn flux(&self) -> Rgb {
        self.power.flux()
    }

    /// Wavelength code; 0 for all wavelengths.
    #[inline]
    #[must_use]
    pub fn wavelength(&self) -> u8 {
        self.wavelength
    }

    /// Unit direction towards the previous vertex, within 10⁻⁴ rad.
    #[inline]
    #[must_use]
    pub fn from(&self) -> Vec3 {
        decode_octahedral(self.from)
    }

    /// Approximate unit normal on the side where the photon landed, within 0.01.
    #[inline]
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        Vec3::from(self.normal.map(f32::from)) / NORMAL_SCALE
    }

    /// The record on the tangent plane of another record with the same normal.
    pub(super) fn at_offset_of(self, other: &Self) -> Self {
        Self { offset: other.offset, ..self }
    }

    /// The quantised normal, equal for photons on the same side of a surface.
    pub(super) fn side(&self) -> [i8; 3] {
        self.normal
    }
}

/// Octahedral coordinates of a unit vector, 16 bits each (Cigolle et al. 2014, JCGT 3(2)).
#[inline]
pub(super) fn encode_octahedral(v: Vec3) -> [u16; 2] {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    let p = if v.z < 0.0 { fold_octahedron(p) } else { p };
    [p.x, p.y].map(|c| ((c * 0.5 + 0.5) * 65_535.0 + 0.5) as u16)
}

/// Unit vector of octahedral coordinates.
#[inline]
pub(super) fn decode_octahedral(e: [u16; 2]) -> Vec3 {
    let [x, y] = e.map(|c| f32::from(c) * (2.0 / 65_535.0) - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let p = if z < 0.0 { fold_octahedron(Vec2::new(x, y)) } else { Vec2::new(x, y) };
    p.extend(z).normalize()
}

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
    fn photon_records_have_20_and_32_bytes() {
        assert_eq!((size_of::<PhotonData>(), size_of::<Photon>()), (20, 32));
    }

    #[test]
    fn packing_preserves_direction_hue_and_power() {
        for i in 0..10_000u64 {
            let key = Key::new(1).purpose_key(Purpose::Test).child_key(i);
            let from = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
            let normal = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightPosition));
            let scale = [1e-33, 1.0, 1e30][i as usize % 3];
            let flux = key.uniform_2d(Dimension::Film).extend(key.uniform_1d(Dimension::Light)) * scale;
            let packed = Photon::new(normal, flux, from, normal).unwrap().data;
            assert!((packed.from() - from).length() < 1e-4);
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
