"""Print the microseconds per pose of a batch of 1000 contact queries, for each named scene: best of 30 batches."""
import sys
import time

import numpy as np

import enamel

for path in sys.argv[1:]:
    scene = enamel.Scene(path)
    low = scene.start.copy()
    for _ in range(100):  # move down until it is 0.1 mm inside
        low[2] -= min(1e-3, scene.nearest(low[None])["gap"][0] + 0.1e-3)
    places = low + np.arange(1000)[:, None] * np.array([1e-6, 0.0, 0.0])
    best = 1e9
    for _ in range(30):
        begin = time.perf_counter()
        contacts = scene.contacts(places)
        best = min(best, time.perf_counter() - begin)
    print(1e6 * best / len(places), len(contacts))
