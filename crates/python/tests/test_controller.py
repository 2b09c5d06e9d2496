"""Controllers that are stepped on a plant of one's own."""

import pickle
import threading
from copy import deepcopy

import numpy as np
import pytest

from bracketry import BracketryError, Controller, System, control, diagnose

PROBLEM = {
    "horizon": {"steps": 20, "dt": 0.1},
    "cost": {"stage": "(x - r)^2 + 0.1*v^2 + 0.01*u^2"},
    "references": {"r": 0.0},
    "constraints": {"u": {"min": -1, "max": 1}},
    "solve": {"method": "rti"},
    "run": {"x0": {"x": 1.0}, "steps": 40},
}


@pytest.fixture
def cart() -> System:
    return System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "u/m"}, parameters={"m": 1.0})


def test_no_bound_is_none_and_bounds_stay_within_the_range_of_the_model():
    mass = System(
        states=["x", "v"], inputs=["a"], dynamics={"x": "v", "v": "a"}, ranges={"a": {"min": -2, "max": 1}}
    )
    controller = Controller({
        "model": mass,
        "horizon": {"steps": 10, "dt": 0.1},
        "cost": {"stage": "x^2 + v^2 + 0.01*a^2"},
        "run": {"x0": {"x": 5}},
    })
    controller.set_bounds("x", None, 9)
    with pytest.raises(BracketryError, match="range in the model"):
        controller.set_bounds("a", 5, 6)
    assert controller.step([5.0, 0.0]).u[0] == pytest.approx(-2)


def test_steps_are_those_of_the_closed_loop_bit_for_bit(cart) -> None:
    loop = control({"model": cart, **PROBLEM})
    controller = Controller({"model": cart, **PROBLEM})
    for k, y in enumerate(loop.measured):
        step = controller.step(y) if k % 2 else controller.step(list(y), t=3.0 + 0.1 * k)
        assert np.array_equal(step.u, loop.inputs[k])
        assert (step.status, step.source, step.sample, step.missed) == ("solved", "program", k, 0)
    assert controller.status["solved"] == 40
    controller.reset()
    controller.prepare()
    assert np.array_equal(controller.feedback(loop.measured[0]).u, loop.inputs[0])


def test_predictions_and_names(cart) -> None:
    controller = Controller({"model": cart, **PROBLEM})
    u = controller.step([0.5, 0.0]).u
    plan = controller.predict()
    assert plan.t.shape == (21,) and plan.states.shape == (21, 2) and plan.inputs.shape == (20, 1)
    assert np.array_equal(plan.inputs[0], u) and np.array_equal(plan.states[0], [0.5, 0.0])
    assert (controller.measured, controller.inputs, controller.references) == (["x", "v"], ["u"], ["r"])
    assert controller.period == 0.1 and controller.delay == 0


def test_what_is_lost_falls_to_the_policy_and_what_is_wrong_is_refused(cart) -> None:
    controller = Controller({"model": cart, **PROBLEM})
    controller.step([1.0, 0.0], t=0.0)
    lost = controller.step([np.nan, np.nan], t=0.1)
    assert (lost.status, lost.reason, lost.source) == ("fallback", "lost_sample", "plan")
    assert controller.lost().reason == "lost_sample"
    for y, t in (([1.0], None), ([1.0, 0.0, 0.0], 0.3), ([1.0, 0.0], 0.1), ([1.0, 0.0], float("nan")), ([1.0, 0.0], 1e6)):
        with pytest.raises(BracketryError):
            controller.step(y, t)
    with pytest.raises((BracketryError, TypeError)):
        controller.step("ab")
    assert controller.step([0.9, 0.0], t=0.6).missed == 3


