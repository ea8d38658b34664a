"""Functions that a process of its own is to survive or to die of."""

import os
import signal
import sys
import tempfile
import time


def double(number):
    print("what a library prints")
    sys.stdout.flush()
    os.write(1, b"what C prints")
    return 2 * number


def fail(text):
    raise KeyError(text)


def unpicklable():
    return lambda: None


def crash():
    os.kill(os.getpid(), signal.SIGSEGV)


def leave():
    os._exit(7)


def hang():
    while True:
        time.sleep(60)


def allocate(size):
    return len(bytearray(size))


def fill_disk(size):
    with tempfile.TemporaryFile() as file:
        file.write(bytes(size))


def write_garbage():
    for stream in range(3, 12):  # one of them carries the answers
        try:
            os.write(stream, b"garbage\n")
        except OSError:
            pass


def temporary_file():
    handle, path = tempfile.mkstemp()
    os.close(handle)
    return path


def own_id():
    return os.getpid()
