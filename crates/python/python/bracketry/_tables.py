"""Tables of samples: mappings of arrays, data frames, trajectories, files."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._native import BracketryError

Floats: TypeAlias = NDArray[np.float64]
#: A file (CSV, for runs also NPZ), columns by name, a pandas DataFrame, or a Trajectory.
Table: TypeAlias = "str | PathLike[str] | Mapping[str, Any] | Any"


def real_array(values: Any, what: str) -> Floats:
    """An array of real numbers of any shape; masked entries are NaN."""
    try:
        masked = isinstance(values, np.ma.MaskedArray)
        given = np.ma.filled(values.astype(float), np.nan) if masked else np.asarray(values)
        if given.dtype.kind not in "cmM":
            return np.ascontiguousarray(given, dtype=float).reshape(given.shape)
    except (TypeError, ValueError) as e:
        raise BracketryError(f"{what} is not an array of numbers: {e}") from None
    kind = "complex numbers" if given.dtype.kind == "c" else "dates or durations; give seconds as numbers"
    raise BracketryError(f"{what} is not an array of real numbers: it holds {kind}")


def floats(values: Any, what: str) -> Floats:
    """A one-dimensional array of numbers."""
    array = np.atleast_1d(real_array(values, what))
    if array.ndim != 1:
        raise BracketryError(f"{what} has the shape {array.shape}; give a one-dimensional array")
    return array


def path_of(table: Any) -> str | None:
    """The path where a table is a file."""
    return fspath(table) if isinstance(table, (str, PathLike)) else None


def columns_of(table: Any, what: str) -> dict[str, Floats]:
    """The columns of a table that is no file; the index of a data frame counts where it is called t."""
    columns = getattr(table, "columns", None)
    if isinstance(table, Mapping):
        pairs = dict(table)
    elif callable(columns):
        pairs = columns()
    elif columns is not None:
        pairs = {str(c): table[c] for c in columns}
        if "t" not in pairs and getattr(table.index, "name", None) == "t":
            pairs["t"] = table.index
    else:
        raise BracketryError(
            f"{what}: {type(table).__name__} is not a table; give a file, a mapping of arrays, a DataFrame, or a Trajectory"
        )
    return {str(name): floats(values, f"{what}: column `{name}`") for name, values in pairs.items()}


def csv_text(columns: Mapping[str, Floats], what: str) -> str:
    """A table as the text of a CSV file, in which numbers read back exactly."""
    lengths = {len(values) for values in columns.values()}
    if len(lengths) > 1:
        found = ", ".join(f"{name}: {len(values)}" for name, values in columns.items())
        raise BracketryError(f"{what}: the columns differ in length ({found})")
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n"


def table_text(table: Any, what: str) -> str | tuple[str, str]:
    """A table as the native module takes it: a path, or a name with the text of a CSV file."""
    path = path_of(table)
    return path if path is not None else (what, csv_text(columns_of(table, what), what))
