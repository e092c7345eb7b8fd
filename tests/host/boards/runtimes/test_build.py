"""The firmware build: rules with file and line, rewriting, the same bytes every time, a tree fit to copy."""

from pathlib import Path

import pytest
from mypy import api

from host import ROOT
from host.boards.build.frozen import ROLES, frozen_sources, select
from host.boards.build.rewrite import EMITTERS, rewrite
from host.boards.build.source import BuildError, closure, read_modules
from host.boards.build.tree import compile_tree, replace_tree, write_tree
from host.boards.runtimes import Unix
from host.util.errors import UserError
from tests.marks import NEEDS_UNIX

HEAD = """from array import array

from .runtime import const, hot, ptr16, ptr32

_TWO = const(2)
TAB = array('H', [1, 2])


"""
RUNTIME = (ROOT / "shared" / "runtime.py").read_text()


def core(folder: Path, body: str, name: str = "one") -> Path:
    """Return a root whose shared/ holds the marks and one module."""
    package = folder / "shared"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "runtime.py").write_text(RUNTIME)
    (package / f"{name}.py").write_text(HEAD + body)
    return folder


def hot(*lines: str, head: str = "f(a: int, b) -> int") -> str:
    return "@hot\ndef " + head + ":\n" + "".join(f"    {line}\n" for line in lines)


SILENT = hot("a += 1", head="g(a: int) -> None") + "\n\n"
LINE = HEAD.count("\n") + 3  # of the first statement of a hot function

BROKEN = [
    (hot("return a", head="f(a: int, b=3) -> int"), LINE - 1, "without defaults"),
    (hot("return a", head="f(a: int, *b) -> int"), LINE - 1, "without defaults"),
    (hot("return a", head="f(a: float) -> int"), LINE - 1, "is annotated int"),
    (hot("return a", head="f(a: int)"), LINE - 1, "-> int, or -> None"),
    (hot("if a:", "    return a"), LINE, "on every path"),
    (hot("if a:", "    return", "return a"), LINE + 1, "on every path"),
    (hot("return a", head="f(a: int) -> None"), LINE, "return stands by itself"),
    (hot("if a:", "    return 0", "a = 1", head="f(a: int) -> None"), LINE + 1, "return stands by itself"),
    (SILENT + hot("return a + g(a)"), LINE + 5, "g has no result: call it as a statement"),
    (SILENT + hot("if g(a):", "    return 1", "return 0"), LINE + 5, "g has no result"),
    (SILENT + hot("g(int(g(a)))", "return 0"), LINE + 5, "g has no result"),
    (SILENT + hot("return g(a)", head="f(a: int) -> None"), LINE + 5, "return stands by itself"),
    (hot("return (a, 2, 3)"), LINE, "a tuple is an allocation"),
    (hot("a = [a]", "return 1"), LINE, "a list is an allocation"),
    (hot("return a / 2"), LINE, "use //"),
    (hot("return a ** 2"), LINE, "multiply"),
    (hot("return a << 32"), LINE, "shifts by 0 .. 31"),
    (hot("a >>= 40", "return a"), LINE, "shifts by 0 .. 31"),
    (hot("return a // (_TWO - 2)"), LINE, "division by zero"),
    (hot("return a + 1073741824"), LINE, "outside -2^30 .. 2^30-1"),
    (hot("return int(a * 1.5)"), LINE, "integers only"),
    (hot("return abs(a)"), LINE, "abs is not a hot function"),
    (hot("return max(a, 2)"), LINE, "max is not a hot function"),
    (hot("return f(a)"), LINE, "f takes 2 arguments, 1 given"),
    (hot("return f(a, b=b)"), LINE, "keyword arguments"),
    (hot("return b[a]"), LINE, "alias the array first"),
    (hot("return b.size"), LINE, ".size is an object"),
    (hot("p = ptr32(b)", "return f(a, p)"), LINE + 1, "hand on the array itself"),
    (hot("return a < 3"), LINE, "not a number in viper"),
    (hot("x = a and 3", "return x"), LINE, "not a number in viper"),
    (hot("if a in b:", "    return 1", "return 2"), LINE, "compare objects"),
    (hot("for x in b:", "    a += x", "return a"), LINE, "runs over range"),
    (hot("for x in range(0, 9, a):", "    a += x", "return a"), LINE, "must be a constant"),
    (hot("return 1 if a else 2"), LINE, "as an if statement"),
    (hot("def g():", "    return 1", "return a"), LINE, "closure"),
    (hot("global TAB", "return a"), LINE, "global"),
    (hot("try:", "    return a", "except ValueError:", "    return 1"), LINE, "exception"),
    (hot("x = ptr16(TAB)", "return x[0:1]"), LINE + 1, "slice"),
]


@pytest.mark.parametrize(("body", "line", "words"), BROKEN, ids=[row[2] + str(at) for at, row in enumerate(BROKEN)])
def test_a_broken_rule_is_told_with_file_and_line(tmp_path, body, line, words):
    with pytest.raises(BuildError) as error:
        compile_tree(core(tmp_path, body), "viper", "armv7emsp", ("shared",))
    assert str(error.value).startswith(f"shared/one.py:{line}: ")
    assert words in str(error.value)


