"""Closed loops."""

import numpy as np
import pytest

from bracketry import BracketryError, System, control

PROBLEM = {
    "horizon": {"steps": 20, "dt": 0.1},
    "cost": {"stage": "x^2 + v^2 + 0.1*u^2", "terminal": "10*x^2 + 10*v^2"},
    "constraints": {"u": {"min": -1, "max": 1}},
    "run": {"x0": {"x": 1.0}, "steps": 60},
}


@pytest.fixture
def cart() -> System:
    return System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "u"})


def test_a_problem_as_mapping(cart) -> None:
    loop = control({"model": cart, **PROBLEM})
    assert loop.succeeded
    assert loop.states.shape == (61, 2) and loop.inputs.shape == (60, 1) and loop.t.shape == (61,)
    assert np.abs(loop.states[-1]).max() < 0.02
    assert loop["u"].min() >= -1.0 - 1e-6
    assert loop.constraint_violation_max < 1e-6
    assert loop.x_final["x"] == loop["x"][-1]
    assert loop.figure().name == "closed_loop"


def test_mapping_text_and_file_agree(cart, tmp_path, command, timeless) -> None:
    cart.save(tmp_path / "cart.toml")
    text = """
        model = "cart.toml"
        horizon = { steps = 20, dt = 0.1 }
        cost = { stage = "x^2 + v^2 + 0.1*u^2", terminal = "10*x^2 + 10*v^2" }
        constraints = { u = { min = -1, max = 1 } }
        run = { x0 = { x = 1.0 }, steps = 60 }
    """
    (tmp_path / "problem.toml").write_text(text)
    mapping = control({"model": cart, **PROBLEM})
    named = control(text, models={"cart.toml": cart})
    file = control(tmp_path / "problem.toml")
    assert np.array_equal(mapping.states, named.states)
    assert np.array_equal(mapping.states, file.states)
    assert timeless(file.json) == timeless(command("control", tmp_path / "problem.toml"))


def test_a_plant_of_its_own_and_a_seed(cart) -> None:
    plant = System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "0.5*u"})
    weaker, same = control({"model": cart, "plant": plant, **PROBLEM}), control({"model": cart, **PROBLEM})
    assert not np.array_equal(weaker.states, same.states)
    noisy = {"model": cart, **PROBLEM, "run": {"x0": {"x": 1.0}, "steps": 20, "noise": {"x": 0.01}}}
    one, same, other = (control(noisy, seed=s).states for s in (1, 1, 2))
    assert np.array_equal(one, same) and not np.array_equal(one, other)


@pytest.mark.parametrize(
    ("problem", "message"),
    [
        ("nowhere.toml", "nowhere.toml"),
        ("model = 'nowhere.toml'\n", "nowhere.toml"),
        ({"model": 3}, "model"),
        ({**PROBLEM, "model": "m", "horizon": {"steps": 0, "dt": 0.1}}, "m"),
        (3, "give a file"),
    ],
)
def test_what_is_no_problem_is_refused(problem, message) -> None:
    with pytest.raises(BracketryError, match=message):
        control(problem)


def test_an_error_names_place_and_remedy(cart) -> None:
    with pytest.raises(BracketryError, match=r"problem:\d+:\d+: .*(?s:.*)\^"):
        control({**PROBLEM, "model": cart, "cost": {"stage": "x^2 + q^2"}})


def test_a_plant_that_ends_early_warns() -> None:
    problem = {
        "model": System(states=["x"], inputs=["u"], dynamics={"x": "x^3 + u"}),
        "horizon": {"steps": 5, "dt": 0.1},
        "cost": {"stage": "x^2 + u^2"},
        "constraints": {"u": {"min": -1, "max": 1}},
        "run": {"x0": {"x": 3}, "steps": 5},
    }
    with pytest.warns(RuntimeWarning, match=r"ended early, at t = 0\.1"):
        loop = control(problem)
    assert not loop.succeeded and any("not finite" in note for note in loop.notes)
