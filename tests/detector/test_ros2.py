"""The ROS 2 example without ROS: its node with a stub of rclpy, which runs the real `skincad listen`."""

from __future__ import annotations

import ast
import json
import os
import sys
import threading
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.conftest import run_skincad
from tests.detector.test_listen import WORDS, board_lines, felt

PACKAGE = Path(__file__).parents[2] / "examples" / "ros2" / "skincad_listen"
LISTEN = [sys.executable, "-m", "skincad", *WORDS]


@dataclass
class Message:
    """As std_msgs has it."""

    data: Any = None


class Stub:
    """What the node asks of rclpy: parameters, publishers, a logger, and a loop that `spin` runs once."""

    def __init__(self, command: list[str], spin: Callable[[], None]) -> None:
        self.command, self.spin, self.up = command, spin, False
        self.published: dict[str, list[Any]] = {}
        self.logged: list[str] = []

    def node(self) -> type:
        stub = self

        class Node:
            def __init__(self, name: str) -> None:
                assert stub.up
                assert name == "skincad_listen"

            def declare_parameter(self, name: str, value: list[str]) -> None:
                assert (name, value[:2]) == ("command", ["skincad", "listen"])

            def get_parameter(self, _: str) -> SimpleNamespace:
                return SimpleNamespace(value=stub.command)

            def create_publisher(self, _: type, topic: str, __: int) -> SimpleNamespace:
                return SimpleNamespace(publish=stub.published.setdefault(topic, []).append)

            def get_logger(self) -> SimpleNamespace:
                return SimpleNamespace(info=stub.logged.append)

            def destroy_node(self) -> None: ...

        return Node

    def modules(self) -> dict[str, ModuleType]:
        def spin_once(node: Any, timeout_sec: float) -> None:
            self.spin()
            node.ended.wait(timeout_sec)

        parts: dict[str, dict[str, Any]] = {
            "rclpy": {
                "init": lambda: setattr(self, "up", True), "shutdown": lambda: setattr(self, "up", False),
                "ok": lambda: self.up, "spin_once": spin_once,
            },
            "rclpy.node": {"Node": self.node()},
            "rclpy.executors": {"ExternalShutdownException": InterruptedError},
            "std_msgs": {},
            "std_msgs.msg": {"String": Message, "Int32": Message},
        }  # fmt: skip
        modules = {name: ModuleType(name) for name in parts}
        for name, contents in parts.items():
            vars(modules[name]).update(contents)
        return modules

    def run(self, monkeypatch: pytest.MonkeyPatch) -> int:
        """The exit status of the node's program."""
        for name, module in self.modules().items():
            monkeypatch.setitem(sys.modules, name, module)
        spec = spec_from_file_location("node", PACKAGE / "skincad_listen" / "node.py")
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        with pytest.raises(SystemExit) as end:
            module.main()
        assert not self.up
        return int(end.value.code or 0)


@pytest.mark.slow
def test_each_line_is_published_once_and_alarms_as_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "film.csv"
    file.write_text(board_lines(felt()))
    stub = Stub([*LISTEN, "--csv", str(file)], lambda: None)
    assert stub.run(monkeypatch) == 0
    events = [json.loads(message.data) for message in stub.published["~/events"]]
    lines = run_skincad(*WORDS, "--csv", str(file), cwd=tmp_path).stdout.splitlines()
    assert events[:-1] == [json.loads(line) for line in lines[:-1]]
    assert events[-1]["kind"] == "end"
    assert [message.data for message in stub.published["~/slip"]] == [e["ridge"] or 0 for e in events[:-1]]
    assert len(events) > 3
    assert any("at rest" in line for line in stub.logged)


@pytest.mark.slow
def test_ctrl_c_keeps_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pipe, file = tmp_path / "pipe", tmp_path / "film.csv"
    os.mkfifo(pipe)
    command = ["sh", "-c", 'exec "$@" < "$0"', str(pipe), *LISTEN, "-", "--record", str(file)]
    said = threading.Event()

    def spin() -> None:
        if stub.published["~/slip"]:
            said.set()
            raise KeyboardInterrupt

    stub = Stub(command, spin)

    def feed() -> None:
        with pipe.open("w") as board:
            board.write(board_lines(felt()))
            board.flush()
            said.wait(60)

    feeder = threading.Thread(target=feed)
    feeder.start()
    assert stub.run(monkeypatch) in (0, 130)  # the pipe's end may be read before the signal
    feeder.join()
    end = json.loads(stub.published["~/events"][-1].data)
    assert end["recording"] == str(file)
    assert len(file.read_text().splitlines()) == end["samples"] + 2


def test_the_packages_files_name_each_other() -> None:
    root = ET.parse(PACKAGE / "package.xml").getroot()
    name = root.findtext("name")
    assert root.findtext("export/build_type") == "ament_python"
    assert {tag.text for tag in root.iter("exec_depend")} == {"rclpy", "std_msgs"}
    assert (PACKAGE / "resource" / str(name)).read_text() == ""
    calls: list[dict[str, Any]] = []
    setup = ModuleType("setuptools")
    setup.setup = lambda **given: calls.append(given)  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "setuptools", setup)
        exec(compile((PACKAGE / "setup.py").read_text(), "setup.py", "exec"), {})
    (given,) = calls
    assert (given["name"], given["packages"]) == (name, [name])
    entry = given["entry_points"]["console_scripts"][0]
    module, function = entry.partition(" = ")[2].split(":")
    tree = ast.parse((PACKAGE / (module.replace(".", "/") + ".py")).read_text())
    assert function in [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert all((PACKAGE / path).exists() for _, paths in given["data_files"] for path in paths)
