"""Operating points, and the linear system around one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._result import Result, parsed, result_of
from ._system import System, model_of
from ._text import expression, listed, name_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Trim(Result):
    """An operating point, or the best point on the way to one."""

    model: str
    #: "out_of_range": the equations hold only with an input outside its range.
    status: Literal["found", "out_of_range", "not_found"]
    #: Value, role ("free", "fixed" or "held") and, where known, the exact value, by name.
    states: dict[str, dict[str, Any]] = field(repr=False)
    inputs: dict[str, dict[str, Any]] = field(repr=False)
    #: Time derivative of each state at the point.
    derivatives: dict[str, float] = field(repr=False)
    #: The largest derivative of those that shall vanish.
    residual: float
    #: Whether the equations hold exactly.
    exact: bool
    notes: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: Other operating points that the starts led to.
    others: list[dict[str, float]] = field(repr=False, default_factory=list)
    #: The model with its point there.
    system: System = field(repr=False)

    @property
    def found(self) -> bool:
        return self.status == "found"

    def __getitem__(self, name: str) -> float:
        """The value of a state or input."""
        return float((self.states | self.inputs)[name]["value"])


@dataclass(frozen=True)
class Gain:
    """A feedback u = -K x, or the gain L of a steady-state Kalman filter."""

    gain: Floats
    #: Solution of the Riccati equation.
    solution: Floats
    #: Norm of that equation's left side, relative to that of its terms.
    residual: float
    poles: NDArray[np.complex128]


@dataclass(frozen=True, eq=False, kw_only=True)
class Linearization(Result):
    """x' = A x + B u, y = C x + D u for deviations from a point."""

    model: str
    state_names: list[str] = field(repr=False)
    input_names: list[str] = field(repr=False)
    output_names: list[str] = field(repr=False)
    #: States, then inputs, at the point.
    point: list[float] = field(repr=False)
    A: Floats = field(repr=False)
    B: Floats = field(repr=False)
    C: Floats = field(repr=False)
    D: Floats = field(repr=False)
    #: Entries of A, B, C, D as formulas of the parameters.
    formulas: dict[str, list[list[str]]] = field(repr=False)
    poles: NDArray[np.complex128]
    zeros: NDArray[np.complex128]
    controllability: dict[str, Any]
    observability: dict[str, Any]
    gramians: dict[str, Any] | None = field(repr=False, default=None)
    distance_to_uncontrollable: dict[str, Any] | None = field(repr=False, default=None)
    distance_to_unobservable: dict[str, Any] | None = field(repr=False, default=None)
    #: Linear-quadratic regulator and steady-state Kalman filter; the reason as text where there is none.
    regulator: Gain | str = field(repr=False, default="")
    estimator: Gain | str = field(repr=False, default="")
    #: Files for python-control, MATLAB and Julia by name.
    files: dict[str, str] = field(repr=False, default_factory=dict)

    def state_space(self) -> Any:
        """A `control.StateSpace`; needs the package python-control."""
        import control  # type: ignore[import-not-found,import-untyped,unused-ignore]

        names = {"states": self.state_names, "inputs": self.input_names, "outputs": self.output_names}
        return control.ss(self.A, self.B, self.C, self.D, **names)


def _complex(pairs: Sequence[Sequence[float]] | None) -> NDArray[np.complex128]:
    return np.array([complex(re, im) for re, im in pairs or ()], dtype=np.complex128)


def _matrix(rows: Sequence[Sequence[float]], shape: tuple[int, int]) -> Floats:
    return np.array(rows, dtype=np.float64).reshape(shape)


def _gain(data: Mapping[str, Any], shape: tuple[int, int], n: int) -> Gain | str:
    if "reason" in data:
        return str(data["reason"])
    return Gain(
        _matrix(data["gain"], shape), _matrix(data["solution"], (n, n)), float(data["residual"]), _complex(data["poles"])
    )


def trim(
    system: System,
    *,
    fix: Mapping[Any, Any] | None = None,
    free: Sequence[Any] = (),
    moving: Sequence[Any] = (),
    starts: int = 24,
    seed: int = 1,
) -> Trim:
    """Finds an equilibrium or operating point near the model's point.

    Parameters
    ----------
    system
        The model.
    fix
        Values of states and inputs, such as ``{"th": "pi/2"}``.
    free
        Inputs to be searched; all others stay at the model's point.
    moving
        States whose derivative need not vanish.
    starts, seed
        Random starts besides the model's point.

    Returns
    -------
    Trim

    Raises
    ------
    BracketryError
        For a name that the model does not have, or a value that cannot be read.
    """
    fixed = [(name_of(k, "fix"), expression(v, "fix")) for k, v in (fix or {}).items()]
    names = [[name_of(n, what) for n in listed(given, what)] for given, what in ((free, "free"), (moving, "moving"))]
    answer = _native.trim(model_of(system), (fixed, names[0], names[1], starts, seed))
    return result_of(Trim, parsed(answer["json"]), answer, system=System._of(answer["model"]))


def linearize(
    system: System,
    at: Mapping[Any, Any] | str | None = None,
    *,
    state_weights: Sequence[float] = (),
    input_weights: Sequence[float] = (),
    process_noise: Sequence[float] = (),
    measurement_noise: Sequence[float] = (),
    horizon: float | None = None,
) -> Linearization:
    """The linear system at the model's point (or `at`), with poles, zeros, ranks, Gramians, distances to
    uncontrollability and unobservability, and gains.

    Weights and noises are diagonals: one number for all, or one each; 1 where none is given.

    Returns
    -------
    Linearization

    Raises
    ------
    BracketryError
        Where the equations are not smooth at the point, or for weights of a wrong number.
    """
    if isinstance(at, Mapping):
        named = {name_of(k, "at"): v for k, v in at.items()} or {model_of(system).states[0]: 0}
        at = ", ".join(f"{name}={expression(value, 'at')}" for name, value in named.items())
    weights = [[float(w) for w in list_] for list_ in (state_weights, input_weights, process_noise, measurement_noise)]
    answer = _native.linearize(model_of(system), at, weights, horizon)
    data = parsed(answer["json"])
    n, m, p = (len(data[k]) for k in ("states", "inputs", "outputs"))
    shapes = {"a": (n, n), "b": (n, m), "c": (p, n), "d": (p, m)}
    matrices = {k.upper(): _matrix(data[k]["values"], shape) for k, shape in shapes.items()}
    poles = [(q["re"], q["im"]) for q in data["poles"] or () for _ in range(q["multiplicity"])]
    return result_of(
        Linearization,
        data,
        answer,
        state_names=data["states"],
        input_names=data["inputs"],
        output_names=data["outputs"],
        formulas={k.upper(): data[k]["formulas"] for k in shapes},
        poles=_complex(poles),
        zeros=_complex(data["zeros"]),
        regulator=_gain(data["regulator"], (m, n), n),
        estimator=_gain(data["estimator"], (n, p), n),
        files=dict(answer["files"]),
        **matrices,
    )
