#!/usr/bin/python3
"""live_rules.py COMMAND SCENES: who may ask the live page's server, how much, how often, and what it answers. No browser."""

import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time

from live_server import LiveServer, number

command, scenes = sys.argv[1:]
brace = f"{scenes}/brace.toml"


def check_who(live):
    page = f"/{live.token}/"
    run = page + "run"
    plan = {"action": "plan", "settings": {}}
    expected = [
        (200, live.ask(page)),
        (200, live.ask(page, Host=f"localhost:{live.port}")),
        (200, live.ask(run, plan)),
        (403, live.ask(page, Host="example.org")),
        (403, live.ask(page, Host=f"example.org:{live.port}")),
        (403, live.ask(page, Host=f"127.0.0.1:{live.port + 1}")),
        (403, live.ask(page, Host="127.0.0.1")),
        (403, live.ask(page, Origin="http://example.org")),
        (403, live.ask(run, plan, Origin="http://example.org")),
        (403, live.ask(run, plan, Origin="null")),
        (403, live.ask(run, plan, Origin=None)),
        (403, live.ask(run, plan, Origin=f"https://127.0.0.1:{live.port}")),
        (403, live.ask(run, plan, Origin=f"http://localhost:{live.port}")),  # another origin than the page's own
        (404, live.ask("/")),
        (404, live.ask("/run", plan)),
        (404, live.ask("/" + "0" * 32 + "/run", plan)),
        (404, live.ask(f"/{live.token[:-1]}/run", plan)),
        (404, live.ask(f"/{live.token}0/run", plan)),
        (404, live.ask(f"/{live.token}")),
        (404, live.ask(page + "other", plan)),
        (404, live.ask(page + "../../etc/passwd")),
        (404, live.ask(page + "%2e%2e/%2e%2e/etc/passwd")),
        (404, live.ask("/etc/passwd")),
        (404, live.ask(run)),  # asked for as a page
        (415, live.ask(run, plan, Content_Type="text/plain")),
        (415, live.ask(run, plan, Content_Type="application/x-www-form-urlencoded")),
        (400, live.ask(run, b"no JSON")),
        (400, live.ask(run, b"[" * 60000)),
        (400, live.ask(run, b"[" * 30000 + b"]" * 30000)),
        (413, live.ask(run, {"action": "plan", "settings": {}, "more": "x" * 70000})),
    ]
    for i, (status, (found, headers, text)) in enumerate(expected):
        assert found == status, f"request {i}: found {found}, expected {status}: {text[:200]}"
        assert "root:" not in text and ("token" not in text or status == 200), text[:200]
        if status not in (413,):
            assert "default-src 'none'" in headers["Content-Security-Policy"] and "unsafe" not in headers["Content-Security-Policy"]
            assert headers["Cache-Control"] == "no-store" and headers["X-Content-Type-Options"] == "nosniff"
            assert "Access-Control-Allow-Origin" not in headers
    for method in ("PUT", "DELETE", "OPTIONS", "PATCH"):
        assert live.ask(run, plan, method=method)[0] >= 400, method
    # Nobody else on the network reaches it.
    for address in {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {"127.0.0.1"}:
        if not address.startswith("127."):
            assert socket.socket().connect_ex((address, live.port)) != 0, address


def check_plain(live):
    """Compressing an answer would take longer than the plan."""
    _, headers, text = live.ask(f"/{live.token}/run", {"action": "plan", "settings": {}}, Accept_Encoding="gzip, deflate, br")
    assert "Content-Encoding" not in headers and json.loads(text)["drawing"]["drawing"] == 2


def check_settings(live):
    """What the page does not offer cannot be set; what is no value of its kind is refused, at its place."""
    refused = [
        ({"title": "x"}, "does not offer"),
        ({"start.file": "/etc/passwd"}, "does not offer"),
        ({"trajectory.file": "x.csv"}, "does not offer"),
        ({"rod.file": "/etc/passwd"}, "does not offer"),
        ({"include": ["/etc/passwd"]}, "does not offer"),
        ({"solver.options.option_file_name": "x"}, "does not offer"),
        ({"solver.plugin": "../../x"}, "one of the words offered"),
        ({"contact.mode": "allow\"\nx = 1"}, "one of the words offered"),
        ({"target.position": "x"}, "points"),
        ({"target.position": [["1", 2]]}, "expected a number"),
        ({"target.position": [[1, 2], [3, 4]]}, "a list of 1 points"),
        ({"obstacle.0.radius": {"x": 1}}, "expected a number"),
        ({"obstacle.0.radius": 1e300}, "expected a number"),
        ({"obstacle.0.radius": -1}, "obstacle.0.radius: "),
    ]
    for settings, part in refused:
        status, body = live.run(settings)
        assert status == 400 and part in body["error"], (settings, status, body)
        assert set(settings) & {"solver.plugin", "contact.mode", "target.position", "obstacle.0.radius"} == ({body["key"]} if "key" in body else set()), body
    # What is wrong with several keys together is told at the first one of their table.
    status, body = live.run({"obstacle.0.center": [[0, 0]]})
    assert status == 400 and "lies around the rod's base" in body["error"] and body["key"].startswith("obstacle.0."), body
    for request in ({}, [], {"settings": {}}, {"settings": [], "action": "plan"}, {"settings": {}, "action": "remove"}, 5,
                    {"settings": {}, "action": "execute", "inputs": "1"}, {"settings": {}, "action": "execute", "inputs": [1, 2]}):
        assert live.ask(f"/{live.token}/run", request)[0] == 400, request
    assert live.run()[0] == 200, "it goes on"


def check_numbers(live, directory):
    """The saved scene, planned by the command, gives the page's numbers."""
    settings = {"target.position": [[94.5, 16.25]], "obstacle.0.center": [[58.5, -1.125]], "rod.actuator.0.limit": 3.5}
    status, body = live.run(settings)
    assert status == 200, body
    text = json.loads(live.ask(f"/{live.token}/scene", {"settings": settings})[2])["text"]
    saved = directory / "scene.toml"
    saved.write_text(text)
    assert '"94.5 mm"' in text and '"3.5 N mm"' in text, text
    result = json.loads(subprocess.run([command, "plan", saved, "--json"], capture_output=True, check=True).stdout)
    for name, value in (("tip x", result["tip"]["x"]), ("tip y", result["tip"]["y"]), ("force of obstacle 1", result["contacts"][0]["force"]),
                        ("moment 1", result["moments"][0])):
        assert abs(number(body["drawing"], name) - value) <= 1e-9 * max(1e-3, abs(value)), name
    kept = json.loads(json.loads(live.ask(f"/{live.token}/result", {"number": body["number"]})[2])["text"])
    assert kept["tip"] == result["tip"] and kept["status"] == "solved"
    # Executed, the planned moments lead to the planned tip; followed, a plan leads to the same plan.
    _, executed = live.run(settings, "execute", inputs=[i["value"] for i in result["inputs"]])
    assert abs(number(executed["drawing"], "tip x") - result["tip"]["x"]) < 1e-7
    status, followed = live.run(settings, "follow")
    assert abs(number(followed["drawing"], "tip x") - result["tip"]["x"]) < 1e-7
    assert live.ask(f"/{live.token}/result", {"number": body["number"]})[0] == 409
    # Friction is offered although the scene says nothing of it.
    contact = live.run({"contact.friction": 0.3})[1]["drawing"]["frames"][0]["contacts"][0]
    assert contact["friction"] == 0.3 and abs(contact["tangent"][0] * contact["normal"][0] + contact["tangent"][1] * contact["normal"][1]) < 1e-12
    status, other = live.run({"coordinates.plugin": "pcc"})
    assert status == 200 and any("order" in item for item in other["dropped"]), other["dropped"]


def check_kinds():
    """A scene that is executed only, a grasp that is moved by pressures, a trajectory."""
    with LiveServer(command, f"{scenes}/tentacle.toml") as live:
        status, body = live.run(action="execute")
        assert status == 200 and body["drawing"]["frames"][-1]["rods"][0]["body"], body
    with LiveServer(command, f"{scenes}/grasp_60mm.toml") as live:
        _, planned = live.run()
        assert [i["unit"] for i in planned["inputs"]] == ["Pa", "Pa"]
        status, body = live.run(action="execute", inputs=[i["value"] for i in planned["inputs"]])
        assert status == 200 and abs(number(body["drawing"], "tip x") - number(planned["drawing"], "tip x")) < 1e-7
    with LiveServer(command, f"{scenes}/trajectory.toml") as live:
        assert len(live.run()[1]["drawing"]["frames"]) == 45


def check_latest(command, directory):
    """A plan that takes long is ended by the next request, and answered as out of date."""
    with LiveServer(command, f"{scenes}/clutter.toml", "--set", "search.effort=thorough", "--set", "solver.time_limit=60") as live:
        late = []
        thread = threading.Thread(target=lambda: late.append(live.run()))
        thread.start()
        time.sleep(0.3)
        begin = time.monotonic()
        status, _ = live.run({}, "execute", inputs=[0.0])
        assert status == 200 and time.monotonic() - begin < 20.0
        thread.join()
        assert late[0][0] == 409, late
        # Ctrl-C does not wait for a plan.
        thread = threading.Thread(target=lambda: late.append(None if live.process.poll() else swallow(live)))
        thread.start()
        time.sleep(0.3)
        begin = time.monotonic()
        code, _, err = live.interrupt()
        assert code == 0 and err == "" and time.monotonic() - begin < 15.0, (code, err)
        thread.join()


def swallow(live):
    try:
        return live.run()
    except (OSError, ValueError) as error:
        return error


def check_speed(live):
    """Plans a second as a hand drags, then faster than is allowed."""
    time.sleep(1.0)
    count, begin = 0, time.monotonic()
    while time.monotonic() - begin < 1.0:
        status, _ = live.run({"target.position": [[95 + count % 7 * 0.3, 18 + count % 5 * 0.4]]})
        assert status == 200, status
        count += 1
    print(f"{count / (time.monotonic() - begin):.0f} plans a second of brace.toml")
    statuses = []
    threads = [threading.Thread(target=lambda: statuses.extend(live.ask("/")[0] for _ in range(100))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert 429 in statuses and set(statuses) <= {403, 404, 429}, set(statuses)
    time.sleep(1.1)
    assert live.ask(f"/{live.token}/")[0] == 200, "it goes on"


def check_idle(live):
    """A page that is left open costs nothing."""
    clock = pathlib.Path(f"/proc/{live.process.pid}/stat")
    spent = lambda: sum(int(field) for field in clock.read_text().rsplit(")", 1)[1].split()[11:13])
    before = spent()
    time.sleep(1.0)
    assert spent() - before <= 1, "hundredths of a second in a second"


def check_ports(live):
    """A port that is taken, a scene that cannot be read: one line each."""
    for options, part in ((["--port", str(live.port)], f"--port {live.port}: the port cannot be opened"), (["--set", "rod.length=-1"], "rod.length"),
                          (["--port", "0"], "--port"), (["--port", "70000"], "--port")):
        run = subprocess.run([command, "live", brace, "--no-browser", *options], capture_output=True, text=True, timeout=30)
        assert run.returncode == 2 and run.stdout == "" and part in run.stderr and run.stderr.count("\n") == 1, (options, run)
    run = subprocess.run([command, "live", f"{scenes}/estimate.toml", "--no-browser"], capture_output=True, text=True, timeout=30)
    assert run.returncode == 2 and "nothing to drag" in run.stderr, run


def check_start(directory):
    """The browser is given a file that leads to the page, which is gone when the server is; without a server there is a line."""
    opener = directory / "xdg-open"
    opener.write_text(f'#!/bin/sh\ncat "$1" > {directory}/opened.part && echo "$1" > {directory}/named && mv {directory}/opened.part {directory}/opened\n')
    opener.chmod(0o755)
    environment = {**os.environ, "PATH": f"{directory}:{os.environ['PATH']}", "DISPLAY": ":none"}
    for display, options, opened in ((":none", [], True), (":none", ["--no-browser"], False), (None, [], False)):
        given = {name: value for name, value in environment.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY") or value == display}
        with LiveServer(command, brace, *options, environment=given) as live:
            for _ in range(100 if opened else 5):
                if (directory / "opened").exists():
                    break
                time.sleep(0.05)
            assert (directory / "opened").exists() == opened, options
            if opened:
                assert f"url={live.address}" in (directory / "opened").read_text()
                file = pathlib.Path((directory / "named").read_text().strip())
                assert file.stat().st_mode & 0o077 == 0 or file.parent.stat().st_mode & 0o077 == 0, "nobody else can read it"
            assert live.interrupt()[0] == 0
        if opened:
            assert not file.parent.exists()
            (directory / "opened").unlink()
    for library in pathlib.Path(command).parent.parent.glob("lib/libtendril-http.so.*"):
        (directory / library.name).write_text("no library")
    run = subprocess.run([command, "live", brace], capture_output=True, text=True, timeout=30, env={**os.environ, "LD_LIBRARY_PATH": str(directory)})
    assert run.returncode == 2 and "the page's server cannot be loaded" in run.stderr and run.stderr.count("\n") == 1, run


def main():
    with tempfile.TemporaryDirectory() as name, LiveServer(command, brace) as live:
        check_who(live)
        check_start(pathlib.Path(name))
        check_plain(live)
        check_settings(live)
        check_numbers(live, pathlib.Path(name))
        check_ports(live)
        check_kinds()
        check_speed(live)
        check_idle(live)
        check_latest(command, pathlib.Path(name))
        code, _, err = live.interrupt()
        assert code == 0 and err == "", (code, err)
        with LiveServer(command, brace, "--port", str(live.port)) as again:
            assert again.token != live.token and again.port == live.port


main()
