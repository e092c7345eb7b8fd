"""The vectors of every public function of shared/. Runs unchanged on CPython and on every MicroPython.

One file per module of shared/ or a few of them, each with its ``PROBES``. To add a function, add its Probe
there; to add a file, add its name to MODULES.
Parity, cost, allocation, overflow and the table in the docs all read these.
"""

MODULES = (
    "fixed",
    "leg",
    "legs",
    "reach",
    "body",
    "swing",
    "pid",
    "balance",
    "attitude",
    "gait",
    "command",
    "steps",
    "posture",
    "goals",
    "compliance",
    "load",
    "sensing",
    "odometry",
    "stability",
    "trot",
    "crawl",
    "planner",
    "wire_codec",
    "wire",
    "joint_parts",
    "joint",
)


def probes(module):
    """Return the probes of one module by its name."""
    return __import__("probe." + module, None, None, ("PROBES",)).PROBES
