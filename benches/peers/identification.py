#!/usr/bin/env python3
"""Names hidden effects by sparse regression (PySINDy) in the logs of the example `hidden_effects`.

    python3 benches/peers/identification.py logs/xv -- --runs 200 --seed 1 --measured xv --effect any --size 0.1 --parallel

needs numpy, scipy and pysindy. What follows -- goes to the example, which writes its logs into the directory and diagnoses them (into
`diagnose.json` there, its table into `diagnose.md`; not again if they are there already); then regression sees the same logs. Without -- any
number of directories with such logs can be given. Each gives one row per method. What helps the regression is granted: the library has exactly
the terms of the effects in question (three Stribeck velocities), derivatives are smoothed over the window that served it best of several
on other seeds (`--window`), the force and its derivative are smoothed alike, and the neighborhood of reversals is left out. The threshold of STLSQ and the number of terms of FROLS have the smallest Bayesian
information criterion on the last 30 % of the log, which the fit does not see. What survives beside force and Coulomb friction is
named; scores as in crates/diagnose/src/synthetic/score.rs.
"""
import argparse
import json
import subprocess
import sys
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import pysindy
from scipy.signal import savgol_filter

STRIBECK_VELOCITIES = [0.05, 0.1, 0.2]
HELD_OUT = 0.3
ROOT = Path(__file__).resolve().parents[2]
# Share of a term's rms in the target's that STLSQ keeps.
THRESHOLDS = np.geomspace(0.003, 0.3, 15)


def smooth(values, dt, window, derivative):
    """A polynomial of degree 3 (4 for a second derivative) through each `window` seconds."""
    count = max(int(round(window / dt)) // 2 * 2 + 1, 7)
    return savgol_filter(values, count, 4 if derivative == 2 else 3, deriv=derivative, delta=dt)


def regression(path, window):
    """Terms by name, acceleration, and time of each row."""
    names = path.open().readline().strip().split(",")
    columns = dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1).T))
    t, u = columns["t"], columns["u"]
    dt = t[1] - t[0]
    x = smooth(columns["x"], dt, window, 0)
    if "v" in columns:
        v, a = smooth(columns["v"], dt, window, 0), smooth(columns["v"], dt, window, 1)
    else:
        v, a = smooth(columns["x"], dt, window, 1), smooth(columns["x"], dt, window, 2)
    force, force_rate = smooth(u, dt, window, 0), smooth(u, dt, window, 1)
    terms = [("force", force), ("coulomb", np.sign(v)), ("viscous", v), ("quadratic", np.abs(v) * v)]
    terms += [("stribeck", np.exp(-((v / s) ** 2)) * np.sign(v)) for s in STRIBECK_VELOCITIES]
    terms += [("tilt", np.ones_like(v)), ("delay", force_rate), ("stiffness", x)]
    # Not the ends, where the window is one-sided, nor reversals, whose jumps the window smears.
    half = int(round(window / dt / 2))
    changes = np.flatnonzero(np.diff(np.sign(v)) != 0)
    use = np.ones(len(t), bool)
    use[:half] = use[-half:] = False
    for k in changes:
        use[max(k - half, 0) : k + half + 2] = False
    return [name for name, _ in terms], np.column_stack([term for _, term in terms])[use], a[use], t[use]


def criterion(theta, target, coefficients, independent):
    """Bayesian information criterion with as many samples as are independent."""
    square = np.mean((target - theta @ coefficients) ** 2)
    return independent * np.log(square) + np.count_nonzero(coefficients) * np.log(independent)


def candidates(method, theta, target):
    """Coefficients of every threshold, or of every number of terms."""
    if method == "STLSQ":
        for threshold in THRESHOLDS:
            optimizer = pysindy.STLSQ(threshold=threshold, alpha=1e-6)
            optimizer.fit(theta, target[:, None])
            yield optimizer.coef_[0]
    else:
        optimizer = pysindy.FROLS(max_iter=theta.shape[1], alpha=1e-6)
        try:
            optimizer.fit(theta, target[:, None])
        except ValueError:  # linearly dependent columns
            yield np.zeros(theta.shape[1])
            return
        for coefficients in optimizer.history_:
            yield np.asarray(coefficients)[0]


