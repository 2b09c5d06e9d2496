"""Trajectories."""

import pickle

import numpy as np
import pytest

from bracketry import BracketryError, System, simulate


@pytest.fixture
def oscillator() -> System:
    return System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "-x + u"}, outputs={"energy": "(x^2 + v^2)/2"})


def test_against_the_exact_solution(oscillator) -> None:
    run = simulate(oscillator, 10.0, x0={"x": 1})
    assert run.t.shape == (1001,)
    assert run.states.shape == (1001, 2) and run.inputs.shape == (1001, 1) and run.outputs.shape == (1001, 1)
    assert run.states.dtype == np.float64
    assert np.allclose(run["x"], np.cos(run.t), atol=1e-7)
    assert np.allclose(run["energy"], 0.5, atol=1e-7)
    assert run.finished and run.events == []
    assert run.inputs_at_zero == ["u"]


def test_inputs_of_all_kinds_agree(oscillator) -> None:
    """A constant input of 2, given in five ways."""
    t = np.array([0.0, 5.0])
    two = np.array([2.0, 2.0])
    ways = [{"u": "2"}, {"u": 2}, {"u": (t, two)}, {"u": lambda t: 2.0}, {"t": t, "u": two}]
    ends = [simulate(oscillator, 5.0, inputs=way, sample=0.1).states[-1] for way in ways]
    exact = [2 - 2 * np.cos(5.0), 2 * np.sin(5.0)]
    for end in ends:
        assert np.allclose(end, exact, atol=1e-8)


def test_an_initial_state_as_array(oscillator) -> None:
    assert np.array_equal(simulate(oscillator, 1.0, x0=[1, 2]).states[0], [1.0, 2.0])
    with pytest.raises(BracketryError, match="x0 has 3 entries"):
        simulate(oscillator, 1.0, x0=[1, 2, 3])


def test_stick_and_slip_are_events(slider) -> None:
    """A push of 3 N against 2.35 N of friction for one second: the mass slides, comes to rest and sticks."""
    run = simulate(slider, 2.0, inputs={"u": (np.array([0.0, 1.0]), np.array([3.0, 0.0]))})
    assert [(e.from_mode, e.to_mode) for e in run.events] == [("stick", "+1"), ("+1", "stick")]
    assert run.events[0].switch == "v"
    a = 3 / 1.2 - 0.2 * 9.81
    assert run.events[1].t == pytest.approx(1 + a / (0.2 * 9.81), abs=1e-9)
    assert run["v"][-1] == 0.0


def test_numbers_are_those_of_the_command_line(models, command, tmp_path) -> None:
    model, scenario = models / "plate_published.toml", models / "plate_experiment_2.toml"
    run = simulate(System.from_file(model), scenario=scenario)
    assert run.json == command("simulate", model, "--scenario", scenario, "--out", tmp_path)
    table = np.genfromtxt(tmp_path / "trajectory.csv", delimiter=",", names=True, deletechars="")
    for name in ("t", "x", "phi", "vx", "X"):
        assert np.array_equal(run[name], table[name]), name


def test_a_table_in_a_file_and_in_memory(oscillator, tmp_path, command) -> None:
    t = np.arange(0, 3, 0.01)
    u = np.sin(3 * t)
    memory = simulate(oscillator, inputs={"t": t, "u": u, "other": u}, hold="linear")
    assert memory.ignored_columns == ["other"]
    rows = "\n".join(f"{a!r},{b!r}" for a, b in zip(t.tolist(), u.tolist(), strict=True))
    (tmp_path / "u.csv").write_text(f"t,u\n{rows}\n")
    file = simulate(oscillator, inputs=tmp_path / "u.csv", hold="linear")
    assert np.array_equal(memory.states, file.states)
    oscillator.save(tmp_path / "model.toml")
    line = command("simulate", tmp_path / "model.toml", "--inputs", tmp_path / "u.csv", "--hold", "linear")
    assert line["x_final"] == file.x_final
    longer = simulate(oscillator, 4.0, inputs=tmp_path / "u.csv", x0={"x": 1}, sample=0.5)
    assert longer.t[-1] == 4.0 and longer["x"][0] == 1.0


