"""The vibrating plate in MuJoCo: the plate moves along commanded accelerations, the object is a free rigid body.

The plate's positions are exact after every step of the engine. Contact is soft, friction has an elliptic cone. With contact "solid",
the engine finds the points of contact from the shapes: four at the rim, which carry all of the load. With contact "footprint", the object
stands on small spheres that are spread over its lower face, so that the pressure is that of an area.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Contact = Literal["solid", "footprint"]

#: Bounds of |X| (m), |theta| (rad), |X''| (m/s²), |theta''| (rad/s²), as in docs/records/plate_control.md.
BOUNDS = (0.1, math.radians(20), 15.0, 60.0)
#: Time step of the engine in s.
STEP = 5e-4
#: So heavy (kg, kg m²) that the object does not move the plate.
PLATE = 1e5
#: Time constant and impedance of the contacts: at rest the object sinks in by micrometers.
SOFTNESS = 'solref="0.004 1" solimp="0.95 0.99 0.001"'
#: Stiffness of friction relative to that of the contact: an object that sticks creeps the less, the larger it is.
FRICTION_STIFFNESS = 10
#: Radius (m) and rough number of the spheres of a footprint.
SPHERE, SPHERES = 1e-3, 60
#: Half sides of the plate that is shown, and height of a mark on it, in m.
SHOWN, MARK = (0.3, 0.25), 5e-4
#: Geoms without contact.
UNTOUCHED = 'contype="0" conaffinity="0"'
#: Corners of the mesh of an ellipse.
CORNERS = 64


@dataclass(frozen=True)
class Body:
    """A flat object: kind, shape as `bracketry.plate` takes it, outline in m (corners around the center of mass)."""

    kind: str
    shape: str | list[list[float]]
    outline: Floats
    #: Geom of MuJoCo; a mesh is made from the outline.
    geom: str
    thickness: float = 0.005
    mass: float = 0.2

    @classmethod
    def disk(cls, radius: float, thickness: float = 0.005) -> Body:
        geom = f'type="cylinder" size="{radius} {thickness / 2}"'
        return cls("disk", f"disk:{radius}", _ellipse(radius, radius), geom, thickness)

    @classmethod
    def ellipse(cls, a: float, b: float, thickness: float = 0.005) -> Body:
        """With semi-axes in m."""
        return cls("ellipse", f"ellipse:{a}x{b}", _ellipse(a, b), 'type="mesh" mesh="object"', thickness)

    @classmethod
    def rectangle(cls, a: float, b: float, thickness: float = 0.005) -> Body:
        """With full sides in m."""
        outline = np.array([[a, b], [-a, b], [-a, -b], [a, -b]]) / 2
        geom = f'type="box" size="{a / 2} {b / 2} {thickness / 2}"'
        return cls("rectangle", f"rectangle:{a}x{b}", outline, geom, thickness)

    @classmethod
    def polygon(cls, corners: Floats, thickness: float = 0.005) -> Body:
        """Convex, corners counterclockwise in m; moved so that the center of mass is at 0."""
        outline = corners - _centroid(corners)
        return cls("polygon", outline.tolist(), outline, 'type="mesh" mesh="object"', thickness)


class Plant:
    """An object at rest at a pose x, y (m), yaw (rad) on the level plate."""

    def __init__(
        self, body: Body, mu: float, pose: tuple[float, float, float], contact: Contact = "solid", mark: Floats | None = None
    ) -> None:
        """`mark`: a pose that pictures show on the plate."""
        self.body = body
        self.model: Any = mujoco.MjModel.from_xml_string(_scene(body, mu, contact, mark))
        self.data: Any = mujoco.MjData(self.model)
        self.data.qpos[2:5] = pose[0], pose[1], body.thickness / 2
        self.data.qpos[5:9] = math.cos(pose[2] / 2), 0, 0, math.sin(pose[2] / 2)
        #: X (m), X' (m/s), theta (rad), theta' (rad/s).
        self.plate = np.zeros(4)
        #: Largest |X|, |theta|, |X''|, |theta''| so far.
        self.largest = np.zeros(4)
        self._yaw = pose[2]

    @property
    def time(self) -> float:
        return float(self.data.time)

    @property
    def pose(self) -> Floats:
        """x, y (m) and yaw (rad, not wrapped) in the frame of the plate."""
        x, y, _, yaw, _ = self._relative()
        self._yaw += math.remainder(yaw - self._yaw, math.tau)
        return np.array([x, y, self._yaw])

    @property
    def gap(self) -> float:
        """Height of the lowest point of the rim above the plate in m, negative where it sinks in."""
        _, _, z, _, rotation = self._relative()
        corners = np.c_[self.body.outline, np.full(len(self.body.outline), -self.body.thickness / 2)]
        return float(z + (corners @ rotation.T)[:, 2].min())

    def measure(self, noise: np.random.Generator, deviations: tuple[float, float] = (5e-4, math.radians(0.5))) -> Floats:
        """The pose with noise: standard deviations of position (m) and yaw (rad)."""
        return self.pose + noise.normal(0, [deviations[0], deviations[0], deviations[1]])

    def advance(self, accelerations: tuple[float, float]) -> None:
        """One step of the engine with X'' (m/s²) and theta'' (rad/s²)."""
        (x, v, theta, w), (a, alpha), h = self.plate, accelerations, STEP
        self.follow((x + h * (v + h / 2 * a), v + h * a, theta + h * (w + h / 2 * alpha), w + h * alpha))
        self._note(0, 0, a, alpha)

    def follow(self, plate: tuple[float, float, float, float]) -> None:
        """One step of the engine, after which the plate has the positions and rates X, X', theta, theta'."""
        data, h = self.data, STEP
        goal = np.array([plate[0], plate[2]])
        # The engine computes q += h (v += h a): with this a, its positions are the exact ones, and so are the object's while it sticks.
        rates = (goal - data.qpos[:2]) / h
        data.qfrc_applied[:2] = (PLATE + 1) * (rates - data.qvel[:2]) / h
        mujoco.mj_step(self.model, data)
        data.qpos[:2], data.qvel[:2] = goal, rates
        self.plate[:] = plate
        self._note(plate[0], plate[2], 0, 0)

    def jump(self, displacement: float) -> None:
        """Moves the plate by so much along x, at once; the object stays where it is in the world."""
        self.data.qpos[0] += displacement
        self.plate[0] += displacement

    def _note(self, *sizes: float) -> None:
        self.largest = np.maximum(self.largest, np.abs(sizes))

    def _relative(self) -> tuple[float, float, float, float, Floats]:
        """Position and yaw of the object in the frame of the plate, and its rotation."""
        data = self.data
        c, s = math.cos(data.qpos[1]), math.sin(data.qpos[1])
        plate = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, data.qpos[5:9])
        rotation = plate.T @ rotation.reshape(3, 3)
        x, y, z = plate.T @ (data.qpos[2:5] - [data.qpos[0], 0, 0])
        return x, y, z, math.atan2(rotation[1, 0], rotation[0, 0]), rotation


def _ellipse(a: float, b: float) -> Floats:
    angles = np.linspace(0, math.tau, CORNERS, endpoint=False)
    return np.asarray(np.c_[a * np.cos(angles), b * np.sin(angles)])


def _centroid(corners: Floats) -> Floats:
    following = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]
    return np.asarray(((corners + following) * cross[:, None]).sum(axis=0) / (3 * cross.sum()))


def _inside(outline: Floats, points: Floats, margin: float) -> Floats:
    """Those points that are inside a convex outline by a margin."""
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.c_[-edges[:, 1], edges[:, 0]] / np.linalg.norm(edges, axis=1)[:, None]
    depth = np.einsum("kj,nkj->nk", normals, points[:, None, :] - outline[None, :, :])
    return np.asarray(points[(depth >= margin).all(axis=1)])


def footprint(outline: Floats) -> Floats:
    """Points that fill a convex outline evenly: a triangular grid, scaled so that its second moments are those of the area."""
    following = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]
    pitch = math.sqrt(cross.sum() / SPHERES / math.sqrt(3))
    count = 2 * int(np.abs(outline).max() / pitch) + 4
    i, j = np.meshgrid(np.arange(-count, count), np.arange(-count, count))
    grid = pitch * np.c_[(i + 0.5 * (j % 2) + 0.25).ravel(), (math.sqrt(0.75) * (j + 0.5)).ravel()]
    points = _inside(outline, grid, SPHERE)
    points -= points.mean(axis=0)
    summed = outline + following
    pairs = outline[:, :, None] * outline[:, None, :] + following[:, :, None] * following[:, None, :]
    moments = ((pairs + summed[:, :, None] * summed[:, None, :]) * cross[:, None, None]).sum(axis=0) / (12 * cross.sum())
    gained = np.linalg.cholesky(moments) @ np.linalg.inv(np.linalg.cholesky(points.T @ points / len(points)))
    return np.asarray(points @ gained.T)


def _scene(body: Body, mu: float, contact: Contact, mark: Floats | None) -> str:
    half = body.thickness / 2
    corners = " ".join(f"{x} {y} {z}" for z in (-half, half) for x, y in body.outline)
    mesh = f'<mesh name="object" vertex="{corners}"/>' if "mesh" in body.geom else ""
    solid, spheres = "", ""
    if contact == "footprint":
        solid = UNTOUCHED
        spheres = "".join(
            f'<geom type="sphere" size="{SPHERE}" pos="{x} {y} {SPHERE - half}" mass="0"/>'
            for x, y in footprint(body.outline)
        )
    # What only pictures need.
    plate, nose = "", ""
    if mark is not None:
        where = f'pos="{mark[0]} {mark[1]} {MARK - half}" euler="0 0 {math.degrees(mark[2])}"'
        plate = f"""
          <geom {UNTOUCHED} type="box" size="{SHOWN[0]} {SHOWN[1]} 0.01" pos="0 0 -0.01" mass="0" material="plate"/>
          <geom {UNTOUCHED} {body.geom} {where} mass="0" rgba=".25 .7 .4 1"/>"""
        front = body.outline[:, 0].max()
        nose = f'<site type="box" size="{front / 4} {front / 16} 0.0005" pos="{front / 2} 0 {half}" rgba=".2 .1 .05 1"/>'
    return f"""<mujoco>
      <option timestep="{STEP}" cone="elliptic" impratio="{FRICTION_STIFFNESS}"><flag multiccd="enable"/></option>
      <default><geom {SOFTNESS} friction="{mu} 0 0" condim="3"/></default>
      <asset>{mesh}
        <texture type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="32" height="32"/>
        <texture name="checks" type="2d" builtin="checker" rgb1=".82 .84 .87" rgb2=".68 .71 .76" width="256" height="256"/>
        <material name="plate" texture="checks" texrepeat="10 10" texuniform="true"/>
      </asset>
      <worldbody>
        <light pos="0.3 -0.6 1.5" dir="-0.2 0.4 -1" diffuse=".7 .7 .7"/>
        <body name="plate">
          <joint type="slide" axis="1 0 0" armature="{PLATE}"/><joint type="hinge" axis="1 0 0" armature="{PLATE}"/>
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <geom type="box" size="1 1 0.05" pos="0 0 -0.05" rgba="0 0 0 0"/>{plate}
        </body>
        <body name="object"><freejoint/>
          <geom {body.geom} mass="{body.mass}" {solid} rgba=".8 .35 .15 1"/>{spheres}{nose}
        </body>
      </worldbody>
    </mujoco>"""
