"""KiCad 6, which has no command line for schematics: its editor on a display of its own, driven by keys."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

PROGRAMS = ("eeschema", "Xvfb", "xdotool")
MISSING = ", ".join(program for program in PROGRAMS if shutil.which(program) is None)
needs_kicad = pytest.mark.skipif(bool(MISSING), reason=f"not installed: {MISSING}")
NETLIST_KEYS, RULES_KEYS = "ctrl+shift+n", "ctrl+alt+shift+j"
SAVE_BUTTON = (-53, -78)  # pixels from the lower right corner of the window of the electrical rules' checker
PATIENCE = 60  # looks, of a second and a little more each
TRIES = (
    4  # of an editor: a key that comes while it draws is lost now and then, and so may be a window's focus
)


@contextmanager
def ending(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """A process that ends with the block."""
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=30)


class Editor:
    """The schematic editor with a file open."""

    def __init__(self, environment: dict[str, str]) -> None:
        self.environment = environment

    def keys(self, *words: str) -> str:
        line = ["xdotool", *words]
        return subprocess.run(
            line, env=self.environment, capture_output=True, text=True, check=False, timeout=30
        ).stdout

    def window(self, title: str) -> str:
        """The window whose title has these words; "" if there is none."""
        return self.keys("search", "--onlyvisible", "--name", title).partition("\n")[0]

    def until(self, file: Path, steps: dict[str, Callable[[str], object]]) -> str:
        """What a file holds once it is there, "" if it does not come. Till then `steps` say what to do with
        the first window that is open."""
        for _ in range(PATIENCE):
            if file.exists() and file.stat().st_size:
                return file.read_text()
            title = next((title for title in steps if self.window(title)), None)
            if title is not None:
                self.keys("windowfocus", self.window(title))
                steps[title](self.window(title))
            time.sleep(1.0)
        return ""

    def press(self, keys: str) -> Callable[[str], object]:
        return lambda _: self.keys("mousemove", "400", "400", "sleep", "0.3", "key", keys)

    def check_and_save(self, window: str) -> None:
        place = self.keys("getwindowgeometry", "--shell", window)
        sizes = dict(row.split("=") for row in place.split())
        x = int(sizes["X"]) + int(sizes["WIDTH"]) + SAVE_BUTTON[0]
        y = int(sizes["Y"]) + int(sizes["HEIGHT"]) + SAVE_BUTTON[1]
        self.keys("key", "Return", "sleep", "3", "mousemove", str(x), str(y), "click", "1")


def netlist_and_rules(file: Path, home: Path) -> tuple[str, str]:
    """Return the netlist and the report of the electrical rules that KiCad writes of a schematic, into its
    folder; `home` is an empty folder for its settings."""
    for number in range(TRIES):
        netlist, report = _asked(file, home / str(number))
        if netlist and report:
            return netlist, report
    pytest.fail(f"KiCad wrote no {'report' if netlist else 'netlist'} of {file.name}, {TRIES} times")


def _asked(file: Path, home: Path) -> tuple[str, str]:
    """What one editor writes, "" of what does not come."""
    settings = home / "kicad" / "6.0"
    settings.mkdir(parents=True)
    (settings / "sym-lib-table").write_text("(sym_lib_table)\n")
    (settings / "kicad_common.json").write_text('{"meta": {"filename": "kicad_common.json", "version": 3}}')
    keys = {"EditorControl.exportNetlist": "Ctrl+Shift+N", "InspectionTool.runERC": "Ctrl+Alt+Shift+J"}
    rows = (f"eeschema.{action}\t{key}\n" for action, key in keys.items())
    (settings / "user.hotkeys").write_text("".join(rows))
    with ExitStack() as stack:
        screen = ["Xvfb", "-displayfd", "1", "-screen", "0", "1600x1200x24"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
        display = stack.enter_context(ending(subprocess.Popen(screen, **pipes)))
        assert display.stdout
        number = display.stdout.readline().strip()
        environment = os.environ | {
            "DISPLAY": f":{number}", "HOME": str(home), "XDG_CONFIG_HOME": str(home / ".config"),
            "KICAD_CONFIG_HOME": str(home / "kicad"), "LIBGL_ALWAYS_SOFTWARE": "1",
        }  # fmt: skip
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "text": True}
        stack.enter_context(ending(subprocess.Popen(["eeschema", str(file)], env=environment, **quiet)))
        editor, loaded = Editor(environment), f"^{file.stem} .*Schematic Editor"
        netlist = editor.until(
            file.with_suffix(".net"),
            {
                "Save Netlist File": editor.press("Return"),
                "Export Netlist": editor.press("Return"),
                loaded: editor.press(NETLIST_KEYS),
            },
        )
        if not netlist:
            return "", ""
        report = editor.until(
            file.parent / "ERC.rpt",
            {
                "Save Report to File": editor.press("Return"),
                "Electrical Rules Checker": editor.check_and_save,
                loaded: editor.press(RULES_KEYS),
            },
        )
    return netlist, report
