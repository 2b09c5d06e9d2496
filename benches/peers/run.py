#!/usr/bin/env python3
"""Compares speed with other systems and writes the tables in docs/records/speed.md.

    python3 benches/peers/run.py [--only algebra|simulation|control]

makes a virtual environment in target/peers, installs the others from PyPI, builds our side in release mode, runs
everything one after the other on one core and replaces what stands between the marks in docs/records/speed.md: algebra with
SymPy, SymEngine and CasADi (its C code is built with cc), simulation with SciPy and MuJoCo, control with CasADi's solvers and
do-mpc. `--python FILE` uses an
interpreter that has them already.
"""
import argparse
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PACKAGES = ["sympy", "symengine", "casadi", "numpy", "scipy", "mujoco", "do-mpc"]
# Largest errors of x, y (m) and phi (rad) at which the simulators are compared.
ERRORS = [1e-4, 1e-6, 1e-8]
# The same for coupled friction, which SciPy only approaches as the speed of stopping goes to zero.
COUPLED_ERRORS = [1e-4, 1e-5]


def output(command, **options):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


def interpreter(target):
    python = target / "peers" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", target / "peers"], check=True)
    # Quick if they are there.
    subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", *PACKAGES], check=True)
    return python


def compiled(directory, name, flags):
    program = directory / f"{name}{len(flags)}"
    subprocess.run(["cc", *flags, directory / f"{name}.c", HERE / "driver.c", "-lm", "-o", program], check=True)
    return float(output([program]))


def ms(seconds):
    return f"{seconds * 1e3:.3g} ms"


def row(what, ours, peer, theirs, least=None):
    """A row of the table, and whether its ratio is at least the one required."""
    ratio = theirs / ours
    return f"| {what} | {ms(ours)} | {peer} | {ms(theirs)} | {ratio:.3g} |", not least or ratio >= least


def table(us, them, c_times):
    rows = []
    label = {
        "symengine_matrices": "SymEngine, matrices", "symengine_entries": "SymEngine, nonzero entries by hand",
        "casadi_jtimes": "CasADi, jtimes", "casadi_sparse": "CasADi, sparse Jacobians",
        "sympy_matrices": "SymPy, matrices", "sympy_entries": "SymPy, nonzero entries by hand",
    }
    names = [
        ("plate_one_mode_6", "plate in one mode, Hall brackets to length 6"),
        ("plate_smoothed_5", "smoothed plate, Hall brackets to length 5"),
    ]
    for key, what in names:
        ours, theirs = us[key], {k: v for k, v in them[key].items() if k != "count"}
        assert ours["count"] == them[key]["count"], "the same number of brackets"
        shape = f"{what} ({ours['count']}, {ours['nonzero']} of them not zero)"
        for k, seconds in sorted(theirs.items(), key=lambda kv: kv[1]):
            least = 20 if k.startswith("sympy") else 2
            rows.append(row(f"{shape}; ours with rank {ours['rank']}, theirs without", ours["with_rank"], label[k],
                            seconds, least))
        best = min(theirs, key=theirs.get)
        rows.append(row(f"{shape}; both without rank", ours["brackets"], label[best], theirs[best]))
    for how in ("jtimes", "jacobians"):
        t = them["trailers"][f"6_{how}"]
        assert t["dimension"] == us["trailers_6"]["dimension"] == 9
        rows.append(row("generic rank of 6 trailers, theirs with pruning", us["trailers_6"]["seconds"],
                        f"CasADi, {how}", t["seconds"], 3))
        t = them["trailers"][f"10_{how}"]
        end = f"rank {t['dimension']}" if t["finished"] else f"stopped at {t['dimension']} of 13"
        rows.append(row("generic rank of 10 trailers (13)", us["trailers_10"]["seconds"], f"CasADi, {how}: {end}",
                        t["seconds"]))
        t = them["trailers"][f"10_{how}_given_our_time"]
        end = "finished" if t["finished"] else f"has {t['dimension']} of 13"
        rows.append((f"| the same where CasADi is given our time | {ms(us['trailers_10']['seconds'])} | CasADi, {how} | "
                     f"{end} | |", not t["finished"]))
    rows.append((f"| generic rank of 20 trailers (23) | {ms(us['trailers_20']['seconds'])} | | | |",
                 us["trailers_20"]["dimension"] == 23))
    assert abs(us["jacobian"]["sum"] - them["jacobian"]["sum"]) < 1e-9, "the same Jacobian"
    native = us["jacobian"]["native"]
    for (name, flags), ns in c_times.items():
        kind = "as generated" if name == "plain" else "after ca.cse"
        line = (f"| one call of the 6 × 7 Jacobian | {native * 1e9:.3g} ns | CasADi's C {kind}, cc {flags} | {ns:.3g} ns |"
                f" {ns / (native * 1e9):.3g} |")
        rows.append((line, native * 1e9 <= 1.5 * ns))
    by_hand = us["jacobian"]["by_hand"]
    rows.append((f"| | {native * 1e9:.3g} ns | written by hand in Rust | {by_hand * 1e9:.3g} ns |"
                 f" {by_hand / native:.3g} |", True))
    return written(them["versions"], rows, output(["cc", "--version"]).splitlines()[0])


