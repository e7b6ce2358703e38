# SPDX-License-Identifier: Apache-2.0
"""A server that connects trackers and 3D Slicer to an operation, by OpenIGTLink.

    client --TRANSFORM ToolToBone--> Server --move()--> servo loop at 1 kHz, in C --> bone
       ^                                |                     |
       '-- TRANSFORM, SENSOR, STRING ---'<------ state() -----'
       '-- STRING, IMAGE ---------------'<----- changes() ----'

    python -m osteon.openigtlink --bone ct.nii.gz --tool reamer.stl

docs/reference/openigtlink.md lists the messages with their units and rates, and the rules for clients. The package
pyigtl converts the messages; this module reads and writes the sockets, because the server of pyigtl accepts messages of
any size and does not check the CRC. _openigtlink.py divides a client's data into messages and packs the server's.

The protocol has neither authentication nor encryption. The server listens on the loopback address by default.

Threads: a Server and its operation are used by one thread. stop() can be called by any thread or signal handler.
"""
import argparse
import collections
import math
import selectors
import signal
import socket
import sys
import time
from typing import Any, Callable, Counter, Dict, List, Optional, Set, Tuple

import numpy as np

from osteon._openigtlink import (NEWTON, NEWTON_METRE, Broken, ChangedBone, Messages, Reader, Refused, SensorMessage,
                                 igtl)
from osteon.backend import Backend
from osteon.errors import FileError, OsteonError, UnavailableError, UsageError
from osteon.force import ForceParams
from osteon.operation import LiveState, LoopReport, Operation
from osteon.world import World

__all__ = ["NEWTON", "NEWTON_METRE", "SensorMessage", "Server", "main"]

PORT = 18944
MAX_OUT = 1 << 18        # state messages are left out while so many bytes wait for a client
MAX_CLIENTS = 8
BACKLOG = 64
ANSWER_S = 0.02          # longest time until an answer, for ticks that do not advance the world
POLL_S = 1e-4            # interval at which the loop's state is read while an answer is due
JUMP_MM, JUMP_COS = 20.0, math.cos(math.radians(30))


class _Client:
    def __init__(self, connection: socket.socket, name: str) -> None:
        self.socket, self.name = connection, name
        self.reader, self.out = Reader(), bytearray()
        self.answer: Optional[Tuple[int, float]] = None  # number of ticks, and time, at which the answer is sent
        self.image = True                      # True if the newest image is to be sent
        self.counts: Counter[str] = collections.Counter()
        self.told: Set[str] = set()


