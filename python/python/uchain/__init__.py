"""The simulator of U-Chain: relay drones that keep a team connected underground.

Quantities are in SI units and carry the unit in their names: ``_m`` metres, ``_s`` seconds, ``_mps``
metres per second, ``_dbm`` dBm, ``_db`` decibels.

>>> import uchain
>>> mission = uchain.run("straight", seed=1)
>>> table = uchain.campaign("straight", seeds=100, vary={"radio.packet_loss": [0.0, 0.2, 0.4]})

Tables have the Arrow PyCapsule interface, so that ``polars.DataFrame(table)`` and
``pyarrow.table(table)`` read them without copying. ``pandas.DataFrame.from_arrow(table)`` reads them
from pandas 3.0 on, and needs pyarrow.
"""

from __future__ import annotations

import json as _json
import operator as _operator
import os as _os
from pathlib import Path as _Path
from typing import Any, Callable, Dict, Iterable, Mapping, Optional, Sequence, Union

from . import cluster as _cluster
from ._uchain import Policy, Simulation as _Simulation, Table, __version__
from ._uchain import fly as _fly
from ._uchain import fly_campaign as _fly_campaign
from ._uchain import fly_comparison as _fly_comparison
from ._uchain import options as _options
from ._uchain import scenarios as _scenarios
from .cluster import read
from .progress import Bar as _Bar
from .radio import RadioLaw

__all__ = [
    "Mission",
    "Policy",
    "RadioLaw",
    "Simulation",
    "Table",
    "__version__",
    "campaign",
    "compare",
    "read",
    "run",
    "scenarios",
]

_Law = Callable[[int, float, float, float, float], float]
#: A policy: a callable, or a class of which an object is made for each mission.
Speed = Union[_Law, Callable[[], _Law]]


class Mission:
    """A mission that was flown: what :func:`run` returns."""

    def __init__(self, flown: Any, seed: int) -> None:
        self._flown = flown
        self.seed = seed
        #: Everything that ``summary.json`` of ``uchain run`` has, as a dict.
        self.summary: dict = _json.loads(flown.summary_json)

    @property
    def success(self) -> bool:
        """Whether the mission succeeded."""
        return self._flown.success

    @property
    def failures(self) -> list:
        """Why it failed, in words; empty for one that succeeded."""
        return self._flown.failures

    @property
    def metrics(self) -> dict:
        """The metrics by name, with their units in the names; ``None`` for one without a value."""
        return self.summary["metrics"]

    @property
    def scenario_toml(self) -> str:
        """The whole scenario as a TOML file with every key, which :func:`run` takes."""
        return self._flown.scenario_toml

    @property
    def trace(self) -> Table:
        """The record: one row for each drone and 0.2 s, in order of time, the head first.

        The columns are those of ``trace.csv``, and ``battery_v``.
        """
        return self._flown.trace()

    def report_html(self) -> str:
        """The page that plays the mission, with all of its data."""
        return self._flown.report_html()

    def _repr_svg_(self) -> str:
        return self._flown.map_svg()

    def __repr__(self) -> str:
        end = "success" if self.success else "; ".join(self.failures)
        return f"<uchain.Mission {self.summary['scenario']}, seed {self.seed}: {end}>"


class Simulation(_Simulation):
    """A mission that is stepped, looked at and steered.

    Parameters are those of :func:`run`. With ``live=True`` the scenario's pilot gives no orders, and
    :meth:`order` does.
    """

    def __new__(
        cls,
        scenario: Union[str, "_os.PathLike[str]"] = "demo",
        seed: int = 1,
        *,
        policy: Union[None, str, Speed] = None,
        live: bool = False,
        timeout_s: float = 10.0,
        **keys: Any,
    ) -> "Simulation":
        callback, keys = _with_policy(policy, _with_law(_checked(keys)))
        return super().__new__(
            cls,
            _os.fspath(scenario),
            _whole("seed", seed),
            policy=callback,
            live=live,
            timeout_s=timeout_s,
            **keys,
        )


def scenarios() -> dict:
    """The built-in scenarios: their titles by their names."""
    return dict(_scenarios())


