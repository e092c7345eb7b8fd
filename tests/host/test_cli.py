"""The command line itself: help, exit codes, one line for every error, whole files or none, quick to start."""

import json
import os
import pkgutil
import select
import signal
import subprocess
import sys
import tomllib
from importlib.metadata import metadata, packages_distributions, requires
from pathlib import Path

import pytest
import typer
from packaging.requirements import Requirement

from host import cli, commands
from host.robot.file import robot_names
from host.util import extras
from host.util.console import progress, write_json
from host.util.errors import UserError
from host.util.extras import EXTRA_OF
from host.util.files import atomic_path, check_folder, write_bytes, write_text
from tests import ROOT
from tests.processes import hear_signals
from tests.waiting import PATIENCE_S

CARAMELO = Path(sys.executable).parent / "caramelo"
# What no command needs before it runs; importing any of them would make every start slower.
SLOW_TO_IMPORT = {"numpy", "pydantic", "pymunk", "matplotlib", "scipy", "aiohttp", "mcap", "can", "wasmtime"}


def one_line(text):
    """Return the only line of a text, without its end."""
    assert text.endswith("\n")
    assert text.count("\n") == 1
    return text[:-1]


def test_help_teaches(run):
    code, out, err = run("--help")
    assert code == 0
    assert err == ""
    for word in ("caramelo walk", "caramelo robots", "--version", "Exit codes"):
        assert word in out


def test_no_command_shows_the_help(run):
    assert run() == run("--help")


def test_version_is_the_distributions(run):
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert run("--version")[:2] == (0, f"{version}\n")


def test_every_file_of_commands_has_its_panel():
    files = {module.name for module in pkgutil.iter_modules(commands.__path__)}
    assert {name for name in files if not name.startswith("_")} == set(commands.PANELS)
    assert set(cli.build_command().commands) == set(commands.PANELS)


def test_every_command_explains_itself_with_an_example(run):
    for path, command in walk_commands(cli.build_command(), ()):
        code, out, _ = run(*path, "--help")
        assert code == 0
        assert len(" ".join(out.split())) > 80, path
        assert command.help, path


def walk_commands(command, path):
    """Yield (words, command) of every command below a group."""
    for name, child in getattr(command, "commands", {}).items():
        yield (*path, name), child
        yield from walk_commands(child, (*path, name))


def test_start_imports_nothing_slow():
    code = "import sys; from host import cli; cli.build_command(); print(' '.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout
    assert {name.partition(".")[0] for name in loaded.split()} & SLOW_TO_IMPORT == set()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("robts",), "Did you mean 'robots'? (see caramelo --help)"),
        (("--colour",), "No such option: --colour"),
        (("robots", "show"), "Missing argument 'ROBOT' (see caramelo robots show --help)"),
        (("robots", "show", "caramelo", "--jsn"), "--json"),
        (("robots", "show", "a", "b"), "unexpected extra argument"),
        (("robots", "show", "caramell"), "did you mean caramelo?"),
        (("robots", "check", "missing.toml"), "missing.toml: no such file"),
    ],
)
def test_wrong_use_is_one_line_and_exit_code_2(refused, arguments, words):
    line = refused(*arguments)
    assert line.startswith("caramelo: ")
    assert words in line


