"""Motion from rest to rest under dry friction."""

import pytest

import bracketry

TABLE = """
name = "table"
states = ["x", "v"]
inputs = ["X"]
[dynamics]
x = "v"
v = "-der(X,2) - 3*sign(v)"
"""


def test_the_table_moves_the_mass_beyond_its_friction():
    table = bracketry.System.from_toml(TABLE)
    no = bracketry.from_rest(table, {"der(X,2)": (-3, 3)})
    assert (no.answer, no.coordinates[0]["motion"]) == ("no", "never")
    yes = bracketry.from_rest(table, "der(X,2)=-4..4")
    assert (yes.answer, yes.proof, yes.margin) == ("yes", "proven", 1.0)
    with pytest.raises(bracketry.BracketryError, match="is not bounded"):
        bracketry.from_rest(table)


def test_the_map_finds_the_threshold():
    table = bracketry.System.from_toml(TABLE)
    found = bracketry.from_rest_map(table, {"der(X,2)": (2, 4), "X": (0.1, 1)}, cells=3)
    (threshold,) = found.thresholds
    assert threshold["no_up_to"] == pytest.approx(3, abs=1e-6)
    assert found.cells[0][0][0]["answer"] == "no"
    assert found.cells[2][2][0]["answer"] == "yes"


def test_loops_steer_from_rest_to_rest():
    table = bracketry.System.from_toml(TABLE)
    found = bracketry.steer(table, {"x": 0.02}, method="loops", bounds={"der(X,2)": (-5, 5)})
    assert found.reached
    assert found.states["x"][-1] == pytest.approx(0.02, abs=1e-6)
