"""Every block of Python in the guide runs, one after the other."""

import re

import pytest
from conftest import ROOT


def test_the_guide_runs(tmp_path, monkeypatch) -> None:
    pytest.importorskip("sympy")
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 7
    names: dict = {"__name__": "guide"}
    for block in blocks:
        exec(compile(block, block.strip().partition("\n")[0], "exec"), names)
    assert (tmp_path / "growth.png").exists() and (tmp_path / "diagnosis.html").exists()
