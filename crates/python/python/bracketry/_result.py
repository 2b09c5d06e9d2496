"""What all results have in common."""

from __future__ import annotations

import copy
import dataclasses
import html
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from ._native import BracketryError, Figures

T = TypeVar("T")
R = TypeVar("R", bound="Result")
#: Fields whose values the native module draws when they are asked for. They do not pickle.
_DRAWN = ("_figures", "_page")


def fields_of(cls: type[T], data: Mapping[str, Any], **made: Any) -> T:
    """A dataclass from an object of JSON: its fields by name, `made` in place of those; what is absent is left to defaults."""
    names = {f.name for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    return cls(**{**{k: v for k, v in data.items() if k in names}, **made})


def result_of(cls: type[R], data: Mapping[str, Any], answer: Mapping[str, Any], **made: Any) -> R:
    """A result from the native module's answer, whose JSON has been parsed into `data`: report, figures, and fields as `fields_of`."""
    return fields_of(cls, data, json=data, text=answer["text"], _figures=answer["figures"], **made)


def real(value: float | None) -> float:
    """A number of JSON, which knows no NaN and writes null."""
    return float("nan") if value is None else float(value)


@dataclass(frozen=True)
class Figure:
    """A figure. Notebooks show it."""

    name: str
    #: The SVG document.
    svg: str
    #: The bytes of a PNG file.
    png: bytes = field(repr=False)

    def __repr__(self) -> str:
        return f"<Figure {self.name}>"

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | PathLike[str]) -> Path:
        """Writes the figure into a file whose name ends with .svg or .png."""
        target = Path(path)
        match target.suffix.lower():
            case ".svg":
                target.write_text(self.svg, encoding="utf-8")
            case ".png":
                target.write_bytes(self.png)
            case other:
                raise BracketryError(f"{target}: a figure is written as .svg or .png, not as `{other}`")
        return target


@dataclass(frozen=True, eq=False, kw_only=True)
class Result:
    """What a computation gave: fields, the JSON object of the command line, the report for a reader, figures."""

    #: The object that the command line prints with --json.
    json: dict[str, Any] = field(repr=False)
    #: The report that the command line prints.
    text: str = field(repr=False)
    _figures: Figures | None = field(repr=False, default=None)

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"

    @property
    def figure_names(self) -> list[str]:
        """Names of the figures that there are."""
        return [] if self._figures is None else self._figures.names()

    def figure(self, name: str | None = None) -> Figure:
        """Draws a figure; the first one unless named. A result that came out of a pickle has none."""
        if self._figures is None:
            raise BracketryError("figures do not travel with a pickled result: draw them where it was made")
        names = self._figures.names()
        if name is None:
            if not names:
                raise BracketryError("this result has no figure")
            name = names[0]
        return Figure(name, self._figures.svg(name), self._figures.png(name))

    def __getstate__(self) -> dict[str, Any]:
        return {name: None if name in _DRAWN else value for name, value in self.__dict__.items()}

    def __copy__(self: R) -> R:
        return self._copied(lambda value: value)

    def __deepcopy__(self: R, memo: dict[int, Any]) -> R:
        return self._copied(lambda value: copy.deepcopy(value, memo))

    def _copied(self: R, copied: Callable[[Any], Any]) -> R:
        """A copy within this process, which keeps what is drawn when it is asked for: that cannot change."""
        twin = object.__new__(type(self))
        twin.__dict__.update({name: value if name in _DRAWN else copied(value) for name, value in self.__dict__.items()})
        return twin


def parsed(text: str) -> dict[str, Any]:
    """An object of JSON."""
    value = json.loads(text)
    assert isinstance(value, dict)
    return value
