"""What the inputs of a model reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from . import _native
from ._result import Result, fields_of, parsed, result_of
from ._system import System, model_of
from ._text import expression, listed, name_of

#: Decided, or "unknown"; the report gives the reason.
Answer: TypeAlias = bool | Literal["unknown"]
Dimension: TypeAlias = int | Literal["unknown"]


@dataclass(frozen=True, kw_only=True)
class Reach:
    """Dimensions of what the inputs reach."""

    #: Entry k: dimension of the span of all brackets of length up to k + 1 of drift and input fields.
    growth: list[int]
    #: Dimension of the accessibility algebra: of the set that is reached.
    accessible_dimension: Dimension
    #: Entry k: the same after k rounds of brackets of the input fields.
    strong_growth: list[int]
    #: Dimension of the strong accessibility algebra: of the set that is reached at one time.
    strongly_accessible_dimension: Dimension
    #: Names of brackets behind `growth`.
    basis: list[str] = field(default_factory=list)
    #: Names of brackets behind `strong_growth`.
    strong_basis: list[str] = field(default_factory=list)
    #: Why something is unknown.
    reason: str | None = None


@dataclass(frozen=True, kw_only=True)
class Mode(Reach):
    """What holds while the signs of all switching functions stay as they are."""

    #: Sign of each switching function; empty for a smooth model.
    signs: dict[str, int]
    #: Functions of the state that no input influences.
    autonomous: list[str] | Literal["unknown"]
    involutive: Answer
    static_feedback_linearizable: Answer


@dataclass(frozen=True, kw_only=True)
class LocalControllability:
    """Small-time local controllability, decided by sufficient and necessary conditions."""

    verdict: Literal["yes", "no", "inconclusive"]
    reason: str
    weights: list[int] | None = None


@dataclass(frozen=True, kw_only=True)
class AtPoint(Reach):
    """What holds at the point of the model."""

    #: Of which model the dimensions and linear statements are: "smoothed" where switching functions vanish at the point.
    of: Literal["model", "smoothed"]
    equilibrium: Answer
    #: Inputs whose values given with the point lie outside of their ranges, so that it is no equilibrium.
    outside_ranges: list[str] = field(default_factory=list)
    stlc: LocalControllability
    #: That of the smoothed model, which says nothing of the model.
    smoothed_stlc: LocalControllability | None = None
    vanishing: list[str] = field(default_factory=list)
    #: Rank of the Kalman matrix; None if the point is no equilibrium.
    linear_controllability_rank: int | None = None
    stabilizable: Answer | None = None
    stabilizable_reason: str | None = None
    uncontrollable_modes: list[dict[str, Any]] | Literal["unknown"] | None = None
    #: Brockett's necessary condition for stabilization by continuous state feedback.
    brockett_condition: Answer | None = None


@dataclass(frozen=True, kw_only=True)
class Affinization:
    """How a model became affine in its inputs."""

    #: none, input_change, feedback, input_augmentation or coordinate_change.
    method: str
    #: Integrators in front of each input that got any.
    integrators: dict[str, int]
    why: str
    #: The affine model; None if an equation is too long to be written.
    model: System | None
    #: New inputs with the functions of the old ones that they stand for.
    input_change: list[dict[str, Any]] = field(default_factory=list)
    coordinate_change: list[dict[str, Any]] = field(default_factory=list)
    #: All ways that were tried, accepted ones first.
    candidates: list[dict[str, Any]] = field(default_factory=list, repr=False)

    def __str__(self) -> str:
        return self.why if self.model is None else f"{self.why}\n{self.model}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Analysis(Result):
    """What the inputs of a model reach. Whatever could not be decided is "unknown"; the report gives the reason."""

    model: str
    #: Number of states of the affine model.
    states: int
    #: Number of inputs of the affine model.
    inputs: int
    #: Whether the model was affine as it stood.
    affine: bool
    affinization: Affinization = field(repr=False)
    #: One for each combination of signs of switching functions; exactly one for a smooth model.
    modes: list[Mode] = field(repr=False)
    #: All modes together; None for a smooth model.
    switched: Reach | None = field(repr=False, default=None)
    #: The model with smooth signs; None for a smooth model.
    smoothed: Reach | None = field(repr=False, default=None)
    #: None if the model gives no point, or if it could not be analyzed there.
    at_point: AtPoint | None = field(repr=False, default=None)
    involutive: Answer = "unknown"
    static_feedback_linearizable: Answer = "unknown"
    relative_degree: list[int] | Literal["unknown"] | None = None
    decoupling_determinant: str | None = None
    flatness: dict[str, Any] | None = field(repr=False, default=None)
    observability: dict[str, Any] | None = field(repr=False, default=None)
    #: The brackets that were asked for, one component per state.
    brackets: dict[str, Any] = field(repr=False, default_factory=dict)
    certificate: dict[str, Any] = field(repr=False, default_factory=dict)
    #: What the ranks mean, in plain language.
    summary: str = field(repr=False, default="")
    seconds: float = field(repr=False, default=0.0)
    #: The report as Markdown with formulas; notebooks show it.
    markdown: str = field(repr=False, default="")
    #: The report as a LaTeX document.
    latex: str = field(repr=False, default="")

    def _repr_markdown_(self) -> str:
        return self.markdown


def _affinization(data: Mapping[str, Any], model: _native.Model | None) -> Affinization:
    return fields_of(Affinization, data, model=None if model is None else System._of(model))


def analyze(
    system: System,
    at: str | Mapping[Any, Any] | None = None,
    *,
    brackets: Sequence[str] = (),
    determines: Sequence[Any] = (),
) -> Analysis:
    """Says what the inputs of a model reach: affine form, ranks, brackets, local verdicts, flatness, observability.

    Parameters
    ----------
    system
        The model.
    at
        Point of local statements in place of the model's, such as ``{"th": "pi/2"}``; unnamed states and inputs are 0, so that
        ``{}`` is the origin.
    brackets
        Brackets to write out, such as ``"[g1,[f,g1]]"``.
    determines
        Functions of states and parameters: do the outputs determine them while the parameters are unknown?

    Returns
    -------
    Analysis

    Raises
    ------
    BracketryError
        If no affine form is found, or for a point, bracket or function that cannot be read.
    """
    if isinstance(at, Mapping):
        # Without any name it is the origin.
        named = {name_of(k, "at"): v for k, v in at.items()} or {model_of(system).states[0]: 0}
        at = ", ".join(f"{name}={expression(value, 'at')}" for name, value in named.items())
    functions = [expression(f, "determines") for f in listed(determines, "determines")]
    answer = _native.analyze(model_of(system), at, listed(brackets, "brackets"), functions)
    data = parsed(answer["json"])
    point = data.get("at_point")
    point = point if isinstance(point, dict) else None
    reach = {k: fields_of(Reach, data[k]) for k in ("switched", "smoothed") if k in data}
    return result_of(
        Analysis,
        data,
        answer,
        affinization=_affinization(data["affinization"], answer["affine_model"]),
        modes=[fields_of(Mode, m) for m in data["modes"]],
        at_point=None if point is None else _at_point(point),
        markdown=answer["markdown"],
        latex=answer["latex"],
        **reach,
    )


def _at_point(point: dict[str, Any]) -> AtPoint:
    smoothed = point.get("smoothed_stlc")
    return fields_of(
        AtPoint,
        point,
        stlc=fields_of(LocalControllability, point["stlc"]),
        smoothed_stlc=None if smoothed is None else fields_of(LocalControllability, smoothed),
    )


def affinize(system: System) -> Affinization:
    """Makes a model affine in its inputs, by new inputs, feedback, integrators or new states.

    Returns
    -------
    Affinization

    Raises
    ------
    BracketryError
        If no affine form is found.
    """
    answer = _native.affinize(model_of(system))
    return _affinization(parsed(answer["json"]), answer["model"])