def written(versions, rows, *more):
    """The table with its head, and whether all ratios are as required."""
    versions = [f"{k} {v}" for k, v in versions.items()]
    where = ", ".join([platform.machine(), cpu(), *versions, output(["rustc", "--version"]).strip(), *more])
    head = [
        f"{where}. Ratio: their time by ours.",
        "",
        "| work | ours | other | their time | ratio |",
        "|---|---|---|---|---|",
    ]
    return "\n".join(head + [r for r, _ in rows]), all(good for _, good in rows)


def cheapest(runs, reference, error):
    """The quickest run whose x, y and phi are nowhere farther than `error` from the reference; None if there is none."""
    def far(run):
        return max(abs(a - b) for p, q in zip(run["states"], reference, strict=True) for a, b in zip(p, q))

    good = [{**run, "error": far(run)} for run in runs if far(run) <= error]
    return min(good, key=lambda run: run["seconds"], default=None)


def scipy_rows(what, ours, runs, reference, error):
    """Our run against the quickest of each of SciPy's methods within the error."""
    rows = []
    for method in ("RK45", "DOP853", "LSODA"):
        theirs = cheapest([r for r in runs if r["method"] == method], reference, error)
        if theirs is None:
            rows.append((f"| {what} | {ms(ours['seconds'])} | SciPy, {method} | not reached | |", True))
            continue
        rows.append(row(what, ours["seconds"], f"SciPy, {method} ({theirs['error']:.1e} with rtol"
                        f" {theirs['rtol']:.1e})", theirs["seconds"], 20))
    return rows


def simulation_table(us, them):
    rows = []
    reference = them["published"]["reference"]
    for error in ERRORS:
        ours = cheapest(us["published"]["runs"], reference, error)
        assert ours["events"] == them["published"]["events"], "the same number of events"
        what = (f"published model, experiment 1, 15 s, {ours['events']} events, error below {error:g}"
                f" ({ours['error']:.1e} with rtol {ours['rtol']:.1e})")
        rows += scipy_rows(what, ours, them["published"]["runs"], reference, error)
    reference = us["reduced"]["runs"][-1]["states"]
    for error in COUPLED_ERRORS:
        ours = cheapest(us["reduced"]["runs"], reference, error)
        what = (f"reduced model, coupled friction, disk, {ours['events']} events, error below {error:g}"
                f" ({ours['error']:.1e} with rtol {ours['rtol']:.1e})")
        rows += scipy_rows(what, ours, them["reduced"]["runs"], reference, error)
    soft = them["soft_contact"]
    assert abs(soft["yaw"] - 120.5) < 6, "the logged orientation"
    mujoco = f"MuJoCo, disk on 37 spheres, {soft['steps']} steps: {soft['yaw']:.1f}°"
    yaw = math.degrees(ours["states"][-1][2])
    rows.append(row(f"reduced model, error below {error:g}: {yaw:.1f}° in 15 s", ours["seconds"], mujoco,
                    soft["seconds"], 10))
    area = us["area"]
    name = f"area contact, {area['points']} points, steps of {1e3 * area['step']:g} ms: {area['yaw']:.1f}° in 15 s"
    rows.append(row(name, area["seconds"], mujoco, soft["seconds"]))
    rows.append(row(name, area["seconds"], "real time", 15.0, 5))
    creeps = [f"{1e3 * them['creep'][k]:.2g} mm" for k in ("stiff", "defaults")]
    rows.append((f"| at rest on a 10° tilt for 60 s, mu 0.3: moves by | {1e3 * us['creep']:.2g} mm | MuJoCo, these settings;"
                 f" its defaults | {creeps[0]}; {creeps[1]} | |", us["creep"] <= 1e-9))
    return written(them["versions"], rows)


