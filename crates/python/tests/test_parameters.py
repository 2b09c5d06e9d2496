"""Cases of parameters, maps, and identifiability."""

import bracketry
import pytest

TANKS = """
states = ["x", "y"]
inputs = ["u"]
parameters = { a = 1, b = 2 }
dynamics = { x = "u - a*x", y = "u - b*y" }
outputs = { h = "y" }
"""

CHAIN = """
states = ["a", "b"]
parameters = { k1 = 1, k2 = 2 }
dynamics = { a = "-k1*a", b = "k1*a - k2*b" }
outputs = { y = "b" }
"""


def test_special_values_are_listed() -> None:
    report = bracketry.parameter_cases(bracketry.System.from_toml(TANKS))
    case = report["strong_accessibility"]["cases"][0]
    assert case["conditions"] == ["a - b"] and case["value"] == {"dimension": 1}
    assert report.complete and "a - b = 0: 1 of 2" in str(report)
    fixed = bracketry.parameter_cases(bracketry.System.from_toml(TANKS), ["a"])
    assert fixed.fixed == {"b": "2"} and fixed["strong_accessibility"]["cases"][0]["conditions"] == ["a - 2"]
    with pytest.raises(bracketry.BracketryError, match="no parameter `c`"):
        bracketry.parameter_cases(bracketry.System.from_toml(TANKS), ["c"])


def test_a_map_has_cells_curves_and_a_figure() -> None:
    found = bracketry.parameter_map(bracketry.System.from_toml(TANKS), {"a": (-1, 1), "b": (-2, 2)}, cells=4)
    cell = found.cells[0][0]
    assert cell is not None and cell["unstable"] == 2 and found.cells[3][3] == {**cell, "unstable": 0}
    assert [c["condition"] for c in found.curves] == ["a - b"]
    assert "a - b = 0" in found.figure("map").svg


def test_identifiability() -> None:
    system = bracketry.System.from_toml(CHAIN)
    report = bracketry.identifiability(system)
    assert report.parameters["k1"] == {"local": True, "global": False, "values": 2}
    assert report.other_solution["k1"] == "k2"
    known = bracketry.identifiability(system, known_initial=["a", "b"])
    assert known.parameters["k1"]["global"] is True
    special = bracketry.identifiability(system, known_initial={"a": 0, "b": None})
    assert special.parameters["k1"]["local"] is None