class Server:
    """Serves an operation to OpenIGTLink clients.

    Parameters
    ----------
    operation : Operation
        The operation, whose loop does not run yet. run() starts it.
    host, port : str, int
        Address to listen on; with port 0, the system chooses the port (see `address`).
    frame : {"ras", "lps"}
        Frame of all poses, forces, torques and images.
    transform : str
        Device name of the TRANSFORM messages that move the tool.
    rate_hz : float
        Rate of the state messages. The client that moves the tool also receives an answer to each pose.
    image_hz : float
        Rate of the image and of the events about removed bone.
    silent_s : float
        Time without a pose after which the motor stops and another client can move the tool.
    motor : bool
        True if the motor runs while poses arrive; a client changes it by the STRING message Motor.
    log : callable
        Called with one line of text per report.

    Raises
    ------
    UnavailableError
        If pyigtl is not installed.
    FileError
        If the address cannot be used.
    """

    def __init__(self, operation: Operation, *, host: str = "127.0.0.1", port: int = PORT, frame: str = "ras",
                 transform: str = "ToolToBone", rate_hz: float = 20.0, image_hz: float = 2.0, silent_s: float = 1.0,
                 motor: bool = True, log: Optional[Callable[[str], Any]] = None) -> None:
        if igtl is None:
            raise UnavailableError("pyigtl is not installed: pip install osteon[openigtlink]")
        if frame not in ("ras", "lps"):
            raise UsageError(f"frame {frame!r}: expected ras or lps")
        for name, value in (("rate", rate_hz), ("image-rate", image_hz)):
            if not 0 < value <= 1000:
                raise UsageError(f"--{name} {value}: expected a number of messages per second, above 0 and at most 1000")
        self.operation, self.frame, self.transform = operation, frame, transform
        self.silent_s, self.motor, self.log = silent_s, motor, log or (lambda line: None)
        self._period, self._image_period = 1 / rate_hz, 1 / image_hz
        self.counts: Counter[str] = collections.Counter()
        self._clients: List[_Client] = []
        self._mover: Optional[_Client] = None   # the client that moves the tool
        self._moved_at = -math.inf              # time of its last pose
        self._last: Optional[np.ndarray] = None
        self._stopped = False
        self._fault = ""
        self._classes_met: Set[str] = set()
        self._removed = 0
        self._image_bytes: Optional[bytes] = None
        try:
            family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM,
                                                             flags=socket.AI_PASSIVE)[0]
            self._listener = socket.socket(family, kind)
            try:
                self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                self._listener.bind(address)
                self._listener.listen(BACKLOG)
            except OSError:
                self._listener.close()
                raise
        except (OSError, OverflowError, UnicodeError) as error:
            raise FileError(f"{host}:{port}: cannot listen on this address: {error}") from None
        self._listener.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)

    @property
    def address(self) -> Tuple[str, int]:
        """Address and port on which the server listens."""
        host, port = self._listener.getsockname()[:2]
        return host, port

    def stop(self) -> None:
        """Ends run()."""
        self._stopped = True

    # -------------------------------------------------------------------- loop

    def run(self, seconds: Optional[float] = None, *, realtime: bool = True) -> LoopReport:
        """Starts the servo loop, and serves clients until stop() is called or the time has passed.

        Parameters
        ----------
        realtime : bool
            True to request real-time priority for the servo loop.

        Raises
        ------
        OsteonError
            If the operation failed.
        """
        self._classes = self.operation.world.classes
        self._bone = ChangedBone(self.operation)
        self.operation.motor = False  # until the first pose
        self.operation.start(realtime=realtime)
        self._messages = Messages(self.frame, time.time())
        now = time.monotonic()
        end = math.inf if seconds is None else now + seconds
        state_at, image_at = now, now
        try:
            while not self._stopped and now < end and self.operation.running:
                waits = max(min(state_at, image_at, end, now + 0.05) - now, 0)
                if any(client.answer for client in self._clients):
                    waits = 0
                    time.sleep(POLL_S)  # select() rounds its time up to a millisecond
                for key, events in self._selector.select(waits):
                    if key.data is None:
                        self._accept()
                    else:
                        self._serve(key.data, events)
                now = time.monotonic()
                state = self.operation.state()
                if state is None:
                    continue
                self._check(state, now)
                self._answer(state, now)
                if now >= state_at:
                    self._broadcast(self._messages.state(state) + self._messages.report(state))
                    state_at = max(state_at + self._period, now)
                if now >= image_at:
                    self._changes(state)
                    image_at = max(image_at + self._image_period, now)
                self._images()
        finally:
            try:
                report = self.operation.stop()
            finally:
                self._finish()
        return report

    def _finish(self) -> None:
        """Sends the remaining data to the clients, for at most a second, and closes all sockets."""
        state = self.operation.state()
        if state is not None:
            self._changes(state)
        until = time.monotonic() + 1
        self._images()
        while any(client.out for client in self._clients) and time.monotonic() < until:
            for key, events in self._selector.select(0.05):
                if key.data is not None and events & selectors.EVENT_WRITE:
                    self._send(key.data)
            self._images()
        for client in list(self._clients):
            self._close(client, "the server ends")
        self._selector.close()
        self._listener.close()

    def _check(self, state: LiveState, now: float) -> None:
        """Stops the motor of a silent client, and reports faults."""
        if self._mover is not None and self.operation.motor and now - self._moved_at > self.silent_s:
            self.operation.motor = False
            self._event(state, {"event": "silent", "client": self._mover.name})
            self._tell(self._mover, "silent", f"no pose for {self.silent_s:g} s; the motor is off")
        if state.fault != self._fault:
            self._fault = state.fault
            self._event(state, {"event": "fault", "fault": state.fault})

    # ----------------------------------------------------------------- sockets

    def _accept(self) -> None:
        for _ in range(BACKLOG):
            try:
                connection, address = self._listener.accept()
            except BlockingIOError:
                return
            except OSError:
                continue  # the client has closed the connection again
            self._greet(connection, address)

    def _greet(self, connection: socket.socket, address: Any) -> None:
        client = _Client(connection, f"{address[0]}:{address[1]}")
        if len(self._clients) == MAX_CLIENTS:
            self.counts["refused clients"] += 1
            self.log(f"{client.name}: refused, because {MAX_CLIENTS} clients are connected")
            connection.close()
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._clients.append(client)
        self._selector.register(connection, selectors.EVENT_READ, client)
        self.log(f"{client.name}: connected")

    def _close(self, client: _Client, reason: str) -> None:
        if client not in self._clients:
            return
        self._clients.remove(client)
        self._selector.unregister(client.socket)
        client.socket.close()
        if client is self._mover:
            self._mover = None
            self.operation.motor = False
        counts = ", ".join(f"{count} {name}" for name, count in sorted(client.counts.items()))
        self.log(f"{client.name}: closed: {reason}" + (f" ({counts})" if counts else ""))

    def _tell(self, client: _Client, kind: str, line: str) -> None:
        """Counts a kind of report, and logs the first of each client."""
        client.counts[kind] += 1
        self.counts[kind] += 1
        if kind not in client.told:
            client.told.add(kind)
            self.log(f"{client.name}: {line}")

    def _serve(self, client: _Client, events: int) -> None:
        try:
            if events & selectors.EVENT_WRITE:
                self._send(client)
            if events & selectors.EVENT_READ and client in self._clients:
                data = client.socket.recv(1 << 16)
                if not data:
                    self._close(client, "by the client")
                    return
                self._receive(client, data)
        except BlockingIOError:
            pass
        except Broken as error:
            self.counts["broken clients"] += 1
            self._close(client, str(error))
        except OSError as error:
            self._close(client, error.strerror or str(error))

    def _put(self, client: _Client, data: bytes) -> None:
        if not client.out:
            self._selector.modify(client.socket, selectors.EVENT_READ | selectors.EVENT_WRITE, client)
        client.out += data

    def _send(self, client: _Client) -> None:
        try:
            sent = client.socket.send(client.out)
        except BlockingIOError:
            return
        except OSError as error:
            self._close(client, error.strerror or str(error))
            return
        del client.out[:sent]
        if not client.out:
            self._selector.modify(client.socket, selectors.EVENT_READ, client)

    def _broadcast(self, data: bytes) -> None:
        for client in self._clients:
            self._offer(client, data)

    def _offer(self, client: _Client, data: bytes) -> None:
        """Sends state messages, unless the client is too slow."""
        if len(client.out) > MAX_OUT:
            self._tell(client, "left out", "does not read fast enough; state messages are left out")
        else:
            self._put(client, data)

    # ------------------------------------------------------------------ input

    def _receive(self, client: _Client, data: bytes) -> None:
        for received in client.reader.feed(data):
            about = f"{received.kind} {received.device}"
            if received.body is None:
                self._tell(client, "ignored", f"{about}: a message of {received.size} bytes that the server does not use; it "
                           "is ignored")
                continue
            try:
                self._message(client, received.kind, received.device, received.unpack())
            except Refused as error:
                self._tell(client, "refused", f"{about}: {error}")

    def _message(self, client: _Client, kind: str, device: str, message: Any) -> None:
        if kind == "TRANSFORM" and device == self.transform:
            self._pose(client, message.matrix)
        elif kind == "STRING" and device == "Motor":
            self._motor(client, message.string)
        else:
            raise Refused(f"expected TRANSFORM {self.transform} or STRING Motor; it is ignored")

    def _mover_is(self, client: _Client) -> None:
        """Checks that a client may move the tool."""
        if self._mover not in (None, client) and time.monotonic() - self._moved_at <= self.silent_s:
            assert self._mover is not None
            raise Refused(f"{self._mover.name} moves the tool; it is ignored")

    def _motor(self, client: _Client, text: str) -> None:
        if text not in ("on", "off"):
            raise Refused(f"{text[:20]!r}: expected on or off")
        self._mover_is(client)
        self.motor = text == "on"
        if client is self._mover:
            self.operation.motor = self.motor

    def _pose(self, client: _Client, matrix: Any) -> None:
        matrix, pose = self._messages.received_pose(matrix)
        self._mover_is(client)
        now = time.monotonic()
        lifted = client is not self._mover or self._last is None or now - self._moved_at > self.silent_s
        if not lifted and self._last is not None and (
                np.linalg.norm(matrix[:3, 3] - self._last[:3, 3]) > JUMP_MM or
                (np.trace(matrix[:3, :3].T @ self._last[:3, :3]) - 1) / 2 < JUMP_COS):
            self._tell(client, "jumps", "the pose jumped; the tool is put down at the new pose and cuts nothing on the "
                       "way")
            lifted = True
        if client is not self._mover:
            self._mover = client
            self.log(f"{client.name}: moves the tool")
        self._last, self._moved_at = matrix, now
        self.operation.move(pose, lifted=lifted, motor=self.motor)
        client.counts["poses"] += 1
        self.counts["poses"] += 1
        state = self.operation.state()
        client.answer = (state.ticks + 1 if state else 1, now + ANSWER_S)

    # ----------------------------------------------------------------- output

    def _event(self, state: LiveState, content: Dict[str, Any]) -> None:
        self._broadcast(self._messages.text("Event", state, {"t_s": state.t_ns / 1e9, **content}))

    def _answer(self, state: LiveState, now: float) -> None:
        data = b""
        for client in self._clients:
            if client.answer and (state.ticks >= client.answer[0] or now >= client.answer[1]):
                client.answer = None
                data = data or self._messages.state(state)
                self._offer(client, data)

    def _changes(self, state: LiveState) -> None:
        """Sends events about the bone that was removed, and makes a new image of the changed bone."""
        removed = self._bone.take()
        if not removed.size:
            return
        borders = [border for _, border in self._classes]
        classes = np.maximum(np.searchsorted(borders, removed, side="right") - 1, 0)
        counts = {name: int((classes == number).sum()) for number, (name, _) in enumerate(self._classes)}
        spacing = self.operation.geometry.spacing_pm
        self._removed += removed.size
        self._event(state, {"event": "removed", "voxels": int(removed.size), "removed_voxels": self._removed,
                            "by_class": counts, "volume_mm3": round(removed.size * math.prod(s * 1e-9 for s in spacing), 6)})
        for name, count in counts.items():
            if count and name not in self._classes_met:
                self._classes_met.add(name)
                self._event(state, {"event": "class", "class": name})
        self._image_bytes = None
        for client in self._clients:
            client.image = True
        self._image_at = self._messages.time(state)

    def _images(self) -> None:
        """Sends the newest image to the clients that have received everything before."""
        if self._bone.box is None:
            return
        for client in self._clients:
            if client.image and not client.out:
                if self._image_bytes is None:
                    self._image_bytes = self._messages.image(self._bone, self._image_at)
                client.image = False
                self._put(client, self._image_bytes)


