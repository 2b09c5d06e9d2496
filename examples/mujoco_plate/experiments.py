#!/usr/bin/env python3
"""The plant alone, before anything is controlled on it: `python examples/mujoco_plate/experiments.py`.

Runs the three published experiments (disk of 0.12 m, mu = 0.3) with both kinds of contact and prints what the object gained beside the
plant of this package, which has friction over the whole footprint; then how far an object creeps that ought to rest.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from plant import STEP, Body, Contact, Floats, Plant

from bracketry import plate

CONTACTS: tuple[Contact, ...] = ("footprint", "solid")
DISK = Body.disk(0.12)
#: Start x, y (m) and yaw, duration (s), frequency of the plate's motion (Hz).
EXPERIMENTS = {1: ((0.3, 0.0, 0.0), 15.0, 2.0), 2: ((0.48, 0.0, 0.0), 6.0, 1.5), 3: ((0.3, -0.03, 0.0), 6.0, 3.0)}


def amplitude(experiment: int, pose: Floats) -> float:
    """Held over a period: 1, or that of X (m) or theta (rad) by the error."""
    if experiment == 1:
        return 1.0
    error = pose[0] - 0.54 if experiment == 2 else pose[1]
    size = 0.015 + 0.3 * abs(error) if experiment == 2 else math.radians(20 + 200 * abs(error))
    return math.copysign(size, error)


def motion(experiment: int, t: float, amp: float) -> tuple[float, float]:
    """X (m) and theta (rad) at a time."""
    rise = 1 - math.exp(-t)
    if experiment == 1:
        wave = math.sin(4 * math.pi * t) * rise
        return 0.025 * wave, -math.radians(15) * wave
    if experiment == 2:
        w = 3 * math.pi
        return amp * (0.51 - 0.5 * math.cos(2 * w * t) - 0.1 * math.cos(4 * w * t)) * rise, 0.0
    return 0.0, amp * (1 - math.cos(6 * math.pi * t)) / 2 * rise


def run(experiment: int, contact: Contact) -> tuple[Floats, Floats, float]:
    """Times, poses, and the largest distance of the lower rim from the plate (m)."""
    start, seconds, frequency = EXPERIMENTS[experiment]
    plant = Plant(DISK, 0.3, start, contact=contact)
    # Experiment 2 has the angular frequency 2 w = 6 pi in its first harmonic: 3 Hz.
    period = round(1 / (2 * frequency if experiment == 2 else frequency) / STEP)
    poses, amp, gap = [plant.pose], 0.0, 0.0
    for k in range(round(seconds / STEP)):
        t = (k + 1) * STEP
        if k % period == 0:
            before, amp = motion(experiment, k * STEP, amp), amplitude(experiment, poses[-1])
            plant.jump(motion(experiment, k * STEP, amp)[0] - before[0])
        displacement, tilt = motion(experiment, t, amp)
        # The rates are not needed by what follows.
        plant.follow((displacement, 0.0, tilt, 0.0))
        poses.append(plant.pose)
        gap = max(gap, abs(plant.gap))
    return np.arange(len(poses), dtype=np.float64) * STEP, np.array(poses), gap


def arrival(t: Floats, values: Floats, start: float, target: float) -> float | None:
    """When 98 % of the distance was first covered."""
    covered = (values - start) / (target - start) >= 0.98
    return float(t[covered.argmax()]) if covered.any() else None


def creep(contact: Contact, degrees: float) -> float:
    """How far a disk with mu = 0.3 moves in 10 s on the tilted plate, in m; it would rest up to 16.7 degrees."""
    plant = Plant(DISK, 0.3, (0.0, 0.0, 0.0), contact=contact)
    tilt, raised = math.radians(degrees), 0.5
    for k in range(round((10 + raised) / STEP)):
        s = min(1.0, (k + 1) * STEP / raised)
        plant.follow((0.0, 0.0, tilt * s * s * (3 - 2 * s), 0.0))
        if (k + 1) * STEP == raised:
            start = plant.pose
    return float(np.linalg.norm(plant.pose[:2] - start[:2]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--experiments", type=int, nargs="*", default=[1, 2, 3])
    chosen = parser.parse_args().experiments
    print("| experiment | contact | x (mm) | y (mm) | yaw (°) | 98 % of the distance (s) | largest gap (mm) |\n|---|---|---|---|---|---|---|")
    for experiment in chosen:
        start, seconds, _ = EXPERIMENTS[experiment]
        ours = plate.run(experiment, shape="disk:0.12", mu=0.3, start=start, seconds=seconds)
        rows = [("area contact of this package", ours.t, ours.states[:, :3], ours.largest_gap)]
        rows += [(f"MuJoCo, {contact}", *run(experiment, contact)) for contact in CONTACTS]
        for name, t, poses, gap in rows:
            gained = poses[-1] - poses[0]
            column, target = {1: (2, math.pi / 2), 2: (0, 0.54), 3: (1, 0.0)}[experiment]
            at = arrival(t, poses[:, column], start[column], target)
            print(
                f"| {experiment} | {name} | {1e3 * gained[0]:.1f} | {1e3 * gained[1]:.1f} | {math.degrees(gained[2]):.1f} "
                f"| {'–' if at is None else f'{at:.1f}'} | {1e3 * gap:.2f} |"
            )
    print()
    for contact in CONTACTS:
        print(f"MuJoCo, {contact}: in 10 s the disk creeps", ", ".join(
            f"{1e6 * creep(contact, degrees):.1f} µm at {degrees}°" for degrees in (0, 5, 10)))


if __name__ == "__main__":
    main()
