"""Causes of what a model gets wrong, from data with known faults."""

import pickle

import numpy as np
import pytest

from bracketry import BracketryError, System, diagnose, simulate


@pytest.fixture
def measured(slider, noise):
    """A run of the slider with viscous friction that its model lacks, as a table, with noise of 20 µm."""
    true = System(
        states=["x", "v"],
        inputs=["u"],
        dynamics={"x": "v", "v": "(u - mu*m*g*sign(v) - c*v)/m"},
        parameters={"m": 1.2, "mu": 0.2, "g": 9.81, "c": 0.8},
    )

    def run(amplitude: float) -> dict[str, np.ndarray]:
        push = f"{amplitude}*(sin(2*pi*0.4*t) + 0.6*sin(2*pi*1.1*t + 1))"
        motion = simulate(true, 10.0, inputs={"u": push}, sample=0.01)
        x = motion["x"] + 2e-5 * noise.standard_normal(len(motion))
        return {"t": motion.t, "u": motion["u"], "x": x}

    return [run(5.0), run(6.0)]


@pytest.fixture
def diagnosis(slider, measured):
    return diagnose(slider, measured[0], measured[1], threads=2)


def test_the_cause_is_named(diagnosis) -> None:
    assert diagnosis.verdict == "cause_found"
    cause = diagnosis.causes[0]
    assert cause.name == "viscous_friction" and cause.equation == "v"
    assert diagnosis.gain is not None and diagnosis.gain.held_out
    assert all(after < before for before, after in zip(diagnosis.gain.before, diagnosis.gain.after, strict=True))
    assert diagnosis.extended_model is not None
    assert diagnosis.extended_model.states == ["x", "v"]
    assert "viscous" in str(diagnosis)
    assert diagnosis.page().lstrip().lower().startswith("<!doctype html")
    assert diagnosis.figure_names and diagnosis.figure().svg.startswith("<svg")
    copy = pickle.loads(pickle.dumps(diagnosis))
    assert copy.causes == diagnosis.causes
    at = ([0.1, 0.2], [1.0])
    assert copy.extended_model.rhs(*at) == pytest.approx(diagnosis.extended_model.rhs(*at), rel=1e-14)
    with pytest.raises(BracketryError, match="does not travel"):
        copy.page()


def test_numbers_are_those_of_the_command_line(slider, measured, tmp_path, command, timeless) -> None:
    slider.save(tmp_path / "slider.toml")
    for k, run in enumerate(measured):
        columns = np.column_stack(list(run.values()))
        rows = "\n".join(",".join(map(repr, row)) for row in columns.tolist())
        (tmp_path / f"run{k}.csv").write_text("t,u,x\n" + rows + "\n")
    system = System.from_file(tmp_path / "slider.toml")
    found = diagnose(system, tmp_path / "run0.csv", tmp_path / "run1.csv", threads=1)
    line = command("diagnose", tmp_path / "slider.toml", tmp_path / "run0.csv", "--validate", tmp_path / "run1.csv")
    assert timeless(found.json) == timeless(line)
    # In memory runs have other names; all else is the same.
    memory = diagnose(system, measured[0], measured[1], threads=2)
    assert memory.causes == found.causes and memory.gain == found.gain


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("nowhere.csv", "nowhere.csv"),
        ({"u": [0.0, 1.0], "x": [0.0, 1.0]}, "no column `t`"),
        ({"t": [0.0, 1.0], "x": [0.0, 1.0]}, "u"),
        ({"t": [0.0, 1.0], "u": [0.0, 1.0]}, "x"),
        ({"t": [0.0, 1.0, 2.0], "u": [0.0, 1.0], "x": [0.0, 1.0]}, "2 entries for 3 times"),
        ({"t": ["a", "b"], "u": [0.0, 1.0], "x": [0.0, 1.0]}, "not an array of numbers"),
        (3.0, "is not a table"),
        ([], "no data"),
    ],
)
def test_data_that_do_not_fit_are_refused(slider, data, message) -> None:
    with pytest.raises(BracketryError, match=message):
        diagnose(slider, data)


def test_a_trajectory_stands_for_its_inputs_and_outputs() -> None:
    """Also where an output is a state by another name: a sensor gives one of them."""
    system = System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "u - 0.5*v"}, outputs={"place": "x"})
    t = np.arange(0, 6, 0.01)
    run = simulate(system, inputs={"t": t, "u": np.sin(2 * t) + 0.5 * np.sin(5 * t)}, hold="linear")
    assert set(run.measurements()) == {"t", "u", "place"}
    assert "place  from" in diagnose(system, run, hold="linear").text
    stateful = System(states=["x"], dynamics={"x": "-x"})
    assert set(simulate(stateful, 1.0, x0=[1.0]).measurements()) == {"t", "x"}
