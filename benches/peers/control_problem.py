"""A problem file of `bracketry control` as a nonlinear program in CasADi, solved by IPOPT in place of the library.

The program is the one that the library states: multiple shooting over the intervals of the file, the classical Runge-Kutta
method with its substeps or collocation (Gauss-Legendre, Radau IIA) with its stages, inputs constant over an interval, hard
constraints as they are, soft ones and targets with slacks. `sign(s)` becomes tanh(s/width), a parameter of the program.
Not covered: move blocks, terminal = "riccati", estimation, delays, derivatives of inputs.
"""
import ast
import re
import time
import tomllib

import casadi as ca
import numpy as np

FUNCTIONS = {
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin, "acos": ca.acos, "atan": ca.atan, "atan2": ca.atan2,
    "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh, "exp": ca.exp, "log": ca.log, "sqrt": ca.sqrt, "abs": ca.fabs,
    "min": ca.fmin, "max": ca.fmax, "pi": np.pi,
}
# What IPOPT is told beyond its defaults.
IPOPT = {"print_level": 0, "sb": "yes", "tol": 1e-9, "max_iter": 3000, "max_wall_time": 60.0}
# Weights of soft bounds for which a file gives none; the library derives them from trial runs.
SOFT = [1e3, 1e3]


def evaluate(text, names):
    """The value of an expression of a TOML file over the names."""
    if not isinstance(text, str):
        return text
    tree = ast.parse(re.sub(r"\s+", " ", text).strip().replace("^", "**"), mode="eval")
    return eval(compile(tree, text, "eval"), {"__builtins__": {}}, {**FUNCTIONS, **names})


class Model:
    """Dynamics as CasADi functions: `field(x, u, t, w)` with sign(s) = tanh(s/w), and the parts of a sliding mode."""

    def __init__(self, path, values=None):
        data = tomllib.loads(path.read_text())
        self.states, self.inputs = data["states"], data.get("inputs", [])
        self.parameters = {k: v["value"] if isinstance(v, dict) else v for k, v in data.get("parameters", {}).items()}
        self.parameters = {k: float(evaluate(v, self.parameters)) for k, v in self.parameters.items()}
        self.parameters |= {k: float(evaluate(v, self.parameters)) for k, v in (values or {}).items()}
        self.ranges = data.get("ranges", {})
        self.n, self.m = len(self.states), len(self.inputs)
        x, u, t, w = ca.SX.sym("x", self.n), ca.SX.sym("u", self.m), ca.SX.sym("t"), ca.SX.sym("w")
        names = {**self.parameters, "t": t}
        names |= {s: x[i] for i, s in enumerate(self.states)} | {s: u[i] for i, s in enumerate(self.inputs)}
        # Parameters, states, inputs and definitions: what costs and constraints may name too.
        self.definitions = data.get("definitions", {})
        self.outputs = data.get("outputs", {})

        def right_hand_side(sign, unit):
            local = {**names, "sign": sign, "unit": unit}
            for name, text in self.definitions.items():
                local[name] = evaluate(text, local)
            return ca.vertcat(*[evaluate(data["dynamics"][s], local) for s in self.states])

        def smooth_unit(*v):
            return v[0] / ca.sqrt(sum(c * c for c in v) + w * w)

        self.field = ca.Function("f", [x, u, t, w], [right_hand_side(lambda s: ca.tanh(s / w), smooth_unit)])
        surfaces, modes = [], []

        def held(surface):
            for s, mode in zip(surfaces, modes):
                if ca.is_equal(s, surface, 5):
                    return mode
            surfaces.append(surface)
            modes.append(ca.SX.sym(f"s{len(modes)}"))
            return modes[-1]

        f = right_hand_side(held, lambda *v: held(v[0]))
        self.surfaces = len(surfaces)
        self.switched = bool(surfaces)
        self.steepest = 0.0
        if self.switched:
            rate = ca.vertcat(*[ca.jtimes(s, x, f) for s in surfaces])
            mode = ca.vertcat(*modes)
            # The rate is linear in the modes; its diagonal is how fast each surface is left or met.
            slope = ca.jacobian(rate, mode)
            self.slopes = ca.Function("r", [x, u, t], [ca.diag(ca.substitute(slope, mode, ca.DM.zeros(mode.shape)))])
            if self.surfaces == 1:
                self.mode_field = ca.Function("f", [x, u, t, mode], [f])
                self.surface = ca.Function("s", [x], [surfaces[0]])
                # Its zero is the equivalent control of Filippov.
                self.equivalent = ca.Function("e", [x, u, t], [-ca.substitute(rate, mode, 0) / slope])

    def constant(self, value):
        return float(evaluate(value, self.parameters))

    def names(self, x, u, t):
        """What an expression of a problem file may name."""
        local = {**self.parameters, "t": t}
        local |= {s: x[i] for i, s in enumerate(self.states)} | {s: u[i] for i, s in enumerate(self.inputs)}
        for table in (self.definitions, self.outputs):
            for name, text in table.items():
                # One with friction stays out: costs and constraints are smooth.
                if name not in local and not re.search(r"\b(sign|unit|der)\b", str(text)):
                    try:
                        local[name] = evaluate(text, local)
                    except NameError:
                        pass
        return local


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


