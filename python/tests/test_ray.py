"""A campaign on a cluster of Ray, one node of which is killed, is the campaign of this machine."""

import os
import signal
import threading
import time

import pytest

import uchain
from uchain import cluster

ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

VARY = {"radio.packet_loss": [0.0, 0.5]}


@pytest.fixture(scope="module")
def nodes():
    """A cluster of three nodes, the first of which flies nothing."""
    started = cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    flying = [started.add_node(num_cpus=1) for _ in range(2)]
    started.wait_for_nodes()
    ray.init(address=started.address, log_to_driver=False)
    yield started, flying
    ray.shutdown()
    started.shutdown()


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_node_that_is_killed_changes_nothing(nodes, tmp_path, short):
    started, flying = nodes
    here, there = tmp_path / "here", tmp_path / "there"
    table = uchain.campaign(short, 6, VARY, out=here)
    parts = there.with_name("there.parts")

    def kill():
        # As soon as the first part is there, so that others are under way.
        while not any(path.name.isdigit() for path in parts.glob("*")):
            time.sleep(0.02)
        started.remove_node(flying[1], allow_graceful=False)

    killer = threading.Thread(target=kill)
    killer.start()
    again = uchain.campaign(short, 6, VARY, on="ray", out=there, parts=6)
    killer.join()
    assert repr(again.to_dict()) == repr(table.to_dict())
    assert files(there) == files(here)
    assert not parts.exists()


def test_wrong_input_is_one_line(nodes, tmp_path, short):
    with pytest.raises(ValueError) as error:
        uchain.campaign(short, 2, on="ray", out=tmp_path / "out", radio={"packet_los": 0.1})
    assert "did you mean packet_loss" in str(error.value) and "\n" not in str(error.value)


def dying(marker):
    """What flies a part, but that its worker dies in the second one: each time, or with a marker once."""
    part = cluster._part

    def fly(options, number, of):
        if number == 2 and (marker is None or not marker.exists()):
            if marker is not None:
                marker.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return part(options, number, of)

    return fly


def test_the_part_of_a_worker_that_dies_is_flown_again(nodes, tmp_path, short, monkeypatch):
    here, there = tmp_path / "here", tmp_path / "there"
    uchain.campaign(short, 4, out=here, duration_s=5)
    monkeypatch.setattr(cluster, "_part", dying(tmp_path / "died"))
    uchain.campaign(short, 4, on="ray", out=there, parts=3, duration_s=5)
    assert (tmp_path / "died").exists()
    assert files(there) == files(here)


def test_a_part_whose_workers_all_die_is_one_line_and_the_others_are_kept(
    nodes, tmp_path, short, monkeypatch
):
    here, there = tmp_path / "here", tmp_path / "there"
    uchain.campaign(short, 4, out=here, duration_s=5)
    with monkeypatch.context() as patched:
        patched.setattr(cluster, "_part", dying(None))
        patched.setattr(cluster, "RETRIES", 1)
        with pytest.raises(RuntimeError) as error:
            uchain.campaign(short, 4, on="ray", out=there, parts=2, duration_s=5)
    assert "part 2/2 was lost with its worker" in str(error.value) and "\n" not in str(error.value)
    assert not there.exists()
    uchain.campaign(short, 4, on="ray", out=there, parts=2, duration_s=5)
    assert files(there) == files(here)
