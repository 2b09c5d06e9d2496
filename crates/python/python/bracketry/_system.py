"""Models."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._export import Export, exported
from ._native import BracketryError, Model
from ._tables import Floats, real_array
from ._text import expression, key, listed, name_of, number, string, toml_value


@dataclass(frozen=True)
class Parameter:
    """A named constant of a model."""

    value: float
    unit: str | None = None
    min: float | None = None
    max: float | None = None
    about: str | None = None


class System:
    """A control system x' = f(x, u, u', …; p) with outputs and a point of interest.

    Expressions are strings in the language of model files, numbers, or SymPy expressions. ``sign(s)`` is set-valued at s = 0,
    which is how dry friction is written; ``der(u, 2)``, in SymPy the derivative of u(t), is the second time derivative of u.

    >>> unicycle = System(
    ...     states=["x", "y", "th"],
    ...     inputs=["u1", "u2"],
    ...     dynamics={"x": "u1*cos(th)", "y": "u1*sin(th)", "th": "u2"},
    ... )
    >>> unicycle.states
    ['x', 'y', 'th']

    Parameters
    ----------
    states
        Names (or SymPy symbols, or functions of time) of the states.
    inputs
        The same of the inputs.
    dynamics
        The time derivative of each state by name, or all of them in the order of the states.
    parameters
        A number by name, or a mapping with ``value``, ``unit``, ``min``, ``max``, ``about``.
    definitions
        Named sub-expressions; they may use those before them.
    outputs
        What is measured, by name.
    point
        Where local statements are made; states and inputs that are absent are 0.
    ranges
        Values that inputs can take: pairs (min, max), None for no limit, or mappings.
    delays
        Seconds by which inputs act later than they are commanded; numbers or expressions of parameters.
    static
        Ratios of static to sliding friction, by argument of ``sign`` or ``unit``.
    units
        Units of states, inputs, and outputs, by name, as free text. Axes and reports show them.
    labels
        The same in words, such as "angle of the pole".
    time_unit
        The unit of the time in the equations: "s", "min", "h", …; "1" for time without a unit.
    name
        What the model is called.

    Raises
    ------
    BracketryError
        With line, column and remedy, for whatever is no model.
    """

    def __init__(
        self,
        states: Sequence[Any],
        inputs: Sequence[Any] = (),
        dynamics: Mapping[Any, Any] | Sequence[Any] = (),
        *,
        parameters: Mapping[Any, Any] | None = None,
        definitions: Mapping[Any, Any] | None = None,
        outputs: Mapping[Any, Any] | Sequence[Any] | None = None,
        point: Mapping[Any, Any] | None = None,
        ranges: Mapping[Any, Any] | None = None,
        delays: Mapping[Any, Any] | None = None,
        static: Mapping[str, Any] | None = None,
        units: Mapping[Any, str] | None = None,
        labels: Mapping[Any, str] | None = None,
        time_unit: str = "s",
        name: str = "model",
    ) -> None:
        state_names = [name_of(s, "states") for s in listed(states, "states")]
        input_names = [name_of(u, "inputs") for u in listed(inputs, "inputs")]
        if not isinstance(dynamics, Mapping):
            rates = list(dynamics)
            if len(rates) != len(state_names):
                raise BracketryError(
                    f"dynamics: {len(rates)} expressions for {len(state_names)} states; give one for each"
                )
            dynamics = dict(zip(state_names, rates, strict=True))
        if outputs is not None and not isinstance(outputs, Mapping):
            outputs = {name_of(y, "outputs"): y for y in listed(outputs, "outputs")}
        lines = [
            f"name = {string(name)}",
            f"states = {toml_value(state_names, 'states')}",
            f"inputs = {toml_value(input_names, 'inputs')}",
        ]
        if time_unit != "s":
            lines.append(f"time_unit = {string(time_unit)}")

        def table(title: str, entries: Mapping[Any, Any] | None, write: Any) -> None:
            # An empty point is the origin.
            if entries or (title == "point" and entries is not None):
                lines.extend(["", f"[{title}]"])
                for entry, value in (entries or {}).items():
                    named = name_of(entry, title)
                    lines.append(f"{key(named)} = {write(value, f'{title}, {named}')}")

        table("parameters", parameters, _parameter)
        table("definitions", definitions, _expression)
        table("dynamics", dynamics, _expression)
        table("outputs", outputs, _expression)
        table("ranges", ranges, _range)
        table("delays", delays, _expression)
        table("static", static, _expression)
        table("point", point, _expression)
        table("units", units, lambda value, _: string(str(value)))
        table("labels", labels, lambda value, _: string(str(value)))
        self._model = Model.parse(f"System({name})", "\n".join(lines) + "\n", name)

    @classmethod
    def _of(cls, model: Model) -> System:
        system = cls.__new__(cls)
        system._model = model
        return system

    @classmethod
    def from_file(cls, path: str | PathLike[str]) -> System:
        """Reads a model file.

        Raises
        ------
        BracketryError
            With file, line, column, the offending text and the remedy.
        """
        return cls._of(Model.read(fspath(path)))

    @classmethod
    def from_toml(cls, text: str, name: str = "model") -> System:
        """Reads a model from the text of a model file; ``name`` is what errors and, unless it names itself, the model go by."""
        return cls._of(Model.parse(name, text, name))

    @property
    def name(self) -> str:
        """What the model is called."""
        return self._model.name

    @property
    def states(self) -> list[str]:
        """Names of the states, in order."""
        return self._model.states

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs, in order."""
        return self._model.inputs

    @property
    def outputs(self) -> list[str]:
        """Names of the outputs, in order."""
        return self._model.outputs

    @property
    def units(self) -> dict[str, str]:
        """Units of states, inputs, and outputs by name, as far as the model states them."""
        return self._model.units

    @property
    def time_unit(self) -> str:
        """The unit of the time in the equations; "1" for time without a unit."""
        return self._model.time_unit

    @property
    def input_derivatives(self) -> list[tuple[str, int]]:
        """Derivatives of inputs that the equations use: input and order."""
        return self._model.input_derivatives

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The parameters by name."""
        rows = self._model.parameters
        return {name: Parameter(value, unit, low, high, about) for name, value, unit, low, high, about in rows}

    @property
    def point(self) -> dict[str, float] | None:
        """Where local statements are made: a value for every state and input; None if the model says nothing."""
        values = self._model.point
        if values is None:
            return None
        return dict(zip(self.states + self.inputs, values[0] + values[1], strict=True))

    @property
    def equations(self) -> dict[str, str]:
        """The time derivative of each state, definitions expanded."""
        return dict(self._model.equations())

    def with_parameters(self, **values: Any) -> System:
        """The same system with other values of parameters."""
        given = [(name, number(value, f"parameter {name}")) for name, value in values.items()]
        return System._of(self._model.with_parameters(given))

    def to_toml(self) -> str:
        """The text of a model file, definitions expanded."""
        return self._model.to_toml()

    def save(self, path: str | PathLike[str]) -> None:
        """Writes :meth:`to_toml` into a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.to_toml())

    def rhs(self, x: ArrayLike, u: ArrayLike = (), derivatives: ArrayLike | None = None) -> Floats:
        """Time derivatives of the states, with ``sign(0) = 0``.

        Parameters
        ----------
        x
            States, shape (…, n).
        u
            Inputs, shape (…, m), broadcast against ``x``; zero if left out.
        derivatives
            Values of :attr:`input_derivatives`, shape (…, number of these); zero if left out.

        Returns
        -------
        numpy.ndarray
            Shape (…, n).
        """
        rows, shape = self._rows(x, u, derivatives)
        return self._model.rates(rows).reshape(*shape, len(self.states))

    def output_values(self, x: ArrayLike, u: ArrayLike = (), derivatives: ArrayLike | None = None) -> Floats:
        """Outputs, shape (…, number of outputs); otherwise as :meth:`rhs`."""
        rows, shape = self._rows(x, u, derivatives)
        return self._model.output_values(rows).reshape(*shape, len(self.outputs))

    def jacobians(
        self, x: ArrayLike, u: ArrayLike = (), derivatives: ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Exact derivatives of :meth:`rhs` by the states, shape (…, n, n), and by the inputs, shape (…, n, m)."""
        rows, shape = self._rows(x, u, derivatives)
        n, m = len(self.states), len(self.inputs)
        both = self._model.jacobian(rows).reshape(*shape, n, n + m)
        return both[..., :n], both[..., n:]

    def export(self, language: str, *, parameters: Sequence[Any] | str = (), name: str | None = None) -> Export:
        """The equations f, the outputs h, and their Jacobians as source code.

        Parameters
        ----------
        language
            "c", "rust", "python" (NumPy), "casadi", or "julia".
        parameters
            Names of the parameters that become arguments of the functions, or "all"; the others are constants.
        name
            Name of module and files, and prefix of C functions, instead of that of the model.

        Returns
        -------
        Export

        Raises
        ------
        BracketryError
            For an unknown language or parameter, or a name that is none.
        """
        return exported(self._model, language, parameters, name)

    def _rows(self, x: ArrayLike, u: ArrayLike, derivatives: ArrayLike | None) -> tuple[Floats, tuple[int, ...]]:
        """Arguments of compiled expressions, one row each, and the shape that the rows stand for."""
        blocks = []
        for what, given, length in (
            ("x", x, len(self.states)),
            ("u", u, len(self.inputs)),
            ("derivatives", () if derivatives is None else derivatives, len(self.input_derivatives)),
        ):
            block = real_array(given, what)
            if block.shape == (0,):
                block = np.zeros(length)
            if block.ndim == 0 or block.shape[-1] != length:
                raise BracketryError(f"{what} has the shape {block.shape}; its last axis must have length {length}")
            blocks.append(block)
        try:
            shape = np.broadcast_shapes(*(b.shape[:-1] for b in blocks))
        except ValueError:
            shapes = ", ".join(str(b.shape) for b in blocks)
            raise BracketryError(f"the shapes {shapes} do not match: all axes but the last must agree") from None
        wide = [np.broadcast_to(b, (*shape, b.shape[-1])) for b in blocks]
        rows = np.concatenate(wide, axis=-1).reshape(-1, sum(b.shape[-1] for b in blocks))
        return np.ascontiguousarray(rows), tuple(shape)

    def __repr__(self) -> str:
        return f"<System {self.name}: states {', '.join(self.states)}; inputs {', '.join(self.inputs) or 'none'}>"

    def __str__(self) -> str:
        return "\n".join([self.name, *(f"  {state}' = {rate}" for state, rate in self._model.equations())])

    def _repr_latex_(self) -> str:
        dynamics, outputs = self._model.latex()
        rows = [f"\\dot{{{state}}} &= {rate}" for state, rate in dynamics]
        rows += [f"\\text{{{name.replace('_', ' ')}}} &= {value}" for name, value in outputs]
        return "$$\\begin{aligned}" + " \\\\ ".join(rows) + "\\end{aligned}$$"

    def _repr_html_(self) -> str:
        values = ", ".join(
            f"{name} = {p.value:g}{f' {p.unit}' if p.unit else ''}" for name, p in self.parameters.items()
        )
        parameters = f"<p>{html.escape(values)}</p>" if values else ""
        return f"<p><b>{html.escape(self.name)}</b></p>{self._repr_latex_()}{parameters}"

    def __reduce__(self) -> tuple[Any, tuple[str, str, str]]:
        return _restored, (self._model.file, self._model.text, self._model.name)


def _restored(file: str, text: str, name: str) -> System:
    """A system out of a pickle."""
    return System._of(Model.parse(file, text, name))


def model_of(system: Any, what: str = "system") -> Model:
    """The native model of a system."""
    if not isinstance(system, System):
        remedy = f"System.from_file({fspath(system)!r})" if isinstance(system, (str, PathLike)) else "a System"
        raise BracketryError(f"{what}: `{system!r}` is not a model; give {remedy}")
    return system._model


def _expression(value: object, what: str) -> str:
    return string(expression(value, what))


def _parameter(value: object, what: str) -> str:
    if isinstance(value, Parameter):
        value = {k: v for k, v in vars(value).items() if v is not None}
    if not isinstance(value, Mapping):
        return number(value, what)
    return toml_value({k: v for k, v in value.items() if v is not None}, what)


def _range(value: object, what: str) -> str:
    if not isinstance(value, Mapping):
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
            raise BracketryError(f"{what}: give a pair (min, max), None where there is no limit")
        value = dict(zip(("min", "max"), value, strict=True))
    return toml_value({k: v for k, v in value.items() if v is not None}, what)
