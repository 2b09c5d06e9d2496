#!/usr/bin/env python3
"""Logs of the plate in MuJoCo for the diagnosis: `python examples/mujoco_plate/logs.py [--diagnose]`.

Writes experiment 1 (8 s) and random moves of the disk of 0.12 m, logged at 200 Hz with noise of 0.5 mm and 0.3°, in SI units with the
names of `models/plate_disk.toml`, for

    bracketry diagnose models/plate_disk.toml out/experiment_1.csv out/move_1.csv --validate out/move_2.csv --window 0.5

which `--diagnose` does here.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from experiments import DISK, motion
from loop import PERIOD, controller
from plant import STEP, Contact, Floats, Plant

from bracketry import System, diagnose

NAMES = ["t", "X", "theta", "x", "y", "phi"]
SAMPLE, NOISE = 0.005, (5e-4, math.radians(0.3))
MODEL = Path(__file__).resolve().parents[2] / "models/plate_disk.toml"


def row(plant: Plant, draw: np.random.Generator) -> list[float]:
    return [plant.time, plant.plate[0], plant.plate[2], *plant.measure(draw, NOISE)]


def experiment(contact: Contact, mu: float, draw: np.random.Generator) -> Floats:
    plant = Plant(DISK, mu, (0.3, 0.0, 0.0), contact)
    rows = [row(plant, draw)]
    for k in range(1, round(8 / STEP) + 1):
        displacement, tilt = motion(1, k * STEP, 1.0)
        plant.follow((displacement, 0.0, tilt, 0.0))
        if k % round(SAMPLE / STEP) == 0:
            rows.append(row(plant, draw))
    return np.array(rows)


def move(contact: Contact, mu: float, draw: np.random.Generator) -> Floats:
    """What the controller does in its first 4 s, from and to random poses."""
    start, target = (draw.uniform([-0.1, -0.1, -math.pi], [0.1, 0.1, math.pi]) for _ in range(2))
    plant, late = Plant(DISK, mu, tuple(start), contact), (0.0, 0.0)
    controls, rows = controller(DISK, target), [row(plant, draw)]
    while plant.time < 4:
        step = controls.step(plant.measure(draw))
        acting, late = late, (step.displacement_acceleration, step.tilt_acceleration)
        for k in range(1, round(PERIOD / STEP) + 1):
            plant.advance(acting)
            if k % round(SAMPLE / STEP) == 0:
                rows.append(row(plant, draw))
    return np.array(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contact", choices=["solid", "footprint"], default="solid")
    parser.add_argument("--mu", type=float, default=0.3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--model", type=Path, default=MODEL)
    parser.add_argument("--diagnose", action="store_true")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    draw, files = np.random.default_rng(given.seed), []
    logs = {"experiment_1": experiment, "move_1": move, "move_2": move}
    for name, log in logs.items():
        files.append(given.out / f"{name}.csv")
        rows = log(given.contact, given.mu, draw)
        np.savetxt(files[-1], rows, delimiter=",", header=",".join(NAMES), comments="", fmt="%.9g")
    if given.diagnose:
        print(diagnose(System.from_file(given.model), files[:2], files[2], window=0.5))


if __name__ == "__main__":
    main()
