#!/usr/bin/env python3
"""`bracketry control` on known systems from papers and packages, compared with CasADi and IPOPT.

    python benches/peers/known_systems.py --references [--only NAME ...]      # writes problems/references.json
    python benches/peers/known_systems.py [--bracketry PATH] [--only NAME ...] [--method default,sqp] [--record]

The problems are in problems/smooth and problems/friction beside this file, and those of other packages in models/.

References of a smooth problem: the first plan by IPOPT from the same guess (with its default settings, and the best of its
barrier strategies), the best one from perturbed guesses too, and the closed loop where IPOPT solves every sample. Of a problem
with friction: the plan with sign() smoothed more and more, its inputs on a flow that is smoothed almost not at all.

The comparison runs the command as it is given to users, and judges the cost of the first plan against the best one that IPOPT
finds from the same guess: "right" within 0.1 %, "better", "worse" with exit code 0 (silent), "reported" with exit code 1. For
problems with friction it runs all methods on the exact plant and judges the closed loop of the default method: "right" within
1 % of the best. Needs casadi, numpy, and scipy.
"""
import argparse
import functools
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import tomllib

import casadi as ca
import numpy as np
from scipy.integrate import solve_ivp

from control_problem import Problem
from control_references import closed_loop

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PROBLEMS = HERE / "problems"
REFERENCES = PROBLEMS / "references.json"
RECORD = ROOT / "docs/records/known_systems.md"
MARKS = ["<!-- begin of the measured tables -->\n", "<!-- end of the measured tables -->\n"]
# Problem files in models/ that belong here too.
SHIPPED_SMOOTH = [
    "klatt_engell_do_mpc", "fed_batch_do_mpc", "polymerization_do_mpc", "double_pendulum_cart_do_mpc", "chain_of_five_masses_rest",
    "cart_pole_swing_up_short", "cart_pole_swing_up", "race_car_lap", "quadrotor_flight", "cstr_set_point",
]
SHIPPED_FRICTION = ["spring_mass_friction_target", "cart_pole_friction_swing_up"]
FRICTION_METHODS = ["rti", "sqp", "plan", "stick-slip"]
RIGHT, RIGHT_LOOP = 1e-3, 1e-2
# Beyond the defaults: strategies that end in other optima from the same guess.
STRATEGIES = [{}, {"mu_strategy": "adaptive"}, {"mu_init": 1e-3}]
STARTS = 6
WIDTHS = [0.1, 0.03, 0.01, 0.003, 0.001]
# In place of sign() on the flow on which a plan with friction is judged.
SHARP = 1e-6
TIMEOUT = 300
# Closed loops that IPOPT may take longer for, s, have no reference.
LONGEST_LOOP = 60


def problems(only):
    found = [("smooth", p) for p in sorted((PROBLEMS / "smooth").glob("*.toml"))]
    found += [("smooth", ROOT / "models" / f"{name}.toml") for name in SHIPPED_SMOOTH]
    found += [("friction", p) for p in sorted((PROBLEMS / "friction").glob("*.toml"))]
    found += [("friction", ROOT / "models" / f"{name}.toml") for name in SHIPPED_FRICTION]
    return [(kind, p) for kind, p in found if not only or p.stem in only]


# References


def perturbed(problem, random):
    """A guess with inputs of the guess plus waves of random size, kept in bounds."""
    m, steps = problem.model.m, problem.steps
    low, high = np.array(problem.program.lower[:m]), np.array(problem.program.upper[:m])
    width = np.where(np.isfinite(high - low), high - low, 1 + 2 * np.abs(problem.first_inputs).max(axis=0))
    t = np.linspace(0, 1, steps)[:, None]
    waves = sum(random.normal(size=m) * np.sin(2 * np.pi * (f * t + random.random(m))) for f in (0.5, 1, 2, 3))
    inputs = problem.first_inputs + 0.2 * width * waves
    return problem.guess(np.clip(inputs, low, high))


def lowest(solutions):
    good = [s for s in solutions if s.success]
    return min(good, key=lambda s: s.penalized, default=None)


