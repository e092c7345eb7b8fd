"""What the unix VM runs to be a board: a simulated flash in a file, a machine module, a slot's modules, the prompt.

Runs on MicroPython. The loader has chosen the slot before: pretend.py. Power is cut by SIGKILL in the
middle of a word written or a sector erased, a reset is SIGTERM. Standard input and output are its USB.
"""

import json
import os
import select
import sys
import time

with open("board.json") as _file:
    SETTINGS = json.load(_file)
HOST = os.getcwd()
sys.path[:] = ["", HOST + "/running", SETTINGS["tests"]]

sim_flash = __import__("sim_flash")  # found only now, as are the slot's modules
flash_map = __import__("firmware.flash_map").flash_map


def die(signal):
    """End this process; its parent knows by the signal whether power was cut."""
    os.system("kill -" + signal + " $PPID")
    while True:
        pass


class Usb:
    """USB as MicroPython serves it: a byte that interrupts, Ctrl-C at first, and all others."""

    interrupt = 3
    came = select.poll()
    deaf = select.poll()

    @staticmethod
    def setinterrupt(byte):
        Usb.interrupt = byte

    @staticmethod
    def readinto(data):
        """Read what has come; None if nothing has, as the port does."""
        count = 0
        while count < len(data) and Usb.came.poll(0):
            data[count] = Usb._read()
            count += 1
        return count or None

    @staticmethod
    def write(buffer):
        return len(buffer)

    @staticmethod
    def look(wait_ms=0):
        """Wait so long, or for the byte that interrupts, if there is one; what comes before it is lost."""
        line = Usb.came if Usb.interrupt >= 0 else Usb.deaf
        end = time.ticks_add(time.ticks_ms(), wait_ms)
        while line.poll(max(0, time.ticks_diff(end, time.ticks_ms()))):
            Usb._read()

    @staticmethod
    def _read():
        byte = sys.stdin.buffer.read(1)[0]
        if byte == Usb.interrupt:
            raise KeyboardInterrupt
        return byte


Usb.came.register(sys.stdin, select.POLLIN)


class Time:
    """The time module; the board can be interrupted as it sleeps."""


for _name in dir(time):
    setattr(Time, _name, getattr(time, _name))
Time.sleep_ms = Usb.look


class File:
    """A store of bytes that survives the power."""

    def __init__(self, path):
        self.file = open(path, "r+b")  # noqa: SIM115

    def read(self, at, count):
        """Return bytes."""
        self.file.seek(at)
        return self.file.read(count)

    def write(self, at, data):
        """Take bytes as they are, also if the process is killed a moment later."""
        Usb.look()
        self.file.seek(at)
        self.file.write(data)
        self.file.flush()


class ChipFlash(sim_flash.SimFlash):
    """Stands for the flash controller's."""

    def __init__(self):
        super().__init__(File("flash.bin"), SETTINGS["cut"], SETTINGS["cut"])

    def _gone(self):
        die("KILL")


class FlashModule:
    """Stands for firmware/chip_flash.py."""

    @staticmethod
    def ChipFlash():
        return flash


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


class Board:
    """Stands in for the pyb module."""

    @staticmethod
    def USB_VCP():
        return Usb


class Vectors:
    """Stands for the processor's register of where its vectors are: where the loader left them."""

    def __getitem__(self, address):
        assert address == 0xE000ED08
        return flash_map.BASE + flash_map.slot_at(SETTINGS["slot"]) + flash_map.HEADER


class Machine:
    """Stands in for the machine module."""

    WDT = Watchdog
    I2C = SilentBus
    mem32 = Vectors()

    @staticmethod
    def reset():
        with open(HOST + "/writes", "a") as file:
            file.write(str(flash.done) + "\n")
        die("TERM")


flash = ChipFlash()
sys.modules["firmware.chip_flash"] = FlashModule
sys.modules["machine"] = Machine
sys.modules["pyb"] = Board
sys.modules["time"] = Time
print("pretend board")
try:
    __import__("main")  # runs the application
except Exception as error:
    sys.print_exception(error)
except KeyboardInterrupt:
    print("interrupted")
