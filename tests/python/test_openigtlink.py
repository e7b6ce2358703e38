# SPDX-License-Identifier: Apache-2.0
"""Tests the OpenIGTLink server, which runs in its own process, with a client of pyigtl in another process and with
hostile clients.

All connections are on the loopback address, on ports that the system chooses. No test depends on a time limit, except
that a test fails if the server does not answer within a minute.
"""
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import osteon

igtl = pytest.importorskip("pyigtl.messages", reason="pyigtl is not installed")
from osteon import _openigtlink, openigtlink, session  # noqa: E402  pylint: disable=wrong-import-position

FLIP = np.diag([-1.0, -1.0, 1.0, 1.0])
TYPES = {"TRANSFORM": igtl.TransformMessage, "STRING": igtl.StringMessage, "IMAGE": igtl.ImageMessage,
         "SENSOR": openigtlink.SensorMessage}


class Running:
    """A server in another process."""

    def __init__(self, folder, inputs, *options):
        self.log = open(folder / "log", "w+", encoding="utf-8")  # pylint: disable=consider-using-with
        self.process = subprocess.Popen(  # pylint: disable=consider-using-with
            [sys.executable, "-m", "osteon.openigtlink", "--bone", str(inputs / "ct.nrrd"), "--tool",
             str(inputs / "reamer.stl"), "--port", "0", "--no-realtime", *map(str, options)],
            stdout=subprocess.PIPE, stderr=self.log, universal_newlines=True)
        line = self.process.stdout.readline()
        assert line.startswith("listening on 127.0.0.1:"), line + self.text()
        self.port = int(line.rsplit(":", 1)[1])

    def text(self):
        self.log.seek(0)
        return self.log.read()

    def lines(self, part):
        return [line for line in self.text().splitlines() if part in line]

    def wait_for(self, part, count=1):
        until = time.monotonic() + 60
        while len(self.lines(part)) < count:
            assert time.monotonic() < until and self.process.poll() is None, self.text()
            time.sleep(0.01)

    def memory_kb(self):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))

    def end(self):
        """Ends the server, and returns the line of its report."""
        self.process.send_signal(signal.SIGTERM)
        out, _ = self.process.communicate(timeout=60)
        assert self.process.returncode == 0, self.text()
        return out.strip()


@pytest.fixture
def serve(tmp_path, inputs):
    made = []

    def start(*options):
        made.append(Running(tmp_path, inputs, *options))
        return made[-1]

    yield start
    for server in made:
        if server.process.poll() is None:
            server.process.kill()
            server.process.communicate()
        server.log.close()


class Peer:
    """A client that reads and writes the bytes itself."""

    def __init__(self, server):
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=60)

    def send(self, *data):
        self.socket.sendall(b"".join(data))

    def read(self, count):
        data = b""
        while len(data) < count:
            part = self.socket.recv(count - len(data))
            if not part:
                raise EOFError
            data += part
        return data

    def next(self):
        """Returns the next message."""
        header = self.read(58)
        fields = igtl.MessageBase.parse_header(header)
        body = self.read(fields["body_size"])
        assert igtl.CRC64(body) == struct.unpack(">Q", header[50:58])[0]
        message = TYPES[fields["message_type"]]()
        message.unpack(fields, body)
        return message

    def until(self, name):
        """Returns the next message of a device."""
        while True:
            message = self.next()
            if message.device_name == name:
                return message

    def event(self, kind):
        while True:
            event = json.loads(self.until("Event").string)
            if event["event"] == kind:
                return event

    def until_motor(self, on, sender=None):
        """Waits until the motor is on or off, while `sender` sends poses."""
        until = time.monotonic() + 60
        while bool(json.loads(self.until("State").string)["rpm"]) != on:
            assert time.monotonic() < until
            if sender:
                sender.send(moved(FAR))

    def collect(self, messages):
        """Appends all messages until the server closes the connection."""
        try:
            while True:
                messages.append(self.next())
        except EOFError:
            pass

    def close(self):
        self.socket.close()


def moved(matrix, name="ToolToBone"):
    return igtl.TransformMessage(matrix, device_name=name).pack()


def text(name, content):
    return igtl.StringMessage(content, device_name=name).pack()


FAR = np.eye(4)  # a pose far from the bone, which is near (150, 20, 50) mm in RAS


@pytest.fixture
def poses(inputs, backend):
    """Poses of a hand that reams, as matrices in LPS, one for every 20 ms."""
    bone = backend.read_bone(inputs / "ct.nrrd")
    tool = backend.read_tool(inputs / "reamer.stl")
    path = osteon.Path.builtin("glenoid-ream", osteon.Glenoid.of_meta(bone.meta), tool)
    return [pose.matrix_mm() for pose in path.poses()[::20]]


