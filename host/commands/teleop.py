"""`caramelo teleop`: drives a robot from keyboard, gamepad, web page or script."""

import signal
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import typer

from ..util.console import say, screen, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Honest, RobotName

# Seconds after letting go of the joints at which the system ends the program: anything that still runs then hangs on
# a disk, a pipe or a terminal.
END_MOST_S = 15


def teleop(
    robot: RobotName = "caramelo",
    gait: Annotated[str | None, typer.Option(help="A gait's name or file (default: the robot file's).")] = None,
    sim: Annotated[bool, typer.Option("--sim", help="Drive emulated servos on a simulated robot.")] = False,
    where: Annotated[str | None, typer.Option("--in", metavar="WORLD", help="With --sim: plane, or space.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve the page for phones and browsers.")] = False,
    listen: Annotated[str, typer.Option(metavar="ADDR", help="Address, or address:port.")] = "127.0.0.1:8080",
    foxglove: Annotated[bool, typer.Option("--foxglove", help="Serve Foxglove on the address of --listen.")] = False,
    foxglove_port: Annotated[int, typer.Option(metavar="PORT", min=1, max=65535, help="Where.")] = 8765,
    log: Annotated[Path | None, typer.Option(metavar="FILE", help="Record to an MCAP file, or into a folder.")] = None,
    keep: Annotated[float | None, typer.Option(metavar="GB", help="Delete the oldest records above this size.")] = None,
    gamepad: Annotated[str | None, typer.Option(metavar="DEVICE", help="auto, or /dev/input/eventN.")] = None,
    socket: Annotated[str | None, typer.Option(metavar="WHERE", help="Unix socket or local port for scripts.")] = None,
    port: Annotated[str | None, typer.Option(help="Serial port, or INTERFACE:CHANNEL of CAN.")] = None,
    imu: Annotated[str | None, typer.Option(metavar="WHERE", help="i2c, a gait board's port, or a recording.")] = None,
    calibration: Annotated[Path | None, typer.Option(metavar="FILE", help="Default: the robot's own.")] = None,
    headless: Annotated[bool, typer.Option("--headless", help="No keyboard and no screen, for a service.")] = False,
    honest: Honest = None,
    direct: Annotated[bool, typer.Option("--direct", help="With --sim: no servo bus in between.")] = False,
    measure: Annotated[float | None, typer.Option(metavar="S", help="Drive by itself, then print the figures.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Headless; print one JSON object at the end.")] = False,
) -> int:
    """Drive the robot: keyboard in the terminal, gamepad, web page, script; an emergency stop works from each.

    First the command prints its checks in order. Then the screen shows the state, why the robot does not move, and the
    keys. Ctrl-C makes the robot sit down and ends the command. Exit code 1 if a check fails, or if --measure missed a
    deadline or met a fault. A simulated robot walks in space where MuJoCo is installed, else in the plane.

    Examples: caramelo teleop --sim; caramelo teleop --sim --web; caramelo teleop --web --listen 0.0.0.0 --log logs/;
    caramelo teleop --sim --measure 30 --json
    """
    from ..robot.file import find, load_robot
    from ..robot.gait_file import with_gait
    from ..teleop.session import Options, Session
    from ._hardware import hardware, kind_of_hardware

    _check(measure, direct, sim, keep, log)
    quiet = headless or as_json or measure is not None
    if not quiet and not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UserError("no terminal for the keyboard: add --headless, with --web, --foxglove, --gamepad or --socket")
    if honest is not None and not sim:
        raise UserError(f"--{'honest' if honest else 'simple'}: only with --sim")
    loaded = with_gait(load_robot(robot).simulated(honest), gait)
    parts = hardware(
        loaded, kind_of_hardware(loaded, sim, direct), port, calibration, str(find(robot)), imu, _in_space(where, sim)
    )
    options = Options(
        robot=robot,
        web=web,
        listen=listen,
        foxglove=foxglove,
        foxglove_port=foxglove_port,
        log=log,
        keep_GB=keep,
        socket=socket,
        gamepad=gamepad,
        measure_s=measure,
        terminal=not quiet,
    )
    told = (lambda line: None) if as_json else say  # with --json only the result is printed
    session = Session(options, loaded, parts, told, lambda: signal.alarm(END_MOST_S))
    try:
        figures = session.run()
        if as_json:
            write_json(figures)
        else:
            _show(figures)
    finally:
        signal.alarm(0)
    failed = measure is not None and (figures["missed"] or figures["failure"])
    return NOT_ACHIEVED if failed else 0


def _check(measure: float | None, direct: bool, sim: bool, keep: float | None, log: Path | None) -> None:
    if measure is not None and not 1 <= measure <= 3600:
        raise UserError(f"--measure {measure:g}: allowed 1 .. 3600 s")
    if direct and not sim:
        raise UserError("--direct: only with --sim")
    if keep is not None and not 0.01 <= keep <= 100_000:
        raise UserError(f"--keep {keep:g}: allowed 0.01 .. 100000 GB")
    if keep is not None and log is None:
        raise UserError(f"--keep {keep:g}: only with --log FOLDER")


def _in_space(where: str | None, sim: bool) -> bool:
    """Return whether the simulation has three dimensions: as --in says, else if MuJoCo is installed."""
    if where not in (None, "space", "plane"):
        raise UserError(f"--in {where}: allowed: space, plane")
    if where is not None and not sim:
        raise UserError(f"--in {where}: only with --sim")
    return sim and (where == "space" or (where is None and find_spec("mujoco") is not None))


def _show(figures: dict[str, Any]) -> None:
    console = screen()
    late, busy = figures["late_ms"], figures["busy_ms"]
    console.print(f"{figures['rate_hz']} Hz: {figures['ticks']} ticks, {figures['missed']} missed their deadline")
    console.print(
        f"late  {late['p50']:.2f} ms median, {late['p99']:.2f} at the 99th percentile, {late['max']:.2f} at most"
    )
    console.print(
        f"busy  {busy['p50']:.2f} ms median, {busy['p99']:.2f} at the 99th percentile, {busy['max']:.2f} at most"
    )
    if "loop_cpu_share" in figures:
        page = f", the page's process {100 * figures['page_cpu_share']:.1f} %" if figures["page_cpu_share"] else ""
        console.print(f"{100 * figures['loop_cpu_share']:.1f} % of one core{page}")
    for source, stops in figures["stop_to_packet_ms"].items():
        console.print(f"stop by {source}: torque off after {stops['max']:.1f} ms at most ({stops['count']})")
    if figures.get("failure"):
        console.print(f"not achieved: {figures['failure']}", soft_wrap=True)
    if figures.get("log"):
        console.print(f"wrote {figures['log']}", soft_wrap=True)
    if figures["left_behind"]:
        console.print(f"did not end in time, left behind: {', '.join(figures['left_behind'])}")
    if figures.get("log_trouble"):
        console.print(figures["log_trouble"], soft_wrap=True)