def collocation_matrix(method, stages):
    """The matrix A of the method with its nodes c; the last row of an extended A gives the end of a step."""
    nodes = np.array(ca.collocation_points(stages, "radau" if method == "radau" else "legendre"))
    powers = np.arange(stages)
    vandermonde = nodes[:, None] ** powers

    def weights(upper):
        return np.linalg.solve(vandermonde.T, upper ** (powers + 1) / (powers + 1))

    return nodes, np.array([weights(c) for c in nodes]), weights(1.0)


class Solved:
    """A solution of the program."""

    def __init__(self, z, cost, penalized, success, iterations, seconds):
        self.z, self.cost, self.penalized, self.success = z, cost, penalized, success
        self.iterations, self.seconds = iterations, seconds


class Program:
    """Variables, constraints and penalties as they are collected."""

    def __init__(self, n):
        self.n, self.penalty = n, 0
        # Of every variable the place among (initial state, 0) that it starts from.
        self.variables, self.lower, self.upper, self.origin = [], [], [], []
        self.constraints, self.g_low, self.g_up = [], [], []

    def _variable(self, low, high, origin):
        v = ca.MX.sym(f"v{len(self.variables)}", len(origin))
        self.variables.append(v)
        self.lower.extend(low)
        self.upper.extend(high)
        self.origin.extend(origin)
        return v

    def input(self, low, high):
        return self._variable(low, high, [self.n] * len(low))

    def state(self):
        return self._variable([-np.inf] * self.n, [np.inf] * self.n, range(self.n))

    def slack(self, weights, factor):
        """A violation s, which costs factor (weights[0] s + weights[1] s^2)."""
        s = self._variable([0.0], [np.inf], [self.n])
        self.penalty += factor * (weights[0] * s + weights[1] * s**2)
        return s

    def constrain(self, value, low, high):
        self.constraints.append(value)
        self.g_low.extend([low] * value.numel())
        self.g_up.extend([high] * value.numel())


