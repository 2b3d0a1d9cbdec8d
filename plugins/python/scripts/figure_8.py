"""The paper's figure 8: one push of 12 N with its controller and with the spring, tick by tick, and then a study over the wall.

    python figure_8.py [PICTURE.png]     # the picture needs matplotlib
"""
import sys

import numpy as np

import enamel

device = enamel.Device(enamel.data / "devices/tau-nominal.toml")
damped = device.damped([0.0, 0.0, 4.0, 0.0, 0.0, 0.0])  # the paper's spring has 4 N s/m
pushes = {
    "hold": enamel.push(device, enamel.hold(device, release=False)),
    "impedance": enamel.push(damped, enamel.impedance(6000.0)),
}
for name, push in pushes.items():
    after = push.ticks[push.ticks["time"] >= 1.0]
    stiffness = push.metrics["K_z1"]
    assert stiffness is not None, push.verdict
    print(f"{name:10} first impact {1e-3 * stiffness:6.2f} kN/m, deepest {-1e3 * after['gap'].min():.3f} mm")

study = enamel.study(
    device,
    {"hold": enamel.hold(device, release=False), "impedance": (enamel.impedance(6000.0), damped)},
    grid=3,
    runs=2,
)
lowest = {(wall["scenario"], wall["renderer"]): wall["lowest K_z1"] for wall in study.walls}
print(f"over the wall: hold {1e-3 * lowest[1, 'hold']:.1f} kN/m at least, spring {1e-3 * lowest[1, 'impedance']:.2f}")
assert lowest[1, "hold"] > 5.0 * lowest[1, "impedance"]  # the paper's finding
assert np.isnan(study.runs["K_z1"][study.runs["scenario"] == 2]).all()  # no step, no first impact

if len(sys.argv) > 1:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    for name, push in pushes.items():
        plt.plot(push.ticks["time"], -1e3 * push.ticks["gap"], label=name)
    plt.xlim(0.9, 1.6)
    plt.xlabel("time [s]")
    plt.ylabel("depth [mm]")
    plt.legend()
    plt.savefig(sys.argv[1])
