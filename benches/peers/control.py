"""The controllers' programs by CasADi's solvers and do-mpc. Prints JSON; wall-clock time on one core, medians, in seconds.

Usage: control.py FILE

FILE is what our side printed: the states of the pendulum's closed loop, and quadratic programs of the pendulum and the plate
as the trajectory at which they are linearized. The programs are built here from the models' equations alone.
"""
import contextlib
import io
import json
import os
import statistics
import sys
import time
import warnings

os.environ.setdefault("OMP_NUM_THREADS", "1")
warnings.filterwarnings("ignore")
import casadi as ca
import do_mpc
import numpy as np

REPEATS = 5


def timed(f, repeats=REPEATS):
    """Median wall-clock time of a call, and its result."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = f()
        times.append(time.perf_counter() - begin)
    return statistics.median(times), result


def rk4(field, x, u, h, substeps=1):
    for _ in range(substeps):
        h_i = h / substeps
        k1 = field(x, u)
        k2 = field(x + h_i / 2 * k1, u)
        k3 = field(x + h_i / 2 * k2, u)
        k4 = field(x + h_i * k3, u)
        x = x + h_i / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


# The pendulum on a cart

PENDULUM = {"steps": 40, "dt": 0.02, "bound": 80.0, "Q": np.diag([1e3, 1e3, 1e-2, 1e-2]), "R": np.diag([1e-2])}


def pendulum_field(z, u):
    big, m, l, g = 1.0, 0.1, 0.8, 9.81
    p, th, v, w = ca.vertsplit(z)
    s, c = ca.sin(th), ca.cos(th)
    d = big + m - m * c**2
    return ca.vertcat(v, w, (-m * l * s * w**2 + m * g * c * s + u) / d,
                      (-m * l * c * s * w**2 + u * c + (big + m) * g * s) / (l * d))


# The plate, reduced model, with friction rounded

PLATE = {"mu": 0.3, "g": 9.81, "h": 0.0025, "Sa": 0.005625, "Sb": 0.0025}


def plate_field(width):
    def field(z, u):
        mu, g, h, sa, sb = (PLATE[k] for k in ("mu", "g", "h", "Sa", "Sb"))
        x, y, phi, vx, vy, w, big_x, xd, th, thd = ca.vertsplit(z)
        xdd, thdd = ca.vertsplit(u)
        inertia = sa + sb
        speed = ca.sqrt(vx**2 + vy**2 + width**2)
        ex, ey = vx / speed, vy / speed
        s, c = ca.sin(phi), ca.cos(phi)
        sxx, syy, sxy = c**2 * sa + s**2 * sb, s**2 * sa + c**2 * sb, s * c * (sa - sb)
        see = inertia / 2 + (sxx - syy) / 2 * (ex**2 - ey**2) + 2 * sxy * ex * ey
        spin = w / ca.sqrt(vx**2 + vy**2 + inertia / 4 * w**2 + width**2)
        load = g * ca.cos(th) + y * thdd + 2 * vy * thd - h * thd**2
        torque = -mu * thdd * (sxy * ey - syy * ex) - mu * g * ca.cos(th) * see * spin
        return ca.vertcat(vx, vy, w, -xdd - mu * load * ex,
                          -g * ca.sin(th) + y * thd**2 + h * thdd - mu * load * ey,
                          (torque + sxy * thd**2) / inertia, xd, xdd, thd, thdd)
    return field


class Programs:
    """Quadratic programs of one problem, in the stage-wise order that HPIPM wants: x0 u0 x1 s1 u1 x2 s2 u2 …

    The slacks s_k of soft bounds are states of their stage, set by inputs of the stage before: s_{k+1} = v_k.
    """

    def __init__(self, field, n, m, steps, dt, substeps, q, r, p, input_bounds, soft):
        z, u = ca.SX.sym("z", n), ca.SX.sym("u", m)
        end = rk4(field, z, u, dt, substeps)
        self.step = ca.Function("step", [z, u], [end, ca.jacobian(end, z), ca.jacobian(end, u)])
        self.n, self.m, self.steps, self.dt = n, m, steps, dt
        self.q, self.r, self.p, self.input_bounds, self.soft = q, r, p, input_bounds, soft

    def build(self, program):
        """H, g, A, bounds of rows and variables for one trajectory."""
        n, m, steps, n_s = self.n, self.m, self.steps, len(self.soft)
        xs, us = np.array(program["x"]), np.array(program["u"])
        start, goal = np.array(program["start"]), np.array(program["goal"])
        states, inputs = [n] + [n + n_s] * steps, m + n_s
        at = np.concatenate([[0], np.cumsum([s + inputs for s in states])])
        columns = at[steps] + states[steps]
        h, g = np.zeros((columns, columns)), np.zeros(columns)
        low, high = -np.inf * np.ones(columns), np.inf * np.ones(columns)
        rows, lower, upper = [], [], []
        for k in range(steps + 1):
            o, o_u = at[k], at[k] + states[k]
            weight = self.p if k == steps else self.dt * self.q
            h[o:o + n, o:o + n] = 2 * weight
            x_k = start if k == 0 else xs[k]
            g[o:o + n] = 2 * weight @ (x_k - goal)
            if k == 0:
                low[:n] = high[:n] = 0
            if k < steps:
                end, a, b = (np.array(v) for v in self.step(x_k, us[k]))
                h[o_u:o_u + m, o_u:o_u + m] = 2 * self.dt * self.r
                g[o_u:o_u + m] = 2 * self.dt * self.r @ us[k]
                low[o_u:o_u + m] = -self.input_bounds - us[k]
                high[o_u:o_u + m] = self.input_bounds - us[k]
                low[o_u + m:o_u + inputs] = 0
                gap = np.zeros((n + n_s, columns))
                gap[:n, o:o + n], gap[:n, o_u:o_u + m] = a, b
                gap[n:, o_u + m:o_u + inputs] = np.eye(n_s)
                gap[:, at[k + 1]:at[k + 1] + n + n_s] = -np.eye(n + n_s)
                rows.append(gap)
                lower.append(np.concatenate([xs[k + 1] - end.ravel(), np.zeros(n_s)]))
                upper.append(lower[-1])
            for j, (state, bound, linear, quadratic) in enumerate(self.soft if k else []):
                g[o + n + j], h[o + n + j, o + n + j] = self.dt * linear, 2 * self.dt * quadratic
                sides = np.zeros((2, columns))
                sides[:, o + state], sides[:, o + n + j] = (1, -1), -1
                rows.append(sides)
                lower.append(-np.inf * np.ones(2))
                upper.append(bound - np.array([1, -1]) * x_k[state])
        return h, g, np.vstack(rows), np.concatenate(lower), np.concatenate(upper), low, high

    def solvers(self):
        """Name, plug-in, options; HPIPM takes bounds beyond `inf` for real ones."""
        n_s = len(self.soft)
        shape = {"N": self.steps, "nx": [self.n] + [self.n + n_s] * self.steps, "nu": [self.m + n_s] * self.steps + [0],
                 "ng": [0] + [2 * n_s] * self.steps}
        return {"HPIPM": ("hpipm", {"inf": 1e4, **shape}), "PIQP": ("piqp", {}), "DAQP": ("daqp", {})}

    def compare(self, programs):
        """Per solver: the time of a program, and how many have our solver's first input."""
        built = [self.build(p) for p in programs]
        # The places of all programs, so that a solver can be built once.
        h_places, a_places = (ca.sparsify(ca.DM(sum(np.abs(b[i]) > 0 for b in built) * 1.0)).sparsity() for i in (0, 2))
        out = {}
        for name, (plugin, options) in self.solvers().items():
            with quiet():
                solver = ca.conic("s", plugin, {"h": h_places, "a": a_places}, {"error_on_fail": False, **options})
            times, errors = [], []
            for program, (h, g, a, la, ua, lx, ux) in zip(programs, built, strict=True):
                numbers = {"h": ca.project(ca.DM(h), h_places), "a": ca.project(ca.DM(a), a_places),
                           "g": g, "lba": la, "uba": ua, "lbx": lx, "ubx": ux}
                with quiet():
                    seconds, result = timed(lambda: solver(**numbers))
                times.append(seconds)
                u0 = np.array(result["x"]).ravel()[self.n:self.n + self.m] + np.array(program["u"][0])
                errors.append(float(np.max(np.abs(u0 - program["u0"]) / self.input_bounds)))
            same = sum(e < 1e-4 for e in errors)
            out[name] = {"seconds": statistics.median(times), "same": same, "of": len(errors), "difference": max(errors)}
        return out


