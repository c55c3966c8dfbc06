"""The line that says how far a campaign has come."""

from __future__ import annotations

import sys
import time
from typing import Any, Optional, TextIO

#: A campaign that takes less than this shows nothing, in seconds.
QUIET_S = 1.0


class Bar:
    """A line on standard error with what is done, and the time that is left.

    It is shown on a terminal and in a notebook, or where ``shown`` says so.
    """

    def __init__(self, shown: Optional[bool], unit: str = "missions") -> None:
        self.stream: TextIO = sys.stderr
        self.in_notebook = _is_of_a_notebook(self.stream)
        self.shown = (self.in_notebook or _is_a_terminal(self.stream)) if shown is None else shown
        self.unit = unit
        self.began = time.monotonic()
        #: What was done when it began: a campaign that goes on has some missions already.
        self.first: Optional[int] = None
        self.line = ""

    def __enter__(self) -> "Bar":
        return self

    def __exit__(self, *_: Any) -> None:
        if not self.line:
            return
        # A notebook keeps what is written: there the last line stays.
        end = "\n" if self.in_notebook else "\r" + " " * len(self.line) + "\r"
        self.stream.write(end)
        self.stream.flush()

    def __call__(self, done: int, total: int) -> None:
        """Show that so many of all are done."""
        taken_s = time.monotonic() - self.began
        if self.first is None:
            self.first = done
        if not self.shown or taken_s < QUIET_S:
            return
        line = f"{done:,} of {total:,} {self.unit}, {100 * done // max(total, 1)} %"
        if self.first < done < total:
            line += f", {_words(taken_s * (total - done) / (done - self.first))} left"
        elif done >= total:
            line += f", {_words(taken_s)}"
        self.stream.write("\r" + line.ljust(len(self.line)))
        self.stream.flush()
        self.line = line


def _words(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    if seconds < 6000:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def _is_a_terminal(stream: Any) -> bool:
    try:
        return stream.isatty()
    except (AttributeError, ValueError):  # There is none, or it is closed.
        return False


def _is_of_a_notebook(stream: Any) -> bool:
    return type(stream).__module__.startswith("ipykernel.")