def survivors(method, path, window):
    """Names of the effects that the regression keeps, the largest term first."""
    names, theta, target, t = regression(path, window)
    scale = np.sqrt(np.mean(theta**2, axis=0)) / np.sqrt(np.mean(target**2))
    theta, target = theta / scale, target
    train = t < t[0] + (1.0 - HELD_OUT) * (t[-1] - t[0])
    size = np.sqrt(np.mean(target**2))
    independent = max(np.count_nonzero(~train) * (t[1] - t[0]) / window, 8.0)
    fits = list(candidates(method, theta[train] / size, target[train] / size))
    best = min(fits, key=lambda c: criterion(theta[~train] / size, target[~train] / size, c, independent))
    kept = sorted(np.flatnonzero(best), key=lambda k: -abs(best[k]))
    return list(dict.fromkeys(names[k] for k in kept if names[k] not in ("force", "coulomb")))


def score(hidden, named):
    if not hidden:
        return "false alarm" if named else "exact"
    if not named:
        return "missed"
    if set(named) - set(hidden):
        return "wrong name"
    return "exact" if set(named) == set(hidden) else "partly"


def make(directory, options):
    """Logs into the directory, then their diagnosis."""
    example = ["cargo", "run", "--release", "-p", "bracketry-trials", "--example", "hidden_effects", "--features", "measure", "--", *options]
    subprocess.run([*example, "--export", str(directory)], check=True, cwd=ROOT)
    if not (directory / "diagnose.md").exists():
        run = subprocess.run([*example, "--json", str(directory / "diagnose.json")], check=True, cwd=ROOT, stdout=subprocess.PIPE)
        (directory / "diagnose.md").write_bytes(run.stdout)


def diagnosed(directory):
    """Scores of `diagnose`, the number of logs whose truth is in the set, and its mean time."""
    rows = [json.loads(line) for line in (directory / "diagnose.json").read_text().splitlines()]
    among = sum(row["score"] in ("exact", "in set") for row in rows)
    return Counter(row["score"] or "error" for row in rows), among, sum(row["seconds"] for row in rows) / len(rows)


def line(directory, method, runs, counts, among, seconds):
    """One row of the table; where nothing is hidden, no truth can be among the names."""
    share = lambda n: f"{100.0 * n / runs:.0f} %"
    among = "" if json.loads(next((directory / "truth").iterdir()).read_text())["hidden"] == [] else share(among)
    cells = [directory.name, method, str(runs), share(counts["exact"]), among, share(counts["wrong name"])]
    cells += [share(counts["missed"] + counts["unexplained"]), share(counts["false alarm"]), f"{seconds:.2g}"]
    print("| " + " | ".join(cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directories", nargs="+", type=Path)
    parser.add_argument("--window", type=float, help="seconds of smoothing; by default 0.03 with v measured, 0.2 without")
    parser.add_argument("--json", type=Path, help="write one line per log and method")
    end = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    options, of_example = parser.parse_args(sys.argv[1:end]), sys.argv[end + 1 :]
    if of_example:
        if len(options.directories) > 1:
            parser.error("one directory only can be filled")
        make(options.directories[0].resolve(), of_example)
    warnings.filterwarnings("ignore")
    rows = []
    print("| logs | method | runs | exactly named | truth among the names | wrong name | missed or unexplained | false alarm | s per log |")
    print("|---|---|---|---|---|---|---|---|---|")
    for directory in options.directories:
        logs = sorted(directory.glob("*.csv"), key=lambda p: int(p.stem))
        measured = logs[0].open().readline()
        window = options.window or (0.03 if ",v" in measured else 0.2)
        if (directory / "diagnose.json").exists():
            line(directory, "diagnose", len(logs), *diagnosed(directory))
        for method in ("STLSQ", "FROLS"):
            all_names, first_names, among, start = Counter(), Counter(), 0, time.time()
            for path in logs:
                truth = json.loads((directory / "truth" / f"{path.stem}.json").read_text())
                hidden = [h["effect"] for h in truth["hidden"]]
                named = survivors(method, path, window)
                all_names[score(hidden, named)] += 1
                # As many names as there are effects, the largest terms.
                first_names[score(hidden, named[: max(len(hidden), 1)])] += 1
                among += bool(hidden) and set(hidden) <= set(named)
                rows.append({"log": str(path), "method": method, "hidden": hidden, "named": named})
            seconds = (time.time() - start) / len(logs)
            line(directory, method, len(logs), all_names, among, seconds)
            line(directory, f"{method}, largest terms only", len(logs), first_names, among, seconds)
    if options.json:
        options.json.write_text("".join(json.dumps(row) + "\n" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
