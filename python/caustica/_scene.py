"""Scenes, renders and their results."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Optional, Union

import numpy as np

from caustica import _native

if TYPE_CHECKING:
    from caustica._builder import SceneBuilder

_PathLike = Union[str, "os.PathLike[str]"]
_MAX_COUNT = 2**32 - 1
_MAX_SIDE = 65_536


def _whole(name: str, value: Any, least: int, most: int) -> int:
    """Returns `value` as a whole number from `least` to `most`, or raises an error that names it."""
    try:
        number: int = value.__index__()
    except AttributeError:
        raise TypeError(f"{name} is {value!r}: give a whole number") from None
    if not least <= number <= most:
        raise ValueError(f"{name} is {number}: give a whole number from {least} to {most}")
    return number


def _optional_whole(name: str, value: Any, least: int, most: int = _MAX_COUNT) -> Optional[int]:
    return None if value is None else _whole(name, value, least, most)


def _number(name: str, value: Any, holds: Callable[[float], bool], rule: str) -> float:
    """Returns `value` as a float for which `holds` is true, or raises an error with `rule`."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} is {value!r}: give a number {rule}") from None
    if not (math.isfinite(number) and holds(number)):
        raise ValueError(f"{name} is {value!r}: give a number {rule}")
    return number


def _optional_number(name: str, value: Any, holds: Callable[[float], bool], rule: str) -> Optional[float]:
    return None if value is None else _number(name, value, holds, rule)


def _target(name: str, value: Any) -> Optional[float]:
    return _optional_number(name, value, lambda x: 0 < x < 1e6, "above 0, such as 0.02 for 2 %")


def _confidence(value: Any) -> float:
    return _number("confidence", value, lambda x: 0.5 <= x < 1, "from 0.5 to less than 1")


def _memory(value: Any) -> Optional[int]:
    return _optional_whole("memory", value, 1, 10**15)


