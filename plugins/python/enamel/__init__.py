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
"""Folder of the devices, scenes, meshes and servos that come with the package."""


class PythonRenderer:
    """A renderer in Python, for experiments. It is not for real time: some 10 us a tick, and the interpreter may pause.

    Derive a class from it, and pass the class, or any callable that makes an object of it, to push(), study(), judge()
    or trials(). An exception in one of its methods ends them. A recording cannot store its state.
    """

    needs_inertia = False
    """Whether render() reads the joint-space inertia. Ticks compute it only then."""

    def activate(self, period):
        """Prepare for ticks of `period` s."""

    def reset(self):
        """Return to the state after activate(). Also called at every tick at which the guard lets no torque through."""

    def render(self, tick):
        """Return the torque of every joint, (n,), N m or N, with gravity. Motors limit it to their largest torque."""
        raise NotImplementedError


RendererLike = _Union[Renderer, _Callable[[], _Union[Renderer, PythonRenderer]]]  # noqa: F405
"""Type of a renderer for push(), study(), judge() and trials()."""
