"""Small firmware for pretend boards: the project's slots, boot and main, and an application that says its name."""

import shutil
from pathlib import Path

from host.build.image import build_image
from host.build.source import ROOT

APPLICATION = '''"""Application of a test."""

from shared.common import NAME

WATCHDOG = False
VERSION = "{version}"
PROTOCOL = None
ROLE = "gait"


def motor_supply_mV():
    return {supply}


def start():
    import time

    print("running", VERSION)
    {body}
    while True:
        time.sleep_ms(5)
'''


def tree(
    folder, version="1", supply=0, body="pass", self_test="return ''", extra=3, application=APPLICATION, common="same"
):
    """Write sources of a firmware; ``extra`` modules of some kilobytes differ in every version."""
    root = Path(folder)
    shutil.rmtree(root, ignore_errors=True)
    (root / "firmware").mkdir(parents=True)
    (root / "shared").mkdir()
    for name in ("boot.py", "main.py", "slots.py"):
        text = (ROOT / "firmware" / name).read_text().replace("START_DELAY_MS = 500", "START_DELAY_MS = 5")
        (root / "firmware" / name).write_text(text)
    (root / "firmware/__init__.py").write_text('"""Test."""\n')
    (root / "shared/__init__.py").write_text('"""Test."""\n')
    (root / "shared/common.py").write_text(f'NAME = "{common}"\n')
    (root / "firmware/selftest.py").write_text(f"def self_test():\n    {self_test}\n")
    (root / "firmware/gait_app.py").write_text(application.format(version=version, supply=supply, body=body))
    for number in range(extra):
        (root / f"shared/extra{number}.py").write_text(f"DATA = {version * 3000!r}\n")
    imports = "".join(f"import shared.extra{number}\n" for number in range(extra))
    (root / "firmware/gait.py").write_text(imports + "import shared.common\n")
    return root


def image_of(root):
    """Return how to build a test's firmware: what Wish.image wants."""

    def build(emitter, arch):
        text = (Path(root) / "firmware/gait_app.py").read_text()
        generated = {"firmware/application.py": "from firmware.gait_app import *\n" if text else ""}
        return build_image(Path(root), "gait", emitter, arch, ("shared", "firmware"), generated)

    return build
