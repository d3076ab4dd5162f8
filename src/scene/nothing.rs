//! Bodies that are nothing.

use super::builder::SceneBuilder;
use super::middle::Extent;
use super::{Body, Scattering};
use crate::color::Rgb;

/// The box around an object; `None` where it has no end, or moves.
type Reach = Option<Extent>;

impl SceneBuilder {
    /// Leaves out what light cannot tell from air: bodies of index 1 that absorb nothing and hold nothing. They are something where they
    /// displace another body or the medium all around, so they stay wherever their boxes meet that of another sort of body.
    pub(super) fn leave_out_nothing(&mut self) {
        if self.filling.is_some()
            || !self.materials.iter().any(|m| matches!(m.scattering, Scattering::Boundary(b) if is_air(&b)))
        {
            return;
        }
        let apart: Vec<Reach> =
            self.objects().filter(|(material, _)| self.is_substance(*material)).map(|o| o.1).collect();
        let goes = |material: u32, emission: Rgb, reach: Reach| {
            let air = matches!(self.materials[material as usize].scattering, Scattering::Boundary(b) if is_air(&b));
            let meets = |other: &Reach| match (reach, other) {
                (Some((min, max)), Some((lo, hi))) => min.cmple(*hi).all() && lo.cmple(max).all(),
                _ => true,
            };
            air && emission == Rgb::ZERO && !apart.iter().any(meets)
        };
        let shapes: Vec<bool> = self.shapes.iter().map(|(s, m, e)| !goes(*m, *e, Some(s.extent()))).collect();
        let planes: Vec<bool> = self.planes.iter().map(|(_, m)| !goes(*m, Rgb::ZERO, None)).collect();
        let ends: Vec<u32> = self.ends_of_parts();
        let parts: Vec<bool> = self
            .parts
            .iter()
            .zip(&ends)
            .map(|((first, m, e), end)| !goes(*m, *e, self.extent_of(*first..*end)))
            .collect();
        keep(&mut self.shapes, &shapes);
        keep(&mut self.planes, &planes);
        let all = std::mem::take(&mut self.triangles);
        for (((first, ..), end), stays) in self.parts.iter_mut().zip(ends).zip(parts) {
            let range = *first as usize..end as usize;
            *first = self.triangles.len() as u32;
            if stays {
                self.triangles.extend_from_slice(&all[range]);
            }
        }
        self.wardrobe.keep(&shapes, &planes);
    }

    /// Whether a material may bound a body that light can tell from air.
    fn is_substance(&self, material: u32) -> bool {
        match self.materials[material as usize].scattering {
            Scattering::Boundary(body) => !is_air(&body),
            Scattering::Mix { first, second, .. } => self.is_body(first) || self.is_body(second),
            Scattering::Fixed(_) => false,
        }
    }

    fn is_body(&self, material: u32) -> bool {
        match self.materials[material as usize].scattering {
            Scattering::Boundary(_) => true,
            Scattering::Mix { first, second, .. } => self.is_body(first) || self.is_body(second),
            Scattering::Fixed(_) => false,
        }
    }

    /// Materials and boxes of all objects.
    fn objects(&self) -> impl Iterator<Item = (u32, Reach)> {
        let shapes = self.shapes.iter().map(|(shape, material, _)| (*material, Some(shape.extent())));
        let parts = self.parts.iter().zip(self.ends_of_parts());
        let parts = parts.map(|((first, material, _), end)| (*material, self.extent_of(*first..end)));
        let planes = self.planes.iter().map(|(_, material)| (*material, None));
        let moving = self.moving_shapes.iter().map(|(.., material, _)| (*material, None));
        let moving_planes = self.moving_planes.iter().map(|(.., material)| (*material, None));
        shapes.chain(parts).chain(planes).chain(moving).chain(moving_planes)
    }
}

/// Whether light cannot tell the inside of a body from air.
fn is_air(body: &Body) -> bool {
    let Body { index, absorption, glass, medium, clear, .. } = *body;
    index == 1.0 && absorption == Rgb::ZERO && glass.is_none() && medium.is_none() && !clear
}

fn keep<T>(of: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    of.retain(|_| stays.next().copied().unwrap_or(true));
}
