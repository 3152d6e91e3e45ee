"""Tasks for the processes of a pool: good ones and murderous ones."""

import os
import signal
import time
import warnings

from blockstat.errors import InputError, InputWarning


def mixed(number):
    """Fail in the way of the number."""
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    if number == 2:
        os.kill(os.getpid(), signal.SIGSEGV)
    if number == 3:
        time.sleep(60)
    if number == 4:
        os._exit(3)
    if number == 5:
        raise ValueError("five")
    if number == 6:
        os.system("echo noise on standard output")
    return 10 * number


def slow(seconds):
    time.sleep(seconds)
    return seconds


def warned(text):
    warnings.warn(InputWarning(text), stacklevel=2)
    return text


def refused(*_, **__):
    raise InputError("the engine is out of order")


def fragile(task):
    """The process that did it; in any but the caller's it may die of the task."""
    caller, what = task
    if what == "dies" and os.getpid() != caller:
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "fails":
        raise ValueError("it fails")
    return os.getpid()


class DiesWhenMoved:
    """An action that ends its process as soon as a block has moved by 10 mm."""

    each_step = False

    def begin(self, world):
        pass

    def act(self, world, time):
        if abs(world.poses()[0]).max() > 0.01:
            os._exit(3)


class Warns:
    """An action that warns at its beginning, and ends its process there if it is told to."""

    each_step = False

    def __init__(self, text, dies=False):
        self.text, self.dies = text, dies

    def begin(self, world):
        warnings.warn(InputWarning(self.text), stacklevel=2)
        if self.dies:
            os._exit(4)

    def act(self, world, time):
        pass
