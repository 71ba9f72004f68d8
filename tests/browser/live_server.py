"""`tendril live` as a process, and a client that says to it whatever it is told to."""

import http.client
import json
import re
import signal
import subprocess
import urllib.parse


class LiveServer:
    """Use it in a `with` statement."""

    def __init__(self, command, scene, *options, environment=None):
        """No browser is opened, unless an `environment` says with which."""
        options = [*options, *([] if environment else ["--no-browser"])]
        self.process = subprocess.Popen([command, "live", str(scene), *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        line = self.process.stdout.readline()
        found = re.match(r"live at (http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/)$", line)
        if not found:
            raise AssertionError(f"no address: {line}{self.process.stderr.read()}")
        self.address, self.port, self.token = found[1], int(found[2]), found[3]
        self.origin = f"http://127.0.0.1:{self.port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def ask(self, path, body=None, method=None, **headers):
        """Status, headers and text of an answer. A header that is None is not sent."""
        data = body if isinstance(body, (bytes, type(None))) else json.dumps(body).encode()
        method = method or ("GET" if data is None else "POST")
        said = {"Host": f"127.0.0.1:{self.port}", **({} if data is None else {"Origin": self.origin, "Content-Type": "application/json"}),
                **{name.replace("_", "-"): value for name, value in headers.items()}}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in said.items():
            for one in value if isinstance(value, list) else [value]:
                if one is not None:
                    connection.putheader(name, one)
        if data is not None:
            connection.putheader("Content-Length", str(len(data)))
        connection.endheaders(data)
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, dict(answer.getheaders()), text

    def run(self, settings=None, action="plan", **more):
        status, _, text = self.ask(f"/{self.token}/run", {"action": action, "settings": settings or {}, **more})
        return status, json.loads(text)

    def interrupt(self):
        """Ctrl-C: how it ends."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=20)
        return self.process.returncode, out, err


def number(drawing, name):
    """A number that stands beside the last frame of a drawing."""
    return next(n["value"] for n in drawing["frames"][-1]["numbers"] if n["name"] == name)


def quoted(path):
    return urllib.parse.quote(path)
