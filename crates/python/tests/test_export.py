"""Models as source code."""

import bracketry
import numpy as np
import pytest
from pathlib import Path

CART = """
name = "cart"
states = ["x", "v"]
inputs = ["u"]
parameters = { m = 2, c = 0.4 }
dynamics = { x = "v", v = "(u - c*sign(v) - sin(x))/m" }
outputs = { y = "x^2" }
"""


def test_the_python_module_computes_what_the_system_computes() -> None:
    system = bracketry.System.from_toml(CART)
    made = system.export("python", parameters=["m"])
    assert made.name == "cart" and list(made.files) == ["cart.py"] and made.parameters[0]["value"] == 2.0
    module = made.module()
    x, u = np.array([0.3, -0.7]), np.array([1.1])
    np.testing.assert_allclose(module.f(0.0, x, u), system.rhs(x, u), rtol=1e-14)
    np.testing.assert_allclose(module.h(0.0, x, u), system.output_values(x, u), rtol=1e-14)
    for got, expected in zip(module.f_jacobian(0.0, x, u), system.jacobians(x, u), strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-14)
    heavy = system.with_parameters(m=5)
    np.testing.assert_allclose(module.f(0.0, x, u, [5.0]), heavy.rhs(x, u), rtol=1e-14)
    assert "sign(v)" in made.notes[0]["text"] and "sign(v)" in made.text and "sign(v)" in made.source


def test_every_language_writes_its_files(tmp_path: Path) -> None:
    system = bracketry.System.from_toml(CART)
    names = {
        "c": ["arm.h", "arm.c"],
        "rust": ["arm.rs"],
        "python": ["arm.py"],
        "casadi": ["arm_casadi.py"],
        "julia": ["Arm.jl"],
    }
    for language, files in names.items():
        made = system.export(language, parameters="all", name="arm")
        assert [p.name for p in made.write(tmp_path / language)] == files
        assert (tmp_path / language / files[-1]).read_text(encoding="utf-8") == made.files[files[-1]]
        assert [p["name"] for p in made.parameters] == ["m", "c"]


def test_casadi_functions_where_casadi_is_installed() -> None:
    pytest.importorskip("casadi")
    system = bracketry.System.from_toml(CART)
    functions = system.export("casadi").module().functions()
    got = np.array(functions["f"](0.0, [0.3, -0.7], [1.1])).ravel()
    np.testing.assert_allclose(got, system.rhs([0.3, -0.7], [1.1]), rtol=1e-14)


def test_bad_requests_have_a_remedy() -> None:
    system = bracketry.System.from_toml(CART)
    with pytest.raises(bracketry.BracketryError, match="write one of c, rust, python, casadi, julia"):
        system.export("matlab")
    with pytest.raises(bracketry.BracketryError, match="did you mean `m`"):
        system.export("c", parameters=["M"])
    with pytest.raises(bracketry.BracketryError, match="is not run here"):
        system.export("c").module()
