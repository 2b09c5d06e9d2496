#!/usr/bin/env python3
"""Runs the demonstration with many seeds and writes the table of docs/records/main_job.md.

usage: seeds.py [--seeds 1-20] [--command target/release/bracketry] [--record | --confirm]

Without --record the table is printed only. With --record or --confirm, the figures of the default seed are copied to docs/figures. Each seed draws other excitations and other noise of the camera. With --confirm the
default seed alone is run: if its numbers are those of the record, to the last digit, the record is stated to hold for the programs
as they are now. For changes that leave results as they are.
"""

import argparse
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RECORD = ROOT / "docs/records/main_job.md"
# Figures of the documents: the file of the demonstration, and its name in docs/figures.
FIGURES = {"extended.gif": "main_job.gif", "before_and_after.png": "main_job_before_and_after.png"}
BEGIN, END = "<!-- seeds: begin -->", "<!-- seeds: end -->"
sys.path.insert(0, str(ROOT / ".ci"))
from main_job import problems  # noqa: E402
from records import RECORDS, STAMP, stamp  # noqa: E402


def run(command: str, seed: int | None, folder: pathlib.Path, draws: bool = False) -> dict:
    """The result of one seed, with its times and memory; the default seed may also draw the figures of the documents."""
    out = folder / f"seed_{seed}"
    arguments = [command, "demo", "--json", "--out", str(out)] + ([] if seed is None else ["--seed", str(seed)])
    start = time.monotonic()
    # Processor time and peak of this child alone.
    script = ("import resource, subprocess, sys; r = subprocess.run(sys.argv[1:]).returncode; "
              "u = resource.getrusage(resource.RUSAGE_CHILDREN); "
              "print(u.ru_utime + u.ru_stime, u.ru_maxrss, file=sys.stderr); sys.exit(r)")
    done = subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True, text=True)
    if not done.stdout:
        raise SystemExit(f"seed {seed}: {done.stderr}")
    result = json.loads(done.stdout)
    processor, peak = done.stderr.split()[-2:]
    result.update(processor_s=float(processor), elapsed_s=time.monotonic() - start, peak_mb=int(peak) / 1024)
    if draws and seed is None:
        for name, figure in FIGURES.items():
            shutil.copy(out / name, ROOT / "docs/figures" / figure)
    shutil.rmtree(out, ignore_errors=True)
    print(" | ".join(row("default" if seed is None else seed, result)), file=sys.stderr, flush=True)
    return result


def row(seed: object, result: dict) -> list[str]:
    moved = result["true_plant"]["extended_model"]
    failed = problems(result, {})
    if moved is None:
        return [str(seed), "no cause"] + ["–"] * 9
    a = moved["arrival"]
    names = [c["parameters"][0]["name"] + {True: "", False: " (not in the plant)", None: " (unnamed)"}[c["in_plant"]] for c in result["causes"]]
    gains = " / ".join(f"{g['times_smaller']:.1f}" for g in result["gain"])
    settled = "–" if a["settled_s"] is None else f"{a['settled_s']:.2f}"
    return [
        str(seed), "no" if failed else "yes", f"{1e3 * a['x_m']:+.2f}", f"{1e3 * a['y_m']:+.2f}", f"{a['phi_deg']:+.2f}", settled,
        gains, f"{result['processor_s']:.0f}", f"{result['elapsed_s']:.0f}", f"{result['peak_mb']:.0f}", ", ".join(names),
    ]


def table(header: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(header)} |", "|" + "---|" * len(header), *(f"| {' | '.join(r)} |" for r in rows)]


def number(value: float | None, form: str, unit: str) -> str:
    return "–" if value is None else f"{value:{form}}{unit}"


