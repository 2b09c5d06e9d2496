#!/usr/bin/env python3
"""Random moves on the plate in MuJoCo: `python examples/mujoco_plate/trials.py --trials 200`.

Draws objects (disk, ellipse, rectangle, polygon), friction, starts and targets; the controller assumes mu = 0.3 and measures the pose
with noise of 0.5 mm and 0.5° every 20 ms; a command acts one sample late. A move succeeds if from some instant on, until its end, one
second after the controller has finished, the object is within 2 mm (x and y) and 2° (yaw) of its target while the plate is at rest.
The time to target is the first such instant; it is infinite for a move that fails. Prints tables. `--record` runs what
docs/records/plate_mujoco.md states and puts the tables there.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import re
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from loop import arrived, closed_loop, controller, error
from plant import BOUNDS, Body, Contact, Plant

RECORD = Path(__file__).resolve().parents[2] / "docs/records/plate_mujoco.md"
KINDS = ("disk", "ellipse", "rectangle", "polygon")
FRICTION = ((0.15, 0.25), (0.25, 0.35), (0.35, 0.5))


@dataclass(frozen=True)
class Result:
    """One move: what was drawn, and what came of it. Lengths in m, angles in rad, times in s."""

    index: int
    kind: str
    thickness: float
    mu: float
    start: list[float]
    target: list[float]
    #: Time to target, infinite if it is not reached.
    time: float
    status: str
    #: Error at the end.
    error: list[float]
    #: Friction coefficient assumed by the controller at the end.
    believed: float
    #: Moves of the plate from rest to rest.
    moves: int
    #: Largest |X|, |theta|, |X''|, |theta''|.
    largest: list[float]
    #: Largest height of the object's lowest point above the plate.
    gap: float
    #: Wall time of the first plan, and of the slowest sample after it.
    first_plan: float
    slowest: float

    @property
    def reached(self) -> bool:
        return math.isfinite(self.time)

    @property
    def bounds_kept(self) -> bool:
        return all(size <= bound * (1 + 1e-9) for size, bound in zip(self.largest, BOUNDS))


def random_body(kind: str, draw: np.random.Generator) -> Body:
    if kind == "disk":
        return Body.disk(draw.uniform(0.08, 0.14))
    a, share = draw.uniform(0.1, 0.16), draw.uniform(0.5, 0.9)
    if kind == "ellipse":
        return Body.ellipse(a, a * share)
    if kind == "rectangle":
        return Body.rectangle(2 * a, 2 * a * share, thickness=float(draw.choice([0.005, 0.02])))
    while True:
        angles = np.sort(draw.uniform(0, math.tau, draw.integers(3, 8)))
        gaps = np.diff(angles, append=angles[0] + math.tau)
        # Neither slender nor with corners that nearly coincide.
        if gaps.max() < 2.4 and gaps.min() > 0.3:
            return Body.polygon(np.c_[a * np.cos(angles), a * max(share, 0.7) * np.sin(angles)])


def move(index: int, *, seed: int, contact: Contact, mu_deviation: float) -> Result:
    """Draws and runs a move; it depends on seed and index only."""
    draw = np.random.default_rng([seed, index])
    kind = KINDS[index % len(KINDS)]
    body, mu = random_body(kind, draw), draw.uniform(0.15, 0.5)
    start, target = (draw.uniform([-0.1, -0.1, -math.pi], [0.1, 0.1, math.pi]) for _ in range(2))
    plant, since, gap = Plant(body, mu, tuple(start), contact), math.inf, 0.0
    walls, moves, resting, clock = [], 0, 99, time.perf_counter()
    for step in closed_loop(plant, controller(body, target, mu_deviation), draw):
        walls.append(time.perf_counter() - clock)
        since = min(since, plant.time) if arrived(plant, target) else math.inf
        gap = max(gap, plant.gap)
        moving = max(abs(step.displacement_acceleration), abs(step.tilt_acceleration)) > 0.1
        moves += moving and resting > 4
        resting = 0 if moving else resting + 1
        clock = time.perf_counter()
    return Result(
        index, kind, body.thickness, mu, start.tolist(), target.tolist(), since, step.status, error(plant, target).tolist(), step.mu,
        moves, plant.largest.tolist(), gap, walls[0], max(walls[1:]),
    )  # fmt: skip


def wilson(successes: int, count: int) -> tuple[float, float]:
    """95 % interval of a share."""
    z, share = 1.96, successes / count
    middle, half = share + z * z / (2 * count), z * math.sqrt(share * (1 - share) / count + z * z / (4 * count**2))
    return (middle - half) / (1 + z * z / count), (middle + half) / (1 + z * z / count)


def quantile(values: Iterable[float], share: float) -> str:
    """As text, by the sorted value itself, so that it may be infinite."""
    ordered = sorted(values)
    value = ordered[min(len(ordered) - 1, int(share * len(ordered)))]
    return f"{value:.2f}" if math.isfinite(value) else "–"


def table(results: list[Result]) -> str:
    """Shares and times of all, per kind of object and per friction."""
    groups: list[tuple[str, Callable[[Result], bool]]] = [("all", lambda r: True)]
    groups += [(kind, partial(lambda kind, r: r.kind == kind, kind)) for kind in KINDS]
    groups += [(f"μ {a} to {b}", partial(lambda a, b, r: a <= r.mu < b, a, b)) for a, b in FRICTION]
    lines = ["| moves | reached (95 %) | time: median, 5 %…95 % (s) | bounds kept |", "|---|---|---|---|"]
    for name, chosen in groups:
        some = [r for r in results if chosen(r)]
        if not some:
            continue
        reached, times = sum(r.reached for r in some), [r.time for r in some]
        low, high = wilson(reached, len(some))
        lines.append(
            f"| {name} | {reached}/{len(some)}, {100 * reached / len(some):.1f} % ({100 * low:.1f}…{100 * high:.1f}) "
            f"| {quantile(times, 0.5)}, {quantile(times, 0.05)}…{quantile(times, 0.95)} "
            f"| {sum(r.bounds_kept for r in some)}/{len(some)} |"
        )
    moves = [r.moves for r in results]
    lines += [
        "",
        f"Moves from rest to rest: {np.mean(moves):.1f} on average, {max(moves)} at most. Wall time of the first plan: "
        f"{quantile([r.first_plan for r in results], 0.5)} s at the median, {max(r.first_plan for r in results):.2f} s at most; "
        f"largest height of an object's lowest point above the plate {1e3 * max(r.gap for r in results):.2f} mm.",
    ]
    failed = [r for r in results if not r.reached]
    if failed:
        lines += ["", "| failed | object | μ | final estimate of μ | status | moves | error at the end |", "|---|---|---|---|---|---|---|"]
    for r in failed:
        x, y, yaw = 1e3 * r.error[0], 1e3 * r.error[1], math.degrees(r.error[2])
        lines.append(
            f"| {r.index} | {r.kind}, {1e3 * r.thickness:.0f} mm | {r.mu:.3f} | {r.believed:.3f} | {r.status} | {r.moves} "
            f"| {x:.1f} mm, {y:.1f} mm, {yaw:.1f}° |"
        )
    return "\n".join(lines)


def record(tables: dict[str, str]) -> None:
    """Puts each table between its two marks in the record."""
    text = RECORD.read_text(encoding="utf-8")
    for name, content in tables.items():
        marks = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        found = marks.search(text)
        assert found, name
        text = f"{text[: found.start()]}{found[1]}\n{content}\n\n{found[2]}{text[found.end() :]}"
    RECORD.write_text(text, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--contact", choices=["solid", "footprint"], nargs="*", default=["solid", "footprint"])
    parser.add_argument("--mu-deviation", type=float, default=0.3, help="as the controller is told")
    parser.add_argument("--index", type=int, nargs="*", help="these moves only")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--json", type=Path, help="every move, to this file")
    parser.add_argument("--record", action="store_true", help="put the tables into docs/records/plate_mujoco.md")
    given = parser.parse_args()
    indices = given.index if given.index else range(given.trials)
    results: dict[str, list[Result]] = {}
    for contact in given.contact:
        run = partial(move, seed=given.seed, contact=contact, mu_deviation=given.mu_deviation)
        with ProcessPoolExecutor(given.jobs) as processes:
            results[contact] = []
            for result in processes.map(run, indices):
                results[contact].append(result)
                came = f"{result.time:.2f} s" if result.reached else result.status
                print(f"{contact} {result.index}: {result.kind}, mu {result.mu:.3f}, {result.moves} moves, {came}", flush=True)
                if given.json:
                    every = {contact: [asdict(r) for r in some] for contact, some in results.items()}
                    given.json.write_text(json.dumps(every, indent=1), encoding="utf-8")
        print(f"\n{contact}\n\n{table(results[contact])}", flush=True)
    if given.record:
        command = f"python examples/mujoco_plate/trials.py --trials {given.trials} --seed {given.seed} --record"
        record({contact: f"`{command}`\n\n{table(some)}" for contact, some in results.items()})
        print(f"\nwritten to {RECORD.name} ({platform.machine()}, Python {platform.python_version()})")


if __name__ == "__main__":
    main()
