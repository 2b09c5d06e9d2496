#!/usr/bin/env python3
"""Measures how long the workspace takes to build and to test, and writes the tables of docs/records/build.md.

usage: measure.py [--record] [--only NAME ...]     (half an hour on two idle cores)

Everything is built in a temporary folder, from nothing but the downloaded sources. Names: release, wheel, research, tests, warm.
Without --record the tables are printed only.
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RECORD = ROOT / "docs/records/build.md"
sys.path.insert(0, str(ROOT / ".ci"))
from records import git  # noqa: E402

# A research program of ten lines, as it stands beside the repository: expressions, models, analysis, and nothing else.
MANIFEST = """[package]
name = "research"
version = "0.1.0"
edition = "2024"
[dependencies]
bracketry = { path = "%s", default-features = false }
[workspace]
"""
PROGRAM = """use bracketry::lie::{AnalysisOptions, analyze_affine};
use bracketry::system::System;

fn main() {
    let text = "states = ['x', 'y', 'a']\\ninputs = ['v', 'w']\\n[dynamics]\\nx = 'v*cos(a)'\\ny = 'v*sin(a)'\\na = 'w'";
    let system = System::parse("unicycle.toml", text).expect("a model");
    println!("{:?}", analyze_affine(&system, &AnalysisOptions::default()).expect("an analysis").involutive);
}
"""


def run(arguments: list[str], target: pathlib.Path, cwd: pathlib.Path = ROOT, **variables: str) -> tuple[float, float, str]:
    """Elapsed and processor seconds of a command, and what it prints."""
    print("$", " ".join(arguments), file=sys.stderr, flush=True)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target), "CARGO_INCREMENTAL": "0", "CARGO_TERM_COLOR": "never", **variables}
    before, start = os.times(), time.monotonic()
    done = subprocess.run(arguments, cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    after = os.times()
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(arguments)}: exit code {done.returncode}\n{done.stdout[-4000:]}")
    processor = after.children_user - before.children_user + after.children_system - before.children_system
    return time.monotonic() - start, processor, done.stdout


def by_crate(target: pathlib.Path, most: int) -> list[tuple[str, float]]:
    """Seconds of the longest units of the last build with --timings."""
    page = max((target / "cargo-timings").glob("*.html"), key=lambda p: p.stat().st_mtime).read_text()
    units = json.loads(re.search(r"UNIT_DATA = (\[.*?\]);\n", page, re.S)[1])
    seconds: dict[str, float] = {}
    for unit in units:
        name = (unit["name"] + unit.get("target", "")).replace(" (test)", "")
        seconds[name] = seconds.get(name, 0.0) + unit["duration"]
    return sorted(seconds.items(), key=lambda entry: -entry[1])[:most]


def release(target: pathlib.Path, rows: list[str], details: list[str]) -> None:
    """The command, cold, as `cargo run --release` builds it."""
    elapsed, processor, _ = run(["cargo", "build", "--release", "--locked", "--bin", "bracketry", "--timings"], target)
    size = (target / "release/bracketry").stat().st_size / 1e6
    _, _, tree = run(["cargo", "tree", "--locked", "-p", "bracketry-cli", "-e", "normal,build", "--prefix", "none"], target)
    crates = len({line.split(" (")[0] for line in tree.splitlines() if line})
    rows += [f"| cold release build of the command | {elapsed:.0f} s | {processor:.0f} s |"]
    details += [f"The command: {size:.1f} MB, {crates} crates in its tree.", "", "| crate | seconds |", "|---|---|"]
    details += [f"| {name} | {seconds:.0f} |" for name, seconds in by_crate(target, 20)] + [""]


def wheel(target: pathlib.Path, rows: list[str], _: list[str]) -> None:
    """The Python package after the command."""
    if not (target / "release/bracketry").exists():
        release(target, [], [])
    rows += [wheel_after("it", target, ["--release"])]


def wheel_after(what: str, target: pathlib.Path, options: list[str], **variables: str) -> str:
    """The row of a wheel built where something else has been built."""
    maturin = ROOT / "target/python-environment/bin/maturin"
    if not maturin.exists():
        raise SystemExit("no maturin: run crates/python/ci.sh once")
    elapsed, processor, text = run([str(maturin), "build", *options, "--locked", "--out", str(target / "wheels")], target, **variables)
    compiled = len(re.findall(r"^\s*Compiling ", text, re.M))
    return f"| wheel after {what}, {compiled} crates compiled | {elapsed:.0f} s | {processor:.0f} s |"


def research(target: pathlib.Path, rows: list[str], _: list[str]) -> None:
    """A program that only analyzes."""
    folder = target / "research"
    (folder / "src").mkdir(parents=True)
    (folder / "Cargo.toml").write_text(MANIFEST % ROOT)
    (folder / "src/main.rs").write_text(PROGRAM)
    shutil.copy(ROOT / "Cargo.lock", folder)
    elapsed, processor, _ = run(["cargo", "build", "--release", "--offline"], target / "of_research", cwd=folder)
    rows += [f"| research program, `default-features = false`, release | {elapsed:.0f} s | {processor:.0f} s |"]


def tests(target: pathlib.Path, rows: list[str], details: list[str]) -> None:
    """The tests, cold: built and run, as .ci/run does."""
    plain = {"CARGO_PROFILE_DEV_DEBUG": "0"}
    elapsed, processor, text = run(["cargo", "test", "--workspace", "--locked", "--no-run", "--timings"], target, **plain)
    programs = len(re.findall(r"Executable tests/", text))
    rows += [f"| cold build of all tests | {elapsed:.0f} s | {processor:.0f} s |"]
    details += ["Of the tests:", "", "| crate and program | seconds |", "|---|---|"]
    details += [f"| {name} | {seconds:.0f} |" for name, seconds in by_crate(target, 20)] + [""]
    elapsed, processor, text = run(["cargo", "test", "--workspace", "--locked"], target, **plain)
    passed = sum(int(n) for n in re.findall(r"test result: ok\. (\d+) passed", text))
    rows += [f"| running {passed} tests, {programs} programs | {elapsed:.0f} s | {processor:.0f} s |"]
    rows += [wheel_after("them", target, ["--profile", "dev", "--features", "native"], **plain)]


def warm(target: pathlib.Path, rows: list[str], _: list[str]) -> None:
    """After a change in the crate of Lie brackets, as a developer has it: incremental."""
    build = ["cargo", "test", "--workspace", "--locked", "--no-run"]
    source = ROOT / "crates/lie/src/lib.rs"
    run(build, target / "warm", CARGO_INCREMENTAL="1")
    os.utime(source)
    elapsed, processor, _ = run(build, target / "warm", CARGO_INCREMENTAL="1")
    rows += [f"| warm build of all tests after a change in bracketry-lie | {elapsed:.0f} s | {processor:.0f} s |"]


MEASURES = {"release": release, "wheel": wheel, "research": research, "tests": tests, "warm": warm}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--only", nargs="+", choices=MEASURES, default=list(MEASURES))
    options = parser.parse_args()
    rows, details = ["| what | elapsed | processor time |", "|---|---|---|"], []
    with tempfile.TemporaryDirectory(prefix="bracketry-build-") as folder:
        for name in options.only:
            before = len(rows)
            MEASURES[name](pathlib.Path(folder), rows, details)
            print("\n".join(rows[before:]), file=sys.stderr, flush=True)
    made = f"Made at commit {git('rev-parse', '--short=12', 'HEAD')} by `{' '.join(['python3 benches/build/measure.py', *sys.argv[1:]])}`, {os.cpu_count()} cores."
    tables = "\n".join([made, "", *rows, "", *details]).rstrip()
    print(tables)
    if options.record:
        text = RECORD.read_text()
        begin, end = "<!-- measured: begin -->", "<!-- measured: end -->"
        before, after = text[: text.index(begin) + len(begin)], text[text.index(end) :]
        RECORD.write_text(f"{before}\n{tables}\n{after}")


if __name__ == "__main__":
    main()
