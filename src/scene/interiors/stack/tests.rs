//! Tests of the stack of dielectric bodies that contain a path vertex.

use super::*;

fn water_ice_glass_materials() -> Vec<Material> {
    let body = |eta, priority| Material::smooth_boundary(Body { priority, ..Body::new(eta) });
    // Three materials: water, ice and glass.
    vec![body(1.33, 0), body(1.31, 1), body(1.5, 2)]
}

fn body_of_material(i: usize) -> Body {
    *water_ice_glass_materials()[i].enclosed_body().unwrap()
}

fn interior_stack_of_materials(bodies: &[u32]) -> InteriorStack {
    let mut inside = InteriorStack::EMPTY;
    bodies.iter().for_each(|b| inside.push_body(*b));
    inside
}

#[test]
fn the_highest_priority_wins_in_any_entry_order() {
    let m = water_ice_glass_materials();
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        assert_eq!(interior_stack_of_materials(&order).dominant_body(&m).unwrap().0, 2);
    }
    assert!(
        interior_stack_of_materials(&[2]).interface_at_boundary(0, &body_of_material(0), true, &m).is_hidden,
        "water begins inside the glass"
    );
    assert!(interior_stack_of_materials(&[2, 0]).interface_at_boundary(0, &body_of_material(0), false, &m).is_hidden);
    let out = interior_stack_of_materials(&[2, 0]).interface_at_boundary(2, &body_of_material(2), false, &m);
    assert_eq!(
        out,
        BodyInterface { is_hidden: false, outside: Some(body_of_material(0)) },
        "glass to the water that began inside it"
    );
    assert_eq!(out.relative_eta(&body_of_material(2), |b| b.eta), 1.5 / 1.33);
}

/// The interface that a path meets when it enters a dielectric body equals the one that it meets
/// when it leaves.
#[test]
fn a_boundary_has_one_interface_from_both_sides() {
    let m = water_ice_glass_materials();
    for around in [&[][..], &[0], &[1], &[2], &[0, 1], &[0, 2], &[0, 1, 2]] {
        for material in 0..3u32 {
            if around.contains(&material) {
                continue;
            }
            let outside = interior_stack_of_materials(around);
            let inwards = outside.interface_at_boundary(material, &body_of_material(material as usize), true, &m);
            let mut within = outside;
            within.push_body(material);
            assert_eq!(
                inwards,
                within.interface_at_boundary(material, &body_of_material(material as usize), false, &m)
            );
        }
    }
}

#[test]
fn equal_priorities_let_the_last_entered_body_win() {
    let mut m = water_ice_glass_materials();
    for material in &mut m {
        *material = material.with_body(Body { priority: 0, ..*material.enclosed_body().unwrap() });
    }
    assert_eq!(interior_stack_of_materials(&[2, 0]).dominant_body(&m).unwrap().0, 0, "the last one entered counts");
    let glass = Body { priority: 0, ..body_of_material(2) };
    let crossing = interior_stack_of_materials(&[2]).interface_at_boundary(2, &glass, true, &m);
    assert_eq!(crossing.relative_eta(&glass, |b| b.eta), 1.0, "glass in the same glass is no boundary");
}

#[test]
fn null_interfaces_yield_and_do_not_refract() {
    let mut m = water_ice_glass_materials();
    m.push(Material::smooth_boundary(Body::null_interface_with_medium(0)));
    m.push(Material::smooth_boundary(Body { priority: 9, ..Body::null_interface_with_medium(1) }));
    assert_eq!(
        interior_stack_of_materials(&[0, 3]).dominant_body(&m).unwrap().0,
        0,
        "the body that refracts wins among equals"
    );
    assert_eq!(interior_stack_of_materials(&[3]).dominant_body(&m).unwrap().0, 3);
    assert_eq!(interior_stack_of_materials(&[2, 4]).dominant_body(&m).unwrap().0, 4, "smoke that displaces glass");
    assert_eq!(
        interior_stack_of_materials(&[2, 4]).dominant_refracting_body(&m).unwrap().0,
        2,
        "but the glass bends light"
    );
    let into = interior_stack_of_materials(&[4]).interface_at_boundary(2, &body_of_material(2), true, &m);
    assert_eq!(into, BodyInterface { is_hidden: false, outside: None });
}

#[test]
fn a_full_stack_drops_the_outermost_body() {
    let mut deep = interior_stack_of_materials(&[0; MAX_BODIES]);
    deep.push_body(2);
    assert_eq!((deep.body_materials().len(), deep.body_materials().last()), (MAX_BODIES, Some(&2)));
    deep.remove_body(2);
    deep.remove_body(7);
    assert_eq!(deep.body_materials(), &[0; MAX_BODIES - 1]);
}
