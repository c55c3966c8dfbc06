"""What the tests share."""

import pytest

SHORT = """
title = "Two relays in a straight gallery"
duration_s = 40
[tunnel]
width_m = 1.2
centre_line_m = [[0, 0], [12, 0]]
[drones]
relays = 2
[launch]
limit_dbm = -56
[retreat]
limit_dbm = -63
[[pilot]]
at_s = 1
order = "explore"
speed_mps = 0.2
"""


@pytest.fixture
def short():
    """A mission of 40 s with two relays."""
    return SHORT
