#!/usr/bin/env python3
"""Runs the main job as the README says, and checks what it promises from its JSON.

usage: main_job.py [--seed N] [--command COMMAND]

Exit code 1 where the target is missed, a cause is named that the simulated plant does not have, the gain is too small, or the
effort exceeds its budget. The counts of effort hardly differ from machine to machine; the times do, and are only shown.
"""

import argparse
import json
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SECONDS = 900
# Errors at the end, and the longest move: mm, mm, degrees, degrees per second, s.
LIMITS = {"x_m": 2e-3, "y_m": 2e-3, "phi_deg": 2.0, "spin_deg_s": 2.0}
LONGEST_MOVE = 1.5
LEAST_GAIN = 5.0
# How far the size of a cause, its first parameter, may be from that in the plant, relative to it. Further parameters are shapes.
FARTHEST = 0.25
# Counts of the chapters with the default seed, a tenth above what they were when the budget was set.
BUDGET = json.loads((ROOT / ".ci/main_job_budget.json").read_text())


def problems(result: dict, budget: dict) -> list[str]:
    """What a result of the main job lacks."""
    found = []
    published, extended = result["true_plant"]["published_model"], result["true_plant"]["extended_model"]
    if published["arrival"]["settled_s"] is not None:
        found.append("the published model reaches the target on the plant: there is nothing to tell")
    if extended is None:
        return found + ["the diagnosis names no cause"]
    arrival = extended["arrival"]
    for name, limit in LIMITS.items():
        if abs(arrival[name]) > limit:
            found.append(f"extended model: {name} = {arrival[name]:.4g}, beyond {limit}")
    settled = arrival["settled_s"]
    if settled is None or settled > LONGEST_MOVE:
        found.append(f"extended model: at rest within the tolerances from {settled} s on, not within {LONGEST_MOVE} s")
    if not result["succeeded"]:
        found.append("the story does not end as it should")
    for cause in result["causes"]:
        if cause["in_plant"] is False:
            parameters = ", ".join(p["name"] for p in cause["parameters"])
            found.append(f"the plant lacks {cause['name']} in {cause['equation']} ({parameters})")
        for p in cause["parameters"][:1] if cause["in_plant"] else []:
            true = p["in_plant"]
            if true is not None and not abs(p["value"] - true) <= FARTHEST * abs(true):
                found.append(f"{p['name']} = {p['value']:.4g}, in the plant {true:.4g}")
    if not result["gain"]:
        found.append("no gain was measured")
    for gain in result["gain"]:
        if not gain["times_smaller"] >= LEAST_GAIN:
            found.append(f"gain {gain['times_smaller']:.1f} at {gain['horizon_s']} s, less than {LEAST_GAIN}")
    counts = {"diagnosis": result["diagnosis"].get("effort", {}), "programs": result["effort"]["programs"]}
    for part, limits in budget.items():
        for name, most in limits.items():
            counted = counts[part].get(name)
            if counted is None or counted > most:
                found.append(f"effort: {counted} {name} ({part}), budget {most}")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int)
    parser.add_argument("--command", help="an executable that is built already, instead of cargo run --release")
    arguments = parser.parse_args()
    command = [arguments.command] if arguments.command else ["cargo", "run", "--release", "--locked", "--quiet", "--"]
    out = pathlib.Path(tempfile.mkdtemp()) / "demo"
    command += ["demo", "--json", "--out", str(out)]
    if arguments.seed is not None:
        command += ["--seed", str(arguments.seed)]
    try:
        run = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, timeout=SECONDS)
        if run.returncode == 2 or not run.stdout:
            print(f"main job: exit code {run.returncode}", file=sys.stderr)
            return 1
        missing = [name for name in ["report.html", "report.txt", "main.json", "extended.toml"] if not (out / name).exists()]
        found = problems(json.loads(run.stdout), BUDGET if arguments.seed is None else {})
        found += [f"{name} was not written" for name in missing]
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"main job: {usage.ru_utime + usage.ru_stime:.0f} s of processor time, {usage.ru_maxrss / 1024:.0f} MB at most")
        for line in found:
            print(f"main job: {line}", file=sys.stderr)
        return 1 if found else 0
    finally:
        shutil.rmtree(out.parent, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
