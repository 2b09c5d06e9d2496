"""The vibrating plate: its published experiments, or others, on any of its models."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._native import BracketryError, PlateStep
from ._result import fields_of, parsed, real, result_of
from ._sampled import Sampled
from ._tables import Floats, Table, real_array, table_text
from ._text import number, whole

__all__ = ["Comparison", "Deviation", "PlateController", "PlateRun", "PlateStep", "run"]

#: How object and plate touch, from the published equations to six degrees of freedom.
Model: TypeAlias = Literal["published", "point", "reduced", "area", "body"]

_STATES = ["x_plate", "y_plate", "phi_plate", "vx", "vy", "w"]
_INPUTS = ["plate_X", "plate_theta"]


@dataclass(frozen=True)
class Deviation:
    """Differences of a run from a log: root mean square, largest in size, at the end."""

    rms: float
    largest: float
    at_end: float


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How far a run is from a log over their common time."""

    log: str
    #: First and last common time (s).
    from_time: float
    to_time: float
    #: Rows of the log between them.
    rows: int
    #: Along x and y (mm).
    x_mm: Deviation
    y_mm: Deviation
    #: Yaw (degrees).
    phi_deg: Deviation
    #: Difference of the yaw gained at the end in percent of the log's; None where the log hardly turns.
    phi_percent: float | None = None
    #: "undecided" where chance decided on a sign of the amplitude: only the time before it counts.
    status: Literal["compared", "undecided"] = "compared"
    #: The signs of the amplitude in run and log, as in the JSON of the command line (SI, rad); None without an amplitude law.
    signs: dict[str, Any] | None = field(repr=False, default=None)


@dataclass(frozen=True, eq=False, kw_only=True)
class PlateRun(Sampled):
    """An experiment on the plate.

    ``run["x_plate"]`` is a column by name, as in the files of the command line: ``t`` (s), ``x_plate, y_plate`` (m),
    ``phi_plate`` (rad), ``vx, vy`` (m/s), ``w`` (rad/s), ``plate_X`` (m), ``plate_theta`` (rad), ``amp``,
    ``normal_force`` (N), ``stick_fraction``, ``gap`` (m), ``lean`` (rad).
    """

    #: What the experiment is called.
    experiment: str
    model: Model
    #: What moves the plate.
    motion: Literal["formula", "log"]
    #: ``kind`` of the shape, and its lengths (m).
    shape: dict[str, Any] = field(repr=False)
    #: ``law`` of friction, and its coefficients.
    friction: dict[str, Any] = field(repr=False)
    #: What was assumed where the experiment's description leaves a choice.
    assumptions: list[str] = field(repr=False)
    #: The coordinate that is to be moved: x, y (m) or phi (rad).
    coordinate: Literal["x", "y", "phi"]
    target: float
    #: Seconds after the start at which 98 % of the distance were covered; None if they were not.
    reached: float | None
    #: "not flat" where the object has left the plate with its lower face.
    outcome: Literal["reached", "not reached", "stopped", "not flat"]
    #: Why the run ended early.
    stopped: str | None = None
    t_final: float
    #: Position (m) and yaw (rad) at the start, at the end, and the difference.
    start: dict[str, float] = field(repr=False)
    final: dict[str, float]
    drift: dict[str, float] = field(repr=False)
    #: Changes between sticking and sliding, and other events; None if the model does not report them.
    events: int | None = field(repr=False, default=None)
    #: Jumps of the plate that the object did not follow.
    plate_jumps: int = field(repr=False, default=0)
    #: Mean share of the contact that sticks.
    stick_share: float = field(repr=False)
    least_normal_force: float = field(repr=False)
    largest_gap: float = field(repr=False)
    #: Error of the energy balance relative to the energy that was exchanged; None if the model does not report it.
    energy_closure: float | None = field(repr=False, default=None)
    #: Seconds that the simulation took.
    wall_seconds: float = field(repr=False)
    #: How the run agrees with the log; None without one.
    comparison: Comparison | None = field(repr=False, default=None)
    #: Amplitude in each period (1 without an amplitude law, NaN where a log moves the plate), shape (k,).
    amplitude: Floats = field(repr=False)
    #: Normal force (N), NaN where the body is free, shape (k,).
    normal_force: Floats = field(repr=False)
    #: Share of the contact that sticks, NaN where the body is free, shape (k,).
    stick_fraction: Floats = field(repr=False)
    #: Gap between plate and object (m), shape (k,).
    gap: Floats = field(repr=False)
    #: Tilt of the object against the plate about the plate's x axis (rad), shape (k,).
    lean: Floats = field(repr=False)

    def _blocks(self) -> list[tuple[list[str], Floats]]:
        contact = {
            "amp": self.amplitude,
            "normal_force": self.normal_force,
            "stick_fraction": self.stick_fraction,
            "gap": self.gap,
            "lean": self.lean,
        }
        return [*super()._blocks(), *(([name], values[:, np.newaxis]) for name, values in contact.items())]


