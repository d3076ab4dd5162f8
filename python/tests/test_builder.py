"""Scenes built in Python."""

import doctest
import inspect
from pathlib import Path

import numpy as np
import pytest

import caustica
from caustica import _builder

TETRAHEDRON = (
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
)


def builder_with_camera(size=(24, 16)):
    builder = caustica.Scene.build()
    builder.camera(center=(0, 2, 6), look_at=(0, 1, 0), angle=35, size=size)
    return builder


def test_a_built_scene_equals_its_text(text):
    builder = caustica.Scene.build()
    builder.camera(center=(0, 2, 6), look_at=(0, 1, 0), angle=35, size=(48, 32))
    builder.rectangle_light((-1, 5, -1), (2, 0, 0), (0, 0, 2), power=60)
    builder.plane(builder.diffuse(0.7), (0, 1, 0))
    builder.sphere(builder.dielectric(1.5), center=np.array([0, 1, 0]), radius=1)
    built = builder.build().render(passes=2).image
    read = caustica.load_string(text).render(passes=2).image
    np.testing.assert_array_equal(built.view(np.uint32), read.view(np.uint32))


def test_meshes_from_arrays_equal_those_of_files(tmp_path):
    vertices, triangles = TETRAHEDRON
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    (tmp_path / "t.obj").write_text("\n".join(lines))

    def image(add):
        builder = builder_with_camera()
        builder.point_light((2, 4, 3), power=100)
        add(builder, builder.phong((0.5, 0.2, 0.1), 0.3, 20))
        return builder.build(folder=tmp_path).render("path", passes=2).image

    arrays = image(lambda b, m: b.mesh(m, vertices, triangles, smooth_angle=30))
    file = image(lambda b, m: b.mesh_file(m, "t.obj", smooth_angle=30))
    assert arrays.max() > 0
    np.testing.assert_array_equal(arrays.view(np.uint32), file.view(np.uint32))


def test_an_emitter_fills_the_view_with_its_radiance():
    builder = builder_with_camera()
    builder.rectangle(builder.diffuse(0.0), (-50, -50, -5), (100, 0, 0), (0, 100, 0), emission=(1, 2, 3))
    image = builder.build().render("path", passes=1).image
    np.testing.assert_allclose(image, np.broadcast_to(np.float32([1, 2, 3]), image.shape), rtol=1e-6)


def test_every_part_builds_a_scene(tmp_path):
    builder = builder_with_camera()
    builder.background(0.1)
    builder.point_light((0, 5, 0), intensity=(1, 2, 3))
    builder.directional_light((0, -1, 0), irradiance=1)
    builder.spot_light((0, 5, 0), angle=30, look_at=(0, 0, 0), penumbra=5, power=10)
    builder.sphere_light((0, 6, 0), 0.1, power=10)
    builder.disc_light((0, 6, 1), (0, -1, 0), 0.1, radiance=10)
    builder.environment_light(0.2)
    textures = [builder.checker_texture(0.1, 0.9, scale=(2, 2))]
    textures += [builder.noise_texture(0.1, 0.9, kind=kind) for kind in ("noise", "marble", "wood")]
    fog = builder.medium(scattering=0.1, absorption=0.01, anisotropy=0.5)
    floor = builder.diffuse(textures[0])
    materials = [builder.phong(textures[1], 0.1, 10), builder.mirror(0.9), builder.dielectric(glass="BK7")]
    materials += [builder.dielectric(1.3, medium=fog, priority=1, roughness=0.1), builder.clear(medium=fog)]
    materials += [builder.conductor("gold", roughness=0.2), builder.conductor(eta=1.0, k=2.0), builder.thin()]
    materials += [builder.mix(floor, builder.diffuse(0.1, emission=1), 0.3)]
    builder.plane(floor, (0, 1, 0), offset=-1)
    for i, material in enumerate(materials):
        builder.sphere(material, (3 * i, 0, 0), 1)
    builder.disc(floor, (0, 0, 9), (0, 0, 1), 1)
    builder.rectangle(floor, (0, 0, 12), (1, 0, 0), (0, 1, 0))
    builder.box(floor, (0, 0, 14), (1, 1, 15))
    builder.cylinder(floor, (0, 0, 20), (0, 1, 20), 0.5, caps=False)
    builder.cone(floor, (0, 0, 24), (0, 1, 24), 0.5, 0.1)
    builder.triangle(floor, (0, 0, 28), (1, 0, 28), (0, 1, 28))
    builder.mesh(floor, *TETRAHEDRON, normals=-np.ones((4, 3)), uv=np.zeros((4, 2)))
    builder.objects("BsplineCurve { controls [ 0 0 0 ] [ 1 0 0 ] [ 1 1 0 ] [ 0 1 0 ] }")
    with builder.moving(translate=(1, 0, 0)):
        builder.sphere(floor, (0, 0, 40), 1)
    scene = builder.build()
    assert (scene.triangles, scene.lights) == (5, 6)
    assert np.isfinite(scene.render(passes=1).image).all()


