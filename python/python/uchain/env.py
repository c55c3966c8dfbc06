"""Environments for reinforcement learning: relays that choose their velocities.

:func:`parallel_env` is a parallel environment of PettingZoo with a relay as each agent, and
:class:`RelayEnv` one of Gymnasium for the only relay of a scenario. They need ``numpy``, ``gymnasium``
and, for the first, ``pettingzoo``: ``pip install './python[env]'`` in the root of the repository.

The drones fly their whole mission; launch, navigation, retreat and the clearance from neighbours that
are too near remain those of the on-board code. The agents choose what the movement policy would: the
velocity along the tunnel of each relay that flies and hears both of its neighbours. In other rounds an
action has no effect, and the value ``steers`` of the observation is 0.

An observation is an array of the values that :data:`OBSERVED` names. The reward of all agents is a tenth
of the strength of the chain's weakest link in dBm, without the antennas and their errors: it is negative,
and the larger the better. An episode ends (is truncated) with the mission.
"""

from __future__ import annotations

import os as _os
from typing import Any, Dict, Optional, Union

import gymnasium as _gymnasium
import numpy as _numpy

try:
    from pettingzoo import ParallelEnv as _ParallelEnv
except ImportError:  # RelayEnv does without.
    _ParallelEnv = object

from . import _checked, _with_law
from ._uchain import Steered as _Steered

__all__ = ["OBSERVED", "ParallelRelays", "RelayEnv", "parallel_env"]

#: The values of an observation, with their lowest and highest: the filtered strength of the link to the
#: neighbour in front (-127 dBm where it is not heard), its change since the step before, that neighbour's
#: velocity along the tunnel, the same of the neighbour behind, the voltage of the battery (0 where points
#: fly, which have none), and whether the relay flies by its agent.
OBSERVED = {
    "front_dbm": (-127.0, 20.0),
    "front_db_s": (-1000.0, 1000.0),
    "front_mps": (-10.0, 10.0),
    "back_dbm": (-127.0, 20.0),
    "back_db_s": (-1000.0, 1000.0),
    "back_mps": (-10.0, 10.0),
    "battery_v": (0.0, 5.0),
    "steers": (0.0, 1.0),
}

_LOWEST = _numpy.array([low for low, _ in OBSERVED.values()], dtype=_numpy.float32)
_HIGHEST = _numpy.array([high for _, high in OBSERVED.values()], dtype=_numpy.float32)


class _Steering:
    """The mission that both kinds of environment steer."""

    def __init__(self, scenario: Any, rounds: int, keys: dict) -> None:
        if rounds < 1:
            raise ValueError(f"rounds_per_step={rounds} is out of range; give 1 or more")
        self.mission = _Steered(_os.fspath(scenario), _with_law(_checked(keys)))
        self.rounds = rounds
        fastest = self.mission.max_speed_mps
        self.action_space = _gymnasium.spaces.Box(-fastest, fastest, (1,), _numpy.float32)
        self.observation_space = _gymnasium.spaces.Box(_LOWEST, _HIGHEST, dtype=_numpy.float32)

    def restart(self, seed: int) -> Any:
        return self._read(self.mission.restart(seed))

    def step(self, speeds: list) -> tuple:
        observed, weakest_dbm, goes_on = self.mission.step(speeds, self.rounds)
        return self._read(observed), weakest_dbm / 10.0, goes_on

    def _read(self, observed: bytes) -> Any:
        values = _numpy.frombuffer(observed, dtype=_numpy.float32).reshape(-1, len(OBSERVED))
        return _numpy.clip(values, _LOWEST, _HIGHEST)


def _seed_of(seed: Optional[int], random: Any) -> int:
    """The seed of a mission: the one given, or the next of the environment's."""
    return int(random.integers(2**32)) if seed is None else int(seed)


