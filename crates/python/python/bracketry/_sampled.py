"""Results that are sampled along time."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np

from ._result import Result
from ._tables import Floats, csv_text


@dataclass(frozen=True, eq=False, kw_only=True)
class Sampled(Result):
    """What was sampled along a run. ``run["x"]`` is a column by name, ``run["t"]`` the times."""

    #: Times in the unit of time of the model, seconds unless it states another, shape (k,).
    t: Floats = field(repr=False)
    #: States at these times, shape (k, n).
    states: Floats = field(repr=False)
    #: Inputs from each time on, shape (k, m), or (k - 1, m) where none acts from the last time on.
    inputs: Floats = field(repr=False)
    state_names: list[str] = field(repr=False)
    input_names: list[str] = field(repr=False)
    #: What stands at the axis of a column: name and, where the model states them, label and unit.
    titles: dict[str, str] = field(repr=False, default_factory=dict)

    def _blocks(self) -> list[tuple[list[str], Floats]]:
        """Names with their columns, block by block."""
        return [(self.state_names, self.states), (self.input_names, self.inputs)]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Floats:
        if name == "t":
            return self.t
        blocks = self._blocks()
        for names, values in blocks:
            if name in names:
                column: Floats = values[:, names.index(name)]
                return column
        known = ", ".join(["t", *(known for names, _ in blocks for known in names)])
        raise KeyError(f"there is no column `{name}`; there are {known}")

    def columns(self) -> dict[str, Floats]:
        """All columns by name.

        Unknown columns are omitted. NaN follows where an input has no value at the last time.
        """
        names = dict.fromkeys(["t", *(name for names, _ in self._blocks() for name in names)])
        columns = {name: self[name] for name in names if not np.isnan(self[name]).all()}
        rows = len(self.t)
        return {
            name: column if len(column) == rows else np.append(column, np.full(rows - len(column), np.nan))
            for name, column in columns.items()
        }

    def to_pandas(self) -> Any:
        """A pandas DataFrame with the times as index."""
        import pandas

        columns = self.columns()
        index = pandas.Index(columns.pop("t"), name="t")
        return pandas.DataFrame(columns, index=index)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Writes all columns as a table whose numbers read back exactly."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(csv_text(self.columns(), type(self).__name__))

    def plot(self, *names: str) -> Any:
        """Draws columns (all states and inputs unless named) over time with matplotlib; gives its figure."""
        import matplotlib.pyplot as plt

        shown = list(names) or [*self.state_names, *self.input_names]
        figure, axes = plt.subplots(
            len(shown), 1, sharex=True, squeeze=False, figsize=(8, 1.6 * len(shown) + 0.6), layout="constrained"
        )
        for axis, name in zip(axes[:, 0], shown, strict=True):
            column = self[name]
            axis.plot(self.t[: len(column)], column)
            axis.set_ylabel(self.titles.get(name, name))
            axis.grid(visible=True, alpha=0.3)
        axes[-1, 0].set_xlabel(self.titles.get("t", "t"))
        return figure
