#!/usr/bin/python3
"""figures.py COMMAND SCENES: pages that show results, opened from disk in a real browser."""

import base64
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from browser import Browser, Missing

command, scenes = sys.argv[1:]


def make(directory, name, kind, scene, *options):
    """Writes a page and returns its path and the result that it shows."""
    page = directory / f"{name}.html"
    run = subprocess.run([command, kind, f"{scenes}/{scene}", "--json", "--figure", page, *options], capture_output=True, text=True, check=True)
    return page, json.loads(run.stdout)


def check_policy(page):
    """Every script and style of the page is allowed by its checksum, and nothing else is."""
    text = page.read_text()
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    allowed = set(re.findall(r"'sha256-([^']*)'", policy))
    inline = re.findall(r"<(?:script|style)>(.*?)</(?:script|style)>", text, re.DOTALL)
    found = {base64.b64encode(hashlib.sha256(part.encode()).digest()).decode() for part in inline}
    assert allowed == found and len(found) == 2, (allowed, found)
    assert policy.startswith("default-src 'none';") and "unsafe" not in policy and "connect-src" not in policy, policy


def shown(browser):
    """Numbers beside the picture, by name."""
    return dict(browser.run("return [...document.querySelectorAll('td[data-value]')].map((c) => [c.dataset.name, Number(c.dataset.value)])"))


def painted(browser, color):
    """How many points of the picture have about this colour."""
    return browser.run("""
        const canvas = document.querySelector(".stage canvas"), want = arguments[0];
        const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        let count = 0;
        for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - want[0]) + Math.abs(data[i + 1] - want[1]) + Math.abs(data[i + 2] - want[2]) < 12) ++count;
        return count;""", color)


def check_trajectory(browser, page, result):
    browser.requests()
    browser.open_file(page)
    browser.wait("return document.querySelectorAll('td[data-value]').length > 5")
    assert shown(browser)["tip x"] == result["steps"][0]["tip"]["x"]
    browser.run("const s = document.querySelector('input[type=range]'); s.value = 20; s.dispatchEvent(new Event('input'))")
    assert shown(browser)["force of obstacle 1"] == result["steps"][20]["contacts"][0]["force"]
    browser.key("\ue014")  # arrow to the right
    assert shown(browser)["moment 1"] == result["steps"][21]["moments"][0]
    browser.key("\ue010")  # End
    assert browser.run("return document.querySelector('.label').textContent") == "step 45 of 45"
    browser.run("document.querySelector('footer button').click()")  # from the end it plays from the beginning
    browser.wait("return document.querySelector('.label').textContent === 'step 3 of 45'")
    browser.key(" ")
    at = browser.run("return document.querySelector('input[type=range]').value")
    time.sleep(0.4)
    assert at == browser.run("return document.querySelector('input[type=range]').value"), "it plays on"
    assert browser.requests() == [page.resolve().as_uri()], "a page on disk asks for nothing"
    assert not browser.messages()


def check_plan(browser, page, result, downloads, dark):
    browser.open_file(page)
    browser.wait("return document.querySelectorAll('td[data-value]').length > 5")
    ground, rod = ([20, 23, 26], [86, 180, 233]) if dark else ([255, 255, 255], [0, 114, 178])
    assert painted(browser, ground) > 10000 and painted(browser, rod) > 300
    # Values under the mouse: of the contact, where the page itself says that it is.
    tip = browser.run("""
        const found = (text) => { const t = document.querySelector(".tip"); return !t.hidden && t.textContent.includes(text) ? t.textContent : ""; };
        const canvas = document.querySelector(".stage canvas"), box = canvas.getBoundingClientRect();
        for (let y = 0; y < box.height; y += 4) for (let x = 0; x < box.width; x += 4) {
          canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + x, clientY: box.top + y }));
          if (found("contact with")) return found("contact with");
        }""")
    assert tip.startswith("contact with obstacle 1\n") and f"force {1e3 * result['contacts'][0]['force']:.5g} mN" in tip, tip
    for kind, start in (("PNG", b"\x89PNG"), ("SVG", b"<svg ")):
        browser.run("[...document.querySelectorAll('footer button')].find((b) => b.textContent === arguments[0]).click()", kind)
        file = downloads / f"tendril.{kind.lower()}"
        for _ in range(200):
            if file.exists() and file.stat().st_size > 0:
                break
            time.sleep(0.05)
        assert file.read_bytes().startswith(start), kind
        file.unlink()
    browser.key("d")
    assert painted(browser, ground) < 100, "dark and light change places"
    assert not browser.messages()


def check_old_browser(browser, page):
    """One that lacks what the page needs says so instead of nothing."""
    made = browser.command("Page.addScriptToEvaluateOnNewDocument", source="delete window.ResizeObserver")
    browser.open_file(page)
    assert "the browser is too old" in browser.run("return document.body.innerText")
    browser.command("Page.removeScriptToEvaluateOnNewDocument", identifier=made["identifier"])


def check_friction(browser, page):
    """What the force of a contact may be is drawn, and explained."""
    browser.open_file(page)
    browser.wait("return document.querySelectorAll('td[data-value]').length > 5")
    assert painted(browser, [246, 211, 189]) > 100, "the friction cone"
    assert "friction cone" in browser.run("return document.querySelector('aside').textContent")


def check_movie(browser, page, downloads):
    browser.open_file(page)
    browser.run("[...document.querySelectorAll('footer button')].find((b) => b.textContent === 'Movie').click()")
    for _ in range(400):
        files = [file for file in downloads.glob("tendril.*") if file.suffix in (".webm", ".mp4") and file.stat().st_size > 1000]
        if files:
            return
        time.sleep(0.05)
    raise AssertionError(f"no movie: {list(downloads.iterdir())} {browser.messages()}")


def main():
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        trajectory = make(directory, "trajectory", "plan", "trajectory.toml")
        plan = make(directory, "plan", "plan", "brace.toml")
        subprocess.run([command, "execute", f"{scenes}/snap_through.toml", "--moments", "100 N mm", "--output", directory / "up"], capture_output=True, check=True)
        executed = make(directory, "executed", "execute", "snap_through.toml", "--moments", "-50 N mm", "--start", directory / "up/result.json")
        others = [make(directory, "grasp", "plan", "grasp_unequal.toml"), executed,
                  make(directory, "study", "study", "grasp_distal_sweep.toml")]
        friction = make(directory, "friction", "plan", "brace.toml", "--set", "contact.friction=0.5")
        others.append(make(directory, "channel", "plan", "endoscope.toml"))
        for page, _ in (trajectory, plan, friction, *others):
            check_policy(page)
        try:
            for dark in (False, True):
                with Browser(dark=dark, downloads=directory) as browser:
                    if not dark:
                        check_trajectory(browser, *trajectory)
                    check_plan(browser, *plan, directory, dark)
                    if not dark:
                        check_movie(browser, others[1][0], directory)
                        check_friction(browser, friction[0])
                    for page, _ in others:
                        browser.requests()
                        browser.open_file(page)
                        browser.wait("return document.querySelectorAll('td[data-value]').length > 3")
                        assert browser.requests() == [page.resolve().as_uri()] and not browser.messages()
                    if dark:
                        check_old_browser(browser, plan[0])
        except Missing as why:
            print(f"skipped: {why}")
            sys.exit(77)


main()
