"""The package: its types, its locked dependencies, its guide and its example."""

import re
import runpy
import subprocess
import sys
from importlib import resources
from pathlib import Path

import exr
import numpy as np
import pytest

import caustica

ROOT = Path(__file__).resolve().parents[2]


def locked(path):
    """Returns the versions of each package in a lock file."""
    versions = {}
    for name, version in re.findall(r'name = "(.*)"\nversion = "(.*)"', path.read_text()):
        versions.setdefault(name, set()).add(version)
    return versions


def test_locked_dependencies_are_those_of_the_program():
    program, wheel = locked(ROOT / "Cargo.lock"), locked(ROOT / "python" / "Cargo.lock")
    differing = {
        name for name in wheel.keys() & program.keys() if not wheel[name] <= program[name] and name not in {"syn"}
    }
    remedy = "copy Cargo.lock to python/ and run cargo metadata --manifest-path python/Cargo.toml"
    assert not differing, f"{sorted(differing)} differ from Cargo.lock: {remedy}"


def test_types_are_shipped():
    for name in ("py.typed", "_native.pyi"):
        assert resources.files("caustica").joinpath(name).is_file()


def test_public_names_have_docstrings():
    for name in caustica.__all__:
        item = getattr(caustica, name)
        if isinstance(item, type):
            members = [member for key, member in vars(item).items() if not key.startswith("_")]
            documented = [m for m in members if callable(m) or isinstance(m, (property, staticmethod))]
            assert item.__doc__ and all(m.__doc__ for m in documented), name
        elif callable(item):
            assert item.__doc__, name


def python_blocks(page):
    return re.findall(r"```python\n(.*?)```", page.read_text(), re.S)


@pytest.mark.parametrize("page", ["README.md", "docs/guide/python.md", "python/README.md"])
def test_documented_code_runs(page, tmp_path, monkeypatch):
    blocks = python_blocks(ROOT / page)
    assert blocks
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    # Renders of the documentation are made small: the first limit ends them.
    render = caustica.Scene.render

    def small(scene, integrator="hybrid", **options):
        passes = min(options.pop("passes", 5), 5)
        return render(scene, integrator, **{**options, "size": (32, 24), "passes": passes, "time": 20})

    monkeypatch.setattr(caustica.Scene, "render", small)
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)


def test_the_readme_gives_the_bits_of_the_program(program, tmp_path, monkeypatch):
    # Its lines run as they are, except that the picture is small.
    size = (64, 48)
    render = caustica.Scene.render
    monkeypatch.setattr(caustica.Scene, "render", lambda *given, **options: render(*given, **options, size=size))
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    names = {}
    (block,) = python_blocks(ROOT / "README.md")
    exec(compile(block, "README.md", "exec"), names)
    limits = ["--target-error", "3%", "--time", "300s", "--size", "64x48"]
    line = [program, "render", "scenes/ring.txt", "-o", "x.exr", "-q", *limits]
    subprocess.run(line, cwd=tmp_path, check=True, timeout=400)
    theirs, ours = exr.read(tmp_path / "x.exr"), names["result"].image
    for i, channel in enumerate("RGB"):
        np.testing.assert_array_equal(ours[..., i].view(np.uint32), theirs[channel].view(np.uint32))
    assert names["result"].ended == "target" and (tmp_path / "ring.png").is_file()


def test_the_example_plots_error_against_time(tmp_path):
    pytest.importorskip("matplotlib")
    example = ROOT / "python" / "examples" / "error_against_time.py"
    output = tmp_path / "error.png"
    line = [sys.executable, str(example), "--time", "3", "--size", "48x32", "-o", str(output)]
    subprocess.run(line, check=True, timeout=300, cwd=ROOT)
    assert output.read_bytes()[:4] == b"\x89PNG"
    assert runpy.run_path(str(example))["main"]


@pytest.mark.parametrize("flags", [[], ["--keep-caustics"]])
def test_the_example_denoises(flags, tmp_path):
    pytest.importorskip("pyoidn")
    example = ROOT / "python" / "examples" / "denoise.py"
    output = tmp_path / "denoised.npy"
    line = [sys.executable, str(example), "--passes", "2", "--size", "64x48", *flags, "-o", str(output)]
    run = subprocess.run(line, check=True, timeout=300, cwd=ROOT, capture_output=True, text=True)
    assert "before denoising" in run.stdout
    denoised = np.load(output)
    scene = caustica.load_file(ROOT / "scenes" / "glass-ball.txt")
    few = scene.render(passes=2, size=(64, 48))
    reference = scene.render(passes=60, size=(64, 48), seed=1).image
    # The denoised picture is nearer to the reference where noise dominates: in the square root,
    # which weighs dark and bright pixels alike.
    def error(image):
        return np.mean((np.sqrt(np.maximum(image, 0)) - np.sqrt(reference)) ** 2)

    assert denoised.dtype == np.float32 and error(denoised) < error(few.image)
