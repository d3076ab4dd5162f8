"""Scenes, and the program that renders the references."""

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

TEXT = """PerspectiveCamera { center 0 2 6  lookAt 0 1 0  angle 35  width 48  height 32 }
Background { color 0 0 0 }
Lights { RectangleLight { corner -1 5 -1  edge0 2 0 0  edge1 0 0 2  power 60 60 60 } }
Materials { Diffuse floor { reflectance .7 .7 .7 }  Dielectric glass { indexOfRefraction 1.5 } }
Group { MaterialName floor  Plane { normal 0 1 0 offset 0 }  MaterialName glass  Sphere { center 0 1 0 radius 1 } }
"""


@pytest.fixture
def text():
    """A glass ball above a floor, in the scene language."""
    return TEXT


@pytest.fixture(scope="session")
def scene():
    """A glass ball above a floor."""
    import caustica

    return caustica.load_string(TEXT)


@pytest.fixture(scope="session")
def program():
    """The program `caustica`: that of CAUSTICA_PROGRAM, or a build of this repository."""
    named = os.environ.get("CAUSTICA_PROGRAM")
    if named:
        assert shutil.which(named), f"CAUSTICA_PROGRAM names {named}, which is no program"
        return str(Path(shutil.which(named)).resolve())
    built = [ROOT / "target" / profile / "caustica" for profile in ("release", "debug")]
    for path in built:
        if path.is_file():
            return str(path)
    pytest.skip("no program is built: run cargo build --release, or set CAUSTICA_PROGRAM")
