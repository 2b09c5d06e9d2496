#!/usr/bin/env python3
"""One move in MuJoCo as a figure and an animation: `python examples/mujoco_plate/move.py [--out docs/figures]`.

An ellipse is moved by 60 mm and 30 mm and turned by 90° at once; friction is weaker than the controller assumes. The animation needs
rendering without a screen: set MUJOCO_GL to what the machine has (egl, if it is not set).
"""

from __future__ import annotations

import argparse
import math
import os
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import matplotlib
import mujoco
import numpy as np
from loop import BELIEVED, PERIOD, TOLERANCE, closed_loop, controller, error
from PIL import Image
from plant import Body, Floats, Plant

matplotlib.use("agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

BODY, FRICTION = Body.ellipse(0.15, 0.10), 0.25
START, TARGET = (-0.03, -0.015, 0.0), np.array([0.03, 0.015, math.pi / 2])
#: Width and height of the animation in pixels, and samples from picture to picture.
SIZE, EVERY = (400, 260), 4


def figure(t: Floats, poses: Floats, plates: Floats) -> Figure:
    drawn, axes = plt.subplots(3, 1, figsize=(9, 6.5), sharex=True, layout="constrained")
    for i, (name, color) in enumerate((("x", "tab:blue"), ("y", "tab:orange"))):
        axes[0].plot(t, 1e3 * poses[:, i], color=color, label=f"object, {name}")
        axes[0].axhline(1e3 * TARGET[i], color=color, ls="--", lw=1, label=f"target, {name}")
    axes[1].plot(t, np.degrees(poses[:, 2]), color="tab:green", label="object, φ")
    axes[1].axhline(math.degrees(TARGET[2]), color="tab:green", ls="--", lw=1, label="target, φ")
    axes[2].plot(t, 1e3 * plates[:, 0], color="tab:purple", label="plate, X (mm)")
    axes[2].plot(t, np.degrees(plates[:, 2]), color="tab:red", label="plate, θ (°)")
    for axis, label in zip(axes, ("position on the plate (mm)", "yaw on the plate (°)", "X (mm), θ (°)")):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        axis.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    axes[2].set_xlabel("time (s)")
    axes[0].set_title(f"Ellipse 0.15 m × 0.10 m in MuJoCo, μ = {FRICTION}, {BELIEVED} assumed initially")
    return drawn


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    plant = Plant(BODY, FRICTION, START, mark=TARGET)
    renderer = mujoco.Renderer(plant.model, SIZE[1], SIZE[0])
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = (0.0, 0.0, 0.0), 0.85, 65, -35
    t, poses, plates, pictures = [], [], [], []
    for k, _ in enumerate(closed_loop(plant, controller(BODY, TARGET), np.random.default_rng(given.seed))):
        t.append(plant.time)
        poses.append(plant.pose)
        plates.append(plant.plate.copy())
        if k % EVERY == 0:
            mujoco.mj_forward(plant.model, plant.data)
            renderer.update_scene(plant.data, camera)
            pictures.append(Image.fromarray(renderer.render()))
    figure(np.array(t), np.array(poses), np.array(plates)).savefig(given.out / "mujoco_move.png", dpi=100)
    few = [picture.quantize(48, dither=Image.Dither.NONE) for picture in pictures]
    few[0].save(
        given.out / "mujoco_move.gif", save_all=True, append_images=few[1:], duration=round(1e3 * EVERY * PERIOD), loop=0
    )
    x, y, yaw = error(plant, TARGET)
    print(f"{plant.time:.2f} s; error at the end {1e3 * x:.1f} mm, {1e3 * y:.1f} mm, {math.degrees(yaw):.1f}°")
    assert max(abs(x), abs(y)) <= TOLERANCE[0]


if __name__ == "__main__":
    main()
