"""Models as source code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

from . import _native
from ._native import Model
from ._result import Result, parsed, result_of
from ._text import listed, name_of


@dataclass(frozen=True, eq=False, kw_only=True)
class Export(Result):
    """The equations of a model with their Jacobians as source code."""

    model: str
    language: str
    #: What the module is called, and with which the functions begin in C.
    name: str
    states: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: The entries of u: inputs, then the derivatives of inputs that the equations use.
    inputs: list[dict[str, Any]] = field(repr=False, default_factory=list)
    outputs: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: The entries of p: the parameters that are arguments, with their values.
    parameters: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: The parameters that are constants.
    constants: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: Each function with its results and number of operations.
    functions: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: What a reader has to know, such as terms that are set-valued in the model.
    notes: list[dict[str, Any]] = field(repr=False, default_factory=list)
    #: The text of each file by name.
    files: dict[str, str] = field(repr=False, default_factory=dict)
    #: Everything as one file.
    source: str = field(repr=False, default="")

    def write(self, folder: str | PathLike[str]) -> list[Path]:
        """Writes the files into a folder, which is created if necessary; returns their paths."""
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        for name, text in self.files.items():
            (target / name).write_text(text, encoding="utf-8")
        return [target / name for name in self.files]

    def module(self) -> ModuleType:
        """The source as a Python module, for the languages "python" and "casadi"."""
        if self.language not in ("python", "casadi"):
            raise _native.BracketryError(f'{self.language} is not run here; export to "python" or "casadi"')
        module = ModuleType(self.name)
        exec(compile(self.source, next(iter(self.files)), "exec"), module.__dict__)
        return module


def exported(model: Model, language: str, parameters: Sequence[Any] | str, name: str | None) -> Export:
    """What :meth:`System.export` returns."""
    if isinstance(parameters, str):
        parameters = [parameters]
    kept = [name_of(p, "parameters") for p in listed(parameters, "parameters")]
    answer = _native.export(model, language, kept, name)
    data = parsed(answer["json"])
    files = {file["name"]: file["text"] for file in data["files"]}
    return result_of(Export, data, answer, files=files, source=answer["source"])
