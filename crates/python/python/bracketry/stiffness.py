"""Stiffness of robots: identified from measurements, compensated along logs; pose selection, payload."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._native import BracketryError, CompensationStep
from ._result import Result, parsed, result_of
from ._tables import Floats, Table, path_of, real_array, table_text
from ._text import number, whole

__all__ = [
    "ChosenPoses",
    "Compensation",
    "CompensationStep",
    "Compensator",
    "Expectation",
    "Identification",
    "Weighing",
    "choose_poses",
    "compensate",
    "identify",
    "weigh",
]

_WRENCH = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Result):
    """Joint springs, and the stiffness at the tool point if all measurements are in one pose."""

    robot: str
    #: Number of measurements.
    measurements: int
    #: Lines of the table (its header is line 1) that were excluded as outliers.
    outliers: list[int] = field(repr=False)
    #: The method to trust.
    trusted: str
    reasons: list[str] = field(repr=False)
    #: All methods with their errors on held-out measurements.
    methods: list[dict[str, Any]] = field(repr=False)
    #: Numbers of the joints' springs: joint (from 1), name, value with the ends of its 95 % interval.
    parameters: list[dict[str, Any]] = field(repr=False)
    #: Residual of the springs, and the joints whose lost motion would explain it.
    unexplained: dict[str, Any] | None = field(repr=False, default=None)
    #: Why outliers were kept although they should have been left out.
    outliers_kept: str | None = field(repr=False, default=None)
    #: Compliance at the tool point in base axes (m/N, rad/(N·m)), shape (6, 6); None where there is none.
    compliance: Floats | None = field(repr=False, default=None)
    #: Ends of its 95 % intervals, shape (6, 6, 2).
    compliance_interval: Floats | None = field(repr=False, default=None)
    #: Its inverse (N/m, N·m/rad), shape (6, 6).
    stiffness: Floats | None = field(repr=False, default=None)
    #: Ends of its 95 % intervals, shape (6, 6, 2).
    stiffness_interval: Floats | None = field(repr=False, default=None)
    #: Why springs that were found are none to work with.
    withheld: str | None = None
    #: The text of the robot file with these springs; None if there are none.
    identified_robot: str | None = field(repr=False, default=None)

    @property
    def stiffnesses(self) -> dict[int, float]:
        """Stiffness of each joint (N·m/rad, N/m) that the data tell."""
        told = [p for p in self.parameters if p["name"] == "stiffness" and p["value"] is not None]
        return {p["joint"]: float(p["value"][0]) for p in told}


@dataclass(frozen=True, eq=False, kw_only=True)
class Compensation(Result):
    """A compensation along a log."""

    robot: str
    samples: int
    period_s: float
    #: Root mean square of the predicted translation of the tool point (m).
    displacement_rms_m: float
    displacement_max_m: float
    #: Largest force of the process (N), filtered.
    force_max_n: float
    #: Largest correction of each joint (rad, m).
    correction_max: list[float]
    #: Number of samples at which a limit acted.
    samples_limited: int
    faults: list[dict[str, Any]]
    #: How stable the loop through the process is; None unless the stiffness of the process was given.
    loop_gain: dict[str, Any] | None = field(repr=False, default=None)
    #: Times, shape (k,).
    t: Floats = field(repr=False)
    #: Corrected references of the joints, shape (k, n).
    corrected: Floats = field(repr=False)
    #: Their corrections, shape (k, n).
    correction: Floats = field(repr=False)
    #: Filtered wrench of the process at the tool point in base axes (N, N·m), shape (k, 6).
    wrench: Floats = field(repr=False)
    #: Displacement of the tool point without correction (m, rad), shape (k, 6).
    displacement: Floats = field(repr=False)
    #: Whether bad input held the correction, shape (k,).
    held: NDArray[np.bool_] = field(repr=False)
    #: Whether a limit shortened it, shape (k,).
    limited: NDArray[np.bool_] = field(repr=False)


@dataclass(frozen=True)
class Expectation:
    """What measurements are expected to tell."""

    #: Relative standard deviation by parameter of the joints' springs; None where it would not be identified.
    errors: dict[str, float | None]
    #: Ratio of the largest to the smallest standard deviation of a combination of logarithms; None where one is not told at all.
    condition: float | None


@dataclass(frozen=True, eq=False, kw_only=True)
class ChosenPoses(Result):
    """The most informative measurements for the springs, out of the candidates."""

    robot: str
    #: Number of candidates.
    candidates: int
    #: Lines of the table that were chosen (its header is line 1).
    lines: list[int]
    #: What they are expected to tell.
    chosen: Expectation
    #: What all candidates together would.
    all: Expectation = field(repr=False)
    #: Whether the springs are those of the robot file, or of a usual size.
    springs_known: bool
    #: Whether the chosen measurements are expected to tell all parameters.
    identifies_all: bool
    #: The rows that were chosen: q1 … qn (rad), Fx … Mz (N, N·m), shape (count, n + 6).
    rows: Floats = field(repr=False)

    @property
    def indices(self) -> list[int]:
        """Rows of the table that were chosen, from 0, where it has neither comments nor empty lines."""
        return [line - 2 for line in self.lines]

    def columns(self) -> dict[str, Floats]:
        """The chosen rows by name of the column."""
        joints = [f"q{i}" for i in range(1, self.rows.shape[1] - len(_WRENCH) + 1)]
        return dict(zip([*joints, *_WRENCH], self.rows.T, strict=True))


@dataclass(frozen=True, eq=False, kw_only=True)
class Weighing(Result):
    """What a force sensor carries, and its bias, with standard deviations."""

    robot: str
    #: Number of readings.
    readings: int
    #: Mass (kg).
    mass: float
    mass_deviation: float
    #: Center of mass in the sensor's frame (m), shape (3,).
    centre: Floats
    centre_deviation: Floats = field(repr=False)
    #: Reading without any load in the sensor's axes (N, N·m), shape (6,).
    bias: Floats = field(repr=False)
    bias_deviation: Floats = field(repr=False)
    #: Standard deviation of one reading about the fit: force (N), moment (N·m), shape (2,).
    residual: Floats = field(repr=False)
    #: Line of the reading that fits worst (the header is line 1).
    worst_line: int
    #: The table ``[payload]`` for the robot file.
    toml: str = field(repr=False)


def identify(data: Table, robot: str | PathLike[str], *, keep_outliers: bool = False) -> Identification:
    """Identifies the springs of a robot from measured displacements under measured loads.

    Parameters
    ----------
    data
        A table with the columns ``q1 … qn`` (rad), ``Fx, Fy, Fz, Mx, My, Mz`` (N, N·m on the robot at the tool point, base
        axes) and ``dx, dy, dz, rx, ry, rz`` (m, rad): a CSV file, a mapping of arrays or a DataFrame.
    robot
        A robot file, or its text.
    keep_outliers
        Use all measurements as they are.

    Returns
    -------
    Identification

    Raises
    ------
    BracketryError
        For a table that does not fit, numbers in other units, and data that tell nothing.
    """
    answer = _native.identify(table_text(data, "data"), _robot(robot), keep_outliers)
    found = parsed(answer["json"])
    matrices = {
        name: None if found.get(name) is None else np.array(found[name], dtype=float)
        for name in ("compliance", "compliance_interval", "stiffness", "stiffness_interval")
    }
    return result_of(
        Identification,
        found,
        answer,
        identified_robot=answer["identified_robot"],
        **matrices,
    )


def compensate(
    log: Table,
    robot: str | PathLike[str],
    *,
    process_stiffness: float | Sequence[float] | None = None,
) -> Compensation:
    """Runs the compensation of a robot file along a log.

    Parameters
    ----------
    log
        A table with the columns ``t``, ``q1 … qn`` (rad) and ``Fx … Mz`` (N, N·m, axes of the sensor), and ``r1 … rn``
        where references differ from what was measured: a CSV file, a mapping of arrays or a DataFrame.
    robot
        A robot file with springs and a sensor, or its text.
    process_stiffness
        Stiffness of the process in N/m, in all directions or along x, y, z of the base: whether the loop
        through it is stable.

    Returns
    -------
    Compensation

    Raises
    ------
    BracketryError
        For a robot file without springs or sensor, and a log that does not fit.
    """
    process = None if process_stiffness is None else _directions(process_stiffness)
    answer = _native.compensate(table_text(log, "log"), _robot(robot), process)
    data = parsed(answer["json"])
    arrays: Mapping[str, Any] = {
        k: answer[k]
        for k in ("t", "corrected", "correction", "wrench", "displacement", "held", "limited")
    }
    return result_of(
        Compensation,
        data,
        answer,
        samples_limited=data["limited"],
        **arrays,
    )


class Compensator:
    """The compensation of a robot file, one control period at a time.

    Parameters
    ----------
    robot
        A robot file with springs and a sensor, or its text.
    period
        Time between two steps in s, in place of that of the file.

    Raises
    ------
    BracketryError
        For a robot file without springs or sensor, and settings that do not fit.
    """

    def __init__(self, robot: str | PathLike[str], *, period: float | None = None) -> None:
        self._native = _native.Compensator(_robot(robot), None if period is None else float(number(period, "period")))

    def step(
        self,
        measured: Sequence[float] | Floats,
        reading: Sequence[float] | Floats,
        reference: Sequence[float] | Floats | None = None,
    ) -> CompensationStep:
        """What to send to the robot in this period.

        Parameters
        ----------
        measured
            Coordinates of the joints as the encoders tell them, rad or m.
        reading
            Of the sensor: Fx, Fy, Fz (N), Mx, My, Mz (N·m) in its axes.
        reference
            Coordinates that the robot is to have; those measured if left out.

        Returns
        -------
        CompensationStep
            ``reference``, corrected, always finite; ``correction``, ``wrench``, ``displacement``, ``fault`` (what was wrong with the input:
            the last good correction is held) and ``limited``.
        """
        return self._native.step(measured, [float(v) for v in reading], measured if reference is None else reference)


def choose_poses(candidates: Table, robot: str | PathLike[str], *, count: int = 20) -> ChosenPoses:
    """Chooses the candidate measurements that are most informative about a robot's springs.

    Parameters
    ----------
    candidates
        A table with the columns ``q1 … qn`` (rad) and ``Fx, Fy, Fz, Mx, My, Mz`` (N, N·m on the robot at the tool
        point, base axes), poses that can be reached with loads that can be applied there: a CSV file, a mapping of arrays or
        a DataFrame.
    robot
        A robot file, or its text.
    count
        Measurements to choose.

    Returns
    -------
    ChosenPoses

    Raises
    ------
    BracketryError
        For a table that does not fit, and fewer candidates than are to be chosen.
    """
    answer = _native.choose_poses(table_text(candidates, "candidates"), _robot(robot), whole(count, "count"))
    data = parsed(answer["json"])
    names = data["parameters"]
    expected = {
        k: Expectation(dict(zip(names, data[k]["errors"], strict=True)), data[k]["condition"]) for k in ("chosen", "all")
    }
    return result_of(
        ChosenPoses,
        data,
        answer,
        identifies_all=answer["identifies_all"],
        rows=answer["rows"],
        **expected,
    )


def weigh(readings: Table, robot: str | PathLike[str]) -> Weighing:
    """Weighs what a force sensor carries, and finds its bias.

    Parameters
    ----------
    readings
        A table with the columns ``q1 … qn`` (rad) and ``Fx, Fy, Fz, Mx, My, Mz`` (N, N·m, axes of the sensor): readings
        at rest with nothing touching the payload, in three orientations or more that tilt it about two axes.
        A CSV file, a mapping of arrays or a DataFrame.
    robot
        A robot file with a sensor, or its text.

    Returns
    -------
    Weighing

    Raises
    ------
    BracketryError
        For a table that does not fit, a robot file without a sensor, and readings that do not determine the payload.
    """
    answer = _native.weigh(table_text(readings, "readings"), _robot(robot))
    data = parsed(answer["json"])
    arrays = {
        k: np.array(data[k], dtype=float) for k in ("centre", "centre_deviation", "bias", "bias_deviation", "residual")
    }
    mass, mass_deviation = data["mass"]
    return result_of(
        Weighing,
        data,
        answer,
        mass=mass,
        mass_deviation=mass_deviation,
        toml=answer["toml"],
        **arrays,
    )


def _directions(stiffness: float | Sequence[float]) -> list[float]:
    """One number for all directions, or one for each."""
    values = np.atleast_1d(real_array(stiffness, "process_stiffness"))
    if values.shape not in ((1,), (3,)) or not np.isfinite(values).all() or (values < 0).any():
        raise BracketryError("process_stiffness: give one number in N/m, or three along x, y, z of the base; none is negative")
    return [float(v) for v in np.broadcast_to(values, (3,))]


def _robot(robot: str | PathLike[str]) -> str | tuple[str, str]:
    if isinstance(robot, str) and "\n" in robot:
        return ("robot", robot)
    path = path_of(robot)
    if path is None:
        raise BracketryError(f"robot: {type(robot).__name__} is not a robot; give a robot file, or its text")
    return path
