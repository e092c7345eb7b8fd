"""The long life of a joint among the vectors: it comes to drive in every mode, in as many ticks as parity takes."""

from host.boards.runtimes import CPython
from host.lab.parity.sources import gather
from shared.wire import names as w

TICKS = 2000  # of `caramelo parity` as it is called without options
DRIVES = (w.MODE_POSITION, w.MODE_VELOCITY, w.MODE_CURRENT, w.MODE_IMPEDANCE, w.MODE_COMMISSIONING, w.MODE_HOMING)
SCRIPT = """
from probe import joint, joint_robot
life = [probe for probe in joint.PROBES if probe.name == "motion_tick:life"][0]
life.start()
modes = []
for index in range(TICKS):
    life.draw(index, TICKS)
    life.call()
    if joint_robot.STATE.drive_state == ENABLED and joint_robot.STATE.mode not in modes:
        modes.append(joint_robot.STATE.mode)
print("@@" + str(modes))
""".replace("TICKS", str(TICKS)).replace("ENABLED", str(w.STATE_OPERATION_ENABLED))


def test_it_drives_in_every_mode(tmp_path):
    """Its two encoders disagreed from its first turn on: it faulted in the tick in which it began to drive."""
    runtime = CPython()
    modes = runtime.ask(runtime.prepare(gather(tmp_path), tmp_path), SCRIPT)
    assert set(modes) >= set(DRIVES)
