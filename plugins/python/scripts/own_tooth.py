"""Your own tooth: load a mesh file, find where a bur touches it, and push against it.

    python own_tooth.py [MESH.ply|obj|stl|off [mm per unit of the file]]
"""
import sys

import numpy as np

import enamel

path = sys.argv[1] if len(sys.argv) > 1 else enamel.data / "meshes/molar.ply"
vertices, triangles = enamel.load_mesh(path, 1e-3 * (float(sys.argv[2]) if len(sys.argv) > 2 else 1.0))
low, high = vertices.min(axis=0), vertices.max(axis=0)
middle = 0.5 * (low + high)

scene = enamel.Scene()
scene.set_tool([((0, 0, 0.6e-3), (0, 0, 0.6e-3), 0.6e-3), ((0, 0, 1.2e-3), (0, 0, 20e-3), 0.4e-3)])  # ball, shaft
tooth = scene.add_mesh("tooth", vertices, triangles, position=-middle, friction=0.2)
print(scene.describe(tooth))

# A height map: lower the bur at all places in steps that are certainly free, until it is 10 um inside.
x, y = np.meshgrid(np.linspace(low[0], high[0], 25) - middle[0], np.linspace(low[1], high[1], 25) - middle[1])
places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, high[2] - middle[2] + 1e-3)])
for _ in range(60):
    places[:, 2] -= np.minimum(1e-3, scene.nearest(places)["gap"] + 10e-6)
contacts = scene.contacts(places, margin=0.0)
touching = np.unique(contacts["pose"])
print(f"{touching.size} of {len(places)} places touch, with {len(contacts)} contacts")
assert touching.size > 100 and (contacts["gap"] < 0.0).all()
assert np.allclose(np.linalg.norm(contacts["normal"], axis=1), 1.0)

device = enamel.Device(enamel.data / "devices/tau-nominal.toml")
scene.start = (0.0, 0.0, high[2] - middle[2] + 2e-3)
push = enamel.push(device, enamel.position_control(device), scene=scene, force=5.0, noise=0.0, duration=1.5)
rest = push.ticks[-1]
print(f"pushed with 5 N: {-1e6 * rest['gap']:.1f} um deep, the tooth pushes back with {rest['normal_force']:.2f} N")
assert push.stopped is None and 2.0 < rest["normal_force"] < 6.0
