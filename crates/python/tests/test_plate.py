"""Experiments on the vibrating plate."""

import pickle

import numpy as np
import pytest

from bracketry import BracketryError, plate

MODELS = ["published", "point", "reduced", "area", "body"]


@pytest.mark.parametrize("model", MODELS)
def test_numbers_are_those_of_the_command_line(model, command, timeless, tmp_path) -> None:
    run = plate.run(2, model=model, seconds=1.0, mu=0.25, start=[0.48, 0.01, 0.2])
    options = ["--model", model, "--seconds", 1.0, "--mu", 0.25, "--start", "0.48,0.01,0.2", "--out", tmp_path]
    assert timeless(run.json) == timeless(command("plate", 2, *options))
    table = np.genfromtxt(tmp_path / "trajectory.csv", delimiter=",", names=True, deletechars="")
    assert set(table.dtype.names) == set(run.columns())
    for name in table.dtype.names:
        assert np.array_equal(run[name], table[name], equal_nan=True), name


def test_rows_start_at_the_start_and_come_every_sample() -> None:
    run = plate.run(3, model="reduced", seconds=0.5, sample=0.01)
    assert run.t.shape == (51,) and run.states.shape == (51, 6) and run.inputs.shape == (51, 2)
    assert np.allclose(np.diff(run.t), 0.01, atol=1e-12)
    assert list(run.states[0, :3]) == [run.start["x"], run.start["y"], run.start["phi"]]
    assert run["x_plate"][-1] == run.final["x"] and len(run) == 51
    assert run.outcome == "not reached" and run.reached is None
    assert run.figure_names == ["motion", "plan_view"]
    assert "<pre>" in run._repr_html_()


def test_the_vertices_of_a_polygon_are_a_shape(tmp_path) -> None:
    corners = np.array([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]])
    ways = [corners, np.asfortranarray(corners), corners.tolist()]
    ends = [plate.run(2, model="reduced", shape=shape, seconds=0.5).states[-1] for shape in ways]
    assert all(np.array_equal(end, ends[0]) for end in ends)
    box = plate.run(2, model="reduced", shape="rectangle:0.2x0.1", seconds=0.5).states[-1]
    assert np.allclose(ends[0], box, atol=1e-9)


def test_a_scenario_file_is_run_and_arguments_have_the_last_word(tmp_path) -> None:
    (tmp_path / "s.toml").write_text("experiment = 2\nmodel = 'published'\nmu = 0.25\nseconds = 0.5\n")
    run = plate.run(tmp_path / "s.toml", mu=0.2)
    assert (run.model, run.friction["mu"], run.t_final) == ("published", 0.2, 0.5)


def test_a_run_is_its_own_log(tmp_path) -> None:
    """Compared with itself nothing differs, in memory and out of a file; and a log can move the plate."""
    log = plate.run(1, model="reduced", seconds=1.0)
    same = plate.run(1, model="reduced", compare=log)
    assert same.comparison is not None and same.comparison.rows == len(log)
    assert max(same.comparison.x_mm.rms, same.comparison.phi_deg.rms) < 1e-9
    assert "comparison" in same.figure_names
    log.to_csv(tmp_path / "log.csv")
    driven = plate.run(1, model="reduced", compare=tmp_path / "log.csv", motion="log")
    assert driven.motion == "log" and np.isnan(driven.amplitude).all()
    assert driven.comparison is not None and driven.comparison.phi_deg.rms < 0.5


def test_a_bearing_on_the_rim_turns_less_and_is_that_of_the_command_line(command, timeless) -> None:
    corners = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]
    feet = "feet:0.1,0;-0.1,0.05;-0.1,-0.05"
    whole = plate.run(1, shape=corners, seconds=1.5, dt=0.002)
    rim = plate.run(1, shape=corners, seconds=1.5, dt=0.002, bearing=feet, center_of_mass=[-0.01, 0.0])
    assert abs(rim.final["phi"]) < abs(whole.final["phi"])
    box = plate.run(1, shape="rectangle:0.2x0.1", seconds=0.5, bearing="ring:1", center_of_mass=(-0.01, 0.0))
    options = ["--shape", "rectangle:0.2x0.1", "--seconds", 0.5, "--bearing", "ring:1", "--center-of-mass", "-0.01,0"]
    assert timeless(box.json) == timeless(command("plate", 1, *options))


def test_a_mirrored_log_is_undecided() -> None:
    run = plate.run(3, model="published", seconds=4.0)
    log = {name: np.array(run[name]) for name in ("t", "x_plate", "y_plate", "phi_plate")}
    starts = np.flatnonzero(np.diff(run.amplitude)) + 1
    first = starts[np.argmin(np.abs(log["y_plate"][starts]))]
    least = abs(float(log["y_plate"][first]))
    log["y_plate"][first:] *= -1
    compared = plate.run(3, model="published", compare=log, noise=3 * least).comparison
    assert compared is not None and compared.signs is not None and compared.status == "undecided"
    assert compared.signs["opposite"]["t"] <= log["t"][first] + 1e-9
    same = plate.run(3, model="published", compare=run).comparison
    assert same is not None and same.signs is not None and (same.status, same.signs["opposite"]) == ("compared", None)


def test_a_run_is_pickled() -> None:
    run = plate.run(2, model="published", seconds=0.2)
    copy = pickle.loads(pickle.dumps(run))
    assert np.array_equal(copy.states, run.states) and copy.json == run.json


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"experiment": 4}, "no experiment `4`"),
        ({"experiment": 1.5}, "give 1, 2, 3"),
        ({"experiment": "nowhere.toml"}, "nowhere.toml"),
        ({"model": "magic"}, "no model `magic`"),
        ({"mu": -0.1}, "^mu: mu = -0.1 must not be negative"),
        ({"mu": float("nan")}, "mu is nan"),
        ({"mu": "0.3"}, "mu: `'0.3'` is not a number"),
        ({"seconds": -1.0}, "must be positive"),
        ({"sample": 0.0}, "not between"),
        ({"shape": "disk:-1"}, "shape"),
        ({"shape": [[0, 0], [1, 1]]}, "shape"),
        ({"shape": [[0, 0, 0]]}, r"\(k, 2\)"),
        ({"friction": "magic"}, "not a friction law"),
        ({"start": [0.1]}, "start has the shape"),
        ({"start": [0.1, float("inf")]}, "not a finite number"),
        ({"bearing": "rim"}, "^bearing: `rim` is not a bearing"),
        ({"bearing": "ring:1", "model": "reduced"}, "model area"),
        ({"center_of_mass": [0.1]}, "center_of_mass has the shape"),
        ({"center_of_mass": [9.0, 0.0]}, "beyond the outline"),
        ({"noise": 1e-3}, "^noise: there is no log"),
        ({"motion": "log"}, "there is no log"),
        ({"motion": "magic"}, "motion is"),
        ({"compare": {"t": [0.0, 1.0]}}, "x_plate"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, message) -> None:
    with pytest.raises(BracketryError, match=message):
        plate.run(**arguments)
