#!/usr/bin/env python3
"""How many random starts of swing-ups and flips are solved, by the library and by IPOPT from the same guess.

    python benches/peers/random_starts.py [--starts 10] [--seed 1] [--program PATH] [--only NAME ...]

draws start states of ten problems, states the same discretized problem (multiple shooting, Runge-Kutta of order 4, inputs constant
over an interval) to `first_plan`, an example of bracketry-mpc, and to CasADi with IPOPT, and compares costs: a start counts as found
where the cost is within 1 % of the better of the two. Both start from the same guess: the initial state at every grid point and
constant inputs. Build the example with `cargo build --release -p bracketry-mpc --example first_plan --features measure`. Needs casadi and numpy.
"""
import argparse
import pathlib
import re
import subprocess
import tempfile
import time

import casadi as ca
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
FUNCTIONS = {"sin": ca.sin, "cos": ca.cos, "sqrt": ca.sqrt, "pi": np.pi}
# Within this of the better cost, a start counts as found.
FOUND = 0.01

CART_POLE = {
    "states": ["p", "th", "v", "w"], "inputs": {"u": (-20, 20, 0)},
    "definitions": {"D": "1.1 - 0.1*cos(th)^2"},
    "dynamics": ["v", "w", "(-0.08*sin(th)*w^2 + 0.981*cos(th)*sin(th) + u)/D",
                 "(-0.08*cos(th)*sin(th)*w^2 + u*cos(th) + 10.791*sin(th))/(0.8*D)"],
    "stage": "p^2 + 10*th^2 + 0.1*(v^2 + w^2) + 0.01*u^2", "terminal": "10*p^2 + 100*th^2 + 10*(v^2 + w^2)",
    "low": [-1, 2.6, -1, -1], "high": [1, 3.7, 1, 1],
}
PENDULUM = {
    "states": ["th", "w"], "inputs": {"u": (-3, 3, 0)}, "definitions": {}, "dynamics": ["w", "9.81*sin(th) - 0.1*w + u"],
    "stage": "10*th^2 + 0.1*w^2 + 0.01*u^2", "terminal": "100*th^2 + 10*w^2", "low": [2.6, -1], "high": [3.7, 1], "horizon": (80, 0.05),
}
PLANAR_QUADROTOR = {
    "states": ["x", "z", "th", "vx", "vz", "w"], "inputs": {"f1": (0, 7, 2.4525), "f2": (0, 7, 2.4525)}, "definitions": {},
    "dynamics": ["vx", "vz", "w", "-2*(f1 + f2)*sin(th)", "2*(f1 + f2)*cos(th) - 9.81", "37.5*(f1 - f2)"],
    "stage": "x^2 + z^2 + th^2 + 0.1*(vx^2 + vz^2 + w^2) + 0.1*((f1 - 2.4525)^2 + (f2 - 2.4525)^2)",
    "terminal": "10*(x^2 + z^2 + th^2) + vx^2 + vz^2 + w^2",
    "low": [-1, -1, 0.9, -1, -1, -1], "high": [1, 1, 3.14, 1, 1, 1], "horizon": (40, 0.05),
}
PVTOL = {
    "states": ["x", "y", "th", "vx", "vy", "w"], "inputs": {"f": (0, 25, 9.81), "m": (-5, 5, 0)}, "definitions": {},
    "dynamics": ["vx", "vy", "w", "-f*sin(th) + 0.3*m*cos(th)", "f*cos(th) + 0.3*m*sin(th) - 9.81", "m"],
    "stage": "x^2 + y^2 + th^2 + 0.1*(vx^2 + vy^2 + w^2) + 0.01*((f - 9.81)^2 + m^2)",
    "terminal": "10*(x^2 + y^2 + th^2) + 5*(vx^2 + vy^2 + w^2)",
    "low": [-2, -2, 0.9, -1, -1, -1], "high": [2, 2, 3.14, 1, 1, 1], "horizon": (60, 0.05),
}
ACROBOT = {
    "states": ["q1", "q2", "d1", "d2"], "inputs": {"u": (-15, 15, 0)},
    "definitions": {
        "m11": "1.733 + cos(q2)", "m12": "0.333 + 0.5*cos(q2)", "m22": "0.333",
        "h1": "0.5*sin(q2)*(2*d1*d2 + d2^2) + 9.81*(1.5*sin(q1) + 0.5*sin(q1 + q2)) - 0.1*d1",
        "h2": "u - 0.5*sin(q2)*d1^2 + 4.905*sin(q1 + q2) - 0.1*d2", "D": "m11*m22 - m12^2",
    },
    "dynamics": ["d1", "d2", "(m22*h1 - m12*h2)/D", "(m11*h2 - m12*h1)/D"],
    "stage": "10*(q1^2 + q2^2) + 0.1*(d1^2 + d2^2) + 0.01*u^2", "terminal": "100*(q1^2 + q2^2) + 10*(d1^2 + d2^2)",
    "low": [2.8, -0.4, -0.5, -0.5], "high": [3.5, 0.4, 0.5, 0.5], "horizon": (60, 0.05),
}
WHEEL = {
    "states": ["th", "w", "r"], "inputs": {"u": (-2, 2, 0)}, "definitions": {}, "dynamics": ["w", "20*sin(th) - 4*u", "20*u"],
    "stage": "10*th^2 + 0.1*w^2 + 1e-4*r^2 + 0.1*u^2", "terminal": "100*th^2 + 10*w^2 + 1e-3*r^2",
    "low": [2.6, -1, -5], "high": [3.7, 1, 5], "horizon": (80, 0.03),
}
RIGID_BODY = {
    "states": ["a", "b", "c", "p", "q", "r"], "inputs": {"u": (-2, 2, 0), "v": (-2, 2, 0), "w": (-2, 2, 0)},
    "definitions": {"n": "a^2 + b^2 + c^2", "s": "a*p + b*q + c*r"},
    # Modified Rodrigues parameters.
    "dynamics": [f"0.25*((1 - n)*{x} + 2*({y}) + 2*s*{z})" for x, y, z in
                 [("p", "b*r - c*q", "a"), ("q", "c*p - a*r", "b"), ("r", "a*q - b*p", "c")]]
                + ["u + 0.5*q*r", "v - 0.8*p*r", "w + 0.3*p*q"],
    "stage": "10*(a^2 + b^2 + c^2) + 0.1*(p^2 + q^2 + r^2) + 0.1*(u^2 + v^2 + w^2)",
    "terminal": "100*(a^2 + b^2 + c^2) + 10*(p^2 + q^2 + r^2)",
    "low": [-1] * 3 + [-2] * 3, "high": [1] * 3 + [2] * 3, "horizon": (50, 0.06),
}
CASES = {
    "cart-pole": CART_POLE | {"horizon": (60, 0.04)},
    "cart-pole, long": CART_POLE | {"horizon": (200, 0.02)},
    "cart-pole, weak": CART_POLE | {"horizon": (100, 0.04), "inputs": {"u": (-8, 8, 0)}},
    "pendulum": PENDULUM,
    "pendulum, weak": PENDULUM | {"horizon": (120, 0.05), "inputs": {"u": (-1.5, 1.5, 0)}},
    "planar quadrotor": PLANAR_QUADROTOR,
    "aircraft": PVTOL,
    "acrobot": ACROBOT,
    "reaction wheel": WHEEL,
    "satellite": RIGID_BODY,
}


