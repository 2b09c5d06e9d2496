#!/usr/bin/env python3
"""Time and memory of the command on large and hostile models: `python3 benches/limits/measure.py [--record] [--only WORD]`.

Each model is generated, and the command runs with a time limit. A row says what was answered, how long it took, and how much memory the
process took at most. `--record` writes docs/records/limits.md. Build the command first: `cargo build --release`.
"""

import argparse
import datetime
import os
import pathlib
import platform
import random
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COMMAND = ROOT / "target" / "release" / "bracketry"
LIMIT = 10


def model(states, inputs, rates, definitions=()):
    quoted = ", ".join(f'"{name}"' for name in states)
    text = [f"states = [{quoted}]", "inputs = [" + ", ".join(f'"{name}"' for name in inputs) + "]"]
    if definitions:
        text += ["[definitions]", *(f'{name} = "{value}"' for name, value in definitions)]
    return "\n".join([*text, "[dynamics]", *(f'{name} = "{rate}"' for name, rate in rates), ""])


def numbered(letter, n):
    return [f"{letter}{i}" for i in range(n)]


def chain(n, cubic):
    """Masses between springs; a force acts on the first."""

    def spring(stretch):
        return f"({stretch})" + (f" + ({stretch})^3" if cubic else "")

    rates = [(f"x{i}", f"v{i}") for i in range(n)]
    for i in range(n):
        before = f"-({spring(f'x{i} - x{i - 1}' if i else 'x0')})"
        after = f" + ({spring(f'x{i + 1} - x{i}')})" if i < n - 1 else ""
        rates.append((f"v{i}", before + after + (" + u" if i == 0 else "")))
    return model(numbered("x", n) + numbered("v", n), ["u"], rates)


def consensus(n):
    """Agents that follow neighbors on a ring and two others; one has an input."""
    draw = random.Random(n)
    rates = []
    for i in range(n):
        others = ({(i + 1) % n, (i - 1) % n} | {draw.randrange(n) for _ in range(2)}) - {i}
        rates.append((f"x{i}", " + ".join(f"(x{j} - x{i})" for j in sorted(others)) + (" + u" if i == 0 else "")))
    return model(numbered("x", n), ["u"], rates)


def network(n):
    """Linear, three random terms in each equation."""
    draw = random.Random(n)
    rates = []
    for i in range(n):
        terms = [f"{draw.randint(1, 9)}*x{draw.randrange(n)}" for _ in range(3)]
        rates.append((f"x{i}", " + ".join(terms) + (" + u" if i == 0 else "")))
    return model(numbered("x", n), ["u"], rates)


def dense(n):
    """Linear with rational entries, each rate with all states."""
    draw = random.Random(n)

    def rate():
        terms = [f"{draw.randint(-9, 9)}/{draw.randint(1, 9)}*x{j}" for j in range(n)]
        return " + ".join(terms) + f" + {draw.randint(1, 9)}*u"

    return model(numbered("x", n), ["u"], [(f"x{i}", rate()) for i in range(n)])


def quotients(n):
    """Each rate a quotient of polynomials in all states."""
    draw = random.Random(n)

    def sum_of_all():
        return " + ".join(f"{draw.randint(1, 9)}*x{j}" for j in range(n))

    rates = [(f"x{i}", f"({sum_of_all()})/(1 + ({sum_of_all()})^2) + {draw.randint(1, 9)}*u") for i in range(n)]
    return model(numbered("x", n), ["u"], rates)


def integrators(n):
    return model(numbered("x", n), ["u"], [(f"x{i}", f"x{i + 1}" if i < n - 1 else "u") for i in range(n)])


def ring_of_sines(n):
    rates = [(f"x{i}", f"sin(x{(i + 1) % n})" + (" + u" if i == 0 else "")) for i in range(n)]
    return model(numbered("x", n), ["u"], rates)


def sum_of_sines(n):
    total = " + ".join(f"sin(x{j})" for j in range(n))
    return model(numbered("x", n), ["u"], [("x0", total), *((f"x{i}", f"x{i - 1}") for i in range(1, n - 1)), (f"x{n - 1}", "u")])


def sines_of_inputs(n):
    return model(numbered("x", n), ["u"], [(f"x{i}", f"sin(x{i} + u)") for i in range(n)])