def control_table(us, them):
    rows = []
    pendulum, plate = us["pendulum"], us["plate"]
    assert abs(pendulum["cost"] - 2047.463) < 2.047, "the closed-loop cost of the swing-up"
    others = {"casadi_cold": "CasADi, IPOPT, started from the shifted solution",
              "casadi_warm": "CasADi, IPOPT, with multipliers and a small barrier too", "do_mpc": "do-mpc, IPOPT"}
    works = [("sqp", "a sample solved to convergence", {"casadi_cold": 10}), ("rti", "a sample of real-time iteration", {})]
    for key, work, least in works:
        for other, name in others.items():
            assert them[other]["difference"] < 1e-4, f"{name}: the same inputs"
            for kind, ours in (("median", "total"), ("mean", "mean")):
                rows.append(row(f"swing-up of the pendulum, N = 40, {work}, {kind}", pendulum[key][ours], name,
                                them[other][kind], least.get(other)))
    for key, what in (("pendulum", "the pendulum's"), ("plate", "the plate's (10 states, soft bounds)")):
        for name, peer in them[f"{key}_programs"].items():
            agree = f"same first input in {peer['same']} of {peer['of']}"
            rows.append(row(f"{what} quadratic program, N = 40", us[key]["rti"]["program"], f"{name}, {agree}",
                            peer["seconds"]))
        times = us[key]["rti"]
        rows.append((f"| {what} sample: linearize and assemble; program; rest | {ms(times['linearize'])};"
                     f" {ms(times['program'])}; {ms(times['rest'])} | | | |", times["linearize"] < times["program"]))
    return written(them["versions"], rows)


def replace(name, text):
    """Writes `text` between the marks of the table `name` in docs/records/speed.md."""
    document = ROOT / "docs" / "records" / "speed.md"
    begin, end = (f"<!-- {which} of the measured table: {name} -->" for which in ("begin", "end"))
    before, rest = document.read_text().split(begin)
    _, after = rest.split(end)
    document.write_text(f"{before}{begin}\n{text}\n{end}{after}")


def cpu():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown processor"


def compare_algebra(cargo, python):
    us = json.loads(output([*cargo, "algebra"], cwd=ROOT))
    with tempfile.TemporaryDirectory() as scratch:
        directory = Path(scratch)
        them = json.loads(output([python, HERE / "peers.py", directory, str(us["trailers_10"]["seconds"])]))
        flags = [("-O3",), ("-O3", "-march=native")]
        c_times = {(n, " ".join(f)): compiled(directory, n, f) for n in ("plain", "merged") for f in flags}
    return table(us, them, c_times)


def compare_simulation(cargo, python):
    us = json.loads(output([*cargo, "simulation"], cwd=ROOT))
    return simulation_table(us, json.loads(output([python, HERE / "simulation.py"])))


def compare_control(cargo, python):
    us = output([*cargo, "control"], cwd=ROOT)
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        file.write(us)
        file.flush()
        return control_table(json.loads(us), json.loads(output([python, HERE / "control.py", file.name])))


def main():
    parts = {"algebra": compare_algebra, "simulation": compare_simulation, "control": compare_control}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", type=Path, help="interpreter with " + ", ".join(PACKAGES))
    parser.add_argument("--only", choices=parts, help="this part alone")
    arguments = parser.parse_args()
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    python = arguments.python or interpreter(target)
    cargo = ["cargo", "bench", "-q", "--features", "native", "--bench", "peers"]
    subprocess.run([*cargo, "--no-run"], check=True, cwd=ROOT)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    all_good = True
    for name in [arguments.only] if arguments.only else parts:
        text, good = parts[name]([*cargo, "--"], python)
        print(text)
        replace(name, text)
        all_good = all_good and good
    if not all_good:
        sys.exit("a ratio is below the one required")


if __name__ == "__main__":
    main()
