//! What is kept of a photon.

use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// Flux \[W] in 8 bytes: the sum of its channels in single precision with two 16-bit fractions, so that hue is right to 1.5·10⁻⁵ and power
/// to 2⁻²⁴ from 10⁻³⁷ to 10³⁸ W.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct Power {
    sum: f32,
    red: u16,
    green: u16,
}

impl Power {
    /// `None` where the flux is not finite, zero or negative: it carries nothing, or would poison an estimate.
    #[inline]
    pub fn new(flux: Rgb) -> Option<Self> {
        let sum = flux.x + flux.y + flux.z;
        if !(sum > 0.0 && sum.is_finite() && flux.min_element() >= 0.0) {
            return None;
        }
        let fraction = |c: f32| (c / sum * 65_535.0 + 0.5) as u16;
        Some(Self { sum, red: fraction(flux.x), green: fraction(flux.y) })
    }

    #[inline]
    pub fn flux(self) -> Rgb {
        let (red, green) = (f32::from(self.red), f32::from(self.green));
        // A part of a step of so faint a sum would lie below the normal numbers.
        Rgb::new(red, green, (65_535.0 - red - green).max(0.0)) * (1.0 / 65_535.0) * self.sum
    }
}

/// Direction, tangent plane and flux of a stored photon: 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct PhotonData {
    power: Power,
    from: [u16; 2],
    normal: [i8; 3],
    /// The code of its wavelength, 0 where it carries all.
    wavelength: u8,
    /// normal · position: the plane's offset from the origin.
    offset: f32,
}

/// A photon as it was deposited: 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Place.
    pub position: Vec3,
    /// Everything else.
    pub data: PhotonData,
}

impl Photon {
    /// Packs a place, flux \[W], the unit direction to where the photon came from, and the unit geometric normal on that side.
    ///
    /// `None` where the place or the flux is not finite, or the flux is zero or negative: such photons carry nothing, or would
    /// poison an estimate.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, flux: Rgb, from: Vec3, normal: Vec3) -> Option<Self> {
        let power = Power::new(flux).filter(|_| position.is_finite())?;
        let mut data = PhotonData {
            power,
            from: encode(from),
            normal: [normal.x, normal.y, normal.z].map(|c| (c * NORMAL_SCALE).round() as i8),
            wavelength: 0,
            offset: 0.0,
        };
        data.offset = data.normal().dot(position);
        Some(Self { position, data })
    }
}

impl Photon {
    /// The same photon of the wavelength with this code.
    #[inline]
    #[must_use]
    pub fn with_wavelength(self, wavelength: u8) -> Self {
        Self { data: PhotonData { wavelength, ..self.data }, ..self }
    }
}

/// Steps of a normal's coordinate.
const NORMAL_SCALE: f32 = 127.0;

/// A point and a normal, ready to be compared with many photons.
#[derive(Clone, Copy, Debug)]
pub struct TangentPlane {
    point: Vec3,
    normal: Vec3,
}

impl TangentPlane {
    /// The plane through `point` across the unit `normal`.
    #[inline]
    #[must_use]
    pub fn new(point: Vec3, normal: Vec3) -> Self {
        Self { point: point / NORMAL_SCALE, normal: normal / NORMAL_SCALE }
    }
}

impl PhotonData {
    /// How much the photon's surface faces the way of `plane` (the cosine of their normals), and how far the plane's point is
    /// above the photon's own tangent plane \[length].
    #[inline]
    #[must_use]
    pub fn relation(&self, plane: &TangentPlane) -> (f32, f32) {
        let normal = Vec3::from(self.normal.map(f32::from));
        (normal.dot(plane.normal), normal.dot(plane.point) - self.offset)
    }

    /// Flux \[W].
    #[inline]
    #[must_use]
    pub fn flux(&self) -> Rgb {
        self.power.flux()
    }

    /// The code of its wavelength, 0 where it carries all.
    #[inline]
    #[must_use]
    pub fn wavelength(&self) -> u8 {
        self.wavelength
    }

    /// Unit direction to where the photon came from, within 10⁻⁴ rad.
    #[inline]
    #[must_use]
    pub fn from(&self) -> Vec3 {
        decode(self.from)
    }

    /// The surface normal on the side where the photon landed, within a hundredth of a radian and of length.
    #[inline]
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        Vec3::from(self.normal.map(f32::from)) / NORMAL_SCALE
    }

    /// The same photon on the tangent plane of another with the same normal.
    pub(super) fn at_offset_of(self, other: &Self) -> Self {
        Self { offset: other.offset, ..self }
    }

    /// A key by which photons of one side can be told from those of another.
    pub(super) fn side(&self) -> [i8; 3] {
        self.normal
    }
}

/// Octahedral coordinates in 16 bits each (Cigolle et al. 2014, JCGT 3(2)).
#[inline]
pub(super) fn encode(v: Vec3) -> [u16; 2] {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    let p = if v.z < 0.0 { fold(p) } else { p };
    [p.x, p.y].map(|c| ((c * 0.5 + 0.5) * 65_535.0 + 0.5) as u16)
}

#[inline]
pub(super) fn decode(e: [u16; 2]) -> Vec3 {
    let [x, y] = e.map(|c| f32::from(c) * (2.0 / 65_535.0) - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let p = if z < 0.0 { fold(Vec2::new(x, y)) } else { Vec2::new(x, y) };
    p.extend(z).normalize()
}

#[inline]
fn fold(p: Vec2) -> Vec2 {
    Vec2::new((1.0 - p.y.abs()) * 1f32.copysign(p.x), (1.0 - p.x.abs()) * 1f32.copysign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp;
    use crate::sampling::{Dimension, Key, Purpose};

    #[test]
    fn a_photon_is_small() {
        assert_eq!((size_of::<PhotonData>(), size_of::<Photon>()), (20, 32));
    }

    #[test]
    fn packing_keeps_direction_hue_and_power() {
        for i in 0..10_000u64 {
            let key = Key::new(1).purpose(Purpose::Test).with(i);
            let from = warp::sphere(key.uniform_2d(Dimension::LightDirection));
            let normal = warp::sphere(key.uniform_2d(Dimension::LightPosition));
            let scale = [1e-33, 1.0, 1e30][i as usize % 3];
            let flux = key.uniform_2d(Dimension::Film).extend(key.uniform(Dimension::Light)) * scale;
            let packed = Photon::new(normal, flux, from, normal).unwrap().data;
            assert!((packed.from() - from).length() < 1e-4);
            assert!((packed.normal() - normal).length() < 0.01);
            let (cosine, height) = packed.relation(&TangentPlane::new(normal * 3.0, -normal));
            assert!((cosine + 1.0).abs() < 0.01 && (height - 2.0).abs() < 0.02);
            let sum = flux.x + flux.y + flux.z;
            assert!(((packed.flux() - flux) / sum).abs().max_element() < 2e-5);
            assert!(((packed.flux().element_sum() - sum) / sum).abs() < 1e-6);
        }
    }

    #[test]
    fn flux_that_would_poison_an_estimate_is_refused() {
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
