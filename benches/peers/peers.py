"""The same work by SymPy, SymEngine and CasADi, each written the way that is fastest in it. Prints JSON.

CPU time of the process, medians, in seconds. Usage: peers.py DIRECTORY SECONDS (where the C code of the Jacobian
goes; the time that is given to CasADi for ten trailers).
"""
import json
import statistics
import sys
import time

import casadi as ca
import numpy as np
import symengine
import sympy


def median(runs, f):
    f()
    times = []
    for _ in range(runs):
        # SymPy remembers what it did, across runs too.
        sympy.core.cache.clear_cache()
        begin = time.process_time()
        result = f()
        times.append(time.process_time() - begin)
    return statistics.median(times), result


def hall(generators, length):
    """(left, right, length) of every element: [a, b] with a < b and b a generator or left(b) <= a."""
    elements = [(None, None, 1) for _ in range(generators)]
    by_length = [[], list(range(generators))]
    for n in range(2, length + 1):
        by_length.append([])
        for k in range(1, n):
            for a in by_length[k]:
                for b in by_length[n - k]:
                    if a < b and (elements[b][0] is None or elements[b][0] <= a):
                        by_length[n].append(len(elements))
                        elements.append((a, b, n))
    return elements


def plate(sin, cos, tanh, number, state, smooth):
    """Drift and input fields of the published plate with integrators; see systems.rs."""
    x, y, phi, vx, vy, w, X, Xd, theta, thetad = state
    mu, g, a, b = number(3, 10), number(981, 100), number(15, 100), number(10, 100)
    sx, sy = (tanh(100 * vx), tanh(100 * vy)) if smooth else (1, 1)
    inertia = a**2 / 4 + b**2 / 4
    syy = sin(phi) ** 2 * a**2 / 4 + cos(phi) ** 2 * b**2 / 4
    drift = [vx, vy, w, -sx * mu * g, -g * sin(theta) - sy * mu * g * cos(theta), 0, Xd, 0, thetad, 0]
    slide = [0, 0, 0, -1, 0, 0, 0, 1, 0, 0]
    tilt = [0, 0, 0, 0, -sy * mu * y, -sx * mu * syy / inertia, 0, 0, 0, 1]
    return [drift, slide, tilt]


NAMES = "x y phi vx vy w X Xd theta thetad"


def brackets_by_matrices(se, smooth, elements):
    """Jacobian matrices and their products, as one would write it down."""
    state = se.symbols(NAMES)
    longest = elements[-1][2]
    generators = plate(se.sin, se.cos, se.tanh, se.Rational, state, smooth)
    column = lambda f: se.Matrix(len(f), 1, f)
    x = column(list(state))
    fields = [column(f) for f in generators]
    jacobians = [f.jacobian(x) for f in fields]
    for a, b, n in elements[3:]:
        fields.append(jacobians[b] * fields[a] - jacobians[a] * fields[b])
        jacobians.append(fields[-1].jacobian(x) if n < longest else None)
    return fields


def brackets_by_entries(se, smooth, elements):
    """Only entries of the Jacobians that are not zero."""
    state = se.symbols(NAMES)
    longest = elements[-1][2]
    generators = plate(se.sin, se.cos, se.tanh, se.Rational, state, smooth)
    place = {s: i for i, s in enumerate(state)}

    def jacobian(field):
        return [(i, place[s], e.diff(s)) for i, e in enumerate(field) if e != 0 for s in e.free_symbols]

    fields = [[se.sympify(e) for e in f] for f in generators]
    jacobians = [jacobian(f) for f in fields]
    zero = se.Integer(0)
    for a, b, n in elements[3:]:
        c = [zero] * len(state)
        for i, k, d in jacobians[b]:
            if fields[a][k] != 0:
                c[i] = c[i] + d * fields[a][k]
        for i, k, d in jacobians[a]:
            if fields[b][k] != 0:
                c[i] = c[i] - d * fields[b][k]
        fields.append(c)
        jacobians.append(jacobian(c) if n < longest else [])
    return fields


def brackets_by_casadi(smooth, elements, sparse):
    x = ca.SX.sym("x", 10)
    longest = elements[-1][2]
    generators = plate(ca.sin, ca.cos, ca.tanh, lambda p, q: p / q, [x[i] for i in range(10)], smooth)
    fields = [ca.vertcat(*f) for f in generators]
    fields = [ca.sparsify(ca.SX(f)) if sparse else ca.SX(f) for f in fields]
    if not sparse:
        for a, b, _ in elements[3:]:
            fields.append(ca.jtimes(fields[b], x, fields[a]) - ca.jtimes(fields[a], x, fields[b]))
        return fields
    jacobians = [ca.jacobian(f, x) for f in fields]
    zero = ca.SX(10, 1)
    for a, b, n in elements[3:]:
        if fields[a].nnz() == 0 or fields[b].nnz() == 0:
            c = zero
        else:
            c = ca.sparsify(ca.mtimes(jacobians[b], fields[a]) - ca.mtimes(jacobians[a], fields[b]))
        fields.append(c)
        jacobians.append(ca.jacobian(c, x) if n < longest else None)
    return fields


def plate_times(smooth, length, with_sympy):
    elements = hall(3, length)
    times = {
        "symengine_matrices": median(11, lambda: brackets_by_matrices(symengine, smooth, elements))[0],
        "symengine_entries": median(11, lambda: brackets_by_entries(symengine, smooth, elements))[0],
        "casadi_jtimes": median(11, lambda: brackets_by_casadi(smooth, elements, False))[0],
        "casadi_sparse": median(11, lambda: brackets_by_casadi(smooth, elements, True))[0],
    }
    if with_sympy:
        times["sympy_matrices"] = median(3, lambda: brackets_by_matrices(sympy, smooth, elements))[0]
        times["sympy_entries"] = median(3, lambda: brackets_by_entries(sympy, smooth, elements))[0]
    times["count"] = len(elements)
    return times


