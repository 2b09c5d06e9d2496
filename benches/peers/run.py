#!/usr/bin/env python3
"""Compares speed with SymPy, SymEngine and CasADi and writes the table in docs/speed.md.

    python3 benches/peers/run.py

makes a virtual environment in target/peers, installs the three from PyPI, builds our side in release mode and the
C code of CasADi with cc, runs everything one after the other and replaces what stands between the two marks in
docs/speed.md. `--python FILE` uses an interpreter that has the three already.
"""
import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BEGIN, END = "<!-- begin of the measured table -->", "<!-- end of the measured table -->"


def output(command, **options):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


def interpreter(target):
    python = target / "peers" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", target / "peers"], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "sympy", "symengine", "casadi", "numpy"], check=True)
    return python


def compiled(directory, name, flags):
    program = directory / f"{name}{len(flags)}"
    subprocess.run(["cc", *flags, directory / f"{name}.c", HERE / "driver.c", "-lm", "-o", program], check=True)
    return float(output([program]))


def ms(seconds):
    return f"{seconds * 1e3:.3g} ms"


def row(what, ours, peer, theirs, wanted=None):
    ratio = theirs / ours
    limit = f"{wanted:g}" if wanted else ""
    return f"| {what} | {ms(ours)} | {peer} | {ms(theirs)} | {ratio:.3g} | {limit} |", not wanted or ratio >= wanted


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
            wanted = 20 if k.startswith("sympy") else 2
            rows.append(row(f"{shape}; ours with rank {ours['rank']}, theirs without", ours["with_rank"], label[k],
                            seconds, wanted))
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
                     f"{end} | | |", not t["finished"]))
    rows.append((f"| generic rank of 20 trailers (23) | {ms(us['trailers_20']['seconds'])} | | | | |",
                 us["trailers_20"]["dimension"] == 23))
    assert abs(us["jacobian"]["sum"] - them["jacobian"]["sum"]) < 1e-9, "the same Jacobian"
    native = us["jacobian"]["native"]
    for (name, flags), ns in c_times.items():
        kind = "as generated" if name == "plain" else "after ca.cse"
        line = (f"| one call of the 6 × 7 Jacobian | {native * 1e9:.3g} ns | CasADi's C {kind}, cc {flags} | {ns:.3g} ns |"
                f" {ns / (native * 1e9):.3g} | {1 / 1.5:.2g} |")
        rows.append((line, native * 1e9 <= 1.5 * ns))
    by_hand = us["jacobian"]["by_hand"]
    rows.append((f"| | {native * 1e9:.3g} ns | written by hand in Rust | {by_hand * 1e9:.3g} ns |"
                 f" {by_hand / native:.3g} | |", True))
    versions = ", ".join(f"{k} {v}" for k, v in them["versions"].items())
    head = [
        f"{platform.machine()}, {cpu()}, {versions}, {output(['rustc', '--version']).strip()}, "
        f"{output(['cc', '--version']).splitlines()[0]}. Ratio: their time by ours.",
        "",
        "| work | ours | other | their time | ratio | wanted |",
        "|---|---|---|---|---|---|",
    ]
    return "\n".join(head + [r for r, _ in rows]), all(good for _, good in rows)


def cpu():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown processor"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", type=Path, help="interpreter with sympy, symengine and casadi")
    arguments = parser.parse_args()
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    python = arguments.python or interpreter(target)
    cargo = ["cargo", "bench", "-q", "--bench", "peers"]
    subprocess.run([*cargo, "--no-run"], check=True, cwd=ROOT)
    us = json.loads(output(cargo, cwd=ROOT))
    with tempfile.TemporaryDirectory() as scratch:
        directory = Path(scratch)
        them = json.loads(output([python, HERE / "peers.py", directory, str(us["trailers_10"]["seconds"])]))
        flags = [("-O3",), ("-O3", "-march=native")]
        c_times = {(n, " ".join(f)): compiled(directory, n, f) for n in ("plain", "merged") for f in flags}
    text, good = table(us, them, c_times)
    print(text)
    document = ROOT / "docs" / "speed.md"
    before, rest = document.read_text().split(BEGIN)
    _, after = rest.split(END)
    document.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}")
    if not good:
        sys.exit("a ratio is below what is wanted")


if __name__ == "__main__":
    main()
