#!/usr/bin/env python3
"""Traps for `bracketry diagnose`: plants with a known fault, and what the command says of them.

    cargo build --release
    python3 benches/diagnosis/traps.py [--draws 5] [--seed 1] [--only KIND[,KIND]] [--plant NAME] [--keep FOLDER] [--record]

It needs NumPy.

Every draw takes a plant, random parameters, a random input, and one fault. The plant is simulated here, in NumPy with small fixed steps,
independently of the simulator of the command. The command sees the model without the fault and a CSV with noise. An answer is

- right: the name of the fault, or one that stands under `confusable_with`, or an abstention where the fault has no name in the library;
- open: no name (`unexplained`, `unknown_term`, `partly_explained`, `no_gain`, `nothing_found`) although the library has one;
- wrong: another name.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMAND = ROOT / "target/release/bracketry"
RECORD = ROOT / "docs/records/diagnose_traps.md"
STEP, SAMPLE, DURATION = 5e-4, 5e-3, 10.0
#: Verdicts that name nothing.
ABSTAINED = {"unexplained", "unknown_term", "no_gain", "partly_explained"}


@dataclass
class Plant:
    name: str
    states: list[str]
    positions: list[str]
    equations: dict[str, str]
    #: Ranges of the parameters, from which each draw is taken.
    parameters: dict[str, tuple[float, float]]
    amplitude: float
    measured: list[str]
    #: The state whose rate a missing force acts on, its velocity or level, and its position.
    forced: tuple[str, str, str]
    offset: float = 0.0
    start: dict[str, float] = field(default_factory=dict)
    #: Coulomb friction, as (state, parameter, parameter of the inertia).
    friction: tuple[str, str, str] | None = None
    #: The only faults that it is drawn for; all where none are given.
    only: tuple[str, ...] = ()


PLANTS = [
    Plant("slider", ["x", "v"], ["x"], {"x": "v", "v": "(u - Fc*sign(v))/m"}, {"m": (0.5, 2), "Fc": (0.5, 1.5)}, 4.0,
          ["x", "v"], ("v", "v", "x"), friction=("v", "Fc", "m")),
    Plant("pendulum", ["th", "w"], ["th"], {"th": "w", "w": "(u - b*w - m*9.81*l*sin(th))/(m*l^2)"},
          {"m": (0.5, 1.5), "l": (0.3, 0.8), "b": (0.05, 0.2)}, 1.5, ["th", "w"], ("w", "w", "th")),
    Plant("motor", ["i", "w"], [], {"i": "(u - R*i - K*w)/L", "w": "(K*i - b*w)/J"},
          {"R": (1, 3), "K": (0.2, 0.6), "L": (0.05, 0.2), "J": (0.01, 0.04), "b": (0.005, 0.02)}, 6.0, ["i", "w"],
          ("w", "w", "i")),
    Plant("tanks", ["h1", "h2"], [], {"h1": "(q - c1*sqrt(h1))/A", "h2": "(c1*sqrt(h1) - c2*sqrt(h2))/A"},
          {"A": (0.5, 1.0), "c1": (0.5, 0.9), "c2": (0.5, 0.9)}, 0.5, ["h1", "h2"], ("h1", "h1", "h2"), offset=1.0,
          start={"h1": 1.5, "h2": 1.5}),
    Plant("masses", ["x1", "x2", "v1", "v2"], ["x1", "x2"],
          {"x1": "v1", "x2": "v2", "v1": "(u - k*(x1 - x2) - d*(v1 - v2))/m1", "v2": "(k*(x1 - x2) + d*(v1 - v2) - c*v2)/m2"},
          {"m1": (0.5, 1.5), "m2": (0.5, 1.5), "k": (10, 40), "d": (0.1, 0.5), "c": (0.3, 1.0)}, 3.0,
          ["x1", "x2", "v1", "v2"], ("v1", "v1", "x1")),
    Plant("exchanger", ["Th", "Tc"], [], {"Th": "(r*u - k*(Th - Tc))/C1", "Tc": "(k*(Th - Tc) - c*(Tc - 15))/C2"},
          {"C1": (0.5, 1.5), "C2": (0.5, 1.5), "k": (0.7, 1.5), "c": (0.7, 1.5), "r": (0.8, 1.2)}, 10.0, ["Th", "Tc"], ("Th", "Th", "Tc"),
          offset=30.0, start={"Th": 75.0, "Tc": 45.0}, only=("none", "temperature")),
]

#: Each fault with the names that are right. Without any, only an abstention is.
FAULTS: dict[str, set[str]] = {
    "none": {"nothing_found"},
    "outliers": {"nothing_found"},
    "lost_rows": {"nothing_found"},
    "wrong_parameter": {"parameter_error", "input_gain"},
    "sign_measured": {"wrong_sign"},
    "sign_input": {"wrong_sign"},
    "unit_measured": {"wrong_unit"},
    "unit_input": {"wrong_unit"},
    "swapped": {"swapped_columns"},
    "wrong_column": {"wrong_column"},
    # Where the model has the same term, its parameter is wrong.
    "viscous": {"viscous_friction", "leak", "parameter_error"},
    "coulomb": {"coulomb_friction"},
    "quadratic": {"quadratic_drag", "quadratic_loss"},
    "stiffness": {"linear_stiffness", "parameter_error"},
    "constant": {"tilt", "constant_bias", "gravity"},
    "sensor_offset": {"sensor_bias"},
    "delay": {"input_delay", "sensor_delay"},
    "lag": {"actuator_lag"},
    "gain": {"input_gain", "parameter_error"},
    "ripple": {"periodic_disturbance"},
    "saturation": {"saturation"},
    "dead_zone": {"dead_zone"},
    "jump": {"parameter_jump"},
    "drift": {"sensor_drift"},
    "filter": {"sensor_lag"},
    "hidden_mode": {"elastic_joint", "hidden_vibration"},
    # The parameter has another value for most of the time.
    "slow_change": {"parameter_error"},
    "hysteresis": {"hysteresis"},
    "outliers_of_column": {"nothing_found"},
    # A measured column is on another scale: kelvin, or degrees Fahrenheit.
    "temperature": {"wrong_unit"},
}
#: Faults that have no name of their own: an abstention is right, too.
NAMELESS = {"slow_change"}
UNITS = [1000, 1e-3, 180 / math.pi, math.pi / 180, 100, 0.01, 2 * math.pi, 60 / (2 * math.pi), 60, 9.80665, 0.0254]


def excitation(rng: np.random.Generator, n: int, amplitude: float) -> np.ndarray:
    t = np.arange(n) * STEP
    count = rng.integers(6, 15)
    low, high = rng.uniform(0.1, 0.3), rng.uniform(1.5, 3.0)
    u = sum(rng.uniform(0.5, 1) * np.sin(2 * math.pi * f * t + rng.uniform(0, 6.28)) for f in np.linspace(low, high, count) * rng.uniform(0.95, 1.05, count))
    return amplitude * u / np.sqrt(np.mean(u**2)) / math.sqrt(2)


def draw(rng: np.random.Generator, plant: Plant, fault: str) -> tuple[dict[str, float], str, list[str], np.ndarray] | None:
    """Parameters, the model file, the columns of the log, and their values; `None` where the plant has no such fault."""
    p = {k: float(rng.uniform(*r)) for k, r in plant.parameters.items()}
    true = dict(p)
    if fault == "wrong_parameter":
        k = rng.choice(sorted(set(p) - {"b"}))
        true[k] *= rng.uniform(1.3, 2.0) if rng.random() < 0.5 else rng.uniform(0.5, 0.75)
    if plant.only and fault not in plant.only or fault == "temperature" and plant.name != "exchanger":
        return None
    if fault in ("swapped",) and len(plant.measured) < 2:
        return None
    every, n = round(SAMPLE / STEP), round(DURATION / STEP)
    force, speed, position = plant.forced
    inputs = "q" if plant.name == "tanks" else "u"
    command = plant.offset + excitation(rng, n, plant.amplitude)
    held = np.repeat(command[::every], every)[:n]
    applied = held.copy()
    rms = float(np.sqrt(np.mean((command - plant.offset) ** 2)))
    if fault == "delay":
        late = rng.integers(60, 160)
        applied = np.concatenate([np.full(late, plant.offset), held[:-late]])
    if fault == "lag":
        tau, y = rng.uniform(0.05, 0.15), held[0]
        for k in range(n):
            y += STEP / tau * (held[k] - y)
            applied[k] = y
    if fault == "gain":
        applied = plant.offset + (held - plant.offset) * rng.choice([0.6, 0.75, 1.4, 1.7]) if plant.offset == 0 else held * rng.choice([0.75, 1.3])
    if fault == "saturation":
        limit = rng.uniform(0.6, 1.0) * rms
        applied = plant.offset + np.clip(held - plant.offset, -limit, limit)
    if fault == "dead_zone":
        if plant.offset:
            return None
        width = rng.uniform(0.3, 0.7) * rms
        applied = np.sign(held) * np.maximum(np.abs(held) - width, 0)
    gain = {"slider": 1 / true.get("m", 1), "pendulum": 1 / (true.get("m", 1) * true.get("l", 1) ** 2), "motor": true.get("K", 1) / true.get("J", 1),
            "tanks": 1 / true.get("A", 1), "masses": 1 / true.get("m1", 1), "exchanger": 1 / true.get("C1", 1)}[plant.name] * rms * (0.5 if plant.name == "motor" else 1)
    size = rng.uniform(0.12, 0.3) * gain
    code = {s: compile(e.replace("^", "**"), s, "eval") for s, e in plant.equations.items()}
    names = {"sin": math.sin, "cos": math.cos, "sqrt": lambda x: math.sqrt(max(x, 0.0)), "sign": lambda v: math.copysign(1.0, v) if v else 0.0}
    z = {s: plant.start.get(s, 0.0) for s in plant.states}
    reference = {"slider": 0.3, "pendulum": 3.0, "motor": 6.0, "tanks": 1.5, "masses": 0.6, "exchanger": 30.0}[plant.name]
    wave = rng.uniform(0.1, 0.3) if plant.name == "slider" else rng.uniform(0.5, 1.2)
    jump_at = rng.uniform(0.35, 0.65) * n
    out = np.zeros((n // every, len(plant.states)))
    hidden = [0.0, 0.0]
    which = rng.choice(sorted(set(p) - {"b", "d"}))
    grow = rng.choice([0.6, 1.5])
    lasting, fading = (rng.uniform(0.4, 1.0) * n, rng.random() < 0.5) if fault == "slow_change" else (n, False)

    def factor(k: int) -> float:
        """By which the parameter `which` has changed at a step."""
        if fault == "jump":
            return grow if k > jump_at else 1.0
        if fault == "slow_change":
            share = 1 - math.exp(-4 * k / lasting) if fading else min(max((k - jump_at) / lasting + 0.5, 0.0), 1.0)
            return 1 + (grow - 1) * share
        return 1.0

    def rate(z: dict[str, float], u: float, k: int) -> dict[str, float]:
        at = {**true, which: true[which] * factor(k)}
        scope = {**names, **at, **z, inputs: u}
        d = {s: eval(code[s], {"__builtins__": {}}, scope) for s in plant.states}
        v, x = z[speed], z[position]
        extra = {
            "viscous": -size * v / reference,
            "coulomb": 0.0,
            "quadratic": -size * abs(v) * v / reference**2,
            "stiffness": -size * x / (0.3 if plant.name != "pendulum" else 0.6),
            "constant": sign_of * size,
            "ripple": size * math.sin(2 * math.pi * x / wave),
            "hidden_mode": 0.0,
        }.get(fault, 0.0)
        d[force] += extra
        return d

    sign_of = rng.choice([-1.0, 1.0])
    if fault in ("stiffness", "ripple", "coulomb") and not plant.positions:
        return None
    if fault == "coulomb" and plant.friction:
        return None
    if fault in ("hidden_mode", "hysteresis") and not plant.positions:
        return None
    frequency = 2 * math.pi * rng.uniform(2, 4)
    way, share, way_state = 0.0, 1.0, 0.0
    if fault == "hysteresis":
        way, share = rng.uniform(0.02, 0.1) * (0.3 if plant.name != "pendulum" else 1.0), rng.choice([1.0, 0.6])
        size *= 2
    dry = None
    if plant.friction:
        s, f, m = plant.friction
        dry = (s, true[f] / true[m])
    if fault == "coulomb":
        dry = (force, size)
    for k in range(n):
        if k % every == 0:
            out[k // every] = [z[s] for s in plant.states]
        u = applied[k]
        if plant.friction or fault == "coulomb":
            # Friction by a step that never reverses the motion; everything else by an explicit step.
            free = rate({**z, dry[0]: z[dry[0]]}, u, k)
            level = dry[1]
            if plant.friction:
                level *= factor(k) if which == "Fc" else 1 / factor(k)
                free[dry[0]] += level * names["sign"](z[dry[0]])
            for s in plant.states:
                z[s] += STEP * free[s] if s != dry[0] else 0.0
            v = z[dry[0]] + STEP * free[dry[0]]
            z[dry[0]] = math.copysign(max(abs(v) - STEP * level, 0.0), v)
        else:
            a = rate(z, u, k)
            middle = {s: z[s] + 0.5 * STEP * a[s] for s in z}
            b = rate(middle, u, k)
            z = {s: z[s] + STEP * b[s] for s in z}
        if fault == "hysteresis":
            # Bouc and Wen with exponent 1; Dahl's friction with a share of 1.
            v = z[speed]
            way_state += STEP / way * (v - share * abs(v) * way_state - (1 - share) * v * abs(way_state))
            z[force] -= STEP * size * way_state
        if fault == "hidden_mode":
            # A part of the mass hangs on a spring with a damper.
            gap, slip = hidden[0] - z[position], hidden[1] - z[speed]
            pull = frequency**2 * gap + 0.1 * frequency * slip
            hidden[1] -= STEP * pull
            hidden[0] += STEP * hidden[1]
            z[force] += STEP * 0.3 * pull
        if not all(abs(value) < 1e6 for value in z.values()):
            return None
    columns = {s: out[:, i].copy() for i, s in enumerate(plant.states)}
    spread = {s: float(np.std(c)) for s, c in columns.items()}
    if fault == "filter":
        s, tau = str(rng.choice(plant.measured)), rng.uniform(0.05, 0.12)
        y = columns[s][0]
        for k in range(len(columns[s])):
            y += SAMPLE / tau * (columns[s][k] - y)
            columns[s][k] = y
    for s in plant.measured:
        columns[s] += rng.normal(0, 0.01 * spread[s], len(out))
    if fault == "sensor_offset":
        s = plant.forced[1]
        columns[s] += rng.choice([-1, 1]) * rng.uniform(0.2, 0.5) * spread[s]
    if fault == "drift":
        s = plant.measured[0]
        columns[s] += rng.uniform(0.5, 1.0) * spread[s] * np.linspace(0, 1, len(out))
    if fault == "sign_measured":
        # A column alone has a sign of its own only where the model relates it to others.
        s = str(rng.choice(plant.measured))
        columns[s] *= -1
    if fault == "unit_measured":
        s = str(rng.choice(plant.measured))
        columns[s] *= rng.choice(UNITS)
    if fault == "temperature":
        s = str(rng.choice(plant.measured))
        columns[s] = columns[s] + 273.15 if rng.random() < 0.5 else 1.8 * columns[s] + 32
    if fault == "swapped":
        a, b = rng.choice(plant.measured, 2, replace=False)
        columns[a], columns[b] = columns[b], columns[a]
    if fault == "wrong_column":
        a, b = rng.choice(plant.measured, 2, replace=False)
        columns[a] = columns[b] + rng.normal(0, 0.01 * spread[b], len(out))
    log_input = command[::every][: len(out)].copy()
    if fault == "sign_input":
        log_input *= -1
    if fault == "unit_input":
        log_input *= rng.choice(UNITS)
    rows = np.column_stack([np.arange(len(out)) * SAMPLE, log_input] + [columns[s] for s in plant.measured])
    if fault == "outliers":
        for _ in range(len(out) // 100):
            c = rng.integers(2, rows.shape[1])
            rows[rng.integers(0, len(out)), c] += rng.choice([-1, 1]) * rng.uniform(5, 15) * spread[plant.measured[c - 2]]
    if fault == "outliers_of_column":
        c, far = rng.integers(2, rows.shape[1]), rng.uniform(0.3, 3)
        for k in rng.choice(len(out), len(out) // 100, replace=False):
            rows[k, c] += rng.choice([-1, 1]) * rng.uniform(1, 2) * far * spread[plant.measured[c - 2]]
    if fault == "lost_rows":
        keep = np.ones(len(rows), bool)
        for _ in range(4):
            a = rng.integers(100, len(rows) - 200)
            keep[a : a + rng.integers(3, 60)] = False
        rows = rows[keep]
    model = f'name = "{plant.name}"\nstates = {json.dumps(plant.states)}\ninputs = ["{inputs}"]\n[parameters]\n'
    # The model knows its parameters to two percent.
    model += "".join(f"{k} = {v * rng.uniform(0.98, 1.02):.6g}\n" for k, v in p.items())
    model += "[dynamics]\n" + "".join(f'{s} = "{e}"\n' for s, e in plant.equations.items())
    if plant.start:
        model += "[point]\n" + "".join(f"{s} = {v}\n" for s, v in plant.start.items()) + f"{inputs} = {plant.offset}\n"
    return true, model, ["t", inputs, *plant.measured], rows


def judge(fault: str, answer: dict) -> str:
    right = FAULTS[fault]
    verdict = answer["verdict"]
    named = [c for c in answer.get("causes", []) if c["name"] != "unknown_term"]
    if verdict in right or ("wrong_unit" in right and any(w in verdict for w in ("it is in", "its rate is in", "wrong_unit"))):
        return "right"
    if not named:
        has_name = right & NAMES if fault not in NAMELESS else set()
        return "open" if has_name else ("right" if verdict in ABSTAINED else "open")
    sets = [{c["name"], *c.get("confusable_with", [])} for c in named]
    if all(s & right for s in sets) or (sets[0] & right and named[0]["name"] in right and len(named) <= 2):
        return "right"
    return "wrong"


#: Names that the command knows.
NAMES = {"nothing_found"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=5, help="of each fault on each plant")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--plant", default="")
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--command", default=str(COMMAND))
    parser.add_argument("--record", action="store_true", help="write docs/records/diagnose_traps.md")
    given = parser.parse_args()
    causes = (ROOT / "crates/diagnose/src/effect.rs").read_text()
    body = causes[causes.index("pub enum Cause {") :]
    for word in body[: body.index("}")].split("{")[1].replace(",", " ").split():
        NAMES.add("".join("_" + c.lower() if c.isupper() else c for c in word).strip("_"))
    table: Counter[tuple[str, str]] = Counter()
    for fault in [f for f in FAULTS if not given.only or f in given.only.split(",")]:
        for plant in [p for p in PLANTS if not given.plant or p.name == given.plant]:
            for k in range(given.draws):
                rng = np.random.default_rng([given.seed, list(FAULTS).index(fault), PLANTS.index(plant), k])
                drawn = draw(rng, plant, fault)
                if drawn is None:
                    continue
                _, model, header, rows = drawn
                folder = given.keep or pathlib.Path(tempfile.mkdtemp())
                folder.mkdir(exist_ok=True)
                stem = f"{fault}_{plant.name}_{k}"
                (folder / f"{stem}.toml").write_text(model)
                np.savetxt(folder / f"{stem}.csv", rows, delimiter=",", header=",".join(header), comments="", fmt="%.8g")
                started = time.time()
                try:
                    run = subprocess.run([given.command, "diagnose", f"{stem}.toml", f"{stem}.csv", "--json"], cwd=folder,
                                         capture_output=True, text=True, timeout=300)
                    answer = json.loads(run.stdout)
                except (subprocess.TimeoutExpired, json.JSONDecodeError) as error:
                    answer = {"verdict": f"none: {str(error)[:60]} {run.stderr[:300] if 'run' in dir() else ''}", "causes": []}
                how = judge(fault, answer)
                table[fault, how] += 1
                names = [c["name"] + (":" + c.get("equation", "")) for c in answer.get("causes", [])]
                gain = answer.get("gain") or {}
                excess = answer.get("excess") or {}
                print(f"{how:6} {stem:24} {answer['verdict']:16} {','.join(names)} gain {[round(g, 4) for g in gain.get('as_given', [])]} "
                      f"{[round(g, 4) for g in gain.get('before', [])]} {[round(g, 4) for g in gain.get('after', [])]} excess "
                      f"{excess.get('refitted', 0):.3g} {excess.get('extended') or 0:.3g} {time.time() - started:.1f} s", flush=True)
    rows = results(table)
    print("\n".join(rows))
    if given.record:
        write_record(rows, given)


def results(table: Counter[tuple[str, str]]) -> list[str]:
    kinds = ("right", "open", "wrong")
    rows = ["| fault | draws | right | open | wrong |", "|---|---|---|---|---|"]
    totals = Counter(how for _, how in table.elements())
    for fault in FAULTS:
        counts = [table[fault, how] for how in kinds]
        if sum(counts):
            rows.append(f"| {fault.replace('_', ' ')} | {sum(counts)} | " + " | ".join(map(str, counts)) + " |")
    share = [f"{totals[how]} ({100 * totals[how] / max(1, totals.total()):.1f} %)" for how in kinds]
    rows.append(f"| all | {totals.total()} | " + " | ".join(share) + " |")
    return rows


def write_record(rows: list[str], given: argparse.Namespace) -> None:
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True)
    begin, end = "<!-- measured: begin -->", "<!-- measured: end -->"
    text = RECORD.read_text()
    command = f"python3 benches/diagnosis/traps.py --draws {given.draws} --seed {given.seed} --record"
    made = f"Made at commit {commit.stdout.strip()} by `{command}`."
    before, after = text[: text.index(begin)], text[text.index(end) :]
    RECORD.write_text(before + begin + "\n" + made + "\n\n" + "\n".join(rows) + "\n" + after)


if __name__ == "__main__":
    sys.exit(main())
