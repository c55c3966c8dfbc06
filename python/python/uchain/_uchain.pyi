"""The compiled side of the package."""

from typing import Any, Callable, Iterator, List, Optional, Tuple

__version__: str

class Table:
    """A table with named columns, which Arrow libraries read without copying."""

    column_names: List[str]
    empty_columns: List[str]
    """The names of the columns that have no value in any row."""
    def head(self, rows: int = 5) -> "Table":
        """The table of the first rows."""
    def __iter__(self) -> Iterator[dict]:
        """The rows, one after the other, as dicts by the names of the columns."""
    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> object: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> List[Any]:
        """The values of a column; ``None`` stands where there is no value."""
    def to_dict(self) -> dict:
        """The columns as lists by name: ``pandas.DataFrame(table.to_dict())``."""

class Policy:
    """A built-in movement policy as a function of the strengths of a relay's links."""

    def __new__(cls, name: str, loss_at_1m_db: float = 40.0) -> "Policy": ...
    def __call__(
        self, drone: int, front_dbm: float, front_mps: float, back_dbm: float, back_mps: float
    ) -> float:
        """The forward velocity of a relay, m/s; ``drone`` has no effect."""

class Simulation:
    """A mission that is stepped, looked at and steered."""

    time_s: float
    """Seconds since the start."""
    is_over: bool
    """Whether the mission is over."""
    order_now: str
    """The operator's order, in words."""
    def __new__(
        cls,
        scenario: str,
        seed: int = 1,
        *,
        policy: Optional[Callable[..., Any]] = None,
        live: bool = False,
        timeout_s: float = 10.0,
        **keys: Any,
    ) -> "Simulation": ...
    def step(self, rounds: int = 1) -> bool:
        """Flies so many rounds of 0.2 s, or to the end; returns whether the mission goes on."""
    def look(self) -> List[dict]:
        """The drones as they are now, the head first and the base last.

        Each is a dict with ``node``, ``role``, ``state``, the true place ``x_m``, ``y_m``, ``z_m``,
        ``yaw_rad`` and ``way_m`` (from the base, along the tunnel), the velocity of the set-point
        ``forward_m_s``, ``left_m_s``, ``yaw_rate_rad_s``, ``battery_v``, the four beams ``ranges_m``
        (NW, NE, SW, SE), and the links ``front`` and ``back``, each ``None`` or a dict with ``peer``,
        ``raw_dbm``, ``filtered_dbm`` and ``true_dbm``.
        """
    def order(
        self, order: str, *, speed_mps: Optional[float] = None, branch: Optional[str] = None
    ) -> None:
        """Gives the operator's order in a live mission: wait, explore (which takes ``speed_mps``, and
        ``branch`` for the next junction), return, land, perch or stop."""

class Flown: ...

class Steered:
    """A mission whose relays fly with the velocities that each step is given."""

    max_speed_mps: float
    """The largest speed of a relay, m/s."""
    drones: List[int]
    """The numbers of the relays."""
    time_s: float
    """Seconds since the start."""
    def __new__(cls, scenario: str, keys: dict) -> "Steered": ...
    def restart(self, seed: int) -> bytes:
        """Begins the mission of this seed; returns what the relays observe, as 32-bit numbers."""
    def step(self, speeds: List[float], rounds: int) -> Tuple[bytes, float, bool]:
        """Flies rounds of 0.2 s with these velocities, m/s; returns what the relays observe, the strength
        of the chain's weakest link, dBm, and whether the mission goes on."""

def fly(
    scenario: str,
    seed: int,
    policy: Optional[Callable[..., Any]],
    timeout_s: float,
    keys: dict,
) -> Flown: ...
def command(arguments: List[str]) -> int:
    """Carries out a command line, whose first argument is the program's name; returns the status."""

def options(vary: dict, keys: dict) -> List[str]:
    """The options of the command for the keys and for the values that they take."""

def read_runs(folder: str) -> Table:
    """The runs of a campaign that the command has written into a folder."""

def tabulate(
    law: Callable[[float, int], float], distances: List[float], rows: int, timeout_s: float
) -> List[List[float]]:
    """The losses by a callable at these distances, with a row for each number of walls from none on."""

def fly_campaign(
    scenario: str,
    seeds: List[int],
    vary: dict,
    threads: int,
    policy: Optional[Tuple[Callable[..., Any], float]],
    keys: dict,
    progress: Optional[Callable[[int, int], Any]],
) -> Table: ...
def fly_comparison(
    own: List[Tuple[str, Callable[..., Any]]],
    built_in: List[str],
    scenarios: List[str],
    is_drawn: bool,
    runs: int,
    seed: int,
    fidelity: str,
    threads: int,
    timeout_s: float,
    progress: Optional[Callable[[int, int], Any]],
) -> Table:
    """Flies policies through the scenarios of ``uchain bench chain``, or in drawn places."""

def scenarios() -> List[Tuple[str, str]]: ...