def files(case, x0, folder):
    """Model and problem as files of the library; the path of the problem."""
    quoted = ", ".join(f'"{s}"' for s in case["states"])
    inputs = ", ".join(f'"{s}"' for s in case["inputs"])
    model = [f"states = [{quoted}]", f"inputs = [{inputs}]", "[definitions]"]
    model += [f'{k} = "{v}"' for k, v in case["definitions"].items()] + ["[dynamics]"]
    model += [f'{s} = "{f}"' for s, f in zip(case["states"], case["dynamics"])]
    (folder / "model.toml").write_text("\n".join(model))
    steps, dt = case["horizon"]
    problem = ['model = "model.toml"', f"horizon = {{ steps = {steps}, dt = {dt}, substeps = 1 }}", "[cost]",
               f'stage = "{case["stage"]}"', f'terminal = "{case["terminal"]}"', "[constraints]"]
    problem += [f"{s} = {{ min = {low}, max = {high} }}" for s, (low, high, _) in case["inputs"].items()] + ["[guess]"]
    problem += [f'{s} = "{start}"' for s, (_, _, start) in case["inputs"].items()] + ["[solve]", 'method = "sqp"', "[run]", "steps = 1"]
    problem += ["[run.x0]"] + [f"{s} = {v!r}" for s, v in zip(case["states"], map(float, x0))]
    path = folder / "problem.toml"
    path.write_text("\n".join(problem))
    return path


