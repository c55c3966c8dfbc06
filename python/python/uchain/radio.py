"""Radio laws of one's own."""

from __future__ import annotations

from typing import Callable, List, Sequence

from ._uchain import tabulate as _tabulate

__all__ = ["RadioLaw"]


#: The largest loss of a table of a scenario, dB.
_SILENT_DB = 400.0


class RadioLaw:
    """A law of the path loss: a callable ``law(distance_m, walls) -> loss_db``.

    It is called once for each distance along the tunnel and each number of walls on the straight line,
    when it is made; the missions use the table of its losses, and call no Python. Between two
    distances the loss is interpolated over the logarithm of the distance. Beyond the last one it goes
    on rising as before it, and does not fall; more walls than the table has count as its most.

    :param law: the callable. It returns the loss in dB, 0 or more; no radio
        hears over more than 400 dB, which is what a greater loss counts as.
    :param distances_m: 2 to 2,000 distances in metres, from 0.01 to 10,000, rising; where left out, 40
        for each power of ten from 0.3 m to 1,000 m.
    :param walls: the largest number of walls.
    :param timeout_s: the longest time of a call.
    :raises ValueError: where a loss is no finite number. What the callable raises comes out as it is.
    :raises TimeoutError: where a call takes longer.
    """

    def __init__(
        self,
        law: Callable[[float, int], float],
        *,
        distances_m: Sequence[float] = (),
        walls: int = 4,
        timeout_s: float = 10.0,
    ) -> None:
        if not 0 <= walls <= 7:
            raise ValueError(f"walls={walls} is out of range; give 0 to 7")
        if not callable(law):
            raise ValueError("a radio law is a callable law(distance_m, walls) -> loss_db")
        #: The distances of the table, m.
        self.distances_m: List[float] = [float(it) for it in distances_m] or _evenly()
        if not all(near < far for near, far in zip(self.distances_m, self.distances_m[1:])):
            raise ValueError("distances_m do not rise; give each greater than the one before it")
        if not 2 <= len(self.distances_m) <= 2_000:
            raise ValueError(f"distances_m has {len(self.distances_m)} distances; give 2 to 2,000")
        if self.distances_m[0] < 0.01 or self.distances_m[-1] > 10_000:
            raise ValueError("distances_m goes beyond what is taken; give 0.01 to 10,000 m")
        #: The losses in dB: a row for each number of walls, from none on.
        self.losses_db: List[List[float]] = []
        for count, row in enumerate(_tabulate(law, self.distances_m, walls + 1, timeout_s)):
            for distance, loss in zip(self.distances_m, row):
                if loss < 0.0:
                    raise ValueError(
                        f"the radio law returned {loss:g} for {distance} m and {count} walls; give a "
                        "loss in dB, 0 or more"
                    )
            self.losses_db.append([min(loss, _SILENT_DB) for loss in row])

    @property
    def model(self) -> dict:
        """The table ``[radio.model]`` of a scenario file."""
        return {"law": "table", "distance_m": self.distances_m, "loss_db": self.losses_db}

    def __repr__(self) -> str:
        rows, columns = len(self.losses_db), len(self.distances_m)
        return f"<uchain.RadioLaw of {columns} distances and up to {rows - 1} walls>"


def _evenly() -> List[float]:
    """Distances from 0.3 m to 1 km, evenly on a logarithmic scale; 1 m is one of them."""
    return [float(f"{10 ** (n / 40):.6g}") for n in range(-21, 121)]