CLIENT = """
import json, sys, time
import numpy as np
import pyigtl
from pyigtl import messages
from osteon.openigtlink import SensorMessage

messages.message_type_to_class_constructor["SENSOR"] = SensorMessage
poses = np.load(sys.argv[2])
client = pyigtl.OpenIGTLinkClient("127.0.0.1", int(sys.argv[1]))
received = []

def receive():
    for m in client.get_latest_messages():
        received.append(m)

for pose in poses:
    client.send_message(pyigtl.TransformMessage(pose, device_name="ToolToBone"), wait=True)
    time.sleep(0.02)
    receive()
until = time.time() + 60
while not any(m.device_name == "Bone" for m in received) and time.time() < until:
    time.sleep(0.01)
    receive()
names = {}
for m in received:
    names[m.device_name] = m.message_type
forces = [np.linalg.norm(m.values) for m in received if m.device_name == "HandForce"]
print(json.dumps({"names": names, "force": max(forces), "events": [
    json.loads(m.string)["event"] for m in received if m.device_name == "Event"]}))
client.stop()
"""


@pytest.mark.parametrize("frame", ["ras", "lps"])
def test_reaming_by_client_of_pyigtl(tmp_path, inputs, serve, poses, command, frame):
    server = serve("--frame", frame, "--record", tmp_path / "s.session", "--out", tmp_path / "out.nrrd", "--image-rate",
                   "20")
    turned = [FLIP @ pose @ FLIP for pose in poses] if frame == "ras" else poses
    np.save(tmp_path / "poses.npy", turned)
    viewer = Peer(server)  # a second client, like 3D Slicer in addition to a tracker
    messages = []
    thread = threading.Thread(target=viewer.collect, args=(messages,))
    thread.start()
    done = subprocess.run([sys.executable, "-c", CLIENT, str(server.port), str(tmp_path / "poses.npy")], check=True,
                          stdout=subprocess.PIPE, universal_newlines=True, timeout=120)
    seen = json.loads(done.stdout)
    assert seen["names"] == {"CutterToBone": "TRANSFORM", "HandForce": "SENSOR", "HandTorque": "SENSOR",
                             "ContactForce": "SENSOR", "State": "STRING", "Event": "STRING", "Bone": "IMAGE"}
    assert seen["force"] > 0.1 and "removed" in seen["events"]
    server.wait_for("closed: by the client (168 poses")
    report = server.end()
    thread.join(60)
    # a replay of the recorded ticks must give the bone that the server wrote
    assert "are as recorded" in command("replay", tmp_path / "s.session")
    after = osteon.Volume.read(tmp_path / "out.nrrd")
    with osteon.Backend() as backend:
        before = backend.read_bone(inputs / "ct.nrrd")
        removed, digest = int(((before.voxels() > 0) & (after.voxels == 0)).sum()), backend.bone(after).digest()
    assert removed > 1000 and f"{removed} voxels removed" in report and report.endswith(digest)
    assert session.read(tmp_path / "s.session").ticks["removed"].sum() == removed
    # the viewer must have received every event, and its last image must show the bone in the box that changed
    events, image, state = [], None, None
    for message in messages:
        if message.device_name == "Event":
            events.append(json.loads(message.string))
        elif message.device_name == "Bone":
            image = message
        elif message.device_name == "State":
            state = json.loads(message.string)
    counted = [event for event in events if event["event"] == "removed"]
    assert sum(event["voxels"] for event in counted) == removed == counted[-1]["removed_voxels"]
    by_class = {name: sum(event["by_class"][name] for event in counted) for name in counted[0]["by_class"]}
    assert sum(by_class.values()) == removed
    assert {event["class"] for event in events if event["event"] == "class"} == {n for n, c in by_class.items() if c}
    assert state["fault"] == "" and 0 < state["removed_voxels"] <= removed
    assert image.world_coordinate_system == frame
    corner = image.ijk_to_world_matrix @ [0, 0, 0, 1]
    corner = (FLIP @ corner if frame == "ras" else corner)[:3]
    first = np.rint((corner - after.geometry.origin_mm) / after.geometry.spacing_mm).astype(int)
    n = image.image.shape
    box = tuple(slice(f, f + size) for f, size in zip(first[::-1], n))
    assert np.array_equal(image.image, after.voxels[box])
    outside = np.ones(after.voxels.shape, bool)
    outside[box] = False
    assert np.array_equal(before_of(inputs)[outside], after.voxels[outside])


def before_of(inputs):
    with osteon.Backend() as backend:
        return backend.read_bone(inputs / "ct.nrrd").voxels()


