#!/usr/bin/env python3
"""Whether an experiment of `bracketry experiment --tell` tells two causes apart that a slow one confuses.

    cargo build --release
    python3 benches/diagnosis/experiments.py [--draws 5] [--seed 1] [--noise 1] [--only PAIR[,PAIR]] [--command FILE] [--keep FOLDER]

Every draw takes a pair of causes, random parameters, and one of the causes as the truth. The sizes of the two are such that a slow experiment confuses
them. `experiment` designs the next one within limits. The truth is simulated exactly under its inputs, and noise is added. Then `diagnose` compares both
models with these data, and the model without either cause. A draw counts as

- told: the true model is accepted (`nothing_found`), and the other one is not;
- named: the diagnosis of the model without the cause names the true cause, and the other one is not among `confusable_with`.

The same is done with the slow experiment. `--noise 30` multiplies the noise, so that some experiments just resolve the causes. Nothing is recorded.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from typing import Callable

ROOT = pathlib.Path(__file__).resolve().parents[2]
DURATION, SAMPLE = 10.0, 0.02
NOISE = {"x": 0.002, "v": 0.01}
LIMITS = "u=-3..3,x=-1..1"


@dataclass
class Pair:
    """Two causes with the force (or the effective input) of each, and what the diagnosis may call it."""

    base: str
    #: Random parameters, and those that belong to the causes, in this order.
    parameters: Callable[[random.Random], tuple[dict[str, float], dict[str, float], dict[str, float]]]
    models: tuple[str, str]
    names: tuple[set[str], set[str]]
    #: Amplitude, angular frequency, and offset of the slow experiment.
    slow: tuple[float, float, float]
    #: Keys of the model files beside the equations.
    extra: tuple[str, str] = ("", "")
    states: tuple[str, str] = ("'x', 'v'", "'x', 'v'")


def friction(r: random.Random):
    d, v = r.uniform(0.3, 1.2), 0.15
    return {"m": r.uniform(0.7, 1.5)}, {"c": 0.85 * d * v}, {"d": d}


def scale(r: random.Random):
    m, k = r.uniform(0.7, 1.5), r.uniform(1.2, 1.5)
    return {"b": r.uniform(0.3, 0.8)}, {"m": m / k}, {"k": k, "m0": m}


def timing(r: random.Random):
    d = r.uniform(0.1, 0.25)
    return {"m": r.uniform(0.7, 1.5), "b": r.uniform(0.3, 0.8)}, {"T": d}, {"d": d}


def reversal(r: random.Random):
    f = r.uniform(0.15, 0.4)
    return {"m": r.uniform(0.7, 1.5), "b": r.uniform(0.5, 1.0)}, {"F": f}, {"z": f}


def spring(r: random.Random):
    h, x = r.uniform(3.0, 12.0), 0.3
    return {"m": r.uniform(0.7, 1.5), "b": r.uniform(0.5, 1.0)}, {"k": 0.75 * h * x * x}, {"h": h}


PAIRS: dict[str, Pair] = {
    "viscous or quadratic": Pair(
        "u/m", friction, ("(u - c*v)/m", "(u - d*v*abs(v))/m"), ({"viscous_friction"}, {"quadratic_drag"}), (0.06, 0.4, 0.0)),
    "mass or gain": Pair(
        "(u - b*v)/m0", scale, ("(u - b*v)/m", "(k*u - b*v)/m0"), ({"parameter_error"}, {"input_gain"}), (0.2, 0.8, 0.0)),
    "lag or delay": Pair(
        "(u - b*v)/m", timing, ("(w - b*v)/m", "(u - b*v)/m"), ({"actuator_lag"}, {"input_delay"}), (0.4, 0.8, 0.0),
        ("\ndynamics.w = '(u - w)/T'", "\ndelays.u = 'd'"), ("'x', 'v', 'w'", "'x', 'v'")),
    "dry friction or dead zone": Pair(
        "(u - b*v)/m", reversal, ("(u - b*v - F*sign(v))/m", "(max(u - z, 0) + min(u + z, 0) - b*v)/m"),
        ({"coulomb_friction"}, {"dead_zone"}), (0.3, 0.8, 1.0)),
    "spring or hardening spring": Pair(
        "(u - b*v)/m", spring, ("(u - b*v - k*x)/m", "(u - b*v - h*x^3)/m"), ({"linear_stiffness"}, {"cubic_stiffness"}), (0.002, 0.4, 0.0)),
}


def model(path: pathlib.Path, states: str, values: dict[str, float], known: dict[str, float], force: str, extra: str) -> None:
    entry = [f"{k} = {v:.6g}" for k, v in values.items()] + [f"{k} = {{ value = {v:.6g}, fixed = true }}" for k, v in known.items()]
    path.write_text(
        f"states = [{states}]\ninputs = ['u']\nparameters = {{ {', '.join(entry)} }}\noutputs = {{ x = 'x', v = 'v' }}\n"
        f"dynamics.x = 'v'\ndynamics.v = '{force}'{extra}\n")


class Draw:
    def __init__(self, command: pathlib.Path, folder: pathlib.Path, pair: Pair, rng: random.Random, factor: float) -> None:
        self.command, self.folder, self.pair = command, folder, pair
        self.noise = ",".join(f"{k}={factor * v:.6g}" for k, v in NOISE.items())
        common, a, b = pair.parameters(rng)
        self.truth = rng.randrange(2)
        self.seed = rng.randrange(10**6)
        known = {k: v for k, v in b.items() if k == "m0"} | ({"b": common["b"]} if "m0" in b else {})
        free = {k: v for k, v in common.items() if k not in known}
        own = [a, {k: v for k, v in b.items() if k not in known}]
        for k in (0, 1):
            used = known if k == 1 else {n: v for n, v in known.items() if n != "m0"}
            model(self.path(k), pair.states[k], free | own[k], used, pair.models[k], pair.extra[k])
        # The mass is what the model without the cause may have wrong.
        mass = {k: v for k, v in known.items() if k == "m0"}
        model(folder / "base.toml", "'x', 'v'", free | mass, {k: v for k, v in known.items() if k not in mass}, pair.base, "")

    def path(self, k: int) -> pathlib.Path:
        return self.folder / f"{'ab'[k]}.toml"

    def run(self, *args: str) -> tuple[int, dict]:
        done = subprocess.run([str(self.command), *map(str, args), "--json"], capture_output=True, text=True)
        if done.returncode not in (0, 1):
            raise RuntimeError(f"{args}: {done.stderr[-500:]}")
        return done.returncode, json.loads(done.stdout)

    def slow(self) -> pathlib.Path:
        path = self.folder / "slow.csv"
        amplitude, w, offset = self.pair.slow
        with path.open("w", newline="") as f:
            out = csv.writer(f)
            out.writerow(["t", "u"])
            for k in range(round(DURATION / SAMPLE) + 1):
                out.writerow([f"{k * SAMPLE:.6g}", f"{offset + amplitude * math.cos(w * k * SAMPLE):.8g}"])
        return path

    def design(self) -> tuple[pathlib.Path, dict, float]:
        start = time.monotonic()
        _, found = self.run("experiment", self.path(0), "--tell", f"{self.path(0)},{self.path(1)}", "--limits", LIMITS, "--duration",
                            DURATION, "--sample", SAMPLE, "--noise", self.noise, "--out", self.folder / "design")
        return self.folder / "design/inputs.csv", found, time.monotonic() - start

    def judge(self, inputs: pathlib.Path, name: str) -> tuple[bool, bool, str]:
        """Whether the truth is told, whether it is named, and what the diagnoses say."""
        out = self.folder / name
        self.run("simulate", self.path(self.truth), "--inputs", inputs, "--noise", self.noise, "--seed", self.seed, "--out", out)
        verdicts = [self.run("diagnose", self.path(k), out / "measured.csv")[1]["verdict"] for k in (0, 1)]
        told = verdicts[self.truth] == "nothing_found" and verdicts[1 - self.truth] != "nothing_found"
        _, base = self.run("diagnose", self.folder / "base.toml", out / "measured.csv")
        causes = base["causes"]
        right, wrong = self.pair.names[self.truth], self.pair.names[1 - self.truth]
        named = any(c["name"] in right and not wrong & set(c["confusable_with"]) for c in causes)
        says = base["verdict"] + "".join(f" {c['name']}({','.join(c['confusable_with'])})" for c in causes)
        return told, named, f"{verdicts[self.truth]}/{verdicts[1 - self.truth]}; {says}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only")
    parser.add_argument("--noise", type=float, default=1.0, help="factor of the noise")
    parser.add_argument("--command", type=pathlib.Path, default=ROOT / "target/release/bracketry")
    parser.add_argument("--keep", type=pathlib.Path)
    args = parser.parse_args()
    only = args.only.split(",") if args.only else list(PAIRS)
    table: dict[str, Counter] = {}
    for name in only:
        counts = table.setdefault(name, Counter())
        for k in range(args.draws):
            with tempfile.TemporaryDirectory() as scratch:
                folder = (args.keep / f"{name}_{k}".replace(" ", "_")) if args.keep else pathlib.Path(scratch)
                folder.mkdir(parents=True, exist_ok=True)
                draw = Draw(args.command, folder, PAIRS[name], random.Random(f"{args.seed} {name} {k}"), args.noise)
                before = draw.judge(draw.slow(), "slow")
                inputs, found, seconds = draw.design()
                after = draw.judge(inputs, "designed")
                counts.update(draws=1, resolved=found["resolved"], slow_told=before[0], slow_named=before[1], seconds=seconds)
                if found["resolved"]:
                    counts.update(told=after[0], named=after[1])
                print(f"{name} {k}: truth {'ab'[draw.truth]}, {found['deviations']:.0f} (simple {found['deviations_before']:.0f}) standard deviations, "
                      f"{seconds:.0f} s; slow {before[2]} | designed {after[2]}", flush=True)
    print(f"\n{'pair':28} draws  slow: told named | resolved  told named  seconds")
    total: Counter = Counter()
    for name, c in [*table.items(), ("all", total)]:
        if name != "all":
            total.update(c)
        print(f"{name:28} {c['draws']:5}  {c['slow_told']:10} {c['slow_named']:5} | {c['resolved']:8} {c['told']:5} {c['named']:5}  {c['seconds'] / max(c['draws'], 1):7.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
