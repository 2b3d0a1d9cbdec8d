"""Stiff contact on haptic devices: Enamel in Python.

SI units. World frame W: x right, y up, z from the wall towards the user, origin at the centre of the workspace. A twist
is [v; w], a wrench [f; m]: both at the TCP and in the axes of W.

Five lines plot a push:

    import enamel, matplotlib.pyplot as plt
    device = enamel.Device(enamel.data / "devices/tau-nominal.toml")
    ticks = enamel.push(device, enamel.position_control(device)).ticks
    plt.plot(ticks["time"], 1e3 * ticks["gap"])
    plt.show()
"""
from pathlib import Path as _Path
from typing import Callable as _Callable, Union as _Union

from ._enamel import *  # noqa: F401,F403
from ._enamel import __doc__ as _doc  # noqa: F401

data = _Path(__file__).parent / "data"
"""Folder of the devices, scenes, meshes and servos that come with the package."""


class PythonRenderer:
    """A renderer in Python, for experiments: not for real time (some 10 us a tick, and the interpreter may pause).

    Derive from it, and hand the class, or any callable that makes one, to push(), study(), judge() or trials(). What
    one of its methods raises ends them with that exception. It has no state that a recording could keep.
    """

    needs_inertia = False
    """Whether render() reads the joint-space inertia: ticks then compute it."""

    def activate(self, period):
        """Prepares for ticks of `period` s."""

    def reset(self):
        """Back to the state after activate(). Also called at every tick at which the guard lets nothing through."""

    def render(self, tick):
        """The torque of every joint, (n,), N m or N, gravity included. What is beyond a motor's limit is cut."""
        raise NotImplementedError


RendererLike = _Union[Renderer, _Callable[[], _Union[Renderer, PythonRenderer]]]  # noqa: F405
"""What push(), study(), judge() and trials() take for a renderer."""
