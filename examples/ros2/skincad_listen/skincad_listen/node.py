"""A node that runs `skincad listen` and publishes what it says.

Topics: `~/events` has each line as JSON, a std_msgs/String; `~/slip` the ridge that begins to slip, a
std_msgs/Int32, 0 where gross slip of the whole skin is ahead.
Parameters: `command`, the list of words to run; its first is the program.
"""

import json
import signal
import subprocess
import threading
from collections.abc import Iterable

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Int32, String

COMMAND = ["skincad", "listen", "yamada-2002", "--ridges", "3,4,5,6", "--rate", "5000"]
COMMAND += ["--port", "/dev/ttyACM0"]
SLIP = {"incipient slip", "gross slip ahead"}
WHOLE_SKIN = 0  # in the place of a ridge, which count from 1
QUEUE = 100  # messages
PATIENCE = 10.0  # s, for a recording to be ended


class ListenNode(Node):
    """Publishes the lines of a process; `ended` is set when it has ended."""

    def __init__(self) -> None:
        super().__init__("skincad_listen")
        self.declare_parameter("command", COMMAND)
        self.events = self.create_publisher(String, "~/events", QUEUE)
        self.slip = self.create_publisher(Int32, "~/slip", QUEUE)
        self.ended = threading.Event()
        command = list(self.get_parameter("command").value)
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C reaches it by `close` alone: a second ends it at once
        )
        self.readers = [
            threading.Thread(target=read, args=(stream,), daemon=True)
            for read, stream in ((self._publish, self.process.stdout), (self._log, self.process.stderr))
        ]
        for reader in self.readers:
            reader.start()

    def _publish(self, lines: Iterable[str]) -> None:
        try:
            for line in lines:
                event = json.loads(line)
                self.events.publish(String(data=line.rstrip("\n")))
                if event["kind"] in SLIP:
                    ridge = WHOLE_SKIN if event["ridge"] is None else event["ridge"]
                    self.slip.publish(Int32(data=ridge))
        finally:
            self.ended.set()

    def _log(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.get_logger().info(line.rstrip("\n"))

    def close(self) -> int:
        """End the process as Ctrl-C does, which keeps its recording; return its status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            status = self.process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        for reader in self.readers:
            reader.join(timeout=PATIENCE)
        return status


def main() -> None:
    """Spin until the process ends or Ctrl-C; the exit status is the process's."""
    rclpy.init()
    node = ListenNode()
    try:
        while rclpy.ok() and not node.ended.is_set():
            rclpy.spin_once(node, timeout_sec=0.1)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        status = node.close()
        node.destroy_node()
        if rclpy.ok():
            rclpy.shutdown()
    raise SystemExit(status)


if __name__ == "__main__":
    main()
