"""Tables of a run as arrays."""
from __future__ import annotations

import csv
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Iterator

import numpy as np


class Table(Mapping):
    """Columns of numbers by their headings.

    table["volume_loss [-]"] or, where one column alone begins so, table["volume_loss"]: an array [rows] [unit of the
    heading]. table.array: all of it, [rows, columns].
    """

    def __init__(self, path: str | os.PathLike, names: list[str], array: np.ndarray):
        self.path = Path(path)
        self.names = names
        self.array = array

    def _column(self, key: str) -> int:
        if key in self.names:
            return self.names.index(key)
        found = [k for k, name in enumerate(self.names) if name.split(" [")[0] == key]
        if len(found) == 1:
            return found[0]
        raise KeyError(f"{self.path}: found no column {key!r}, expected one of {', '.join(self.names)}")

    def __getitem__(self, key: str) -> np.ndarray:
        return self.array[:, self._column(key)]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def unit(self, key: str) -> str:
        """The unit in the heading of a column: "s" of "time [s]", "" without one."""
        name = self.names[self._column(key)]
        return name.split(" [", 1)[1].rstrip("]") if " [" in name else ""

    def __repr__(self) -> str:
        return f"<Table {str(self.path)!r}: {len(self.array)} rows of {', '.join(self.names)}>"


def read_table(path: str | os.PathLike) -> Table:
    """Read a table of numbers: lines with '#' are comments, the first other one has the headings."""
    rows, names = [], []
    with open(path, encoding="utf-8", newline="") as file:
        lines = [(k, line) for k, line in enumerate(file, 1) if line.strip() and not line.startswith("#")]
    for (k, _), fields in zip(lines, csv.reader(line for _, line in lines)):
        if not names:
            names = [field.strip() for field in fields]
            continue
        try:
            rows.append([float(field) for field in fields])
        except ValueError as error:
            found = str(error).rsplit(":", 1)[-1].strip()
            raise ValueError(f"{path}:{k}: found {found}, expected a number") from None
        if len(fields) != len(names):
            raise ValueError(f"{path}:{k}: found {len(fields)} fields, expected {len(names)}")
    if not names:
        raise ValueError(f"{path}: found no headings")
    if len(set(names)) != len(names):
        raise ValueError(f"{path}: found a heading twice")
    return Table(path, names, np.array(rows, dtype=np.float64).reshape(len(rows), len(names)))