class RelayEnv(_gymnasium.Env):
    """The only relay of a scenario, for Gymnasium.

    :param scenario: as for :func:`uchain.run`; its key ``drones.relays`` has to be 1.
    :param rounds_per_step: how many rounds of 0.2 s an action lasts.
    :param keys: as for :func:`uchain.run`.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        scenario: Union[str, "_os.PathLike[str]"] = "relay-pair",
        *,
        rounds_per_step: int = 1,
        **keys: Any,
    ) -> None:
        self._steering = _Steering(scenario, rounds_per_step, keys)
        count = len(self._steering.mission.drones)
        if count != 1:
            raise ValueError(
                f"the scenario has {count} relays; give drones={{'relays': 1}}, or use parallel_env"
            )
        self.action_space = self._steering.action_space
        self.observation_space = self._steering.observation_space

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict] = None) -> tuple:
        """Begin the mission of a seed; without one, of a seed that the environment draws."""
        super().reset(seed=seed)
        return self._steering.restart(_seed_of(seed, self.np_random))[0], {}

    def step(self, action: Any) -> tuple:
        """Fly on with a velocity towards the head, m/s."""
        observed, reward, goes_on = self._steering.step([float(_numpy.asarray(action).item())])
        return observed[0], reward, False, not goes_on, {"time_s": self._steering.mission.time_s}


class ParallelRelays(_ParallelEnv):
    """The relays of a scenario, for PettingZoo. See :func:`parallel_env`."""

    metadata = {"name": "uchain_relays_v0", "render_modes": [], "is_parallelizable": True}
    render_mode = None

    def __init__(
        self,
        scenario: Union[str, "_os.PathLike[str]"] = "random-n15",
        *,
        rounds_per_step: int = 1,
        **keys: Any,
    ) -> None:
        if _ParallelEnv is object:
            raise ImportError("parallel_env needs PettingZoo: pip install pettingzoo")
        self._steering = _Steering(scenario, rounds_per_step, keys)
        self.possible_agents = [f"drone_{n}" for n in self._steering.mission.drones]
        self.agents: list = []
        self._random: Any = None
        self.observation_spaces = {
            agent: self._steering.observation_space for agent in self.possible_agents
        }
        self.action_spaces = {agent: self._steering.action_space for agent in self.possible_agents}

    def observation_space(self, agent: str) -> Any:
        """The space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The space of an agent's actions: its velocity towards the head, m/s."""
        return self.action_spaces[agent]

    def reset(self, seed: Optional[int] = None, options: Optional[dict] = None) -> tuple:
        """Begin the mission of a seed; without one, of a seed that the environment draws."""
        if seed is not None or self._random is None:
            self._random = _numpy.random.default_rng(seed)
        self.agents = list(self.possible_agents)
        observed = self._steering.restart(_seed_of(seed, self._random))
        return dict(zip(self.agents, observed)), {agent: {} for agent in self.agents}

    def step(self, actions: Dict[str, Any]) -> tuple:
        """Fly on with a velocity of each agent."""
        if not self.agents:
            raise RuntimeError("the mission is over; call reset")
        unknown = set(actions) - set(self.agents)
        missing = set(self.agents) - set(actions)
        if unknown or missing:
            wrong = f"no agent {min(unknown)}" if unknown else f"no action for {min(missing)}"
            raise ValueError(f"{wrong}; give an action for each of {', '.join(self.agents)}")
        speeds = [float(_numpy.asarray(actions[agent]).item()) for agent in self.agents]
        observed, reward, goes_on = self._steering.step(speeds)
        agents = self.agents
        told = {"time_s": self._steering.mission.time_s}
        if not goes_on:
            self.agents = []
        return (
            dict(zip(agents, observed)),
            dict.fromkeys(agents, reward),
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, not goes_on),
            {agent: dict(told) for agent in agents},
        )

    def render(self) -> None:
        """Nothing is drawn; fly the mission with :func:`uchain.run` to see it."""

    def close(self) -> None:
        """There is nothing to close."""


def parallel_env(
    scenario: Union[str, "_os.PathLike[str]"] = "random-n15",
    *,
    rounds_per_step: int = 1,
    **keys: Any,
) -> ParallelRelays:
    """The relays of a scenario as agents of a parallel environment of PettingZoo.

    :param scenario: as for :func:`uchain.run`, with one relay or more.
    :param rounds_per_step: how many rounds of 0.2 s an action lasts.
    :param keys: as for :func:`uchain.run`.
    """
    return ParallelRelays(scenario, rounds_per_step=rounds_per_step, **keys)
