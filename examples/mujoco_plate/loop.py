"""The loop that the examples close: measure with noise, step the controller, command one sample late."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from plant import STEP, Body, Floats, Plant

from bracketry.plate import PlateController, PlateStep

PERIOD, BELIEVED = 0.02, 0.3
#: Noise and tolerance of position (m) and yaw (rad).
NOISE, TOLERANCE = (5e-4, math.radians(0.5)), (2e-3, math.radians(2))
#: Rates of a plate at rest, in m/s and rad/s.
REST = 1e-6
#: Seconds that a move lasts after the controller has finished, and at most.
AFTER, LONGEST = 1.0, 30.0


def controller(body: Body, target: Floats, mu_deviation: float = 0.3) -> PlateController:
    return PlateController(
        target, shape=body.shape, thickness=body.thickness, mass=body.mass, mu=BELIEVED, mu_deviation=mu_deviation,
        period=PERIOD, delay=1, noise=NOISE, tolerance=TOLERANCE,
    )  # fmt: skip


def closed_loop(plant: Plant, controls: PlateController, draw: np.random.Generator) -> Iterator[PlateStep]:
    """The answers of the controller, each before its period passes on the plant; ends a while after the controller has finished."""
    late, finished_at = (0.0, 0.0), math.inf
    while plant.time < min(LONGEST, finished_at + AFTER):
        step = controls.step(plant.measure(draw, NOISE))
        yield step
        acting, late = late, (step.displacement_acceleration, step.tilt_acceleration)
        for _ in range(round(PERIOD / STEP)):
            plant.advance(acting)
        finished_at = min(finished_at, plant.time) if step.finished else math.inf


def error(plant: Plant, target: Floats) -> Floats:
    """Of x, y (m) and yaw (rad, without whole turns)."""
    x, y, yaw = plant.pose - target
    return np.array([x, y, math.remainder(yaw, math.tau)])


def arrived(plant: Plant, target: Floats) -> bool:
    """Whether the object is within the tolerance while the plate is at rest."""
    x, y, yaw = abs(error(plant, target))
    return bool(max(x, y) <= TOLERANCE[0] and yaw <= TOLERANCE[1] and abs(plant.plate[[1, 3]]).max() <= REST)
