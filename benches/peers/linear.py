#!/usr/bin/env python3
"""Compares `bracketry trim` and `bracketry linearize` with SciPy and python-control on random systems.

    python3 benches/peers/linear.py --bracketry target/release/bracketry [--systems 50]

needs numpy, scipy, mpmath and control (python-control), for example from a virtual environment. It prints the largest relative difference
of each quantity and ends with an error where one exceeds 1e-9. Random systems are x' = A x + B u + a quadratic and a sine about a
random equilibrium, so that the matrices, the operating point and all that follows are known from formulas.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

# The module control is python-control, not the file of that name beside this one.
sys.path = [entry for entry in sys.path if Path(entry or ".").resolve() != Path(__file__).resolve().parent]

import control  # noqa: E402
import mpmath  # noqa: E402
import numpy as np  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.optimize  # noqa: E402

TOLERANCE = 1e-9


def run(program, *arguments):
    done = subprocess.run([program, *arguments, "--json"], stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{arguments}: exit code {done.returncode}")
    return json.loads(done.stdout)


def model(rng, n, m, p):
    """Text of a model with the equilibrium x = 0, u = 0, and its matrices there."""
    a, b, c, d = (np.round(rng.uniform(-2, 2, shape), 3) for shape in ((n, n), (n, m), (p, n), (p, m)))
    d[rng.uniform(size=d.shape) < 0.5] = 0.0
    names = [f"x{i}" for i in range(n)]
    inputs = [f"u{j}" for j in range(m)]
    lines = [f"states = {names}", f"inputs = {inputs}", "[dynamics]"]
    for i in range(n):
        terms = [f"({float(a[i, j])!r})*x{j}" for j in range(n) if j != i] + [f"({float(b[i, j])!r})*u{j}" for j in range(m)]
        terms += [f"({float(a[i, i])!r})*sin(x{i})", f"x{i}^2*x{(i + 1) % n}/4"]
        lines.append(f"x{i} = '{' + '.join(terms)}'")
    lines.append("[outputs]")
    for k in range(p):
        terms = [f"({float(c[k, j])!r})*x{j}" for j in range(n)] + [f"({float(d[k, j])!r})*u{j}" for j in range(m)]
        lines.append(f"y{k} = '{' + '.join(terms)}'")
    return "\n".join(lines) + "\n", (a, b, c, d)


def difference(ours, theirs):
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    if ours.shape != theirs.shape:
        return np.inf
    return 0.0 if ours.size == 0 else float(np.abs(ours - theirs).max() / (1.0 + np.abs(theirs).max()))


def matched(ours, theirs):
    """Relative difference of two sets of complex numbers, paired so that the sum of distances is least."""
    ours, theirs = np.asarray(ours, dtype=complex), np.asarray(theirs, dtype=complex)
    if ours.shape != theirs.shape:
        return np.inf
    if ours.size == 0:
        return 0.0
    distance = np.abs(ours[:, None] - theirs[None, :])
    rows, columns = scipy.optimize.linear_sum_assignment(distance)
    return float((distance[rows, columns] / (1.0 + np.abs(theirs[columns]))).max())


def complex_list(pairs):
    return [complex(re, im) for re, im in pairs]


def refined(a, b, x, steps=3):
    """The solution of a Riccati equation with unit weights, by Newton's method with 40 digits: where the solution is large, the
    peers' own is known to fewer digits than are compared."""
    mpmath.mp.dps = 40
    n = len(a)
    a, b, x = (mpmath.matrix(m.tolist()) for m in (a, b, x))
    for _ in range(steps):
        gain = b.T * x
        closed, right = a - b * gain, mpmath.eye(n) + gain.T * gain
        left, flat = mpmath.matrix(n * n, n * n), mpmath.matrix(n * n, 1)
        for i in range(n):
            for j in range(n):
                for k in range(n):
                    left[i * n + j, k * n + j] += closed[k, i]
                    left[i * n + j, i * n + k] += closed[k, j]
                flat[i * n + j] = -right[i, j]
        flat = mpmath.lu_solve(left, flat)
        x = mpmath.matrix([[(flat[i * n + j] + flat[j * n + i]) / 2 for j in range(n)] for i in range(n)])
    return np.array(x.tolist(), dtype=float)


