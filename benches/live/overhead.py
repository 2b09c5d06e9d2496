#!/usr/bin/env python3
"""What stepping a controller costs on top of its own work, and whether it grows: `python benches/live/overhead.py [STEPS [PROFILE]]`.

Steps a double integrator by the real-time iteration from Python, from C, and over the pipe, and prints the median of the time around a
step less the time that the controller states for preparation and feedback, and the resident memory after a tenth of the steps and after
all; at last, the time of the same exchange with `cat`, which is the share of the peer and the pipe. Needs the package `bracketry` in
release (`MATURIN_PEP517_ARGS="--features native" pip install .`), without which its line is left out, a C compiler, and
`cargo build --release --features native` (or PROFILE `debug`).
"""
import array
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

try:
    import bracketry
except ImportError:
    bracketry = None

STEPS = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
ROOT = pathlib.Path(__file__).resolve().parents[2]
PROFILE = sys.argv[2] if len(sys.argv) > 2 else "release"
BUILT = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / PROFILE
MODEL = 'states = ["x", "v"]\ninputs = ["a"]\ndynamics = { x = "v", v = "a" }\n'
PROBLEM = """model = "mass.toml"
horizon = { steps = 10, dt = 0.1 }
cost = { stage = "(x - r)^2 + 0.1*v^2 + 0.01*a^2" }
references = { r = "sin(t)" }
constraints = { a = { min = -1, max = 1 } }
solve = { method = "rti" }
run = { x0 = { x = 1 } }
"""


def resident(pid: str = "self") -> float:
    """Resident memory of a process in MiB."""
    pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def loop(step, pid: str) -> tuple[list[float], list[float]]:
    """Overheads in µs, and the memory after a tenth of the steps and at the end."""
    # All of its memory from the start, so that it does not grow itself.
    overheads, memory, x, v = array.array("d", [0.0]) * STEPS, [], 1.0, 0.0
    for k in range(STEPS):
        start = time.perf_counter()
        a, own = step(x, v)
        overheads[k] = 1e6 * (time.perf_counter() - start - own)
        x, v = x + 0.1 * v + 0.005 * a, v + 0.1 * a
        if k + 1 in (STEPS // 10, STEPS):
            memory.append(resident(pid))
    return list(overheads), memory


def report(name: str, overheads: list[float], memory: list[float]) -> None:
    overheads.sort()
    print(
        f"{name:<8} overhead {statistics.median(overheads):6.1f} µs median, {overheads[int(0.99 * STEPS)]:6.1f} µs 99 %;"
        f" memory {memory[0]:.1f} MiB after {STEPS // 10} steps, {memory[1]:.1f} MiB after {STEPS}"
    )


def from_python(problem: pathlib.Path) -> None:
    controller = bracketry.Controller(problem)

    def step(x: float, v: float) -> tuple[float, float]:
        answer = controller.step([x, v])
        return float(answer.u[0]), answer.feedback_seconds + answer.prepare_seconds

    report("Python", *loop(step, "self"))


def exchange(pipe: subprocess.Popen, x: float, v: float) -> dict:
    """What a peer does at every sample."""
    pipe.stdin.write(json.dumps({"y": [x, v]}) + "\n")
    return json.loads(pipe.stdout.readline())


def over_the_pipe(problem: pathlib.Path) -> None:
    command = [BUILT / "bracketry", "control", problem, "--live"]
    pipe = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
    pipe.stdout.readline()

    def step(x: float, v: float) -> tuple[float, float]:
        answer = exchange(pipe, x, v)
        # Where the measurement follows at once, it waits for the preparation after the last answer.
        return answer["u"][0], 1e-3 * (answer["feedback_ms"] + answer["prepare_ms"])

    report("pipe", *loop(step, str(pipe.pid)))
    pipe.communicate('{"type": "end"}\n')


def to_an_echo() -> None:
    """What the peer and the pipe alone cost: the lines come back as they are, from `cat`."""
    pipe = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def step(x: float, v: float) -> tuple[float, float]:
        exchange(pipe, x, v)
        return 0.0, 0.0

    report("echo", *loop(step, str(pipe.pid)))
    pipe.communicate()


def from_c(problem: pathlib.Path) -> None:
    program = problem.parent / "loop"
    library = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-ldl", "-lm"]
    source = [pathlib.Path(__file__).with_name("loop.c"), BUILT / "deps/libbracketry_c.a"]
    subprocess.run(["cc", "-O2", "-I", ROOT / "crates/c/include", *source, *library, "-o", program], check=True)
    lines = subprocess.run([program, problem, str(STEPS)], check=True, capture_output=True, text=True).stdout.splitlines()
    pages = [int(line.split()[1]) for line in lines if line.startswith("memory")]
    overheads = [float(line) for line in lines if not line.startswith("memory")]
    report("C", overheads, [n * resource.getpagesize() / 2**20 for n in pages])


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        problem = pathlib.Path(folder) / "problem.toml"
        (problem.parent / "mass.toml").write_text(MODEL)
        problem.write_text(PROBLEM)
        if bracketry is not None:
            from_python(problem)
        from_c(problem)
        over_the_pipe(problem)
        to_an_echo()


if __name__ == "__main__":
    main()
