"""Records: objects here, arrays with places for viper and C, native classes for mypyc; wrong names are found."""

from pathlib import Path

import pytest

from host import ROOT
from host.boards.build.lower import lower
from host.boards.build.rewrite import rewrite
from host.boards.build.source import BuildError, read_modules
from host.boards.build.typed import typed_modules
from shared.body.axes import POSE_AXES, Pose
from shared.body.params import LEGS, Params
from shared.num.pid import Pid
from shared.record import copy, pack, unpack
from shared.sense.sensed import Sensed

HEAD = '''"""One."""

from .record import Axes, field, part, parts, record, vector
from .runtime import Ints, const, hot, zeros

LEGS = const(4)


@record
class Leg:
    """A leg."""

    length: int = field("lu", "of the thigh", 3)
    rest: Ints = vector(3, "lu", "the foot")


@record
class Robot:
    """A robot."""

    rate_hz: int = field("Hz", "ticks a second")
    legs: list[Leg] = parts(LEGS, Leg, "FR, FL, RR, RL")
    arm: Leg = part(Leg, "in front")


@record
class Point(Axes):
    """A point."""

    x: int = field("lu", "forward")
    y: int = field("lu", "left")
    z: int = field("lu", "up")


@record
class Path:
    """Two points."""

    ticks: int = field("ticks", "of the way")
    start: Point = part(Point, "where it begins")
    end: Point = part(Point, "where it ends")


class Holder:
    """What is handed around."""

    def __init__(self, robot: Robot):
        self.robot = robot
        self.feet = zeros(12)


'''
HOT = '''@hot
def f(holder: Holder, robot: Robot, feet: Ints, leg: int) -> int:
    """Do."""
    mine = holder.robot
    out = holder.feet
    limb = robot.legs[leg]
    limb.length += robot.legs[2].rest[leg + 1] * robot.arm.length
    out[leg] = feet[leg] + mine.rate_hz + limb.rest[2]
    return f(holder, mine, feet, leg)
'''
LOWERED = """@hot
def f(holder, robot, feet, leg: int) -> int:
    \"\"\"Do.\"\"\"; _robot = ptr32(robot); _feet = ptr32(feet)
    mine = ptr32(holder.robot)
    out = ptr32(holder.feet)
    limb = 1 + leg * 4
    _robot[limb] += _robot[leg + 11] * _robot[17]
    out[leg] = _feet[leg] + mine[0] + _robot[limb + 3]
    return f(holder, holder.robot, feet, leg)
"""


def modules(folder: Path, text: str):
    """Return the modules of a core of one file."""
    package = folder / "shared"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    for name in ("runtime.py", "record.py"):
        (package / name).write_bytes((ROOT / "shared" / name).read_bytes())
    (package / "one.py").write_text(HEAD + text)
    return read_modules(folder, ("shared",))


def test_names_become_places_and_no_line_moves(tmp_path):
    made = lower(modules(tmp_path, HOT))["shared.one"].text.decode()
    assert made.endswith(LOWERED)
    assert made.count("\n") == (HEAD + HOT).count("\n")
    assert "def Leg(): return block(4, ((0, 3), ))\n" in made
    assert "def Robot(): return block(21, ((1, 3), (5, 3), (9, 3), (13, 3), (17, 3), ))\n" in made


def test_ordinary_functions_read_the_same_places(tmp_path):
    text = "\n\ndef g(holder: Holder):\n    leg = holder.robot.legs[3]\n    leg.length = 7\n    return leg.rest[1]\n"
    made = lower(modules(tmp_path, HOT + text))["shared.one"].text.decode()
    assert made.endswith("    leg = 13\n    holder.robot[leg] = 7\n    return holder.robot[leg + 2]\n")


