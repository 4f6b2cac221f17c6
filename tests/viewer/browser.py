# SPDX-License-Identifier: BSD-3-Clause
"""Chromium without a window, for tests of pages."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
)  # fmt: skip
START = 60.0  # s; the software renderer is slow where processors are shared


class Browser:
    """Shows pages, and lists what they request and what goes wrong in them."""

    def __init__(self, width: int = 800, height: int = 600) -> None:
        """Start Chromium. Skips the test if it is not installed."""
        webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
        chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
        if chromium is None or driver is None:
            pytest.skip("chromium or chromedriver is not installed (Debian: chromium chromium-driver)")
        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for argument in (*ARGUMENTS, f"--window-size={width},{height}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self._driver = webdriver.Chrome(options, webdriver.ChromeService(driver))

    def open(self, page: Path) -> None:
        """Open a viewer's page, and wait until it has drawn."""
        self.open_address(page.as_uri())

    def open_address(self, address: str) -> None:
        """Open a page that is served, and wait until it has drawn."""
        self._driver.get(address)
        self.wait("return Boolean(window.gelenk && window.gelenk.ready)")

    def show(self, page: Path) -> None:
        """Open any page."""
        self._driver.get(page.as_uri())

    @contextmanager
    def frame(self, selector: str) -> Iterator[None]:
        """Run scripts in a frame of the page."""
        from selenium.webdriver.common.by import By

        self._driver.switch_to.frame(self._driver.find_element(By.CSS_SELECTOR, selector))
        try:
            yield
        finally:
            self._driver.switch_to.default_content()

    def run(self, script: str) -> Any:
        """Run JavaScript, and return its result."""
        return self._driver.execute_script(script)

    def wait(self, script: str, seconds: float = START) -> None:
        """Wait until a script returns true."""
        end = time.monotonic() + seconds
        while not self.run(script):
            assert time.monotonic() < end, f"not within {seconds:g} s: {script}; {self.errors()}"
            time.sleep(0.05)

    def press(self, key: str) -> None:
        """Press a key."""
        from selenium.webdriver.common.by import By

        self._driver.find_element(By.TAG_NAME, "body").send_keys(key)

    def drag(self, start: tuple[float, float], end: tuple[float, float], hold: float = 0.0) -> None:
        """Press the mouse at a pixel, move it to another one, and release it there after some seconds."""
        from selenium.webdriver.common.actions.action_builder import ActionBuilder

        actions = ActionBuilder(self._driver)
        pointer: Any = actions.pointer_action
        pointer.move_to_location(*map(round, start)).pointer_down()
        pointer.move_to_location(*map(round, end)).pause(hold).pointer_up()
        actions.perform()

    def resize(self, width: int, height: int) -> None:
        """Give the page another size [pixels], as of another device."""
        self._driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < height},
        )

    def picture(self) -> bytes:
        """Return what is seen as PNG."""
        out: bytes = self._driver.get_screenshot_as_png()
        return out

    def errors(self) -> list[str]:
        """Return what the page has reported since the last call: errors and warnings of its own."""
        return [
            entry["message"]
            for entry in self._driver.get_log("browser")
            if entry["level"] == "SEVERE" or "file://" in entry["message"]
        ]

    def requests(self) -> list[str]:
        """Return the addresses that the page has requested since the last call, but for itself."""
        messages = [json.loads(entry["message"])["message"] for entry in self._driver.get_log("performance")]
        sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith(("file:", "data:", "blob:"))]

    def close(self) -> None:
        """End Chromium."""
        self._driver.quit()
