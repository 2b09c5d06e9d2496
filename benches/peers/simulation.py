"""The plate's experiments by SciPy and MuJoCo. Prints JSON; CPU time of the process, medians, in seconds.

Usage: simulation.py
"""
import itertools
import json
import math
import statistics
import time

import mujoco
import mujoco.rollout
import numpy as np
import scipy
from scipy.integrate import solve_ivp

DURATION = 15.0
GRAVITY, FRICTION = 9.81, 0.3
# There are 110; loose tolerances can make a method stop and break loose at one instant for ever.
MOST_EVENTS = 1000
SAMPLES = np.linspace(0, DURATION, 31)


def median(runs, f):
    result = f()
    times = []
    for _ in range(runs):
        begin = time.process_time()
        result = f()
        times.append(time.process_time() - begin)
    return statistics.median(times), result


# Experiment 1 on the published model, by events

RATE, STROKE, TILT = 4 * math.pi, 0.025, -math.radians(15)
ALONG, ACROSS = 0.15**2 / 4, 0.10**2 / 4


def plate(t):
    """X'', theta, theta''."""
    e = math.exp(-t)
    s, c = math.sin(RATE * t), math.cos(RATE * t)
    turn = -(1 - e) * RATE * RATE * s + 2 * e * RATE * c - e * s
    return STROKE * turn, TILT * (1 - e) * s, TILT * turn


def rates(t, q, x_sign, y_sign):
    """The right-hand side; a sign of None: sticks, and the friction is what holds."""
    _, y, phi, vx, vy, w = q
    acceleration, theta, turn = plate(t)
    if x_sign is None:
        friction, ax = -acceleration / (FRICTION * GRAVITY), 0.0
    else:
        friction, ax = x_sign, -acceleration - x_sign * FRICTION * GRAVITY
    ay = 0.0
    if y_sign is not None:
        ay = -GRAVITY * math.sin(theta) - y_sign * FRICTION * (GRAVITY * math.cos(theta) + y * turn)
    s, c = math.sin(phi), math.cos(phi)
    syy = s * s * ALONG + c * c * ACROSS
    return [vx, vy, w, ax, ay, -friction * FRICTION * syy * turn / (ALONG + ACROSS)]


def x_stops(t, q, x_sign, y_sign):
    return x_sign * q[3]


def y_stops(t, q, x_sign, y_sign):
    return y_sign * q[4]


def x_breaks_loose(t, q, x_sign, y_sign):
    return FRICTION * GRAVITY - abs(plate(t)[0])


def y_breaks_loose(t, q, x_sign, y_sign):
    _, theta, turn = plate(t)
    return FRICTION * (GRAVITY * math.cos(theta) + q[1] * turn) - GRAVITY * abs(math.sin(theta))


for event in (x_stops, y_stops, x_breaks_loose, y_breaks_loose):
    event.terminal, event.direction = True, -1


def x_sign(t, q, may_stick):
    if q[3] != 0:
        return math.copysign(1, q[3])
    drive = -plate(t)[0]
    return None if may_stick and abs(drive) <= FRICTION * GRAVITY else math.copysign(1, drive)


def y_sign(t, q, may_stick):
    if q[4] != 0:
        return math.copysign(1, q[4])
    _, theta, turn = plate(t)
    drive = -GRAVITY * math.sin(theta)
    hold = FRICTION * (GRAVITY * math.cos(theta) + q[1] * turn)
    return None if may_stick and abs(drive) <= hold else math.copysign(1, drive)


def by_events(method, tolerance):
    """x, y, phi at SAMPLES and the number of events."""
    t, q = 0.0, np.array([0.3, 0, 0, 0, 0, 0])
    sx, sy = x_sign(t, q, True), y_sign(t, q, True)
    states, events = [], 0
    while True:
        watched = [x_breaks_loose if sx is None else x_stops, y_breaks_loose if sy is None else y_stops]
        run = solve_ivp(rates, (t, DURATION), q, method=method, rtol=tolerance, atol=1e-2 * tolerance, events=watched,
                        args=(sx, sy), t_eval=SAMPLES[SAMPLES >= t])
        if len(run.t):
            states += np.transpose(run.y)[:, :3].tolist()
        if run.status != 1:
            return states, events
        events += 1
        if events > MOST_EVENTS:
            return None, events
        of_x = len(run.t_events[0]) > 0
        which = 0 if of_x else 1
        t, q = run.t_events[which][0], run.y_events[which][0].copy()
        if of_x:
            stops = sx is not None
            if stops:
                q[3] = 0.0
            sx = x_sign(t, q, stops)
        else:
            stops = sy is not None
            if stops:
                q[4] = 0.0
            sy = y_sign(t, q, stops)


def published_plate():
    reference, events = by_events("DOP853", 1e-13)
    runs = []
    for method in ("RK45", "DOP853", "LSODA"):
        for half_digits in range(6, 25):
            tolerance = 10 ** (-half_digits / 2)
            seconds, (states, n) = median(3, lambda: by_events(method, tolerance))
            if states is None:
                continue
            runs.append({"method": method, "rtol": tolerance, "seconds": seconds, "states": states, "events": n})
    return {"reference": reference, "events": events, "runs": runs}


