//! Parses the transforms of a Mitsuba scene file.

use super::color::parse_numbers;
use super::files::{MitsubaSourceLocation, ReadResult};
use glam::{DMat3, DMat4, DVec3};
use std::collections::HashMap;

/// XML element inside a transform, such as `translate`: its name, attributes and position.
pub(super) type TransformElement = (String, HashMap<String, String>, MitsubaSourceLocation);

/// Returns the matrix of a transform, the product of its elements. The first element applies first.
///
/// # Errors
/// If an element is not known or has invalid attributes. Also if the product is not affine.
pub(super) fn parse_transform(elements: &[TransformElement]) -> ReadResult<DMat4> {
    let mut product = DMat4::IDENTITY;
    for (tag, attributes, place) in elements {
        product = element_matrix(tag, attributes, place)? * product;
    }
    if let Some((_, _, place)) = elements.last()
        && !(product.is_finite() && product.row(3).truncate() == DVec3::ZERO && product.w_axis.w == 1.0)
    {
        return Err(place.error("this transform is not affine or not finite", "correct its numbers"));
    }
    Ok(product)
}

/// Parses a vector from the attribute `value`, or else from `x`, `y` and `z`.
///
/// A single number in `value` stands for all three components. `default` replaces each of `x`, `y`
/// and `z` that is missing.
pub(super) fn parse_vector(
    attributes: HashMap<String, String>,
    default: f64,
    place: &MitsubaSourceLocation,
) -> ReadResult<DVec3> {
    let invalid = || place.error("this is not a vector", "write `value=\"x, y, z\"` or the attributes x, y and z");
    if let Some(text) = attributes.get("value") {
        return match *parse_numbers(text).ok_or_else(invalid)? {
            [all] => Ok(DVec3::splat(all)),
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(invalid()),
        };
    }
    let mut vector = DVec3::splat(default);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if let Some(text) = attributes.get(name) {
            vector[axis] = match *parse_numbers(text).ok_or_else(invalid)? {
                [number] => number,
                _ => return Err(invalid()),
            };
        }
    }
    Ok(vector)
}

/// Returns the matrix of one element, such as `translate`.
fn element_matrix(tag: &str, attributes: &HashMap<String, String>, place: &MitsubaSourceLocation) -> ReadResult<DMat4> {
    let vector = |default: f64| parse_vector(attributes.clone(), default, place);
    Ok(match tag {
        "translate" => DMat4::from_translation(vector(0.0)?),
        "scale" => DMat4::from_scale(vector(1.0)?),
        "rotate" => {
            let angle = attributes.get("angle").and_then(|text| parse_numbers(text));
            match (angle.as_deref(), vector(0.0)?.try_normalize()) {
                (Some([angle]), Some(axis)) => DMat4::from_mat3(crate::math::rotation_matrix_degrees(axis, *angle)),
                _ => return Err(place.error("this rotation has no axis or no angle", "write an axis and an `angle`")),
            }
        }
        "lookat" => look_at_to_world(attributes, place)?,
        "matrix" => {
            let numbers = attributes.get("value").and_then(|text| parse_numbers(text)).unwrap_or_default();
            if let Ok(rows) = <[f64; 16]>::try_from(numbers.as_slice()) {
                DMat4::from_cols_array(&rows).transpose()
            } else if let Ok(rows) = <[f64; 9]>::try_from(numbers.as_slice()) {
                DMat4::from_mat3(DMat3::from_cols_array(&rows).transpose())
            } else {
                return Err(place.error("a matrix has 16 numbers", "write 16 numbers, row by row"));
            }
        }
        _ => {
            let help = "use `translate`, `scale`, `rotate`, `lookat` or `matrix`";
            return Err(place.error(format!("`{tag}` is no part of a transform"), help));
        }
    })
}

/// Returns the camera-to-world matrix of a `lookat` element.
///
/// The camera looks along +z of its own frame, with +y up and +x to the left. Without `up`, the
/// rotation about the view direction is arbitrary.
fn look_at_to_world(attributes: &HashMap<String, String>, place: &MitsubaSourceLocation) -> ReadResult<DMat4> {
    let point = |name: &str| match *attributes.get(name).and_then(|text| parse_numbers(text)).unwrap_or_default() {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    };
    let (Some(origin), Some(target)) = (point("origin"), point("target")) else {
        return Err(place.error("`lookat` needs an `origin` and a `target`", "write both as `x, y, z`"));
    };
    let same = || place.error("origin and target of `lookat` are the same point", "choose another target");
    let direction = (target - origin).try_normalize().ok_or_else(same)?;
    let up = point("up").filter(|up| *up != DVec3::ZERO).unwrap_or_else(|| direction.any_orthogonal_vector());
    let parallel = || place.error("the view of `lookat` is parallel to `up`", "choose another `up`");
    let left = up.cross(direction).try_normalize().ok_or_else(parallel)?;
    let up = direction.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), direction.extend(0.0), origin.extend(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::SourceText;
    use crate::format::description::Span;

    fn transform_element(tag: &str, attributes: &[(&str, &str)]) -> TransformElement {
        let place = MitsubaSourceLocation { source: SourceText::new("a.xml", ""), span: Span::default(), line: 1 };
        let attributes = attributes.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        (tag.to_owned(), attributes.collect(), place)
    }

    #[test]
    fn elements_apply_in_the_order_of_the_file() {
        let elements = [
            transform_element("scale", &[("value", "2")]),
            transform_element("rotate", &[("z", "1"), ("angle", "90")]),
            transform_element("translate", &[("x", "1")]),
            transform_element("matrix", &[("value", "1 0 0 0  0 1 0 5  0 0 1 0  0 0 0 1")]),
        ];
        let moved = parse_transform(&elements).unwrap().transform_point3(DVec3::X);
        assert!((moved - DVec3::new(1.0, 7.0, 0.0)).length() < 1e-12, "{moved}");
        assert!(parse_transform(&[transform_element("shear", &[])]).is_err());
        assert!(parse_transform(&[transform_element("matrix", &[("value", "1 2 3")])]).is_err());
    }

    #[test]
    fn views_look_along_z_with_x_left() {
        let attributes = [("origin", "0, 0, 5"), ("target", "0 0 0"), ("up", "0, 1, 0")];
        let view = parse_transform(&[transform_element("lookat", &attributes)]).unwrap();
        assert_eq!(view.transform_vector3(DVec3::Z), DVec3::NEG_Z);
        assert_eq!(view.transform_vector3(DVec3::Y), DVec3::Y);
        assert_eq!(view.transform_vector3(DVec3::X), DVec3::NEG_X);
        assert_eq!(view.transform_point3(DVec3::ZERO), DVec3::new(0.0, 0.0, 5.0));
    }
}
