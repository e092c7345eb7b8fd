"""The page in a real browser: drive, stop, a second driver, a lost connection, phones and keyboards, latencies."""

import contextlib
import re

import pytest

from host.lab.teleop.browser import DESK, FAKE_PAD, missing, open_browser, patient
from host.robot.file import load_robot
from host.robot.gait_advice import gait_advice
from host.sim.stage import profiles
from host.teleop.web.paired import NAME, Paired
from host.util.errors import UserError
from tests.host.control.rig import STILL
from tests.waiting import let_pass, stays, wait_until

from .rig import Teleop

playwright = pytest.importorskip("playwright.sync_api", reason="the library playwright is not installed")
pytestmark = pytest.mark.skipif(missing() != "", reason=missing())

ROBOT = load_robot("caramelo")
PHONE = {"width": 390, "height": 844}
LYING = {"width": 844, "height": 390}


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def teleop(tmp_path_factory):
    with Teleop(tmp_path_factory.mktemp("browser")) as running:
        yield running


def complains(line):
    """Say whether a line of the browser's console is a complaint; a page that a test takes off the line tells that."""
    return line.type in ("error", "warning") and "ERR_INTERNET_DISCONNECTED" not in line.text


@pytest.fixture
def open_page(browser, teleop):
    """Return a function that opens a page; complaints of the browser fail the test."""
    contexts, complaints = [], []

    def open_page(viewport=DESK, touch=False, script=None, scheme="light"):
        context = patient(browser.new_context(viewport=viewport, has_touch=touch, color_scheme=scheme))
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda line: complaints.append(line.text) if complains(line) else None)
        page.on(
            "request", lambda request: request.url.startswith((teleop.url, "data:")) or complaints.append(request.url)
        )
        if script:
            page.add_init_script(script)
        page.goto(teleop.url)
        playwright.expect(page.locator("#word")).not_to_have_text("connecting")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert complaints == []


@pytest.fixture(autouse=True)
def standing(teleop):
    """Every test begins with a robot that stands, undriven, and no stop."""
    teleop.wait(lambda status: status["driver"] is None)
    teleop.say(type="gait", gait=ROBOT.gait.default)
    teleop.say(type="balance", on=True)
    teleop.say(type="release")

    def ready(status):
        if status["state"] == "lifted":  # raised by its pose it may say so; nothing but a stop and a reset ends that
            teleop.say(type="stop")
        if status["stop"] or status["state"] in ("fault", "disarmed"):
            teleop.say(type="reset")  # also puts a robot back that has slid down since it was let go
            teleop.say(type="posture", posture="stand")
            teleop.say(type="release")
        return status["state"] == "standing" and status["driver"] is None

    teleop.wait(ready)


def walks(status):
    return status["state"] == "walking" and not status["reason"] and any(status["speed"])


def driven(teleop, push, found=walks):
    """Push a stick and hold it until ``found``; return the status.

    A page that a busy machine halts for 3 s has lost the controls, and a stick held still since then does nothing: it
    is pushed again.
    """
    push()
    return teleop.wait(lambda status: found(status) or (status["driver"] is None and push()))


def key(page, name):
    """Return how a key is pressed and held down."""
    return lambda: page.keyboard.up(name) or page.keyboard.down(name)


def test_drive_by_keyboard_and_stop(teleop, open_page):
    page = open_page()
    status = driven(teleop, key(page, "w"))
    assert status["speed"][0] > 0
    assert status["driver"] == ["web", status["driver"][1]]
    playwright.expect(page.locator("#reason")).to_have_text("moving as commanded")
    page.keyboard.press("Space")
    status = teleop.wait(lambda status: status["stop"])
    assert status["stop"] == f"web {status['driver'][1]}"
    assert not status["armed"]
    page.wait_for_selector("#state.halted")
    page.keyboard.up("w")
    page.keyboard.press("t")
    assert stays(lambda: not teleop.status()["armed"], 0.2), "it stays stopped"
    page.keyboard.press("r")
    teleop.wait(lambda status: status["stop"] is None)
    page.keyboard.press("t")
    teleop.wait(lambda status: status["state"] == "standing up")