LOWERINGS = {  # beside HOT: what is written, and what becomes of it
    "an array's pointer stands behind the docstring": (
        '@hot\ndef g(feet: Ints, leg: int) -> int:\n    """Do."""\n    feet[leg] += 1\n    return g(feet, feet[leg])\n',
        '@hot\ndef g(feet, leg: int) -> int:\n    """Do."""; _feet = ptr32(feet)\n    _feet[leg] += 1\n'
        "    return g(feet, _feet[leg])\n",
    ),
    "or before the first statement": (
        "@hot\ndef g(feet: Ints) -> int:\n    feet[0] += 1\n    return 0\n",
        "@hot\ndef g(feet) -> int:\n    _feet = ptr32(feet); _feet[0] += 1\n    return 0\n",
    ),
    "an array that is only handed on has none": (
        "@hot\ndef g(feet: Ints) -> int:\n    return g(feet)\n", "@hot\ndef g(feet) -> int:\n    return g(feet)\n",
    ),
    "an array of an object is read through one, too": (
        "@hot\ndef g(holder: Holder, leg: int) -> int:\n    return holder.feet[leg] + holder.robot.arm.length\n",
        "@hot\ndef g(holder, leg: int) -> int:\n    _holder_feet = ptr32(holder.feet); "
        "_holder_robot = ptr32(holder.robot); return _holder_feet[leg] + _holder_robot[17]\n",
    ),
    "nor has one in an ordinary function": (
        "def g(feet: Ints, leg: int):\n    return feet[leg]\n", "def g(feet, leg: int):\n    return feet[leg]\n",
    ),
    "axes are read by name or by number": (
        "@hot\ndef g(path: Path, point: Point, axis: int) -> int:\n"
        "    end = path.end\n    end[axis] -= point[axis]\n"
        "    point.z = path.start[axis] + path.start[2]\n    return end.y\n",
        "@hot\ndef g(path, point, axis: int) -> int:\n    _path = ptr32(path); _point = ptr32(point); end = 4\n"
        "    _path[end + axis] -= _point[axis]\n    _point[2] = _path[1 + axis] + _path[3]\n"
        "    return _path[end + 1]\n",
    ),
    "also outside of hot functions": (
        "def g(path: Path, axis: int):\n    return path.end[axis]\n",
        "def g(path, axis: int):\n    return path[4 + axis]\n",
    ),
    "a method named like a field is no field": (
        "def g(stick, robot: Robot):\n    return stick.length(robot.rate_hz) + robot.arm.length\n",
        "def g(stick, robot):\n    return stick.length(robot[0]) + robot[17]\n",
    ),
    "an object's attribute may have a field's name where nothing is known of the object": (
        "class Queue:\n    def __init__(self):\n        self.length = 0\n\n\ndef g(queue):\n    return queue.length\n",
        "def g(queue):\n    return queue.length\n",
    ),
    "an ordinary function's result has no annotation": (
        "def g(robot: Robot) -> Ints:\n    return zeros(robot.rate_hz)\n",
        "def g(robot):\n    return zeros(robot[0])\n",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "made"), LOWERINGS.values(), ids=LOWERINGS)
def test_what_becomes_of_a_function(tmp_path, text, made):
    found = lower(modules(tmp_path, text))["shared.one"].text.decode()
    assert found.endswith("\n\n" + made)
    assert found.count("\n") == (HEAD + text).count("\n")


@pytest.mark.parametrize(
    ("index", "place"),
    [("leg & 1", "10 + (leg & 1)"), ("leg << 1", "10 + (leg << 1)"), ("(leg & 1) + LEGS", "(leg & 1) + 14")],
)
def test_an_index_stays_one_number(tmp_path, index, place):
    text = HOT.replace("rest[leg + 1]", f"rest[{index}]")
    assert f"_robot[{place}] * _robot[17]" in lower(modules(tmp_path, text))["shared.one"].text.decode()


def test_mypyc_gets_a_class(tmp_path):
    found = typed_modules(modules(tmp_path, HOT))["shared.one"].decode()
    assert "length: int; rest: list[int]" in found
    assert "self.legs = [Leg() for _ in range(4)]; self.arm = Leg()" in found
    assert "def f(holder: Holder, robot: Robot, feet: list[int], leg: i64) -> i64:" in found
    assert "return self.x if axis == 0 else self.y if axis == 1 else [self.z][axis - 2]\n" in found
    assert "self.x = value if axis == 0 else self.x; self.y = value if axis == 1 else self.y; " in found
    assert found.count("\n") == (HEAD + HOT).count("\n")