def library(program, path):
    """Cost (infinite where the solver did not converge) and time in s."""
    line = subprocess.run([program, str(path)], capture_output=True, text=True, timeout=120, check=True).stdout
    cost, milliseconds, status = re.match(r"\S+\s+(\S+) programs\s+\d+\s+(\S+) ms .* miss \S+ (.*)", line).groups()
    return float(cost) if status == "converged" else np.inf, float(milliseconds) / 1e3


def expression(text, names):
    return eval(text.replace("^", "**"), {"__builtins__": {}}, FUNCTIONS | names)


class Reference:
    """The same problem in CasADi; made once for all starts."""

    def __init__(self, case):
        n, m, (steps, dt) = len(case["states"]), len(case["inputs"]), case["horizon"]
        x, u = ca.SX.sym("x", n), ca.SX.sym("u", m)
        names = {s: x[i] for i, s in enumerate(case["states"])} | {s: u[j] for j, s in enumerate(case["inputs"])}
        for name, text in case["definitions"].items():
            names[name] = expression(text, names)
        f = ca.Function("f", [x, u], [ca.vertcat(*[expression(text, names) for text in case["dynamics"]])])
        k1 = f(x, u)
        k2 = f(x + dt / 2 * k1, u)
        k3 = f(x + dt / 2 * k2, u)
        k4 = f(x + dt * k3, u)
        end = ca.Function("F", [x, u], [x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
        stage = ca.Function("l", [x, u], [dt * expression(case["stage"], names)])
        terminal = ca.Function("e", [x], [expression(case["terminal"], names)])
        states, inputs, start = ca.MX.sym("X", n, steps + 1), ca.MX.sym("U", m, steps), ca.MX.sym("x0", n)
        rows = [states[:, 0] - start] + [states[:, k + 1] - end(states[:, k], inputs[:, k]) for k in range(steps)]
        cost = terminal(states[:, steps]) + sum(stage(states[:, k], inputs[:, k]) for k in range(steps))
        nlp = {"x": ca.vertcat(ca.vec(states), ca.vec(inputs)), "p": start, "f": cost, "g": ca.vertcat(*rows)}
        options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-8, "max_iter": 1000}}
        self.solver = ca.nlpsol("solver", "ipopt", nlp, options)
        low, high, self.guess = zip(*case["inputs"].values())
        free = [np.inf] * (n * (steps + 1))
        self.low, self.high = [-v for v in free] + list(low) * steps, free + list(high) * steps
        self.steps = steps

    def solve(self, x0):
        guess = np.concatenate([np.tile(x0, self.steps + 1), np.tile(self.guess, self.steps)])
        began = time.perf_counter()
        result = self.solver(x0=guess, p=x0, lbx=self.low, ubx=self.high, lbg=0, ubg=0)
        seconds = time.perf_counter() - began
        return float(result["f"]) if self.solver.stats()["success"] else np.inf, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default=str(ROOT / "target/release/examples/first_plan"))
    parser.add_argument("--only", nargs="*", default=list(CASES))
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    totals = np.zeros(2, dtype=int)
    print(f"{'':20}{'library':>9}{'IPOPT':>7}   better: {'library':>7}{'IPOPT':>7}   median ms: {'library':>8}{'IPOPT':>8}")
    for name, case in CASES.items():
        starts = random.uniform(case["low"], case["high"], (arguments.starts, len(case["states"])))
        if name not in arguments.only:
            continue
        reference, found, better, times = Reference(case), np.zeros(2, dtype=int), np.zeros(2, dtype=int), []
        for x0 in starts:
            with tempfile.TemporaryDirectory() as folder:
                ours, seconds = library(arguments.program, files(case, x0, pathlib.Path(folder)))
            theirs, other = reference.solve(x0)
            times.append((seconds, other))
            limit = min(ours, theirs) * (1 + FOUND)
            found += [ours <= limit, theirs <= limit]
            better += [ours * (1 + FOUND) < theirs, theirs * (1 + FOUND) < ours]
        totals += found
        a, b = 1e3 * np.median(times, axis=0)
        print(f"{name:20}{found[0]:9}{found[1]:7}           {better[0]:7}{better[1]:7}              {a:8.1f}{b:8.1f}", flush=True)
    print(f"{'sum':20}{totals[0]:9}{totals[1]:7}")


if __name__ == "__main__":
    main()
