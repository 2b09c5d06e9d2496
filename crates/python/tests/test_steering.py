"""Inputs from one state to another."""

import bracketry
import numpy as np
import pytest

UNICYCLE = """
name = "unicycle"
states = ["x", "y", "th"]
inputs = ["s", "w"]
dynamics = { x = "s*cos(th)", y = "s*sin(th)", th = "w" }
"""


def test_a_unicycle_moves_sideways_and_the_simulation_agrees() -> None:
    system = bracketry.System.from_toml(UNICYCLE)
    found = bracketry.steer(system, {"y": 1}, {"x": 0})
    assert found.reached and found.method == "chained" and found.end_error is not None and found.end_error < 1e-6
    assert found.states["y"][-1] == pytest.approx(1, abs=1e-6)
    inputs = {name: (found.input_times, u) for name, u in found.inputs.items()}
    run = bracketry.simulate(system, found.duration, inputs=inputs, hold=found.hold)
    assert run["y"][-1] == pytest.approx(1, abs=1e-6) and run["x"][-1] == pytest.approx(0, abs=1e-6)
    assert "<svg" in found.figure("steering").svg and "<svg" in found.figure("path").svg


def test_what_no_input_moves_is_not_reached() -> None:
    stuck = bracketry.System.from_toml("states = ['x', 'y']\ninputs = ['u']\n[dynamics]\nx = 'u'\ny = '0'\n")
    found = bracketry.steer(stuck, "y=1")
    assert not found.reached and len(found.attempts) == 4
    with pytest.raises(bracketry.BracketryError, match="neither a state nor an input"):
        bracketry.steer(stuck, {"q": 1})
    with pytest.raises(bracketry.BracketryError, match="method"):
        bracketry.steer(stuck, "x=1", method="fast")  # type: ignore[arg-type]
    assert np.isfinite(found.t).all()