def oscillators(n):
    """Phases on a ring that attract each other; one has an input."""
    rates = []
    for i in range(n):
        pull = " + ".join(f"sin(x{j % n} - x{i})" for j in (i + 1, i - 1 + n))
        rates.append((f"x{i}", pull + (" + u" if i == 0 else "")))
    return model(numbered("x", n), ["u"], rates)


def bilinear(n):
    rates = [(f"x{i}", f"x{i}*u{i} + x{(i + 1) % n}*u{(i + 1) % n}") for i in range(n)]
    return model(numbered("x", n), numbered("u", n), rates)


def nested(n):
    """Definitions that use each other n deep, and double with each step when multiplied out."""
    definitions = [("d0", "x0"), *((f"d{i}", f"d{i - 1}*x{i} + x{i}") for i in range(1, n))]
    rates = [(f"x{i}", f"-x{i} + 0.1*d{i}" + (" + u" if i == 0 else "")) for i in range(n)]
    return model(numbered("x", n), ["u"], rates, definitions)


def arm(n):
    """A planar arm of n links of length and mass 1 with a torque at each joint, in the angles of the links: M(q) w' = r, solved by elimination."""
    mass = {(i, j): f"{2 * (n - max(i, j)) - 1}/2*cos(q{i} - q{j})" for i in range(n) for j in range(n) if i != j}
    mass |= {(i, i): f"{3 * (n - i) - 2}/3" for i in range(n)}
    definitions, m = [], {}
    for i in range(n):
        forces = [f"({2 * (n - max(i, j)) - 1}/2)*sin(q{i} - q{j})*w{j}^2" for j in range(n) if j != i]
        torque = f"u{i}" + (f" - u{i + 1}" if i < n - 1 else "")
        definitions.append((f"r{i}", f"{torque} - {' - '.join(forces)} - 9.81*{2 * (n - i) - 1}/2*cos(q{i})"))
        definitions += [(f"m{i}_{j}", mass[i, j]) for j in range(n)]
        m |= {(i, j): f"m{i}_{j}" for j in range(n)}
    r = {i: f"r{i}" for i in range(n)}
    for k in range(n):
        for i in range(k + 1, n):
            factor = f"f{i}_{k}"
            definitions.append((factor, f"{m[i, k]}/{m[k, k]}"))
            for j in range(k + 1, n):
                definitions.append((f"m{i}_{j}_{k}", f"{m[i, j]} - {factor}*{m[k, j]}"))
                m[i, j] = f"m{i}_{j}_{k}"
            definitions.append((f"r{i}_{k}", f"{r[i]} - {factor}*{r[k]}"))
            r[i] = f"r{i}_{k}"
    for k in reversed(range(n)):
        known = "".join(f" - {m[k, j]}*a{j}" for j in range(k + 1, n))
        definitions.append((f"a{k}", f"({r[k]}{known})/{m[k, k]}"))
    rates = [(f"q{i}", f"w{i}") for i in range(n)] + [(f"w{i}", f"a{i}") for i in range(n)]
    return model(numbered("q", n) + numbered("w", n), numbered("u", n), rates, definitions)


def power(exponent):
    return model(["x", "y"], ["u"], [("x", f"y^{exponent}"), ("y", "u - y")])