@pytest.mark.parametrize("frame", ["ras", "lps"])
def test_each_pose_is_answered(serve, poses, frame):
    """The tool in the answers must follow the poses, and the force must be in the frame of the poses."""
    server = serve("--frame", frame, "--rate", "0.001", "--motor-off")
    peer = Peer(server)
    if frame == "ras":
        poses = [FLIP @ pose @ FLIP for pose in poses]
    for matrix in poses[:90]:
        for _ in range(20):
            peer.send(moved(matrix))
            answer = [peer.until(name) for name in ("CutterToBone", "HandForce", "HandTorque", "ContactForce")]
    assert [len(m.values) for m in answer[1:]] == [3, 3, 1]
    assert [m.unit for m in answer[1:]] == [openigtlink.NEWTON, openigtlink.NEWTON_METRE, openigtlink.NEWTON]
    axis = poses[0][:3, :3] @ [0, 0, 1]  # away from the bone, since the tool works towards -z
    force, tool = np.array(answer[1].values), answer[0].matrix
    assert force @ axis > 0.9 * np.linalg.norm(force) > 0.1 and answer[3].values[0] > 1
    behind = (tool[:3, 3] - poses[89][:3, 3]) @ axis  # the motor is off, so the bone stops the tool before the pose
    assert 0.1 < behind < 10 and np.abs(tool[:3, :3] @ [0, 0, 1] - axis).max() < 0.1
    times = [m.timestamp for m in answer]
    assert max(times) - min(times) < 1e-6 and abs(times[0] - time.time()) < 60
    assert " 0 voxels removed" in server.end()


