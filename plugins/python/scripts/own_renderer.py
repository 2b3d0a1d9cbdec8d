"""Your own renderer, compared with two others. A renderer in Python is for experiments, not for real time."""
import numpy as np
import numpy.typing as npt

import enamel


class Nonlinear(enamel.PythonRenderer):
    """A spring that stiffens with depth, f = k d + c d^2, with a damper that acts while the tool moves in."""

    def __init__(self, stiffness: float = 3000.0, growth: float = 2e6, damping: float = 4.0) -> None:
        self.stiffness, self.growth, self.damping = stiffness, growth, damping

    def render(self, tick: enamel.Tick) -> npt.ArrayLike:
        k = tick.kinematics
        wrench = np.zeros(6)
        for contact in tick.contacts[tick.contacts["gap"] < 0.0]:
            normal, arm = contact["normal"], contact["point"] - k.position
            speed = normal @ (k.twist[:3] + np.cross(k.twist[3:], arm))
            depth = -contact["gap"]
            force = self.stiffness * depth + self.growth * depth**2 + self.damping * max(0.0, -speed)
            wrench += force * np.concatenate([normal, np.cross(arm, normal)])
        torque: npt.NDArray[np.float64] = k.gravity + k.jacobian.T @ wrench
        return torque


device = enamel.Device(enamel.data / "devices/tau-nominal.toml").damped([0.0, 0.0, 4.0, 0.0, 0.0, 0.0])
renderers: dict[str, enamel.RendererLike] = {
    "own": Nonlinear,
    "spring": enamel.impedance(3000.0),
    "position control": enamel.position_control(device),
}
for name, renderer in renderers.items():
    push = enamel.push(device, renderer, noise=0.0, duration=1.6)
    assert push.stopped is None
    score = enamel.judge(device, renderer, runs=2)
    stiffness = push.metrics["K_z1"]
    assert stiffness is not None, push.verdict
    print(
        f"{name:17} one push {1e-3 * stiffness:7.2f} kN/m; judged {1e-3 * score['stiffness']:7.2f} kN/m, "
        f"chatter {score['chatter']:.3f} N m, {score['lost']} runs lost"
    )

# An exception in a renderer ends the push.
class Broken(enamel.PythonRenderer):
    def render(self, tick: enamel.Tick) -> npt.ArrayLike:
        raise ValueError(f"no idea at {tick.time} s")


try:
    enamel.push(device, Broken)
except ValueError as error:
    print("the broken one:", error)
else:
    raise AssertionError("the exception was lost")
