"""The process as a shell meets it: closed and full descriptors, encodings, limits, signals."""

from __future__ import annotations

import codecs
import importlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from skincad import __main__ as process
from skincad.base import ExhaustedError, FaultError, InputError, RefusedError, listen, replaced, safe_point
from skincad.outputs import ready, write_new
from tests.conftest import run_skincad
from tests.processes import python, started

# no library that takes long to load: advice is sought with scipy
CHECK = "check plain-ridges --tier winkler --no-advice"
FAILS = f"{CHECK} --force 1"
SKINCAD = f"{sys.executable} -m skincad"


def shell(line: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line in bash, as a user writes it."""
    return subprocess.run(
        ["bash", "-c", f"set -o pipefail; {line}"],
        cwd=cwd, env={**os.environ, **environment}, capture_output=True, check=False, timeout=300,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "status"),
    [("templates <&- >&- 2>&-", 0), ("templates 2>&-", 0), (f"{FAILS} >&-", 1), ("new x.pdf 2>&-", 2)],
)
def test_closed_descriptors_change_no_status(line: str, status: int, tmp_path: Path) -> None:
    done = shell(f"{SKINCAD} {line}", tmp_path)
    assert (done.returncode, done.stderr) == (status, b"")
    assert bool(done.stdout) == (line == "templates 2>&-")


@pytest.mark.slow
def test_a_file_never_takes_the_place_of_a_closed_descriptor(tmp_path: Path) -> None:
    """The files are written, and what is printed to the closed stdout goes into none of them."""
    assert shell(f"{SKINCAD} new open/mine.toml", tmp_path).returncode == 0
    assert shell(f"{SKINCAD} new closed/mine.toml <&- >&- 2>&-", tmp_path).returncode == 0
    for path in (tmp_path / "open").iterdir():
        assert path.read_bytes() == (tmp_path / "closed" / path.name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "status", "buffered"),
    [("templates", 0, ""), (FAILS, 1, "1"), ("templates", 0, "1"), ("--help", 0, "1")],
)
def test_a_reader_who_has_had_enough_changes_no_status(
    command: str, status: int, buffered: str, tmp_path: Path
) -> None:
    done = shell(f"{SKINCAD} {command} | true", tmp_path, PYTHONUNBUFFERED=buffered)
    assert (done.returncode, done.stderr) == (status, b"")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@pytest.mark.parametrize(
    ("command", "buffered"), [("templates", "1"), (f"{CHECK} --json", ""), ("--help", "")]
)
def test_a_result_that_cannot_be_written_has_status_3(command: str, buffered: str, tmp_path: Path) -> None:
    done = shell(f"{SKINCAD} {command} >/dev/full", tmp_path, PYTHONUNBUFFERED=buffered)
    assert done.returncode == 3
    assert done.stderr.startswith(b"skincad: out of space on the disk")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_message_that_cannot_be_written_changes_no_status(tmp_path: Path) -> None:
    assert shell(f"{SKINCAD} new x.pdf 2>/dev/full", tmp_path).returncode == 2


ENCODINGS = {
    "latin-1": {"PYTHONIOENCODING": "latin-1"},
    "strict": {"PYTHONIOENCODING": "ascii:strict"},
    "C": {"LC_ALL": "C"},
    "POSIX alone": {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_nothing_fails_for_what_a_stream_cannot_show(encoding: str, tmp_path: Path) -> None:
    """A name that the terminal's encoding lacks is escaped, in the result and in a message."""
    settings = ENCODINGS[encoding]
    done = shell(f"{SKINCAD} new é日.toml", tmp_path, **settings)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(b"\n") == 2
    assert (tmp_path / "é日.toml").is_file()
    done = shell(f"{SKINCAD} new é日.toml", tmp_path, **settings)
    assert done.returncode == 2
    assert done.stderr.startswith(b"skincad: ")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize(("encoding", "sign"), [("ascii", b"+-"), ("latin-1", b"\xb1")])
def test_an_error_has_a_plus_minus_sign_where_the_encoding_has_one(
    encoding: str, sign: bytes, tmp_path: Path
) -> None:
    done = shell(f"{SKINCAD} {CHECK}", tmp_path, PYTHONIOENCODING=encoding)
    assert b" " + sign + b" " in done.stdout
    assert b"\\x" not in done.stdout


def test_signs_in_a_row_are_each_replaced() -> None:
    codecs.register_error("escape", process.escaped)
    assert "é±±日±".encode("ascii", "escape") == rb"\xe9+-+-\u65e5+-"
    assert "é±日".encode("cp1251", "escape") == b"\\xe9\xb1\\u65e5"
    assert "é±日".encode("utf-8", "escape") == "é±日".encode()


def test_a_name_that_is_not_utf_8_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="folder: must be UTF-8"):
        ready(tmp_path / os.fsdecode(b"\xff"), "make", [])
    with pytest.raises(InputError, match="FILE: must be UTF-8"):
        write_new(tmp_path / os.fsdecode(b"\xff.toml"))
    assert not list(tmp_path.iterdir())


