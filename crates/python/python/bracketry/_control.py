"""Closed loops."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any, TypedDict

import numpy as np

from . import _native
from ._native import BracketryError
from ._result import parsed, real, result_of
from ._sampled import Sampled
from ._system import System, model_of
from ._tables import Floats
from ._text import toml_document, whole


class ProblemArguments(TypedDict):
    """A problem for the native functions."""

    path: str | None
    text: str | None
    folder: str
    models: dict[str, _native.Model]


@dataclass(frozen=True, eq=False, kw_only=True)
class ClosedLoop(Sampled):
    """A closed loop: samples, figures of the solver, what was reached.

    ``loop["x"]`` is a state or input by name. Of k samples there are k + 1 times and states and k inputs, each applied from its
    time on.
    """

    #: Whether it did what was asked: every target met (without targets: the plan converged), no sample without a solution.
    succeeded: bool
    #: Σ dt·stage at the sampled states and applied inputs.
    closed_loop_cost: float
    #: Cost that the first plan predicts.
    open_loop_cost: float
    x_final: dict[str, float]
    #: Number of samples.
    steps: int
    constraint_violation_max: float
    #: What is missing to every target at the end.
    miss: dict[str, float] = field(default_factory=dict)
    #: Outcomes of the samples: solved, inaccurate, infeasible, fallback …
    status: dict[str, Any] = field(repr=False, default_factory=dict)
    #: Times per sample: median, p99, max.
    solve_ms: dict[str, float] = field(repr=False, default_factory=dict)
    period_ms: float = field(repr=False, default=0.0)
    plan: dict[str, Any] | None = field(repr=False, default=None)
    #: End time and parameters that were free: ``end_time``, ``parameters``, ``status`` …
    found: dict[str, Any] | None = field(repr=False, default=None)
    #: What went wrong, and what to do about it.
    notes: list[str] = field(repr=False, default_factory=list)
    #: What was measured at each sample, shape (k, number of outputs).
    measured: Floats = field(repr=False)
    #: States handed to the controller, shape (k, n).
    estimates: Floats = field(repr=False)


def control(
    problem: str | PathLike[str] | Mapping[str, Any],
    *,
    models: Mapping[str, System] | None = None,
    seed: int | None = None,
) -> ClosedLoop:
    """Runs the closed loop of a control problem on its plant.

    Parameters
    ----------
    problem
        A problem file; its text; or its tables as a mapping, in which ``model`` and ``plant`` may be systems.
    models
        Systems by the names under which the problem speaks of them; other names are files.
    seed
        Seed of the measurement noise in place of the problem's.

    Returns
    -------
    ClosedLoop

    Raises
    ------
    BracketryError
        For a problem that contradicts itself, and if the plant stops. A plant whose states are no numbers is in the result, with a
        `RuntimeWarning`.
    """
    answer = _native.control(**problem_of(problem, models), seed=None if seed is None else whole(seed, "seed"))
    data = parsed(answer["json"])
    lost = np.flatnonzero(~np.isfinite(answer["states"]).all(axis=1))
    if lost.size:
        warnings.warn(f"the plant ended early, at t = {answer['t'][lost[0]]:.6g}: see `notes`", RuntimeWarning, stacklevel=2)
    return result_of(
        ClosedLoop,
        data,
        answer,
        closed_loop_cost=real(data["closed_loop_cost"]),
        open_loop_cost=real(data["open_loop_cost"]),
        constraint_violation_max=real(data["constraint_violation_max"]),
        x_final={name: real(value) for name, value in data["x_final"].items()},
        t=answer["t"],
        states=answer["states"],
        inputs=answer["inputs"],
        measured=answer["measured"],
        estimates=answer["estimates"],
        state_names=answer["state_names"],
        input_names=answer["input_names"],
        titles=answer["titles"],
    )


def problem_of(problem: str | PathLike[str] | Mapping[str, Any], models: Mapping[str, System] | None) -> ProblemArguments:
    """What the native functions are told of a problem."""
    named = dict(models or {})
    path = text = None
    if isinstance(problem, Mapping):
        tables = dict(problem)
        for role in ("model", "plant"):
            if isinstance(tables.get(role), System):
                named[role] = tables[role]
                tables[role] = role
        text = toml_document(tables, "problem")
    elif isinstance(problem, str) and ("\n" in problem or ("=" in problem and not problem.endswith(".toml"))):
        text = problem
    elif isinstance(problem, (str, PathLike)):
        path = fspath(problem)
    else:
        raise BracketryError("problem: give a file, the text of one, or its tables as a mapping")
    if path is not None and named:
        raise BracketryError("models go with a problem that is given as text or as a mapping, not with a file")
    systems = {name: model_of(system, name) for name, system in named.items()}
    return {"path": path, "text": text, "folder": "", "models": systems}