def test_cameras_of_all_kinds_render():
    for name, more in [
        ("camera", {"direction": (0, 0, -1), "aperture": 0.1, "focus_distance": 4, "blades": 5}),
        ("orthographic_camera", {"look_at": (0, 0, 0), "height": 4}),
        ("environment_camera", {}),
    ]:
        builder = caustica.Scene.build()
        getattr(builder, name)(center=(0, 0, 5), size=(8, 4), **more)
        builder.background(2)
        np.testing.assert_array_equal(builder.build().render("path", passes=1).image, 2)


def test_transforms_equal_shapes_in_place():
    angle = np.radians(90)
    turn = np.array([[np.cos(angle), 0, np.sin(angle), 1], [0, 1, 0, 2], [-np.sin(angle), 0, np.cos(angle), 0]])
    turn = np.vstack([turn, [0, 0, 0, 1]])

    def image(**maps):
        builder = builder_with_camera()
        builder.point_light((2, 4, 3), power=100)
        with builder.transform(**maps):
            builder.box(builder.diffuse(0.5), (0, -1, 0), (1, 0, 0.5))
        return builder.build().render("path", passes=1).image

    by_matrix, by_maps = image(matrix=turn), image(translate=(1, 2, 0), rotate=((0, 1, 0), 90))
    assert by_matrix.max() > 0
    np.testing.assert_allclose(by_matrix, by_maps, atol=1e-3 * by_maps.max())


def test_errors_name_the_line_of_the_call():
    builder = builder_with_camera()
    white = builder.diffuse(0.5)
    builder.sphere(white, (0, 0, 0), -1); line = inspect.currentframe().f_lineno  # fmt: skip # noqa: E702
    with pytest.raises(caustica.SceneError, match="radius") as caught:
        builder.build()
    assert (Path(caught.value.file).name, caught.value.line) == ("test_builder.py", line)
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("call", "kind", "match"),
    [
        (lambda b, m: b.mesh(m, np.zeros((3, 2)), [[0, 1, 2]]), ValueError, r"vertices has shape \(3, 2\)"),
        (lambda b, m: b.mesh(m, np.zeros((3, 3)), [[0, 1, 3]]), ValueError, "from 0 to 2"),
        (lambda b, m: b.mesh(m, np.zeros((3, 3)), [[0, 1, -1]]), ValueError, "from 0 to 2"),
        (lambda b, m: b.mesh(m, np.zeros((3, 3)), [[0, 1, 2.5]]), TypeError, "whole numbers"),
        (lambda b, m: b.mesh(m, np.zeros((3, 3)), np.zeros((0, 3), int)), ValueError, "at least one"),
        (lambda b, m: b.mesh(m, np.full((3, 3), np.nan), [[0, 1, 2]]), ValueError, "finite"),
        (lambda b, m: b.mesh(m, np.eye(3), [[0, 1, 2]], uv=np.zeros((2, 2))), ValueError, "2 rows"),
        (lambda b, m: b.sphere("white", (0, 0, 0), 1), TypeError, "material"),
        (lambda b, m: b.sphere(caustica.Scene.build().diffuse(1), (0, 0, 0), 1), ValueError, "another builder"),
        (lambda b, m: b.mesh_file(m, "a\nb.obj"), ValueError, "line break"),
        (lambda b, m: b.noise_texture(kind="x"), ValueError, "marble"),
        (lambda b, m: b.diffuse(float("inf")), caustica.SceneError, "inf"),
        (lambda b, m: b.diffuse(2.0), caustica.SceneError, "reflectance"),
        (lambda b, m: b.conductor('"} Sphere {'), caustica.SceneError, "metal"),
        (lambda b, m: b.objects("} }"), caustica.SceneError, "test_builder"),
    ],
)
def test_wrong_values_are_errors(call, kind, match):
    builder = builder_with_camera()
    with pytest.raises(kind, match=match):
        call(builder, builder.diffuse(0.5))
        builder.build()


def test_a_scene_needs_a_camera():
    with pytest.raises(caustica.SceneError, match="camera"):
        caustica.Scene.build().build()


def test_examples_in_docstrings_hold():
    assert doctest.testmod(_builder).attempted > 5
    assert doctest.testmod(_builder).failed == 0
