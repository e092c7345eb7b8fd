"""What viewers draw: messages of the standard schemas, links where the kinematics has them, and the record of them."""

import json
from math import cos, sin
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from host.control.odometry import Odometry
from host.records.channels import DRAWN
from host.records.log import LoopLog, about
from host.records.reader import read_record
from host.records.recorder import Recorder
from host.records.scene import Scene
from host.robot.file import load_robot
from host.robot.kinematics_si import leg_forward
from host.robot.model import JOINT_NAMES, LEG_NAMES
from tests.host.control.rig import AHEAD, Rig

JOINTS = [0.1, 0.5, -1.1, -0.2, 0.6, -1.0, 0.05, 0.7, -1.3, 0.0, 0.4, -0.9]
MOVED = Odometry(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, tuple(range(1, 10)))
TIME_NS = 1_700_000_000_123_456_789


def matrix(transform):
    """Return a transform as a 4 x 4 matrix, from its quaternion by the textbook."""
    x, y, z, w = (transform["rotation"][name] for name in "xyzw")
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turn, [transform["translation"][name] for name in "xyz"]
    return whole


def world(transforms):
    """Return name -> 4 x 4 place of every frame."""
    placed = {"odom": np.eye(4)}
    for each in transforms:  # parents come first
        placed[each["child_frame_id"]] = placed[each["parent_frame_id"]] @ matrix(each)
    return placed


@pytest.mark.parametrize("name", ["caramelo", "parallel", "solo12"])
def test_links_are_where_the_kinematics_has_them(name):
    robot = load_robot(name)
    placed = world(Scene(robot).places(TIME_NS, JOINTS, None, Odometry())["/tf"]["transforms"])
    body = np.linalg.inv(placed["base_link"])
    for leg, label in enumerate(LEG_NAMES):
        foot = leg_forward(robot.geometry.links_m, robot.side(leg), tuple(JOINTS[3 * leg : 3 * leg + 3]))
        found = (body @ placed[f"{label}_foot"])[:3, 3]
        assert found == pytest.approx((robot.hip_m(leg)[0] + foot[0], robot.hip_m(leg)[1] + foot[1], foot[2]), abs=1e-4)


def test_the_body_is_turned_as_the_sensor_says_and_stands_on_the_ground():
    robot, (roll, pitch, yaw) = load_robot("caramelo"), (0.2, -0.3, 1.0)
    placed = world(Scene(robot).places(TIME_NS, JOINTS, (roll, pitch), Odometry(1.5, -0.5, yaw))["/tf"]["transforms"])
    rx = np.array([[1, 0, 0], [0, cos(roll), -sin(roll)], [0, sin(roll), cos(roll)]])
    ry = np.array([[cos(pitch), 0, sin(pitch)], [0, 1, 0], [-sin(pitch), 0, cos(pitch)]])
    rz = np.array([[cos(yaw), -sin(yaw), 0], [sin(yaw), cos(yaw), 0], [0, 0, 1]])
    assert placed["base_link"][:3, :3] == pytest.approx(rz @ rx @ ry, abs=1e-4)  # shared/sense/attitude.py
    assert placed["base_link"][:2, 3] == pytest.approx((1.5, -0.5))
    lowest = min(placed[f"{leg}_foot"][2, 3] for leg in LEG_NAMES)
    assert lowest == pytest.approx(robot.geometry.foot_radius_m, abs=2e-4)


def test_frames_joints_and_shapes_are_the_urdfs():
    scene = Scene(load_robot("parallel"))
    parts, places = scene.parts(TIME_NS), scene.places(TIME_NS, JOINTS, None, Odometry())
    root = Xml.fromstring(parts["/robot_description"]["data"])
    links = {link.attrib["name"] for link in root.findall("link")}
    drawn = {link.attrib["name"] for link in root.findall("link") if link.find("visual") is not None}
    assert {each["child_frame_id"] for each in places["/tf"]["transforms"]} == links - {"imu_link"}
    assert {entity["frame_id"] for entity in parts["/scene"]["entities"]} == drawn
    assert {f"{leg}_hip" for leg in LEG_NAMES} <= drawn
    hinges = [joint.attrib["name"] for joint in root.findall("joint") if joint.attrib["type"] == "revolute"]
    states = places["/joint_states"]["joints"]
    names = [f"{leg}_{joint}_joint" for leg in LEG_NAMES for joint in JOINT_NAMES]
    assert [state["name"] for state in states] == hinges == names
    assert [state["position"] for state in states] == JOINTS


def all_messages():
    scene = Scene(load_robot("caramelo"))
    speeds = [0.1] * 12
    return {**scene.parts(TIME_NS), **scene.places(TIME_NS, JOINTS, (0.1, 0.1), MOVED, speeds)}