def test_a_released_key_stops(teleop, open_page):
    page = open_page()
    assert driven(teleop, key(page, "a"))["speed"][2] > 0
    page.keyboard.up("a")
    teleop.wait(lambda status: status["reason"] == "the sticks are at rest")
    teleop.wait(lambda status: status["state"] == "standing")


@pytest.mark.parametrize(("viewport", "scheme"), [(PHONE, "light"), (LYING, "dark")], ids=["portrait", "landscape"])
def test_touch_sticks_and_stop_button_on_a_phone(teleop, open_page, viewport, scheme, tmp_path):
    page = open_page(viewport, touch=True, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "nothing sticks out"
    for name in ("stop", "walk", "turn"):
        box = page.locator(f"#{name}").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= viewport["width"]
        assert box["y"] >= 0
        assert box["y"] + box["height"] <= viewport["height"] + 1
        assert min(box["width"], box["height"]) >= 44
    x, y = _middle(page.locator("#walk"))
    page.mouse.move(x, y)
    page.mouse.down()
    status = driven(teleop, lambda: page.mouse.move(x, y) or page.mouse.move(x, y - 40, steps=4))
    assert status["speed"][0] > 0
    page.screenshot(path=tmp_path / "phone.png")
    assert (tmp_path / "phone.png").stat().st_size > 5000
    page.touchscreen.tap(*_middle(page.locator("#stop")))
    teleop.wait(lambda status: status["stop"])
    page.mouse.up()


def _middle(element):
    box = element.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_pose_out_of_reach_is_told_on_the_page(teleop, open_page):
    page, limits = open_page(), ROBOT.body_limits
    pose = [0.0, 0.0, limits.z_m, *limits.angles_rad[:2], 0.0]
    told = "pose out of reach: held at the nearest"
    bias = "measuring the gyro's bias: hold the robot still"  # in a robot's first seconds this is told beside it
    teleop.wait(lambda status: teleop.say(**{**STILL, "pose": pose}) or status["remark"] == told)
    playwright.expect(page.locator("#remark")).to_have_text(re.compile(f"^{told}(; {bias})?$"))
    teleop.wait(lambda status: teleop.say(**STILL) or status["remark"] == "")
    playwright.expect(page.locator("#remark")).to_have_text(re.compile(f"^({bias})?$"))
    teleop.say(type="release")


def test_a_second_page_watches_and_may_stop(teleop, open_page):
    first, second = open_page(), open_page(PHONE, touch=True)
    shown = second.locator("#driver")
    seen = lambda status: walks(status) and shown.inner_text() == f"web {status['driver'][1]}"  # noqa: E731
    driver = driven(teleop, key(first, "w"), seen)["driver"]
    playwright.expect(second.locator("#take")).to_be_disabled()
    second.keyboard.down("s")

    def never_the_second():  # whose key goes back; the first one's command may come late, and be 0, or none
        status = teleop.status()
        return status["driver"] in (driver, None) and status["speed"][0] >= 0

    assert stays(never_the_second, 0.3)
    second.keyboard.press("Space")
    assert teleop.wait(lambda status: status["stop"])["stop"] != f"web {driver[1]}"
    first.keyboard.up("w")


def test_a_lost_connection_stops_the_robot(teleop, open_page):
    page = open_page()
    driven(teleop, key(page, "w"))
    page.context.set_offline(True)
    page.close()
    status = teleop.wait(lambda status: status["driver"] is None)
    assert status["reason"] == "nobody drives: take the controls"
    assert not status["fresh"]
    teleop.wait(lambda status: status["state"] == "standing")


def test_a_page_that_hangs_stops_the_robot(teleop, open_page):
    page = open_page()
    driven(teleop, key(page, "w"))
    debugger = page.context.new_cdp_session(page)
    debugger.send("Debugger.enable")
    debugger.send("Debugger.pause")  # its next line of script waits until it is let go on
    status = teleop.wait(lambda status: not status["fresh"])
    assert status["reason"].startswith("no command from web") or status["driver"] is None  # it has left after 3 s
    teleop.wait(lambda status: status["state"] == "standing")
    debugger.send("Debugger.resume")
    page.keyboard.up("w")


def test_pose_gait_and_balance_without_a_mouse(teleop, open_page):
    page = open_page()
    usual = teleop.status()["gait"]
    page.focus("#gait")
    page.keyboard.press("Home")
    while page.locator("#gait").input_value() != "crawl":
        page.keyboard.press("ArrowDown")
    teleop.wait(lambda status: status["gait"] == "crawl")
    level = teleop.status()["joints_rad"][2]
    page.focus("#pose-z")
    page.keyboard.press("End")
    raised = teleop.wait(lambda status: abs(status["joints_rad"][2] - level) > 0.06)["joints_rad"][2]
    page.focus("#balance")
    page.keyboard.press("Enter")
    page.locator("#balance").set_checked(False)
    teleop.wait(lambda status: not status["balance"])
    page.locator("#balance").set_checked(True)
    teleop.wait(lambda status: status["balance"])
    page.locator("#gait").select_option(usual)
    page.focus("#level")
    page.keyboard.press("Enter")
    teleop.wait(lambda status: abs(status["joints_rad"][2] - raised) > 0.03)  # the body has moved again


def test_a_gait_that_is_not_advised_is_marked_with_the_reason(teleop, open_page):
    page = open_page()
    options = {option.get_attribute("value"): option.inner_text() for option in page.locator("#gait option").all()}
    advice = gait_advice(ROBOT)
    assert options == {gait: f"{gait} (not advised)" if why else gait for gait, why in advice.items()}
    playwright.expect(page.locator("#advice")).to_have_text("")
    marked = next(gait for gait, why in advice.items() if why)
    page.locator("#gait").select_option(marked)
    playwright.expect(page.locator("#advice")).to_have_text(f"{marked} is not advised: {advice[marked]}")


def test_the_speed_is_nothing_while_the_robot_does_not_walk(teleop, open_page):
    page = open_page()
    assert driven(teleop, key(page, "w"))["speed"][0] > 0
    page.keyboard.press("Space")
    assert teleop.wait(lambda status: status["stop"])["speed"] == [0, 0, 0]
    page.keyboard.up("w")
    status = driven(teleop, key(page, "s"), lambda status: status["driver"] and status["fresh"])
    assert (status["armed"], status["speed"]) == (False, [0, 0, 0])
    page.keyboard.up("s")


def test_a_browsers_gamepad(teleop, open_page):
    page = open_page(script=FAKE_PAD)
    page.evaluate("pad.axes[1] = -1")
    assert stays(lambda: teleop.status()["driver"] is None, 0.3), "the dead-man button is not held"
    page.evaluate("pad.buttons[4].pressed = true")
    status = driven(teleop, lambda: page.evaluate("pad.axes[1] = -1 + 0.1 * Math.random()"))
    assert status["speed"][0] > 0
    page.evaluate("pad.buttons[1].pressed = true")
    teleop.wait(lambda status: status["stop"])
    page.evaluate("pad.buttons[4].pressed = false")


def drawn(page, selector):
    """Return the number of painted pixels of a canvas, and something that is another for another picture."""
    return page.evaluate(
        """(selector) => { const shown = document.querySelector(selector), c = document.createElement('canvas');
            [c.width, c.height] = [shown.width, shown.height];
            const pen = c.getContext('2d', {willReadFrequently: true});
            pen.drawImage(shown, 0, 0);
            const data = pen.getImageData(0, 0, c.width, c.height).data;
            let painted = 0, mark = 0;
            data.forEach((value, i) => { painted += i % 4 === 3 && value > 0; mark = (mark * 31 + value) % 1000003; });
            return [painted, mark]; }""",
        selector,
    )


def test_the_live_view_is_drawn_and_values_are_shown(open_page):
    page = open_page()
    playwright.expect(page.locator("#latency")).to_contain_text("ms")
    assert drawn(page, "#view")[0] > 1000
    assert page.locator("#battery").inner_text() == "12.0 V"
    assert page.locator("#joints tr").count() == 4
    assert page.locator("#legend li").count() == 5


def test_the_picture_is_turned_by_dragging_and_by_its_buttons(open_page):
    page = open_page()
    page.locator('[data-camera="top"]').click()
    top = drawn(page, "#view")
    page.locator('[data-camera="side"]').click()
    side = drawn(page, "#view")
    assert top[1] != side[1]
    x, y = _middle(page.locator("#view"))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y + 60, steps=4)
    page.mouse.up()
    assert drawn(page, "#view")[1] != side[1]


