"""Caustica: a photon-mapping renderer that estimates the error of its pictures.

>>> import caustica
>>> scene = caustica.load_file("scenes/ring.txt")                # doctest: +SKIP
>>> result = caustica.render(scene, target_error=0.03, time=300) # doctest: +SKIP
>>> result.image.shape                                           # doctest: +SKIP
(540, 960, 3)
"""

from caustica._builder import Material, SceneBuilder, Texture
from caustica._errors import SceneError
from caustica._native import INTEGRATORS, __version__
from caustica._scene import (
    Decision,
    ErrorEstimate,
    Forecast,
    Plan,
    Progress,
    Result,
    Scene,
    load_file,
    load_string,
    render,
)

__all__ = [
    "INTEGRATORS",
    "Decision",
    "ErrorEstimate",
    "Forecast",
    "Material",
    "Plan",
    "Progress",
    "Result",
    "Scene",
    "SceneBuilder",
    "SceneError",
    "Texture",
    "__version__",
    "load_file",
    "load_string",
    "render",
]