def test_changes_while_it_runs(cart) -> None:
    controller = Controller({"model": cart, "live_parameters": ["m"], **PROBLEM})
    assert abs(controller.step([0.0, 0.0]).u[0]) < 1e-6
    controller.set_reference("r", 1.0)
    assert controller.step([0.0, 0.0]).u[0] > 0.9
    controller.set_bounds("u", -0.5, 0.5)
    controller.set_parameters(m=2.0)
    assert controller.step([0.0, 0.0]).u[0] == pytest.approx(0.5, abs=1e-6)
    controller.set_reference("r", np.zeros(5))
    assert abs(controller.step([0.0, 0.0]).u[0]) < 1e-3
    for wrong in (
        lambda: controller.set_reference("q", 1.0),
        lambda: controller.set_parameters(q=1.0),
        lambda: controller.set_parameters(m=float("nan")),
        lambda: controller.set_bounds("u", 1.0, -1.0),
        lambda: controller.set_target("x", 1.0),
    ):
        with pytest.raises(BracketryError):
            wrong()


def test_an_estimator_makes_states_of_outputs(cart) -> None:
    estimation = {"kind": "ekf", "outputs": {"x": 0.01}}
    controller = Controller({"model": cart, **PROBLEM, "estimation": estimation})
    assert controller.measured == ["x"]
    step = controller.step([1.0])
    assert step.estimate is not None and step.estimate.shape == (2,)


def test_the_log_is_a_table_that_diagnose_reads(cart) -> None:
    controller = Controller({"model": cart, **PROBLEM}, log=200)
    x, v = 1.0, 0.0
    rng = np.random.default_rng(3)
    for k in range(300):
        if k % 40 == 0:
            controller.set_reference("r", rng.uniform(-1.0, 1.0))
        u = controller.step([x, v]).u[0]
        a = u - 0.3 * v  # the plant has friction that the model lacks
        x, v = x + 0.1 * v + 0.005 * a, v + 0.1 * a
    log = controller.log
    assert list(log) == ["t", "x", "v", "u"] and len(log["t"]) == 200
    found = diagnose(cart, log)
    assert found.verdict == "cause_found" and found.causes
    with pytest.raises(BracketryError):
        Controller({"model": cart, **PROBLEM}, log=0).log  # noqa: B018


def test_the_interpreter_is_free_while_a_controller_computes(cart) -> None:
    problem = {**PROBLEM, "horizon": {"steps": 400, "dt": 0.1}, "solve": {"method": "sqp"}}
    controller = Controller({"model": cart, **problem})
    counted = 0
    done = threading.Event()

    def work() -> None:
        for _ in range(20):
            controller.step([1.0, 0.0])
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.wait(1e-4):
        counted += 1
    thread.join()
    assert counted > 5


def test_measurements_of_every_kind_are_read_or_refused(cart) -> None:
    def fresh() -> Controller:
        return Controller({"model": cart, **PROBLEM})

    expected = fresh().step([0.5, 0.25]).u
    for y in ((0.5, 0.25), np.array([0.5, 0.25], dtype=np.float32), np.array([0.5, 9.0, 0.25])[::2], np.ma.array([0.5, 0.25])):
        assert np.array_equal(fresh().step(y).u, expected)
    # A masked entry is not measured.
    masked = fresh().step(np.ma.array([0.5, 0.25], mask=[False, True]))
    assert masked.reason == "measurement"
    controller = fresh()
    for y in ("ab", ["0.5", "0.25"], [0.5, None], [[0.5, 0.25]], np.zeros((1, 2)), np.array([0.5, 1j]), {"x": 1}, None, 0.5, []):
        with pytest.raises(BracketryError):
            controller.step(y)
        with pytest.raises(BracketryError):
            controller.feedback(y)
    for t in ("soon", [0.0], 1j):
        with pytest.raises(BracketryError):
            controller.step([0.5, 0.25], t)
    assert controller.step([0.5, 0.25]).sample == 0


def test_changes_that_are_refused_change_nothing(cart) -> None:
    model = System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "u/m - c*v"}, parameters={"m": 1.0, "c": 0.1})
    problem = {"model": model, "live_parameters": ["m", "c"], **PROBLEM}
    controller, other = Controller(problem), Controller(problem)
    for wrong in (
        lambda: controller.set_parameters(m=5.0, q=1.0),
        lambda: controller.set_parameters(m=5.0, c="much"),
        lambda: controller.set_bounds("u", "low", 1.0),
        lambda: controller.set_bounds("u", float("nan"), 0.1),
        lambda: controller.set_bounds("u", float("inf")),
        lambda: controller.reset([1.0]),
        lambda: controller.reset(["a", "b"]),
    ):
        with pytest.raises(BracketryError):
            wrong()
    for y in ([0.3, 0.0], [0.2, 0.1]):
        assert np.array_equal(controller.step(y).u, other.step(y).u)


