"""Robots that bend."""

import numpy as np
import pytest

from bracketry import BracketryError, stiffness

WRENCH = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]
TWIST = ["dx", "dy", "dz", "rx", "ry", "rz"]

#: Two revolute joints about z with links of 1 m, so that everything can be written down by hand.
ARM = """
name = "arm"
convention = "standard"
[[joint]]
a = 1.0
stiffness = 1.0e5
[[joint]]
a = 1.0
stiffness = 5.0e4
"""


def jacobian(q: np.ndarray) -> np.ndarray:
    """Translation in the plane and rotation about z of the tool point by the joints, shape (6, 2)."""
    j = np.zeros((6, 2))
    one, two = q[0], q[0] + q[1]
    j[0] = [-np.sin(one) - np.sin(two), -np.sin(two)]
    j[1] = [np.cos(one) + np.cos(two), np.cos(two)]
    j[5] = [1.0, 1.0]
    return j


@pytest.fixture
def measurements(noise) -> dict[str, np.ndarray]:
    """Displacements by J K⁻¹ Jᵀ F with springs of 2·10⁵ and 8·10⁴ N·m/rad, and noise of 2 µm."""
    q = noise.uniform(-1.5, 1.5, (60, 2))
    force = np.zeros((60, 6))
    force[:, :2] = noise.uniform(-500, 500, (60, 2))
    compliance = np.diag([1 / 2e5, 1 / 8e4])
    moved = np.array([jacobian(a) @ compliance @ jacobian(a).T @ f for a, f in zip(q, force, strict=True)])
    moved[:, :3] += 2e-6 * noise.standard_normal((60, 3))
    moved[:, 3:] += 2e-6 * noise.standard_normal((60, 3))
    table = {"q1": q[:, 0], "q2": q[:, 1]}
    table.update(zip(WRENCH, force.T, strict=True))
    table.update(zip(TWIST, moved.T, strict=True))
    return table


def write(table, path) -> None:
    rows = "\n".join(",".join(map(repr, row)) for row in np.column_stack(list(table.values())).tolist())
    path.write_text(",".join(table) + "\n" + rows + "\n")


def test_springs_are_found(measurements) -> None:
    found = stiffness.identify(measurements, ARM)
    assert found.robot == "arm" and found.measurements == 60
    assert found.stiffnesses[1] == pytest.approx(2e5, rel=0.02)
    assert found.stiffnesses[2] == pytest.approx(8e4, rel=0.02)
    assert found.identified_robot is not None and "stiffness" in found.identified_robot
    assert "arm: 60 measurements" in str(found)


def test_numbers_are_those_of_the_command_line(measurements, tmp_path, command) -> None:
    write(measurements, tmp_path / "data.csv")
    (tmp_path / "arm.toml").write_text(ARM)
    memory = stiffness.identify(measurements, ARM)
    file = stiffness.identify(tmp_path / "data.csv", tmp_path / "arm.toml")
    assert memory.json == file.json
    assert file.json == command("stiffness", "identify", tmp_path / "data.csv", tmp_path / "arm.toml")


def test_a_log_is_compensated(models, tmp_path, command) -> None:
    k = np.arange(500)
    log = {"t": 0.004 * k, **{f"q{i}": np.full(500, angle) for i, angle in enumerate([0.1, -0.9, 1.2, 0.2, 0.6, 0.3], 1)}}
    log.update({name: 0.0 * k for name in WRENCH})
    log["Fz"] = 300.0 * np.sin(0.02 * k)
    robot = models / "kr125.toml"
    run = stiffness.compensate(log, robot)
    assert run.corrected.shape == (500, 6) and run.wrench.shape == (500, 6) and run.held.dtype == bool
    assert run.samples == 500 and run.period_s == pytest.approx(0.004)
    assert run.displacement_max_m > 0
    write(log, tmp_path / "log.csv")
    line = command("stiffness", "compensate", tmp_path / "log.csv", robot)
    assert run.json == line
    assert run.figure().name == "compensation"


def test_what_does_not_fit_is_refused(measurements, models) -> None:
    with pytest.raises(BracketryError, match="q2 is missing"):
        stiffness.identify({k: v for k, v in measurements.items() if k != "q2"}, ARM)
    with pytest.raises(BracketryError, match="degrees"):
        stiffness.identify({**measurements, "q1": 90 + measurements["q1"]}, ARM)
    with pytest.raises(BracketryError, match="differ in length"):
        stiffness.identify({**measurements, "q1": [1.0]}, ARM)
    with pytest.raises(BracketryError, match=r"no \[sensor\]"):
        stiffness.compensate({"t": 0.01 * np.arange(60), **measurements}, ARM)
    with pytest.raises(BracketryError, match="nowhere.toml"):
        stiffness.identify(measurements, "nowhere.toml")


