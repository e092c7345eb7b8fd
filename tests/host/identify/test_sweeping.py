"""Sweeps over the servos' protocol: only one leg holds, all is limp in the end, what is kept is read as it was."""

import pytest

from host.bus.dynamixel import table as t
from host.bus.dynamixel.link import ServoError
from host.identify import keeping, procedure, sweeping
from host.identify.carried import in_the_air
from host.identify.plan import FALLS_RAD_S2, REACH_RAD, plan
from host.util.errors import UserError

from .robots import ROBOT, stand

FEW = ("run +0.24", "coast -0.50", "steps")


@pytest.fixture(autouse=True)
def few_sweeps(monkeypatch):
    """Sweep little: these tests look at what goes on around the sweeps."""
    monkeypatch.setattr(sweeping, "plan", lambda *args: [sweep for sweep in plan(*args) if sweep.name in FEW])


@pytest.fixture
def made():
    return stand(3)


def holding(made):
    return [joint for joint, servo in enumerate(made.bus.servos) if servo.get(t.TORQUE_ENABLE)]


def test_no_sweep_leaves_its_reach():
    for sweep in plan(0.3, REACH_RAD, in_the_air(ROBOT, 1)):
        assert all(abs(move.goal_rad - 0.3) <= REACH_RAD + 1e-9 for move in sweep.moves), sweep.name
        assert all(move.most is None or move.most <= 0.5 for move in sweep.moves)


@pytest.mark.parametrize("joint", range(3))
def test_runs_begin_where_the_weight_lays_the_play(joint):
    load = in_the_air(ROBOT, joint)
    for sweep in sweeping.sweeps_of(ROBOT, joint):
        assert abs(load.at_scalar(sweep.start_rad)) > FALLS_RAD_S2 * load.inertia_kg_m2, sweep.name


def test_only_the_leg_of_the_joint_holds_and_then_nothing_does(made):
    seen = set[int]()
    traces = sweeping.sweep_joint(made.rig, 4, lambda share: seen.update(holding(made)))
    assert seen == {3, 4, 5}
    assert holding(made) == []
    assert {trace.name for trace in traces} == set(FEW)
    assert -1.0 in next(trace for trace in traces if trace.name.startswith("coast")).most


def test_ctrl_c_leaves_all_joints_limp_and_nothing_half_written(made, tmp_path):
    def interrupt(what, share):
        if what == "FR thigh":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        procedure.measure_in_air(made.rig, tmp_path, range(3), interrupt)
    assert holding(made) == []
    assert [path.name for path in tmp_path.iterdir()] == ["FR-hip.mcap"]
    said = []
    procedure.measure_in_air(made.rig, tmp_path, range(3), lambda what, share: said.append(what))
    assert set(said) == {"FR thigh", "FR calf"}  # the hip is kept


def test_what_is_kept_is_read_as_it_was(made, tmp_path):
    traces = sweeping.sweep_joint(made.rig, 2)
    path = keeping.path_of(tmp_path, 2)
    keeping.keep_traces(path, ROBOT, traces)
    assert keeping.kept_traces(path, ROBOT) == traces
    with pytest.raises(UserError, match="of robot caramelo, allowed other"):
        keeping.kept_traces(path, ROBOT.model_copy(update={"name": "other"}))
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(UserError, match="damaged"):
        keeping.kept_traces(path, ROBOT)


def test_a_servo_that_falls_silent_ends_it_with_all_joints_limp(made):
    def unplug(share):
        made.bus.servo(made.rig.calibration.ids[0]).missing = True

    with pytest.raises(ServoError, match="FR hip"):
        sweeping.sweep_joint(made.rig, 0, unplug)
    assert [joint for joint in holding(made) if joint] == []


def test_a_hot_servo_ends_it(made):
    made.bus.servo(made.rig.calibration.ids[1]).put(t.PRESENT_TEMPERATURE, 79)
    with pytest.raises(ServoError, match="79 C, allowed 75"):
        sweeping.sweep_joint(made.rig, 1)
    assert holding(made) == []


def test_a_joint_that_leaves_its_place_is_let_go(made):
    def knock(share):
        made.plant._joints[1].position_rad += 0.9

    with pytest.raises(ServoError, match="it was let go"):
        sweeping.sweep_joint(made.rig, 1, knock)
    assert holding(made) == []


def test_a_thigh_whose_sign_is_wrong_is_let_go_and_told():
    made = stand(3, "reversed", 1)
    with pytest.raises(ServoError, match=r"FR thigh .* it was let go; check its calibration"):
        sweeping.sweep_joint(made.rig, 1)
    assert holding(made) == []


def test_a_robot_without_room_for_sweeps_is_refused():
    limits = ROBOT.joint_limits.model_copy(update={"calf_deg": (-100.0, -80.0)})
    with pytest.raises(UserError, match="FR calf: 9 deg"):
        sweeping.sweeps_of(ROBOT.model_copy(update={"joint_limits": limits}), 2)


def test_swaying_reads_all_joints_and_lets_go(made, monkeypatch):
    poses = [sweeping._shifted(ROBOT, (0, 0, 0.001 * k)) for k in range(9)]
    monkeypatch.setattr(sweeping, "_sway", lambda robot: poses)
    made.put_on_ground()
    rows = sweeping.stand_and_sway(made.rig)
    assert len(rows) == 9
    assert all(min(row.load[2::3]) > 0.25 for row in rows)  # every knee pushes; on the way down friction holds
    assert holding(made) == []
