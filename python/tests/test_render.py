"""Renders: the bits of the program, errors of pictures, limits, callbacks and interrupts."""

import _thread
import json
import subprocess
import threading
import time

import exr
import numpy as np
import pytest

import caustica

FLAGS = {"hybrid": {}, "sppm": {"photons": 20000}, "path": {"spp": 2, "filter": "box"}, "raycast": {}}


def words(options):
    return [word for name, value in options.items() for word in (f"--{name.replace('_', '-')}", str(value))]


@pytest.mark.parametrize("integrator", FLAGS)
def test_pictures_equal_those_of_the_program(integrator, text, program, tmp_path):
    (tmp_path / "ball.txt").write_text(text)
    options = {"passes": 1 if integrator == "raycast" else 5, "seed": 7, **FLAGS[integrator]}
    groups = [] if integrator == "raycast" else ["--light-groups"]
    aov = ["--aov", "layers.exr", *groups]
    line = ["render", "ball.txt", "-o", "x.exr", "--integrator", integrator, "--size", "40x30", "-q", *aov]
    subprocess.run([program, *line, *words(options)], cwd=tmp_path, check=True, timeout=300)
    scene = caustica.load_file(tmp_path / "ball.txt")
    result = scene.render(
        integrator, size=(40, 30), threads=3, aovs=True, light_groups=bool(groups), **options
    )
    theirs = exr.read(tmp_path / "x.exr")
    ours = result.image
    assert (ours.dtype, ours.shape) == (np.float32, (30, 40, 3))
    for i, channel in enumerate("RGB"):
        np.testing.assert_array_equal(ours[..., i].view(np.uint32), theirs[channel].view(np.uint32))
    assert ours.max() > 0
    check_layers(result.layers, exr.read(tmp_path / "layers.exr"))


def test_crop_and_clamp_equal_those_of_the_program(text, program, tmp_path):
    (tmp_path / "ball.txt").write_text(text)
    line = ["render", "ball.txt", "-o", "x.exr", "--passes", "5", "--crop", "5,3,37,30", "--clamp", "0.1", "-q"]
    subprocess.run([program, *line, "--aov", "layers.exr", "--stats", "x.json"], cwd=tmp_path, check=True, timeout=300)
    result = caustica.load_string(text).render(passes=5, crop=(5, 3, 37, 30), clamp=0.1, aovs=True)
    assert result.size == (32, 27) and result.image.shape == (27, 32, 3)
    check_layers(result.layers, exr.read(tmp_path / "layers.exr"))
    stats = json.loads((tmp_path / "x.json").read_text())
    assert result.clamped_fraction == stats["clamped_fraction"] > 0
    assert result.error.clamping == stats["error"]["clamping"] > 0
    parts = [result.error.blur, result.error.shared_paths, result.error.clamping]
    assert result.error.bias == pytest.approx(np.linalg.norm(parts))


def test_a_crop_has_the_bits_of_the_whole_picture(scene):
    whole, part = (scene.render("path", passes=1, crop=crop) for crop in (None, (7, 2, 30, 20)))
    np.testing.assert_array_equal(whole.image[2:20, 7:30], part.image)
    assert whole.clamped_fraction is None


def test_light_groups_add_up_to_the_picture(scene):
    layers = scene.render(passes=2, light_groups=True).layers
    total = layers["direct"] + layers["indirect"] + layers["caustic"]
    np.testing.assert_allclose(total, layers["image"], rtol=1e-5, atol=1e-6)
    assert layers["caustic"].max() > 0


def test_motion_has_two_channels(scene):
    layers = scene.render("path", passes=1, spp=1, aovs=True).layers
    assert layers["motion"].shape == (*layers["depth"].shape, 2) and not layers["motion"].any()


def check_layers(layers, channels):
    """Checks that the arrays hold exactly the channels of the file."""
    for name, values in layers.items():
        if values.ndim == 3:
            prefix = "" if name == "image" else f"{name}."
            letters = "XYZ" if name in ("normal", "position", "motion") else "RGB"
            ours = {prefix + channel: values[..., i] for i, channel in zip(range(values.shape[2]), letters)}
        else:
            letter = {"depth": ".Z", "object": ".X", "material": ".X"}.get(name, "")
            ours = {name + letter: values}
        for channel, array in ours.items():
            np.testing.assert_array_equal(array, channels.pop(channel))
    assert not channels


def test_saved_pictures_hold_the_image(scene, tmp_path):
    result = scene.render(passes=4, seed=1)
    result.save(tmp_path / "a.exr")
    result.save(tmp_path / "a.png", tone="filmic", exposure=1)
    result.save_layers(tmp_path / "layers.exr")
    saved = exr.read(tmp_path / "a.exr")
    np.testing.assert_array_equal(np.stack([saved[c] for c in "RGB"], axis=-1), result.image)
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert "noise.R" in exr.read(tmp_path / "layers.exr")
    with pytest.raises(ValueError, match="extension"):
        result.save(tmp_path / "a.jpg")
    with pytest.raises(OSError, match="folder"):
        result.save(tmp_path / "none" / "a.png")
    with pytest.raises(ValueError, match="tone"):
        result.save(tmp_path / "b.png", tone="sepia")


