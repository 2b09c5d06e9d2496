#!/usr/bin/env python3
"""Closed-loop costs of the problem files in models/, by CasADi and IPOPT in place of the library.

    python benches/peers/control_references.py [--fine] [PROBLEM.toml ...]

reads the same TOML files, writes the same discretized problem (multiple shooting, Runge-Kutta of order 4, inputs constant
over an interval, soft bounds with slacks), solves it to convergence at every sample and applies the first input to the plant.
A smooth plant is integrated by the same Runge-Kutta method with `plant_substeps`, one with sign() by small steps with sliding
modes (one switching function at most). Without names it takes all files that tests quote. Needs casadi and numpy.
"""
import argparse
import ast
import pathlib
import re
import time
import tomllib

import casadi as ca
import numpy as np

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"
QUOTED = [
    "cart_pole_swing_up", "double_integrator_rest", "van_der_pol_rest", "cstr_set_point", "klatt_engell_set_point",
    "fed_batch_production", "oscillating_masses_rest", "chain_of_masses_rest", "quadrotor_flight",
    "cart_pole_friction_swing_up", "spring_mass_friction_target",
]
FUNCTIONS = {
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin, "acos": ca.acos, "atan": ca.atan, "atan2": ca.atan2,
    "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh, "exp": ca.exp, "log": ca.log, "sqrt": ca.sqrt, "abs": ca.fabs,
    "min": ca.fmin, "max": ca.fmax, "pi": np.pi,
}


def evaluate(text, names):
    """The value of an expression of a TOML file over the names."""
    if not isinstance(text, str):
        return text
    tree = ast.parse(re.sub(r"\s+", " ", text).strip().replace("^", "**"), mode="eval")
    return eval(compile(tree, text, "eval"), {"__builtins__": {}}, {**FUNCTIONS, **names})


class Model:
    """Dynamics as CasADi functions: `field(x, u, t, w)` with sign(s) = tanh(s/w), and the parts of a sliding mode."""

    def __init__(self, path):
        data = tomllib.loads(path.read_text())
        self.states, self.inputs = data["states"], data.get("inputs", [])
        self.parameters = {k: v["value"] if isinstance(v, dict) else v for k, v in data.get("parameters", {}).items()}
        self.ranges = data.get("ranges", {})
        self.n, self.m = len(self.states), len(self.inputs)
        x, u, t, w = ca.SX.sym("x", self.n), ca.SX.sym("u", self.m), ca.SX.sym("t"), ca.SX.sym("w")
        names = {**self.parameters, "t": t}
        names |= {s: x[i] for i, s in enumerate(self.states)} | {s: u[i] for i, s in enumerate(self.inputs)}
        surfaces = []

        def right_hand_side(sign):
            local = {**names, "sign": sign}
            for name, text in data.get("definitions", {}).items():
                local[name] = evaluate(text, local)
            return ca.vertcat(*[evaluate(data["dynamics"][s], local) for s in self.states])

        self.field = ca.Function("f", [x, u, t, w], [right_hand_side(lambda s: ca.tanh(s / w))])
        mode = ca.SX.sym("s")

        def held(surface):
            surfaces.append(surface)
            return mode

        f = right_hand_side(held)
        self.switched = bool(surfaces)
        if self.switched:
            if any(not ca.is_equal(s, surfaces[0], 5) for s in surfaces):
                raise SystemExit("more than one switching function: not covered here")
            rate = ca.jtimes(surfaces[0], x, f)
            # The rate is linear in the mode: its zero is the equivalent control of Filippov.
            slope = ca.jacobian(rate, mode)
            self.mode_field = ca.Function("f", [x, u, t, mode], [f])
            self.surface = ca.Function("s", [x], [surfaces[0]])
            self.equivalent = ca.Function("e", [x, u, t], [-ca.substitute(rate, mode, 0) / slope])

    def constant(self, value):
        return float(evaluate(value, self.parameters))


def runge_kutta(f, x, u, t, dt, steps):
    """The classical method; `f` takes (x, u, t)."""
    h = dt / steps
    for i in range(steps):
        a = t + i * h
        k1 = f(x, u, a)
        k2 = f(x + h / 2 * k1, u, a + h / 2)
        k3 = f(x + h / 2 * k2, u, a + h / 2)
        k4 = f(x + h * k3, u, a + h)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


