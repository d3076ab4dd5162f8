"""Scenes built in Python code."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Optional, Sequence, TypeVar, Union

import numpy as np

from caustica import _native
from caustica._errors import SceneError
from caustica._scene import Scene, _memory, _PathLike

_Vector = Union[Sequence[float], "np.ndarray[Any, Any]"]
_FOLDER = os.path.dirname(os.path.abspath(__file__))


class _Named:
    """A material, texture or medium of one builder."""

    __slots__ = ("_builder", "name")

    def __init__(self, builder: SceneBuilder, name: str) -> None:
        self._builder = builder
        #: Name in the scene language.
        self.name = name

    def __repr__(self) -> str:
        return f"<caustica.{type(self).__name__} {self.name}>"


_NamedType = TypeVar("_NamedType", bound=_Named)


class Texture(_Named):
    """A texture of a `SceneBuilder`: a color at each point of a surface."""

    __slots__ = ()


class Medium(_Named):
    """A medium of a `SceneBuilder`: fog, milk, smoke."""

    __slots__ = ()


class Material(_Named):
    """A material of a `SceneBuilder`."""

    __slots__ = ()


_Color = Union[float, _Vector]
_ColorOrTexture = Union[float, _Vector, Texture]


class _Word(str):
    """A word of the scene language, which stands without quotes."""


def _word(text: Optional[str]) -> Optional[str]:
    """Returns `text` as a word of the scene language if it looks like one."""
    return _Word(text) if text is not None and text.isalnum() else text


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _numbers(value: Any) -> str:
    """Returns a number or an array of numbers as text that reads back bit for bit."""
    array = np.asarray(value, dtype=np.float64)
    return " ".join(repr(float(number)) for number in array.ravel())


def _color(value: _ColorOrTexture) -> Any:
    """Returns a color of three numbers; a single number is grey."""
    if value is None or isinstance(value, _Named):
        return value
    array = np.asarray(value, dtype=np.float64)
    return np.repeat(array, 3) if array.ndim == 0 else array


def _place() -> tuple[str, int]:
    """Returns file and line of the nearest caller outside of this package."""
    frame: Any = sys._getframe(1)
    while frame.f_back is not None and (
        os.path.dirname(os.path.abspath(frame.f_code.co_filename)) == _FOLDER
        or frame.f_globals.get("__name__") == "contextlib"
    ):
        frame = frame.f_back
    return (frame.f_code.co_filename, frame.f_lineno)


def _array(name: str, value: Any, columns: int, dtype: Any) -> np.ndarray[Any, Any]:
    """Returns `value` as a contiguous array of rows of `columns` numbers."""
    array = np.asarray(value)
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"{name} has shape {array.shape}: give an array of shape (n, {columns})")
    if np.issubdtype(dtype, np.integer) and not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"{name} holds {array.dtype}: give whole numbers")
    return np.ascontiguousarray(array, dtype=dtype)


class SceneBuilder:
    """A scene in the making. `Scene.build` returns an empty one, `build` makes the scene.

    Each method adds one thing. Methods of materials, textures and media return a handle, which shapes and
    materials take. A color is three numbers, or one number for grey. Lengths have one unit, the metre where
    lights are given in watts; angles are in degrees.

    >>> import caustica
    >>> builder = caustica.Scene.build()
    >>> white = builder.diffuse(0.8)
    >>> builder.plane(white, normal=(0, 1, 0))
    >>> builder.sphere(builder.dielectric(1.5), center=(0, 1, 0), radius=0.8)
    >>> builder.point_light((2, 4, 0), power=200)
    >>> builder.camera(center=(0, 2, 6), look_at=(0, 1, 0), angle=40, size=(32, 24))
    >>> builder.build()
    <caustica.Scene: 0 triangles, 2 shapes, 1 lights, 32 x 24>

    A parameter out of range is an error of `build`, with the line that gave it.
    """

    def __init__(self) -> None:
        self._camera: Optional[tuple[str, tuple[str, int]]] = None
        self._background: Optional[tuple[str, tuple[str, int]]] = None
        # Lines of each block, with the place of the call that added them.
        self._blocks: dict[str, list[tuple[str, tuple[str, int]]]] = {
            name: [] for name in ("Lights", "Textures", "Media", "Materials", "Group")
        }
        self._meshes: list[tuple[str, bytes, bytes, Optional[bytes], Optional[bytes]]] = []

    # The scene language.

    def _fields(self, keyword: str, fields: dict[str, Any]) -> str:
        """Returns a block of the scene language. Fields that are None are left out."""
        words = [keyword, "{"]
        for name, value in fields.items():
            if value is None:
                continue
            if isinstance(value, _Named):
                if value._builder is not self:
                    raise ValueError(f"{name} is {value!r} of another builder: make it with this one")
                value = _quoted(value.name)
            elif isinstance(value, bool):
                value = "yes" if value else "no"
            elif isinstance(value, _Word):
                value = str(value)
            elif isinstance(value, (str, os.PathLike)):
                value = _quoted(os.fspath(value))
            elif isinstance(value, (int, np.integer)):
                value = str(int(value))
            else:
                value = _numbers(value)
            if "\n" in value or "\r" in value:
                raise ValueError(f"{name} holds a line break: give one line")
            words += [name, value]
        return " ".join([*words, "}"])

    def _add(self, block: str, keyword: str, fields: dict[str, Any]) -> None:
        self._blocks[block].append((self._fields(keyword, fields), _place()))

    def _add_named(self, cls: type[_NamedType], block: str, keyword: str, fields: dict[str, Any]) -> _NamedType:
        name = f"{block.lower()}{len(self._blocks[block])}"
        self._blocks[block].append((self._fields(f"{keyword} {name}", fields), _place()))
        return cls(self, name)

    def _shape(self, keyword: str, material: Material, emission: Any, fields: dict[str, Any]) -> None:
        if not isinstance(material, Material):
            raise TypeError(f"material is {material!r}: give a material of this builder, such as builder.diffuse(0.8)")
        if material._builder is not self:
            raise ValueError(f"material is {material!r} of another builder: make it with this one")
        text = self._fields(keyword, {**fields, "emission": _color(emission)})
        # A Transform takes one object, so the material and the shape are a group.
        line = f"Group {{ MaterialName {_quoted(material.name)} {text} }}"
        self._blocks["Group"].append((line, _place()))

    # Camera and background.

    def camera(
        self,
        *,
        center: _Vector,
        look_at: Optional[_Vector] = None,
        direction: Optional[_Vector] = None,
        up: _Vector = (0, 1, 0),
        angle: float = 40.0,
        size: tuple[int, int] = (960, 720),
        aperture: Optional[float] = None,
        focus_distance: Optional[float] = None,
        focus_at: Optional[_Vector] = None,
        blades: Optional[int] = None,
    ) -> None:
        """Sets a perspective camera: `angle` is the vertical field of view, `aperture` the lens radius.

        Give `look_at` or `direction`. The plane in focus is that of `look_at`, or that of `focus_distance` or
        `focus_at`.
        """
        lens = {"aperture": aperture, "focusDistance": focus_distance, "focusAt": focus_at, "blades": blades}
        view = {"center": center, "lookAt": look_at, "direction": direction, "up": up}
        fields = {**view, "angle": angle, "width": size[0], "height": size[1], **lens}
        self._camera = (self._fields("PerspectiveCamera", fields), _place())

    def orthographic_camera(
        self,
        *,
        center: _Vector,
        height: float,
        look_at: Optional[_Vector] = None,
        direction: Optional[_Vector] = None,
        up: _Vector = (0, 1, 0),
        size: tuple[int, int] = (960, 720),
    ) -> None:
        """Sets a camera of parallel projection; `height` is that of the visible region."""
        view = {"center": center, "lookAt": look_at, "direction": direction, "up": up}
        fields = {**view, "size": height, "width": size[0], "height": size[1]}
        self._camera = (self._fields("OrthographicCamera", fields), _place())

    def environment_camera(
        self,
        *,
        center: _Vector,
        direction: _Vector = (0, 0, -1),
        up: _Vector = (0, 1, 0),
        size: tuple[int, int] = (960, 480),
    ) -> None:
        """Sets a camera that sees all directions, by longitude and latitude."""
        fields = {"center": center, "direction": direction, "up": up, "width": size[0], "height": size[1]}
        self._camera = (self._fields("EnvironmentCamera", fields), _place())

    def background(self, color: _Color = 0.0, *, medium: Optional[Medium] = None) -> None:
        """Sets the radiance of rays that leave the scene, and the medium outside all bodies.

        Without this call, the background is black.
        """
        self._background = (self._fields("Background", {"color": _color(color), "medium": medium}), _place())

    # Lights.

    def point_light(
        self, position: _Vector, *, power: Optional[_Color] = None, intensity: Optional[_Color] = None
    ) -> None:
        """Adds a point light, with a `power` in watts or an `intensity` in W/sr."""
        self._light("PointLight", {"position": position}, power=power, intensity=intensity)

    def directional_light(self, direction: _Vector, *, irradiance: _Color) -> None:
        """Adds parallel light; `irradiance` is that of a surface that faces it, in W/m²."""
        self._light("DirectionalLight", {"direction": direction}, irradiance=irradiance)

    def spot_light(
        self,
        position: _Vector,
        *,
        angle: float,
        direction: Optional[_Vector] = None,
        look_at: Optional[_Vector] = None,
        penumbra: Optional[float] = None,
        power: Optional[_Color] = None,
        intensity: Optional[_Color] = None,
    ) -> None:
        """Adds a spotlight with the full opening `angle`, and a soft rim of width `penumbra` inside."""
        cone = {"direction": direction, "lookAt": look_at, "angle": angle, "penumbra": penumbra}
        self._light("SpotLight", {"position": position, **cone}, power=power, intensity=intensity)

    def sphere_light(
        self, center: _Vector, radius: float, *, radiance: Optional[_Color] = None, power: Optional[_Color] = None
    ) -> None:
        """Adds a sphere that emits, with a `radiance` in W/(m² sr) or a `power` in watts."""
        self._light("SphereLight", {"center": center, "radius": radius}, radiance=radiance, power=power)

    def disc_light(
        self,
        center: _Vector,
        normal: _Vector,
        radius: float,
        *,
        radiance: Optional[_Color] = None,
        power: Optional[_Color] = None,
    ) -> None:
        """Adds a disc that emits on the side of its normal."""
        disc = {"center": center, "normal": normal, "radius": radius}
        self._light("DiscLight", disc, radiance=radiance, power=power)

    def rectangle_light(
        self,
        corner: _Vector,
        edge0: _Vector,
        edge1: _Vector,
        *,
        radiance: Optional[_Color] = None,
        power: Optional[_Color] = None,
    ) -> None:
        """Adds a parallelogram that emits on the side of `edge0` × `edge1`."""
        rectangle = {"corner": corner, "edge0": edge0, "edge1": edge1}
        self._light("RectangleLight", rectangle, radiance=radiance, power=power)

    def environment_light(
        self,
        radiance: Optional[_Color] = None,
        *,
        file: Optional[_PathLike] = None,
        scale: Optional[float] = None,
        rotate: Optional[float] = None,
    ) -> None:
        """Adds light from all directions: a constant `radiance`, or a picture by longitude and latitude."""
        self._light("EnvironmentLight", {"file": file, "scale": scale, "rotate": rotate}, radiance=radiance)

    def _light(self, keyword: str, fields: dict[str, Any], **strength: Optional[_Color]) -> None:
        colors = {name: _color(value) for name, value in strength.items() if value is not None}
        self._add("Lights", keyword, {**fields, **colors})

    # Textures.

    def image_texture(
        self,
        file: _PathLike,
        *,
        encoding: Optional[str] = None,
        wrap: Optional[str] = None,
        scale: Optional[_Vector] = None,
        rotate: Optional[float] = None,
        offset: Optional[_Vector] = None,
    ) -> Texture:
        """Adds a picture. `encoding` is ``srgb`` or ``linear``; `wrap` is ``repeat``, ``clamp`` or ``mirror``."""
        mapping = {"encoding": _word(encoding), "wrap": _word(wrap), "scale": scale, "rotate": rotate, "offset": offset}
        return self._add_named(Texture, "Textures", "Image", {"file": file, **mapping})

    def checker_texture(self, color0: _Color = 0.0, color1: _Color = 1.0, *, scale: _Vector = (1, 1)) -> Texture:
        """Adds squares of side 1 in texture coordinates, after these are multiplied by `scale`."""
        fields = {"color0": _color(color0), "color1": _color(color1), "scale": scale}
        return self._add_named(Texture, "Textures", "Checker", fields)

    def noise_texture(
        self,
        color0: _Color = 0.0,
        color1: _Color = 1.0,
        *,
        kind: str = "noise",
        frequency: float = 1.0,
        amplitude: float = 1.0,
        octaves: int = 4,
    ) -> Texture:
        """Adds a solid texture; `kind` is ``noise``, ``marble`` or ``wood``."""
        keywords = {"noise": "Noise", "marble": "Marble", "wood": "Wood"}
        if kind not in keywords:
            raise ValueError(f"kind is {kind!r}: choose one of {', '.join(keywords)}")
        pattern = {"frequency": float(frequency), "amplitude": float(amplitude), "octaves": octaves}
        fields = {"color0": _color(color0), "color1": _color(color1), **pattern}
        return self._add_named(Texture, "Textures", keywords[kind], fields)

    # Media.

    def medium(
        self,
        *,
        absorption: _Color = 0.0,
        scattering: _Color = 0.0,
        emission: _Color = 0.0,
        anisotropy: Optional[float] = None,
    ) -> Medium:
        """Adds a homogeneous medium with coefficients per length. `anisotropy` is the mean cosine."""
        colors = {"absorption": _color(absorption), "scattering": _color(scattering), "emission": _color(emission)}
        return self._add_named(Medium, "Media", "Medium", {**colors, "anisotropy": anisotropy})

    # Materials.

    def diffuse(self, reflectance: _ColorOrTexture, *, emission: Optional[_ColorOrTexture] = None) -> Material:
        """Adds a Lambertian material. `emission` makes its surfaces lights, in W/(m² sr)."""
        return self._material("Diffuse", {"reflectance": _color(reflectance)}, emission)

    def phong(
        self,
        diffuse: _ColorOrTexture,
        specular: _ColorOrTexture,
        shininess: float,
        *,
        emission: Optional[_ColorOrTexture] = None,
    ) -> Material:
        """Adds a material of Phong's model."""
        colors = {"diffuseColor": _color(diffuse), "specularColor": _color(specular)}
        return self._material("Phong", {**colors, "shininess": float(shininess)}, emission)

    def mirror(self, reflectance: _ColorOrTexture = 1.0) -> Material:
        """Adds a perfect mirror."""
        return self._material("Mirror", {"reflectance": _color(reflectance)}, None)

    def dielectric(
        self,
        index: Optional[float] = None,
        *,
        glass: Optional[str] = None,
        abbe: Optional[float] = None,
        absorption: Optional[_Color] = None,
        roughness: Union[float, Texture, None] = None,
        priority: Optional[int] = None,
        medium: Optional[Medium] = None,
    ) -> Material:
        """Adds the boundary of a body of glass, water or the like.

        Give the `index` of refraction (1.5 by default, with `abbe` for dispersion), or a `glass` by name, such
        as ``BK7`` or ``water``. `absorption` is per length. Where bodies overlap, the highest `priority` counts.
        """
        refraction = {"indexOfRefraction": index, "glass": glass, "abbe": abbe}
        inside = {"absorption": None if absorption is None else _color(absorption), "medium": medium}
        return self._material(
            "Dielectric", {**refraction, **inside, "roughness": roughness, "priority": priority}, None
        )

    def clear(self, *, medium: Optional[Medium] = None, priority: Optional[int] = None) -> Material:
        """Adds the boundary of a region without a surface, such as that of a cloud of fog."""
        return self._material("Clear", {"medium": medium, "priority": priority}, None)

    def conductor(
        self,
        metal: Optional[str] = None,
        *,
        eta: Optional[_Color] = None,
        k: Optional[_Color] = None,
        roughness: Union[float, Texture, None] = None,
    ) -> Material:
        """Adds a metal by name, such as ``gold``, or by its refractive index `eta` + i `k`."""
        index = {"eta": None if eta is None else _color(eta), "k": None if k is None else _color(k)}
        return self._material("Conductor", {"metal": metal, **index, "roughness": roughness}, None)

    def thin(self, index: float = 1.5, *, transmittance: _ColorOrTexture = 1.0) -> Material:
        """Adds a pane without thickness."""
        fields = {"indexOfRefraction": float(index), "transmittance": _color(transmittance)}
        return self._material("Thin", fields, None)

    def mix(self, first: Material, second: Material, amount: Union[float, Texture]) -> Material:
        """Adds a material that is `second` with probability `amount` at each point, else `first`."""
        return self._material("Mix", {"first": first, "second": second, "amount": amount}, None)

    def _material(self, keyword: str, fields: dict[str, Any], emission: Optional[_ColorOrTexture]) -> Material:
        emits = {} if emission is None else {"emission": _color(emission)}
        return self._add_named(Material, "Materials", keyword, {**fields, **emits})

    # Shapes.

    def sphere(
        self, material: Material, center: _Vector, radius: float, *, emission: Optional[_Color] = None
    ) -> None:
        """Adds a sphere. The `emission` of a shape is a radiance in W/(m² sr), and makes it a light."""
        self._shape("Sphere", material, emission, {"center": center, "radius": radius})

    def plane(self, material: Material, normal: _Vector, offset: float = 0.0) -> None:
        """Adds the infinite plane of the points x with `normal` · x = `offset`."""
        self._shape("Plane", material, None, {"normal": normal, "offset": float(offset)})

    def disc(
        self,
        material: Material,
        center: _Vector,
        normal: _Vector,
        radius: float,
        *,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds a flat disc."""
        self._shape("Disc", material, emission, {"center": center, "normal": normal, "radius": radius})

    def rectangle(
        self,
        material: Material,
        corner: _Vector,
        edge0: _Vector,
        edge1: _Vector,
        *,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds a parallelogram with normal `edge0` × `edge1`."""
        self._shape("Rectangle", material, emission, {"corner": corner, "edge0": edge0, "edge1": edge1})

    def box(self, material: Material, min: _Vector, max: _Vector, *, emission: Optional[_Color] = None) -> None:
        """Adds a closed box with edges along the axes."""
        self._shape("Box", material, emission, {"min": min, "max": max})

    def cylinder(
        self,
        material: Material,
        bottom: _Vector,
        top: _Vector,
        radius: float,
        *,
        caps: bool = True,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds a cylinder between the centers of its ends, which `caps` close."""
        fields = {"bottom": bottom, "top": top, "radius": radius, "caps": bool(caps)}
        self._shape("Cylinder", material, emission, fields)

    def cone(
        self,
        material: Material,
        bottom: _Vector,
        top: _Vector,
        radius: float,
        top_radius: float = 0.0,
        *,
        caps: bool = True,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds a cone, or a truncated cone with `top_radius`."""
        radii = {"radius": radius, "topRadius": float(top_radius)}
        self._shape("Cone", material, emission, {"bottom": bottom, "top": top, **radii, "caps": bool(caps)})

    def triangle(
        self, material: Material, vertex0: _Vector, vertex1: _Vector, vertex2: _Vector, *, emission: Any = None
    ) -> None:
        """Adds one triangle."""
        vertices = {"vertex0": vertex0, "vertex1": vertex1, "vertex2": vertex2}
        self._shape("Triangle", material, emission, vertices)

    def mesh(
        self,
        material: Material,
        vertices: Any,
        triangles: Any,
        *,
        normals: Any = None,
        uv: Any = None,
        smooth_angle: Optional[float] = None,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds a triangle mesh from arrays.

        `vertices` has shape (n, 3). `triangles` has shape (m, 3) and holds indices of vertices, anticlockwise
        seen from outside. `normals` (n, 3) and `uv` (n, 2) belong to the vertices; normals may have any length.
        Without normals, faces are flat, unless `smooth_angle` smooths edges up to this angle.
        """
        positions = _array("vertices", vertices, 3, np.float64)
        indices = _array("triangles", triangles, 3, np.int64)
        if len(indices) == 0:
            raise ValueError("triangles is empty: give at least one triangle")
        if len(positions) >= 2**32 or indices.min() < 0 or indices.max() >= len(positions):
            raise ValueError(f"triangles names a vertex that is not there: give indices from 0 to {len(positions) - 1}")
        arrays = {"vertices": positions}
        if normals is not None:
            directions = _array("normals", normals, 3, np.float64)
            largest = np.abs(directions).max(axis=1, keepdims=True)
            # Dividing by the largest component first avoids overflow of the length.
            scaled = directions / np.where(largest > 0, largest, 1)
            length = np.linalg.norm(scaled, axis=1, keepdims=True)
            arrays["normals"] = np.ascontiguousarray(scaled / np.where(length > 0, length, 1))
        if uv is not None:
            arrays["uv"] = _array("uv", uv, 2, np.float64)
        for name, array in arrays.items():
            if not np.isfinite(array).all():
                raise ValueError(f"{name} holds numbers that are not finite: remove them")
            if len(array) != len(positions):
                raise ValueError(f"{name} has {len(array)} rows: give one for each of {len(positions)} vertices")
        largest_coordinate = float(np.abs(positions).max())
        if largest_coordinate > 1e12:
            raise ValueError(f"vertices holds {largest_coordinate}: coordinates must be at most 1e12")
        name = f"mesh {len(self._meshes)}"
        of = {key: array.tobytes() for key, array in arrays.items()}
        corners = indices.astype(np.uint32).tobytes()
        self._meshes.append((name, of["vertices"], corners, of.get("normals"), of.get("uv")))
        self._shape("TriangleMesh", material, emission, {"file": name, "smoothAngle": smooth_angle})

    def mesh_file(
        self,
        material: Material,
        file: _PathLike,
        *,
        file_materials: bool = False,
        smooth_angle: Optional[float] = None,
        emission: Optional[_Color] = None,
    ) -> None:
        """Adds the triangle mesh of an OBJ or PLY file. `file_materials` uses the materials of its MTL files."""
        materials = _Word("file" if file_materials else "scene")
        fields = {"file": Path(file), "materials": materials, "smoothAngle": smooth_angle}
        self._shape("TriangleMesh", material, emission, fields)

    def objects(self, text: str) -> None:
        """Adds objects in the scene language, such as ``BezierPatch { … }``, verbatim to the `Group`.

        The text names materials by ``MaterialName`` and the handle's `name`.
        """
        place = _place()
        self._blocks["Group"].append(("Group {", place))
        self._blocks["Group"].extend((line, place) for line in text.split("\n"))
        self._blocks["Group"].append(("}", place))

    @contextmanager
    def transform(
        self,
        *,
        translate: Optional[_Vector] = None,
        rotate: Optional[tuple[_Vector, float]] = None,
        scale: Optional[_Color] = None,
        matrix: Any = None,
    ) -> Iterator[None]:
        """Transforms the shapes that the `with` block adds.

        Shapes are scaled first, then rotated about an axis by degrees, then translated. `matrix` (4 × 4, for
        column vectors) stands alone.
        """
        maps = self._maps(translate, rotate, scale)
        if matrix is not None:
            if maps:
                raise ValueError("matrix stands alone: leave out translate, rotate and scale")
            columns = np.asarray(matrix, dtype=np.float64)
            if columns.shape != (4, 4):
                raise ValueError(f"matrix has shape {columns.shape}: give shape (4, 4)")
            maps = f"Matrix4f {{ {_numbers(columns.T)} }}"
        with self._nested(f"Transform {{ {maps} Group {{"):
            yield

    @contextmanager
    def moving(
        self,
        *,
        translate: Optional[_Vector] = None,
        rotate: Optional[tuple[_Vector, float]] = None,
        scale: Optional[_Color] = None,
    ) -> Iterator[None]:
        """Moves the shapes that the `with` block adds, while the shutter is open.

        The maps grow evenly from the identity, when the shutter opens, to their full size, when it closes.
        """
        with self._nested(f"Moving {{ {self._maps(translate, rotate, scale)} Group {{"):
            yield

    @contextmanager
    def _nested(self, head: str) -> Iterator[None]:
        place = _place()
        self._blocks["Group"].append((head, place))
        try:
            yield
        finally:
            self._blocks["Group"].append(("} }", place))

    @staticmethod
    def _maps(translate: Any, rotate: Any, scale: Any) -> str:
        maps = []
        if translate is not None:
            maps.append(f"Translate {_numbers(translate)}")
        if rotate is not None:
            axis, angle = rotate
            maps.append(f"Rotate {{ {_numbers(axis)} {_numbers(angle)} }}")
        if scale is not None:
            maps.append(f"Scale {_numbers(_color(scale))}")
        return " ".join(maps)

    # The scene.

    def _lines(self) -> list[tuple[str, tuple[str, int]]]:
        """Returns the lines of the scene text, each with the place of its call."""
        here = _place()
        lines = [self._camera] if self._camera else []
        lines.append(self._background or ("Background { color 0 0 0 }", here))
        for block, entries in self._blocks.items():
            if entries or block == "Group":
                lines += [(f"{block} {{", here), *entries, ("}", here)]
        return lines

    @property
    def text(self) -> str:
        """The scene so far in the scene language."""
        return "\n".join(line for line, _ in self._lines()) + "\n"

    def build(self, *, folder: _PathLike = ".", memory: Optional[int] = None) -> Scene:
        """Returns the scene. Files are looked up in `folder`, then in its parent.

        Raises `SceneError` with the file and line of the call that gave a wrong value. The builder stays as it
        is, and may be used further.
        """
        if self._camera is None:
            file, line = _place()
            raise SceneError("the scene has no camera", file, line, 0, "call builder.camera(…) before build()")
        lines = self._lines()
        text = "\n".join(line for line, _ in lines) + "\n"
        try:
            native = _native.load_text(text, "<builder>", Path(folder), self._meshes, _memory(memory))
        except SceneError as error:
            raise self._located(error, lines) from None
        return Scene(native)

    @staticmethod
    def _located(error: SceneError, lines: list[tuple[str, tuple[str, int]]]) -> SceneError:
        """Returns `error`, with the place of the call whose line it names."""
        file, line = lines[error.line - 1][1] if 0 < error.line <= len(lines) else _place()
        located = SceneError(error.message, file, line, 0, error.remedy)
        located.further = [SceneBuilder._located(further, lines) for further in error.further]
        return located
