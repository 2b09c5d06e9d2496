#!/usr/bin/env python3
"""References of problems with rates of inputs, intervals of different lengths, and a free end time, by CasADi with IPOPT on the
same discretization (RK4, 2 steps per interval, inputs held). `cargo test -p bracketry-mpc --test main breadth::` compares.

    python benches/peers/breadth_references.py
"""
import casadi as ca
import numpy as np


def pendulum(x, u):
    return ca.vertcat(x[1], 9.81 * ca.sin(x[0]) - 0.1 * x[1] + u)


def rk4(x, u, h):
    for _ in range(2):
        k1 = pendulum(x, u)
        k2 = pendulum(x + h / 4 * k1, u)
        k3 = pendulum(x + h / 4 * k2, u)
        k4 = pendulum(x + h / 2 * k3, u)
        x = x + h / 12 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


def solve(lengths, x0, stage, bound, rate=None, target=None, guess=lambda t: 0.0, time=None):
    """The cost, and the end time where `time` = (guess, min, max) is one. `stage` has the arguments x, u, rate(u)."""
    steps = len(lengths)
    x, u = ca.SX.sym("x", 2, steps + 1), ca.SX.sym("u", steps)
    scale = ca.SX.sym("scale") if time else ca.SX(1)
    cost, equal, rates = 0, [x[:, 0] - x0], []
    start, states, inputs, t = np.array(x0, float), [np.array(x0, float)], [], 0.0
    for k, length in enumerate(lengths):
        h = scale * length
        change = (u[k] - (u[k - 1] if k else 0)) / h
        cost += h * stage(x[:, k], u[k], change)
        equal.append(x[:, k + 1] - rk4(x[:, k], u[k], h))
        rates.append(change)
        inputs.append(guess(t + length / 2))
        t += length
        start = np.array(rk4(ca.DM(start), inputs[-1], length)).ravel()
        states.append(start)
    if target is not None:
        equal.append(x[:, steps] - target)
    z = ca.vertcat(ca.vec(x), u, *([scale] if time else []))
    first = np.concatenate([np.concatenate(states), inputs, [1.0] if time else []])
    ends = ([time[1] / time[0]], [time[2] / time[0]]) if time else ([], [])
    low = np.concatenate([np.full(2 * steps + 2, -np.inf), np.full(steps, -bound), ends[0]])
    high = np.concatenate([np.full(2 * steps + 2, np.inf), np.full(steps, bound), ends[1]])
    g = ca.vertcat(*equal, *(rates if rate else []))
    n = ca.vertcat(*equal).numel()
    limits = np.zeros(n), np.zeros(n)
    if rate:
        limits = np.append(limits[0], np.full(steps, -rate)), np.append(limits[1], np.full(steps, rate))
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-10, "ipopt.max_iter": 3000}
    solver = ca.nlpsol("solver", "ipopt", {"x": z, "f": cost, "g": g}, options)
    found = solver(x0=first, lbx=low, ubx=high, lbg=limits[0], ubg=limits[1])
    status, iterations = solver.stats()["return_status"], solver.stats()["iter_count"]
    return float(found["f"]), float(found["x"][-1]) * time[0] if time else None, status, iterations


def quadratic(x, u, rate):
    return 10 * x[0] ** 2 + 0.1 * x[1] ** 2 + 0.01 * u**2


if __name__ == "__main__":
    uniform = [0.04] * 50
    print("rates", *solve(uniform, [2, 0], lambda x, u, r: quadratic(x, u, r) + 1e-4 * r**2, 10, rate=60))
    print("growth", *solve([0.04 * 1.055**k for k in range(25)], [2, 0], quadratic, 10))
    for effort, guess in [(0.01, 1.5), (0.1, 3.3)]:
        free = (guess, 0.2, 10)
        swing = solve([guess / 30] * 30, [1.0, 0], lambda x, u, r: 1 + effort * u**2, 12, target=[0, 0], time=free)
        print("end time", effort, *swing)
