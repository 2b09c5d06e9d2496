"""Normal forms and decompositions."""

import bracketry
import pytest

JOINT = """
states = ["q", "w", "p", "v"]
inputs = ["u"]
parameters = { k = 100, g = 9.8 }
dynamics = { q = "w", w = "-g*sin(q) - k*(q - p)", p = "v", v = "u + k*(q - p)" }
outputs = { y = "p" }
point = {}
"""


def test_a_form_comes_with_its_change_and_feedback() -> None:
    system = bracketry.System.from_toml(JOINT)
    chain = bracketry.transform(system, "brunovsky")
    assert chain.found and chain.system is not None
    assert chain.system.states == ["z1", "z2", "z3", "z4"] and chain.coordinates["z1"] == "q"
    assert chain.inverse is not None and set(chain.inverse) == {"q", "w", "p", "v"} and "v1" in chain.feedback["u"]
    internal = bracketry.transform(system, "byrnes-isidori", outputs=["y"])
    assert internal.parts["zero_dynamics"].states == ["eta1", "eta2"]
    assert "v1" in internal.linearizing_feedback["u"]


def test_what_is_impossible_says_why() -> None:
    system = bracketry.System(states=["x", "y"], inputs=["u"], dynamics={"x": "u", "y": "-y"})
    result = bracketry.transform(system, "brunovsky")
    assert result.outcome == "impossible" and result.system is None and "do not reach all of the state" in str(result.reason)
    with pytest.raises(bracketry.BracketryError, match="did you mean"):
        bracketry.transform(system, "kalmann")
