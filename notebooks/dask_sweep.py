"""The same Monte Carlo sweep in this process, on a pool of processes and on a local Dask cluster: the same numbers.

    pip install 'dask[distributed]'
    python notebooks/dask_sweep.py
"""

import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from dask.distributed import Client, LocalCluster

from bracketry import System, simulate, sweep

BLOCK = System(
    name="block on a shaken table",
    states=["x", "v"],
    inputs=["a"],
    dynamics={"x": "v", "v": "-a - mu*g*sign(v)"},
    parameters={"mu": 0.2, "g": 9.81},
)


def drift(friction: float, stream: np.random.Generator) -> float:
    """How far the block has slipped after ten seconds of random shaking."""
    phases = stream.uniform(0, 2 * np.pi, 5)
    shaking = " + ".join(f"0.9*sin({2 + 3 * k}*t + {phase!r})" for k, phase in enumerate(phases.tolist()))
    return float(simulate(BLOCK, 10.0, inputs={"a": shaking}, parameters={"mu": friction}).x_final["x"])


def main() -> None:
    """Runs the sweep three times."""
    cases = np.linspace(0.02, 0.25, 200).tolist()
    results = {}

    def timed(name, executor) -> None:
        begin = time.perf_counter()
        results[name] = sweep(drift, cases, executor=executor, seed=1)
        print(f"{name:>8}: {time.perf_counter() - begin:.2f} s, first {results[name][0]:.9f} m, last {results[name][-1]:.9f} m")

    timed("alone", None)
    with ProcessPoolExecutor(2) as processes:
        timed("process", processes)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        timed("Dask", client)
    if not results["alone"] == results["process"] == results["Dask"]:
        raise SystemExit("the results differ")
    print("the results are the same to the last bit")


if __name__ == "__main__":
    main()
