"""Every block of Python in the guide runs, one after the other, and so does that of the README."""

import re

import pytest
from conftest import ROOT


def run_blocks(document: str) -> int:
    """Runs the blocks of Python in a document one after the other; gives their number."""
    text = (ROOT / document).read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict = {"__name__": "guide"}
    for block in blocks:
        exec(compile(block, block.strip().partition("\n")[0], "exec"), names)
    return len(blocks)


def test_the_readme_runs(capsys) -> None:
    assert run_blocks("README.md") == 1
    assert "equilibrium" in capsys.readouterr().out


def test_the_cart_pole_of_an_independent_engine_is_swung_up(monkeypatch, capsys) -> None:
    pytest.importorskip("mujoco")
    text = (ROOT / "docs/live.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(block.splitlines()) <= 30
    names: dict = {}
    exec(compile(block, "docs/live.md", "exec"), names)
    p, th = names["plant"].qpos
    assert abs(p) < 0.05 and abs(th) < 0.05
    assert abs(names["plant"].qvel).max() < 0.2


def test_a_disk_on_the_plate_of_an_independent_engine_is_brought_to_its_pose(capsys) -> None:
    pytest.importorskip("mujoco")
    text = (ROOT / "docs/plate.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(block.splitlines()) <= 40
    names: dict = {}
    exec(compile(block, "docs/plate.md", "exec"), names)
    x, y, yaw = abs(names["pose"]() - names["target"])
    assert names["step"].status == "arrived"
    assert max(x, y) < 2e-3 and yaw < 0.035
    assert abs(names["plant"].qpos[:2]).max() < 0.35 and abs(names["plant"].qvel).max() < 0.01


def test_the_guide_runs(tmp_path, monkeypatch) -> None:
    pytest.importorskip("sympy")
    monkeypatch.chdir(tmp_path)
    assert run_blocks("docs/python.md") >= 7
    assert (tmp_path / "growth.png").exists() and (tmp_path / "diagnosis.html").exists()