def _window(values: Any, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Returns a window of columns and rows of a picture of `size`, or raises an error."""
    try:
        left, top, right, bottom = values
    except (TypeError, ValueError):
        raise TypeError(f"crop is {values!r}: give (x0, y0, x1, y1) in pixels") from None
    width, height = size
    x0 = _whole("x0 of crop", left, 0, width - 1)
    y0 = _whole("y0 of crop", top, 0, height - 1)
    x1, y1 = _whole("x1 of crop", right, x0 + 1, width), _whole("y1 of crop", bottom, y0 + 1, height)
    return (x0, y0, x1, y1)


@dataclass(frozen=True)
class Forecast:
    """Number of passes after which a render is expected to reach an error.

    The range from `low` to `high` holds the number with a probability of 80 %.
    """

    #: Lower end of the range; None if no number of passes is enough.
    low: Optional[int]
    #: Median; None if it is too far to tell, or if no number of passes is enough.
    median: Optional[int]
    #: Upper end of the range; None if it is too far to tell.
    high: Optional[int]
    #: Relative bias that no number of passes removes, if it exceeds the error; else None.
    floor: Optional[float]


@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated relative error of a picture: 0.01 means 1 %. Errors are root mean squares."""

    #: Number of passes of the picture.
    passes: int
    #: Total error: the root of noise² + bias².
    error: float
    #: Lower end of the interval that holds the true error with `confidence`.
    low: float
    #: Upper end of the interval that holds the true error with `confidence`.
    high: float
    #: Standard error of the mean of the passes.
    noise: float
    #: Error that averaging does not reduce: the root of blur² + shared_paths² + clamping².
    bias: float
    #: Bias of photon density estimates.
    blur: float
    #: Error of camera paths that all passes share; 0 if each pass has its own.
    shared_paths: float
    #: Bias due to the light that `clamp` removes; 0 without it.
    clamping: float
    #: Confidence of the interval.
    confidence: float
    _forecast: _native.NativeForecast = field(repr=False, compare=False)

    @property
    def interval(self) -> tuple[float, float]:
        """Interval that holds the true error with `confidence`."""
        return (self.low, self.high)

    def error_after(self, passes: int) -> float:
        """Returns the predicted error after `passes` passes in all."""
        return self._forecast.error_after_passes(_whole("passes", passes, 1, _MAX_COUNT))

    def forecast(self, target_error: float, confidence: float = 0.9) -> Forecast:
        """Returns after how many passes in all the error is at most `target_error`, with `confidence`."""
        target = _target("target_error", target_error)
        if target is None:
            raise TypeError("target_error is None: give a number above 0, such as 0.02 for 2 %")
        return Forecast(*self._forecast.stop(target, _confidence(confidence)))

    def __str__(self) -> str:
        text = f"error {self.error:.2%} ({self.low:.2%} to {self.high:.2%} with {self.confidence:.0%} confidence)"
        return f"{text}: noise {self.noise:.2%}, bias {self.bias:.2%}, {self.passes} passes"


def _estimate(values: Optional[tuple[int, list[float], float, _native.NativeForecast]]) -> Optional[ErrorEstimate]:
    if values is None:
        return None
    passes, errors, confidence, forecast = values
    return ErrorEstimate(passes, *errors, confidence, forecast)


@dataclass(frozen=True)
class Progress:
    """Progress of a render after a pass: the argument of its callback."""

    #: Number of passes so far.
    passes: int
    #: Time since the call of `render`, in seconds.
    seconds: float
    #: Estimated error; None after a pass that did not estimate it. The first three passes do not.
    error: Optional[ErrorEstimate]


@dataclass(frozen=True)
class Decision:
    """Decision whether a render simulates one effect of light."""

    #: Name of the effect, such as ``caustics``.
    effect: str
    #: True if the scene needs the effect.
    is_needed: bool
    #: True if a render simulates the effect.
    is_simulated: bool
    #: Reason why the scene needs the effect, or does not need it.
    reason: str


@dataclass(frozen=True)
class Plan:
    """Plan of a render: one decision for each effect of light."""

    #: Name of the rendering algorithm.
    integrator: str
    #: Decisions in a fixed order.
    decisions: tuple[Decision, ...]

    @property
    def simulated(self) -> tuple[str, ...]:
        """Names of the effects that a render simulates."""
        return tuple(decision.effect for decision in self.decisions if decision.is_simulated)

    def __getitem__(self, effect: str) -> Decision:
        """Returns the decision for the effect of this name."""
        for decision in self.decisions:
            if decision.effect == effect:
                return decision
        names = ", ".join(decision.effect for decision in self.decisions)
        raise KeyError(f"no effect is called {effect!r}: choose one of {names}")

    def __str__(self) -> str:
        lines = (f"{'+' if d.is_simulated else '-'} {d.effect}: {d.reason}" for d in self.decisions)
        return "\n".join([f"plan of {self.integrator}:", *lines])


class Result:
    """Result of a render."""

    __slots__ = ("_native",)

    def __init__(self, native: _native.NativeResult) -> None:
        self._native = native

    def _array(self, values: bytearray, *channels: int) -> np.ndarray[Any, Any]:
        width, height = self._native.size()
        return np.frombuffer(values, dtype=np.float32).reshape(height, width, *channels)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self._native.size()

    @property
    def image(self) -> np.ndarray[Any, Any]:
        """New float32 array of height × width × 3: linear radiance in W/(m² sr), rows from the top."""
        return self._array(self._native.image(), 3)

    @property
    def layers(self) -> dict[str, np.ndarray[Any, Any]]:
        """New float32 arrays: the layers that ``caustica render --aov`` writes.

        ``image`` and other colors and vectors have 3 channels, such as ``noise``, ``bias``, ``albedo`` and
        ``normal``; ``motion`` has 2. Layers of one channel have none, such as ``depth``. Other channels are apart,
        such as ``radius.caustic``. Maps of the error exist once it is estimated, after 4 passes.
        """
        layers = {}
        for name, channels in self._native.layers():
            if len(channels) > 1 and all(len(channel) == 1 for channel, _ in channels):
                parts = [self._array(values) for _, values in channels]
                layers[name or "image"] = np.stack(parts, axis=-1)
            elif len(channels) == 1:
                layers[name] = self._array(channels[0][1])
            else:
                layers.update((f"{name}.{channel}", self._array(values)) for channel, values in channels)
        return layers

    @property
    def error(self) -> Optional[ErrorEstimate]:
        """Estimated error; None before 4 passes, or if the error is not estimated."""
        return _estimate(self._native.error(None))

    def error_with_confidence(self, confidence: float) -> Optional[ErrorEstimate]:
        """Returns the estimated error with an interval of `confidence`, in the open interval (0, 1)."""
        number = _number("confidence", confidence, lambda x: 0 < x < 1, "between 0 and 1")
        return _estimate(self._native.error(number))

    @property
    def passes(self) -> int:
        """Number of passes."""
        return self._native.passes()

    @property
    def seconds(self) -> float:
        """Wall time of all passes, in seconds. Loading and pilots are not included."""
        return self._native.seconds()

    @property
    def ended(self) -> str:
        """Why the render ended.

        ``passes``, ``time`` or ``target``: by this limit. ``floor``: bias keeps the error above the target.
        ``interrupted``: the callback returned False.
        """
        return self._native.ended()

    @property
    def clamped_fraction(self) -> Optional[float]:
        """Light that `clamp` removed, as a fraction of the light without it; None without `clamp`."""
        return self._native.clamped_fraction()

    def save(
        self,
        path: _PathLike,
        *,
        tone: Optional[str] = None,
        exposure: float = 0.0,
        png_bits: int = 8,
        exr_bits: int = 32,
    ) -> None:
        """Writes the picture as .png or .exr, whole or not at all.

        `tone` (``srgb``, ``filmic`` or ``course``) and `exposure` in stops apply to PNG. OpenEXR holds linear
        radiance.
        """
        stops = _number("exposure", exposure, lambda x: abs(x) <= 64, "from -64 to 64")
        bits = (_whole("png_bits", png_bits, 8, 16), _whole("exr_bits", exr_bits, 16, 32))
        self._native.save(Path(path), tone, stops, *bits)

    def save_layers(self, path: _PathLike) -> None:
        """Writes all layers as one .exr file, like ``--aov``."""
        self._native.save_layers(Path(path))

    def __repr__(self) -> str:
        width, height = self.size
        return f"<caustica.Result: {width} x {height}, {self.passes} passes, {self.error or 'no error estimate'}>"


class Scene:
    """A scene that is ready to be rendered. `load_file`, `load_string` and `Scene.build` make one."""

    __slots__ = ("_native",)

    def __init__(self, native: _native.NativeScene) -> None:
        self._native = native

    @staticmethod
    def build() -> SceneBuilder:
        """Returns an empty `SceneBuilder`."""
        from caustica._builder import SceneBuilder

        return SceneBuilder()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture that the scene asks for, in pixels."""
        return self._native.size()

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return self._native.counts()[0]

    @property
    def shapes(self) -> int:
        """Number of shapes that are not triangles."""
        return self._native.counts()[1]

    @property
    def lights(self) -> int:
        """Number of lights. A shape that emits is one, too."""
        return self._native.counts()[2]

    @property
    def text(self) -> str:
        """The scene in the scene language, in a canonical form. Meshes from arrays appear by name."""
        return self._native.text()

    @property
    def warnings(self) -> list[str]:
        """Warnings about content that is ignored, approximated, unused or defective, one line each."""
        return self._native.warnings()

    def plan(self, integrator: str = "hybrid", *, effects: str = "auto") -> Plan:
        """Returns which effects of light a render simulates, with reasons.

        `effects` forces effects on or off, such as ``auto,-caustics``.
        """
        return Plan(integrator, tuple(Decision(*values) for values in self._native.plan(integrator, effects)))

    def render(
        self,
        integrator: str = "hybrid",
        *,
        passes: Optional[int] = None,
        time: Optional[float] = None,
        target_error: Optional[float] = None,
        confidence: float = 0.9,
        preview: bool = False,
        estimate_error: bool = True,
        seed: int = 0,
        size: Optional[tuple[int, int]] = None,
        threads: Optional[int] = None,
        callback: Optional[Callable[[Progress], Any]] = None,
        photons: Optional[int] = None,
        caustic_photons: Optional[int] = None,
        spp: Optional[int] = None,
        max_bounces: int = 100,
        gather_k: Optional[int] = None,
        radius: Optional[float] = None,
        alpha: Optional[float] = None,
        kernel: str = "epanechnikov",
        filter: str = "blackman-harris",
        adaptive: bool = False,
        final_gathering: str = "bsdf",
        light_tracing: str = "weighted",
        indirect_photons: str = "weighted",
        volume: str = "beams",
        prefix_rays: bool = True,
        environment_guiding: bool = True,
        scatter_point_guiding: bool = True,
        effects: str = "auto",
        aovs: bool = False,
        aov_first_hit: bool = False,
        light_groups: bool = False,
        crop: Optional[tuple[int, int, int, int]] = None,
        clamp: Optional[float] = None,
    ) -> Result:
        """Renders the scene, and returns the picture with its estimated error.

        The render ends at the first limit that it reaches: `passes`, `time` in seconds from the call
        (pilots included), or `target_error` (0.03 is 3 %) with `confidence`. Without limits it ends at 3 %,
        or after five minutes.

        `callback` receives a `Progress` after each pass; it ends the render by returning False. Ctrl-C abandons
        the current pass and raises `KeyboardInterrupt`. Other Python threads run meanwhile.

        `aovs` adds the layers ``albedo``, ``normal``, ``depth``, ``position``, ``object`` and ``material`` of
        the first surface that is not specular, and ``motion``. With `aov_first_hit` they belong to the first
        surface. `light_groups` adds ``direct``, ``indirect`` and ``caustic``, whose sum is the picture.

        `crop` is ``(x0, y0, x1, y1)``: only the columns ``x0`` to before ``x1`` and the rows ``y0`` to before
        ``y1`` are rendered. Their pixels equal those of the whole picture. `clamp` limits the radiance of each
        camera path, against fireflies: `Result.clamped_fraction` says how much light this removes, the layer
        ``clamped`` holds it, and the bias of the error includes it.

        Other arguments are the flags of ``caustica render``, which renders the same picture bit for bit.
        docs/guide/command-line.md lists their values. `threads` changes no bit.

        Raises `ValueError` or `TypeError` for an argument out of range, `SceneError` for a scene that does not
        suit `size`, and `MemoryError` for a picture or photons that do not fit into memory.
        """
        if size is not None:
            width, height = size
            size = (_whole("width", width, 1, _MAX_SIDE), _whole("height", height, 1, _MAX_SIDE))
        if gather_k == 1:
            raise ValueError("gather_k is 1: give at least 2, or 0 for all photons within the radius")
        if not estimate_error and (target_error is not None or preview):
            raise ValueError("target_error and preview need estimate_error=True")
        if integrator == "raycast" and (target_error is not None or preview):
            raise ValueError("raycast makes one pass, whose error cannot be estimated: leave out target_error")
        if integrator == "raycast" and light_groups:
            raise ValueError("raycast only shades surfaces: light_groups needs another integrator")
        if integrator == "raycast" and clamp is not None:
            raise ValueError("raycast only shades surfaces: clamp needs another integrator")
        if crop is not None:
            crop = _window(crop, size or self.size)
        if callback is not None and not callable(callback):
            raise TypeError(f"callback is {callback!r}: give a function of one argument")
        options = {
            "integrator": integrator,
            "passes": _optional_whole("passes", passes, 1),
            "seconds": _optional_number("time", time, lambda x: 0 <= x <= 1e9, "of seconds, at least 0"),
            "target_error": _target("target_error", target_error),
            "confidence": _confidence(confidence),
            "preview": bool(preview),
            "estimate_error": bool(estimate_error),
            "seed": _whole("seed", seed, 0, 2**64 - 1),
            "size": size,
            "threads": 0 if threads is None else _whole("threads", threads, 1, 1024),
            "photons": _optional_whole("photons", photons, 0),
            "caustic_photons": _optional_whole("caustic_photons", caustic_photons, 0),
            "spp": _optional_whole("spp", spp, 1),
            "max_bounces": _whole("max_bounces", max_bounces, 0, _MAX_COUNT),
            "gather_k": _optional_whole("gather_k", gather_k, 0),
            "radius": _optional_number("radius", radius, lambda x: 1e-45 < x < 3.4e38, "above 0, in scene units"),
            "alpha": _optional_number("alpha", alpha, lambda x: 0 < x <= 1, "above 0 and at most 1"),
            "kernel": kernel,
            "filter": filter,
            "adaptive": bool(adaptive),
            "final_gathering": final_gathering,
            "light_tracing": light_tracing,
            "indirect_photons": indirect_photons,
            "volume": volume,
            "prefix_rays": bool(prefix_rays),
            "environment_guiding": bool(environment_guiding),
            "scatter_point_guiding": bool(scatter_point_guiding),
            "effects": effects,
            "aovs": bool(aovs or aov_first_hit),
            "aov_first_hit": bool(aov_first_hit),
            "light_groups": bool(light_groups),
            "crop": crop,
            "clamp": _optional_number("clamp", clamp, lambda x: 1e-38 < x < 3.4e38, "above 0, a radiance"),
        }
        report: Optional[Callable[[int, float, Any], Any]] = None
        if callback is not None:

            def report(passes: int, seconds: float, error: Any) -> Any:
                return callback(Progress(passes, seconds, _estimate(error)))

        return Result(self._native.render(options, report))

    def __repr__(self) -> str:
        width, height = self.size
        counts = f"{self.triangles} triangles, {self.shapes} shapes, {self.lights} lights"
        return f"<caustica.Scene: {counts}, {width} x {height}>"


def load_file(
    path: _PathLike,
    format: Optional[str] = None,
    *,
    allow_outside: bool = False,
    memory: Optional[int] = None,
) -> Scene:
    """Reads a scene file: scene text, glTF, Mitsuba, pbrt or Tungsten.

    `format` is the extension that selects the importer, by default that of the file. `allow_outside` lets a
    scene of another program name files outside its folder. `memory` limits the memory of this process in
    bytes.

    Raises `SceneError` for errors in the scene, and `OSError` for a file that cannot be read.
    """
    if format is not None:
        format = format.lower().lstrip(".")
        if format not in _native.FORMATS:
            raise ValueError(f"format is {format!r}: choose one of {', '.join(_native.FORMATS)}")
    return Scene(_native.load_file(Path(path), format, bool(allow_outside), _memory(memory)))


def load_string(
    text: str,
    *,
    name: str = "<string>",
    folder: _PathLike = ".",
    memory: Optional[int] = None,
) -> Scene:
    """Reads scene `text`. Files that it names are looked up in `folder`, then in its parent.

    Messages name the text `name`. Raises `SceneError` for errors in the scene.
    """
    return Scene(_native.load_text(text, name, Path(folder), [], _memory(memory)))


def render(scene: Scene, integrator: str = "hybrid", **options: Any) -> Result:
    """Renders `scene`. `options` are those of `Scene.render`."""
    return scene.render(integrator, **options)