def test_the_poses_that_tell_the_most_are_those_of_the_command_line(measurements, tmp_path, command) -> None:
    candidates = {name: values for name, values in measurements.items() if name not in TWIST}
    write(candidates, tmp_path / "candidates.csv")
    (tmp_path / "arm.toml").write_text(ARM)
    memory = stiffness.choose_poses(candidates, ARM, count=8)
    file = stiffness.choose_poses(tmp_path / "candidates.csv", tmp_path / "arm.toml", count=8)
    line = command("stiffness", "poses", tmp_path / "candidates.csv", tmp_path / "arm.toml", "--count", 8)
    assert memory.json == file.json == line
    assert len(memory.lines) == 8 and memory.candidates == 60 and memory.springs_known and memory.identifies_all
    assert list(memory.chosen.errors) == ["joint 1 stiffness", "joint 2 stiffness"]
    for name, values in memory.columns().items():
        assert np.array_equal(values, candidates[name][memory.indices]), name


def test_chosen_measurements_tell_more_than_as_many_others(measurements) -> None:
    """The expected errors of the choice are below those of the first measurements of the table."""
    candidates = {name: values for name, values in measurements.items() if name not in TWIST}
    chosen = stiffness.choose_poses(candidates, ARM, count=8)
    first = stiffness.choose_poses({name: values[:8] for name, values in candidates.items()}, ARM, count=8)
    for name, error in chosen.chosen.errors.items():
        assert error is not None and error < first.chosen.errors[name]


#: Three revolute joints at right angles, so that gravity comes to the sensor from all sides.
WRIST = """
name = "wrist"
convention = "standard"
[[joint]]
alpha_deg = 90
[[joint]]
alpha_deg = -90
[[joint]]
[sensor]
position = [0.0, 0.0, 0.0]
force_range = 500.0
moment_range = 100.0
"""


def rotation(q: np.ndarray) -> np.ndarray:
    """Orientation of the sensor of the wrist: turns about z, each followed by a quarter turn about x, forth and back."""

    def z(a: float) -> np.ndarray:
        return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])

    forth = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    return z(q[0]) @ forth @ z(q[1]) @ forth.T @ z(q[2])


def test_a_load_is_weighed(noise, tmp_path, command) -> None:
    mass, centre, bias = 4.2, np.array([0.01, -0.02, 0.08]), np.array([3.0, -2.0, 5.0, 0.1, -0.2, 0.3])
    angles = noise.uniform(-2, 2, (25, 3))
    readings = np.empty((25, 6))
    for row, q in zip(readings, angles, strict=True):
        weight = rotation(q).T @ np.array([0, 0, -9.81 * mass])
        row[:] = bias + np.concatenate([weight, np.cross(centre, weight)])
    readings += 0.01 * noise.standard_normal((25, 6))
    table = {f"q{i + 1}": angles[:, i] for i in range(3)} | dict(zip(WRENCH, readings.T, strict=True))
    found = stiffness.weigh(table, WRIST)
    assert found.mass == pytest.approx(mass, abs=5 * found.mass_deviation)
    assert np.allclose(found.centre, centre, atol=1e-3)
    assert np.allclose(found.bias, bias, atol=0.05)
    assert found.centre.shape == (3,) and found.bias_deviation.shape == (6,) and found.residual.shape == (2,)
    assert found.toml.startswith("[payload]\nmass = ")
    write(table, tmp_path / "readings.csv")
    (tmp_path / "wrist.toml").write_text(WRIST)
    assert found.json == command("stiffness", "weigh", tmp_path / "readings.csv", tmp_path / "wrist.toml")


def test_what_cannot_be_chosen_or_weighed_is_refused(measurements) -> None:
    with pytest.raises(BracketryError, match="count is -1"):
        stiffness.choose_poses(measurements, ARM, count=-1)
    with pytest.raises(BracketryError, match="60"):
        stiffness.choose_poses(measurements, ARM, count=61)
    with pytest.raises(BracketryError, match=r"no \[sensor\]"):
        stiffness.weigh(measurements, ARM)
    with pytest.raises(BracketryError, match="is not a robot"):
        stiffness.weigh(measurements, None)