def chapters(result: dict) -> list[str]:
    """The figures of the chapters with the default seed."""
    error, two = result["target_error"], result["two_step"]
    published, extended = (result["true_plant"][name] for name in ["published_model", "extended_model"])
    shortest, move = result["shortest_s"], result["move_s"]
    lines = [
        "On the published equations (chapter 2), the shortest plan that arrives takes "
        f"{number(shortest, '.2f', ' s')}, and the move {move:.2f} s:", "",
    ]
    lines += table(["", "together (MPC)", "two steps"], [
        ["time to target", number(result["time_s"], ".2f", " s"), number(result["two_step_time_s"], ".2f", " s")],
        ["error in x", number(1e3 * error["x_m"], "+.2f", " mm"), number(1e3 * two["x_m"], "+.2f", " mm")],
        ["error in y", number(1e3 * error["y_m"], "+.2f", " mm"), number(1e3 * two["y_m"], "+.2f", " mm")],
        ["error in yaw", number(error["phi_deg"], "+.2f", "°"), number(two["phi_deg"], "+.0f", "°")],
        ["remaining spin", number(result["spin_deg_s"], "+.2f", " °/s"), number(two["spin_deg_s"], "+.0f", " °/s")],
    ])
    lines += ["", "On the plant with contact over the whole footprint (chapters 3 and 6):", ""]

    def both(name: str, scale: float, form: str, unit: str, loop: str) -> list[str]:
        return [number(None if m is None else scale * m[loop][name], form, unit) for m in [published, extended]]

    def time(name: str) -> list[str]:
        return [number(None if m is None else m[name], ".2f", " s") for m in [published, extended]]

    rows = [["shortest plan that arrives", *time("shortest_s")], ["duration of the move", *time("duration_s")]]
    for what, loop in [("closed loop", "arrival"), ("open loop", "plan_arrival")]:
        rows.append([f"{what}, x", *both("x_m", 1e3, "+.2f", " mm", loop)])
        rows.append([f"{what}, y", *both("y_m", 1e3, "+.2f", " mm", loop)])
        rows.append([f"{what}, yaw", *both("phi_deg", 1, "+.2f", "°", loop)])
    settled = [None if m is None else m["arrival"]["settled_s"] for m in [published, extended]]
    rows.append(["within ±2 mm, ±2° from", *("never" if s is None else f"{s:.2f} s" for s in settled)])
    lines += table(["errors at the end", "published model", "extended model"], rows)
    lines += ["", "Causes that the diagnosis names (chapter 4):", ""]

    def values(cause: dict) -> str:
        of = [f"`{p['name']}` {p['value']:.4g}" + (" (whole)" if not p["interval"] or p["interval"][0] == p["interval"][1] else
              f" ({p['interval'][0]:.3g} to {p['interval'][1]:.3g})") for p in cause["parameters"]]
        return ", ".join(of)

    def truth(cause: dict) -> str:
        known = [f"{p['in_plant']:.4g}" for p in cause["parameters"] if p["in_plant"] is not None]
        return {True: ", ".join(known), False: "lacks it", None: f"unnamed: {', '.join(known) or '–'}"}[cause["in_plant"]]

    lines += table(["cause", "in", "value (95 % interval)", "in the plant"], [
        [f"`{c['name']}`", c["equation"], values(c), truth(c)] for c in result["causes"]])
    gain = result["diagnosis"]["gain"]
    lines += ["", "Prediction error on the held-out multisine, relative to the standard deviation of the measurement:", ""]
    lines += table(["horizon", "published model", "refitted", "extended", "published over extended"], [
        [f"{h:g} s", f"{100 * g:.1f} %", f"{100 * b:.1f} %", f"{100 * a:.1f} %", f"{g / a:.1f}"]
        for h, g, b, a in zip(gain["horizons_s"], gain["as_given"], gain["before"], gain["after"])])
    return lines


