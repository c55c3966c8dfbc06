"""What the environments promise: their libraries' checks, and the same bytes for the same seed."""

import math

import pytest

numpy = pytest.importorskip("numpy")
gymnasium = pytest.importorskip("gymnasium")

env = pytest.importorskip("uchain.env")


def test_gymnasium_checks_the_relay():
    from gymnasium.utils.env_checker import check_env

    check_env(env.RelayEnv(duration_s=10), skip_render_check=True)


def test_pettingzoo_checks_the_relays():
    test = pytest.importorskip("pettingzoo.test")
    test.parallel_api_test(env.parallel_env(duration_s=8), num_cycles=100)
    test.parallel_seed_test(lambda: env.parallel_env(duration_s=8))


def flown(relays, seed):
    """The bytes of an episode in which every relay chooses by its observation."""
    observed, _ = relays.reset(seed=seed)
    record = [observed[agent].tobytes() for agent in relays.agents]
    while relays.agents:
        speeds = {
            agent: 0.02 * (values[3:4] - values[0:1]).clip(-10, 10)
            for agent, values in observed.items()
        }
        observed, rewards, ended, cut, _ = relays.step(speeds)
        assert not any(ended.values())
        record += [values.tobytes() for values in observed.values()]
        record.append(repr(sorted(rewards.items())))
    assert all(cut.values())
    return record


def test_the_same_seed_gives_the_same_bytes():
    pytest.importorskip("pettingzoo")
    relays = env.parallel_env("random-n15", duration_s=6)
    first = flown(relays, 7)
    assert flown(relays, 7) == first
    assert flown(env.parallel_env("random-n15", duration_s=6), 7) == first
    assert flown(relays, 8) != first


def test_the_relay_goes_where_it_is_told(short):
    places = []
    for speed in (0.2, -0.2):
        relay = env.RelayEnv("relay-pair", duration_s=20)
        observed, _ = relay.reset(seed=1)
        assert observed[-1] == 0.0, "it has not heard its neighbours yet"
        over = False
        while not over:
            observed, reward, ended, over, told = relay.step(numpy.array([speed], numpy.float32))
            assert reward < 0.0 and not ended
        assert told["time_s"] == pytest.approx(20.0)
        places.append(observed[0] - observed[3])
    assert places[0] > places[1] + 3.0, "towards the head the front link is the stronger one"


def test_what_is_wrong_is_one_line():
    relay = env.RelayEnv()
    relay.reset(seed=1)
    with pytest.raises(ValueError, match="velocity of drone 1 is NaN"):
        relay.step(numpy.array([math.nan]))
    with pytest.raises(ValueError, match="14 relays"):
        env.RelayEnv("random-n15")
    with pytest.raises(ValueError, match="no relay to steer"):
        env.RelayEnv("straight", drones={"relays": 0})
    with pytest.raises(ValueError, match="did you mean packet_loss"):
        env.RelayEnv(radio={"packet_los": 0.3})
    pytest.importorskip("pettingzoo")
    relays = env.parallel_env()
    with pytest.raises(RuntimeError, match="reset"):
        relays.step({})
    relays.reset(seed=1)
    with pytest.raises(ValueError, match="no action for drone_1"):
        relays.step({})
