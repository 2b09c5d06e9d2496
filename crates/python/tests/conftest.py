"""What the tests share: models of the repository, the command line where it was built, a slider with known friction."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bracketry import System

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def models() -> Path:
    """The model files of the repository."""
    return ROOT / "models"


def _binary() -> Path | None:
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    named = os.environ.get("BRACKETRY_BIN") or shutil.which("bracketry")
    places = [target / "release" / "bracketry", target / "debug" / "bracketry", *([Path(named)] if named else [])]
    built = [p for p in places if p.is_file()]
    # The one built last is that of the sources.
    return max(built, key=lambda p: p.stat().st_mtime) if built else None


@pytest.fixture
def command() -> Callable[..., Any]:
    """Runs `bracketry … --json` and gives its object."""
    binary = _binary()
    if binary is None:
        pytest.skip("the command line is not built")

    def run(*arguments: str | Path) -> Any:
        done = subprocess.run(
            [binary, *map(str, arguments), "--json"], capture_output=True, text=True, check=False, timeout=300
        )
        assert done.returncode in (0, 1), done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture
def slider() -> System:
    """A mass on a dry surface, pushed by a force."""
    return System(
        states=["x", "v"],
        inputs=["u"],
        dynamics={"x": "v", "v": "(u - mu*m*g*sign(v))/m"},
        parameters={"m": 1.2, "mu": 0.2, "g": {"value": 9.81, "unit": "m/s^2"}},
        outputs={"x": "x"},
        name="slider",
    )


#: What a clock measured, by its name in the JSON objects.
CLOCKS = ("seconds", "solve_ms", "wall_seconds", "times_real_time")


def seconds_and_timings(value: Any) -> Any:
    """The object without what a clock measured."""
    if isinstance(value, dict):
        return {k: seconds_and_timings(v) for k, v in value.items() if k not in CLOCKS}
    if isinstance(value, list):
        return [seconds_and_timings(v) for v in value]
    return value


@pytest.fixture
def timeless() -> Callable[[Any], Any]:
    """Removes what a clock measured."""
    return seconds_and_timings


@pytest.fixture
def noise() -> np.random.Generator:
    """A random stream that is the same in every run."""
    return np.random.default_rng(20240501)