def test_it_says_that_it_is_a_simulation_of_which_robot(open_page):
    page = open_page()
    playwright.expect(page.locator("#robot")).to_have_text("caramelo")
    playwright.expect(page.locator("#sim")).to_be_visible()
    assert page.title() == "caramelo, simulation"
    playwright.expect(page.locator("#grounds")).to_be_hidden()  # the plane has one ground


def test_a_real_robot_is_no_simulation(open_page):
    page = open_page(script="""
        const told = JSON.parse;
        JSON.parse = (text) => Object.assign(told(text), text.includes('"hello"') ? {simulated: false} : {});
    """)
    playwright.expect(page.locator("#robot")).to_have_text("caramelo")
    playwright.expect(page.locator("#sim")).to_be_hidden()
    assert page.title() == "caramelo"


def test_the_way_and_the_speeds_are_told(teleop, open_page):
    page = open_page()
    start_m = teleop.status()["odometry"][0]
    speeds = re.compile("ahead 0.15 \N{RIGHTWARDS ARROW} 0.(0[1-9]|1)")  # on a busy machine it walks more slowly

    def told(status):
        return status["odometry"][0] > start_m + 0.05 and speeds.match(page.locator("#speed").inner_text())

    driven(teleop, key(page, "w"), told)
    playwright.expect(page.locator("#walked")).not_to_have_text("0.00 m")
    playwright.expect(page.locator("#place")).to_have_text(re.compile(r"ahead -?\d+\.\d\d m, left"))
    page.keyboard.up("w")