def test_installed_command_passes_the_exit_code_on():
    done = subprocess.run([CARAMELO, "robots", "show", "nobody"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert one_line(done.stderr).startswith("caramelo: robot \"nobody\"")


def test_robots_lists_all(run, run_json):
    code, out, _ = run("robots")
    assert code == 0
    assert "caramelo" in out
    assert "parallel" in out
    assert [robot["name"] for robot in run_json("robots")[1]["robots"]] == robot_names()


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_robots_show_gives_everything_as_json(run, run_json, name):
    code, shown, _ = run_json("robots", "show", name)
    assert (code, shown["name"]) == (0, name)
    assert shown["geometry"]["thigh_m"] > 0
    assert shown["derived"]["length_unit_m"] == 2.0 ** (-17 if name == "caramelo" else -16)
    for word in ("mass", "joint limits", "length unit"):
        assert word in run("robots", "show", name)[1]


def test_robots_check_says_yes_or_why_not(run, run_json, tmp_path):
    path = tmp_path / "my.toml"
    path.write_text((ROOT / "host/robot/files/caramelo.toml").read_text())
    code, out, _ = run("robots", "check", str(path))
    assert code == 0
    assert out.startswith(f'{path}: ok: "caramelo", 2.204 kg\n')
    found = run_json("robots", "check", str(path))[1]
    assert (found["ok"], found["lacks"]) == (True, [])
    assert f"sags {1000 * found['ability']['sag_m']:.1f} mm" in out
    path.write_text("name = 3")
    code, answer, err = run_json("robots", "check", str(path))
    assert (code, answer["ok"]) == (2, False)
    assert err == f"caramelo: {answer['reason']}\n"


def test_robots_check_tells_what_a_robot_can_not_carry_and_which_key_to_change(run, run_json, tmp_path):
    """Its servos give 2.5 N m, of which a calf that carries half of the robot takes 40 %; with 0.9 N m it is 112 %."""
    path = tmp_path / "weak.toml"
    text = (ROOT / "host/robot/files/caramelo.toml").read_text()
    path.write_text(text.replace("stall_Nm = 2.5 ", "stall_Nm = 0.9 ").replace("stall_Nm = 2.3 ", "stall_Nm = 0.8 "))
    code, out, _ = run("robots", "check", str(path))
    assert code == 1
    assert out.startswith(f"{path}: can't walk: ")
    last = out.splitlines()[-1]
    for words in ("standing on two legs", "the calf needs 1.1 times", "actuator.supply.stall_Nm", "trunk.mass_kg"):
        assert words in last
    code, found, _ = run_json("robots", "check", str(path))
    assert (code, found["ok"], found["lacks"]) == (1, False, [last])


def app_that_raises(error):
    """Return a build_command whose only command raises."""

    def build():
        app = typer.Typer(pretty_exceptions_enable=False)

        @app.command()
        def fail():
            raise error

        return typer.main.get_command(app)

    return build


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (UserError("two\n lines", 1), 1, "caramelo: two lines"),
        (KeyboardInterrupt(), 130, "caramelo: stopped by Ctrl-C"),
        (ModuleNotFoundError("no", name="pymunk.batch"), 2, "caramelo: this needs pymunk, which is not installed: "
         "run make setup EXTRAS=sim in the project's folder"),
    ],
)  # fmt: skip
def test_errors_become_a_line_and_an_exit_code(run, monkeypatch, error, code, line):
    monkeypatch.setattr(cli, "build_command", app_that_raises(error))
    assert run() == (code, "", line + "\n")


@pytest.mark.parametrize("error", [ModuleNotFoundError("no", name="hostt"), ZeroDivisionError("bug")])
def test_a_mistake_of_ours_keeps_its_traceback(monkeypatch, error):
    monkeypatch.setattr(cli, "build_command", app_that_raises(error))
    with pytest.raises(type(error)):
        cli.main([])


@pytest.mark.parametrize(("number", "code", "words"), [
    (signal.SIGINT, 130, "Ctrl-C"), (signal.SIGTERM, 143, "SIGTERM"), (signal.SIGHUP, 129, "SIGHUP"),
])  # fmt: skip
def test_what_ends_a_command_leaves_no_file(tmp_path, number, code, words):
    script = (
        "import sys, time; from pathlib import Path; import typer\n"
        "from host import cli; from host.util import files\n"
        "app = typer.Typer(pretty_exceptions_enable=False)\n"
        "@app.command()\n"
        "def slow(path: Path):\n"
        "    with files.atomic_path(path) as draft, draft.open('w') as file:\n"
        "        file.write('half'); file.flush(); print('ready', flush=True)\n"
        "        while True: time.sleep(0.01)\n"  # one wait could begin just after the signal has come
        "cli.build_command = lambda: typer.main.get_command(app)\n"
        "sys.exit(cli.main())"
    )
    target = tmp_path / "result.html"
    target.write_text("old")
    process = subprocess.Popen(
        [sys.executable, "-c", script, str(target)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        preexec_fn=hear_signals,
    )
    assert process.stdout.readline() == "ready\n"
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code
    assert err == f"caramelo: stopped by {words}\n"
    assert os.listdir(tmp_path) == ["result.html"]
    assert target.read_text() == "old"


def test_a_signal_that_is_ignored_stays_so(run):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert run("--version")[0] == 0
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["robots"], ["robots", "--json"], ["--help"], ["--version"]])
def test_an_output_that_takes_nothing_is_told_in_a_line(arguments, unbuffered):
    around = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    command = [sys.executable, "-m", "caramelo", *arguments]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, env=around, cwd=ROOT)
    assert done.returncode == 1
    assert "the output can't be written: No space left on device" in one_line(done.stderr)


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_stream_that_came_closed_costs_no_result(tmp_path, closed):
    """Each None in sys ended a command in a traceback: stdout with all of them, stderr where one shows progress."""
    shell = f'exec "$0" -m caramelo walk --distance 0.05 --out "$1" {closed}'
    ran = subprocess.run(["sh", "-c", shell, sys.executable, tmp_path], capture_output=True, text=True, cwd=ROOT)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert (tmp_path / "walk.json").exists()