@contextlib.contextmanager
def quiet():
    """Nothing on standard output, of C code neither."""
    sys.stdout.flush()
    saved, null = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(null)


def casadi_ipopt(states, warm):
    """A converged solution at every state of the closed loop, each started from the last, shifted."""
    n, steps, dt = 4, PENDULUM["steps"], PENDULUM["dt"]
    x0, x, u = ca.SX.sym("x0", n), ca.SX.sym("x", n, steps + 1), ca.SX.sym("u", 1, steps)
    q, r = PENDULUM["Q"], PENDULUM["R"]
    cost, gaps = 0, [x[:, 0] - x0]
    for k in range(steps):
        cost += dt * (x[:, k].T @ q @ x[:, k] + u[:, k].T @ r @ u[:, k])
        gaps.append(x[:, k + 1] - rk4(pendulum_field, x[:, k], u[:, k], dt))
    cost += x[:, steps].T @ q @ x[:, steps]
    variables = ca.vertcat(ca.vec(x), ca.vec(u))
    quietly = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
    options = dict(quietly)
    if warm:
        options.update({"ipopt.warm_start_init_point": "yes", "ipopt.mu_init": 1e-6,
                        "ipopt.warm_start_bound_push": 1e-8, "ipopt.warm_start_mult_bound_push": 1e-8})
    program = {"x": variables, "p": x0, "f": cost, "g": ca.vertcat(*gaps)}
    with quiet():
        first = ca.nlpsol("first", "ipopt", program, quietly)
        solver = ca.nlpsol("solver", "ipopt", program, options)
    bound = np.concatenate([np.inf * np.ones(n * (steps + 1)), PENDULUM["bound"] * np.ones(steps)])
    guess = np.concatenate([np.tile(states[0], steps + 1), np.zeros(steps)])
    multipliers = {"lam_x0": np.zeros(len(guess)), "lam_g0": np.zeros(n * (steps + 1))}
    times, inputs = [], []
    for k, state in enumerate(states):
        def solve():
            with quiet():
                return (solver if k else first)(x0=guess, p=state, lbx=-bound, ubx=bound, lbg=0, ubg=0, **multipliers)
        seconds, result = timed(solve, 1)
        if k:  # the first solution finds the swing-up
            times.append(seconds)
        v = np.array(result["x"]).ravel()
        xs, us = v[:n * (steps + 1)].reshape(steps + 1, n), v[n * (steps + 1):]
        inputs.append(float(us[0]))
        guess = np.concatenate([xs[1:].ravel(), xs[-1], us[1:], us[-1:]])
        multipliers = {"lam_x0": result["lam_x"], "lam_g0": result["lam_g"]}
    return times, inputs