def test_hostile_data(serve):
    server = serve()
    peer = Peer(server)
    peer.send(moved(FAR))
    peer.until("HandForce")
    memory = server.memory_kb()
    good = moved(FAR)

    def refused(data, line, last=""):
        other = Peer(server)
        other.send(data)
        server.wait_for(line)
        other.socket.shutdown(socket.SHUT_WR)
        if last:
            server.wait_for(last)
        other.close()

    nan, mirrored, scaled, away = (np.eye(4) for _ in range(4))
    nan[0, 3], mirrored[0, 0], scaled[:3, :3], away[0, 3] = np.nan, -1, 2 * np.eye(3), 1e5
    refused(moved(nan), "the matrix contains NaN")
    refused(moved(mirrored), "is not a rotation and a translation")
    refused(moved(scaled) * 5000, "is not a rotation and a translation",
            "closed: by the client (5000 refused)")  # counted, and reported in one line
    refused(moved(away), "TRANSFORM ToolToBone: ")
    refused(good[:-1] + b"\x55", "the CRC is wrong")
    refused(moved(FAR, "Other"), "TRANSFORM Other: expected TRANSFORM ToolToBone or STRING Motor")
    refused(text("Motor", "fast"), "'fast': expected on or off")
    body = b"\0\x05\xff"
    header = _openigtlink.HEADER.pack(1, b"STRING", b"Motor", 0, len(body), igtl.CRC64(body))
    refused(header + body, "STRING Motor: cannot be read")
    refused(_openigtlink.HEADER.pack(2, b"TRANSFORM", b"ToolToBone", 0, 3, igtl.CRC64(b"abc")) + b"abc",
            "TRANSFORM ToolToBone: cannot be read")
    refused(_openigtlink.HEADER.pack(1, b"TRANSFORM", b"ToolToBone", 0, 1 << 62, 0), f"a message of {1 << 62} bytes")
    refused(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n" + bytes(40), "not an OpenIGTLink message")
    image = igtl.ImageMessage(np.zeros((200, 400, 400), np.int16), device_name="CT").pack()  # 64 MB: skipped, not stored
    other = Peer(server)
    other.send(image, text("Motor", "fast"))
    server.wait_for("IMAGE CT: a message of 64000072 bytes")
    server.wait_for("expected on or off", 2)
    other.close()
    half = Peer(server)  # a client that stops in the middle of a message
    half.send(good[:40])
    rng = random.Random(1)
    for _ in range(200):
        data = bytearray(good * 2)
        for _ in range(rng.randrange(1, 6)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        other = Peer(server)
        try:
            other.send(bytes(data[:rng.randrange(1, len(data) + 1)]))
            other.socket.shutdown(socket.SHUT_WR)
            while other.socket.recv(1 << 16):
                pass
        except OSError:
            pass
        other.close()
    peer.send(moved(FAR))
    peer.until("HandForce")
    assert server.memory_kb() - memory < 20_000
    assert not server.lines("clients are connected") and not server.lines("Traceback")
    assert " 0 voxels removed" in server.end()


def test_two_clients(serve):
    server = serve("--silent", "500")
    first, second = Peer(server), Peer(server)
    first.send(moved(FAR))
    first.until("HandForce")
    server.wait_for("moves the tool")
    # the first client moves the tool until the second client is refused
    until = time.monotonic() + 60
    while not server.lines("moves the tool; it is ignored"):
        assert time.monotonic() < until
        first.send(moved(FAR))
        second.send(moved(FAR), text("Motor", "off"))
        time.sleep(0.01)
    assert len(server.lines("moves the tool; it is ignored")) == 1
    # after the first client has sent nothing for 500 ms, the motor must stop, and the second client may move the tool
    assert first.event("silent")["t_s"] > 0
    first.until_motor(False)
    second.send(moved(FAR))
    server.wait_for("moves the tool", 3)
    first.until_motor(True, second)
    # when the client disconnects, the motor must stop
    second.close()
    first.until_motor(False)
    first.send(moved(FAR))
    server.wait_for("moves the tool", 4)
    first.send(text("Motor", "off"))
    first.until_motor(False, first)
    first.send(text("Motor", "on"))
    first.until_motor(True, first)
    many = [Peer(server) for _ in range(openigtlink.MAX_CLIENTS)]
    server.wait_for(f"refused, because {openigtlink.MAX_CLIENTS} clients are connected")
    for peer in many:
        peer.close()
    server.end()


def test_jump_removes_nothing(serve, poses):
    server = serve("--frame", "lps", "--force", "off")
    there, back = poses[80].copy(), poses[80].copy()
    axis = there[:3, :3] @ [0, 0, 1]
    there[:3, 3] += 60 * axis   # outside the bone
    back[:3, 3] -= 60 * axis    # on the other side
    peer = Peer(server)
    for matrix in (there, back, there):
        for _ in range(100):
            peer.send(moved(matrix))
            tool = peer.until("CutterToBone").matrix
        assert np.abs(tool[:3, 3] - matrix[:3, 3]).max() < 0.01
    assert len(server.lines("the pose jumped")) == 1
    assert " 0 voxels removed, " in server.end()


def test_client_that_does_not_read(serve, poses):
    server = serve("--frame", "lps", "--rate", "1000", "--image-rate", "100")
    slow, peer = Peer(server), Peer(server)
    slow.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    memory, number = server.memory_kb(), 0
    until = time.monotonic() + 60
    while not server.lines("does not read fast enough"):
        assert time.monotonic() < until
        peer.send(moved(poses[number % len(poses)]))
        peer.until("HandForce")
        number += 1
    assert server.memory_kb() - memory < 20_000
    server.end()


def test_bytes_of_sensor_message():
    """The expected layout is that of SENSOR and UNIT in the specification of OpenIGTLink 3."""
    packed = openigtlink.SensorMessage([1.5, -2.0, 0.0], openigtlink.NEWTON_METRE, 3.0, "HandTorque").pack()
    assert packed[:2] == b"\0\1" and packed[2:14] == b"SENSOR\0\0\0\0\0\0"
    assert packed[14:34] == b"HandTorque" + bytes(10) and packed[34:42] == b"\0\0\0\3\0\0\0\0"
    assert packed[42:50] == struct.pack(">Q", 34)
    # prefix 0000, newton 001011 to the power 0001, metre 000001 to the power 0001
    unit = int("0000" "001011" "0001" "000001" "0001" + "0" * 40, 2)
    assert packed[58:] == struct.pack(">BBQ3d", 3, 0, unit, 1.5, -2.0, 0.0)
    assert openigtlink.NEWTON == int("0000" "001011" "0001" + "0" * 50, 2)


def test_errors(serve, tmp_path, inputs):
    server = serve()

    def fails(status, part, *options):
        done = subprocess.run([sys.executable, "-m", "osteon.openigtlink", *map(str, options)], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, check=False, timeout=60,
                              env=dict(os.environ))
        assert done.returncode == status and part in done.stderr and "Traceback" not in done.stderr
        assert not done.stdout

    both = ("--bone", inputs / "ct.nrrd", "--tool", inputs / "reamer.stl")
    fails(2, "cannot listen on this address", *both, "--port", server.port)
    fails(2, "nothing.nrrd", "--bone", tmp_path / "nothing.nrrd", "--tool", inputs / "reamer.stl", "--port", 0)
    fails(2, "--rate", *both, "--rate", "0", "--port", 0)
    fails(2, "motor speed of -5", *both, "--rpm", "-5", "--port", 0)
    fails(2, "the following arguments are required: --bone, --tool")
    assert server.end()