def run(
    experiment: int | str | PathLike[str] = 1,
    *,
    model: Model | None = None,
    shape: str | ArrayLike | None = None,
    thickness: float | None = None,
    mass: float | None = None,
    bearing: str | None = None,
    center_of_mass: Sequence[float] | Floats | None = None,
    mu: float | None = None,
    friction: str | None = None,
    start: Sequence[float] | Floats | None = None,
    seconds: float | None = None,
    omega: int | None = None,
    jumps: Literal["world", "smooth"] | None = None,
    points: int | None = None,
    dt: float | None = None,
    restitution: float | None = None,
    sample: float | None = None,
    compare: Table | None = None,
    motion: Literal["formula", "log"] = "formula",
    noise: float | None = None,
) -> PlateRun:
    """Runs an experiment on the vibrating plate.

    Parameters
    ----------
    experiment
        1 (orientation), 2 (along x), 3 (along y), or a scenario file. Other arguments replace the values in the file.
    model
        "published" equations, "point" contact, "reduced" to an ordinary differential equation with yaw friction, "area" contact
        (the default), or "body" with six degrees of freedom.
    shape
        "disk:R", "ellipse:AxB" (semi-axes), "rectangle:AxB" (full sides), "polygon:FILE.csv", in meters; or the vertices of a
        polygon in order around the outline, shape (k, 2). A disk of 0.12 m if left out.
    thickness, mass
        Of the object, in m (0.005) and kg (0.2).
    bearing
        Where the object presses: "footprint", "scaled:F", "ring:S", "feet:x,y;x,y;…" or "map:FILE.csv" (rows x, y, weight), in meters
        from the center of the shape. Model "area" only.
    center_of_mass
        x, y from the center of the shape in m (0, 0). Model "area" only.
    mu
        Friction coefficient of sliding (0.3).
    friction
        "coulomb", "static:MU_S", "stribeck:MU_S,V", "anisotropic:MU_Y" or "viscous:C", in addition to ``mu``.
    start
        x, y (m) and yaw (rad, 0 if left out) at which the object begins at rest; that of log or experiment if left out.
    seconds
        Duration: that of the log, else 15.
    omega
        Frequency of experiment 2 in units of π (3).
    jumps
        Where the amplitude changes: "world" (the plate jumps, the object keeps its place in the inertial frame) or "smooth".
    points
        Points of contact of the area model (48).
    dt
        Time step of the models area and body in seconds (5e-4).
    restitution
        Of impacts of the body, 0 to 1.
    sample
        Seconds between the rows of the result (0.002).
    compare
        A log with the columns ``t, x_plate, y_plate, phi_plate`` (SI, rad): a CSV file, a mapping of arrays, a DataFrame, another run.
    motion
        "log" moves the plate by the columns ``plate_X, plate_theta`` of the log.
    noise
        Standard deviation of the log in the coordinate that the experiment moves (m or rad), estimated from it if left out.

    Returns
    -------
    PlateRun

    Raises
    ------
    BracketryError
        For what does not fit. An object that does not arrive, tips or lifts off is a result.
    """
    if motion not in ("formula", "log"):
        raise BracketryError(f'motion is {motion!r}; it can be "formula" or "log"')
    if motion == "log" and compare is None:
        raise BracketryError('motion="log": there is no log; give one as `compare`')
    if noise is not None and compare is None:
        raise BracketryError("noise: there is no log; give one as `compare`")
    chosen, scenario = _experiment(experiment)
    polygon = None if shape is None or isinstance(shape, str) else _vertices(shape)
    numbers = {
        "omega": omega,
        "thickness": thickness,
        "mass": mass,
        "mu": mu,
        "seconds": seconds,
        "points": points,
        "dt": dt,
        "restitution": restitution,
        "sample": sample,
        "noise": noise,
    }
    texts = {
        "experiment": chosen,
        "model": model,
        "shape": shape if isinstance(shape, str) else None,
        "friction": friction,
        "bearing": bearing,
        "center_of_mass": None if center_of_mass is None else _point(center_of_mass),
        "start": None if start is None else _start(start),
        "jumps": jumps,
    }
    given = {name: None if value is None else float(number(value, name)) for name, value in numbers.items()}
    log = None if compare is None else table_text(compare, "compare")
    answer = _native.run_plate(
        given, texts, scenario=scenario, polygon=polygon, log=log, driven_by_log=motion == "log"
    )
    data = parsed(answer["json"])
    return result_of(
        PlateRun,
        data,
        answer,
        stick_share=real(data["stick_share"]),
        least_normal_force=real(data["least_normal_force"]),
        comparison=None if data["comparison"] is None else _comparison(data["comparison"]),
        t=answer["t"],
        states=answer["states"],
        inputs=np.column_stack([answer["plate_displacement"], answer["plate_tilt"]]),
        state_names=list(_STATES),
        input_names=list(_INPUTS),
        amplitude=answer["amplitude"],
        normal_force=answer["normal_force"],
        stick_fraction=answer["stick_fraction"],
        gap=answer["gap"],
        lean=answer["lean"],
    )