def test_mypy_tells_of_a_result_that_is_none(tmp_path):
    text = "from shared.num.pid import Pid, pid_reset\n\nmore = pid_reset(Pid()) + 1\n"
    words, _, code = api.run(["--config-file=", "--follow-imports=silent", f"--cache-dir={tmp_path}", "-c", text])
    assert (code, words.count("error:")) == (1, 1)
    assert words.startswith('<string>:3: error: Unsupported operand types for + ("None" and "int")')


def test_what_only_the_compiler_sees_has_file_and_line_too(tmp_path):
    body = hot("x = 1", "x = b", "return x")
    with pytest.raises(BuildError, match=rf"shared/one\.py:{LINE + 1}: ViperTypeError"):
        compile_tree(core(tmp_path, body), "viper", "armv7emsp", ("shared",))


def test_a_syntax_error_and_a_constant_that_is_none(tmp_path):
    with pytest.raises(BuildError, match=r"shared/one\.py:\d+: "):
        read_modules(core(tmp_path / "a", "def f(:\n"), ("shared",))
    with pytest.raises(BuildError, match="const\\(\\) needs an integer"):
        read_modules(core(tmp_path / "b", "_X = const(len(TAB))\n"), ("shared",))


GOOD = hot(
    "table = ptr16(TAB)",
    "p = ptr32(b)",
    "p[0] >>= 1",
    "x = g(a) + table[1] * _TWO",
    "g(a)",
    "h(a)",
    "return p[a] - x",
) + "\n\n" + hot("return a + 1", head="g(a: int) -> int") + "\n\n" + (
    hot("if a:", "    return", "g(a)", head="h(a: int) -> None")
)

