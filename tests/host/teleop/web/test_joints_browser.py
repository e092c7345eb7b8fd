"""The joints' page in a real browser: the tree of parameters, a plot, a step, the stop; a desk and a phone."""

import subprocess
import sys

import pytest

from host.lab.teleop.browser import DESK, missing, open_browser, patient
from host.lab.teleop.watched import free_port
from host.util.child import end_child
from tests.waiting import PATIENCE_S

playwright = pytest.importorskip("playwright.sync_api", reason="the library playwright is not installed")
pytestmark = pytest.mark.skipif(missing() != "", reason=missing())
PHONE = {"width": 390, "height": 844}


@pytest.fixture
def page():
    """The page of simulated joints once it hears them; complaints of the browser fail the test."""
    port, complaints = free_port(), []
    command = [sys.executable, "-m", "host.cli", "joints", "page", "--sim", "--listen", f"127.0.0.1:{port}"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline().startswith(f"http://127.0.0.1:{port}")
        with open_browser() as browser:
            page = patient(browser.new_page(viewport=DESK))
            page.on("pageerror", lambda error: complaints.append(str(error)))
            page.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
            page.goto(f"http://127.0.0.1:{port}")
            says(page, "#word", "disarmed")
            yield page
    finally:
        process.terminate()
        end_child(process, PATIENCE_S)
    assert process.returncode == 0
    assert complaints == []


def says(page, where, text):
    playwright.expect(page.locator(where)).to_have_text(text)


def test_a_joint_is_tuned_from_the_page(page):
    page.locator("#find").fill("position_p")
    gain = page.get_by_label("position_p", exact=True)
    playwright.expect(gain).to_have_value("12.875")
    gain.fill("900")
    gain.press("Enter")
    playwright.expect(page.locator("#told")).to_contain_text("position_p: 900: allowed ")
    gain.fill("12")
    gain.press("Enter")
    playwright.expect(page.locator("#told")).to_contain_text("position_p is 12 rate/rc")
    page.locator("#keep").click()
    playwright.expect(page.locator("#told")).to_contain_text("its parameters are saved")
    assert page.locator("#step").is_disabled()
    assert page.locator("#step").get_attribute("title") == "arm first"
    page.locator("#arm").click()
    says(page, "#word", "armed")
    page.locator("#plot-pick").select_option("speed")
    page.locator("#step").click()
    playwright.expect(page.locator("#told")).to_contain_text("deg left")
    assert page.locator("#plot-list figure").count() == 3
    page.keyboard.press("Space")
    says(page, "#word", "disarmed")
    says(page, "#told", "emergency stop: all joints are off")
    page.set_viewport_size(PHONE)
    stop = page.locator("#stop").bounding_box()
    assert stop["x"] >= 0
    assert stop["x"] + stop["width"] <= PHONE["width"]
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