def test_parameters_replace_those_of_the_model(slider) -> None:
    icy = simulate(slider, 1.0, inputs={"u": 1.0}, parameters={"mu": 0})
    assert icy["x"][-1] == pytest.approx(0.5 / 1.2, abs=1e-9)
    assert simulate(slider, 1.0, inputs={"u": 1.0})["x"][-1] == 0.0


def test_what_a_derivative_of_an_input_needs(models) -> None:
    plate = System.from_file(models / "plate_published.toml")
    assert plate.input_derivatives
    t = np.linspace(0, 1, 101)
    table = {"t": t, "theta": 0.1 * np.sin(t), "der(theta,2)": -0.1 * np.sin(t), "der(X, 2)": np.cos(t)}
    run = simulate(plate, inputs=table)
    assert run.finished and run.ignored_columns == []
    assert np.isnan(run["X"]).all()
    assert "X" not in run.columns()


def test_blow_up_is_a_result() -> None:
    with pytest.warns(RuntimeWarning, match="ended early: .*t = 1 s"):
        run = simulate(System(states=["x"], dynamics={"x": "x^2"}), 2.0, x0={"x": 1})
    assert not run.finished
    assert run.stopped is not None and "stopped at t = 1 s" in run.stopped
    assert run.t[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "how long"),
        ({"duration": -1}, "must be positive"),
        ({"duration": 1, "x0": {"q": 0}}, "unknown key `q`"),
        ({"duration": 1, "inputs": {"w": 1}}, "unknown key `w`"),
        ({"duration": 1, "inputs": {"w": ([0, 1], [0, 1])}}, "no input `w`"),
        ({"duration": 1, "inputs": {"u": "sin(q)"}}, "unknown name"),
        ({"duration": 1, "inputs": {"u": ([0, 0], [0, 1])}}, "the time does not increase"),
        ({"duration": 1, "inputs": {"u": ([0, 1], [0, np.nan])}}, "not a finite number"),
        ({"duration": 1, "inputs": {"u": ([0, 1], [[0], [1]])}}, "one-dimensional"),
        ({"inputs": {"t": [0.0, 1.0], "z": [1.0, 2.0]}}, "no column has the name of an input"),
        ({"duration": 1, "parameters": {"k": 1}}, "unknown key `k`"),
        ({"duration": 1, "hold": "cubic"}, "previous"),
        ({"duration": 1, "rtol": 0.0}, "rtol"),
        ({"inputs": "nowhere.csv"}, "nowhere.csv"),
        ({"scenario": "nowhere.toml"}, "nowhere.toml"),
        ({"scenario": "s.toml", "duration": 1}, "give it alone"),
        ({"inputs": "u.csv", "start": 1}, "omit `start`"),
    ],
)
def test_what_does_not_fit_is_refused(oscillator, arguments, message) -> None:
    with pytest.raises(BracketryError, match=message):
        simulate(oscillator, **arguments)


def test_columns_and_files(oscillator, tmp_path) -> None:
    run = simulate(oscillator, 1.0, x0={"x": 1}, inputs={"u": "t"})
    assert list(run.columns()) == ["t", "x", "v", "u", "energy"]
    run.to_csv(tmp_path / "run.csv")
    table = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    assert np.array_equal(table["x"], run["x"])
    with pytest.raises(KeyError, match="there are t, x, v, u, energy"):
        run["q"]
    copy = pickle.loads(pickle.dumps(run))
    assert np.array_equal(copy.states, run.states) and len(copy) == len(run)
    assert run.figure().name == "trajectory"


def test_data_frames(oscillator) -> None:
    pandas = pytest.importorskip("pandas")
    run = simulate(oscillator, 1.0, x0={"x": 1}, inputs={"u": "t"}, sample=0.1)
    frame = run.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.index.name == "t" and list(frame.columns) == ["x", "v", "u", "energy"]
    again = simulate(oscillator, inputs=frame[["u"]], x0={"x": 1}, hold="linear")
    assert np.allclose(again["x"], run["x"], atol=1e-8)


def test_plot(oscillator) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = simulate(oscillator, 1.0, x0={"x": 1}).plot("x", "energy")
    assert [axis.get_ylabel() for axis in figure.axes] == ["x", "energy"]
