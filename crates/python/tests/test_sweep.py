"""Many runs at once: the same numbers whoever works."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from bracketry import BracketryError, System, diagnose, simulate, sweep

PENDULUM = System(
    states=["th", "w"],
    inputs=["u"],
    dynamics={"th": "w", "w": "-g/l*sin(th) - d*w + u"},
    parameters={"g": 9.81, "l": 1.0, "d": {"value": 0.1, "min": 0}},
)


def last_angle(damping: float, stream: np.random.Generator) -> float:
    """The angle after two seconds from a random start."""
    run = simulate(PENDULUM, 2.0, x0={"th": stream.uniform(-1, 1)}, parameters={"d": damping})
    return float(run["th"][-1])


def whole_run(damping: float):
    """A result as a whole."""
    return simulate(PENDULUM, 1.0, x0={"th": 1.0}, parameters={"d": damping})


def diagnosed(_: int) -> str:
    """Work on all threads of a process."""
    run = simulate(PENDULUM, 5.0, x0={"th": 0.5}, inputs={"u": "2*sin(3*t)"}, sample=0.01)
    return str(diagnose(PENDULUM, run).verdict)


CASES = [0.0, 0.05, 0.1, 0.2]


def test_executors_agree() -> None:
    alone = sweep(last_angle, CASES, seed=7)
    assert len(set(alone)) == len(CASES)
    with ThreadPoolExecutor(2) as threads:
        assert sweep(last_angle, CASES, executor=threads, seed=7) == alone
    with ProcessPoolExecutor(2) as processes:
        assert sweep(last_angle, CASES, executor=processes, seed=7) == alone
    assert sweep(last_angle, CASES, seed=8) != alone


def test_a_case_keeps_its_stream() -> None:
    """More cases change nothing about the first ones."""
    assert sweep(last_angle, CASES[:2], seed=7) == sweep(last_angle, CASES, seed=7)[:2]


def test_results_travel_between_processes() -> None:
    with ProcessPoolExecutor(2) as processes:
        runs = sweep(whole_run, CASES, executor=processes)
    for run, damping in zip(runs, CASES, strict=True):
        assert np.array_equal(run.states, whole_run(damping).states)


def test_a_forked_process_has_threads_of_its_own() -> None:
    """A diagnosis before the fork must not leave one after it waiting for threads that are not there."""
    before = diagnosed(0)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as processes:
        assert processes.submit(diagnosed, 0).result(timeout=60) == before


def test_errors_are_raised_or_kept() -> None:
    with pytest.raises(BracketryError, match="lies outside"):
        sweep(whole_run, [0.1, -1.0])
    kept = sweep(whole_run, [0.1, -1.0, 0.2], errors="keep")
    assert isinstance(kept[1], BracketryError) and "lies outside" in str(kept[1])
    assert kept[0].finished and kept[2].finished
    with ProcessPoolExecutor(1) as processes, pytest.raises(BracketryError, match="lies outside"):
        sweep(whole_run, [-1.0], executor=processes)
