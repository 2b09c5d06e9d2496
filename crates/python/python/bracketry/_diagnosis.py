"""What a model gets wrong in measured data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from . import _native
from ._native import BracketryError, Page
from ._result import Result, fields_of, parsed, result_of
from ._simulation import Hold, Trajectory
from ._system import System, model_of
from ._tables import Floats, Table, columns_of, path_of
from ._text import listed, whole


@dataclass(frozen=True)
class Estimate:
    """A number with its uncertainty."""

    value: float
    std: float
    #: The interval that holds the true value with 95 % probability; None where it was not made.
    interval: list[float] | None = None
    unit: str = ""


@dataclass(frozen=True)
class Rival:
    """A rival that the experiment cannot distinguish from a cause."""

    name: str
    equation: str
    term: str
    why: str


@dataclass(frozen=True)
class Cause:
    """A cause of what the model gets wrong."""

    name: str
    #: The state, input or measured column that it acts on.
    equation: str
    term: str
    parameters: dict[str, Estimate]
    p_value: float
    #: Names that this experiment cannot distinguish from it.
    confusable_with: list[str]
    #: What to measure to distinguish them.
    separating_experiment: str
    rivals: list[Rival] = field(default_factory=list)
    share: float | None = None
    #: What is odd about the values, as a negative friction coefficient.
    flags: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    """Where the refitted model is wrong."""

    equation: str
    regime: str
    share: float
    time: float | None = None


@dataclass(frozen=True)
class Gain:
    """How much better the extended model predicts."""

    metric: str
    horizons_s: list[float]
    before: list[float]
    after: list[float]
    as_given: list[float]
    held_out: bool
    predictions: list[int]
    equation_error_before: float | None = None
    equation_error_after: float | None = None
    equation_error_as_given: float | None = None
    equation_bandwidth_hz: float | None = None


@dataclass(frozen=True)
class Windows:
    """The windows in which a model was fitted, each with an initial state of its own."""

    #: Their number.
    count: int
    #: Their median length in seconds.
    seconds: float


@dataclass(frozen=True)
class RefittedParameter(Estimate):
    """A parameter of the given model, refitted."""

    #: Its value in the model.
    before: float = field(kw_only=True)

    @property
    def after(self) -> float:
        """Its value refitted."""
        return self.value


@dataclass(frozen=True)
class Candidate:
    """An explanation that was tried."""

    name: str
    equation: str
    term: str
    p_value: float
    chosen: bool
    share: float | None = None
    interval: list[float] | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Result):
    """What a model gets wrong in measured data: the cause by name, the extended model, the gain."""

    model: str
    verdict: Literal[
        "cause_found",
        "unknown_term",
        "partly_explained",
        "no_gain",
        "nothing_found",
        "unexplained",
        "uninformative",
        "wrong_sign",
        "wrong_unit",
        "swapped_columns",
        "wrong_column",
    ]
    #: Why, in a sentence.
    reason: str
    causes: list[Cause]
    #: Where the refitted model is wrong (`where` in the JSON object), the largest share first.
    where: list[Place] = field(repr=False)
    gain: Gain | None = field(repr=False, default=None)
    #: The refitted parameters by name.
    parameters: dict[str, RefittedParameter] = field(repr=False)
    #: Candidates, best first.
    candidates: list[Candidate] = field(repr=False)
    #: The windows of the fit; None where nothing was fitted.
    windows: Windows | None = field(repr=False, default=None)
    #: The model with the causes in it; None without any.
    extended_model: System | None = field(repr=False, default=None)
    #: What the extended model changes in what the inputs reach.
    ranks: dict[str, Any] | None = field(repr=False, default=None)
    #: What was noticed in the data, one per run.
    data: list[dict[str, Any]] = field(repr=False, default_factory=list)
    notes: list[str] = field(repr=False, default_factory=list)
    seconds: float = field(repr=False, default=0.0)
    _page: Page | None = field(repr=False, default=None)

    def page(self) -> str:
        """The report with its figures as one HTML page. A result that came out of a pickle has none."""
        if self._page is None:
            raise BracketryError("the page does not travel with a pickled result: make it where the result was made")
        return self._page.html()


def diagnose(
    system: System,
    data: Table | Sequence[Table],
    validate: Table | Sequence[Table] | None = None,
    *,
    hold: Hold | None = None,
    rename: Mapping[str, str] | None = None,
    fix: Sequence[str] = (),
    reference: System | None = None,
    max_causes: int | None = None,
    seed: int | None = None,
    window: float | None = None,
    horizon: Sequence[float] = (),
    time_limit: float = 600.0,
    threads: int | None = None,
) -> Diagnosis:
    """Finds what a model gets wrong in measured data.

    A run is a file (CSV or NPZ), a mapping of arrays, a DataFrame or a :class:`Trajectory` (its inputs and outputs), with a column ``t`` in seconds, one
    for each input and one for each measured state or output; NaN in a measured column is a lost value.

    Parameters
    ----------
    system
        The model.
    data
        One run, or several.
    validate
        Runs that no fit sees, to measure the gain on.
    hold
        How inputs go on between samples; if left out they are held, and derivatives of inputs follow straight lines.
    rename
        Model names of columns.
    fix
        Parameters that keep their values.
    reference
        Another model of the same system: terms that the first lacks become candidates.
    max_causes
        Most causes that are named together.
    seed
        Seed of what is resampled.
    window
        Length of the windows in seconds; chosen from the data if left out.
    horizon
        Horizons in seconds at which predictions are compared; chosen from the data if left out.
    time_limit
        The search for causes ends after this many seconds in all; a note says what was left out.
    threads
        Threads to work with, all of the machine if left out. Results do not depend on them.

    Returns
    -------
    Diagnosis

    Raises
    ------
    BracketryError
        For data that do not fit the model, with place and remedy.
    """
    answer = _native.diagnose(
        model_of(system),
        _runs(data, "data"),
        [] if validate is None else _runs(validate, "validate"),
        hold_inputs=hold,
        rename=list((rename or {}).items()),
        fix=listed(fix, "fix"),
        reference=None if reference is None else model_of(reference, "reference"),
        max_causes=None if max_causes is None else whole(max_causes, "max_causes"),
        seed=None if seed is None else whole(seed, "seed"),
        window=window,
        horizon=[float(h) for h in horizon],
        time_limit=float(time_limit),
        threads=0 if threads is None else whole(threads, "threads"),
    )
    found = parsed(answer["json"])
    gain = found.get("gain")
    windows = found.get("windows")
    extended = answer["extended_model"]
    return result_of(
        Diagnosis,
        found,
        answer,
        _page=answer["page"],
        causes=[_cause(c) for c in found["causes"]],
        where=[fields_of(Place, p) for p in found["where"]],
        gain=None if gain is None else fields_of(Gain, gain),
        parameters={name: fields_of(RefittedParameter, p, value=p["after"]) for name, p in found["parameters"].items()},
        candidates=[fields_of(Candidate, c) for c in found["candidates"]],
        windows=None if windows is None else fields_of(Windows, windows),
        extended_model=None if extended is None else System._of(extended),
    )


def _cause(data: Mapping[str, Any]) -> Cause:
    return fields_of(
        Cause,
        data,
        parameters={name: fields_of(Estimate, p) for name, p in data["parameters"].items()},
        rivals=[fields_of(Rival, r) for r in data.get("rivals", [])],
    )


def _runs(runs: Any, what: str) -> list[str | tuple[str, dict[str, Floats]]]:
    """Runs as the native module takes them."""
    if isinstance(runs, (list, tuple)):
        listed = list(runs)
    else:
        listed = [runs]
    taken: list[str | tuple[str, dict[str, Floats]]] = []
    for k, run in enumerate(listed, start=1):
        path = path_of(run)
        name = f"{what} {k}" if len(listed) > 1 else what
        columns = run.measurements() if isinstance(run, Trajectory) else None
        taken.append(path if path is not None else (name, columns or columns_of(run, name)))
    return taken
