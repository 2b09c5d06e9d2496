"""SymPy expressions in models."""

import math

import numpy as np
import pytest

from bracketry import BracketryError, System, analyze, simulate

sympy = pytest.importorskip("sympy")


def test_symbols_and_expressions() -> None:
    x, y, th, u1, u2, length = sympy.symbols("x y th u1 u2 L")
    car = System(
        states=[x, y, th],
        inputs=[u1, u2],
        dynamics={x: u1 * sympy.cos(th), y: u1 * sympy.sin(th), th: u1 * sympy.tan(u2) / length},
        parameters={length: sympy.Rational(3, 2)},
    )
    assert car.states == ["x", "y", "th"]
    assert car.parameters["L"].value == 1.5
    assert np.allclose(car.rhs([0, 0, 0.3], [2, 0.1]), [2 * math.cos(0.3), 2 * math.sin(0.3), 2 * math.tan(0.1) / 1.5])
    assert analyze(car).affine is False


def test_functions_of_time_and_derivatives_of_inputs() -> None:
    t = sympy.Symbol("t")
    x, v, w = (sympy.Function(name)(t) for name in "xvw")
    shaken = System(states=[x, v], inputs=[w], dynamics=sympy.Matrix([v, -x - 2 * w.diff(t, 2)]))
    assert shaken.states == ["x", "v"] and shaken.inputs == ["w"]
    assert shaken.input_derivatives == [("w", 2)]
    assert np.allclose(shaken.rhs([1, 2], [0], [3]), [2, -7])


def random_expressions() -> list:
    a, b, c = sympy.symbols("a b c")
    return [
        a - b - c,
        -(a - b) * (c - a),
        a / b / c,
        a / (b * c) ** 2,
        -a / (b + c),
        (a + b) ** (c / 2),
        2 ** (-a),
        (-a) ** 2,
        -(a**2),
        sympy.sqrt(a**2 + b**2) / sympy.sqrt(c),
        a ** sympy.Rational(-3, 2),
        sympy.Rational(-2, 3) * a + sympy.Rational(7, 5),
        sympy.Float("1.5e-7") * a - sympy.Float("2.25") * b,
        sympy.exp(-a / 2) + sympy.E * b + sympy.pi * c,
        sympy.Abs(a - b) + sympy.Max(a, b, c) - sympy.Min(a, 1),
        sympy.atan2(a, b) + sympy.asin(a / 10) + sympy.acos(b / 10) + sympy.atan(c),
        sympy.sinh(a) - sympy.cosh(b) * sympy.tanh(c),
        sympy.log(a) + sympy.sign(b - c),
        sympy.sec(a) + sympy.csc(b) - sympy.cot(c) / a,
        sympy.cos(a) ** 2 * sympy.sin(b) ** -1,
        (a - b) * (b - c) / ((c - a) * (a + 2)),
        a * (b - (c - (a - b))),
    ]


@pytest.mark.parametrize("expr", random_expressions(), ids=str)
def test_an_expression_keeps_its_value(expr) -> None:
    symbols = sympy.symbols("a b c")
    system = System(states=list(symbols), dynamics=[expr, 0, 0])
    for at in ([0.7, 1.3, 2.1], [1.9, 0.4, 0.8]):
        wanted = complex(expr.subs(dict(zip(symbols, at, strict=True))).evalf())
        assert wanted.imag == 0
        assert system.rhs(at)[0] == pytest.approx(wanted.real, rel=1e-13)


def test_inputs_and_points() -> None:
    x, u, t = sympy.symbols("x u t")
    system = System(states=[x], inputs=[u], dynamics={x: u}, point={x: sympy.pi / 3})
    assert system.point == {"x": math.pi / 3, "u": 0.0}
    run = simulate(system, 1.0, x0={x: sympy.Integer(0)}, inputs={u: sympy.cos(t)})
    assert run["x"][-1] == pytest.approx(math.sin(1.0), abs=1e-9)


@pytest.mark.parametrize(
    "text",
    ["besselj(0, x)", "Piecewise((x, x > 0), (0, True))", "Heaviside(x)", "I*x", "oo", "gamma(x)", "Integral(sin(x)/x, x)",
     "x > 1", "f(x, y)", "Derivative(f(x), x, 2)*Derivative(g(x, y), y)", "zoo", "floor(x)"],
)
def test_what_a_model_cannot_say_is_refused_by_name(text) -> None:
    with pytest.raises(BracketryError, match="cannot be used in a model|not defined|not an expression"):
        System(states=["x"], dynamics=[sympy.sympify(text)])


def test_sympy_is_not_imported_unless_it_is_used() -> None:
    import subprocess
    import sys

    code = (
        "import sys, bracketry as b; s = b.System(['x'], ['u'], ['u']); b.analyze(s); b.simulate(s, 1.0, inputs={'u': 1});"
        "assert not {'sympy', 'pandas', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