REWRITTEN = {
    ("bytecode", "any"): (
        "@hot", "table = TAB", "pass", "b[0] >>= 1", "x = g(a) + table[1] * 2", "g(a)", "h(a)", "return b[a] - x",
    ),
    ("native", "armv7emsp"): (
        "@micropython.native", "table = TAB", "pass", "b[0] >>= 1", "x = g(a) + table[1] * 2", "g(a)",
        "h(a)", "return b[a] - x",
    ),
    ("viper", "armv7emsp"): (
        "@micropython.viper", "table = ptr16(TAB)", "pass", "b[0] >>= 1", "x = int(g(a)) + table[1] * 2",
        "g(a)", "h(a)", "return b[a] - x",
    ),
    ("viper", "x64"): (
        "@micropython.viper", "table = ptr16(TAB)", "pass", "b[0] = ((b[0] << 32) >> 32) >> (1)",
        "x = int(g(a)) + table[1] * 2", "g(a)", "h(a)", "return ((b[a] << 32) >> 32) - x",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("emitter", "arch"), REWRITTEN)
def test_rewriting_keeps_every_line_in_its_place(tmp_path, emitter, arch):
    modules = read_modules(core(tmp_path, GOOD), ("shared",))
    text = rewrite(modules["shared.one"], modules, emitter, arch).decode()
    lines = [line.strip() for line in text.splitlines()[LINE - 3 : LINE + 6]]
    assert [line for line in lines if not line.startswith("def ")] == list(REWRITTEN[emitter, arch])
    assert text.count("\n") == (HEAD + GOOD).count("\n")
    assert ("def h(a: int):\n" in text) == (emitter == "viper")
    assert ("def f(a: int, b: ptr32) -> int:\n" in text) == (emitter == "viper")


@pytest.mark.parametrize("line", ["g(b)", "p = ptr32(c)", "b = c"])
def test_an_alias_stays_where_the_array_is_needed_too_or_another_takes_its_place(tmp_path, line):
    body = hot("p = ptr32(b)", line, "return p[0]", head="f(b, c) -> int")
    modules = read_modules(core(tmp_path, body + "\n\n" + hot("return 1", head="g(a) -> int")), ("shared",))
    text = rewrite(modules["shared.one"], modules, "viper", "armv7emsp").decode()
    assert "def f(b, c) -> int:\n    p = ptr32(b)\n" in text
    assert "    return p[0]\n" in text


def test_constants_of_other_modules_become_numbers(tmp_path):
    root = core(tmp_path, "FAR = const(-7)\nNEAR = const(FAR + 3)\n", "names")
    (root / "shared" / "one.py").write_text(
        "from .names import FAR, NEAR as CLOSE\nfrom .runtime import hot\n\n\n"
        "@hot\ndef f(a: int) -> int:\n    return a + FAR + CLOSE\n\n\ndef g(FAR):\n    return FAR\n"
    )
    modules = read_modules(root, ("shared",))
    text = rewrite(modules["shared.one"], modules, "viper", "armv7emsp").decode()
    assert "return a + (-7) + (-4)" in text
    assert "def g(FAR):\n    return FAR" in text


@pytest.mark.parametrize("emitter", EMITTERS)
def test_the_same_source_gives_the_same_bytes_anywhere(tmp_path, emitter):
    first = compile_tree(core(tmp_path / "a", GOOD), emitter, "armv7emsp", ("shared",))
    second = compile_tree(core(tmp_path / "a much longer path", GOOD), emitter, "armv7emsp", ("shared",))
    assert first == second
    assert str(tmp_path).encode() not in b"".join(first.values())


def test_another_source_gives_other_bytes(tmp_path):
    first = compile_tree(core(tmp_path / "a", GOOD), "viper", "armv7emsp", ("shared",))
    second = compile_tree(core(tmp_path / "b", GOOD.replace("_TWO", "3")), "viper", "armv7emsp", ("shared",))
    assert first["shared/one.mpy"] != second["shared/one.mpy"]


def test_a_tree_is_written_as_it_was_compiled(tmp_path):
    files = compile_tree(core(tmp_path / "root", GOOD), "viper", "armv7emsp", ("shared",))
    write_tree(files, tmp_path / "tree")
    found = {p.relative_to(tmp_path / "tree").as_posix(): p.read_bytes() for p in (tmp_path / "tree").rglob("*.mpy")}
    assert found == files
    assert set(files) == {"shared/__init__.mpy", "shared/one.mpy", "shared/runtime.mpy"}


@pytest.mark.parametrize("role", ROLES)
def test_a_role_brings_along_all_it_imports(role):
    modules = read_modules(ROOT)
    names = select(modules, role)
    assert names == closure(modules, names)
    assert "shared.num.fixed" in names
    assert ("shared.planner.planner" in names) == (role == "gait")
    assert ("shared.joint.current" in names) == (role == "joint")


@pytest.mark.parametrize("role", ROLES)
def test_what_is_frozen_starts_by_itself_and_holds_no_stale_module(tmp_path, role):
    replace_tree({"modules/old.py": b"a module of a former build"}, tmp_path / "frozen")
    tree = frozen_sources(role, "caramelo", tmp_path / "frozen")
    files = {path.relative_to(tree.modules).as_posix(): path.read_text() for path in tree.modules.rglob("*.py")}
    assert files["main.py"].endswith("start.settle()\nstart.run()\n")
    assert f"from firmware.start_{role} import" in files["firmware/application.py"]
    assert ("firmware/robot_params.py" in files) == (role == "gait")
    assert "firmware/main.py" not in files
    assert "old.py" not in files
    assert "@hot" not in "".join(files.values())
    assert tree.c_modules is not None
    assert "core_floor" in (tree.c_modules / "_core/core.c").read_text()


def content(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("foreign", ["thesis.txt", "a/one.py", "a/link.py"])
def test_a_build_removes_what_a_build_has_left_and_nothing_else(tmp_path, foreign):
    out = tmp_path / "out"
    replace_tree({"a/one.py": b"1", "a/two.py": b"2"}, out)
    replace_tree({"a/one.py": b"1 anew"}, out)
    assert content(out) == {"a/one.py": b"1 anew"}
    if foreign == "a/link.py":
        (out / foreign).symlink_to(out / "a/one.py")
    else:
        (out / foreign).write_bytes(b"years of work")
    before = content(tmp_path)
    with pytest.raises(UserError, match=f"{foreign}: is not as a build has left it"):
        replace_tree({"b.py": b"3"}, out)
    assert content(tmp_path) == before


def test_a_build_that_was_cut_off_is_built_over(tmp_path, monkeypatch):
    out = tmp_path / "out"
    replace_tree({"a.py": b"1", "b.py": b"1"}, out)

    def cut_off(files, out):
        (out / "a.py").write_bytes(files["a.py"])
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("host.boards.build.tree.write_tree", cut_off)
        with pytest.raises(KeyboardInterrupt):
            replace_tree({"a.py": b"2", "b.py": b"2"}, out)
    replace_tree({"a.py": b"3"}, out)
    assert content(out) == {"a.py": b"3"}


@NEEDS_UNIX
def test_pointers_are_signed_on_x64_too(tmp_path):
    runtime = Unix("viper")
    sources = core(tmp_path / "root", GOOD)
    tree = runtime.prepare(sources, tmp_path)
    script = "from array import array\nfrom shared.one import f\nb = array('i', [-9, -100])\nprint(f(1, b), b)\n"
    assert runtime.execute(tree, script) == "-106 array('i', [-5, -100])\n"


@NEEDS_UNIX
def test_a_negated_name_keeps_its_value_on_x64(tmp_path):
    body = hot("p = ptr32(b)", "x = -a", "y = -p[0] * 2", "return a * 10000 + x * 100 + y")
    sources = core(tmp_path / "root", body)
    tree = Unix("viper").prepare(sources, tmp_path)
    script = "from array import array\nfrom shared.one import f\nprint(f(7, array('i', [-3])))\n"
    assert Unix("viper").execute(tree, script) == f"{7 * 10000 - 7 * 100 + 6}\n"
