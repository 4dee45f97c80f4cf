"""A page in headless Chromium, over the pipe of its debugging protocol (no driver, no network)."""

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # as root in a container
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--remote-debugging-pipe",
    "--window-size=1400,1000",
)
LOCAL = ("file:", "data:", "blob:", "about:", "chrome:")


class Browser:
    """Chromium with one page; notes what the page asks of the network and complains of."""

    def __init__(self, folder: Path) -> None:
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()

        def connect():
            # the protocol's pipes are descriptors 3 and 4; first out of the way of each other
            a, b = os.dup(theirs_in), os.dup(theirs_out)
            spare = [os.dup(a), os.dup(b)]
            os.dup2(spare[0], 3)
            os.dup2(spare[1], 4)
            os.set_inheritable(3, True)
            os.set_inheritable(4, True)

        self.process = subprocess.Popen(
            [CHROMIUM, *OPTIONS, f"--user-data-dir={folder}", "about:blank"],
            preexec_fn=connect,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self.reader, self.writer = ours_in, ours_out
        self.buffer, self.count, self.session = b"", 0, None
        self.requests, self.complaints = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.reader)
        os.close(self.writer)

    def call(self, method, timeout_s=60.0, **parameters):
        """Result of a command; events that come first are noted."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.writer, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            answer = self._next(end)
            if answer.get("id") == self.count:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self._note(answer)
        raise TimeoutError(f"no answer to {method} in {timeout_s:g} s")

    def _next(self, end):
        while b"\0" not in self.buffer:
            ready, _, _ = select.select([self.reader], [], [], max(0.0, end - time.monotonic()))
            part = os.read(self.reader, 1 << 20) if ready else b""
            if not part:
                raise TimeoutError("Chromium does not answer")
            self.buffer += part
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def _note(self, event):
        kind, given = event.get("method"), event.get("params", {})
        if kind == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif kind == "Runtime.exceptionThrown":
            self.complaints.append(given["exceptionDetails"]["text"])
        elif kind == "Runtime.consoleAPICalled" and given["type"] in ("error", "assert"):
            self.complaints.append(str([part.get("value") for part in given["args"]]))
        elif kind == "Log.entryAdded" and given["entry"]["level"] == "error":
            self.complaints.append(given["entry"]["text"])

    def open(self, path: Path) -> None:
        """Load a file and wait until it is complete."""
        self.call("Page.navigate", url=path.resolve().as_uri())
        assert self.wait_for("document.readyState === 'complete'")

    def run(self, script):
        """Value of a script; a promise is waited for."""
        answer = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait_for(self, condition, timeout_s=30.0):
        """Whether a condition becomes true in time."""
        end = time.monotonic() + timeout_s
        while not (found := self.run(f"Boolean({condition})")) and time.monotonic() < end:
            time.sleep(0.1)
        return found

    def drag(self, start, end, steps=8):
        """Press the left button at a point of the window, move to another, let go."""
        path = [
            [a + k / steps * (b - a) for a, b in zip(start, end, strict=True)]
            for k in range(steps + 1)
        ]
        for kind, points in (
            ("mousePressed", path[:1]),
            ("mouseMoved", path[1:]),
            ("mouseReleased", path[-1:]),
        ):
            for x, y in points:
                self.call(
                    "Input.dispatchMouseEvent",
                    type=kind,
                    x=x,
                    y=y,
                    button="left",
                    buttons=1,
                    clickCount=1,
                )

    def printed(self) -> bytes:
        """The page as a PDF, on paper as the page asks for it."""
        options = {"printBackground": True, "preferCSSPageSize": True}
        return base64.b64decode(self.call("Page.printToPDF", timeout_s=300.0, **options)["data"])

    @property
    def outward(self):
        """Requests that leave the machine."""
        return [url for url in self.requests if not url.startswith(LOCAL)]