class PlateController:
    """The controller that brings an object on the plate to a pose, stepped on a plate of your own.

    It plans moves from rest to rest with both motions of the plate at once, follows them, and corrects what they missed.

    Parameters
    ----------
    target
        x, y (m) and yaw (rad) in the frame of the plate.
    shape, thickness, mass
        The object, as for :func:`run`.
    mu
        Friction coefficient assumed at first (0.3).
    mu_deviation
        Standard deviation of what is not known of it, as a share of it.
    period
        Sampling period in s.
    delay
        Samples after which a command acts.
    noise
        Standard deviations of the measured position (m) and yaw (rad).
    tolerance
        What counts as arrived: error of x and y (m), and of yaw (rad).

    Raises
    ------
    BracketryError
        For an object, a target or a setting without meaning.
    """

    def __init__(
        self,
        target: Sequence[float] | Floats,
        *,
        shape: str | ArrayLike | None = None,
        thickness: float | None = None,
        mass: float | None = None,
        mu: float | None = None,
        mu_deviation: float = 0.3,
        period: float = 0.02,
        delay: int = 1,
        noise: Sequence[float] = (5e-4, 0.0087),
        tolerance: Sequence[float] = (2e-3, 0.035),
    ) -> None:
        numbers = {"thickness": thickness, "mass": mass, "mu": mu}
        self._native = _native.PlateController(
            _several(target, 3, "target"),
            {name: None if value is None else float(number(value, name)) for name, value in numbers.items()},
            {"shape": shape if isinstance(shape, str) else None},
            polygon=None if shape is None or isinstance(shape, str) else _vertices(shape),
            period=float(number(period, "period")),
            delay=whole(delay, "delay"),
            mu_deviation=float(number(mu_deviation, "mu_deviation")),
            noise=_several(noise, 2, "noise"),
            tolerance=_several(tolerance, 2, "tolerance"),
        )

    def step(self, pose: Sequence[float] | Floats, plate: Sequence[float] | Floats | None = None) -> PlateStep:
        """The accelerations of the plate for the next period.

        Parameters
        ----------
        pose
            Measured x, y (m) and yaw (rad, not wrapped) of the object in the frame of the plate; NaN where lost.
        plate
            Measured X (m), X' (m/s), theta (rad) and theta' (rad/s) of the plate; without it, the plate does what it is told.

        Returns
        -------
        PlateStep
            ``displacement_acceleration`` (m/s²), ``tilt_acceleration`` (rad/s²), ``finished``, ``status`` (working, arrived,
            unreachable or moves_used_up), ``estimate`` of the object's state, ``mu``, the assumed friction coefficient, and
            ``learned`` by name with standard deviations: ``mu``, ``scale`` of the bearing (how far out the pressure stands),
            ``center_of_mass_x`` and ``center_of_mass_y`` (m), ``latency`` of the camera (s), ``servo_lag`` (s). The first step plans,
            which takes about a second.
        """
        return self._native.step(_several(pose, 3, "pose"), None if plate is None else _several(plate, 4, "plate"))


def _several(values: Any, count: int, what: str) -> list[float]:
    """So many numbers."""
    array = real_array(values, what)
    if array.shape != (count,):
        raise BracketryError(f"{what} has the shape {array.shape}; give {count} numbers")
    return [float(value) for value in array]


def _experiment(given: Any) -> tuple[str | None, str | None]:
    """The number of an experiment as text, or the path of a scenario file."""
    if isinstance(given, (str, PathLike)):
        path = fspath(given)
        return (path, None) if path.isdigit() else (None, path)
    try:
        return str(operator.index(given)), None
    except TypeError:
        raise BracketryError(f"experiment: `{given!r}` is none; give 1, 2, 3 or a scenario file") from None


def _start(start: Sequence[float] | Floats) -> str:
    values = real_array(start, "start")
    if values.shape not in ((2,), (3,)):
        raise BracketryError(f"start has the shape {values.shape}; give x, y (m) and the yaw (rad)")
    return ",".join(map(repr, values.tolist()))


def _point(center_of_mass: Sequence[float] | Floats) -> str:
    values = real_array(center_of_mass, "center_of_mass")
    if values.shape != (2,):
        raise BracketryError(f"center_of_mass has the shape {values.shape}; give x and y (m)")
    return ",".join(map(repr, values.tolist()))


def _vertices(shape: ArrayLike) -> list[list[float]]:
    vertices = real_array(shape, "shape")
    if vertices.ndim != 2 or vertices.shape[1] != 2:
        raise BracketryError(f"shape has the shape {vertices.shape}; vertices of a polygon have the shape (k, 2)")
    listed: list[list[float]] = vertices.tolist()
    return listed


def _comparison(data: dict[str, Any]) -> Comparison:
    deviations = {k: fields_of(Deviation, data[k]) for k in ("x_mm", "y_mm", "phi_deg")}
    return fields_of(Comparison, data, from_time=data["from"], to_time=data["to"], **deviations)