def test_full_stick_is_the_gaits_own_limit_and_what_is_beyond_is_told(teleop, open_page):
    page = open_page()
    page.locator("#share").fill("100")
    most = {}
    for gait in ("trot", "paper-trot"):
        page.locator("#gait").select_option(gait)
        fastest = teleop.wait(lambda status, gait=gait: status["gait"] == gait)["fastest"]
        full = pytest.approx(fastest[0], rel=0.02)
        driven(teleop, key(page, "w"), lambda status, full=full: walks(status) and status["speed"][0] == full)
        most[gait] = fastest[0]
        page.keyboard.up("w")
        teleop.wait(lambda status: status["state"] == "standing")
    assert most["trot"] > 1.5 * most["paper-trot"]
    page.close()
    teleop.wait(lambda status: status["driver"] is None)
    wish = {**STILL, "vx_m_s": 9.0}
    teleop.say(type="gait", gait="trot")
    limited = teleop.wait(lambda status: teleop.say(**wish) or status["slower"])["slower"]
    assert limited == "trot is limited to 0.3 m/s by speed_limits.vx_m_s"
    watching = open_page()
    teleop.wait(lambda status: teleop.say(**wish) or watching.locator("#why").inner_text() == limited)
    teleop.say(type="release")


def test_buttons_that_can_do_nothing_now_look_so_and_say_why(teleop, open_page):
    page = open_page()
    for name, why in (("stand", "the robot already stands"), ("reset", "nothing to reset")):
        playwright.expect(page.locator(f"#{name}")).to_be_disabled()
        assert page.locator(f"#{name}").get_attribute("title") == why
    playwright.expect(page.locator("#sit")).to_be_enabled()
    page.keyboard.press("Space")
    teleop.wait(lambda status: status["stop"])
    playwright.expect(page.locator("#reset")).to_be_enabled()
    playwright.expect(page.locator("#stand")).to_be_disabled()
    assert page.locator("#stand").get_attribute("title") == "reset first"
    assert page.locator("#walk").get_attribute("aria-disabled") == "true"
    assert float(page.locator("#stand").evaluate("(button) => getComputedStyle(button).opacity")) < 0.6