def test_errors_estimate_noise_bias_and_forecasts(scene):
    result = scene.render(passes=8, seed=2)
    error = result.error
    assert error.passes == result.passes == 8
    assert error.error == pytest.approx(np.hypot(error.noise, error.bias))
    assert error.bias == pytest.approx(np.hypot(error.blur, error.shared_paths))
    assert error.low <= error.error <= error.high and error.interval == (error.low, error.high)
    assert error.confidence == 0.9
    assert error.error_after(64) < error.error_after(8)
    far = error.forecast(error.high / 2)
    assert 8 < far.low <= far.median and far.floor is None
    narrow = result.error_with_confidence(0.5)
    assert error.low < narrow.low < narrow.high < error.high
    assert "noise" in str(error) and "8 passes" in repr(result)


def test_few_passes_have_no_error_estimate(scene):
    assert scene.render(passes=3).error is None
    assert scene.render(passes=5, estimate_error=False).error is None
    assert list(scene.render(passes=3).layers) == ["image"]


def test_limits_end_renders(scene):
    assert scene.render(passes=2).ended == "passes"
    assert scene.render(time=0.0).ended == "time"
    ended = scene.render(target_error=0.5, passes=1000)
    assert ended.ended == "target" and ended.error.high <= 0.5


def test_threads_change_no_bit(scene):
    one, three = (scene.render(passes=2, threads=n).image for n in (1, 3))
    np.testing.assert_array_equal(one.view(np.uint32), three.view(np.uint32))
    assert not np.array_equal(one, scene.render(passes=2, seed=1).image)


def test_callbacks_see_each_pass_and_stop(scene):
    seen = []

    def callback(progress):
        seen.append(progress)
        return progress.passes < 6

    result = caustica.render(scene, passes=1000, callback=callback)
    assert result.ended == "interrupted" and result.passes == 6
    assert [progress.passes for progress in seen] == [1, 2, 3, 4, 5, 6]
    assert seen[2].error is None and seen[5].error == result.error
    assert all(a.seconds <= b.seconds for a, b in zip(seen, seen[1:]))
    assert scene.render(passes=2, callback=lambda progress: None).passes == 2


def test_callback_exceptions_end_the_render(scene):
    with pytest.raises(ZeroDivisionError):
        scene.render(time=60, callback=lambda progress: 1 // 0)


def test_ctrl_c_abandons_the_pass(scene):
    # One pass takes minutes, so only a pass that is abandoned ends within the limit.
    timer = threading.Timer(1.0, _thread.interrupt_main)
    start = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        scene.render("path", spp=1_000_000, passes=1)
    assert 1 <= time.monotonic() - start < 15


def test_other_threads_run_meanwhile(scene):
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    scene.render("path", spp=200, passes=4, size=(160, 120))
    passed = counted[0] - before
    done.set()
    thread.join()
    assert passed > 20


@pytest.mark.parametrize(
    ("options", "kind", "match"),
    [
        ({"passes": 0}, ValueError, "passes is 0"),
        ({"passes": 2**40}, ValueError, "4294967295"),
        ({"passes": 1.5}, TypeError, "whole number"),
        ({"seed": -1}, ValueError, "seed is -1"),
        ({"size": (0, 10)}, ValueError, "width is 0"),
        ({"size": (65536, 65536)}, MemoryError, "size"),
        ({"time": float("nan")}, ValueError, "time"),
        ({"time": -1}, ValueError, "time"),
        ({"target_error": 0}, ValueError, "target_error"),
        ({"target_error": "2%"}, TypeError, "target_error"),
        ({"confidence": 1.0}, ValueError, "confidence"),
        ({"threads": 5000}, ValueError, "threads"),
        ({"gather_k": 1}, ValueError, "gather_k"),
        ({"alpha": 2}, ValueError, "alpha"),
        ({"integrator": "magic"}, ValueError, "hybrid, path"),
        ({"kernel": "x"}, ValueError, "kernel"),
        ({"filter": "x"}, ValueError, "filter"),
        ({"volume": "x"}, ValueError, "beams"),
        ({"effects": "+magic"}, ValueError, "magic"),
        ({"callback": 3}, TypeError, "callback"),
        ({"crop": (0, 0, 9)}, TypeError, "x0, y0, x1, y1"),
        ({"crop": (0, 0, 49, 9)}, ValueError, "x1 of crop is 49"),
        ({"crop": (9, 0, 9, 9)}, ValueError, "x1 of crop is 9"),
        ({"size": (8, 8), "crop": (0, 0, 9, 8)}, ValueError, "x1 of crop"),
        ({"clamp": 0}, ValueError, "clamp"),
        ({"clamp": "x"}, TypeError, "clamp"),
        ({"integrator": "raycast", "clamp": 1}, ValueError, "raycast"),
        ({"estimate_error": False, "target_error": 0.1}, ValueError, "estimate_error"),
    ],
)
def test_wrong_arguments_are_named(scene, options, kind, match):
    with pytest.raises(kind, match=match):
        scene.render(**options)
