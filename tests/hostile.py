"""Everything that a master's peers should not do, all at once: `hostile.py HOST:PORT FINGERPRINT [KIND]`.

Each kind has a process of its own, so that none keeps the others from being what they are. Says `ready` once all are at
it, and ends with its standard input. Needs grpcio.
"""

import contextlib
import itertools
import os
import random
import socket
import struct
import subprocess
import sys
import threading
import time

import grpc

ADDRESS, FINGERPRINT, *KIND = sys.argv[1:]
HOST, PORT = ADDRESS.rsplit(":", 1)
METHOD = "/selftalk.v1.Evaluation/Work"
PROTOCOL = 1


def varint(number):
    out = b""
    while number > 0x7F:
        out += bytes([number & 0x7F | 0x80])
        number >>= 7
    return out + bytes([number])


def text(number, value):
    return varint(number << 3 | 2) + varint(len(value)) + value


def integer(number, value):
    return varint(number << 3) + varint(value)


def hello(name):
    body = integer(1, PROTOCOL) + text(2, b"0.0.0") + text(3, FINGERPRINT.encode()) + text(4, name.encode())
    body += integer(5, os.getpid()) + integer(6, 1) + varint(7 << 3 | 1) + struct.pack("<Q", random.getrandbits(64))
    return text(1, body)


HEARTBEAT = text(2, b"")


@contextlib.contextmanager
def call(messages):
    """A stream to the master, of bytes as they are."""
    with grpc.insecure_channel(ADDRESS) as channel:
        yield channel.stream_stream(METHOD, request_serializer=bytes, response_deserializer=bytes)(messages)


def silent():
    """Connections on which nothing is said."""
    sockets = [socket.create_connection((HOST, int(PORT))) for _ in range(200)]
    yield
    for one in sockets:
        one.recv(1)


def garbage():
    """Bytes that are no HTTP."""
    for attempt in itertools.count():
        with contextlib.suppress(OSError), socket.create_connection((HOST, int(PORT))) as one:
            one.sendall(random.randbytes(100_000))
            while one.recv(4096):
                pass
        if attempt == 20:
            yield


def nonsense():
    """Messages that are none."""
    for attempt in itertools.count():
        with contextlib.suppress(grpc.RpcError), call(iter([random.randbytes(50) for _ in range(10)])) as responses:
            for _ in responses:
                pass
        if attempt == 20:
            yield


def huge():
    """A message that is too long."""
    for _ in range(5):
        with contextlib.suppress(grpc.RpcError), call(iter([hello("huge") + text(15, bytes(5_000_000))])) as responses:
            for _ in responses:
                pass
    yield


def flood():
    """A worker that says that it is alive, and nothing else, as fast as it can."""
    with call(itertools.chain([hello("flood")], itertools.repeat(HEARTBEAT))) as responses:
        next(responses)
        yield
        for _ in responses:
            pass


@contextlib.contextmanager
def alive(name):
    """The stream of a worker that says every half second that it is alive."""

    def beats():
        yield hello(name)
        while True:
            time.sleep(0.5)
            yield HEARTBEAT

    with call(beats()) as responses:
        next(responses)
        yield responses


def hang():
    """A worker that is alive and does nothing."""
    with alive("hang") as responses:
        yield
        for _ in responses:
            pass


def stall():
    """The same, and does not even listen."""
    with alive("stall") as responses:
        yield
        while responses.is_active():
            time.sleep(0.5)


KINDS = {kind.__name__: kind for kind in [silent, garbage, nonsense, huge, flood, hang, stall]}


def play(kind):
    """Is at it until it is cut off."""
    steps = KINDS[kind]()
    next(steps, None)
    print("ready", flush=True)
    with contextlib.suppress(OSError, grpc.RpcError):
        for _ in steps:
            pass


def start(kind):
    return subprocess.Popen([sys.executable, __file__, ADDRESS, FINGERPRINT, kind], stdout=subprocess.PIPE)


if KIND:
    threading.Thread(target=play, args=KIND, daemon=True).start()
else:
    peers = [start(kind) for kind in KINDS]
    if not all(peer.stdout.readline() == b"ready\n" for peer in peers):
        sys.exit("a peer ended before it was at it")
    print("ready", flush=True)
# Until the test has seen enough, which closes it for all of them.
sys.stdin.read()
os._exit(0)
