"""What workers of the live page do in tests; they are started by name in another process."""

import itertools


def count_for_ever(channel):
    for _ in itertools.count():
        pass


def fill_memory(channel):
    kept = []
    while True:
        kept.append(bytearray(50_000_000))
