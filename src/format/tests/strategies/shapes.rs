//! Generators of random shapes for property tests.

use glam::{DVec3, DVec4};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

use super::values::*;
use crate::format::description::*;

pub fn random_shape() -> impl Strategy<Value = ShapeDescription> {
    prop_oneof![
        (random_point(), random_positive())
            .prop_map(|(center, radius)| ShapeDescription::Sphere(SphereDescription { center, radius })),
        (random_direction(), random_finite_number())
            .prop_map(|(normal, offset)| ShapeDescription::Plane(PlaneDescription { normal, offset })),
        (random_point(), random_direction(), random_positive())
            .prop_map(|(center, normal, radius)| ShapeDescription::Disc(DiscDescription { center, normal, radius })),
        random_corner_and_edges().prop_map(|(corner, edge0, edge1)| ShapeDescription::Rectangle(
            RectangleDescription { corner, edge0, edge1 }
        )),
        (random_point(), [random_positive(), random_positive(), random_positive()]).prop_filter_map(
            "no extent",
            |(min, size)| {
                let max = min + DVec3::from_array(size);
                (max.is_finite() && max.cmpgt(min).all()).then_some(ShapeDescription::Box(BoxDescription { min, max }))
            }
        ),
        ([random_point(), random_point()], random_positive(), any::<bool>()).prop_filter_map(
            "no length",
            |(ends, radius, is_capped)| {
                (ends[0] != ends[1]).then_some(ShapeDescription::Cylinder(CylinderDescription {
                    ends,
                    radius,
                    is_capped,
                }))
            }
        ),
        ([random_point(), random_point()], random_positive(), option::of(random_positive()), any::<bool>())
            .prop_filter_map("no length", |(ends, radius, top, is_capped)| {
                let radii = [radius, top.unwrap_or(0.0)];
                (ends[0] != ends[1]).then_some(ShapeDescription::Cone(ConeDescription { ends, radii, is_capped }))
            }),
        (
            [random_point(), random_point(), random_point()],
            option::of([random_direction(), random_direction(), random_direction()]),
            option::of([random_vec2(), random_vec2(), random_vec2()].prop_map(Box::new))
        )
            .prop_map(|(vertices, normals, texcoords)| ShapeDescription::Triangle(TriangleDescription {
                vertices,
                normals,
                texcoords
            })),
        (random_mesh_path(), any::<bool>(), any::<bool>(), option::of(0.0..=180.0)).prop_map(
            |(path, uses_file_materials, ignores_normals, max_smoothing_angle)| {
                let options = MeshOptions { uses_file_materials, ignores_normals, max_smoothing_angle };
                ShapeDescription::Mesh(MeshDescription { path: with_empty_span(path), options })
            }
        ),
        random_curve().prop_map(|profile| ShapeDescription::Revolution(RevolutionDescription { profile })),
        vec(random_point(), 4..7).prop_map(|controls| BezierCurveDescription { controls }.into()),
        vec(random_point(), 4..7).prop_map(|controls| BsplineCurveDescription { controls }.into()),
        (vec(random_weighted_point(), 8), any::<bool>()).prop_map(|(controls, once)| {
            if once {
                ShapeDescription::Patches(BezierPatchesDescription { degree: [3, 1], controls })
            } else {
                ShapeDescription::Patches(BezierPatchesDescription { degree: [1, 1], controls })
            }
        }),
        (vec(random_weighted_point(), 12), option::of(random_knots(6)), option::of(random_knots(6))).prop_map(
            |(controls, u, v)| {
                let knots = [u.unwrap_or_default(), v.unwrap_or_default()];
                ShapeDescription::Nurbs(NurbsDescription { degree: [2, 1], control_counts: [3, 4], knots, controls })
            }
        ),
    ]
}

fn random_mesh_path() -> impl Strategy<Value = String> {
    (random_name(), any::<bool>()).prop_map(|(name, ply)| if ply { name + ".ply" } else { name })
}

fn random_curve() -> impl Strategy<Value = ProfileCurve> {
    (vec(random_point(), 4..7), any::<bool>()).prop_map(|(controls, bezier)| {
        let basis = if bezier { CurveBasis::Bezier } else { CurveBasis::Bspline };
        ProfileCurve { basis, controls }
    })
}

fn random_weighted_point() -> impl Strategy<Value = DVec4> {
    (random_point(), prop_oneof![Just(1.0), random_positive()])
        .prop_filter_map("no weight", |(p, w)| (w > 0.0).then(|| p.extend(w)))
}

fn random_knots(count: usize) -> impl Strategy<Value = Vec<f64>> {
    vec(random_finite_number(), count).prop_map(|mut knots| {
        knots.sort_by(f64::total_cmp);
        knots
    })
}
