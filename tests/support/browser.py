"""Pages in headless Chromium: the fixtures `browser` and `open_page`."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:  # Tests that open no page run without Playwright.
    from playwright.sync_api import Browser, Page

# No sandbox, since containers run as root; WebGL by software, since they have no GPU; no calls home.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"]
ARGUMENTS += ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]


@pytest.fixture(scope="session")
def browser() -> Iterator["Browser"]:
    """The machine's Chromium; tests that need it skip where there is none, unless DEMAND_BROWSER is set."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        assert not os.environ.get("DEMAND_BROWSER"), "DEMAND_BROWSER is set and there is no Chromium"
        pytest.skip("no Chromium on this machine")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser: "Browser") -> Iterator[Callable[..., "Page"]]:
    """Opens a file in a tab of its own. At the end no tab may have fetched anything or raised an error.

    A page that consists of several files names the `folder` that holds them all, and may load from it.
    """
    tabs: list[Page] = []
    fetched: list[str] = []
    errors: list[str] = []

    def open_one(path: Path, width: int = 1300, height: int = 900, folder: Path | None = None) -> "Page":
        tab = browser.new_page(viewport={"width": width, "height": height})
        tabs.append(tab)
        own = path.resolve().as_uri()
        home = own if folder is None else f"{folder.resolve().as_uri()}/"
        tab.on("request", lambda request: fetched.append(request.url) if _is_fetched(request.url, own, home) else None)
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.goto(own)
        return tab

    yield open_one
    for tab in tabs:
        tab.close()
    assert fetched == []
    assert errors == []


def _is_fetched(url: str, own: str, home: str) -> bool:
    inside = home.endswith("/") and url.startswith(home)
    return url != own and not inside and not url.startswith(("data:", "blob:"))
