"""What workers of the live page do in tests; they are started by name in another process."""

import itertools
from time import sleep


def count_for_ever(channel):
    for _ in itertools.count():
        pass


def fill_memory(channel):
    kept = []
    while True:
        kept.append(bytearray(50_000_000))


class Scripted:
    """A model that is built after so many seconds, or needs more memory than there is."""

    gap = 1e-3

    def __init__(self, seconds, error=""):
        self.seconds, self.error = seconds, error

    def built(self, values):
        sleep(self.seconds)
        if self.error == "memory":
            raise MemoryError
        from evidence.scenes.small import stack

        return stack(1)
