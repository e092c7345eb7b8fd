"""A search's trials in a file, a line of JSON each, written as they come: a search that ended goes on from it."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...util.errors import UserError
from ...util.files import check_folder, write_text, writing

Values = dict[str, float]


class Store:
    """The trials so far. The first line of the file says which search they are of."""

    def __init__(self, path: Path, search: Mapping[str, Any]) -> None:
        self.path, self.trials = path, list[tuple[Values, float]]()
        head = json.loads(json.dumps(search))
        if path.exists():
            self._read(head)
        else:
            check_folder("--store", path.parent)
            write_text(path, json.dumps(head) + "\n")

    def _read(self, head: dict[str, Any]) -> None:
        try:
            lines = self.path.read_text(encoding="utf-8").split("\n")
            found = json.loads(lines[0])
            other = [key for key in head if found.get(key) != head[key]]
            if other:
                raise UserError(f"{self.path}: its trials belong to another search ({', '.join(other)}): remove it, "
                                "or name another with --store")
            # A last line that a power cut left incomplete is tried again.
            self.trials = [(one["values"], float(one["score"])) for one in map(json.loads, lines[1:-1])]
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise UserError(f"{self.path}: not a file of trials ({error}): name another with --store") from error
        write_text(self.path, "\n".join(lines[:-1]) + "\n")

    def add(self, values: Values, score: float) -> None:
        """Write a trial to the disk."""
        self.trials.append((values, score))
        with writing(self.path), self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"values": values, "score": score}) + "\n")
            file.flush()
            os.fsync(file.fileno())

    @property
    def best(self) -> tuple[Values, float]:
        """The values with the highest score, and the score; the first of equals."""
        return max(self.trials, key=lambda trial: trial[1])
