#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the OpenIGTLink server of the Python package on the loopback address.

    PYTHON bench/python_openigtlink.py [SECONDS]         the packages osteon and pyigtl must be installed

The server runs in a process of its own; the poses ream a generated glenoid. Three clients run one after another, each
for SECONDS (default 5):

    one by one     sends a pose and waits for the answer, with sockets of its own
    pyigtl         the same with the client of pyigtl, whose thread waits up to 10 ms for a message before it sends
    as fast as possible   sends poses without waiting; a thread reads the answers

The last lines are the server's report, with the missed deadlines of the servo loop, and the time of the same loop
without clients.
"""
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
import pyigtl
from pyigtl.messages import message_type_to_class_constructor

import osteon
from osteon.openigtlink import SensorMessage

FLIP = np.diag([-1.0, -1.0, 1.0, 1.0])


def poses_of(bone, tool):
    """Returns the matrices (RAS, millimetres) of a tool that a surgeon moves slowly to ream."""
    path = osteon.Path.builtin("glenoid-slow", osteon.Glenoid.of_meta(bone.meta), tool)
    return [FLIP @ pose.matrix_mm() @ FLIP for pose in path.poses()[::10]]


def message(matrix):
    return pyigtl.TransformMessage(matrix, device_name="ToolToBone")


def answer(connection, data):
    """Reads data until the end of the server's answer. The last message of an answer is ContactForce."""
    while b"ContactForce" not in data:
        data = data[-100:] + connection.recv(1 << 16)


def one_by_one(port, poses, seconds):
    """Returns the times of round trips in microseconds."""
    packed, times, number = [message(m).pack() for m in poses], [], 0
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            begin = time.perf_counter()
            connection.sendall(packed[number % len(packed)])
            answer(connection, b"")
            times.append((time.perf_counter() - begin) * 1e6)
            number += 1
    return sorted(times)


def by_pyigtl(port, poses, seconds):
    """Returns the times of round trips in microseconds."""
    message_type_to_class_constructor["SENSOR"] = SensorMessage
    client, times, number = pyigtl.OpenIGTLinkClient("127.0.0.1", port), [], 0
    while not client.is_connected():
        time.sleep(0.01)
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        client.get_latest_messages()
        begin = time.perf_counter()
        client.send_message(message(poses[number % len(poses)]))
        client.wait_for_message("ContactForce", timeout=5)
        times.append((time.perf_counter() - begin) * 1e6)
        number += 1
    client.stop()
    return sorted(times)


def as_fast_as_possible(port, poses, seconds):
    """Returns the number of poses per second."""
    packed = [message(m).pack() for m in poses]
    with socket.create_connection(("127.0.0.1", port)) as connection:
        def read():
            while connection.recv(1 << 16):
                pass

        thread = threading.Thread(target=read)
        thread.start()
        begin, number = time.perf_counter(), 0
        while time.perf_counter() < begin + seconds:
            connection.sendall(packed[number % len(packed)])
            number += 1
        connection.shutdown(socket.SHUT_WR)
        thread.join()  # the server closes the connection after the last pose
        return number / (time.perf_counter() - begin)


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5
    with osteon.Backend() as backend, tempfile.TemporaryDirectory() as folder:
        bone = backend.bone(osteon.phantom.ct("glenoid"))
        tool = backend.voxelize(osteon.phantom.tool("reamer"))
        poses = poses_of(bone, tool)
        files = [os.path.join(folder, name) for name in ("bone.nrrd", "tool.nrrd")]
        bone.write(files[0])
        tool.write(files[1])
        serve = [sys.executable, "-m", "osteon.openigtlink", "--bone", files[0], "--tool", files[1], "--port", "0"]
        with subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              universal_newlines=True) as server:
            port = int(server.stdout.readline().rsplit(":", 1)[1])
            for name, run in (("one by one", one_by_one), ("pyigtl", by_pyigtl)):
                times = run(port, poses, seconds)
                print(f"{name:22}{times[len(times) // 2]:9.0f} us median{times[len(times) * 99 // 100]:9.0f} us at 99 %"
                      f"{times[-1]:9.0f} us at most{len(times) / seconds:9.0f} poses/s", flush=True)
                time.sleep(1.5)  # the next client can move the tool
            print(f"{'as fast as possible':22}{as_fast_as_possible(port, poses, seconds):9.0f} poses/s", flush=True)
            server.send_signal(signal.SIGTERM)
            print("the server: " + server.communicate()[0].strip())
        alone = subprocess.run(serve + ["--seconds", str(seconds)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                               universal_newlines=True, check=True)
        print("without clients: " + alone.stdout.strip().splitlines()[-1])


if __name__ == "__main__":
    main()
