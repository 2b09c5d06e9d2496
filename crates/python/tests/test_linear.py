"""Operating points and linear systems."""

import bracketry
import numpy as np
import pytest

PENDULUM = """
states = ["th", "w"]
inputs = ["u"]
parameters = { g = 9.81 }
dynamics = { th = "w", w = "u - g*sin(th)" }
outputs = { y = "th" }
"""


def test_an_operating_point_is_found_and_linearized() -> None:
    system = bracketry.System.from_toml(PENDULUM)
    point = bracketry.trim(system, fix={"th": 1}, free=["u"])
    assert point.found and point.exact and point["u"] == pytest.approx(9.81 * np.sin(1), abs=1e-13)
    linear = bracketry.linearize(point.system)
    assert linear.A[1, 0] == pytest.approx(-9.81 * np.cos(1), abs=1e-13)
    assert linear.B.tolist() == [[0.0], [1.0]] and linear.C.tolist() == [[1.0, 0.0]] and linear.D.tolist() == [[0.0]]
    assert isinstance(linear.regulator, bracketry.LinearGain) and linear.regulator.residual < 1e-12
    assert sorted(linear.files) == ["linear.jl", "linear.m", "linear.py"]


def test_without_an_operating_point_the_best_one_is_given() -> None:
    point = bracketry.trim(bracketry.System.from_toml(PENDULUM), fix={"th": 1})
    assert point.status == "not_found" and point.residual == pytest.approx(9.81 * np.sin(1), abs=1e-6)
    with pytest.raises(bracketry.BracketryError, match="no state or input"):
        bracketry.trim(bracketry.System.from_toml(PENDULUM), free=["v"])


def test_python_control_takes_the_system() -> None:
    pytest.importorskip("control")
    space = bracketry.linearize(bracketry.System.from_toml(PENDULUM)).state_space()
    assert space.nstates == 2 and space.state_labels == ["th", "w"]