def test_controllers_in_threads_do_not_know_of_each_other(cart) -> None:
    expected = control({"model": cart, **PROBLEM})
    shared = Controller({"model": cart, **PROBLEM})
    wrong: list[int] = []

    def work() -> None:
        own = Controller({"model": cart, **PROBLEM})
        for k, y in enumerate(expected.measured):
            shared.step(y)
            shared.predict()
            if not np.array_equal(own.step(y).u, expected.inputs[k]):
                wrong.append(k)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not wrong and sum(shared.status[s] for s in ("solved", "inaccurate")) == 80


def test_measurements_and_states_go_by_name(cart) -> None:
    def fresh() -> Controller:
        return Controller({"model": cart, **PROBLEM})

    expected = fresh().step([0.5, 0.25]).u
    controller = fresh()
    assert np.array_equal(controller.step({"v": 0.25, "x": 0.5}).u, expected)
    assert np.array_equal(fresh().feedback({"v": 0.25, "x": 0.5}).u, expected)
    assert fresh().step({"x": 0.5, "v": None}).reason == "measurement"
    controller.reset({"v": 0.25})
    assert controller.predict().states[0, 0] == 0.0
    for wrong, told in (({"x": 0.5}, "`v` is missing"), ({"x": 0.5, "w": 1.0}, "no `w`"), ({"x": "a", "v": 0.0}, "`x` is not a number")):
        with pytest.raises(BracketryError, match=told):
            controller.step(wrong)
    with pytest.raises(BracketryError, match="no `w`"):
        controller.reset({"w": 1.0})
    assert repr(controller) == "Controller(measured=['x', 'v'], inputs=['u'], period=0.1)"


def test_the_innovation_shows_a_plant_that_differs(cart) -> None:
    def largest(mass: float) -> float:
        controller = Controller({"model": cart, **PROBLEM})
        x, v = 1.0, 0.0
        found = []
        for k in range(30):
            step = controller.step([x, v])
            a = step.u[0] / mass
            x, v = x + 0.1 * v + 0.005 * a, v + 0.1 * a
            assert (step.innovation is None) == (k == 0) and step.programs >= 1 and step.iterations >= 1
            found.append(0.0 if step.innovation is None else abs(step.innovation[1]))
        assert controller.predicted_cost >= 0.0
        return max(found)

    assert largest(1.0) < 1e-6
    assert largest(1.5) == pytest.approx(0.1 * (1 - 1 / 1.5), rel=0.01)


def test_a_step_survives_pickling_and_carries_its_residual(cart) -> None:
    soft = {"v": {"max": 0.1, "soft": [0.1, 0.1]}}
    controller = Controller({"model": cart, **PROBLEM, "constraints": {**PROBLEM.get("constraints", {}), **soft}})
    assert controller.step([float("nan"), 0.0]).residual is None
    for y in ([0.5, 0.25], [0.4, 0.5]):
        step = controller.step(y)
        assert step.residual is not None and 0.0 <= step.residual < np.inf
        assert set(controller.slacks()) == {"v"} and controller.slacks()["v"] >= 0.0
        for same in (pickle.loads(pickle.dumps(step)), deepcopy(step)):
            for name in ("u", "estimate", "innovation"):
                assert np.array_equal(getattr(same, name), getattr(step, name)) or getattr(step, name) is None
            for name in ("status", "reason", "source", "sample", "missed", "residual", "programs", "iterations"):
                assert getattr(same, name) == getattr(step, name)
            assert repr(same) == repr(step) and same.feedback_seconds == step.feedback_seconds


def test_a_copy_of_a_controller_starts_anew(cart) -> None:
    controller = Controller({"model": cart, **PROBLEM})
    first = controller.step([0.5, 0.25]).u
    controller.step([0.4, 0.1])
    copy = pickle.loads(pickle.dumps(controller))
    step = copy.step([0.5, 0.25])
    assert step.sample == 0 and np.array_equal(step.u, first)
