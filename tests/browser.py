"""A headless browser spoken to over the two pipes of its DevTools protocol; no package is needed for it.

The browser is what the variable LPTN_BROWSER names, or the first of NAMES that is installed.
"""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PATIENCE = 120.0
"""Seconds that an answer may take, on a machine that has other work."""
FIRST_FREE = 10
"""Descriptors of the pipes are moved from here on, so that those the browser reads, 3 and 4, are free."""
KEYS = {"Tab": 9, "Enter": 13, "Escape": 27, " ": 32, "End": 35, "Home": 36,
        "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40}  # fmt: skip


def find_browser() -> str | None:
    named = os.environ.get("LPTN_BROWSER")
    return shutil.which(named) if named else next((found for name in NAMES if (found := shutil.which(name))), None)


@dataclass
class Browser:
    """One page in a running browser. said: what the page logged, threw, or was refused by its policy, as told."""

    process: subprocess.Popen[bytes]
    to: int
    of: int
    said: list[str] = field(default_factory=list)
    happened: list[str] = field(default_factory=list)
    _session: str = ""
    _count: int = 0
    _read: bytes = b""

    # -- the protocol ---------------------------------------------------------------------------------------------
    def ask(self, method: str, **given: Any) -> dict[str, Any]:
        """The answer to a command of the protocol. Raises AssertionError where it is refused."""
        self._count += 1
        words: dict[str, Any] = {"id": self._count, "method": method, "params": given}
        if self._session:
            words["sessionId"] = self._session
        os.write(self.to, json.dumps(words).encode() + b"\0")
        while (answer := self._take()).get("id") != self._count:
            self._note(answer)
        assert "error" not in answer, f"{method}: {answer['error']}"
        return dict(answer["result"])

    def wait_for(self, event: str) -> None:
        while event not in self.happened:
            self._note(self._take())

    def _take(self) -> dict[str, Any]:
        end = time.monotonic() + PATIENCE
        while b"\0" not in self._read:
            ready, _, _ = select.select([self.of], [], [], max(end - time.monotonic(), 0.0))
            piece = os.read(self.of, 1 << 20) if ready else b""
            assert piece, "the browser does not answer"
            self._read += piece
        told, _, self._read = self._read.partition(b"\0")
        return dict(json.loads(told))

    def _note(self, event: dict[str, Any]) -> None:
        method, told = event.get("method", ""), event.get("params", {})
        self.happened.append(method)
        if method == "Runtime.consoleAPICalled":
            self.said.append(f"{told['type']}: {[each.get('value', each.get('description')) for each in told['args']]}")
        elif method == "Runtime.exceptionThrown":
            self.said.append(str(told["exceptionDetails"].get("exception", {}).get("description", told)))
        elif method == "Page.javascriptDialogOpening":
            self.said.append(f"dialog: {told['message']}")
        elif method == "Log.entryAdded":
            self.said.append(f"{told['entry']['level']}: {told['entry']['text']}")

    # -- the page -------------------------------------------------------------------------------------------------
    def attach(self) -> None:
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Accessibility"):
            self.ask(f"{domain}.enable")

    def show(self, page: Path, width: int = 1280, height: int = 900, script: bool = True, touch: bool = False) -> None:
        """Load a file in a window of this size, with or without JavaScript."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        self.ask("Emulation.setTouchEmulationEnabled", enabled=touch)
        self.ask("Emulation.setEmulatedMedia", media="screen")
        self.ask("Emulation.setScriptExecutionDisabled", value=not script)
        self.said.clear()
        self.happened.clear()
        self.ask("Page.navigate", url=page.as_uri())
        self.wait_for("Page.loadEventFired")

    def tell(self, expression: str) -> Any:
        """The value of an expression of JavaScript in the page."""
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def press(self, key: str, shift: bool = False) -> None:
        """A key pressed and let go, as by a hand: what has the focus gets it."""
        text = "\r" if key == "Enter" else key if len(key) == 1 else ""
        named = {"key": key, "code": "Space" if key == " " else key, "modifiers": 8 if shift else 0}
        named["windowsVirtualKeyCode"] = KEYS.get(key, ord(key[0].upper()))
        self.ask("Input.dispatchKeyEvent", type="keyDown", **named, **({"text": text} if text else {}))
        self.ask("Input.dispatchKeyEvent", type="keyUp", **named)

    def point(self, kind: str, x: float, y: float) -> None:
        """kind: mouseMoved, mousePressed, mouseReleased."""
        held = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **held)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.point("mouseMoved", *start)
        self.point("mousePressed", *start)
        self.ask("Input.dispatchMouseEvent", type="mouseMoved", x=end[0], y=end[1], button="left", buttons=1)
        self.point("mouseReleased", *end)

    def picture(self, where: Path, whole: bool = True) -> Path:
        data = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        where.write_bytes(base64.b64decode(data))
        return where

    def paper(self, where: Path) -> Path:
        """The page as it is printed on A4."""
        self.ask("Emulation.setEmulatedMedia", media="")
        size = {"paperWidth": 8.27, "paperHeight": 11.69, "preferCSSPageSize": True, "printBackground": False}
        where.write_bytes(base64.b64decode(self.ask("Page.printToPDF", **size)["data"]))
        return where


@contextmanager
def opened(program: str, profile: Path) -> Iterator[Browser]:
    """A browser with an empty profile, closed at the end however that is."""
    (theirs, to), (of, also_theirs) = os.pipe(), os.pipe()
    theirs, also_theirs = (fcntl.fcntl(fd, fcntl.F_DUPFD, FIRST_FREE) for fd in (theirs, also_theirs))

    def place() -> None:
        os.dup2(theirs, 3)
        os.dup2(also_theirs, 4)

    words = [program, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--remote-debugging-pipe"]
    words += [f"--user-data-dir={profile}", "--disable-background-networking", "about:blank"]
    with (profile.parent / "browser.log").open("wb") as log:
        process = subprocess.Popen(words, stdout=log, stderr=log, preexec_fn=place, pass_fds=(3, 4))
    os.close(theirs)
    os.close(also_theirs)
    browser = Browser(process, to, of)
    try:
        browser.attach()
        yield browser
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE)
        os.close(to)
        os.close(of)
