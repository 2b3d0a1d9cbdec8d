"""Stiff contact on haptic devices: Enamel in Python.

SI units. World frame W: x right, y up, z from the wall towards the user, origin at the centre of the workspace. A twist
is [v; w], a wrench [f; m]; both are at the TCP and in the axes of W.

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
"""Folder of the devices, scenes, meshes and servos in the package."""


class PythonRenderer:
    """A renderer in Python for experiments, not for real time: a tick takes about 10 us, and the interpreter may pause.

    Derive from this class. Pass the derived class, or any callable that returns an instance, to push(), study(),
    judge() or trials(). An exception in one of its methods ends that call. A recording cannot store its state.
    """

    needs_inertia = False
    """True if render() reads the joint-space inertia: ticks then compute it."""

    def activate(self, period):
        """Prepare for ticks of `period` s."""

    def reset(self):
        """Return to the state after activate(). Also called at every tick in which the guard blocks all forces."""

    def render(self, tick):
        """Return the torque of every joint, (n,), N m or N, with gravity. It is cut to the motors' limits."""
        raise NotImplementedError


RendererLike = _Union[Renderer, _Callable[[], _Union[Renderer, PythonRenderer]]]  # noqa: F405
"""Types of renderers that push(), study(), judge() and trials() accept."""
