#!/usr/bin/python3
"""live_page.py COMMAND SCENES: the live page in a real browser: dragged, changed, undone, saved, and compared with the command."""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

from browser import Browser, Missing
from dragging import drags, page_memory, server_memory
from live_server import LiveServer

command, scenes = sys.argv[1:]

# Everything that was asked for is shown.
SETTLED = "return window.live && !live.pending && live.shown === live.asked"


def settle(browser):
    browser.wait(SETTLED, seconds=60)


def shown(browser):
    """Numbers beside the picture, by name."""
    return dict(browser.run("return [...document.querySelectorAll('td[data-value]')].map((c) => [c.dataset.name, Number(c.dataset.value)])"))


def handle(browser, name):
    """Where something can be taken, in pixels of the window."""
    return browser.run("""
        const box = live.viewer.canvas.getBoundingClientRect();
        const p = live.viewer.to_screen(live.handles().find((h) => h.name === arguments[0]).at);
        return [box.left + p[0], box.top + p[1]];""", name)


def drag(browser, name, by, steps=5):
    x, y = handle(browser, name)
    browser.drag([(x + by[0] * i / steps, y + by[1] * i / steps) for i in range(steps + 1)])
    settle(browser)


def download(browser, directory, button, name):
    file = directory / name
    file.unlink(missing_ok=True)
    browser.run("[...document.querySelectorAll('footer button')].find((b) => b.textContent === arguments[0]).click()", button)
    for _ in range(200):
        if file.exists() and file.stat().st_size > 0:
            return file
        time.sleep(0.05)
    raise AssertionError(f"{name} was not saved: {browser.messages()}")


def check_dragging(browser, directory):
    first = shown(browser)
    drag(browser, "target", (-20, -12))
    moved = shown(browser)
    assert abs(moved["tip y"] - first["tip y"]) > 1e-4, "the tip follows the target"
    drag(browser, "obstacle 1", (6, -4))
    drag(browser, "base", (-3, 5))
    last = shown(browser)
    assert last["force of obstacle 1"] != moved["force of obstacle 1"]
    scene = download(browser, directory, "Save scene", "scene.toml")
    result = json.loads(subprocess.run([command, "plan", scene, "--json"], capture_output=True, check=True).stdout)
    for name, value in (("tip x", result["tip"]["x"]), ("tip y", result["tip"]["y"]), ("force of obstacle 1", result["contacts"][0]["force"])):
        assert abs(last[name] - value) <= 1e-9 * max(abs(value), 1e-3), (name, last[name], value)
    kept = json.loads(download(browser, directory, "Save result", "result.json").read_text())
    assert kept["tip"] == result["tip"]
    for button, name, start in (("PNG", "tendril.png", b"\x89PNG"), ("SVG", "tendril.svg", b"<svg ")):
        assert download(browser, directory, button, name).read_bytes().startswith(start), name
    for _ in range(3):
        browser.run("live.undo()")
        settle(browser)
    assert shown(browser) == first, "taken back"
    for _ in range(3):
        browser.run("live.redo()")
        settle(browser)
    assert shown(browser) == last, "and done again"


