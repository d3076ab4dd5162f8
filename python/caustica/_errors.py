"""Exceptions of the package."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be rendered: the defect, its place and the remedy.

    ``str()`` gives ``file:line:column: message``, then the remedy, then the further errors of the file.
    """

    def __init__(self, message: str, file: str, line: int = 0, column: int = 0, remedy: str = "") -> None:
        super().__init__(message, file, line, column, remedy)
        #: Description of the defect, without its place.
        self.message = message
        #: Name of the scene file; of the Python file for an object of a `SceneBuilder`.
        self.file = file
        #: Line, from 1; 0 if the error has no place in the file.
        self.line = line
        #: Column in characters, from 1; 0 if it is unknown.
        self.column = column
        #: Advice on how to correct the defect.
        self.remedy = remedy
        #: Further errors of the same scene.
        self.further: list[SceneError] = []

    def __str__(self) -> str:
        place = [self.file, *(str(n) for n in (self.line, self.column) if n > 0)]
        remedy = f"; {self.remedy}" if self.remedy else ""
        return "\n".join([f"{':'.join(place)}: {self.message}{remedy}", *map(str, self.further)])