# ----------------------------------------------------------------------- command


def _arguments(arguments: Optional[List[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m osteon.openigtlink", description="Serves an operation on a bone to "
                                     "OpenIGTLink clients, such as 3D Slicer and trackers.")
    parser.add_argument("--bone", required=True, help="a bone or a CT, as for osteon import")
    parser.add_argument("--tool", required=True, help="a mesh or a tool grid")
    parser.add_argument("--voxel", default="0.5", metavar="MM", help="voxel size of the tool (default: 0.5)")
    parser.add_argument("--bind", default="127.0.0.1", metavar="ADDRESS", help="address to listen on (default: 127.0.0.1,"
                        " which other machines cannot reach)")
    parser.add_argument("--port", type=int, default=PORT, help=f"port; 0: chosen by the system (default: {PORT})")
    parser.add_argument("--transform", default="ToolToBone", metavar="NAME", help="device name of the TRANSFORM messages "
                        "that move the tool (default: ToolToBone)")
    parser.add_argument("--frame", choices=("ras", "lps"), default="ras", help="frame of poses, forces and images "
                        "(default: ras, as in 3D Slicer)")
    parser.add_argument("--rate", type=float, default=20, metavar="HZ", help="rate of the state messages (default: 20)")
    parser.add_argument("--image-rate", type=float, default=2, metavar="HZ", help="greatest rate of the images "
                        "(default: 2)")
    parser.add_argument("--silent", type=float, default=1000, metavar="MS", help="time without a pose after which the "
                        "motor stops (default: 1000)")
    parser.add_argument("--rpm", type=int, default=200, help="speed of the motor (default: 200)")
    parser.add_argument("--motor-off", action="store_true", help="the motor is off until a client sends STRING Motor")
    parser.add_argument("--force", choices=("energy", "instant", "off"), default="energy", help="force law; off: the tool "
                        "is at the pose, and bone yields at once (default: energy)")
    parser.add_argument("--force-params", metavar="FILE", help="parameters of the force")
    parser.add_argument("--backend", default="cpu", metavar="SPEC", help="backend (default: cpu)")
    parser.add_argument("--record", metavar="FILE", help="session file to write")
    parser.add_argument("--out", metavar="FILE", help="file for the remaining bone")
    parser.add_argument("--seconds", type=float, metavar="N", help="duration (default: until SIGINT or SIGTERM)")
    parser.add_argument("--no-realtime", action="store_true", help="request no real-time priority")
    return parser.parse_args(arguments)


def _log(line: str) -> None:
    print("osteon.openigtlink: " + line.replace("\n", " "), file=sys.stderr, flush=True)


def _run(args: argparse.Namespace) -> None:
    force = None
    if args.force != "off":
        force = ForceParams.read(args.force_params, args.force) if args.force_params else ForceParams(args.force)
    with Backend(args.backend) as backend:
        bone = backend.read_bone(args.bone)
        world = World(bone, [backend.read_tool(args.tool, args.voxel)])
        with Operation(world, force=force, rpm=args.rpm, record=args.record, device="openigtlink") as operation:
            server = Server(operation, host=args.bind, port=args.port, frame=args.frame, transform=args.transform,
                            rate_hz=args.rate, image_hz=args.image_rate, silent_s=args.silent / 1000,
                            motor=not args.motor_off, log=_log)
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, lambda *unused: server.stop())
            host, port = server.address
            if not host.startswith("127.") and host != "::1":
                _log(f"{host} can be reached from other machines; the protocol has neither authentication nor encryption")
            print(f"listening on {host}:{port}", flush=True)
            report = server.run(args.seconds, realtime=not args.no_realtime)
            operation.finish()
            if args.out:
                bone.write(args.out)
            counts = "".join(f", {count} {name}" for name, count in sorted(server.counts.items()))
            print(f"{report.ticks} ticks, {world.totals.removed_voxels} voxels removed, {report.missed} deadlines missed"
                  f"{counts}; bone {bone.digest()}", flush=True)


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the server until SIGINT, SIGTERM or --seconds. Returns the exit status."""
    args = _arguments(arguments)
    try:
        _run(args)
    except OsteonError as error:
        _log(str(error))
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