CASES = [
    *((f"chain of {n} masses, {kind}", "analyze", lambda n=n, kind=kind: chain(n, kind == "cubic")) for n in (40, 100, 300) for kind in ("linear", "cubic")),
    *((f"consensus of {n}", "analyze", lambda n=n: consensus(n)) for n in (40, 100, 300)),
    *((f"linear network of {n}", "analyze", lambda n=n: network(n)) for n in (40, 100, 300, 1000)),
    *((f"dense linear system of {n}", "analyze", lambda n=n: dense(n)) for n in (16, 60)),
    ("quotients of 16 states", "analyze", lambda: quotients(16)),
    *((f"chain of {n:,} integrators", "analyze", lambda n=n: integrators(n)) for n in (1000, 10_000, 100_000)),
    ("ring of 400 sines", "analyze", lambda: ring_of_sines(400)),
    *((f"ring of {n} oscillators", "analyze", lambda n=n: oscillators(n)) for n in (40, 100)),
    *((f"bilinear, {n} inputs", "analyze", lambda n=n: bilinear(n)) for n in (100, 700)),
    ("arm of six joints", "analyze", lambda: arm(6)),
    ("definitions 3000 deep", "analyze", lambda: nested(3000)),
    *((f"y^{exponent}", "analyze", lambda exponent=exponent: power(exponent)) for exponent in (1000, 10**9)),
    ("ring of 400 sines", "affinize", lambda: ring_of_sines(400)),
    ("sum of 400 sines", "affinize", lambda: sum_of_sines(400)),
    ("arm of six joints", "affinize", lambda: arm(6)),
    ("400 sines of an input", "affinize", lambda: sines_of_inputs(400)),
    ("chain of 100,000 integrators", "affinize", lambda: integrators(100_000)),
    *((f"chain of {n} masses, linear", "linearize", lambda n=n: chain(n, False)) for n in (40, 100)),
    ("dense linear system of 32", "linearize", lambda: dense(32)),
    ("definitions 300 deep", "certify", lambda: nested(300)),
    ("definitions 3000 deep", "certify", lambda: nested(3000)),
    ("chain of 40 masses, cubic", "certify", lambda: chain(40, True)),
    ("dense linear system of 60", "certify", lambda: dense(60)),
    ("y^1000000000", "certify", lambda: power(10**9)),
    ("chain of 40 masses, cubic", "trim", lambda: chain(40, True)),
    ("chain of 40 masses, linear", "transform --to brunovsky", lambda: chain(40, False)),
    ("definitions 300 deep", "transform --to brunovsky", lambda: nested(300)),
]


def answer(command, text, error):
    """What the report says, in a few words."""
    if "stopped" in error:
        return "stopped without a result"
    if command == "analyze":
        found = re.search(r"^  strongly accessible +(\d+|unknown)", text, re.MULTILINE)
        return "no report" if not found else "unknown" if found[1] == "unknown" else f"dimension {found[1]}"
    return "done" if not error.startswith("error") else error.splitlines()[0][:60]


def measure(command, text, folder):
    path = folder / "model.toml"
    path.write_text(text)
    name, *options = command.split()
    with open(folder / "out", "w+") as out, open(folder / "err", "w+") as err:
        start = time.perf_counter()
        process = subprocess.Popen([COMMAND, name, path, *options, "--time-limit", str(LIMIT)], stdout=out, stderr=err)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.perf_counter() - start
        out.seek(0)
        err.seek(0)
        found = answer(name, out.read(), err.read())
    megabytes = usage.ru_maxrss / (1024 if sys.platform != "darwin" else 1024**2)
    return found, process.returncode, seconds, megabytes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--record", action="store_true", help="write docs/records/limits.md")
    parser.add_argument("--only", help="only models or commands with this word")
    options = parser.parse_args()
    rows = ["| model | command | answer | exit code | time | peak memory |", "|---|---|---|---|---|---|"]
    print(*rows, sep="\n")
    with tempfile.TemporaryDirectory() as folder:
        for name, command, make in CASES:
            if options.only and options.only not in f"{name} {command}":
                continue
            found, code, seconds, megabytes = measure(command, make(), pathlib.Path(folder))
            rows.append(f"| {name} | `{command}` | {found} | {code} | {seconds:.2f} s | {megabytes:.0f} MB |")
            print(rows[-1], flush=True)
    if options.record:
        commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=ROOT, check=True, capture_output=True, text=True)
        text = f"""# Limits of time and memory

Large and hostile models, each with `--time-limit {LIMIT}`. `python3 benches/limits/measure.py --record` generates the models, runs the command, and
writes this table; dimensions are those that the inputs reach (strongly accessible).

Made at commit {commit.stdout.strip()} on {datetime.date.today()}, on {os.cpu_count()} cores ({platform.machine()}, {platform.system()}).

"""
        (ROOT / "docs" / "records" / "limits.md").write_text(text + "\n".join(rows) + f"""

What is not decided within the limit is reported as unknown, with exit code 1. A command whose work does not look at the time is ended: half the limit, and
at least five seconds, after it. A command whose process takes more than its memory limit is ended as well; by default, the limit is half the memory of
the machine.
""")


if __name__ == "__main__":
    main()