def run(
    scenario: Union[str, "_os.PathLike[str]"] = "demo",
    seed: int = 1,
    *,
    policy: Union[None, str, Speed] = None,
    timeout_s: float = 10.0,
    **keys: Any,
) -> Mission:
    """Fly one mission.

    :param scenario: the name of a built-in scenario, the path of a scenario file, or its text.
    :param seed: the seed of all random numbers, 0 or more.
    :param policy: the movement policy instead of the scenario's: a name, or a callable
        ``policy(drone, front_dbm, front_mps, back_dbm, back_mps) -> float``. It is called in each
        round of 0.2 s for each relay that hears both of its neighbours, with the relay's number, the
        filtered strength of its link to the neighbour in front, dBm, that neighbour's velocity along
        the tunnel, m/s, positive towards the head, and both of the neighbour behind. It returns the
        relay's forward velocity, m/s. Of a class, an object is made. The filter, the clearance from
        neighbours and the largest speed remain those of the scenario's policy (the key
        ``policy.name``); in place of ``chain``, which works by sums over the whole chain, ``k-tuned``.
    :param timeout_s: the longest time of a call of the policy, in seconds.
    :param keys: other values of keys of the scenario: ``radio={"packet_loss": 0.3}`` or
        ``**{"radio.packet_loss": 0.3}``; and ``radio_law``, a :class:`RadioLaw` in place of the
        scenario's.
    :raises ValueError: where the input cannot be used, with the line that the command prints.
    :raises TimeoutError: where a call of the policy takes longer than ``timeout_s``.
    """
    callback, keys = _with_policy(policy, _with_law(_checked(keys)))
    seed = _whole("seed", seed)
    return Mission(_fly(_os.fspath(scenario), seed, callback, timeout_s, keys), seed)


def campaign(
    scenario: Union[str, "_os.PathLike[str]"],
    seeds: Union[int, Iterable[int]] = 100,
    vary: Optional[Mapping[str, Sequence[Any]]] = None,
    *,
    threads: Optional[int] = None,
    policy: Union[None, str, Speed] = None,
    timeout_s: float = 10.0,
    on: str = "threads",
    out: Union[None, str, "_os.PathLike[str]"] = None,
    parts: Optional[int] = None,
    progress: Optional[bool] = None,
    **keys: Any,
) -> Table:
    """Fly a scenario with many seeds, and with every combination of the values of ``vary``.

    :param scenario: as for :func:`run`.
    :param seeds: the seeds, or how many of them, from 1 on.
    :param vary: the values of keys of the scenario: ``{"radio.packet_loss": [0.0, 0.2]}``; ``"policy"``
        stands for ``"policy.name"``.
    :param threads: how many threads of this machine fly; where left out, as many as it has cores. The
        result does not depend on it.
    :param policy: as for :func:`run`. A callable is called for the missions of all threads, of which one
        at a time runs Python. A policy that remembers something is given as its class, of which an
        object is made for each mission. With a callable, ``out`` and ``on`` are left out. When a call
        fails, no further mission begins, and the error comes out with a note of the seed.
    :param timeout_s: the longest time of a call of the policy, in seconds. The time in which calls of
        several missions are under way is shared among them, so that waits for others do not count.
    :param on: where it is flown: on the ``"threads"`` of this machine, or ``"ray"``: as tasks of a
        cluster of Ray, one for each part. A part whose worker dies is flown again.
    :param out: the folder for the results, with the files of ``uchain campaign --out``; ``on="ray"``
        needs it. Where the campaign was stopped, the same call goes on with it.
    :param parts: the number of parts for ``on="ray"``; where left out, 64. The result does not depend
        on it.
    :param progress: whether a line on standard error says how far it is, from the first second on; where
        left out, on a terminal and in a notebook.
    :param keys: as for :func:`run`. One of ``vary`` is not given here, too.
    :returns: a table with a row for each mission, in the order of the grid (the first key varies
        slowest) and the seeds. The columns are the keys of ``vary``, ``seed``, ``success``, and those
        of ``runs.csv`` of ``uchain campaign``. A value that there is none of is null; a time at which
        nothing happened is infinite.
    :raises ValueError: where the input cannot be used, with the line that the command prints.
    :raises KeyboardInterrupt: after Ctrl-C, when the missions that had begun have ended; a cluster does
        not wait for those.
    """
    if callable(policy) and (out is not None or on != "threads"):
        raise ValueError(
            "a policy of Python flies on this machine's threads only; leave out= and on= out, or give the "
            "name of a policy"
        )
    callback, keys = _with_policy(policy, _with_law(_checked(keys)))
    vary = dict(vary or {})
    if "policy" in vary and "policy.name" in vary:
        raise ValueError('"policy" stands for "policy.name"; give one of them')
    vary = {"policy.name" if key == "policy" else key: values for key, values in vary.items()}
    for key, values in vary.items():
        if isinstance(values, str) or not hasattr(values, "__iter__"):
            raise ValueError(f"{key}: vary takes a list of values for each key")
        vary[key] = values = list(values)
        if key == "policy.name" and any(map(callable, values)):
            raise ValueError("policy: vary takes names of built-in policies; give a callable as policy=")
        if key in _flat(keys):
            raise ValueError(f"{key}: this key is varied and given, too; give it once")
    seeds = _seeds(seeds)
    if threads is not None and threads < 1:
        raise ValueError(f"threads={threads} is out of range; give 1 or more")
    if on not in ("threads", "ray"):
        raise ValueError(f'on="{on}" is no place to fly on; give "threads" or "ray"')
    if on == "ray" and out is None:
        raise ValueError('on="ray" needs a folder for its parts; give out="FOLDER"')
    if on == "ray" and threads is not None:
        raise ValueError('threads= counts on this machine only; leave it out with on="ray"')
    if on == "threads" and parts is not None:
        raise ValueError('parts= counts on a cluster only; leave it out, or give on="ray"')
    parts = 64 if parts is None else parts
    if parts < 1:
        raise ValueError(f"parts={parts} is out of range; give 1 or more")
    missions = _missions(seeds, vary)
    if out is not None:
        words = _words(scenario, seeds, vary, keys)
        folder = _Path(out).absolute()
        if on == "threads":
            return _cluster.here(words, folder, threads, missions, _Bar(progress))
        return _cluster.on_ray(words, folder, min(parts, missions), _Bar(progress, "parts"))
    called = None if callback is None else (callback, timeout_s)
    with _Bar(progress) as bar:
        return _fly_campaign(_os.fspath(scenario), seeds, vary, threads or 0, called, keys, bar)


