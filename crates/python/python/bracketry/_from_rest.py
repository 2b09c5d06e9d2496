"""Motion from rest to rest under dry friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from . import _native
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, name_of


@dataclass(frozen=True, eq=False, kw_only=True)
class FromRest(Result):
    """Which rest states bounded inputs reach."""

    model: str
    #: Whether all rest states near the point are reachable from it.
    answer: Literal["no", "yes", "unknown"]
    #: What a "yes" rests on: "proven" or "evidence".
    proof: str | None = None
    reason: dict[str, Any] | None = field(repr=False, default=None)
    #: `name`, `at`, `motion` ("never", "only-up", "only-down", "open"), `answer`, `proof`.
    coordinates: list[dict[str, Any]] = field(repr=False)
    bounds: list[dict[str, Any]] = field(repr=False)
    #: Friction forces: `velocities`, `rates`, `friction`, `holds`, `text`.
    friction: list[dict[str, Any]] = field(repr=False)
    #: Loops of the inputs: `inputs`, `form`, `text`, `duration`, `displacements`, `proven`, `signals`.
    loops: list[dict[str, Any]] = field(repr=False)
    #: Radius of the ball about 0 in the hull of the directions of displacement.
    margin: float


@dataclass(frozen=True, eq=False, kw_only=True)
class FromRestMap(Result):
    """The answers over two bounds; the figure is called "map"."""

    names: list[str]
    coordinates: list[str]
    #: Middles of columns and rows.
    x: list[float] = field(repr=False)
    y: list[float] = field(repr=False)
    #: By row, column, and coordinate: `answer`, `proof`; None where time ran out.
    cells: list[list[list[dict[str, Any]] | None]] = field(repr=False)
    #: `coordinate`, `bound`, `no_up_to`, `yes_from`.
    thresholds: list[dict[str, Any]] = field(repr=False)


def bounds_text(bounds: Mapping[Any, tuple[Any, Any]] | str, what: str) -> str:
    """Bounds as text, such as ``der(X,2)=-4..4``."""
    if isinstance(bounds, str):
        return bounds
    parts = [
        f"{name if isinstance(name, str) else name_of(name, what)}={expression(low, what)}..{expression(high, what)}"
        for name, (low, high) in bounds.items()
    ]
    return ",".join(parts)


def _point(at: Mapping[Any, Any] | str | None) -> str | None:
    if at is None or isinstance(at, str):
        return at
    return ", ".join(f"{name_of(k, 'at')}={expression(v, 'at')}" for k, v in at.items())


def from_rest(
    system: System,
    bounds: Mapping[Any, tuple[Any, Any]] | str = "",
    *,
    at: Mapping[Any, Any] | str | None = None,
    time_limit: float = 120.0,
) -> FromRest:
    """Which rest states are reached under dry friction by inputs within bounds, such as ``{"der(X,2)": (-4, 4)}``.

    Parameters
    ----------
    system
        The model.
    bounds
        Bounds of inputs, of their derivatives, and of coordinates, in addition to the ranges of the model.
    at
        The rest state; the model's point if it is not given.
    time_limit
        Seconds after which no further loops are tried.

    Raises
    ------
    BracketryError
        For bounds that do not fit the model.
    """
    answer = _native.from_rest(model_of(system), bounds_text(bounds, "bounds"), _point(at), time_limit)
    return result_of(FromRest, parsed(answer["json"]), answer)


def from_rest_map(
    system: System,
    axes: Mapping[Any, tuple[Any, Any]] | str,
    bounds: Mapping[Any, tuple[Any, Any]] | str = "",
    *,
    at: Mapping[Any, Any] | str | None = None,
    cells: int = 40,
    time_limit: float = 120.0,
) -> FromRestMap:
    """The answers of :func:`from_rest` over two bounds, each plus and minus a value about the value at rest.

    Raises
    ------
    BracketryError
        As for :func:`from_rest`.
    """
    answer = _native.from_rest_map(
        model_of(system), bounds_text(axes, "axes"), bounds_text(bounds, "bounds"), _point(at), cells, time_limit
    )
    return result_of(FromRestMap, parsed(answer["json"]), answer)