def smooth_reference(path):
    problem = Problem(path)
    guess = problem.guess()
    tried = [problem.solve(guess, problem.x0, solver=problem.with_options(o)) for o in STRATEGIES]
    same = lowest(tried)
    random = np.random.default_rng(1)
    others = []
    if min(s.seconds for s in tried) < 10:
        others = [problem.solve(perturbed(problem, random), problem.x0) for _ in range(STARTS)]
    best = lowest(tried + others)
    if same is None:
        raise RuntimeError("IPOPT does not converge from the guess")
    result = {"kind": "smooth", "ipopt": tried[0].cost if tried[0].success else None, "same_guess": same.cost, "best": best.cost,
              "penalty": same.penalized - same.cost, "iterations": tried[0].iterations, "seconds": tried[0].seconds,
              "seconds_same_guess": same.seconds,
              "starts_at_best": sum(s.success and s.penalized <= best.penalized + RIGHT * abs(best.penalized) for s in others)}
    if same.seconds * problem.samples < LONGEST_LOOP:
        cost, _, x, failures = closed_loop(problem)
        result |= {"closed_loop": cost, "failed_samples": failures, "x_final": dict(zip(problem.model.states, x))}
    return result


def sharp_cost(problem, solved):
    """Stage and terminal cost of the plan's inputs on a flow with almost no smoothing."""
    u, _ = problem.split(solved.z)
    x, cost = problem.x0.copy(), 0.0
    for k in range(problem.steps):
        t = k * problem.dt
        cost += problem.dt * float(problem.stage(x, u[k], t))
        f = problem.plant.field
        flow = solve_ivp(lambda a, y: np.array(f(y, u[k], a, SHARP)).ravel(), (t, t + problem.dt), x, "Radau", rtol=1e-8, atol=1e-10)
        x = flow.y[:, -1]
    return cost + float(problem.terminal(x, problem.steps * problem.dt)), x


def friction_reference(path):
    problem = Problem(path)
    # Every width needs steps of its own: stability asks for the narrowest.
    problem.widths = WIDTHS
    problem.substeps = problem.stable_substeps()
    problem.transcribe()
    solved = problem.solve(problem.guess(), problem.x0)
    cost, x = sharp_cost(problem, solved)
    return {"kind": "friction", "smoothed": solved.cost, "on_sharp_flow": cost, "success": solved.success,
            "iterations": solved.iterations, "seconds": solved.seconds, "x_final": dict(zip(problem.model.states, x))}


def write_references(only):
    for kind, path in problems(only):
        began = time.time()
        try:
            entry = smooth_reference(path) if kind == "smooth" else friction_reference(path)
        except (RuntimeError, AssertionError, KeyError, SyntaxError, ValueError) as e:
            print(f"{path.stem}: NO REFERENCE: {e}", flush=True)
            continue
        # Read anew: several of these programs may write.
        stored = json.loads(REFERENCES.read_text()) if REFERENCES.exists() else {"problems": {}}
        stored["problems"][path.stem] = entry
        figures = ", ".join(f"{k} {v:.6g}" for k, v in entry.items() if isinstance(v, (int, float)) and not isinstance(v, bool))
        print(f"{path.stem} ({time.time() - began:.1f} s): {figures}", flush=True)
        stored = {"command": "python benches/peers/known_systems.py --references", "casadi": ca.__version__,
                  "problems": dict(sorted(stored["problems"].items()))}
        REFERENCES.write_text(json.dumps(stored, indent=1) + "\n")


# Comparison


def variant(path, method, samples, directory):
    """The problem file with another method or number of samples, beside absolute paths of its models."""
    text = path.read_text()
    text = re.sub(r'^(model|plant) = "(.*)"', lambda m: f'{m[1]} = "{(path.parent / m[2]).resolve()}"', text, flags=re.M)
    text = re.sub(r'^method = .*\n', "", text, flags=re.M)
    text = re.sub(r'^solve = \{(.*)\}', lambda m: "[solve]\n" + "\n".join(p.strip() for p in m[1].split(",")), text, flags=re.M)
    if method != "default":
        head, mark, tail = (text if "[solve]\n" in text else f"{text}\n[solve]\n").partition("[solve]\n")
        text = f'{head}{mark}method = "{method}"\n{tail}'
    if samples is not None:
        # The run's own number of samples, not that of the horizon.
        head, run = text.rsplit("run" if "[run]" not in text else "[run]", 1)
        run = re.sub(r"\bsteps = \d+", f"steps = {samples}", run, count=1)
        text = head + ("run" if "[run]" not in text else "[run]") + run
    file = pathlib.Path(directory) / f"{path.stem}_{method}.toml"
    file.write_text(text)
    return file