class Problem:
    """The program of a problem file."""

    def __init__(self, path, options=None):
        problem = tomllib.loads(path.read_text())
        self.file = problem
        values = problem.get("parameters", {})
        self.model = model = Model(path.parent / problem["model"], values)
        plant_values = values | problem.get("run", {}).get("parameters", {})
        self.plant = Model(path.parent / problem.get("plant", problem["model"]), plant_values)
        self.horizon, self.run = problem["horizon"], problem["run"]
        self.steps, self.dt = self.horizon["steps"], model.constant(self.horizon["dt"])
        self.samples = self.run.get("steps", self.steps)
        self.x0 = np.array([model.constant(self.run.get("x0", {}).get(s, 0)) for s in model.states])
        widths = problem.get("solve", {}).get("smoothing", 0.01)
        self.widths = widths if isinstance(widths, list) else [widths]
        if not model.switched:
            self.widths = [1.0]
        self.bounds = dict(problem.get("constraints", {}))
        for name, r in model.ranges.items():
            self.bounds[name] = {**r, **self.bounds.get(name, {})}
        self.first_inputs = self._first_inputs()
        self.substeps = self.stable_substeps()
        self.transcribe(options)

    def _first_inputs(self):
        """The guess of the inputs; where the file gives none, 0 or the bound closest to it."""
        guess = self.file.get("guess", {})
        low, high = self._input_bounds()
        rows = []
        for k in range(self.steps):
            local = {**self.model.parameters, "t": (k + 0.5) * self.dt}
            rows.append([float(evaluate(guess[s], local)) if s in guess else min(max(0.0, low[j]), high[j])
                         for j, s in enumerate(self.model.inputs)])
        return np.array(rows).reshape(self.steps, self.model.m)

    def _end(self, name, side, default):
        bounds = self.bounds.get(name, {})
        return self.model.constant(bounds[side]) if side in bounds else default

    def _input_bounds(self):
        names = self.model.inputs
        return [self._end(s, "min", -np.inf) for s in names], [self._end(s, "max", np.inf) for s in names]

    def stable_substeps(self):
        """As many Runge-Kutta steps as the smoothed friction needs for stability, unless the file says how many."""
        if "substeps" in self.horizon or not self.model.switched:
            return self.horizon.get("substeps", 1)
        slopes = np.abs(np.array(self.model.slopes(self.x0, self.first_inputs[0], 0)))
        return max(1, int(np.ceil(self.dt * slopes.max() / self.widths[-1] / 2)))

    def _functions(self):
        """Stage and terminal cost; the constraints on expressions: function, side, table, whether inputs and states occur."""
        model = self.model
        x, u, t = ca.SX.sym("x", model.n), ca.SX.sym("u", model.m), ca.SX.sym("t")
        names = model.names(x, u, t)
        for k, v in self.file.get("references", {}).items():
            names[k] = evaluate(v, {**model.parameters, "t": t})
        costs = self.file.get("cost", {})
        self.stage = ca.Function("l", [x, u, t], [evaluate(costs.get("stage", 0.0), names)])
        self.terminal = ca.Function("e", [x, t], [evaluate(costs.get("terminal", 0.0), names)])
        rows = []
        for name, b in self.bounds.items():
            if "expression" in b:
                value = evaluate(b["expression"], names)
                parts = [(side, [value - evaluate(b[side], names)]) for side in ("min", "max") if side in b]
            elif "norm" in b:
                # The square is smooth where the norm is not; a slack widens the limit.
                parts = [("norm", [sum(evaluate(c, names) ** 2 for c in b["norm"]), evaluate(b["max"], names)])]
            else:
                continue
            for side, terms in parts:
                uses_inputs, uses_states = (any(ca.depends_on(ca.vertcat(*terms), v) for v in ca.vertsplit(w)) for w in (u, x))
                rows.append((ca.Function("g", [x, u, t], terms), side, b, uses_inputs, uses_states))
        return rows

    def transcribe(self, options=None):
        """States the program, and makes its solver."""
        model, steps, dt = self.model, self.steps, self.dt
        start, t0, width = ca.MX.sym("x0", model.n), ca.MX.sym("t0"), ca.MX.sym("w")
        self.program = program = Program(model.n)
        path_constraints = self._functions()
        inputs = [program.input(*self._input_bounds()) for _ in range(steps)]
        states = [program.state() for _ in range(steps + 1)]
        times = [t0 + k * dt for k in range(steps + 1)]
        program.constrain(states[0] - start, 0.0, 0.0)
        cost = self.terminal(states[steps], times[steps])
        advance = self._advance()
        for k in range(steps):
            program.constrain(states[k + 1] - advance(states[k], inputs[k], times[k], width), 0.0, 0.0)
            cost += dt * self.stage(states[k], inputs[k], times[k])
            for i, name in enumerate(model.states):
                if name in self.bounds:
                    self._bound(name, states[k + 1][i])
        for constraint in path_constraints:
            self._along(constraint, states, [*inputs, ca.DM.zeros(model.m)], times)
        for name, target in self.file.get("target", {}).items():
            self._target(states[steps][model.states.index(name)], target if isinstance(target, dict) else {"value": target})
        z, p = ca.vertcat(*program.variables), ca.vertcat(start, t0, width)
        self.cost = ca.Function("cost", [z, p], [cost, cost + program.penalty])
        self.nlp = {"x": z, "p": p, "f": cost + program.penalty, "g": ca.vertcat(*program.constraints)}
        self.options = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False, "expand": True,
                        "ipopt": {**IPOPT, **(options or {})}}
        self.solver = ca.nlpsol("solver", "ipopt", self.nlp, self.options)

    def with_options(self, options):
        """Another solver of the same program."""
        return ca.nlpsol("solver", "ipopt", self.nlp, {**self.options, "ipopt": {**self.options["ipopt"], **options}})

    def _advance(self):
        """The state after an interval as a function of (x, u, t, width)."""
        method = self.horizon.get("integrator", "rk4")
        self.stages = self.horizon.get("stages", 2) if method != "rk4" else 0
        if self.stages:
            return lambda x, u, t, w: self._collocate(collocation_matrix(method, self.stages), x, u, t, w)
        x, u, t, w = ca.SX.sym("x", self.model.n), ca.SX.sym("u", self.model.m), ca.SX.sym("t"), ca.SX.sym("w")
        end = runge_kutta(lambda a, b, c: self.model.field(a, b, c, w), x, u, t, self.dt, self.substeps)
        return ca.Function("F", [x, u, t, w], [end])

    def _collocate(self, tableau, x, u, t, width):
        nodes, matrix, last = tableau
        h = self.dt / self.substeps
        for i in range(self.substeps):
            points = [self.program.state() for _ in nodes]
            f = [self.model.field(p, u, t + (i + c) * h, width) for p, c in zip(points, nodes)]
            for p, row in zip(points, matrix):
                self.program.constrain(p - x - h * sum(a * v for a, v in zip(row, f)), 0.0, 0.0)
            x = x + h * sum(a * v for a, v in zip(last, f))
        return x

    def _bound(self, name, value):
        """The bounds of a state at a grid point."""
        b = self.bounds[name]
        low, high = self._end(name, "min", -np.inf), self._end(name, "max", np.inf)
        s = 0 if b.get("hard") else self.program.slack(b.get("soft", SOFT), self.dt)
        if np.isfinite(low):
            self.program.constrain(value + s, low, np.inf)
        if np.isfinite(high):
            self.program.constrain(value - s, -np.inf, high)

    def _along(self, constraint, states, inputs, times):
        """A constraint on an expression or a norm: at all points with inputs if it uses them, else at all but the first."""
        f, side, table, uses_inputs, uses_states = constraint
        hard = table.get("hard", not uses_states and "soft" not in table)
        for k in range(self.steps) if uses_inputs else range(1, self.steps + 1):
            value = f(states[k], inputs[k], times[k])
            s = 0 if hard else self.program.slack(table.get("soft", SOFT), self.dt)
            if side == "norm":
                square, limit = value
                self.program.constrain(limit + s, 0.0, np.inf)
                self.program.constrain(square - (limit + s) ** 2, -np.inf, 0.0)
            elif side == "min":
                self.program.constrain(value + s, 0.0, np.inf)
            else:
                self.program.constrain(value - s, -np.inf, 0.0)

    def _target(self, value, target):
        tolerance = self.model.constant(target.get("tolerance", 1e-2))
        s = self.program.slack(target.get("soft", [1 / tolerance, 0.5 / tolerance**2]), 1.0)
        e = value - self.model.constant(target["value"])
        self.program.constrain(e - s, -np.inf, 0.0)
        self.program.constrain(e + s, 0.0, np.inf)

    def guess(self, inputs=None):
        """Where the solution starts: the inputs of the guess, at rest in the initial state."""
        z = np.concatenate([self.x0, [0.0]])[self.program.origin]
        z[:self.first_inputs.size] = (self.first_inputs if inputs is None else inputs).ravel()
        return z

    def split(self, z):
        """Inputs (steps × m) and states (steps + 1 × n) of a solution."""
        n, m, steps = self.model.n, self.model.m, self.steps
        u, x, _ = np.split(z, [steps * m, steps * m + (steps + 1) * n])
        return u.reshape(steps, m), x.reshape(steps + 1, n)

    def shifted(self, z):
        """The solution one interval later."""
        u, x = self.split(z)
        u, x = np.vstack([u[1:], u[-1:]]), np.vstack([x[1:], x[-1:]])
        # Collocation is for stiff models, on which an explicit method would not end.
        if not self.stages:
            x[-1] = runge_kutta(self._field(self.model, self.widths[-1]), x[-2], u[-1], 0.0, self.dt, self.substeps)
        return np.concatenate([u.ravel(), x.ravel(), z[u.size + x.size:]])

    @staticmethod
    def _field(model, width):
        return lambda a, b, c: np.array(model.field(a, b, c, width)).ravel()

    def solve(self, z, x, t=0.0, widths=None, solver=None):
        """Solves the program, for one smoothing width after the other."""
        seconds, iterations = 0.0, 0
        for w in widths or self.widths:
            p = np.concatenate([x, [t, w]])
            began = time.perf_counter()
            result = (solver or self.solver)(x0=z, p=p, lbx=self.program.lower, ubx=self.program.upper,
                                             lbg=self.program.g_low, ubg=self.program.g_up)
            seconds += time.perf_counter() - began
            stats = (solver or self.solver).stats()
            iterations += stats["iter_count"]
            z = np.array(result["x"]).ravel()
        cost, penalized = (float(v) for v in self.cost(z, p))
        return Solved(z, cost, penalized, stats["success"], iterations, seconds)

    def advance_plant(self, x, u, t, dt):
        """One sample of the plant: with one switching function exactly, smooth by Runge-Kutta."""
        if self.plant.switched:
            return switched_step(self.plant, x, u, t, dt, 40)
        return runge_kutta(self._field(self.plant, 1.0), x, u, t, dt, self.run.get("plant_substeps", self.substeps))
