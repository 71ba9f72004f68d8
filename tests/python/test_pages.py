"""What the command writes for eyes: pages, pictures, movies, and the live page, all with components of this process."""

import http.client
import json
import os
import signal
import threading
import urllib.parse

import numpy as np
import pytest

import tendril
from test_components import DISC, Disc


@pytest.fixture
def disc(brace):
    tendril.obstacle("disc", options=DISC)(Disc)
    scene = brace.copy({"obstacle": [{"shape": "disc", "radius": "8 mm", "x": "60 mm", "y": "0 mm"}]})
    yield tendril.Scene(scene.to_dict())  # of no file
    tendril.unregister("disc")


def test_a_page_and_a_picture(disc, tmp_path):
    plan = disc.plan()
    plan.view(tmp_path / "plan.html")
    plan.view(tmp_path / "plan.svg")
    page = (tmp_path / "plan.html").read_text()
    drawing = json.loads(page.split('id="drawing">')[1].split("</script>")[0])
    outline = np.array(drawing["obstacles"][0]["outlines"][0])
    assert np.hypot(outline[:, 0] - 0.06, outline[:, 1]) == pytest.approx(np.full(len(outline), 0.008), abs=1e-6)
    assert "<svg" in (tmp_path / "plan.svg").read_text()


def test_a_movie(scenes, tmp_path):
    document = tendril.load(scenes / "trajectory.toml").trajectory().to_dict()
    few = tendril.Trajectory({**document, "steps": document["steps"][:3]})
    few.view(tmp_path / "way.gif")
    assert (tmp_path / "way.gif").read_bytes().startswith(b"GIF8")


def test_what_cannot_be_viewed_is_refused(brace, tmp_path):
    plan = brace.plan()
    with pytest.raises(tendril.Error, match="plan.xyz"):
        plan.view(tmp_path / "plan.xyz")
    with pytest.raises(tendril.Error, match="one frame"):
        plan.view(tmp_path / "plan.gif")
    with pytest.raises(TypeError, match="file"):
        plan.view(3)
    with pytest.raises(tendril.Error, match="backbone"):
        brace.describe().view(tmp_path / "plan.svg")
    assert list(tmp_path.iterdir()) == []


def test_the_live_page_plans_with_components_of_this_process(disc):
    planned = []

    def ask(address):
        place = urllib.parse.urlsplit(address)
        connection = http.client.HTTPConnection(place.netloc)
        connection.request("GET", place.path)
        page = connection.getresponse().read().decode()
        connection.request("POST", place.path + "run", json.dumps({"action": "plan", "settings": {}}),
                           {"Content-Type": "application/json", "Origin": f"http://{place.netloc}"})
        planned.extend([page, json.loads(connection.getresponse().read())])
        os.kill(os.getpid(), signal.SIGINT)

    disc.live(browser=False, ready=lambda address: threading.Thread(target=ask, args=(address,)).start())
    page, answer = planned
    assert page.startswith("<!DOCTYPE html>")
    force = answer["drawing"]["frames"][-1]["contacts"][0]["force"]
    assert force == pytest.approx(disc.plan().contacts[0].force, rel=1e-6)


def test_wrong_ports(brace):
    for port in (-1, 65536, 1.5, "80", True):
        with pytest.raises(ValueError, match="port"):
            brace.live(port=port)


def test_the_command_is_at_hand(tmp_path):
    assert tendril.command("--version").strip() == tendril.__version__
    assert "`max_force`" in tendril.command("reference", "keys")
    tendril.command("new", "objective", "my_term", tmp_path / "my_term")
    assert (tmp_path / "my_term" / "CMakeLists.txt").exists()
    with pytest.raises(tendril.Error, match="did you mean 'plan'"):
        tendril.command("plann")
    with pytest.raises(TypeError, match=r"arguments\[1\]"):
        tendril.command("plan", 3)