def test_what_is_picked_is_plotted(open_page):
    page = open_page()
    page.locator("#plot-pick").select_option("battery")
    page.locator("#plot-pick").select_option("FR calf angle")
    playwright.expect(page.locator("#plot-list figure")).to_have_count(2)
    playwright.expect(page.locator("#plot-list figcaption").first).to_have_text("battery: 12.0 V")
    wait_until(lambda: drawn(page, "#plot-list figure:last-child canvas")[0] > 10, "a line is drawn")
    page.locator("#plot-pick").select_option("battery")
    playwright.expect(page.locator("#plot-list figure")).to_have_count(2)
    page.locator("#plot-clear").click()
    playwright.expect(page.locator("#plot-list figure")).to_have_count(0)


@pytest.mark.parametrize("viewport", [PHONE, LYING, DESK], ids=["portrait", "landscape", "desktop"])
def test_nothing_covers_the_picture(open_page, viewport):
    page = open_page(viewport, touch=viewport is not DESK)
    picture = page.locator("#view").bounding_box()
    for name in ("walk", "turn", "stop"):
        box = page.locator(f"#{name}").bounding_box()
        apart = (
            box["x"] + box["width"] <= picture["x"]
            or picture["x"] + picture["width"] <= box["x"]
            or box["y"] + box["height"] <= picture["y"]
            or picture["y"] + picture["height"] <= box["y"]
        )
        assert apart, name
    assert picture["y"] + picture["height"] <= viewport["height"], "all of it is seen"
    assert picture["height"] > 100


def press_until(teleop, page, key, found):
    """Press a key until it works: a page that a busy machine halts for seconds is off the line for a while."""
    for _ in range(20):
        page.keyboard.press(key)
        with contextlib.suppress(UserError):
            return teleop.wait(found, 6)
    raise AssertionError(f"{key} does nothing")


def measured(browser, folder, presses, stops):
    """Press keys and stop; return the figures of the command.

    Its loop measures from the browser's event to the packet, both by this machine's clock.
    """
    with Teleop(folder) as teleop:
        page = patient(browser.new_page())
        page.goto(teleop.url)
        page.wait_for_selector("#take:enabled")
        press_until(teleop, page, "t", lambda status: status["state"] == "standing")
        for number in range(presses):
            page.keyboard.down("w")
            let_pass(0.047 + number % 13 / 1000)
            page.keyboard.up("w")
            let_pass(0.031 + number % 17 / 1000)
        for _ in range(stops):
            press_until(teleop, page, "Space", lambda status: status["stop"])
            press_until(teleop, page, "r", lambda status: status["stop"] is None)
        return teleop.stop()


def test_latency_is_measured_end_to_end(browser, tmp_path):
    figures = measured(browser, tmp_path, 15, 3)
    keys, stops = figures["command_to_packet_ms"]["web"], figures["stop_to_packet_ms"]["web"]
    assert keys["count"] >= 25
    assert keys["p50"] < 100
    assert stops["count"] == 3
    assert stops["p50"] < 100


@pytest.mark.slow
def test_latency_figures(browser, tmp_path):
    figures = measured(browser, tmp_path, 300, 60)
    print({key: figures[key] for key in ("command_to_packet_ms", "stop_to_packet_ms", "missed", "ticks", "busy_ms")})
    assert figures["command_to_packet_ms"]["web"]["p99"] <= 150, "five times what is aimed at: the machine may be busy"
    assert figures["stop_to_packet_ms"]["web"]["p99"] <= 125


