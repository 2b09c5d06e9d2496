"""Normal forms and decompositions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from . import _native
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, listed, name_of


@dataclass(frozen=True, eq=False, kw_only=True)
class Transformation(Result):
    """A model in a normal form or decomposition, or why there is none."""

    model: str
    form: str
    outcome: Literal["found", "impossible", "not_found"]
    #: Why there is no such form, or why it was not found.
    reason: str | None = None
    #: Each new state as a function of the old ones.
    coordinates: dict[str, str] = field(repr=False, default_factory=dict)
    #: Each old state as a function of the new ones; None if that was not found in closed form.
    inverse: dict[str, str] | None = field(repr=False, default=None)
    #: Each old input as a function of old states and new inputs; empty if the inputs stay.
    feedback: dict[str, str] = field(repr=False, default_factory=dict)
    new_inputs: dict[str, str] = field(repr=False, default_factory=dict)
    #: The feedback that would turn the last derivatives of the outputs into new inputs, where the form keeps the inputs.
    linearizing_feedback: dict[str, str] = field(repr=False, default_factory=dict)
    singular_set: str | None = field(repr=False, default=None)
    #: Where the formulas of the inverse hold, besides.
    inverse_valid: str | None = field(repr=False, default=None)
    regular_at_point: bool | None = field(repr=False, default=None)
    #: Groups of the new states.
    blocks: list[dict[str, Any]] = field(repr=False, default_factory=list)
    notes: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: The model in the new coordinates.
    system: System | None = field(repr=False, default=None)
    #: Systems within, such as the zero dynamics, by name.
    parts: dict[str, System] = field(repr=False, default_factory=dict)

    @property
    def found(self) -> bool:
        return self.outcome == "found"


def transform(
    system: System,
    to: str,
    at: Mapping[Any, Any] | str | None = None,
    *,
    outputs: Sequence[Any] = (),
    time_limit: float = 120.0,
) -> Transformation:
    """The model in a normal form or decomposition, with the change of coordinates, its inverse, and the feedback.

    Parameters
    ----------
    system
        The model, affine in its inputs (see `affinize`) and without switching.
    to
        "brunovsky", "byrnes-isidori", "kalman", "accessible", "observable", "observer", "flat", or "chained".
    at
        Point near which branches are chosen, instead of the model's.
    outputs
        Names of the outputs that the form is about; all where none are given.
    time_limit
        Seconds after which the search ends.

    Returns
    -------
    Transformation

    Raises
    ------
    BracketryError
        For an unknown form, output, or point.
    """
    if isinstance(at, Mapping):
        named = {name_of(k, "at"): v for k, v in at.items()} or {model_of(system).states[0]: 0}
        at = ", ".join(f"{name}={expression(value, 'at')}" for name, value in named.items())
    names = [name_of(n, "outputs") for n in listed(outputs, "outputs")]
    answer = _native.transform(model_of(system), to, at, names, float(time_limit))
    model = answer["model"]
    return result_of(
        Transformation,
        parsed(answer["json"]),
        answer,
        system=None if model is None else System._of(model),
        parts={name: System._of(part) for name, part in answer["parts"]},
    )
