"""What Python programs pass by accident, and what they may pass."""

import copy
import pickle

import numpy as np
import pytest

from bracketry import BracketryError, System, affinize, analyze, control, diagnose, simulate, sweep


@pytest.fixture
def integrator() -> System:
    return System(states=["x"], inputs=["u"], dynamics={"x": "u"}, name="integrator")


#: The samples 0, 1, 2, 3 in every form that holds them.
FORMS = {
    "list": [0, 1, 2, 3],
    "integers": np.arange(4),
    "unsigned": np.arange(4, dtype=np.uint8),
    "single": np.arange(4, dtype=np.float32),
    "strided": np.arange(8.0)[::2] / 2,
    "reversed": np.arange(4.0)[::-1][::-1],
    "column": np.stack([np.arange(4.0), np.zeros(4)], axis=1)[:, 0],
    "big-endian": np.arange(4).astype(">f8"),
    "masked": np.ma.masked_array(np.arange(4.0), mask=False),
}


@pytest.mark.parametrize("form", FORMS)
def test_samples_of_every_form_are_the_same(integrator, form) -> None:
    samples = FORMS[form]
    run = simulate(integrator, inputs={"t": samples, "u": samples}, hold="linear")
    assert run["x"][-1] == pytest.approx(4.5, abs=1e-9)


def test_samples_that_cannot_be_written_are_read(integrator) -> None:
    fixed = np.arange(4.0)
    fixed.flags.writeable = False
    assert simulate(integrator, inputs={"t": fixed, "u": fixed}, x0=fixed[:1])["x"][0] == 0.0
    assert integrator.rhs(fixed[:, np.newaxis], fixed[:, np.newaxis]).tolist() == [[0.0], [1.0], [2.0], [3.0]]


def test_pandas_columns_are_samples(integrator) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"t": [0, 1, 2, 3], "u": [0, 1, 2, 3]}, index=list("abcd"))
    for given in (frame, {"t": frame["t"], "u": frame["u"]}, {"u": (frame["t"], frame["u"])}):
        assert simulate(integrator, inputs=given, hold="linear")["x"][-1] == pytest.approx(4.5, abs=1e-9)
    times = pandas.date_range("2024-01-01", periods=4, freq="s")
    with pytest.raises(BracketryError, match="seconds as numbers"):
        simulate(integrator, inputs={"t": times, "u": [0, 1, 2, 3]})


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        ([0, 1, 2, 3j], "complex"),
        ([0, 1, 2, "x"], "not an array of numbers"),
        ([0, 1, 2, None], "not a finite number"),
        (np.ma.masked_array([0.0, 1, 2, 3], mask=[0, 0, 1, 0]), "not a finite number"),
        ([[0, 1], [2]], "not an array of numbers"),
        (np.zeros((4, 1)), "one-dimensional"),
        ([0, 1, 2], "length|samples"),
    ],
)
def test_samples_that_are_none_are_refused(integrator, samples, message) -> None:
    with pytest.raises(BracketryError, match=message):
        simulate(integrator, inputs={"t": [0, 1, 2, 3], "u": samples})


@pytest.mark.parametrize("seconds", [0, -1.0, float("nan"), float("inf"), True])
def test_times_that_are_none_are_refused(integrator, seconds) -> None:
    with pytest.raises(BracketryError, match="duration"):
        simulate(integrator, seconds)
    with pytest.raises(BracketryError, match="sample"):
        simulate(integrator, 1.0, inputs={"u": lambda t: t}, sample=seconds)


def test_what_is_no_model_is_refused_by_name() -> None:
    for function in (analyze, affinize, lambda s: simulate(s, 1.0), lambda s: diagnose(s, {})):
        with pytest.raises(BracketryError, match=r"give System.from_file\('ball.toml'\)"):
            function("ball.toml")
        with pytest.raises(BracketryError, match="give a System"):
            function(None)
    with pytest.raises(BracketryError, match="plant: .* is not a model"):
        control("model = 'a'", models={"plant": 3})


def test_a_text_is_no_list_of_texts(integrator) -> None:
    with pytest.raises(BracketryError, match=r"brackets: give a list, such as \['\[f,g1\]'\]"):
        analyze(integrator, brackets="[f,g1]")
    with pytest.raises(BracketryError, match="fix: give a list"):
        diagnose(integrator, {"t": [0.0, 1.0]}, fix="mu")
    with pytest.raises(BracketryError, match="errors is 'ignore'"):
        sweep(abs, [1], errors="ignore")


@pytest.mark.parametrize("seed", [-1, 1.5, "one", True])
def test_seeds_are_whole_numbers(integrator, seed) -> None:
    with pytest.raises(BracketryError, match="seed is .*whole number"):
        diagnose(integrator, {"t": [0.0, 1.0]}, seed=seed)


def test_copies_within_a_process_keep_their_figures(integrator) -> None:
    run = simulate(integrator, 1.0, inputs={"u": 1})
    for twin in (copy.copy(run), copy.deepcopy(run)):
        assert np.array_equal(twin.states, run.states) and twin.figure_names == ["trajectory"]
    assert copy.copy(run).states is run.states and copy.deepcopy(run).states is not run.states
    assert pickle.loads(pickle.dumps(run)).figure_names == []
    assert copy.deepcopy(integrator).equations == integrator.equations
