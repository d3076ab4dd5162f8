"""Loading of scenes, their errors and plans."""

import pickle

import pytest

import caustica


def test_files_and_strings_give_one_scene(text, tmp_path):
    (tmp_path / "a.txt").write_text(text)
    file, string = caustica.load_file(tmp_path / "a.txt"), caustica.load_string(text)
    assert file.text == string.text
    assert (file.size, file.triangles, file.shapes, file.lights) == ((48, 32), 0, 3, 1)
    assert caustica.load_string(file.text).text == file.text
    (tmp_path / "b.scene").write_text(text)
    assert caustica.load_file(str(tmp_path / "b.scene"), format="txt").text == file.text


def test_scene_errors_name_place_and_remedy(text):
    with pytest.raises(caustica.SceneError) as caught:
        caustica.load_string(text.replace("Sphere", "Spere"), name="ball.txt")
    error = caught.value
    assert (error.file, error.line, error.column) == ("ball.txt", 5, 82)
    assert "Spere" in error.message and error.remedy == "did you mean `Sphere`?"
    assert str(error) == f"ball.txt:5:82: {error.message}; {error.remedy}"
    assert isinstance(error, ValueError)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_all_errors_of_a_scene_are_listed(text):
    with pytest.raises(caustica.SceneError) as caught:
        caustica.load_string(text.replace("Sphere", "Spere").replace("Diffuse", "Difuse"))
    # The material that is missing is the second error of line 5.
    first, further = caught.value, caught.value.further
    assert first.line == 4 and [error.line for error in further] == [5, 5]
    assert str(further[0]) in str(first)


def test_files_that_cannot_be_read_are_named(text, tmp_path):
    with pytest.raises(FileNotFoundError, match="none.txt"):
        caustica.load_file(tmp_path / "none.txt")
    with pytest.raises(ValueError, match="txt"):
        caustica.load_file(tmp_path / "none.txt", format="blend")
    named = text.replace("Sphere { center 0 1 0 radius 1 }", "TriangleMesh { file none.obj }")
    with pytest.raises(caustica.SceneError, match="none.obj"):
        caustica.load_string(named, folder=tmp_path)
    (tmp_path / "bytes.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(caustica.SceneError, match="UTF-16"):
        caustica.load_file(tmp_path / "bytes.txt")


def test_another_size_reads_no_file_again(text, tmp_path):
    (tmp_path / "triangle.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    mesh = text.replace("Plane {", "TriangleMesh { obj_file triangle.obj }  Plane {")
    (tmp_path / "a.txt").write_text(mesh)
    scene = caustica.load_file(tmp_path / "a.txt")
    (tmp_path / "triangle.obj").unlink()
    assert scene.render("path", passes=1, size=(8, 6)).image.shape == (6, 8, 3)
    assert (scene.size, scene.triangles) == ((48, 32), 1)


def test_scenes_beyond_the_memory_are_refused(text, tmp_path):
    (tmp_path / "a.txt").write_text(text + " " * 1000)
    with pytest.raises(MemoryError, match="memory"):
        caustica.load_file(tmp_path / "a.txt", memory=1)


def test_plans_give_reasons(scene):
    plan = scene.plan()
    assert "caustics" in plan.simulated and plan["caustics"].is_needed
    assert not plan["media"].is_simulated and plan["media"].reason == "the scene has no media"
    assert not scene.plan("whitted")["caustics"].is_simulated
    assert not scene.plan(effects="auto,-caustics")["caustics"].is_simulated
    assert "- media: the scene has no media" in str(plan)
    with pytest.raises(KeyError, match="caustics"):
        plan["magic"]
    with pytest.raises(ValueError, match="hybrid"):
        scene.plan("magic")


def test_warnings_name_unused_materials(text):
    unused = text.replace("Materials {", "Materials { Mirror spare { }")
    assert any("spare" in line for line in caustica.load_string(unused).warnings)
    assert caustica.load_string(text).warnings == []


def test_integrators_are_those_of_the_program():
    assert caustica.INTEGRATORS[0] == "hybrid" and len(caustica.INTEGRATORS) == 8
