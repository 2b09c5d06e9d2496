"""Verdicts by cases of parameters, and identifiability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from . import _native
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, listed, name_of


@dataclass(frozen=True, eq=False, kw_only=True)
class ParameterCases(Result):
    """Verdicts for generic values of parameters, and the special values for which they differ."""

    model: str
    #: Parameters without value, and the values of the others.
    parameters: list[str]
    fixed: dict[str, str] = field(repr=False)
    #: Functions of the parameters at whose zeros the equations have no value.
    undefined: list[str] = field(repr=False)
    #: `aspect`, `generic`, `cases` (each with `conditions`, `value`, `confirmed_at`), `complete`, `open`.
    aspects: list[dict[str, Any]] = field(repr=False)
    #: Whether all cases with up to the given number of conditions are known.
    complete: bool

    def __getitem__(self, aspect: str) -> dict[str, Any]:
        """One aspect, such as "strong_accessibility"."""
        return next(a for a in self.aspects if a["aspect"] == aspect)


@dataclass(frozen=True, eq=False, kw_only=True)
class ParameterMap(Result):
    """Verdicts over two parameters; the figure is called "map"."""

    names: list[str]
    #: Middles of columns and rows.
    x: list[float] = field(repr=False)
    y: list[float] = field(repr=False)
    #: By row and column: `unstable`, `on_axis`, `uncontrollable`, `stabilizable`; None where there is no linearization.
    cells: list[list[dict[str, Any] | None]] = field(repr=False)
    #: Where ranks change: `condition`, `changes`.
    curves: list[dict[str, Any]] = field(repr=False)
    points: list[dict[str, Any]] = field(repr=False)
    #: The exact cases in these parameters, as in the JSON of :func:`parameter_cases`.
    report: dict[str, Any] = field(repr=False)


@dataclass(frozen=True, eq=False, kw_only=True)
class Identifiability(Result):
    """Which parameters and initial states the outputs determine."""

    model: str
    #: By name: `local`, `global` and `values`; None where that is not known.
    parameters: dict[str, dict[str, Any]]
    states: dict[str, dict[str, Any]] = field(repr=False)
    #: Locally identifiable functions of parameters that are not.
    combinations: list[str]
    combinations_missing: int | None = None
    #: Where two sets of values in all give the same outputs: what the second has in place of a name.
    other_solution: dict[str, str] = field(repr=False, default_factory=dict)


def parameter_cases(system: System, parameters: Sequence[Any] = (), *, conditions: int = 2) -> ParameterCases:
    """The verdicts for generic values of `parameters` (all if none are given), and where they differ.

    Raises
    ------
    BracketryError
        For unknown names, and for equations that switch or are not affine in the inputs.
    """
    names = [name_of(p, "parameters") for p in listed(parameters, "parameters")]
    answer = _native.parameter_cases(model_of(system), names, conditions)
    return result_of(ParameterCases, parsed(answer["json"]), answer)


def parameter_map(
    system: System, ranges: Mapping[Any, tuple[Any, Any]], *, cells: int = 40, conditions: int = 2
) -> ParameterMap:
    """Verdicts over two parameters with their ranges, such as ``{"a": (0, 2), "b": (-1, 1)}``.

    Raises
    ------
    BracketryError
        As for :func:`parameter_cases`.
    """
    parts = [
        f"{name_of(name, 'ranges')}={expression(low, 'ranges')}..{expression(high, 'ranges')}"
        for name, (low, high) in ranges.items()
    ]
    answer = _native.parameter_map(model_of(system), ",".join(parts), cells, conditions)
    return result_of(ParameterMap, parsed(answer["json"]), answer)


def identifiability(
    system: System,
    *,
    known_initial: Mapping[Any, Any] | Sequence[Any] = (),
    unknown_inputs: Sequence[Any] = (),
    count: bool = True,
) -> Identifiability:
    """Local and global identifiability of parameters and initial states, and identifiable combinations.

    Parameters
    ----------
    system
        The model.
    known_initial
        States whose initial value is known; with numbers as ``{"x": 0}``, where None stands for a known generic value.
    unknown_inputs
        Inputs that are unknown functions of time.
    count
        Whether to count the values that give the same outputs, which decides global identifiability.

    Raises
    ------
    BracketryError
        For unknown names, and for models without outputs.
    """
    if isinstance(known_initial, Mapping):
        pairs = [(name_of(k, "known_initial"), v) for k, v in known_initial.items()]
        known = [k if v is None else f"{k}={expression(v, 'known_initial')}" for k, v in pairs]
    else:
        known = [name_of(k, "known_initial") for k in listed(known_initial, "known_initial")]
    unknown = [name_of(k, "unknown_inputs") for k in listed(unknown_inputs, "unknown_inputs")]
    answer = _native.identifiability(model_of(system), known, unknown, count)
    return result_of(Identifiability, parsed(answer["json"]), answer)
