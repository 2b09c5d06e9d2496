"""Simulations with exact stick–slip friction."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._native import BracketryError
from ._result import parsed, real, result_of
from ._sampled import Sampled
from ._system import System, model_of
from ._tables import Floats, columns_of, floats, path_of
from ._text import expression, name_of, number, numbers, toml_document

Hold: TypeAlias = Literal["previous", "linear"]
#: Rows of a result where neither `sample` nor a table says how many.
_ROWS = 1000


@dataclass(frozen=True)
class Event:
    """A change of mode of a switching function."""

    t: float
    switch: str
    #: +1, -1, slide or stick.
    from_mode: str
    to_mode: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory(Sampled):
    """A simulation: samples, events, how it ended.

    ``trajectory["x"]`` is the column of a state, input, or output by name, ``trajectory["t"]`` the times. Inputs are NaN where
    only derivatives of them are given.
    """

    model: str
    #: Outputs, shape (k, number of outputs), with sign(0) = 0.
    outputs: Floats = field(repr=False)
    output_names: list[str] = field(repr=False)
    #: Changes of mode, in order.
    events: list[Event] = field(repr=False)
    t_final: float
    x_final: dict[str, float]
    #: Whether the end was reached.
    finished: bool
    #: Where and why it stopped before.
    stopped: str | None = None
    #: Steps of the integrator.
    steps: int = 0
    ignored_columns: list[str] = field(repr=False, default_factory=list)
    #: Inputs that nothing drives.
    inputs_at_zero: list[str] = field(repr=False, default_factory=list)
    #: Derivatives of inputs whose impulses are neglected, because the input jumps or has kinks.
    impulses_left_out: list[str] = field(repr=False, default_factory=list)

    def _blocks(self) -> list[tuple[list[str], Floats]]:
        return [*super()._blocks(), (self.output_names, self.outputs)]

    def measurements(self) -> dict[str, Floats]:
        """Times, inputs and what sensors would give, by name: the outputs, or the states where the model has no outputs.

        This is what :func:`diagnose` takes of a trajectory.
        """
        states = [] if self.output_names else self.state_names
        kept = {"t", *self.input_names, *self.output_names, *states}
        return {name: column for name, column in self.columns().items() if name in kept}


def simulate(
    system: System,
    duration: float | None = None,
    *,
    x0: Mapping[Any, Any] | ArrayLike | None = None,
    inputs: Mapping[Any, Any] | str | PathLike[str] | Any = None,
    parameters: Mapping[Any, Any] | None = None,
    sample: float | None = None,
    start: float | None = None,
    hold: Hold = "previous",
    scenario: str | PathLike[str] | None = None,
    rtol: float | None = None,
    atol: float | None = None,
) -> Trajectory:
    """Integrates a model with exact stick–slip friction.

    Parameters
    ----------
    system
        The model.
    duration
        Seconds; with sampled inputs that come with times, the span of these if left out.
    x0
        Initial state by name, or an array in the order of the states; unnamed states have the values of the
        model's point, else 0.
    inputs
        Input signals by name: an expression in ``t`` (text or SymPy), a number, a pair (times, values), a
        function of time that is sampled every ``sample`` seconds. Or a table with a column ``t``: a file, a mapping of
        arrays or a DataFrame; ``der(X,2)`` names the second derivative of X. Inputs that nothing drives are zero.
    parameters
        Values in place of the model's.
    sample
        Seconds between the rows of the result: a thousandth of the duration, or as in the table, if left out.
    start
        Time at the beginning: 0, or the first of a table.
    hold
        How samples go on: "previous" holds each value until the next, "linear" draws straight lines.
    scenario
        A scenario file in place of all this.
    rtol
        Relative tolerance of the local error, 1e-9 if left out.
    atol
        Absolute tolerance, 1e-11 if left out.

    Returns
    -------
    Trajectory

    Raises
    ------
    BracketryError
        For what does not fit the model. Blow-up and chattering are in the result, with a `RuntimeWarning`.
    """
    model_of(system)
    native: dict[str, Any] = {"rtol": rtol, "atol": atol, "hold_inputs": hold}
    if scenario is not None:
        if any(v is not None for v in (duration, x0, inputs, parameters, sample, start)):
            raise BracketryError("a scenario file defines duration, x0, inputs, parameters, and sample: give it alone")
        return _run(system, file=fspath(scenario), **native)
    for what, seconds in (("duration", duration), ("sample", sample)):
        if seconds is not None and not 0 < float(number(seconds, what)):
            raise BracketryError(f"{what} must be positive, not {seconds}; give a time in seconds")
    own = {
        "x0": _initial(system, x0),
        "parameters": None if parameters is None else numbers(parameters, "parameters"),
    }
    table = path_of(inputs)
    if table is not None:
        if start is not None:
            raise BracketryError("a table of inputs starts at its first time: omit `start`")
        text = toml_document({"duration": 1.0, **own}, "simulate")
        return _run(system, table=table, text=text, duration=duration, sample=sample, **native)
    samples: dict[str, tuple[Floats, Floats]] = {}
    functions: dict[str, Callable[[Any], Any]] = {}
    ignored: list[str] = []
    expressions: dict[str, str] = {}
    if inputs is not None and not isinstance(inputs, Mapping):
        inputs = columns_of(inputs, "inputs")
    given = {name_of(k, "inputs"): v for k, v in (inputs or {}).items()}
    if "t" in given and "t" not in system.inputs:
        times = floats(given.pop("t"), "inputs: column `t`")
        if len(times) < 2:
            raise BracketryError("inputs: the table has fewer than two rows; give at least two samples")
        first, last = float(times[0]), float(times[-1])
        start = first if start is None else start
        duration = last - start if duration is None else duration
        sample = (last - first) / (len(times) - 1) if sample is None else sample
        known = {*system.inputs, *_derivative_names(system)}
        for name, values in given.items():
            if name.replace(" ", "") in known:
                samples[name.replace(" ", "")] = (times, floats(values, f"inputs: column `{name}`"))
            else:
                ignored.append(name)
        if not samples and system.inputs:
            raise BracketryError(
                f"inputs: no column has the name of an input of the model; name them {', '.join(sorted(known))}"
            )
    else:
        for name, value in given.items():
            if isinstance(value, tuple) and len(value) == 2:
                samples[name] = (floats(value[0], f"times of `{name}`"), floats(value[1], f"values of `{name}`"))
            elif callable(value) and not hasattr(value, "free_symbols"):
                functions[name] = value
            else:
                expressions[name] = expression(value, f"inputs, {name}")
    if duration is None and samples:
        begin = min(t[0] for t, _ in samples.values())
        start = float(begin) if start is None else start
        duration = float(max(t[-1] for t, _ in samples.values()) - start)
    if duration is None:
        raise BracketryError("how long? give a duration in seconds")
    start = 0.0 if start is None else float(start)
    for name, function in functions.items():
        step = float(duration) / _ROWS if sample is None else float(sample)
        grid = floats(start + step * np.arange(int(np.floor(float(duration) / step + 1e-9)) + 1), "times")
        samples[name] = (grid, _sampled(function, grid, name))
    text = toml_document({"duration": duration, "sample": sample, "inputs": expressions or None, **own}, "simulate")
    return _run(system, text=text, samples=samples, start=start, ignored=ignored, **native)


def _run(
    system: System,
    *,
    text: str | None = None,
    file: str | None = None,
    table: str | None = None,
    samples: Mapping[str, tuple[Floats, Floats]] | None = None,
    start: float = 0.0,
    duration: float | None = None,
    sample: float | None = None,
    ignored: list[str] | None = None,
    **native: Any,
) -> Trajectory:
    answer = _native.simulate(
        system._model,
        text=text,
        file=file,
        table=table,
        samples=dict(samples or {}),
        start=start,
        duration=duration,
        sample=sample,
        ignored=ignored or [],
        **native,
    )
    data = parsed(answer["json"])
    if not data["finished"]:
        warnings.warn(f"the simulation ended early: {data['stopped']}", RuntimeWarning, stacklevel=3)
    return result_of(
        Trajectory,
        data,
        answer,
        t=answer["t"],
        states=answer["states"],
        inputs=answer["inputs"],
        outputs=answer["outputs"],
        state_names=system.states,
        input_names=system.inputs,
        output_names=system.outputs,
        titles=system._model.titles,
        events=[Event(e["t"], e["switch"], e["from"], e["to"]) for e in data["events"]],
        x_final={name: real(value) for name, value in data["x_final"].items()},
    )


def _derivative_names(system: System) -> list[str]:
    return [f"der({name},{order})" for name, order in system.input_derivatives]


def _initial(system: System, x0: Any) -> dict[str, Any] | None:
    if x0 is None:
        return None
    if isinstance(x0, Mapping):
        return numbers(x0, "x0")
    values = floats(x0, "x0")
    if len(values) != len(system.states):
        raise BracketryError(f"x0 has {len(values)} entries; the model has the states {', '.join(system.states)}")
    return dict(zip(system.states, values.tolist(), strict=True))


def _sampled(function: Callable[[Any], Any], times: Floats, name: str) -> Floats:
    """A function of time at all times: called with one at a time, as it may not take arrays."""
    return floats([float(function(float(t))) for t in times], f"values of `{name}`")