def test_what_the_system_refuses_is_a_line(run, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device", "/tmp/x")

    monkeypatch.setattr("host.robot.file.robot_names", full)
    assert run("robots") == (1, "", "caramelo: /tmp/x: the system refused: No space left on device\n")


def test_ctrl_c_while_the_command_is_imported_is_a_line():
    script = (
        "import sys; from host.__main__ import main\n"
        "class Stop:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'typer': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Stop())\n"
        "sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr) == (130, "caramelo: stopped by Ctrl-C\n")


@pytest.mark.parametrize("command", [["walk"], ["experiment", "table1"], ["motor", "sim"]])
def test_a_folder_that_cannot_be_written_is_refused_before_the_work(refused, tmp_path, command):
    (tmp_path / "file").write_text("mine")
    line = refused(*command, "--out", str(tmp_path / "file/sub"))
    assert line == f"caramelo: --out {tmp_path}/file/sub: {tmp_path}/file is a file: name a folder\n"
    assert (tmp_path / "file").read_text() == "mine"


def test_a_folder_that_can_be_made_is_not_made_yet(tmp_path):
    check_folder("--out", tmp_path / "a/b")
    check_folder("--out", None)
    assert list(tmp_path.iterdir()) == []


def test_files_are_written_whole_into_new_folders(tmp_path):
    write_text(tmp_path / "a/b/c.txt", "Straße")
    write_bytes(tmp_path / "a/b/c.bin", b"\0")
    with atomic_path(tmp_path / "a/b/c.png") as draft:
        assert draft.suffix == ".png"
        assert not (tmp_path / "a/b/c.png").exists()
        draft.write_bytes(b"png")
    assert sorted(os.listdir(tmp_path / "a/b")) == ["c.bin", "c.png", "c.txt"]
    assert (tmp_path / "a/b/c.txt").read_text(encoding="utf-8") == "Straße"


def test_a_file_where_a_folder_belongs_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="can't be written"):
        write_text(tmp_path / "file/below.txt", "x")
    (tmp_path / "folder").mkdir()
    with pytest.raises(UserError, match="can't be written: it is a folder or a device"):
        write_text(tmp_path / "folder", "x")
    with pytest.raises(UserError, match=r"\.: names no file to write"):
        write_text(Path(""), "x")
    assert sorted(os.listdir(tmp_path)) == ["file", "folder"]


def test_json_is_one_object_without_nan(capsys):
    write_json({"text": "ü\n", "number": 1.5})
    assert json.loads(one_line(capsys.readouterr().out)) == {"text": "ü\n", "number": 1.5}
    with pytest.raises(ValueError, match="JSON"):
        write_json({"number": float("nan")})
    assert capsys.readouterr().out == ""


def test_progress_is_silent_without_a_terminal(capsys):
    with progress("walking", 10) as tell:
        tell(5)
    assert capsys.readouterr() == ("", "")


def test_progress_shows_a_bar_on_a_terminal():
    if not hasattr(os, "openpty"):
        pytest.skip("this system has no pseudo-terminals")
    master, slave = os.openpty()
    code = "import sys; from host.util.console import progress\nwith progress('walking', 2) as tell: sys.stdin.read()"
    command, pipe = [sys.executable, "-c", code], subprocess.PIPE
    process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=slave, cwd=ROOT)
    os.close(slave)
    shown = b""
    while b"walking" not in shown:
        assert select.select([master], [], [], PATIENCE_S)[0], "nothing is shown"
        shown += os.read(master, 4096)
    out, _ = process.communicate(timeout=PATIENCE_S)
    os.close(master)
    assert out == b""


def test_a_missing_extra_is_told_by_make_in_a_checkout_and_by_pip_elsewhere(monkeypatch, tmp_path):
    assert extras.how_to_get("pymunk") == "run make setup EXTRAS=sim in the project's folder"
    monkeypatch.setattr(extras, "ROOT", tmp_path)
    assert extras.how_to_get("pymunk").startswith("run pip install 'caramelo-robot[sim]'")
    assert "make" not in str(extras.missing_library(ModuleNotFoundError("no", name="aiohttp")))


def test_every_library_is_assigned_to_the_extra_that_installs_it():
    wanted_by = {}
    for line in requires("caramelo-robot"):
        wanted = Requirement(line)
        for extra in metadata("caramelo-robot").get_all("Provides-Extra"):
            if wanted.marker and f'extra == "{extra}"' in str(wanted.marker):
                wanted_by.setdefault(wanted.name.lower().replace("-", "_"), extra)
    distributions = packages_distributions()
    for library, extra in EXTRA_OF.items():
        names = [name.lower().replace("-", "_") for name in distributions.get(library, [library])]
        assert extra in [wanted_by.get(name) for name in names], library