def told_code(capfd):
    return re.search(r"pairing code (\d{6})", capfd.readouterr().err)[1]


def test_an_unpaired_page_says_so_and_drives_once_it_is_paired(browser, tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    with Teleop(tmp_path, host="0.0.0.0") as teleop:
        code = told_code(capfd)
        page = patient(browser.new_page())
        page.goto(teleop.url)
        playwright.expect(page.locator("#word")).to_have_text("not paired")
        assert page.locator("#stop").get_attribute("class") == "dead", "it could stop nothing"
        page.fill("#code", code)
        page.keyboard.press("Enter")
        page.wait_for_selector("#take:enabled")
        assert page.locator("#stop").get_attribute("class") == ""
        press_until(teleop, page, "Space", lambda status: status["stop"])
        page.close()


def test_a_pairing_by_qr_code_outlasts_a_restart_until_it_is_revoked(browser, tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    context = patient(browser.new_context())
    with Teleop(tmp_path, host="0.0.0.0") as teleop:
        page = context.new_page()
        page.goto(f"{teleop.url}/#{told_code(capfd)}")
        page.wait_for_selector("#take:enabled")
        assert page.url == f"{teleop.url}/", "the code does not stay in the address"
        page.close()
    with Teleop(tmp_path, host="0.0.0.0") as teleop:  # another port, another code
        page = context.new_page()
        page.goto(teleop.url)
        page.wait_for_selector("#take:enabled")
        page.locator("#unpair").click()
        playwright.expect(page.locator("#word")).to_have_text("not paired")
        page.reload()
        playwright.expect(page.locator("#word")).to_have_text("not paired")
    context.close()


def test_an_open_page_is_hung_up_on_when_all_pairings_are_revoked(browser, tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    with Teleop(tmp_path, host="0.0.0.0") as teleop:
        page = patient(browser.new_page())
        page.goto(f"{teleop.url}/#{told_code(capfd)}")
        page.wait_for_selector("#take:enabled")
        page.keyboard.press("t")
        teleop.wait(lambda status: status["driver"])
        Paired(tmp_path / NAME).forget_all()
        playwright.expect(page.locator("#word")).to_have_text("not paired")
        teleop.wait(lambda status: status["driver"] is None)
        page.close()


def test_nothing_acts_before_the_robot_is_heard(browser, tmp_path):
    """Not even while the page connects: a key would be lost, and nobody told."""
    with Teleop(tmp_path) as teleop:
        page = patient(browser.new_page())
        page.add_init_script("window.WebSocket = class { static OPEN = 1; send() {} }")  # connects for ever
        page.goto(teleop.url)
        assert page.evaluate("document.getElementById('take').disabled")
        page.close()


def test_in_space_a_ground_is_chosen_and_goes_by(browser, tmp_path):
    with Teleop(tmp_path, sim=("--sim", "--direct", "--in", "space")) as teleop:
        page = patient(browser.new_page(viewport=DESK))
        page.goto(teleop.url)
        page.wait_for_selector("#take:enabled")
        playwright.expect(page.locator("#ground option")).to_have_text(list(profiles()))
        page.locator("#ground").select_option("ramp")
        lies = teleop.wait(lambda status: status["ground"] == "ramp")
        assert lies["place"][0] == pytest.approx(0.0, abs=0.02)
        press_until(teleop, page, "t", lambda status: status["state"] == "standing")
        playwright.expect(page.locator("#ground")).to_be_disabled()
        assert page.locator("#ground").get_attribute("title").startswith("switch the joints off first")
        before = drawn(page, "#view")
        driven(teleop, key(page, "d"), lambda status: status["place"][3] < -0.1)  # in the plane it could not turn
        page.keyboard.up("d")
        assert drawn(page, "#view")[1] != before[1]
        page.close()