ROBOTS = "feet: list[Robot], leg: int) -> int:\n    leg = feet[leg].rate_hz\n"
EXCHANGED = "holder.feet = holder.feet\n    holder.feet[leg] +="


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("robot.arm.length", "robot.arm.lenght", r"shared/one.py:58: Leg has no field lenght"),
        ("robot: Robot, feet", "robot, feet", r"what is robot\? .legs is a field of a record: annotate robot"),
        ("f(holder, mine, feet, leg)", "f(holder, limb, feet, leg)", r"shared/one.py:60: limb is a part of a block"),
        ("feet: Ints, leg: int) -> int:\n", ROBOTS, r"feet\[leg\] is read through a name"),
        ("limb.length +=", EXCHANGED, r"59: holder.feet may be another one later"),
        ('    """Do."""\n', "    if leg:\n        leg = 1\n", "54: a hot function that begins with a block"),
        ("    mine = holder.robot\n", "    mine = holder.robot\n    mine = robot\n", r"one name for one record"),
    ],
)
def test_what_cannot_be_built_is_named_with_its_line(tmp_path, old, new, complaint):
    assert old in HOT
    with pytest.raises(BuildError, match=complaint):
        lower(modules(tmp_path, HOT.replace(old, new)))


@pytest.mark.parametrize(
    ("given", "complaint"),
    [("3", "a record holds lines"), ('field("the size")', "a field has a unit and a meaning, a part a meaning")],
)
def test_a_record_declares_fields_and_nothing_else(tmp_path, given, complaint):
    text = f'\n\n@record\nclass Odd:\n    """Odd."""\n\n    size: int = {given}\n'
    with pytest.raises(BuildError, match=rf"shared/one.py:\d+: {complaint}"):
        lower(modules(tmp_path, HOT + text))


def test_axes_are_single_integers(tmp_path):
    text = '\n\n@record\nclass Odd(Axes):\n    """Odd."""\n\n    feet: Ints = vector(3, "lu", "each")\n'
    with pytest.raises(BuildError, match=r"shared/one.py:\d+: Odd is an Axes: it has single integers only"):
        lower(modules(tmp_path, HOT + text))


def test_viper_gets_pointers(tmp_path):
    made = lower(modules(tmp_path, HOT.replace("    return f(holder, mine, feet, leg)\n", "    return 0\n")))
    text = rewrite(made["shared.one"], made, "viper", "armv7emsp").decode()
    assert "@micropython.viper\ndef f(holder, robot: ptr32, feet: ptr32, leg: int) -> int:\n" in text
    assert "\n    out = ptr32(holder.feet)\n" in text
    assert "\n    robot[limb] += robot[leg + 11] * robot[17]\n" in text


def test_integers_go_in_and_out_in_the_order_of_the_declaration():
    params = Params()
    integers = list(range(len(pack(params))))
    unpack(params, integers)
    assert pack(params) == integers
    assert params.rate_hz == 0
    first = [params.legs[leg].hip_length for leg in range(LEGS)]
    assert first == sorted(set(first))
    other = Params()
    copy(params, other)
    params.legs[2].rest[1] = -5
    assert pack(other) == integers


def test_what_is_sensed_goes_in_and_out_in_the_order_of_a_recording():
    sensed, integers = Sensed(), list(range(20))
    sensed.unpack(integers)
    assert sensed.pack() == integers
    assert (sensed.tilt, sensed.joints, pack(sensed.turned)) == ([0, 1], integers[3:15], [16, 17, 18])
    assert (sensed.valid.tilt, sensed.valid.joints, sensed.valid.turned) == (2, 15, 19)


def test_axes_are_one_thing_by_name_and_by_number():
    pose = Pose()
    for axis in range(POSE_AXES):
        pose[axis] = 10 * axis
    pose.pitch += 1
    assert pack(pose) == list(pose) == [0, 10, 20, 30, 41, 50]
    assert pose[4] == pose.pitch == 41
    with pytest.raises(IndexError):
        pose[POSE_AXES] = 0


def test_a_wrong_number_of_integers_is_refused():
    with pytest.raises(ValueError, match="missing"):
        unpack(Pid(), [1] * 7)
    with pytest.raises(ValueError, match="1 integers too many"):
        unpack(Pid(), [1] * 9)
    with pytest.raises(AttributeError):
        Pid().kp = 3  # an object has no other names