def check_controls(browser):
    # A weak motor: a slider, its number, and what it says.
    browser.run("""
        const field = document.querySelector('[data-key="rod.actuator.0.limit"] input[type=number]');
        field.value = "0.5"; field.dispatchEvent(new Event("input")); field.dispatchEvent(new Event("change"));""")
    settle(browser)
    assert abs(shown(browser)["moment 1"]) <= 0.5e-3 * (1 + 1e-9)
    assert browser.run("return document.querySelector('[data-key=\"rod.actuator.0.limit\"] input[type=range]').value") == "0.5"
    # Nonsense is told at its place, and the page goes on.
    browser.run("live.change('obstacle.0.radius', -3, true)")
    settle(browser)
    assert browser.run("return document.querySelector('[data-key=\"obstacle.0.radius\"] .message').textContent")
    browser.run("live.undo()")
    settle(browser)
    assert not browser.run("return document.querySelector('[data-key=\"obstacle.0.radius\"] .message').textContent")
    browser.run("live.change('obstacle.0.center', [[0, 0]], true)")  # over the base
    settle(browser)
    assert "around the rod's base" in browser.run("return document.querySelector('[data-key^=\"obstacle.0.\"] .message').textContent")
    browser.run("live.undo()")
    settle(browser)
    for solver in browser.run("return live.rows.get('solver.plugin').control.choices"):
        browser.run("live.change('solver.plugin', arguments[0], true)", solver)
        settle(browser)
        assert browser.run("return live.viewer.status.textContent") == "solved", solver
    browser.run("[...document.querySelectorAll('.bar button')].find((b) => b.textContent === 'Execute').click()")
    settle(browser)
    assert browser.run("return live.trouble.textContent") == "" and "executed in" in browser.run("return live.busy.textContent")
    planned = shown(browser)["tip y"]
    browser.run("""
        const field = live.input_rows.querySelector("input[type=number]");
        field.value = "-1"; field.dispatchEvent(new Event("input"));""")
    settle(browser)
    assert shown(browser)["moment 1"] == -1e-3 and shown(browser)["tip y"] < planned, "a moment of the hand's own"
    browser.run("[...document.querySelectorAll('.bar button')].find((b) => b.textContent === 'Follow').click()")
    settle(browser)


def check_500_drags(browser, live):
    browser.command("Performance.enable")
    browser.run("live.set_action('plan')")
    settle(browser)
    times, told = drags(browser, 100, 1)
    server, page = server_memory(live), page_memory(browser)
    for seed in (2, 3, 4, 5):
        more, complaints = drags(browser, 100, seed)
        times += more
        told += complaints
    print(f"median of 500 drags {sorted(times)[250]:.1f} ms; server {server} to {server_memory(live)} KiB, page {page} to {page_memory(browser)} KiB")
    assert len(times) == 500 and not told, told
    assert server_memory(live) < 1.1 * server + 4000 and page_memory(browser) < 1.2 * page + 1000, "no leak"
    assert sorted(times[-200:])[100] < 2.0 * sorted(times[100:300])[100] + 5.0, "no growing delay"


def main():
    with tempfile.TemporaryDirectory() as name, LiveServer(command, f"{scenes}/brace.toml") as live:
        directory = pathlib.Path(name)
        try:
            with Browser(1200, 800, downloads=directory) as browser:
                browser.open(live.address)
                settle(browser)
                asked = browser.requests()
                assert all(address.startswith(live.address) for address in asked) and len(asked) >= 2, asked
                check_dragging(browser, directory)
                check_controls(browser)
                # From a change to the painted answer, in the browser.
                fast = browser.run("""
                    return (async () => {
                      live.set_action("plan");
                      const all = [];
                      for (let i = 0; i < 60; ++i) {
                        while (live.pending) await new Promise((d) => setTimeout(d, 1));
                        const begin = performance.now();
                        live.change("target.position", [[95 + (i % 7) * 0.3, 18 + (i % 5) * 0.4]], false);
                        while (live.shown !== live.asked) await new Promise((d) => setTimeout(d, 0));
                        all.push(performance.now() - begin);
                      }
                      return all.sort((a, b) => a - b)[30];
                    })();""")
                print(f"{fast:.1f} ms from a change to its picture")
                check_500_drags(browser, live)
                assert not [m for m in browser.messages() if "400 (Bad Request)" not in m]
                # A server that is gone is told, and the last plan stays.
                last = shown(browser)
                assert live.interrupt()[0] == 0
                browser.run("live.change('target.position', [[95, 19]], true)")
                browser.wait("return live.trouble.textContent.includes('tendril does not answer')")
                assert shown(browser) == last
        except Missing as why:
            print(f"skipped: {why}")
            sys.exit(77)


main()
