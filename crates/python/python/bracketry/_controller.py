"""Controllers that are stepped on a plant of one's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from os import PathLike
from typing import Any

import numpy as np

from . import _native
from ._control import problem_of
from ._native import BracketryError, Step
from ._result import parsed
from ._system import System
from ._tables import Floats, floats
from ._text import number, whole


@dataclass(frozen=True, eq=False, kw_only=True)
class Prediction:
    """States and inputs that a controller expects.

    Of N intervals there are N + 1 times and states and N inputs, each from its time on.
    """

    #: Times in seconds, shape (N + 1,).
    t: Floats = field(repr=False)
    #: States, shape (N + 1, n).
    states: Floats = field(repr=False)
    #: Inputs, shape (N, m).
    inputs: Floats = field(repr=False)
    state_names: list[str]
    input_names: list[str]


def _by_name(values: Mapping[str, Any], names: list[str], what: str, absent: float | None) -> list[float]:
    """Numbers by name, in order; ``absent`` stands for what is missing, which is refused without it."""
    unknown = [str(name) for name in values if name not in names]
    if unknown:
        raise BracketryError(f"{what}: there is no `{unknown[0]}`; its names are {', '.join(names)}")
    missing = [name for name in names if name not in values]
    if missing and absent is None:
        raise BracketryError(f"{what}: `{missing[0]}` is missing; give {', '.join(names)}")
    wrong = [name for name in values if not isinstance(values[name], Real)]
    if wrong:
        raise BracketryError(f"{what}: `{wrong[0]}` is not a number: {values[wrong[0]]!r}")
    return [float(values[name]) if name in values else float(absent or 0.0) for name in names]


def _measured(answer: Callable[..., Step], names: Callable[[], list[str]], y: Any, *time: Any) -> Step:
    """The answer to a measurement; what is no list of numbers, or no time, is refused as everything else."""
    if isinstance(y, Mapping):
        given = {name: float("nan") if value is None else value for name, value in y.items()}
        y = _by_name(given, names(), "the measurement", None)
    elif type(y) is not list and (type(y) is not np.ndarray or y.dtype != np.float64):
        y = floats(y, "the measurement")
    try:
        return answer(y, *time)
    except BracketryError:
        raise
    except (TypeError, ValueError) as e:
        raise BracketryError(f"the measurement is not a list of numbers, or its time is not a number: {e}") from None


def _remade(problem: Any, models: Mapping[str, System] | None, log: int) -> Controller:
    return Controller(problem, models=models, log=log)


class Controller:
    """The controller of a problem, stepped on a plant of one's own: what :func:`control` runs, with its estimator, delay
    compensation and failure policy.

    >>> import bracketry
    >>> mass = bracketry.System(states=["x", "v"], inputs=["a"], dynamics={"x": "v", "v": "a"})
    >>> controller = bracketry.Controller({
    ...     "model": mass,
    ...     "horizon": {"steps": 30, "dt": 0.1},
    ...     "cost": {"stage": "x^2 + 0.1*v^2 + 0.01*a^2"},
    ...     "constraints": {"a": {"min": -1, "max": 1}},
    ...     "run": {"x0": {"x": 1}},
    ... })
    >>> x, v = 1.0, 0.0
    >>> for _ in range(100):
    ...     (a,) = controller.step([x, v]).u
    ...     x, v = x + 0.1 * v + 0.005 * a, v + 0.1 * a
    >>> abs(x) < 1e-3
    True

    Parameters
    ----------
    problem, models
        As for :func:`control`. What the problem says of noise, faults and the plant is left out.
    log
        Number of samples that :attr:`log` keeps, the last ones; 0 for none.

    Raises
    ------
    BracketryError
        For a problem that contradicts itself.
    """

    def __init__(
        self,
        problem: str | PathLike[str] | Mapping[str, Any],
        *,
        models: Mapping[str, System] | None = None,
        log: int = 10_000,
    ) -> None:
        self._given = (problem, None if models is None else dict(models), log)
        self._native = _native.LiveController(**problem_of(problem, models), log=whole(log, "log"))

    def __repr__(self) -> str:
        return f"Controller(measured={self.measured}, inputs={self.inputs}, period={self.period})"

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy starts again: with the problem as it was given, at sample 0."""
        return _remade, self._given

    def step(self, y: Sequence[float] | Floats | Mapping[str, float | None], t: float | None = None) -> Step:
        """The input for a measurement: :meth:`prepare` where it has not been called, then :meth:`feedback`.

        Parameters
        ----------
        y
            What was measured, in the order of :attr:`measured` or by name; NaN (by name also None) where nothing was.
        t
            Time of the measurement in s, on a clock of your own. Samples that have passed since the last one without a
            measurement are compensated: the last input counts as held. Without a time, every call is the next sample.

        Returns
        -------
        Step
            ``u``, the input to hold for a :attr:`period`, with ``status`` (solved, inaccurate, infeasible, played_out or fallback),
            ``reason`` of a fallback, ``source`` of the input (program, tangent, plan, brake or rest), ``sample``, ``missed``
            samples before it, ``estimate`` of the states, ``innovation``, by which the states differ from what the plan before predicted
            (None for the first sample, after missed ones, and with a compensated delay), ``residual`` of the conditions of optimality
            (None where nothing was solved), ``programs`` solved and ``iterations`` in them, ``feedback_seconds`` and ``prepare_seconds``.

        Raises
        ------
        BracketryError
            For a measurement of the wrong length, and for a time that is not finite, not after the last, or more than a horizon
            after it. The controller is then as it was.
        """
        return _measured(self._native.step, lambda: self.measured, y, t)

    def prepare(self) -> None:
        """Everything that does not need the next measurement; call it while the input acts."""
        self._native.prepare()

    def feedback(self, y: Sequence[float] | Floats | Mapping[str, float | None]) -> Step:
        """The input for a measurement, as fast as possible after :meth:`prepare`."""
        return _measured(self._native.feedback, lambda: self.measured, y)

    def lost(self) -> Step:
        """The input of a sample whose measurement has not come: that of the failure policy."""
        return self._native.lost()

    def predict(self) -> Prediction:
        """What the plan behind the last input predicts, from the time on at which that input acts."""
        return Prediction(**self._native.predict(), state_names=self.states, input_names=self.inputs)

    def reset(self, x0: Sequence[float] | Floats | Mapping[str, float] | None = None) -> None:
        """Starts again at sample 0, from the problem's initial state or another, as a list or by name (0 for what is missing).

        Changes of references, parameters, bounds and targets stay.
        """
        if isinstance(x0, Mapping):
            x0 = _by_name(x0, self.states, "x0", 0.0)
        self._native.reset(None if x0 is None else floats(x0, "x0"))

    def set_reference(self, name: str, value: float | Sequence[float] | Floats) -> None:
        """Gives a reference a value from now on, or values at the next samples, of which the last one holds."""
        values = floats(value, name)
        if getattr(value, "__len__", None) is None:
            self._native.set_reference(name, float(values[0]))
        else:
            self._native.set_reference_ahead(name, values)

    def set_parameters(self, **values: float) -> None:
        """Gives parameters of the controller's model new values; they have to stand in ``live_parameters`` of the problem.

        Where one of them is refused, none is changed.
        """
        self._native.set_parameters([(name, float(number(value, name))) for name, value in values.items()])

    def set_bounds(self, name: str, min: float | None = None, max: float | None = None) -> None:  # noqa: A002
        """Replaces the bounds of a state or an input; None is no bound."""
        ends = floats([-np.inf if min is None else min, np.inf if max is None else max], f"the bounds of {name}")
        self._native.set_bounds(name, float(ends[0]), float(ends[1]))

    def set_target(self, name: str, value: float) -> None:
        """Replaces the target of a state."""
        self._native.set_target(name, float(number(value, name)))

    @property
    def log(self) -> dict[str, Floats]:
        """The last samples as a table for :func:`diagnose`: ``t``, measured outputs, inputs that acted."""
        columns = self._native.log()
        if columns is None:
            raise BracketryError("this controller keeps no log: give the number of samples to keep, log=10000")
        return columns

    @property
    def status(self) -> dict[str, Any]:
        """Outcomes of the samples since the last reset: solved, inaccurate, infeasible, fallback …"""
        return parsed(self._native.counts())

    @property
    def predicted_cost(self) -> float:
        """Cost of the last plan over the horizon, without penalties."""
        return self._native.predicted_cost

    def slacks(self) -> dict[str, float]:
        """Slacks of the soft bounds along the last plan: the largest violation of each, by the name of the state or constraint."""
        return self._native.slacks()

    @property
    def period(self) -> float:
        """Sampling period in s."""
        return self._native.period

    @property
    def delay(self) -> int:
        """Samples between a measurement and its input that the controller predicts over."""
        return self._native.delay

    @property
    def measured(self) -> list[str]:
        """Names of the entries of a measurement: the states, or the outputs of the estimator."""
        return self._native.measured

    @property
    def states(self) -> list[str]:
        """Names of the states."""
        return self._native.states

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
        return self._native.inputs

    @property
    def references(self) -> list[str]:
        """Names of the references."""
        return self._native.references

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters that :meth:`set_parameters` changes."""
        return self._native.parameters

    @property
    def targets(self) -> list[str]:
        """Names of the states that have a target."""
        return self._native.targets