FAILURES = {
    "memory": (MemoryError(), 3, "out of memory (MemoryError)"),
    "a library's memory": (RuntimeError("std::bad_alloc"), 3, "out of memory (std::bad_alloc)"),
    "exhausted": (ExhaustedError("the model needs more memory"), 3, "the model needs more memory"),
    "refused": (RefusedError("does not balance"), 1, "does not balance"),
    "a failed check of its own": (
        FaultError("cavity: the print mesh is open"),
        3,
        "cavity: the print mesh is open; this is a fault of skincad, not of the input; please report it",
    ),
    "a fault": (ZeroDivisionError("by\nzero"), 3, "internal error: ZeroDivisionError: by zero; please rep"),
}


@pytest.mark.parametrize("json_asked", [False, True])
@pytest.mark.parametrize("failure", FAILURES)
def test_every_failure_is_one_line_and_with_json_an_object(
    failure: str, json_asked: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    raised, expected, words = FAILURES[failure]
    monkeypatch.setattr("skincad.check", Mock(side_effect=raised))
    done = run_skincad(*CHECK.split(), *["--json"] * json_asked, cwd=tmp_path)
    assert done.returncode == expected
    assert done.stderr.startswith(f"skincad: {words}")
    assert done.stderr.count("\n") == 1
    if json_asked:
        message = done.stderr.removeprefix("skincad: ").rstrip("\n")
        assert json.loads(done.stdout) == {"passed": False, "error": message}
    else:
        assert done.stdout == ""


def kernel_fails(*_: object) -> None:
    raise type("StdFail_NotDone", (Exception,), {"__module__": "OCP.StdFail"})


def measured(**wrong: object) -> Callable[..., object]:
    """A measurement of any mesh, good but for what is `wrong`."""
    good = {"watertight": True, "self_intersections": 0, "volume": 1.0, "deviation": 0.0}
    return lambda *_: SimpleNamespace(**{**good, **wrong})


BROKEN = {  # a check that fails: what stands for it, and the words for it
    "volume": ("skincad.solids.occ.volume", lambda part, _: 1.001 * part.volume, "volume differs"),
    "validity": (
        "skincad.solids.occ.BRepCheck_Analyzer",
        Mock(**{"return_value.IsValid": bool}),
        "not valid",
    ),
    "kernel": ("skincad.solids.occ.unchecked_solid", kernel_fails, "the CAD kernel failed (StdFail_NotDone"),
    "open": ("skincad.fabrication.measures.measure", measured(watertight=False), "is open"),
    "crossing": ("skincad.fabrication.measures.measure", measured(self_intersections=2), "2 faces"),
    "deviation": ("skincad.fabrication.measures.measure", measured(deviation=1.0), "deviates by 1 mm"),
}


@pytest.mark.parametrize("check", BROKEN)
def test_a_solid_or_mesh_that_fails_its_check_is_a_fault_and_writes_nothing(
    check: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, wrong, words = BROKEN[check]
    monkeypatch.setattr(place, wrong)
    small = "--set ridge.count=1 --set skin.width=3.0 --no-check"
    done = run_skincad(*f"make plain-ridges {small} -o out".split(), cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.startswith("skincad: skin: ")
    assert words in done.stderr
    assert "this is a fault of skincad, not of the input; please report it" in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_traceback_is_shown_to_who_asks_for_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("skincad.check", Mock(side_effect=ZeroDivisionError))
    monkeypatch.setenv("SKINCAD_TRACEBACK", "1")
    done = run_skincad(*CHECK.split(), cwd=tmp_path)
    assert done.returncode == 3
    assert "Traceback" in done.stderr
    assert "SKINCAD_TRACEBACK" in done.stderr.splitlines()[-1]


TOO_LITTLE = """
import resource, sys
import skincad.mechanics.models.linear
from skincad.base.machine import one_blas_thread
from skincad.cli import main
with one_blas_thread():
    pass
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
most = used + ({} << 20)
resource.setrlimit(resource.RLIMIT_AS, (most, most))
sys.argv = ["skincad", "check", "plain-ridges", "--tier", "linear", "--json"]
main()
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks Linux how much memory is used")
@pytest.mark.slow
@pytest.mark.parametrize("more", [20, 60])  # MB beside what the libraries take: a solution asks for more
def test_too_little_memory_is_one_object_and_status_3(more: int, tmp_path: Path) -> None:
    done = python(TOO_LITTLE.format(more), cwd=tmp_path)
    assert "Traceback" not in done.stderr
    assert done.returncode == 3, done.stderr
    # the FE library may have a line of its own before
    assert "memory" in json.loads(done.stdout.splitlines()[-1])["error"]


MISSING = "cannot open shared object file: No such file or directory"


def test_a_kernel_that_does_not_load_for_another_reason_is_no_missing_library(tmp_path: Path) -> None:
    """Only the linker's word that a file is missing leads to the advice to install it."""
    broken = tmp_path / "cadquery"
    broken.mkdir()
    program = "import skincad.solids.occ"
    environment = {"PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"}
    for words, kind in (("initialization failed", "ImportError"), ("libGL.so.1: " + MISSING, "InputError")):
        (broken / "__init__.py").write_text(f"raise ImportError({words!r})")
        done = python(program, **environment)
        assert kind in done.stderr.splitlines()[-1]
        assert ("apt-get" in done.stderr) == (kind == "InputError")


@pytest.fixture
def _listening() -> object:
    before = {signum: signal.getsignal(signum) for signum in NAMES}
    listen()
    yield
    for signum, handler in before.items():
        signal.signal(signum, handler)


@pytest.mark.usefixtures("_listening")
@pytest.mark.parametrize(
    ("signum", "kind"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)]
)
def test_a_signal_waits_for_an_import_to_be_through(
    signum: int, kind: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C extensions turn whatever is raised in their import into an ImportError, as this module would."""
    (tmp_path / "half_made.py").write_text(
        f"import os, time\ntry:\n    os.kill(os.getpid(), {int(signum)})\n    time.sleep(0.1)\n"
        "except BaseException as failure:\n    raise ImportError('initialization failed') from failure\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "half_made", raising=False)
    importlib.import_module("half_made")
    with pytest.raises(kind):
        safe_point()
    safe_point()  # one signal ends one thing


@pytest.mark.usefixtures("_listening")
def test_a_signal_waits_for_a_folder_to_be_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the files that are moved, and in the removal of the old ones too."""
    for step in ("rename", "unlink"):  # the second time there is a result to be replaced
        original, sent = getattr(Path, step), []

        def signalled(self: Path, *rest: object, original: object = original, sent: list = sent) -> object:
            if not sent:
                sent.append(os.kill(os.getpid(), signal.SIGINT))
            return original(self, *rest)

        monkeypatch.setattr(Path, step, signalled)
        with replaced(tmp_path / "here", "make") as staging:
            (staging / "a").write_text("new")
        monkeypatch.setattr(Path, step, original)
        if sent:
            with pytest.raises(KeyboardInterrupt):
                safe_point()
    assert sent
    assert [p.name for p in tmp_path.iterdir()] == ["here"]
    assert sorted(p.name for p in (tmp_path / "here").iterdir()) == ["a", "make.json"]
    assert (tmp_path / "here" / "a").read_text() == "new"


TWICE = """
import os, signal, time
from skincad.base.interrupt import listen
listen()
for _ in range(2):
    os.kill(os.getpid(), signal.SIGINT)
    print("here", flush=True)
"""


def test_a_second_signal_ends_the_process_at_once() -> None:
    """The first one waits for a safe point, and there is none."""
    done = python(TWICE)
    assert (done.returncode, done.stdout) == (-signal.SIGINT, "here\n")


AT = """
import os, signal, sys
class At:
    def find_spec(self, name, path=None, target=None):
        if name == AT:
            SEND
sys.meta_path.insert(0, At())
sys.argv = ["skincad", *sys.argv[1:]]
from skincad.__main__ import main
main()
"""
NAMES = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


def assert_ended(status: int, out: str, err: str, signum: int, cwd: Path) -> None:
    assert (status, out) == (128 + signum, ""), err
    assert err == f"skincad: {NAMES[signal.Signals(signum)]}\n"
    assert not [p for p in cwd.rglob("*") if p.is_file() or p.name.startswith(".")]


@pytest.mark.parametrize(
    ("module", "command"),
    [
        ("typer", "templates"),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("numpy.linalg", CHECK),  # a C extension, as pydantic_core
                ("PIL.Image", "circuit yamada-2002"),
                ("ngsolve", "check plain-ridges --model linear --no-advice"),
            )
        ),
        pytest.param(
            *("OCP.gp", "make plain-ridges --format dxf --no-check"),
            marks=[pytest.mark.slow, pytest.mark.dear("the CAD kernel is imported twice")],
        ),
    ],
)
def test_a_signal_while_a_library_is_imported(module: str, command: str, tmp_path: Path) -> None:
    for signum in NAMES:
        text = AT.replace("== AT", f"== {module!r}").replace("SEND", f"os.kill(os.getpid(), {int(signum)})")
        done = python(text, *command.split(), cwd=tmp_path)
        assert_ended(done.returncode, done.stdout, done.stderr, signum, tmp_path)


@pytest.mark.slow
@pytest.mark.dear("each signal has a process that imports what the command needs")
@pytest.mark.parametrize(
    ("command", "times"), [("make plain-ridges --format dxf --no-check", 2), ("circuit yamada-2002", 4)]
)
def test_signals_at_random_moments(command: str, times: int, tmp_path: Path) -> None:
    """In the first seconds, from when skincad listens: the handlers are set before it is imported itself."""
    dice = random.Random(2002)
    text = AT.replace("== AT", "== 'skincad.cli'").replace("SEND", "os.write(2, b'.')")
    for i in range(times):
        signum = (signal.SIGINT, signal.SIGTERM)[i % 2]
        words = [sys.executable, "-c", text, *command.split(), "-o", f"{i}"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        with started(words, cwd=tmp_path, **pipes) as running:
            assert running.stderr is not None
            assert running.stderr.read(1) == "."
            time.sleep(dice.uniform(0.0, 3.0))
            running.send_signal(signum)
            out, err = running.communicate(timeout=300)
        if running.returncode == 0:  # it was faster: a whole result
            assert (tmp_path / f"{i}").is_dir()
            assert not list(tmp_path.glob(".*"))
            continue
        assert_ended(running.returncode, out, err, signum, tmp_path / f"{i}")
        assert not list(tmp_path.glob(".*"))


@pytest.mark.slow
def test_a_signal_that_was_ignored_stays_so(tmp_path: Path) -> None:
    """As a script has it for what it runs in the background."""
    text = AT.replace("== AT", "== 'typer'").replace("SEND", "os.kill(os.getpid(), signal.SIGINT)")
    done = subprocess.run(
        [sys.executable, "-c", text, "templates"],
        cwd=tmp_path, capture_output=True, check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
        timeout=300,
    )  # fmt: skip
    assert done.returncode == 0
