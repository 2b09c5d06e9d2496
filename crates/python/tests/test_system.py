"""Models from Python objects."""

import pickle

import numpy as np
import pytest

import bracketry
from bracketry import BracketryError, System


@pytest.fixture
def unicycle() -> System:
    return System(
        states=["x", "y", "th"],
        inputs=["u1", "u2"],
        dynamics={"x": "u1*cos(th)", "y": "u1*sin(th)", "th": "u2"},
        point={"x": 0},
        name="unicycle",
    )


def test_names_and_equations(unicycle: System) -> None:
    assert unicycle.name == "unicycle"
    assert unicycle.states == ["x", "y", "th"]
    assert unicycle.inputs == ["u1", "u2"]
    assert unicycle.equations["y"] == "u1*sin(th)"
    assert "x' = u1*cos(th)" in str(unicycle)
    assert r"\dot{x} &= u_{1} \cos" in unicycle._repr_latex_()


def test_the_text_of_a_model_gives_the_same_model(unicycle: System) -> None:
    again = System.from_toml(unicycle.to_toml())
    assert again.to_toml() == unicycle.to_toml()
    assert again.name == "unicycle"


def test_pickling_keeps_text_and_name(unicycle: System) -> None:
    copy = pickle.loads(pickle.dumps(unicycle))
    assert copy.to_toml() == unicycle.to_toml()


def test_rates_and_jacobians_over_arrays(unicycle: System) -> None:
    x = np.linspace(-1, 1, 30).reshape(2, 5, 3)
    u = np.array([2.0, 0.5])
    rates = unicycle.rhs(x, u)
    assert rates.shape == (2, 5, 3)
    th = x[..., 2]
    assert np.allclose(rates, np.stack([2 * np.cos(th), 2 * np.sin(th), np.full_like(th, 0.5)], axis=-1), atol=1e-15)
    a, b = unicycle.jacobians(x, u)
    assert a.shape == (2, 5, 3, 3) and b.shape == (2, 5, 3, 2)
    assert np.allclose(a[..., 0, 2], -2 * np.sin(th), atol=1e-15)
    assert np.allclose(b[..., 1, 0], np.sin(th), atol=1e-15)
    assert np.count_nonzero(a[..., :, :2]) == 0


def test_a_wrong_shape_is_named(unicycle: System) -> None:
    with pytest.raises(BracketryError, match=r"x has the shape \(2,\); its last axis must have length 3"):
        unicycle.rhs([1.0, 2.0])
    with pytest.raises(BracketryError, match="do not match"):
        unicycle.rhs(np.zeros((4, 3)), np.zeros((5, 2)))


def test_parameters_with_units_and_limits() -> None:
    system = System(
        states=["v"],
        inputs=["u"],
        dynamics={"v": "(u - c*v)/m"},
        parameters={"m": 2, "c": {"value": 0.1, "unit": "N s/m", "min": 0, "max": 1}},
    )
    assert system.parameters["m"].value == 2.0
    assert system.parameters["c"] == bracketry.Parameter(0.1, "N s/m", 0.0, 1.0)
    heavier = system.with_parameters(m=4.0)
    assert heavier.rhs([0.0], [1.0]) == 0.25
    assert system.rhs([0.0], [1.0]) == 0.5
    with pytest.raises(BracketryError, match="max"):
        system.with_parameters(c=3.0)
    with pytest.raises(BracketryError, match="no parameter `k`; it has m, c"):
        system.with_parameters(k=3.0)


def test_an_error_has_place_and_remedy() -> None:
    with pytest.raises(BracketryError) as error:
        System.from_toml('states = ["x"]\n[dynamics]\nx = "x + *2"\n', name="broken.toml")
    message = str(error.value)
    assert "broken.toml:3:" in message
    assert "^" in message
    assert isinstance(error.value, ValueError)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"states": "x", "dynamics": {"x": "1"}}, "give a list"),
        ({"states": ["x"], "dynamics": ["1", "2"]}, "2 expressions for 1 states"),
        ({"states": ["x"], "dynamics": {"x": "y"}}, "unknown name"),
        ({"states": ["x"], "dynamics": {"x": "1"}, "parameters": {"p": float("nan")}}, "finite"),
        ({"states": ["x"], "dynamics": {"x": "1"}, "parameters": {"p": "1/3"}}, "is not a number"),
        ({"states": ["x"], "dynamics": {"x": object()}}, "is not an expression"),
        ({"states": ["x"], "dynamics": {"x": True}}, "is not an expression"),
        ({"states": ["x"], "inputs": ["u"], "dynamics": {"x": "u"}, "ranges": {"u": 3}}, "give a pair"),
        ({"states": ["x"], "dynamics": {}}, "no equations"),
        ({"states": [], "dynamics": {}}, "no states"),
    ],
)
def test_what_is_no_model_is_refused(arguments: dict, message: str) -> None:
    with pytest.raises(BracketryError, match=message):
        System(**arguments)


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(BracketryError, match="nowhere.toml"):
        System.from_file("nowhere.toml")


def test_units_stand_where_the_model_states_them() -> None:
    tank = System(
        states=["V"],
        inputs=["F"],
        dynamics={"V": "F"},
        units={"V": "L", "F": "L/h"},
        labels={"V": "volume"},
        time_unit="h",
    )
    assert tank.units == {"V": "L", "F": "L/h"}
    assert tank.time_unit == "h"
    again = System.from_toml(tank.to_toml())
    assert (again.units, again.time_unit) == (tank.units, "h")
    run = bracketry.simulate(tank, duration=2.0, inputs={"F": 1.0})
    assert run.titles == {"t": "t [h]", "V": "volume V [L]", "F": "F [L/h]"}
    with pytest.raises(BracketryError, match="not a unit of time"):
        System(states=["x"], dynamics={"x": "x"}, time_unit="hour")
