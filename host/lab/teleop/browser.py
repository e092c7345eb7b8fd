"""A real browser on the page, for measurements: its keys, sticks, STOP button and gamepad as a person uses them."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .watched import PATIENCE_S

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
KEYS = {"push": "w", "let go": "w", "stop": "Space", "stand": "t", "reset": "r"}
PATIENCE_MS = 1000 * PATIENCE_S
DESK = {"width": 1280, "height": 900}
# A gamepad that the caller moves: window.pad is what the browser would tell.
FAKE_PAD = """
window.pad = {connected: true, axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false}))};
navigator.getGamepads = () => [window.pad];
"""


def executable() -> str | None:
    """Return where the browser is, or None."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def missing() -> str:
    """Return why no page can be opened here, "" if one can."""
    try:
        import playwright.sync_api  # noqa: F401
    except ImportError:
        return "the library playwright is not installed: make setup"
    return "" if executable() else "no browser: apt-get install chromium"


@contextmanager
def open_browser() -> Iterator[Any]:
    """Yield the machine's own browser, without a window."""
    from playwright.sync_api import expect, sync_playwright

    with sync_playwright() as library:
        expect.set_options(timeout=PATIENCE_MS)
        browser = library.chromium.launch(executable_path=executable(), args=list(FLAGS), timeout=PATIENCE_MS)
        yield browser
        browser.close()


def patient(opened: Any) -> Any:
    """Return a page or context just opened that waits as long as all else here: the library gives up after 30 s."""
    opened.set_default_timeout(PATIENCE_MS)
    return opened


@contextmanager
def open_page(url: str) -> Iterator[Any]:
    """Yield the page once it may drive, with a gamepad that lies still."""
    with open_browser() as browser:
        page = patient(browser.new_page(viewport=DESK))
        page.add_init_script(FAKE_PAD)
        page.goto(url)
        page.wait_for_selector("#take:enabled")
        yield page


def by_key(page: Any, what: str) -> None:
    """Do one of push, let go, stop, stand, reset with the page's keyboard."""
    keys = page.keyboard
    {"push": keys.down, "let go": keys.up}.get(what, keys.press)(KEYS[what])


def by_stick(page: Any, what: str) -> None:
    """Do it with the page's left stick and its STOP button."""
    if what == "push":
        box = page.locator("#walk").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y - box["height"] / 3)
        page.mouse.down()
    elif what == "let go":
        page.mouse.up()
    elif what == "stop":
        page.locator("#stop").click()
    else:
        by_key(page, what)


def by_pad(page: Any, what: str) -> None:
    """Do it with the browser's gamepad, whose dead-man button is held."""
    if what == "push":
        page.evaluate("pad.buttons[4].pressed = true; pad.axes[1] = -1")
    elif what == "let go":
        page.evaluate("pad.axes[1] = 0")
    elif what == "stop":
        page.evaluate("pad.buttons[1].pressed = true")
        page.wait_for_timeout(60)
        page.evaluate("pad.buttons[1].pressed = false")
    else:
        by_key(page, what)
