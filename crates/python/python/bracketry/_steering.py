"""Inputs that move a model from one state to another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._from_rest import bounds_text
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, name_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Steering(Result):
    """Inputs from one state to another, with the motion of the model under them."""

    model: str
    #: "first-guess": the motion ends elsewhere, or an input leaves its range.
    status: Literal["reached", "first-guess", "not-found"]
    #: Initial state and the state asked for at the end, by name.
    start: dict[str, float] = field(repr=False)
    goal: dict[str, float] = field(repr=False)
    #: Largest difference of a state from the goal at the end of the simulated motion; `None` without one.
    end_error: float | None
    #: "chained", "nilpotent", "flat", "loops" or "shooting"; `None` without a motion.
    method: str | None = None
    #: What the method was: coordinates, brackets, flat outputs.
    plan: dict[str, Any] = field(repr=False, default_factory=dict)
    duration: float | None = None
    #: Newton steps on the inputs that removed what was left of the end error.
    corrections: int = field(repr=False, default=0)
    notes: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: Methods that did not reach the end, each with its reason.
    attempts: list[dict[str, str]] = field(repr=False, default_factory=list)
    #: Times of the rows of the inputs, and the inputs by name; constant or along lines between them (`hold`).
    input_times: Floats = field(repr=False)
    inputs: dict[str, Floats] = field(repr=False)
    hold: str | None = field(repr=False, default=None)
    #: Times and states of the motion.
    t: Floats = field(repr=False)
    states: dict[str, Floats] = field(repr=False)
    #: Text of a scenario that replays the inputs from `inputs.csv`.
    scenario: str | None = field(repr=False, default=None)
    #: The model that was steered, with integrators in front of inputs whose derivatives it uses.
    system: System = field(repr=False)

    @property
    def reached(self) -> bool:
        return self.status == "reached"


def _point(values: Mapping[Any, Any] | str, what: str) -> str:
    if isinstance(values, str):
        return values
    return ", ".join(f"{name_of(k, what)}={expression(v, what)}" for k, v in values.items())


def steer(
    system: System,
    goal: Mapping[Any, Any] | str,
    start: Mapping[Any, Any] | str | None = None,
    *,
    bounds: Mapping[Any, tuple[Any, Any]] | str = "",
    duration: float | None = None,
    method: Literal["auto", "chained", "nilpotent", "flat", "loops", "shooting"] = "auto",
    time_limit: float = 120.0,
    seed: int = 1,
) -> Steering:
    """Finds inputs that move the model from `start` (its point, if none is given) to `goal`.

    States that are not named are 0. Whatever the method, the end error is that of a simulation of the model. The
    method "loops" needs `bounds` of inputs and of their derivatives, such as ``{"der(X,2)": (-4, 4)}``.

    Returns
    -------
    Steering

    Raises
    ------
    BracketryError
        For a name that the model does not have, or a value that cannot be read.
    """
    asked = (None if start is None else _point(start, "start"), _point(goal, "goal"), bounds_text(bounds, "bounds"))
    answer = _native.steer(model_of(system), asked, duration, method, time_limit, seed)
    data = parsed(answer["json"])
    table = data.pop("inputs", None) or {"t": [], "hold": None, "columns": {}}
    header, rows = answer["trajectory"] or (["t"], [])
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), len(header)).T
    return result_of(
        Steering,
        data,
        answer,
        start=data["from"],
        goal=data["to"],
        input_times=np.array(table["t"], dtype=np.float64),
        inputs={name: np.array(u, dtype=np.float64) for name, u in table["columns"].items()},
        hold=table["hold"],
        t=columns[0],
        states=dict(zip(header[1:], columns[1:], strict=True)),
        scenario=answer["scenario"],
        system=System._of(answer["model"]),
    )
