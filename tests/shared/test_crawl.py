"""The crawl in the planner: when it begins and ends, that goals never jump; and its parts against plain formulas."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.control.planner import Driver
from host.robot.file import load_robot
from host.robot.plane import planar_robot
from shared.body.params import FL
from shared.crawl import state as at
from shared.crawl.crawl import recentre_map
from shared.crawl.footholds import MOST_FOOTHOLDS, foothold_add, foothold_drop
from shared.crawl.ground import TROT_LANDINGS
from shared.crawl.map import fit_body
from shared.crawl.state import Crawl, Footholds, Map
from shared.crawl.swing import brake_speed
from shared.gait.table import MOVER_TABLE
from shared.num.filters import fraction, quintic_q15
from shared.planner import status as n
from shared.planner.handover import REASON_COMMAND, REASON_EVEN, REASON_HELD
from shared.record import pack, unpack
from shared.sense.legs import Sensing
from sim2d import terrain
from sim2d.run import simulate

from .bars import integers, repeatable
from .robots import block
from .walker import BACK, OFF, ON, Walker, phase


@repeatable(800)
@given(integers(-(1 << 25) + 1, (1 << 25) - 1), integers(0, 32768))
def test_fraction_is_the_product_within_a_unit(value, share):
    assert abs(fraction(value, share) - value * share / 32768) <= 1


@repeatable(500)
@given(integers(1, 16383), st.floats(0, 1))
def test_quintic_is_the_polynomial(ticks, share):
    tick = round(share * ticks)
    u = tick / ticks
    assert abs(quintic_q15(tick, ticks) / 32768 - u**3 * (10 - 15 * u + 6 * u * u)) <= 64 / 32768
    assert (quintic_q15(0, ticks), quintic_q15(ticks, ticks)) == (0, 32768)


@repeatable(300)
@given(integers(1, 1 << 19), integers(0, 2000))
def test_brake_speed_stops_within_the_way(brake, way):
    exact = 16 * math.sqrt(brake * way)
    assert brake_speed(brake, way) <= exact
    assert brake_speed(brake, way) >= min(exact, 16 * math.sqrt((1 << 30) - 1 - brake - way)) - 17


def standing(x_lu, y_lu, heading_rad):
    """Return a crawl whose feet stand in a map, and what they look like from a body at (x, y) with a heading."""
    crawl, sensing = Crawl(block("caramelo")), Sensing()
    dice = random.Random(4)
    for leg in range(4):
        x = (1 - leg // 2 * 2) * 15000 + dice.randint(-3000, 3000)
        foot = x, (leg % 2 * 2 - 1) * 15000, dice.randint(-500, 500)
        unpack(crawl.map.feet[leg], [value << 8 for value in foot])
        dx, dy = foot[0] - x_lu, foot[1] - y_lu
        cosine, sine = math.cos(heading_rad), math.sin(heading_rad)
        seen = dx * cosine + dy * sine, dy * cosine - dx * sine, foot[2] - 24000
        unpack(sensing.level[leg], [round(value) for value in seen])
        crawl.support.stance[leg], crawl.support.share_q12[leg] = 1, 4096
    return crawl, sensing


@repeatable(100)
@given(integers(-3000, 3000), integers(-3000, 3000), st.floats(-0.3, 0.3))
def test_the_body_is_found_among_its_feet(x_lu, y_lu, heading_rad):
    crawl, sensing = standing(x_lu, y_lu, heading_rad)
    for _ in range(2):
        fit_body(crawl, sensing)
    x, y, z, _, _, yaw = pack(crawl.map.body_pose)
    assert abs(yaw / (1 << 24) * 2 * math.pi - heading_rad) < 3e-4
    assert math.dist((x / 256, y / 256, z / 256), (x_lu, y_lu, 24000)) < 8


def test_a_foot_in_the_air_does_not_move_the_body():
    crawl, sensing = standing(100, -50, 0.05)
    fit_body(crawl, sensing)
    before = pack(crawl.map.body_pose)
    crawl.support.stance[0] = 0
    for axis in range(3):
        sensing.level[0][axis] += 3000
    fit_body(crawl, sensing)
    moved = [abs(a - b) for a, b in zip(before, pack(crawl.map.body_pose), strict=True)]
    assert max(moved[:3]) <= 8 * 256


def places(crawl):
    """Return the places of a crawl as seen from its body."""
    body, path, swing = crawl.map.body_pose, crawl.path, crawl.swing
    points = crawl.map.feet + crawl.map.measured + crawl.footholds.sides[0].places + crawl.footholds.sides[1].places
    found = [value for point in points for value in pack(point)]
    found += [pose[axis] for pose in (path.wanted, path.from_pose, path.to_pose) for axis in range(3)]
    found += [*pack(swing.place), *pack(swing.target)]
    found = [value - body[at % 3] for at, value in enumerate(found)]
    found += [swing.departure[axis] - body[axis] for axis in range(2)] + [swing.ground - body.z, swing.apex - body.z]
    return found + [x - body.x for x in crawl.contact.past_x]


def test_the_map_is_moved_exactly():
    """After it nothing has changed but the origin: every place lies where it did from the body."""
    crawl, dice = Crawl(block("caramelo")), random.Random(7)
    queues = [place for queue in crawl.footholds.sides for place in queue.places]
    for queue in crawl.footholds.sides:
        queue.waiting = MOST_FOOTHOLDS
    for values in (*crawl.map.feet, *crawl.map.measured, *queues, crawl.path.wanted, crawl.path.to_pose,
                   crawl.swing.place, crawl.swing.target, crawl.swing.departure, crawl.contact.past_x):
        unpack(values, [dice.randint(-(1 << 22), 1 << 22) for _ in pack(values)])
    crawl.map.body_pose.x = (crawl.params.leg_length << 7) + 12345
    crawl.swing.ground = crawl.swing.place.z - 777
    away = places(crawl)
    assert recentre_map(crawl) == 1
    assert places(crawl) == away
    assert crawl.map.body_pose.x == 0
    assert recentre_map(crawl) == 0


def test_footholds_come_out_in_the_order_they_went_in():
    map, footholds = Map(), Footholds()
    for step in range(MOST_FOOTHOLDS + 2):
        map.feet[FL].x = step
        assert foothold_add(map, footholds, 1) == min(step + 1, MOST_FOOTHOLDS)
    for step in range(2, MOST_FOOTHOLDS + 2):
        assert footholds.sides[1].places[0].x == step
        foothold_drop(footholds, 1)
    assert footholds.sides[1].waiting == 0


def test_the_crawl_begins_when_commanded_and_tells_why():
    walker = Walker()
    walker.walk("crawl")
    walker.ticks(50)
    assert (phase(walker.planner), walker.planner.status.reason) == (ON, REASON_COMMAND)
    assert walker.state == n.WALKING


@pytest.mark.parametrize("missing", ["joints", "tilt"])
def test_without_joints_or_attitude_it_stands_and_says_so(missing):
    walker = Walker()
    walker.walk("crawl")
    setattr(walker.sensed.valid, missing, 0)
    assert walker.ticks(50) & n.BLIND
    assert (phase(walker.planner), walker.state) == (OFF, n.STANDING)


class Scripted:
    """The planner in the sagittal simulator, with its command changed at given seconds; keeps states and goal steps."""

    rate_hz = 50

    def __init__(self, gait, changes):
        self.driver = Driver(load_robot("caramelo"), planar=True)
        self.driver.set_command(mode="walk", gait=gait, vx_m_s=0.05)
        self.changes = {round(at_s * self.rate_hz): wish for at_s, wish in changes.items()}
        self.ticks, self.states, self.crawls, self.reasons = 0, [], [], []
        self.goals, self.largest_step_rad = None, 0.0

    def tick(self, sensed):
        self.ticks += 1
        self.driver.set_command(**self.changes.get(self.ticks, {}))
        rates = (0.0, sensed.pitch_rate_rad_s, 0.0)
        self.driver.sense(sensed.joint_position_rad, sensed.roll_rad, sensed.pitch_rad, rates)
        goals = self.driver.step()
        if self.goals and self.ticks > 1.5 * self.rate_hz:
            steps = [abs(a - b) for a, b in zip(goals, self.goals, strict=True)]
            self.largest_step_rad = max(self.largest_step_rad, *steps)
        self.goals = goals
        status = self.driver.planner.status
        self.states.append(status.state)
        self.crawls.append(phase(self.driver.planner))
        self.reasons.append(status.reason)
        return goals


# Of eleven slopes from -10 to 10 degrees only this one, and not with honest drives.
LOOPS = pytest.mark.xfail(reason="high swings downhill are taken for held up, which keeps them high", strict=True)


def slope_all_along(angle_deg):
    """Return a slope that the robot stands on from the start."""
    rise = math.tan(math.radians(angle_deg))
    return terrain.Terrain("slope", ((-3.0, -3.0 * rise), (4.0, 4.0 * rise)))


def walked(controller, ground, seconds, distance_m=None):
    robot = planar_robot(load_robot("caramelo"))
    return simulate(robot, controller, ground, duration_s=seconds, distance_m=distance_m, stuck_after_s=seconds)


def test_no_goal_jumps_into_the_crawl_through_it_and_out_of_it():
    script = Scripted("paper-trot", {2: {"gait": "crawl"}, 16: {"gait": "trot"}, 22: {"gait": "paper-trot"}})
    recording = walked(script, terrain.flat(), 30.0)
    assert recording.outcome.kind != "fell"
    assert ON in script.crawls[200:450]
    assert script.driver.planner.status.mover == MOVER_TABLE
    assert script.crawls[-1] == OFF
    assert script.reasons[-1] == REASON_COMMAND
    assert script.largest_step_rad <= 0.15  # a trot's swing at 0.05 m/s takes 0.12 in a tick


def test_on_level_ground_the_legs_land_in_order_without_a_second_try():
    class Landings(Scripted):
        legs, seen = (), 0

        def tick(self, sensed):
            goals, state = super().tick(sensed), self.driver.planner.crawl
            if state.event.number != self.seen:
                self.seen = state.event.number
                assert state.event.code == at.EVENT_LANDED
                self.legs += (state.event.leg,)
            return goals

    script = Landings("crawl", {})
    walked(script, terrain.flat(), 20.0)
    assert len(script.legs) >= 7
    assert script.legs[:8] == (3, 1, 2, 0, 3, 1, 2, 0)[: len(script.legs)]


def test_a_command_of_nothing_lets_it_rest_with_all_feet_down_and_then_sit():
    script = Scripted("crawl", {5: {"vx_m_s": 0.0}, 9: {"mode": "sit"}})
    walked(script, terrain.flat(), 14.0)
    assert script.crawls[100] == ON
    assert script.states[440] == n.STANDING
    assert list(script.driver.planner.crawl.support.stance[:4]) == [1, 1, 1, 1]
    assert (script.states[-1], script.crawls[-1]) == (n.SEATED, OFF)


def over_a_high_step(seconds, changes):
    """Walk at a step of 65 mm, higher than the trot takes."""
    script = Scripted("trot", changes)
    script.driver.set_command(vx_m_s=0.1)
    return script, walked(script, terrain.step(0.065, 0.3, None), seconds, 1.1)


def test_the_trot_gives_way_to_the_crawl_where_it_is_held_up_and_goes_on_behind_it():
    script, recording = over_a_high_step(150.0, {})
    assert recording.outcome.ok, recording.outcome.sentence
    backing = [tick for tick, crawl in enumerate(script.crawls) if crawl == BACK]
    assert script.reasons[backing[0]] == REASON_HELD
    assert script.states[backing[-1]] == n.STANDING
    assert script.crawls[backing[-1] + 1] == ON
    x_m = recording.torso_x_m
    # In the plane its feet hang on this edge: 5 mm. How far it goes back: tests/host/sim/space/test_trot.py.
    assert 0.0 < x_m[backing[0]] - x_m[backing[-1]] < 0.14
    assert script.reasons[-1] == REASON_EVEN
    assert script.crawls[-1] == OFF
    assert script.driver.planner.crawl.ground.landings >= TROT_LANDINGS


@pytest.mark.parametrize("angle_deg", [8.0, -7.5, pytest.param(-8.0, marks=LOOPS), -8.5])
def test_on_a_slope_the_trot_takes_over_at_the_crawls_next_rest(angle_deg):
    script = Scripted("crawl", {4: {"gait": "trot"}})
    recording = walked(script, slope_all_along(angle_deg), 58.0, 0.6)
    assert recording.outcome.ok, recording.outcome.sentence
    assert ON in script.crawls[:200]
    assert ON not in script.crawls[400:]


def test_backing_off_ends_with_the_command_to_walk_on():
    held_up, _ = over_a_high_step(30.0, {})
    second = (held_up.crawls.index(BACK) + 1) // held_up.rate_hz + 1  # a tick after it began, or later
    script, _ = over_a_high_step(second + 6.0, {second: {"mode": "stand"}})
    assert BACK in script.crawls
    assert script.crawls[-1] == OFF
    assert script.states[-1] == n.STANDING