def values_of_all(results: list[dict]) -> list[str]:
    """The values of each parameter that the diagnosis adds, compared with that of the plant."""
    found = {}
    for result in results:
        for parameter in (p for c in result["causes"] for p in c["parameters"]):
            found.setdefault(parameter["name"], []).append(parameter)

    def of(name: str, all_of_it: list[dict]) -> list[str]:
        true, values = all_of_it[0]["in_plant"], [p["value"] for p in all_of_it]
        fitted = [p["interval"] for p in all_of_it if p["interval"] and p["interval"][0] < p["interval"][1]]
        inside = "whole, not fitted" if not fitted else "–" if true is None else (
            f"{sum(low <= true <= high for low, high in fitted)} of {len(fitted)}")
        ends = f"{statistics.median(values):.4g} ({min(values):.4g} to {max(values):.4g})"
        return [f"`{name}`", str(len(values)), "–" if true is None else f"{true:.4g}", ends, inside]

    header = ["parameter", "runs", "in the plant", "median (minimum to maximum)", "95 % intervals that contain the plant's value"]
    return table(header, [of(*item) for item in found.items()])


def confirm(command: str) -> int:
    """Runs the default seed, and renews the date of the record if nothing but times has changed."""
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        result = run(command, None, folder, draws=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    record = RECORD.read_text()
    now, times = row("default", result), range(7, 10)
    cells = next(line for line in record.splitlines() if line.startswith("| default |"))[2:-2].split(" | ")
    differ = [(a, b) for k, (a, b) in enumerate(zip(cells, now)) if k not in times and a != b]
    tables = [line for line in chapters(result) if line and line not in record]
    if differ or tables:
        print(f"the record has other numbers: {differ} {tables}", file=sys.stderr)
        return 1
    old = STAMP.search(record)
    new = stamp("python3 benches/main_job/seeds.py --confirm", RECORDS["docs/records/main_job.md"][0])
    end = record.index("\n", old.start())
    of = re.search(r"(?:numbers of all seeds were|figures) made at commit ([0-9a-f]+)", record[old.start():end])
    new += f" The numbers of all seeds were made at commit {of[1] if of else old[1]}."
    RECORD.write_text(record[:old.start()] + new + record[end:])
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="1-20", help="first-last")
    parser.add_argument("--command", default=str(ROOT / "target/release/bracketry"))
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; more than one lengthen each other")
    parser.add_argument("--record", action="store_true", help="write the table into the record")
    parser.add_argument("--confirm", action="store_true", help="run only the default seed, and renew the date of the record")
    arguments = parser.parse_args()
    if arguments.confirm:
        return confirm(arguments.command)
    first, last = (int(part) for part in arguments.seeds.split("-"))
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        seeds = [None, *range(first, last + 1)]
        with ThreadPoolExecutor(arguments.jobs) as pool:
            results = dict(zip(seeds, pool.map(lambda seed: run(arguments.command, seed, folder, arguments.record), seeds)))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    header = ["seed", "passed", "x, mm", "y, mm", "yaw, °", "at rest from, s", "gain at 0.1 / 0.5 / 1 s", "processor, s",
              "elapsed, s", "peak, MB", "causes, by parameter"]
    lines = table(header, [row("default" if s is None else s, r) for s, r in results.items()])
    good = sum(not problems(r, {}) for r in results.values())

    def median_and_most(name: str) -> str:
        values = [r[name] for r in results.values()]
        return f"{statistics.median(values):.0f} (maximum {max(values):.0f})"

    text = "\n".join([
        stamp("python3 benches/main_job/seeds.py --record", RECORDS["docs/records/main_job.md"][0]), "",
        f"{good} of {len(results)} runs passed, {arguments.jobs} at a time. Processor time {median_and_most('processor_s')} s, elapsed "
        f"{median_and_most('elapsed_s')} s, peak {median_and_most('peak_mb')} MB at the median.", "", *lines, "",
        "### Values over all runs", "", *values_of_all(list(results.values())), "", "### With the default seed", "", *chapters(results[None]),
    ])
    print(text)
    if arguments.record:
        record = RECORD.read_text()
        before, after = record.split(BEGIN)[0], record.split(END)[1]
        RECORD.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}")
    return 0 if good == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())