def compare(
    policies: Union[Speed, Mapping[str, Speed]],
    against: Union[str, Iterable[str]] = ("chain", "k-tuned"),
    *,
    scenarios: Union[str, Iterable[str]] = (),
    drawn: bool = False,
    runs: int = 40,
    seed: int = 1,
    fidelity: str = "point",
    threads: Optional[int] = None,
    timeout_s: float = 10.0,
    progress: Optional[bool] = None,
) -> Table:
    """Fly policies of Python beside built-in ones, all with the same seeds, as ``uchain bench chain`` does.

    >>> uchain.compare(policy, against=["k-tuned"], scenarios=["s-turns-5"])

    :param policies: a callable as :func:`run` takes it, whose rows are called ``python``, or several by
        the names of their rows. Classes are taken, too, of which an object is made for each mission.
    :param against: the names of the built-in policies, or one name.
    :param scenarios: the scenarios of the benchmark, or one; where left out, all of them.
    :param drawn: fly in places that the seeds draw instead, beside an oracle, as
        ``uchain bench chain --drawn``.
    :param runs: the number of missions of a row, or of places.
    :param seed: the first seed.
    :param fidelity: ``"point"`` or ``"flight"``.
    :param threads: as for :func:`campaign`.
    :param timeout_s: the longest time of a call of a policy, in seconds, as for :func:`campaign`.
    :param progress: as for :func:`campaign`.
    :returns: a table with a row for each scenario and policy, and a column for each figure that the
        benchmark has in one of the scenarios; null where it has it not in this one, infinite for a time
        that never came. With ``drawn``, a row for each policy, and for each figure its value and the
        limits of its 95 % interval, ``…_low`` and ``…_high``.
    """
    if not callable(policies) and not isinstance(policies, Mapping):
        raise TypeError(
            "compare takes a callable, or a dict of callables by names; give names of built-in policies "
            "as against="
        )
    own = list(({"python": policies} if callable(policies) else dict(policies)).items())
    against = _names("against", against)
    for name, policy in own:
        if not isinstance(name, str):
            raise TypeError(f"{name!r}: the name of a policy is a string")
        if not callable(policy):
            raise ValueError(f"{name}: this is no callable; give names of built-in policies as against=")
        if name in against:
            raise ValueError(f'"{name}" is a built-in policy; give yours another name')
    if not own and not against:
        raise ValueError("there is no policy to fly; give one or more")
    if _whole("runs", runs) < 1:
        raise ValueError(f"runs={runs} is out of range; give 1 or more")
    if threads is not None and threads < 1:
        raise ValueError(f"threads={threads} is out of range; give 1 or more")
    if fidelity not in ("point", "flight"):
        raise ValueError(f'fidelity="{fidelity}" is no level here; give "point" or "flight"')
    scenarios = _names("scenarios", scenarios)
    if drawn and scenarios:
        raise ValueError("drawn places are no scenarios of the benchmark; leave scenarios= or drawn= out")
    seed = _whole("seed", seed)
    with _Bar(progress) as bar:
        return _fly_comparison(
            own,
            against,
            scenarios,
            drawn,
            runs,
            seed,
            fidelity,
            threads or 0,
            timeout_s,
            bar,
        )


