"""Everything that a master's peers should not do, all at once: `hostile.py HOST:PORT FINGERPRINT`.

Says `ready` once all are at it, and how each ended: what is cut off has got what it deserves. Needs grpcio.
"""

import itertools
import os
import random
import socket
import struct
import sys
import threading
import time

import grpc

ADDRESS, FINGERPRINT = sys.argv[1:]
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


def call(messages):
    """A stream to the master, of bytes as they are."""
    channel = grpc.insecure_channel(ADDRESS)
    return channel.stream_stream(METHOD, request_serializer=bytes, response_deserializer=bytes)(messages)


def silent():
    """Connections on which nothing is said."""
    sockets = [socket.create_connection((HOST, int(PORT))) for _ in range(200)]
    yield
    for one in sockets:
        one.recv(1)


def garbage():
    """Bytes that are no HTTP."""
    for attempt in itertools.count():
        with socket.create_connection((HOST, int(PORT))) as one:
            try:
                one.sendall(random.randbytes(100_000))
                while one.recv(4096):
                    pass
            except OSError:
                pass
        if attempt == 20:
            yield


def nonsense():
    """Messages that are none."""
    for attempt in itertools.count():
        try:
            for _ in call(iter([random.randbytes(50) for _ in range(10)])):
                pass
        except grpc.RpcError:
            pass
        if attempt == 20:
            yield


def huge():
    """A message that is too long."""
    for attempt in range(5):
        try:
            for _ in call(iter([hello("huge") + text(15, bytes(5_000_000))])):
                pass
        except grpc.RpcError:
            pass
    yield


def flood():
    """A worker that says that it is alive, and nothing else, as fast as it can."""
    responses = call(itertools.chain([hello("flood")], itertools.repeat(HEARTBEAT)))
    next(responses)
    yield
    for _ in responses:
        pass


def alive(name):
    """The stream of a worker that says every half second that it is alive."""

    def beats():
        yield hello(name)
        while True:
            time.sleep(0.5)
            yield HEARTBEAT

    responses = call(beats())
    next(responses)
    return responses


def hang():
    """A worker that is alive and does nothing."""
    responses = alive("hang")
    yield
    for _ in responses:
        pass


def stall():
    """The same, and does not even listen."""
    responses = alive("stall")
    yield
    while responses.is_active():
        time.sleep(0.5)


def play(kind, ready):
    steps = kind()
    next(steps, None)
    ready.release()
    try:
        for _ in steps:
            pass
    except (OSError, grpc.RpcError):
        pass
    print(f"{kind.__name__}: cut off", flush=True)


KINDS = [silent, garbage, nonsense, huge, flood, hang, stall]
READY = threading.Semaphore(0)
for each in KINDS:
    threading.Thread(target=play, args=(each, READY), daemon=True).start()
for _ in KINDS:
    READY.acquire()
print("ready", flush=True)
# Until the test has seen enough.
sys.stdin.read()
os._exit(0)