def complaints(value, schema, where=""):
    """Yield where a value is not as its schema says; every key must be one of the schema's."""
    types = {"object": dict, "array": list, "string": str, "number": (int, float), "integer": int, "boolean": bool}
    if not isinstance(value, types[schema["type"]]):
        yield where
    elif schema["type"] == "object":
        for key, each in value.items():
            if key in schema["properties"]:
                yield from complaints(each, schema["properties"][key], f"{where}.{key}")
            else:
                yield f"{where}.{key}"
    elif schema["type"] == "array":
        for at, each in enumerate(value):
            yield from complaints(each, schema["items"], f"{where}.{at}")


@pytest.mark.parametrize("topic", DRAWN)
def test_messages_are_as_their_schemas_say(topic):
    assert list(complaints(all_messages()[topic], DRAWN[topic])) == []


def test_the_covariance_of_x_y_and_yaw_stands_in_its_six_rows():
    told = all_messages()["/odometry"]["pose_covariance"]
    rows = [told[6 * row : 6 * row + 6] for row in range(6)]
    assert [[row[0], row[1], row[5]] for row in (rows[0], rows[1], rows[5])] == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert sum(map(bool, told)) == 9


def test_a_message_that_is_otherwise_is_found():
    assert list(complaints({"data": 1}, DRAWN["/robot_description"])) == [".data"]
    assert list(complaints({"dada": ""}, DRAWN["/robot_description"])) == [".dada"]


def built(messages, title, value, schema):
    """Make the SDK's own message of a value: it takes only the keywords that the standard has, in its types."""
    if schema["type"] == "array":
        return [built(messages, schema["items"].get("title", ""), each, schema["items"]) for each in value]
    if schema["type"] != "object":
        return value
    kind = {"time": "Timestamp", "duration": "Duration"}.get(title, title.removeprefix("foxglove."))
    fields = {}
    for key, each in value.items():
        rule = schema["properties"][key]
        fields[key] = built(messages, rule.get("title", ""), each, rule)
    return getattr(messages, kind)(**fields)


@pytest.mark.parametrize("topic", [topic for topic in DRAWN if DRAWN[topic]["title"].startswith("foxglove.")])
def test_schemas_are_foxgloves_own(topic):
    messages = pytest.importorskip("foxglove.messages", reason="the SDK is not installed (extra foxglove)")
    told = built(messages, DRAWN[topic]["title"], all_messages()[topic], DRAWN[topic])
    assert len(told.encode()) > 20
    with pytest.raises(TypeError):
        built(messages, "foxglove.Vector3", {"w": 1.0}, {"type": "object", "properties": {"w": {"type": "number"}}})


def test_a_record_has_them_beside_its_channels(tmp_path):
    from mcap.reader import make_reader

    rig = Rig()
    recorder = Recorder(tmp_path / "drive.mcap", about(rig.robot, rig.supervisor))
    rig.loop._after_tick = LoopLog(recorder).tick
    rig.stand()
    rig.run(2.0, AHEAD)
    recorder.close()
    counts = read_record(recorder.path).counts
    ticks = counts["/timing"]
    assert counts["/tf"] == counts["/odometry"] == counts["/joint_states"] == (ticks + 1) // 2
    assert counts["/scene"] == counts["/robot_description"] == (ticks + 49) // 50
    names, poses = {}, []
    with recorder.path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            names[channel.topic] = (schema.name, schema.encoding, channel.message_encoding)
            if channel.topic == "/odometry":
                told = json.loads(message.data)
                poses.append(told["pose"]["position"]["x"])
                stamp = told["timestamp"]["sec"] * 10**9 + told["timestamp"]["nsec"]
                assert stamp == message.log_time
    assert names["/tf"] == ("foxglove.FrameTransforms", "jsonschema", "json")
    assert names["/joint_states"][0] == "foxglove.JointStates"
    assert names["/robot_description"][0] == "std_msgs/String"
    assert names["/joints"][0] == "joints"
    assert poses[-1] > 0.02


def test_a_csv_file_of_them_has_objects_as_json(tmp_path):
    from host.records.export import export_csv

    recorder = Recorder(tmp_path / "drive.mcap", {"robot": "caramelo"})
    for topic, values in all_messages().items():
        recorder.put(topic, 1.0, values)
    recorder.close()
    paths = export_csv(read_record(recorder.path), tmp_path / "csv")
    assert {path.stem for path in paths} == {topic[1:] for topic in DRAWN}
    text = (tmp_path / "csv/joint_states.csv").read_text()
    assert text.splitlines()[0] == "time_s,timestamp,joints"
    assert '""FR_hip_joint""' in text