def _with_policy(policy: Union[None, str, Speed], keys: dict) -> tuple:
    """The callable, if the policy is one, and the keys with its name or its table, if it has one."""
    if policy is None or callable(policy):
        return policy, keys
    if isinstance(policy, Mapping):
        return None, {**keys, "policy": dict(policy)}
    if not isinstance(policy, str):
        kind = type(policy).__name__
        raise TypeError(f"policy: the type {kind} is none of one; give a name, a callable, or a class of callables")
    return None, {**keys, "policy.name": policy}


def _checked(keys: dict) -> dict:
    """The keys, of which ``seed`` and ``seeds`` are none."""
    for wrong, right in (("seed", "seeds"), ("seeds", "seed")):
        if wrong in keys:
            raise ValueError(f"{wrong}={keys[wrong]}: this is no key of a scenario; give {right}=")
    return keys


def _with_law(keys: dict) -> dict:
    """The keys with the table of a radio law in place of ``radio_law``."""
    if "radio_law" not in keys:
        return keys
    law = keys["radio_law"]
    if not isinstance(law, RadioLaw):
        raise ValueError("radio_law takes a RadioLaw; give uchain.RadioLaw(law)")
    others = {key: value for key, value in keys.items() if key != "radio_law"}
    # Before the others, so that one of them which belongs to another law is refused.
    return {"radio.model": law.model, **others}


def _flat(keys: Mapping[str, Any], above: str = "") -> Dict[str, Any]:
    """The keys with dots in place of dictionaries."""
    flat: Dict[str, Any] = {}
    for key, value in keys.items():
        if isinstance(value, Mapping) and f"{above}{key}" != "radio.model":
            flat.update(_flat(value, f"{above}{key}."))
        else:
            flat[f"{above}{key}"] = value
    return flat


def _names(name: str, given: Any) -> list:
    """A list of names, of which a single one is given as it is."""
    if isinstance(given, str):
        return [given]
    if not hasattr(given, "__iter__") or not all(isinstance(it, str) for it in given):
        raise TypeError(f"{name} takes a name, or a list of names")
    return list(given)


def _whole(name: str, value: Any) -> int:
    """A seed, which has 64 bits."""
    try:
        whole = _operator.index(value)
    except TypeError:
        raise TypeError(f"{name}={value!r} is no whole number; give one") from None
    if not 0 <= whole < 2**64:
        raise ValueError(f"{name}={whole} is out of range; give a whole number from 0 to 2**64 - 1")
    return whole


def _seeds(seeds: Any) -> list:
    """The seeds that a campaign flies."""
    if isinstance(seeds, str) or not hasattr(seeds, "__iter__"):
        count = _whole("seeds", seeds)
        if not 1 <= count < 2**48:
            raise ValueError(f"seeds={count} is out of range; give the number of seeds, 1 or more, or a list")
        return list(range(1, count + 1))
    listed = [_whole("seeds", seed) for seed in seeds]
    if not listed:
        raise ValueError("seeds: there is none in this list; give one or more, or how many of them")
    return listed


def _words(scenario: Any, seeds: list, vary: Any, keys: dict) -> list:
    """The words of the command line of a campaign."""
    if not seeds or seeds != list(range(seeds[0], seeds[0] + len(seeds))):
        raise ValueError("a campaign with out= flies consecutive seeds; give a number, or a range")
    scenario = _os.fspath(scenario)
    if scenario not in scenarios() and _os.path.exists(scenario):
        scenario = _os.path.abspath(scenario)
    first = ["--runs", str(len(seeds)), "--seed", str(seeds[0])]
    return ["campaign", scenario, *first, *_options(dict(vary or {}), keys)]


def _missions(seeds: Any, vary: Any) -> int:
    """The number of missions of a campaign."""
    count = len(seeds)
    for values in (vary or {}).values():
        count *= len(values)
    return count
