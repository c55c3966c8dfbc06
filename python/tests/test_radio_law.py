"""Radio laws of one's own: the table that a callable gives, and what it does wrong."""

import math
import time

import pytest

import uchain


def free_space(distance_m, walls):
    return 40.0 + 20.0 * math.log10(distance_m) + 20.0 * walls


def test_a_law_that_copies_free_space_flies_as_log_distance(short):
    law = uchain.RadioLaw(free_space)
    own = uchain.run(short, seed=3, radio={"model": {"law": "log-distance", "corner_db": 20.0}})
    called = uchain.run(short, seed=3, radio_law=law)
    for name in ("farthest_m", "launched"):
        assert called.metrics[name] == pytest.approx(own.metrics[name], abs=0.2)
    again = uchain.run(called.scenario_toml, seed=3)
    assert again.summary["metrics"] == called.summary["metrics"]


def test_walls_and_distances_count(short):
    near = uchain.run(short, radio_law=uchain.RadioLaw(free_space))
    far = uchain.run(short, radio_law=uchain.RadioLaw(lambda d, w: free_space(d, w) + 12.0))
    assert far.metrics["farthest_m"] < near.metrics["farthest_m"]
    law = uchain.RadioLaw(free_space, distances_m=[1, 10], walls=1)
    assert law.losses_db == [[40.0, 60.0], [60.0, 80.0]]
    assert uchain.RadioLaw(lambda d, w: 1000.0).losses_db[0][0] == 400.0
    table = uchain.campaign(short, 2, radio_law=law, duration_s=5)
    assert len(table) == 2


def test_what_a_law_does_wrong_is_told(short):
    with pytest.raises(ValueError, match=r"returned NaN for 0.2\d* m and 0 walls"):
        uchain.RadioLaw(lambda *_: math.nan)
    with pytest.raises(ZeroDivisionError):
        uchain.RadioLaw(lambda *_: 1 / 0)
    with pytest.raises(TypeError):
        uchain.RadioLaw(lambda *_: "weak")
    with pytest.raises(ValueError, match="returned -3 for"):
        uchain.RadioLaw(lambda *_: -3.0)
    with pytest.raises(ValueError, match="each greater than the one before"):
        uchain.RadioLaw(free_space, distances_m=[2, 1])
    with pytest.raises(ValueError, match="RadioLaw"):
        uchain.run(short, radio_law=free_space)


def without_end(*_):
    while True:
        pass


def test_what_never_returns_is_ended(short):
    with pytest.raises(TimeoutError, match="the radio law took longer than 0.2 s"):
        uchain.RadioLaw(without_end, timeout_s=0.2)
    with pytest.raises(TimeoutError, match="the radio law took longer than 0.2 s"):
        uchain.RadioLaw(lambda *_: time.sleep(0.6) or 50.0, timeout_s=0.2)
    with pytest.raises(TimeoutError, match="the policy took longer than 0.2 s for drone 1"):
        uchain.run("relay-pair", policy=without_end, timeout_s=0.2)
    simulation = uchain.Simulation("relay-pair", policy=without_end, timeout_s=0.2)
    with pytest.raises(TimeoutError, match="the policy took longer"):
        simulation.step(1000)
    with pytest.raises(ValueError, match="timeout_s"):
        uchain.RadioLaw(free_space, timeout_s=0.0)
    # Nothing is left over of it.
    assert uchain.run(short, duration_s=2).summary["seed"] == 1