def trailers(n):
    q = ca.SX.sym("q", n + 3)
    angle = [q[2 + i] for i in range(n + 1)]
    speed = ca.SX(1)
    rates = [ca.SX(0)]
    for i in range(1, n + 1):
        rates.append(speed * ca.sin(angle[i - 1] - angle[i]) / (i + 1))
        speed = speed * ca.cos(angle[i - 1] - angle[i])
    drive = ca.vertcat(speed * ca.cos(angle[n]), speed * ca.sin(angle[n]), *rates)
    turn = ca.SX(ca.DM([0, 0, 1] + n * [0]))
    return q, [drive, ca.sparsify(turn)]


def trailer_rank(n, by_jtimes, budget, tolerance=1e-12):
    """Right-normed brackets of the fields that were independent so far; numeric rank at one random point."""
    begin = time.process_time()
    q, generators = trailers(n)
    point = np.random.default_rng(1).uniform(-1, 1, n + 3)
    span = np.zeros((n + 3, 0))
    jacobians = {}

    def jacobian(f):
        if id(f) not in jacobians:
            jacobians[id(f)] = ca.jacobian(f, q)
        return jacobians[id(f)]

    def bracket(a, b):
        if by_jtimes:
            return ca.jtimes(b, q, a) - ca.jtimes(a, q, b)
        return ca.mtimes(jacobian(b), a) - ca.mtimes(jacobian(a), b)

    def independent(candidates):
        nonlocal span
        values = ca.Function("f", [q], [ca.densify(c) for c in candidates]).call([point])
        kept = []
        for c, value in zip(candidates, values):
            v = np.array(value).reshape(n + 3)
            v = v / (np.linalg.norm(v) or 1)
            for _ in range(2):
                v = v - span @ (span.T @ v)
            size = np.linalg.norm(v)
            if size > tolerance:
                span = np.column_stack([span, v / size])
                kept.append(c)
        return kept

    fresh = independent(generators)
    while fresh and span.shape[1] < n + 3:
        candidates = []
        for x in generators:
            for y in fresh:
                if x is not y:
                    candidates.append(bracket(x, y))
                if time.process_time() - begin > budget:
                    return {"dimension": span.shape[1], "finished": False}
        fresh = independent(candidates)
    return {"dimension": span.shape[1], "finished": True}


def trailer_times(budget):
    times = {}
    for name, by_jtimes in [("jtimes", True), ("jacobians", False)]:
        seconds, result = median(5, lambda: trailer_rank(6, by_jtimes, 60.0))
        times["6_" + name] = {"seconds": seconds, **result}
        seconds, result = median(1, lambda: trailer_rank(10, by_jtimes, budget))
        times["10_" + name + "_given_our_time"] = {"seconds": seconds, **result}
        seconds, result = median(1, lambda: trailer_rank(10, by_jtimes, 30.0))
        times["10_" + name] = {"seconds": seconds, **result}
    return times


def write_jacobian(directory):
    """C code of the 6 x 7 Jacobian of crates/native/benches/model, as it stands and with common subexpressions merged."""
    v = ca.SX.sym("v", 9)
    y, phi, vx, vy, w, th, al, om, A = [v[i] for i in range(9)]
    N = 9.81 * ca.cos(th) + y * al + 2 * vy * om - 0.0025 * om**2
    s = ca.sqrt(vx**2 + vy**2 + 1e-4)
    ex, ey = vx / s, vy / s
    Sxx = ca.cos(phi) ** 2 * 0.005625 + ca.sin(phi) ** 2 * 0.0025
    Syy = ca.sin(phi) ** 2 * 0.005625 + ca.cos(phi) ** 2 * 0.0025
    Sxy = 0.003125 * ca.cos(phi) * ca.sin(phi)
    See = Sxx * ex**2 + 2 * Sxy * ex * ey + Syy * ey**2
    ax = -A - 0.3 * N * ex
    ay = -9.81 * ca.sin(th) + y * om**2 + 0.0025 * al - 0.3 * N * ey
    spin = w / ca.sqrt(vx**2 + vy**2 + 1e-4 + 0.008125 * w**2 / 4)
    aw = (-0.3 * al * (Sxy * ey - Syy * ex) + Sxy * om**2 - 0.3 * 9.81 * ca.cos(th) * See * spin) / 0.008125
    J = ca.jacobian(ca.vertcat(vx, vy, w, ax, ay, aw), v)[:, :7]
    plain = ca.Function("plate_jacobian", [v], [J])
    merged = ca.Function("plate_jacobian", [v], [ca.cse(J)])
    codes = []
    for name, f in [("plain", plain), ("merged", merged)]:
        generator = ca.CodeGenerator(f"{name}.c", {"with_header": False})
        generator.add(f)
        generator.generate(directory + "/")
        codes.append({"name": name, "nonzeros": f.nnz_out(0), "instructions": f.n_instructions()})
    at = plain([0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0])
    return {"codes": codes, "sum": float(ca.sum1(ca.sum2(ca.densify(at))))}


if __name__ == "__main__":
    report = {
        "versions": {m.__name__: m.__version__ for m in (sympy, symengine, ca)},
        "plate_one_mode_6": plate_times(False, 6, True),
        "plate_smoothed_5": plate_times(True, 5, True),
        "trailers": trailer_times(float(sys.argv[2])),
        "jacobian": write_jacobian(sys.argv[1]),
    }
    print(json.dumps(report))