def switched_step(model, x, u, t, dt, steps):
    """One switching function: a mode is held until its surface is met, then it slides or crosses."""
    h = dt / steps
    for i in range(steps):
        a = t + i * h
        left = h
        while left > 1e-13:
            s = float(model.surface(x))
            e = float(model.equivalent(x, u, a))
            sliding = abs(s) < 1e-12 and abs(e) <= 1
            # Off the surface the side decides; on it, what the forces exceed.
            mode = float(np.sign(s if abs(s) >= 1e-12 else e))

            def f(y, v, b):
                held = np.clip(float(model.equivalent(y, v, b)), -1, 1) if sliding else mode
                return np.array(model.mode_field(y, v, b, held)).ravel()

            y = runge_kutta(f, x, u, a, left, 1)
            after = float(model.surface(y))
            step = left
            if not sliding and after * mode < 0 and abs(s) >= 1e-12:
                low, high = 0.0, left
                for _ in range(60):
                    middle = (low + high) / 2
                    y = runge_kutta(f, x, u, a, middle, 1)
                    low, high = (middle, high) if float(model.surface(y)) * mode > 0 else (low, middle)
                step = high
                y = runge_kutta(f, x, u, a, step, 1)
            x, a, left = y, a + step, left - step
    return x


def solve(path, verbose=True, smoothing_last=None):
    """Runs the closed loop of a problem file; the cost, the open-loop cost and the last state."""
    problem = tomllib.loads(path.read_text())
    model = Model(path.parent / problem["model"])
    plant = Model(path.parent / problem["plant"]) if "plant" in problem else model
    n, m = model.n, model.m
    horizon, run = problem["horizon"], problem["run"]
    steps, dt, substeps = horizon["steps"], model.constant(horizon["dt"]), horizon.get("substeps", 1)
    samples = run.get("steps", steps)
    solver = problem.get("solve", {})
    references = problem.get("references", {})
    x0 = np.array([model.constant(run.get("x0", {}).get(s, 0)) for s in model.states])

    xs, us, ts = ca.SX.sym("x", n), ca.SX.sym("u", m), ca.SX.sym("t")
    names = {**model.parameters, "t": ts}
    names |= {s: xs[i] for i, s in enumerate(model.states)} | {s: us[i] for i, s in enumerate(model.inputs)}
    names |= {k: evaluate(v, {**model.parameters, "t": ts}) for k, v in references.items()}
    costs = problem.get("cost", {})
    stage = ca.Function("l", [xs, us, ts], [evaluate(costs.get("stage", 0.0), names)])
    terminal = ca.Function("e", [xs, ts], [evaluate(costs.get("terminal", 0.0), names)])

    widths = solver.get("smoothing", 0.01)
    widths = widths if isinstance(widths, list) else [widths]
    if not model.switched:
        widths = [1.0]
    rate = 0.0
    if model.switched:
        u0, x0s = np.zeros(m), np.zeros(n)
        mode = ca.SX.sym("s")
        surface_rate = ca.jtimes(model.surface(xs), xs, model.mode_field(xs, us, ts, mode))
        rate = abs(float(ca.Function("r", [xs, us, ts], [ca.jacobian(surface_rate, mode)])(x0, u0, 0)))

    t0, width, start = ca.MX.sym("t0"), ca.MX.sym("w"), ca.MX.sym("x0", n)
    variables, lower, upper, constraints, g_low, g_up = [], [], [], [], [], []
    objective = 0
    bounds = dict(problem.get("constraints", {}))
    for name, r in model.ranges.items():
        bounds.setdefault(name, r)

    def bound(name, side, default):
        return model.constant(bounds[name][side]) if name in bounds and side in bounds[name] else default

    def variable(name, size, low, high):
        v = ca.MX.sym(name, size)
        variables.append(v)
        lower.extend(low)
        upper.extend(high)
        return v

    inputs = [variable(f"u{k}", m, [bound(s, "min", -np.inf) for s in model.inputs],
                       [bound(s, "max", np.inf) for s in model.inputs]) for k in range(steps)]
    states = [variable(f"x{k}", n, [-np.inf] * n, [np.inf] * n) for k in range(steps + 1)]
    constraints.append(states[0] - start)
    g_low += [0] * n
    g_up += [0] * n
    # As many Runge-Kutta steps as the smoothed friction needs for stability, unless the file says how many.
    finest = substeps if "substeps" in horizon else max(1, int(np.ceil(dt * rate / widths[-1] / 2)))
    for k in range(steps):
        t = t0 + k * dt
        end = runge_kutta(lambda x, u, a: model.field(x, u, a, width), states[k], inputs[k], t, dt, finest)
        constraints.append(states[k + 1] - end)
        g_low += [0] * n
        g_up += [0] * n
        objective += dt * stage(states[k], inputs[k], t)
        for i, name in enumerate(model.states):
            if name not in bounds:
                continue
            low, high = bound(name, "min", -np.inf), bound(name, "max", np.inf)
            if bounds[name].get("hard"):
                constraints.append(states[k + 1][i])
                g_low.append(low)
                g_up.append(high)
                continue
            linear, quadratic = bounds[name].get("soft", [1e3, 1e3])
            slack = variable(f"s{k}_{name}", 1, [0.0], [np.inf])
            objective += dt * (linear * slack + quadratic * slack**2)
            for value, low_, high_ in ((states[k + 1][i] + slack, low, np.inf), (states[k + 1][i] - slack, -np.inf, high)):
                constraints.append(value)
                g_low.append(low_)
                g_up.append(high_)
    objective += terminal(states[steps], t0 + steps * dt)
    nlp = {"x": ca.vertcat(*variables), "p": ca.vertcat(start, t0, width), "f": objective, "g": ca.vertcat(*constraints)}
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9, "max_iter": 2000}}
    nlp_solver = ca.nlpsol("solver", "ipopt", nlp, options)

    guess = problem.get("guess", {})
    first_inputs = [[float(evaluate(guess.get(s, 0), {**model.parameters, "t": (k + 0.5) * dt})) for s in model.inputs]
                    for k in range(steps)]
    z = np.concatenate([np.array(first_inputs).ravel(), np.tile(x0, steps + 1),
                        np.zeros(nlp["x"].numel() - steps * m - (steps + 1) * n)])

    def shifted(z):
        u, x, rest = np.split(z, [steps * m, steps * m + (steps + 1) * n])
        u, x = u.reshape(steps, m), x.reshape(steps + 1, n)
        u, x = np.vstack([u[1:], u[-1:]]), np.vstack([x[1:], x[-1:]])
        last = runge_kutta(lambda a, b, c: np.array(model.field(a, b, c, widths[-1])).ravel(), x[-2], u[-1], 0.0, dt, finest)
        x[-1] = last
        return np.concatenate([u.ravel(), x.ravel(), rest])

    def to_convergence(z, x, t, all_widths):
        good = True
        for w in widths if all_widths else widths[-1:]:
            result = nlp_solver(x0=z, p=np.concatenate([x, [t, w]]), lbx=lower, ubx=upper, lbg=g_low, ubg=g_up)
            z = np.array(result["x"]).ravel()
            good = nlp_solver.stats()["success"]
        return z, float(result["f"]), good

    x, cost, opening, failures, began = x0.copy(), 0.0, None, 0, time.time()
    for k in range(samples):
        z, value, good = to_convergence(z, x, k * dt, True)
        failures += not good
        opening = value if opening is None else opening
        u = z[:m]
        cost += dt * float(stage(x, u, k * dt))
        if plant.switched:
            x = switched_step(plant, x, u, k * dt, dt, 40)
        else:
            x = np.array(runge_kutta(lambda a, b, c: plant.field(a, b, c, 1.0), x, u, k * dt, dt,
                                     run.get("plant_substeps", 1))).ravel()
        z = shifted(z)
    if verbose:
        final = ", ".join(f"{s} = {v:.6g}" for s, v in zip(model.states, x))
        print(f"{path.stem}: closed loop {cost:.6f}, first optimum with penalties {opening:.6f}, {failures} of {samples} samples "
              f"not converged, {(time.time() - began) / samples * 1e3:.1f} ms a sample\n    {final}", flush=True)
    return cost, opening, x


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problems", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    for path in arguments.problems or [MODELS / f"{name}.toml" for name in QUOTED]:
        solve(path)
