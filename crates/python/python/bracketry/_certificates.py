"""Lyapunov functions, regions of attraction, storage functions, and conserved functions, with exact certificates."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from . import _native
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, listed, name_of


@dataclass(frozen=True, eq=False, kw_only=True)
class Certification(Result):
    """What is proved of a polynomial model at its point.

    A finding is a dictionary with ``proved``; if that is true, with ``conclusion``, ``function``, and ``certificate`` (for a region also
    ``level``), else with ``reason``. What was not sought is None.
    """

    model: str
    #: Whether everything that was sought is proved.
    proved: bool
    #: Exact text and value of each state and input.
    point: dict[str, dict[str, Any]] = field(repr=False)
    #: Eigenvalues of the linearization: "left", "on_axis", "right".
    eigenvalues: dict[str, int] | None = field(repr=False, default=None)
    conserved: dict[str, Any] | None = field(repr=False, default=None)
    lyapunov: dict[str, Any] | None = field(repr=False, default=None)
    region: dict[str, Any] | None = field(repr=False, default=None)
    passivity: dict[str, Any] | None = field(repr=False, default=None)
    seconds: float = field(repr=False, default=0.0)


def _point_and_feedback(
    system: System, at: Mapping[Any, Any] | str | None, feedback: Mapping[Any, Any] | None
) -> tuple[str | None, list[str]]:
    if isinstance(at, Mapping):
        named = {name_of(k, "at"): v for k, v in at.items()} or {model_of(system).states[0]: 0}
        at = ", ".join(f"{name}={expression(value, 'at')}" for name, value in named.items())
    laws = [f"{name_of(k, 'feedback')}={expression(v, 'feedback')}" for k, v in (feedback or {}).items()]
    return at, laws


def certify(
    system: System,
    at: Mapping[Any, Any] | str | None = None,
    *,
    feedback: Mapping[Any, Any] | None = None,
    find: str | Sequence[str] = "all",
    degree: int = 4,
    time_limit: float = 120.0,
) -> Certification:
    """Searches Lyapunov, storage, and conserved functions and a region of attraction, and proves them in rational arithmetic.

    Parameters
    ----------
    system
        A polynomial model.
    at
        Equilibrium instead of the model's point; unnamed states and inputs are 0.
    feedback
        Expressions of the states that set inputs, such as ``{"u": "-x - 2*v"}``.
    find
        ``"lyapunov"``, ``"region"``, ``"passivity"``, ``"conserved"``, several of these, or ``"all"``.
    degree
        Largest degree of the functions: 2 or 4.
    time_limit
        Seconds after which what is undecided is unknown.

    Returns
    -------
    Certification

    Raises
    ------
    BracketryError
        For names that the model does not have, and other bad arguments.
    """
    point, laws = _point_and_feedback(system, at, feedback)
    sought = [find] if isinstance(find, str) else [str(f) for f in listed(find, "find")]
    answer = _native.certify(model_of(system), point, laws, sought, int(degree), float(time_limit))
    return result_of(Certification, parsed(answer["json"]), answer)


def check_certificate(
    system: System,
    certificate: Mapping[str, Any],
    at: Mapping[Any, Any] | str | None = None,
    *,
    feedback: Mapping[Any, Any] | None = None,
) -> str | None:
    """What a certificate proves of the model, checked in rational arithmetic: its conclusion, or None if it proves nothing."""
    point, laws = _point_and_feedback(system, at, feedback)
    conclusion, _ = _native.check_certificate(model_of(system), point, laws, json.dumps(dict(certificate)))
    return conclusion