# Experiment 1 on the reduced model: friction coupled over both directions, and against the spin

HEIGHT = 0.0025
SECOND_MOMENT = 0.12**2 / 4
YAW_INERTIA = 2 * SECOND_MOMENT
slow = 1e-6
# At rest nothing else keeps a step from jumping over a short slip.
LONGEST = 0.02


def tilting(t):
    """X'', theta, theta', theta''."""
    e = math.exp(-t)
    s, c = math.sin(RATE * t), math.cos(RATE * t)
    once = (1 - e) * RATE * c + e * s
    twice = -(1 - e) * RATE * RATE * s + 2 * e * RATE * c - e * s
    return STROKE * twice, TILT * (1 - e) * s, TILT * once, TILT * twice


def forces(t, q):
    """What drives the object along x and y, and the load, all per mass."""
    _, y, _, _, vy, _ = q
    acceleration, theta, rate, turn = tilting(t)
    load = GRAVITY * math.cos(theta) + y * turn + 2 * vy * rate - HEIGHT * rate**2
    return -acceleration, -GRAVITY * math.sin(theta) + y * rate**2 + HEIGHT * turn, load


def friction_against_spin(t):
    return FRICTION * GRAVITY * math.cos(tilting(t)[1]) * SECOND_MOMENT


def slides(t, q):
    _, _, _, vx, vy, w = q
    fx, fy, load = forces(t, q)
    speed = math.hypot(vx, vy) or 1.0
    ex, ey = vx / speed, vy / speed
    spin = w / (math.sqrt(vx * vx + vy * vy + YAW_INERTIA / 4 * w * w) or 1.0)
    torque = FRICTION * tilting(t)[3] * SECOND_MOMENT * ex - friction_against_spin(t) * spin
    return [vx, vy, w, fx - FRICTION * load * ex, fy - FRICTION * load * ey, torque / YAW_INERTIA]


def driving_torque(t, q):
    """While the center sticks: friction along x is what holds it."""
    fx, _, load = forces(t, q)
    return tilting(t)[3] * SECOND_MOMENT * fx / load


def pivots(t, q):
    torque = driving_torque(t, q) - friction_against_spin(t) * 2 / math.sqrt(YAW_INERTIA) * math.copysign(1, q[5])
    return [0.0, 0.0, q[5], 0.0, 0.0, torque / YAW_INERTIA]


def rests(t, q):
    return [0.0] * 6


def center_stops(t, q):
    return math.hypot(q[3], q[4]) - slow


def center_slips(t, q):
    fx, fy, load = forces(t, q)
    return FRICTION * load - math.hypot(fx, fy)


def spin_stops(t, q):
    return abs(q[5]) - slow


def spin_begins(t, q):
    return friction_against_spin(t) * 2 / math.sqrt(YAW_INERTIA) - abs(driving_torque(t, q))


for event in (center_stops, center_slips, spin_stops, spin_begins):
    event.terminal, event.direction = True, -1

WATCHED = {slides: [center_stops], pivots: [center_slips, spin_stops], rests: [center_slips, spin_begins]}


def next_mode(t, q, event):
    """The mode after an event; sets what stops to zero and gives what breaks loose its direction."""
    fx, fy, load = forces(t, q)
    drive = math.hypot(fx, fy)
    if event is center_slips or event is center_stops and drive > FRICTION * load:
        q[3], q[4] = 2 * slow * fx / drive, 2 * slow * fy / drive
        return slides
    q[3] = q[4] = 0.0
    if event is spin_begins or abs(q[5]) <= slow and spin_begins(t, q) < 0:
        q[5] = math.copysign(2 * slow, driving_torque(t, q))
        return pivots
    if abs(q[5]) > slow * (1 + 1e-6):
        return pivots
    q[5] = 0.0
    return rests


def reduced_by_events(method, tolerance, stop_speed):
    """As by_events. A velocity has no zero crossing: what friction can hold stops at `stop_speed`."""
    global slow
    slow = stop_speed
    t, q, mode = 0.0, np.array([0.3, 0, 0, 0, 0, 0]), rests
    states, events = [], 0
    while events <= MOST_EVENTS:
        run = solve_ivp(mode, (t, DURATION), q, method=method, rtol=tolerance, atol=1e-2 * tolerance,
                        events=WATCHED[mode], t_eval=SAMPLES[SAMPLES >= t], max_step=LONGEST)
        if len(run.t):
            states += np.transpose(run.y)[:, :3].tolist()
        if run.status != 1:
            return (states if run.success else None), events
        events += 1
        which = next(i for i, times in enumerate(run.t_events) if len(times))
        t, q = run.t_events[which][0], run.y_events[which][0].copy()
        mode = next_mode(t, q, WATCHED[mode][which])
    return None, events


