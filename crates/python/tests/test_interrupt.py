"""Ctrl-C ends long work, and the work really stops."""

import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest

from bracketry import System, simulate

COMMON = """
import os, signal, threading, time, numpy as np, bracketry
# A process that was started in the background of a shell ignores interrupts until it is told otherwise.
signal.signal(signal.SIGINT, signal.default_int_handler)
from bracketry import System, analyze, control, diagnose, simulate
def busy():
    "Processor time per second of the process."
    a = time.process_time(); time.sleep(0.5); return (time.process_time() - a) / 0.5
"""

WORK = {
    "simulate": """
        s = System(["x", "v"], ["u"], ["v", "-1e4*x + u"])
        work = lambda: simulate(s, 1e5, inputs={"u": "sin(50*t)"}, sample=1.0)
    """,
    "control": """
        s = System(["x", "v"], ["u"], ["v", "u - sin(x)"])
        work = lambda: control({"model": s, "horizon": {"steps": 60, "dt": 0.05}, "cost": {"stage": "x^2 + v^2 + u^2"},
                                "run": {"x0": {"x": 1.0}, "steps": 1000000}})
    """,
    "diagnose": """
        s = System(["x", "v", "y", "w"], ["u"], ["v", "u - k*x^3 - c*v*abs(y) - f*sign(v)", "w", "x - y - d*w - f*sign(w)"],
                   parameters={"k": 1, "c": 0.2, "f": 0.1, "d": 0.3})
        t = np.arange(0, 400, 0.01)
        rng = np.random.default_rng(1)
        columns = {"t": t, "u": np.sin(t) + np.sin(2.7 * t), "x": np.cumsum(rng.normal(size=t.size)) * 1e-2,
                   "y": np.cumsum(rng.normal(size=t.size)) * 1e-2}
        work = lambda: diagnose(s, columns)
    """,
    "plate": """
        work = lambda: bracketry.plate.run(1, model="area", seconds=5000.0, sample=0.02)
    """,
}


@pytest.mark.parametrize("name", WORK)
def test_an_interrupt_is_raised_and_the_work_ends(name: str) -> None:
    program = COMMON + textwrap.dedent(WORK[name]) + textwrap.dedent("""
        print("begin", flush=True)
        try:
            work()
            print("finished", flush=True)
        except KeyboardInterrupt:
            print("interrupted", busy() < 0.5, flush=True)
    """)
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "begin"
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        try:
            out, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    assert out.strip() == "interrupted True"


def test_other_threads_run_meanwhile() -> None:
    """The interpreter is free while the library works."""
    system = System(states=["x", "v"], dynamics=["v", "-1e4*x"])
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    simulate(system, 20.0, x0={"x": 1.0})
    done.set()
    other.join()
    assert counted > 5