def ours(bracketry, file):
    """The report of the command, its exit code and its time."""
    began = time.perf_counter()
    try:
        done = subprocess.run([bracketry, "control", str(file), "--json"], capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return {"code": None, "message": f"no end within {TIMEOUT} s", "seconds": TIMEOUT}
    seconds = time.perf_counter() - began
    result = {"code": done.returncode, "seconds": seconds}
    if done.stdout.strip():
        result |= json.loads(done.stdout)
    else:
        result["message"] = done.stderr.strip()
    return result


def number(result, key):
    value = result.get(key)
    return math.nan if value is None else float(value)


def relative(value, reference):
    return (value - reference) / max(abs(reference), 1e-9)


def notes_of(result):
    if "message" in result:
        return result["message"].splitlines()[0][:120]
    counts = [f"{n} {k}" for k, n in result["status"].items() if isinstance(n, int) and n and k != "solved"]
    return ", ".join(counts)


def verdict_of(gap, right, code):
    """A judgment of a relative gap and an exit code."""
    if math.isnan(gap) or gap > right:
        return "worse" if code == 0 else "reported"
    return ("right" if gap >= -right else "better") + ("" if code == 0 else ", exit code 1")


@functools.cache
def seconds_of_ipopt(path):
    """The times of IPOPT from the guess with its default settings, here and now: of the solution alone, and with all that the
    command does too: reading the file, writing the program, its derivatives."""
    began = time.perf_counter()
    problem = Problem(path)
    alone = problem.solve(problem.guess(), problem.x0, solver=problem.with_options(STRATEGIES[0])).seconds
    return alone, time.perf_counter() - began


def compare_smooth(bracketry, path, method, reference, directory):
    first = ours(bracketry, variant(path, method, 1, directory))
    whole = ours(bracketry, variant(path, method, None, directory))
    problem = tomllib.loads(path.read_text())
    gap = relative(number(whole, "open_loop_cost"), reference["same_guess"])
    loop = relative(number(whole, "closed_loop_cost"), reference["closed_loop"]) if reference.get("closed_loop") else math.nan
    code = whole["code"]
    # A run that is shorter than the horizon misses a target as it has to.
    short = "target" in problem and problem["run"].get("steps", 0) < problem["horizon"]["steps"]
    if short and code == 1 and not any(whole.get("status", {}).get(k) for k in ("infeasible", "fallback")):
        code = 0
    chosen = whole.get("method", problem.get("solve", {}).get("method", "rti") if method == "default" else method)
    # One program a sample predicts from a plan that is not converged: the loop counts, where there is one.
    by_loop = chosen == "rti" and not math.isnan(loop)
    verdict = verdict_of(loop, RIGHT_LOOP, code) if by_loop else verdict_of(gap, RIGHT, code)
    return {"name": path.stem, "verdict": verdict, "ours": number(whole, "open_loop_cost"), "reference": reference["same_guess"],
            "best": reference["best"], "gap": gap, "loop": number(whole, "closed_loop_cost"), "loop_gap": loop, "code": whole["code"],
            "seconds": first["seconds"], "ratios": [first["seconds"] / s for s in seconds_of_ipopt(path)], "method": chosen,
            "notes": notes_of(whole)}


def compare_friction(bracketry, path, reference, directory):
    runs = {m: ours(bracketry, variant(path, m, None, directory)) for m in ["default", *FRICTION_METHODS]}
    costs = {m: number(r, "closed_loop_cost") for m, r in runs.items()}
    finite = [c for c in costs.values() if math.isfinite(c)]
    best = min(finite, default=math.nan)
    gap = relative(costs["default"], best) if finite else math.nan
    chosen = runs["default"]
    verdict = verdict_of(gap, RIGHT_LOOP, chosen["code"])
    return {"name": path.stem, "verdict": verdict, "gap": gap, "costs": costs, "codes": {m: r["code"] for m, r in runs.items()},
            "plan": number(runs["stick-slip"], "open_loop_cost"), "reference": reference.get("on_sharp_flow", math.nan),
            "seconds": {m: r["seconds"] for m, r in runs.items()}, "method": chosen.get("method", "default"), "notes": notes_of(chosen)}


def smooth_table(rows):
    lines = ["| problem | verdict | method | first plan | IPOPT, same guess | gap, % | IPOPT, best of all starts "
             "| loop | loop gap, % | exit | s | time / IPOPT | time / IPOPT with construction | status |",
             "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for r in rows:
        lines.append(f"| {r['name']} | {r['verdict']} | {r['method']} | {r['ours']:.6g} | {r['reference']:.6g} "
                     f"| {100 * r['gap']:.3f} | {r['best']:.6g} | {r['loop']:.6g} | {100 * r['loop_gap']:.2f} | {r['code']} | {r['seconds']:.3f} | {r['ratios'][0]:.2f} "
                     f"| {r['ratios'][1]:.2f} | {r['notes']} |")
    return lines


def friction_table(rows):
    lines = [f"| problem | verdict | chosen | gap, % | {' | '.join(['default', *FRICTION_METHODS])} | exit codes "
             "| first plan, stick-slip | IPOPT's on the exact flow | status |",
             "|---|---|---|---|" + "---|" * (len(FRICTION_METHODS) + 5)]
    for r in rows:
        costs = " | ".join(f"{c:.6g}" for c in r["costs"].values())
        codes = " ".join(str(c) for c in r["codes"].values())
        lines.append(f"| {r['name']} | {r['verdict']} | {r['method']} | {100 * r['gap']:.2f} | {costs} | {codes} | {r['plan']:.6g} | {r['reference']:.6g} | {r['notes']} |")
    return lines


def totals(rows):
    counts = {}
    for r in rows:
        counts[r["verdict"]] = counts.get(r["verdict"], 0) + 1
    return ", ".join(f"{n} {v}" for v, n in sorted(counts.items()))


def mean_ratio(rows, which):
    ratios = [r["ratios"][which] for r in rows]
    mean, longer = math.exp(np.mean(np.log(ratios))), sum(r > 1 for r in ratios)
    return f"{mean:.2f} in the geometric mean, {longer} of {len(rows)} longer, at most {max(ratios):.2f} times"


def compare(arguments):
    references = json.loads(REFERENCES.read_text())["problems"]
    lines = []
    with tempfile.TemporaryDirectory() as directory:
        for method in arguments.method.split(","):
            rows = []
            for kind, path in problems(arguments.only):
                if kind == "smooth" and path.stem in references and not arguments.friction:
                    rows.append(compare_smooth(arguments.bracketry, path, method, references[path.stem], directory))
                    print(smooth_table(rows[-1:])[-1], flush=True)
            if rows:
                lines += ["", f"## Smooth problems, method {method}", "", *smooth_table(rows), "",
                          f"{len(rows)} problems: {totals(rows)}. Time of the first plan, including the start of the program, relative "
                          f"to IPOPT's solution alone: {mean_ratio(rows, 0)}; with the construction of IPOPT's problem: {mean_ratio(rows, 1)}."]
                print(lines[-1], flush=True)
        rows = []
        for kind, path in problems(arguments.only):
            if kind == "friction" and not arguments.smooth:
                rows.append(compare_friction(arguments.bracketry, path, references.get(path.stem, {}), directory))
                print(friction_table(rows[-1:])[-1], flush=True)
        if rows:
            lines += ["", "## Problems with dry friction", "", *friction_table(rows), "", f"{len(rows)} problems: {totals(rows)}."]
            print(lines[-1], flush=True)
    if arguments.record:
        before, rest = RECORD.read_text().split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        RECORD.write_text(before + MARKS[0] + "\n".join(lines) + "\n\n" + MARKS[1] + after)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--references", action="store_true", help="solve with IPOPT and store")
    parser.add_argument("--only", nargs="*", default=[], metavar="NAME")
    parser.add_argument("--bracketry", default=str(ROOT / "target/release/bracketry"), metavar="PATH")
    parser.add_argument("--method", default="default", metavar="M,M", help="methods for the smooth problems")
    parser.add_argument("--smooth", action="store_true", help="smooth problems alone")
    parser.add_argument("--friction", action="store_true", help="problems with friction alone")
    parser.add_argument("--record", action="store_true", help="write the tables to docs/records/known_systems.md")
    given = parser.parse_args()
    sys.exit(write_references(given.only) if given.references else compare(given))