def compared(answer, a, b, c, d):
    n, m, p = len(a), b.shape[1], c.shape[0]
    space = control.ss(a, b, c, d)
    found = {k: difference(np.array(answer[k.lower()]["values"]).reshape(v.shape), v) for k, v in zip("ABCD", (a, b, c, d))}
    poles = [complex(q["re"], q["im"]) for q in answer["poles"] for _ in range(q["multiplicity"])]
    found["poles"] = matched(poles, space.poles())
    if m == p:
        # Finite generalized eigenvalues of the Rosenbrock pencil.
        left = np.block([[a, b], [c, d]])
        right = np.zeros_like(left)
        right[:n, :n] = np.eye(n)
        alpha, beta = scipy.linalg.eigvals(left, right, homogeneous_eigvals=True)
        finite = np.abs(beta) > 1e-7 * np.abs(alpha).max()
        found["zeros"] = matched(complex_list(answer["zeros"]), alpha[finite] / beta[finite])
    _, solution, _ = control.lqr(space, np.eye(n), np.eye(m))
    solution = refined(a, b, solution)
    found["regulator"] = max(
        difference(answer["regulator"]["gain"], b.T @ solution), difference(answer["regulator"]["solution"], solution)
    )
    estimator = scipy.linalg.solve_continuous_are(a.T, c.T, np.eye(n), np.eye(p))
    estimator = refined(a.T, c.T, estimator)
    found["estimator"] = difference(answer["estimator"]["gain"], estimator @ c.T)
    gramians = answer["gramians"]
    if "horizon" not in gramians:
        found["Gramians"] = max(
            difference(gramians["controllability"], scipy.linalg.solve_continuous_lyapunov(a, -b @ b.T)),
            difference(gramians["observability"], scipy.linalg.solve_continuous_lyapunov(a.T, -c.T @ c)),
        )
    else:
        # By integration of the matrix exponential, Gauss-Legendre on 8 parts.
        nodes, weights = np.polynomial.legendre.leggauss(20)
        parts, total = 8, np.zeros_like(a)
        step = gramians["horizon"] / parts
        for k in range(parts):
            for x, w in zip(nodes, weights):
                e = scipy.linalg.expm(a * step * (k + 0.5 * (x + 1.0))) @ b
                total += 0.5 * step * w * e @ e.T
        found["Gramians to a horizon"] = difference(gramians["controllability"], total)
    # A search for the least singular value from many starts, which bounds it from above.
    def sigma(z):
        return np.linalg.svd(np.hstack([a - (z[0] + 1j * z[1]) * np.eye(n), b]), compute_uv=False)[-1]

    starts = [(z.real, abs(z.imag)) for z in poles] + [(0.0, 0.0)]
    options = {"xatol": 1e-10, "fatol": 1e-14}
    least = min(scipy.optimize.minimize(sigma, s, method="Nelder-Mead", options=options).fun for s in starts)
    margin = answer["distance_to_uncontrollable"]
    if margin["lower"] > least * (1 + 1e-9) or margin["upper"] > least * (1 + 1e-6):
        raise RuntimeError(f"margin {margin} against {least}")
    assert answer["controllability"]["rank"] == np.linalg.matrix_rank(control.ctrb(a, b))
    assert answer["observability"]["rank"] == np.linalg.matrix_rank(control.obsv(a, c))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bracketry", default="target/release/bracketry")
    parser.add_argument("--systems", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    worst = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.toml"
        for k in range(given.systems):
            n, m, p = int(rng.integers(2, 8)), int(rng.integers(1, 4)), int(rng.integers(1, 4))
            text, matrices = model(rng, n, m, p)
            path.write_text(text)
            for name, value in compared(run(given.bracketry, "linearize", str(path)), *matrices).items():
                if value > worst.get(name, (-1, 0))[0]:
                    worst[name] = (value, k)
            # The equilibrium with a held input, against SciPy's root from the same start.
            a, b, _, _ = matrices
            u = np.round(rng.uniform(-0.05, 0.05, m), 3)
            fixed = ",".join(f"u{j}={float(v)!r}" for j, v in enumerate(u))
            trim = run(given.bracketry, "trim", str(path), "--fix", fixed)
            off = a - np.diag(np.diag(a))

            def f(x):
                return off @ x + np.diag(a) * np.sin(x) + x**2 * np.roll(x, -1) / 4 + b @ u

            if trim["found"]:
                ours = np.array([trim["states"][f"x{i}"]["value"] for i in range(n)])
                theirs = scipy.optimize.root(f, ours, tol=1e-14).x
                value = max(difference(ours, theirs), float(np.abs(f(ours)).max()))
                if value > worst.get("trim", (-1, 0))[0]:
                    worst["trim"] = (value, k)
            else:
                print(f"system {k}: no operating point, residual {trim['residual']}")
    for name, (value, k) in worst.items():
        print(f"{name:22} {value:.1e} (system {k})")
    return 0 if all(value <= TOLERANCE for value, _ in worst.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
