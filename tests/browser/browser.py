"""A browser without a window, driven through Debian's chromedriver by the W3C WebDriver protocol."""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request


class Missing(Exception):
    """There is no browser here, and why."""


class Browser:
    """One page in Chromium. Use it in a `with` statement."""

    def __init__(self, width=800, height=600, dark=False, downloads=None):
        self.driver = shutil.which("chromedriver")
        if not self.driver or not shutil.which("chromium"):
            raise Missing("chromium and chromedriver are not installed (Debian: chromium, chromium-driver)")
        self.profile = tempfile.TemporaryDirectory(prefix="tendril-browser-", ignore_cleanup_errors=True)
        self.process = subprocess.Popen([self.driver, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                        env={**os.environ, "HOME": self.profile.name})
        port = next(int(line.split()[-1].rstrip(".")) for line in self.process.stdout if "started successfully on port" in line)
        self.url = f"http://127.0.0.1:{port}/session"
        arguments = ["--headless=new", "--disable-gpu", f"--window-size={width},{height}", "--hide-scrollbars", "--no-first-run",
                     "--disable-background-networking", f"--user-data-dir={self.profile.name}/profile"]
        if os.geteuid() == 0:
            arguments.append("--no-sandbox")
        preferences = {"profile.default_content_setting_values.automatic_downloads": 1}
        if downloads:
            preferences["download.default_directory"] = str(downloads)
        answer = self._ask("POST", "", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:loggingPrefs": {"performance": "ALL", "browser": "ALL"},
            "goog:chromeOptions": {"args": arguments, "binary": shutil.which("chromium"), "prefs": preferences}}}})
        self.url += "/" + answer["sessionId"]
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        # The browser's own first page is none of ours.
        self.open("about:blank")
        self.requests()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self._ask("DELETE", "")
        except OSError:
            pass
        self.process.terminate()
        self.process.wait()
        self.profile.cleanup()

    def _ask(self, method, path, body=None):
        data = None if method == "DELETE" else json.dumps(body or {}).encode()
        request = urllib.request.Request(self.url + path, data if method == "POST" else None, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def open(self, address):
        self._ask("POST", "/url", {"url": str(address)})

    def open_file(self, path):
        self.open(pathlib.Path(path).resolve().as_uri())

    def run(self, script, *arguments):
        """What `script`, the body of a function, returns."""
        return self._ask("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, *arguments, seconds=20.0):
        """What `script` returns as soon as it is true."""
        end = time.monotonic() + seconds
        while not (value := self.run(script, *arguments)):
            if time.monotonic() > end:
                raise AssertionError(f"did not come true within {seconds} s: {script}\n{self.messages()}")
            time.sleep(0.02)
        return value

    def command(self, name, **parameters):
        """A command of the DevTools protocol."""
        return self._ask("POST", "/goog/cdp/execute", {"cmd": name, "params": parameters})

    def drag(self, points):
        """Presses the mouse at the first of `points`, moves over the others and lets go at the last."""
        moves = [{"type": "pointerMove", "duration": 0, "x": round(x), "y": round(y)} for x, y in points]
        actions = [moves[0], {"type": "pointerDown", "button": 0}, *moves[1:], {"type": "pointerUp", "button": 0}]
        self._ask("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]})

    def key(self, key):
        for kind in ("keyDown", "keyUp"):
            self._ask("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": [{"type": kind, "value": key}]}]})

    def requests(self):
        """Addresses that were asked for since the last call."""
        events = [json.loads(entry["message"])["message"] for entry in self._ask("POST", "/se/log", {"type": "performance"})]
        return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]

    def messages(self):
        """Errors of the page since the last call, refusals by its policy among them."""
        return [entry["message"] for entry in self._ask("POST", "/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]

    def screenshot(self, path):
        answer = self.command("Page.captureScreenshot")
        pathlib.Path(path).write_bytes(base64.b64decode(answer["data"]))