def reduced_model():
    runs = []
    for method, digits, stop_speeds in (("LSODA", (4, 5, 6, 7), (5e-6, 2e-6, 2e-7)), ("RK45", (6,), (2e-6,)),
                                        ("DOP853", (6,), (2e-6,))):
        for tolerance, stop_speed in itertools.product((10.0**-d for d in digits), stop_speeds):
            try:
                seconds, (states, n) = median(1, lambda: reduced_by_events(method, tolerance, stop_speed))
            except ValueError:
                # An event that SciPy sees in a step but does not find again on its interpolant.
                continue
            if states is not None:
                runs.append({"method": method, "rtol": tolerance, "seconds": seconds, "states": states, "events": n})
    return {"runs": runs}


# MuJoCo: a rigid disk on many spheres, soft contacts

RADIUS, HALF_THICKNESS, MASS = 0.12, 0.0025, 0.2
SPHERE, STEP = 0.005, 5e-4
# So heavy that the object does not move it.
PLATE = 1e5


def footprint():
    """37 points that fill the disk evenly, inside by the radius of a sphere."""
    golden = math.pi * (3 - math.sqrt(5))
    reach = RADIUS - SPHERE
    polar = [(reach * math.sqrt((k + 0.5) / 37), k * golden) for k in range(37)]
    return [(r * math.cos(a), r * math.sin(a)) for r, a in polar]


STIFF = {"option": 'cone="elliptic" impratio="10"', "contact": 'solref="0.004 1" solimp="0.95 0.99 0.001"'}
DEFAULTS = {"option": "", "contact": ""}


def scene(plate_body, x, settings=STIFF):
    spheres = "".join(f'<geom type="sphere" size="{SPHERE}" pos="{px} {py} {SPHERE - HALF_THICKNESS}"/>'
                      for px, py in footprint())
    across = MASS * (RADIUS**2 / 4 + HALF_THICKNESS**2 / 3)
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{STEP}" {settings["option"]}/>
      <default><geom {settings["contact"]} friction="{FRICTION} 0 0" condim="3" mass="0" contype="1"
                     conaffinity="2"/></default>
      <worldbody>{plate_body}
        <body pos="{x} 0 {HALF_THICKNESS}"><freejoint/>
          <inertial pos="0 0 0" mass="{MASS}" diaginertia="{across} {across} {MASS * RADIUS**2 / 2}"/>{spheres}</body>
      </worldbody></mujoco>""")


def soft_contact():
    """Experiment 1 with the plate's motion imposed, all steps in one call of MuJoCo."""
    model = scene(f"""<body><joint type="slide" axis="1 0 0" armature="{PLATE}"/>
      <joint type="hinge" axis="1 0 0" armature="{PLATE}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <geom type="box" size="2 2 0.05" pos="0 0 -0.05" contype="2" conaffinity="1"/></body>""", 0.3)
    data = mujoco.MjData(model)
    steps = round(DURATION / STEP)
    t = STEP * np.arange(-1, steps + 1)
    wave = np.sin(RATE * t) * (1 - np.exp(-t))
    # Second differences: then the positions after every step are those of the formula.
    push = (wave[2:] - 2 * wave[1:-1] + wave[:-2]) / STEP**2 * (PLATE + 1)
    forces = np.zeros((1, steps, model.nv))
    forces[0, :, 0], forces[0, :, 1] = STROKE * push, TILT * push
    start = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    # The first step brings the velocity to what the second difference presumes: from rest at -STEP, 0.
    start[1 + model.nq : 1 + model.nq + 2] = np.array([STROKE, TILT]) * (wave[1] - wave[0]) / STEP

    def run():
        states, _ = mujoco.rollout.rollout(model, data, start[None], forces,
                                           control_spec=mujoco.mjtState.mjSTATE_QFRC_APPLIED.value)
        return states[0]

    seconds, states = median(5, run)
    w, x, y, z = states[:, 6:10].T
    yaw = np.unwrap(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)))
    missed = abs(states[:, 1] - STROKE * wave[2:]).max()
    return {"seconds": seconds, "steps": steps, "yaw": math.degrees(yaw[-1]), "plate_error": float(missed)}


def creep(settings):
    """How far the disk moves in 60 s on a plate tilted by 10 degrees, in meters."""
    model = scene('<geom type="plane" size="2 2 0.1" contype="2" conaffinity="1"/>', 0.0, settings)
    tilt = math.radians(10)
    model.opt.gravity[:] = [0, -GRAVITY * math.sin(tilt), -GRAVITY * math.cos(tilt)]
    data = mujoco.MjData(model)
    for _ in range(round(60 / STEP)):
        mujoco.mj_step(model, data)
    return -float(data.qpos[1])


if __name__ == "__main__":
    print(json.dumps({
        "versions": {"scipy": scipy.__version__, "mujoco": mujoco.__version__, "numpy": np.__version__},
        "published": published_plate(),
        "reduced": reduced_model(),
        "soft_contact": soft_contact(),
        "creep": {"stiff": creep(STIFF), "defaults": creep(DEFAULTS)},
    }))