def do_mpc_steps(states):
    """The same with do-mpc: its own transcription of the discrete-time model."""
    model = do_mpc.model.Model("discrete")
    z = model.set_variable("_x", "z", shape=(4, 1))
    u = model.set_variable("_u", "u", shape=(1, 1))
    model.set_rhs("z", rk4(pendulum_field, z, u, PENDULUM["dt"]))
    model.setup()
    mpc = do_mpc.controller.MPC(model)
    mpc.settings.n_horizon = PENDULUM["steps"]
    mpc.settings.t_step = PENDULUM["dt"]
    mpc.settings.store_full_solution = False
    mpc.settings.nlpsol_opts = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
    q = ca.DM(PENDULUM["Q"])
    terminal = z.T @ q @ z
    mpc.set_objective(mterm=terminal, lterm=PENDULUM["dt"] * (terminal + 1e-2 * u**2))
    mpc.set_rterm(u=0)
    mpc.bounds["lower", "_u", "u"], mpc.bounds["upper", "_u", "u"] = -PENDULUM["bound"], PENDULUM["bound"]
    with quiet():
        mpc.setup()
        mpc.x0 = np.array(states[0]).reshape(-1, 1)
        mpc.set_initial_guess()
    times, inputs = [], []
    for k, state in enumerate(states):
        def solve():
            with quiet():
                return mpc.make_step(np.array(state).reshape(-1, 1))
        seconds, result = timed(solve, 1)
        if k:
            times.append(seconds)
        inputs.append(float(result[0, 0]))
    return times, inputs


def main():
    us = json.load(open(sys.argv[1]))
    states, applied = us["pendulum"]["states"], us["pendulum"]["inputs"]
    out = {"versions": {"CasADi": ca.__version__, "do-mpc": do_mpc.__version__}}

    def agreement(inputs):
        return max(abs(a - b) for a, b in zip(inputs, applied, strict=True)) / PENDULUM["bound"]

    for name, f in (("casadi_cold", lambda: casadi_ipopt(states, False)),
                    ("casadi_warm", lambda: casadi_ipopt(states, True)), ("do_mpc", lambda: do_mpc_steps(states))):
        times, inputs = f()
        out[name] = {"median": statistics.median(times), "mean": statistics.mean(times), "difference": agreement(inputs)}
    q, r = PENDULUM["Q"], PENDULUM["R"]
    pendulum = Programs(pendulum_field, 4, 1, 40, 0.02, 1, q, r, q, np.array([PENDULUM["bound"]]), [])
    out["pendulum_programs"] = pendulum.compare(us["pendulum"]["programs"])
    plate = us["plate"]
    q, r, p = (np.diag(plate[k]) for k in ("Q", "R", "P"))
    soft = [tuple(s) for s in plate["soft"]]
    programs = Programs(plate_field(plate["width"]), 10, 2, plate["steps"], plate["dt"], plate["substeps"], q, r, p,
                        np.array(plate["bounds"]), soft)
    out["plate_programs"] = programs.compare(plate["programs"])
    print(json.dumps(out))


if __name__ == "__main__":
    main()
