"""What the unix VM runs to be a board: LittleFS on a file of blocks, a machine module, boot.py, main.py, the prompt.

Runs on MicroPython. Power is cut by SIGKILL in the middle of a block write, a reset is SIGTERM: tests/flash/pretend.py.
"""

import json
import os
import sys

import vfs

with open("board.json") as _file:
    SETTINGS = json.load(_file)


def die(signal):
    """End this process; its parent knows by the signal whether power was cut."""
    os.system("kill -" + signal + " $PPID")
    while True:
        pass


class Blocks:
    """A block device in a file. ``cut`` counts down the block writes until the power goes in the middle of one."""

    def __init__(self, path, size, cut):
        self.file = open(path, "r+b")  # noqa: SIM115
        self.size = size
        self.count = self.file.seek(0, 2) // size
        self.cut = cut
        self.writes = 0

    def readblocks(self, block, buffer, offset=0):
        self.file.seek(block * self.size + offset)
        self.file.readinto(buffer)

    def writeblocks(self, block, buffer, offset=0):
        self.file.seek(block * self.size + offset)
        self._spend(buffer)
        self.file.write(buffer)

    def ioctl(self, operation, block):
        if operation == 4:
            return self.count
        if operation == 5:
            return self.size
        if operation == 6:
            self.file.seek(block * self.size)
            self._spend(b"\xff" * self.size)
            self.file.write(b"\xff" * self.size)
            return 0
        return None

    def _spend(self, data):
        self.writes += 1
        if self.writes == self.cut:
            self.file.write(bytes(data)[: len(data) // 2])
            die("KILL")


class Watchdog:
    """Resets the board when it is not fed: the parent looks at the file."""

    def __init__(self, timeout):
        self.timeout = timeout
        self.feed()

    def feed(self):
        with open(HOST + "/watchdog", "w") as file:
            file.write(str(self.timeout))


class SilentBus:
    """An I2C bus with nothing on it."""

    def __init__(self, number, freq):
        self.number = number

    def readfrom_mem(self, address, register, count):
        raise OSError(19)

    def readfrom_mem_into(self, address, register, buffer):
        raise OSError(19)


class Usb:
    """USB with nobody at the other end."""

    def setinterrupt(self, byte):
        self.byte = byte

    def any(self):
        return False

    def write(self, buffer):
        return len(buffer)


class Board:
    """Stands in for the pyb module."""

    USB_VCP = Usb


class Machine:
    """Stands in for the machine module."""

    WDT = Watchdog
    I2C = SilentBus

    @staticmethod
    def reset():
        with open(HOST + "/writes", "a") as file:
            file.write(str(device.writes) + "\n")
        die("TERM")


class System:
    """Stands in for sys where a test wants another _mpy."""

    def __init__(self):
        for name in dir(sys):
            if name[:2] != "__":
                setattr(self, name, getattr(sys, name))
        self.implementation = Implementation()


REAL = sys.implementation


class Implementation:
    """sys.implementation with another _mpy."""

    _mpy = SETTINGS["mpy"]
    _machine = "pretend board"

    def __getitem__(self, index):
        return REAL[index]


HOST = os.getcwd()
device = Blocks("flash.bin", SETTINGS["block"], SETTINGS["cut"])
KIND = {"lfs": vfs.VfsLfs2, "fat": vfs.VfsFat}[SETTINGS["filesystem"]]
if SETTINGS["fresh"]:
    KIND.mkfs(device)
    device.writes = 0
filesystem = KIND(device)
vfs.mount(filesystem, "/flash")
os.chdir("/flash")
sys.path[:] = ["", "/flash"]
sys.modules["machine"] = Machine
sys.modules["pyb"] = Board
if SETTINGS["mpy"]:
    sys.modules["sys"] = System()
os.system("stty isig")
print("pretend board")
for _name in ("boot.py", "main.py"):
    if _name in os.listdir():
        with open(_name) as _file:
            _text = _file.read()
        try:
            exec(_text, {"__name__": "__main__"})
        except Exception as error:
            sys.print_exception(error)
        except KeyboardInterrupt:
            print("interrupted")
