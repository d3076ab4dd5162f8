//! Where the coordinates of a resolved scene count from.

use crate::camera::Camera;
use crate::shape::Shape;
use glam::{DVec3, Vec2};

/// How many times their own size things may be away from the middle. Single precision then rounds their coordinates by no more than
/// 2⁻²⁴·2¹² = 2⁻¹² of their size.
const FAR: f64 = 4096.0;

/// Halvings that find the least distance: as many as double precision has digits.
const HALVINGS: u32 = 64;

/// The least and the greatest corner of a box around something, in double precision.
pub(super) type Extent = (DVec3, DVec3);

/// An eye, and the distance of what it sees.
pub(super) type Sight = (DVec3, f64);

/// Something that single precision must tell, as its middle and its size.
#[derive(Clone, Copy, Debug)]
struct Thing {
    center: DVec3,
    size: f64,
}

/// The middle of the box around `boxes`, unless that is far from one of them in its own size, as things are from the centre of a sphere that
/// is their floor: then where the farthest in its own size is as near as can be. `eye` is where the picture is taken from, with the distance
/// of what it sees. `None` where there is nothing.
///
/// Nothing is farther from the second than twice as far as from the first, so no coordinate loses more than one digit of two by it.
pub(super) fn middle(boxes: &[Extent], eye: Option<Sight>) -> Option<DVec3> {
    let (min, max) = boxes.iter().copied().reduce(|(min, max), (a, b)| (min.min(a), max.max(b)))?;
    let of_box = min * 0.5 + max * 0.5;
    let thing = |(min, max): &Extent| Thing { center: *min * 0.5 + *max * 0.5, size: (*max - *min).max_element() };
    // The eye may be outside of the box, where the middle is not to go.
    let eye = eye.map(|(center, size)| Thing { center: center.clamp(min, max), size });
    let things: Vec<Thing> = boxes.iter().map(thing).chain(eye).filter(|t| t.size > 0.0).collect();
    let farthest = |m: DVec3| things.iter().map(|t| (t.center - m).abs().max_element() / t.size).fold(0.0, f64::max);
    let most = farthest(of_box);
    if most.is_nan() || most <= FAR {
        return Some(of_box);
    }
    let nearest = DVec3::from_array([0, 1, 2].map(|axis| nearest(&things, axis, most)));
    Some(nearest.clamp(min, max))
}

/// The eye of a camera, with the distance of the nearest of `shapes` that it sees in the middle or the corners of its picture.
pub(super) fn sight<'a>(camera: &Camera, shapes: impl Iterator<Item = &'a Shape>) -> Option<Sight> {
    let (eye, (width, height)) = (camera.center(), camera.size());
    let looking = camera.translated(-eye);
    let size = Vec2::new(width as f32, height as f32);
    let rays = [Vec2::splat(0.5), Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|place| looking.ray(place * size, None));
    let distances = shapes.map(|shape| shape.translated(-eye)).flat_map(|shape| {
        let nearest = rays.iter().filter_map(|ray| Some(shape.intersect(ray)?.0)).reduce(f32::min);
        nearest.into_iter()
    });
    Some((eye, f64::from(distances.reduce(f32::min)?)))
}

/// The coordinate along an axis of which no thing is farther, in its own size, than it must be; `most` is enough for all.
fn nearest(things: &[Thing], axis: usize, most: f64) -> f64 {
    let within = |t: f64| {
        let ends =
            things.iter().map(|thing| (thing.center[axis] - t * thing.size, thing.center[axis] + t * thing.size));
        ends.fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), (a, b)| (low.max(a), high.min(b)))
    };
    let (mut too_near, mut enough) = (0.0, most);
    for _ in 0..HALVINGS {
        let t = 0.5 * (too_near + enough);
        let (low, high) = within(t);
        if low <= high { enough = t } else { too_near = t }
    }
    let (low, high) = within(enough);
    0.5 * low + 0.5 * high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(center: DVec3, radius: f64) -> Extent {
        (center - radius, center + radius)
    }

    #[test]
    fn things_of_like_sizes_lie_around_the_middle_of_their_box() {
        let boxes = [ball(DVec3::ZERO, 1.0), ball(DVec3::new(100.0, 0.0, 3.0), 0.1)];
        let off = middle(&boxes, None).unwrap() - DVec3::new(49.55, 0.0, 1.05);
        assert!(off.length() < 1e-12, "{off}");
        assert_eq!(middle(&[], Some((DVec3::ONE, 1.0))), None);
    }

    #[test]
    fn small_things_on_a_huge_one_lie_around_themselves() {
        let floor = ball(DVec3::new(0.0, -1e5, 0.0), 1e5);
        let boxes = [floor, ball(DVec3::new(2.0, 0.5, 0.0), 0.5), ball(DVec3::new(-2.0, 0.5, 0.0), 0.25)];
        let found = middle(&boxes, None).unwrap();
        // Four times 0.5/0.75 from the larger ball.
        assert!((found.x - (2.0 - 4.0 / 1.5)).abs() < 1e-9 && (found.y - 0.5).abs() < 1.0, "{found}");
        assert!((middle(&[floor], Some((DVec3::Y, 1.0))).unwrap().y).abs() < 2.0);
        assert_eq!(middle(&[floor], None), Some(DVec3::Y * -1e5));
    }
}
