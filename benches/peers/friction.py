#!/usr/bin/env python3
"""The spring-mass with Coulomb friction by a complementarity formulation on CasADi and IPOPT, on an exact stick-slip plant.

    python benches/peers/friction.py

Every sample solves the problem with the friction F s, -1 <= s <= 1, v = p - m, where 1 - s is complementary to p and 1 + s to m:
their products are at most eps, for eps from 1e-1 to 1e-8, each solution the start of the next (Scholtes). Implicit Euler or
Radau IIA collocation. The plant is integrated in closed form between events. The last line minimizes every sample on that
closed-form flow (SciPy, L-BFGS-B): what this horizon can attain.
Needs casadi, numpy and scipy. Compare with `cargo run --release -p bracketry-mpc --example friction_comparison --features measure spring-mass`.
"""
import time
from math import atan2, cos, exp, pi, sin, sqrt

import casadi as ca
import numpy as np
from scipy.optimize import minimize

K, C, F = 0.8, 0.5, 0.2
GOAL, U_REF, R, U_MAX = 2.0, 1.8, 0.1, 2.0
N, H, SAMPLES = 20, 0.15, 40
DAMPING = C / 2
FREQUENCY = sqrt(K - DAMPING**2)


def slide(x, v, u, sign, t):
    """Closed-form motion under constant input and friction force."""
    rest = (u - sign * F) / K
    d = x - rest
    e, c, s = exp(-DAMPING * t), cos(FREQUENCY * t), sin(FREQUENCY * t)
    b = (v + DAMPING * d) / FREQUENCY
    position = e * (d * c + b * s)
    return rest + position, -DAMPING * position + e * FREQUENCY * (b * c - d * s)


def plant(x, v, u, t):
    """Exact stick-slip motion over a time t."""
    while t > 1e-15:
        if abs(v) < 1e-13:
            v, force = 0.0, u - K * x
            if abs(force) <= F:
                break
            sign = 1.0 if force > 0 else -1.0
        else:
            sign = 1.0 if v > 0 else -1.0
        # v(t) = e^(-at) (v cos wt + q sin wt): its first zero after now.
        d = x - (u - sign * F) / K
        b = (v + DAMPING * d) / FREQUENCY
        q = -DAMPING * b - FREQUENCY * d
        angle = atan2(sign * v, -sign * q)
        zero = min((angle + j * pi) / FREQUENCY for j in range(-1, 3) if angle + j * pi > 1e-12)
        if zero >= t:
            return slide(x, v, u, sign, t)
        x, v = slide(x, v, u, sign, zero)
        v, t = 0.0, t - zero
    return x, v


def stage(x, v, u):
    return (x - GOAL) ** 2 + v**2 + R * (u - U_REF) ** 2


class Complementarity:
    """Control with friction as a complementarity problem in every collocation point."""

    def __init__(self, substeps, radau):
        points = [1 / 3, 1.0] if radau else [1.0]
        # Row i: coefficients of (x_0, x_1, ...) in h x'(point i).
        derivative = [[-2.0, 1.5, 0.5], [2.0, -4.5, 2.5]] if radau else [[-1.0, 1.0]]
        w, low, high, g, g_low, g_high, cost = [], [], [], [], [], [], 0
        self.start, self.eps = ca.SX.sym("x0", 2), ca.SX.sym("eps")
        state, h = self.start, H / substeps
        self.inputs = []

        def variable(name, size, lower, upper):
            v = ca.SX.sym(name, size)
            w.append(v)
            low.extend([lower] * size)
            high.extend([upper] * size)
            return v

        def constrain(e, lower, upper):
            g.append(e)
            g_low.append(lower)
            g_high.append(upper)

        for k in range(N):
            self.inputs.append(sum(v.numel() for v in w))
            u = variable(f"u{k}", 1, -U_MAX, U_MAX)
            cost += H * stage(state[0], state[1], u)
            for _ in range(substeps):
                stages = [state] + [variable("x", 2, -ca.inf, ca.inf) for _ in points]
                for i in range(len(points)):
                    x, v = stages[i + 1][0], stages[i + 1][1]
                    # v = plus - minus; force F s with 1 - s complementary to plus and 1 + s to minus.
                    plus, minus, s = variable("p", 1, 0, ca.inf), variable("m", 1, 0, ca.inf), variable("s", 1, -1, 1)
                    constrain(v - plus + minus, 0, 0)
                    constrain(plus * (1 - s) - self.eps, -ca.inf, 0)
                    constrain(minus * (1 + s) - self.eps, -ca.inf, 0)
                    slope = sum(derivative[i][j] * stages[j] for j in range(len(stages)))
                    constrain(slope[0] - h * v, 0, 0)
                    constrain(slope[1] - h * (-K * x - C * v + u - F * s), 0, 0)
                state = stages[-1]
        problem = {"x": ca.vertcat(*w), "f": cost, "g": ca.vertcat(*g), "p": ca.vertcat(self.start, self.eps)}
        options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-8,
                   "ipopt.warm_start_init_point": "yes", "ipopt.mu_init": 1e-3}
        self.solver = ca.nlpsol("solver", "ipopt", problem, options)
        self.bounds = {"lbx": low, "ubx": high, "lbg": g_low, "ubg": g_high}
        self.guess = np.zeros(len(low))

    def __call__(self, x, v):
        for eps in (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8):
            self.guess = self.solver(x0=self.guess, p=[x, v, eps], **self.bounds)["x"]
        return float(self.guess[self.inputs[0]])


class ExactMinimum:
    """Control by minimizing the cost on the plant's own flow."""

    def __init__(self):
        self.guess = np.full(N, U_REF)

    def __call__(self, x0, v0):
        def cost(inputs):
            x, v, total = x0, v0, 0.0
            for u in inputs:
                total += H * stage(x, v, u)
                x, v = plant(x, v, u, H)
            return total

        starts = (self.guess, np.full(N, U_REF), np.full(N, U_MAX))
        found = [minimize(cost, s, bounds=[(-U_MAX, U_MAX)] * N, method="L-BFGS-B") for s in starts]
        best = min(found, key=lambda r: r.fun).x
        self.guess = np.append(best[1:], best[-1])
        return float(best[0])


def main():
    print("| way | cost | end x | ms median | ms longest |\n|---|---|---|---|---|")
    for name, controller in (
        ("complementarity, implicit Euler", Complementarity(1, False)),
        ("complementarity, Radau IIA, 2 points", Complementarity(1, True)),
        ("complementarity, Radau IIA, 2 points, 3 substeps", Complementarity(3, True)),
        ("minimum on the closed-form flow", ExactMinimum()),
    ):
        x, v, cost, times = 0.0, 0.0, 0.0, []
        for _ in range(SAMPLES):
            begin = time.perf_counter()
            u = controller(x, v)
            times.append(1e3 * (time.perf_counter() - begin))
            cost += H * stage(x, v, u)
            x, v = plant(x, v, u, H)
        print(f"| {name} | {cost:.5f} | {x:.5f} | {np.median(times):.1f} | {max(times):.1f} |", flush=True)


if __name__ == "__main__":
    main()
