"""The Python module gives the results of the command-line tool, and errors as exceptions.

ctest runs it with PYTHONPATH at the package; ENAMEL_TOOL, if set, is the built command-line tool.
"""
import inspect
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import enamel

TAU = enamel.data / "devices/tau-nominal.toml"
TOOL = os.environ.get("ENAMEL_TOOL")


class Devices(unittest.TestCase):
    def test_kinematics_there_and_back(self):
        for file in sorted((enamel.data / "devices").glob("*.toml")):
            device = enamel.Device(file)
            there = device.reach([0.004, -0.003, 0.002])
            back = device.track(there.q)
            np.testing.assert_allclose(back.position, [0.004, -0.003, 0.002], atol=1e-12)
            rates = np.linspace(-1.0, 1.0, device.joints)
            moving = device.track(there.q, rates)
            np.testing.assert_allclose(moving.twist, moving.jacobian @ rates, atol=1e-12)
            # At rest, gravity's torque gives zero acceleration.
            rest = device.accelerate([0.004, -0.003, 0.002], there.gravity)
            np.testing.assert_allclose(rest, 0.0, atol=1e-9)

    def test_arrays_look_into_the_object(self):
        home = enamel.Device(TAU).home
        for name in ("q", "jacobian", "inertia", "position", "rotation"):
            array = getattr(home, name)
            self.assertFalse(array.flags.owndata or array.flags.writeable, name)
            self.assertEqual(array.ctypes.data, getattr(home, name).ctypes.data)
        self.assertEqual(home.jacobian.shape, (6, 6))

    def test_errors_are_exceptions_with_the_librarys_words(self):
        with self.assertRaises(enamel.ConfigurationError) as caught:
            enamel.Device.parse('name = "x"\nkind = "lever"\n', "lever.toml")
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.key), ("lever.toml", 2, "kind"))
        self.assertIn("lever.toml:2: kind", str(caught.exception))
        self.assertIsInstance(caught.exception, enamel.Error)
        device = enamel.Device(TAU)
        with self.assertRaisesRegex(enamel.Error, "inverse kinematics: "):
            device.reach([1.0, 0.0, 0.0])
        with self.assertRaisesRegex(ValueError, r"position has the shape \(2,\), must be \(3,\), m"):
            device.reach([1.0, 0.0])
        with self.assertRaisesRegex(enamel.Error, "duration is -1"):
            enamel.push(device, enamel.impedance(), duration=-1.0)
        with self.assertRaisesRegex(enamel.Error, "unknown plant \"wood\": must be closed-form"):
            enamel.push(device, enamel.impedance(), plant="wood")
        with self.assertRaises(enamel.DesignError):
            enamel.design_servo(device, torque=-1.0)
        with self.assertRaises(enamel.PluginError):
            enamel.plugin(TAU)
        with self.assertRaises(TypeError):
            enamel.push(device, 6000.0)


class Scenes(unittest.TestCase):
    def setUp(self):
        self.scene = enamel.Scene(enamel.data / "scenes/molar.toml")
        rng = np.random.default_rng(1)
        self.places = self.scene.start + rng.uniform(-1.0, 1.0, (500, 3)) * [4e-3, 4e-3, 6e-3]

    def test_old_names_warn(self):
        device = enamel.Device(enamel.data / "devices/tau-detailed.toml")
        with self.assertWarnsRegex(DeprecationWarning, "Device.count: is now called encoder_step"):
            count = device.count
        self.assertTrue((count == device.encoder_step).all())
        push = lambda plant: enamel.push(device, enamel.impedance(), plant=plant, duration=1.1).ticks["gap"]
        with self.assertWarnsRegex(DeprecationWarning, "plant real: is now called imperfect"):
            old = push("real")
        self.assertTrue((old == push("imperfect")).all())

    def test_a_batch_answers_as_pose_by_pose(self):
        together = self.scene.contacts(self.places, margin=2e-3)
        alone = [self.scene.contacts(place[None], margin=2e-3) for place in self.places]
        self.assertGreater(len(together), 50)
        self.assertEqual(len(together), sum(len(a) for a in alone))
        for i, contacts in enumerate(alone):
            of = together[together["pose"] == i].copy()
            of["pose"] = 0
            self.assertEqual(of.tobytes(), contacts.tobytes())
        np.testing.assert_allclose(np.linalg.norm(together["normal"], axis=1), 1.0, atol=1e-12)
        nearest = self.scene.nearest(self.places)
        first = np.unique(together["pose"], return_index=True)[1]
        self.assertTrue((together["gap"][first] == nearest["gap"][together["pose"][first]]).all())

    def test_shapes(self):
        scene = enamel.Scene()
        wall = scene.add_half_space("wall", point=(0, 0, -1), normal=(0, 0, 2))
        ball = scene.add_sphere("ball", (0, 0, 1), 0.25)
        box = scene.add_box("box", (5, 0, 0), (2, 2, 2))
        self.assertEqual((wall, ball, box, scene.obstacles), (0, 1, 2, ["wall", "ball", "box"]))
        near = scene.nearest([[0, 0, 0], [0, 0, 0.5], [5, 0, 1.5]])
        np.testing.assert_allclose(near["gap"], [0.75, 0.25, 0.5])
        self.assertEqual(near["obstacle"].tolist(), [1, 1, 2])
        scene.move(ball, (0, 0, 2), twist=(1, 0, 0, 0, 0, 0))
        moved = scene.nearest([[0, 0, 1.5]])
        np.testing.assert_allclose(moved["gap"], 0.25)
        np.testing.assert_allclose(moved["velocity"][0], [1, 0, 0])
        scene.suspend(box, (1, 1, 1, 0, 0, 0), stiffness=(10, 10, 10, 0, 0, 0), damping=(1, 1, 1, 0, 0, 0), centre=(0, 0, 1))
        with self.assertRaisesRegex(enamel.Error, "suspension must be at least 0"):
            scene.suspend(box, (-1, 1, 1, 0, 0, 0))
        with self.assertRaisesRegex(enamel.Error, "no obstacle 7"):
            scene.suspend(7, (1, 1, 1, 0, 0, 0))
        scene.soften(ball, 1500.0, exponent=1.5, thickness=2e-3, hysteresis=1.0, puncture=3.0)
        with self.assertRaisesRegex(enamel.Error, "an exponent in 1 to 10"):
            scene.soften(ball, 1500.0, exponent=0.5)
        with self.assertRaisesRegex(enamel.Error, "a puncture force needs a thickness"):
            scene.soften(ball, 1500.0, puncture=3.0)
        scene.set_surface(ball, friction=0.4, sliding_friction=0.2, stribeck_speed=0.01, roughness=5e-6, wavelength=3e-4)
        with self.assertRaisesRegex(enamel.Error, "a roughness of 1e-05 m and a wavelength of 3e-04 m"):
            scene.set_surface(ball, roughness=1e-5, wavelength=3e-4)
        with self.assertRaisesRegex(enamel.Error, "sliding friction in 0 to friction"):
            scene.set_surface(ball, friction=0.4, sliding_friction=0.5)
        scene.set_tool("round-010")  # its tip is at the TCP, and its shank is 0.8 mm thick on each side
        np.testing.assert_allclose(scene.nearest([[0, 0, -0.5], [3.9, 0, 0]])["gap"], [0.5, 0.1 - 0.8e-3])
        with self.assertRaisesRegex(enamel.Error, '"round-1" is not a tool'):
            scene.set_tool("round-1")
        scene.set_tap(box, "enamel")
        scene.set_tap(box, (300, 90))
        with self.assertRaisesRegex(enamel.Error, 'must be one of "enamel"'):
            scene.set_tap(box, "wood")
        with self.assertRaisesRegex(enamel.Error, "a frequency of 10 to 1000 Hz"):
            scene.set_tap(box, tap=(5, 90))
        with self.assertRaisesRegex(enamel.Error, "no obstacle 7"):
            scene.set_tap(7, "metal")
        scene.add_line_guide([[0, 0, 0], [0, 0.01, 0]], 200, 1.0, radius=1e-3)
        scene.add_plane_guide((0, 0, 0), (0, 0, 2), 100, 1.0, one_sided=True)
        scene.add_box_guide((0, 0, 0), (1, 1, 1), stiffness=100, max_force=1.0)
        with self.assertRaisesRegex(enamel.Error, "guide 3: the largest force is -1"):
            scene.add_plane_guide((0, 0, 0), (0, 0, 2), 100, -1.0)
        with self.assertRaisesRegex(ValueError, "length of normal is zero"):
            scene.add_plane_guide((0, 0, 0), (0, 0, 0), 100, 1.0)
        with self.assertRaisesRegex(enamel.Error, "guide 3: the line has 0 points"):
            scene.add_line_guide(np.zeros((0, 3)), 200, 1.0)
        with self.assertRaisesRegex(enamel.Error, "ball"):
            scene.add_sphere("ball", (0, 0, 1), 0.25)
        with self.assertRaisesRegex(enamel.Error, "is not a mesh"):
            scene.mesh(wall)

    def test_a_solid_against_a_target(self):
        scene = enamel.Scene(enamel.data / "scenes/slow-bur.toml")
        vertices, triangles = enamel.load_mesh(enamel.data / "meshes/molar.ply", 2.5e-3)
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        corners = (vertices - middle)[triangles]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
        molar = scene.obstacles.index("molar")
        same = scene.compare_cut(molar, vertices, triangles)
        self.assertEqual(same["layers"], ["enamel", "dentine"])
        self.assertEqual((same["planned"].sum(), same["whole"]["over_cut"].sum(), same["is_prepared"].sum()), (0, 0, 0))
        smaller = scene.compare_cut(molar, middle + 0.9 * (vertices - middle), triangles, axis=(0, 0, 2))
        whole, floors, walls = smaller["whole"], smaller["floors"], smaller["walls"]
        np.testing.assert_allclose(whole["under_cut"].sum(), (1.0 - 0.9**3) * volume, rtol=0.005)
        np.testing.assert_array_equal(floors["under_cut"] + walls["under_cut"], whole["under_cut"])
        np.testing.assert_allclose(smaller["planned"], whole["under_cut"])
        self.assertEqual(smaller["removed"].sum(), 0.0)
        distance = smaller["distance"]
        self.assertEqual(len(distance), len(smaller["vertices"]))
        self.assertEqual(distance[smaller["is_prepared"]].max(), whole["highest"])
        self.assertTrue(0.0 < whole["mean"] < whole["p95"] < whole["highest"] < 0.1 * np.abs(corners).max() * 2.0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "molar.solid"
            scene.save_solid(molar, path)
            again = enamel.Scene()
            number = again.add_solid("again", path, position=(0, 0, -0.012))
            self.assertEqual(again.compare_cut(number, vertices, triangles)["distance"].tobytes(), same["distance"].tobytes())
            scene.set_tool([((0, 0, 0), (0, 0, 0), 0.0)])
            self.assertEqual(again.nearest([[0, 0, 0.002]])["gap"], scene.nearest([[0, 0, 0.002]])["gap"])
            path.write_bytes(path.read_bytes()[:-1])
            with self.assertRaisesRegex(enamel.ConfigurationError, "molar.solid: is damaged"):
                again.add_solid("damaged", path)
        with self.assertRaisesRegex(enamel.Error, "must be closed"):
            scene.compare_cut(molar, vertices, triangles[1:])
        with self.assertRaisesRegex(enamel.Error, "is not a solid"):
            enamel.Scene(enamel.data / "scenes/flat-wall.toml").compare_cut(0, vertices, triangles)

    def test_labels_become_a_solid(self):
        far = np.linalg.norm(np.stack(np.meshgrid(*[np.arange(-15, 16)] * 3, indexing="ij")), axis=0)
        labels = (far < 11.5).astype(int) + (far < 7)  # balls of 1.15 and 0.7 mm
        scene = enamel.Scene()
        layers = [("enamel", [1], 3.4e9), ("dentine", [2], 0.6e9)]
        tooth = scene.add_labels("tooth", labels[:, :, 1:], layers, (1e-4, 1e-4, 1e-4), position=(-1.5e-3, -1.5e-3, -1.4e-3))
        # Labels locate a surface to half a voxel.
        np.testing.assert_allclose(scene.nearest([[0, 0, 2e-3], [0, -3e-3, 0]])["gap"], [0.85e-3, 1.85e-3], atol=5e-5)
        tetrahedron = [[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
        self.assertEqual(scene.compare_cut(tooth, *tetrahedron)["layers"], ["enamel", "dentine"])
        for wrong, text in (((labels[0], layers), "labels must have 3 axes"), ((labels, [("pulp", [3], 1e8)]), "pulp")):
            with self.assertRaisesRegex(enamel.Error, text):
                scene.add_labels("wrong", wrong[0], wrong[1], (1e-4, 1e-4, 1e-4))

    def test_meshes_without_copies_and_out_of_their_scene(self):
        vertices, triangles = self.scene.mesh(0)
        self.assertEqual(vertices.ctypes.data, self.scene.mesh(0)[0].ctypes.data)
        copy = vertices.copy()
        del self.scene  # the arrays keep the scene alive
        self.assertTrue((vertices == copy).all())
        self.assertFalse(vertices.flags.writeable)
        again = enamel.Scene()
        again.add_mesh("again", vertices, triangles)
        self.assertTrue((again.mesh(0)[0] == copy).all() and (again.mesh(0)[1] == triangles).all())
        with self.assertRaisesRegex(enamel.Error, "triangle 0"):
            again.add_mesh("bad", vertices[:3], [[0, 1, 7]])

    def test_a_tool_that_is_followed_stays_on_its_side(self):
        sheet = enamel.Scene()
        sheet.set_tool([((0, 0, 0), (0, 0, 0), 0.5e-3)])
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.05
        sheet.add_mesh("sheet", square, [[0, 1, 2], [0, 2, 3]], thickness=0.2e-3)
        down = np.column_stack([np.zeros(60), np.zeros(60), np.linspace(2e-3, -4e-3, 60)])
        followed = sheet.contacts(down, follow=True)
        last = followed[followed["pose"] == 59]
        self.assertEqual(len(last), 1)
        self.assertGreater(last["normal"][0, 2], 0.99)  # pushes back up
        self.assertLess(last["gap"][0], -4e-3)


class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.device = enamel.Device(TAU)

    def test_a_push_is_the_tools_bit_for_bit(self):
        if TOOL is None:
            self.skipTest("no command-line tool beside it")
        with tempfile.TemporaryDirectory() as folder:
            output, recording = Path(folder, "run.csv"), Path(folder, "run.rec")
            subprocess.run([TOOL, "push", "--device", TAU, "--output", output, "--record", recording, "--encoders",
                            "--delay", "constant:1", "--seed", "3", "--finger-rest"], check=True, stdout=subprocess.DEVNULL)
            names = output.read_text().splitlines()[0]
            there = np.genfromtxt(output, delimiter=",", skip_header=1)
            law = enamel.position_control(self.device, delay=(1, 1))
            options = dict(encoders=True, delay=(1, 1), seed=3)
            here = enamel.push(self.device, law, finger_rest=True, **options)
            self.assertFalse((enamel.push(self.device, law, **options).ticks["gap"] == here.ticks["gap"]).all())
            self.assertTrue(names.startswith("t [s],x [m],y [m],z [m]"))
            self.assertEqual(len(there), len(here.ticks))
            self.assertTrue((there[:, 0] == here.ticks["time"]).all())
            self.assertTrue((there[:, 1:4] == here.ticks["position"]).all())
            gap = [name.split(" [")[0] for name in names.split(",")].index("gap")
            self.assertTrue((there[:, gap] == here.ticks["gap"]).all())

            record = enamel.Recording(recording)
            self.assertEqual((record.renderer, record.device.name), ("position-control", self.device.name))
            ticks = record.ticks()
            for name in ("q", "requested", "command"):
                self.assertTrue((ticks[name] == here.ticks[name]).all(), name)
            replayed = record.replay(law)
            self.assertEqual((replayed["ticks"], replayed["different"], replayed["closed"]), (3000, 0, True))
            other = record.replay(enamel.impedance(3000.0))
            self.assertGreater(other["different"], 1000)

    def test_tables_are_views(self):
        ticks = enamel.push(self.device, enamel.hold(self.device), duration=0.1).ticks
        self.assertEqual(len(ticks), 100)
        self.assertFalse(ticks.flags.owndata)
        self.assertEqual(ticks["rotation"].shape, (100, 3, 3))
        np.testing.assert_allclose(ticks["rotation"][0], np.eye(3), atol=1e-15)
        self.assertEqual(enamel.modes[ticks["mode"][-1]], "contact")

    def test_a_renderer_in_python_is_the_linked_one(self):
        class Spring(enamel.PythonRenderer):
            def render(self, tick):
                k = tick.kinematics
                torque = k.gravity.copy()
                for c in tick.contacts:
                    force = max(0.0, -5000.0 * c["gap"]) * c["normal"]
                    torque += k.jacobian.T @ np.concatenate([force, np.cross(c["point"] - k.position, force)])
                return torque

        device = self.device.damped([0, 0, 4, 0, 0, 0])
        mine = enamel.push(device, Spring, duration=1.5).ticks
        linked = enamel.push(device, enamel.impedance(5000.0), duration=1.5).ticks
        self.assertLess(linked["gap"].min(), -1e-3)
        np.testing.assert_allclose(mine["gap"], linked["gap"], atol=1e-9)
        np.testing.assert_allclose(mine["normal_force"], linked["normal_force"], atol=1e-5)

    def test_a_handpiece_has_its_mass_in_the_model(self):
        heavy = self.device.with_handpiece(0.085, com=(0, 0, 0.06), inertia=np.diag([8e-5, 8e-5, 5e-6]))
        work = heavy.home.jacobian.T @ np.diag([0.085] * 3 + [0] * 3) @ heavy.home.jacobian
        self.assertGreater(np.trace(heavy.home.inertia - self.device.home.inertia), 0.9 * np.trace(work))
        with self.assertRaisesRegex(enamel.Error, "mass is -1, must be at least 0 kg"):
            self.device.with_handpiece(-1.0)

    def test_what_a_renderer_raises_ends_the_run(self):
        class Tired(enamel.PythonRenderer):
            def render(self, tick):
                if tick.time > 0.05:
                    raise KeyError("tired")
                return tick.kinematics.gravity

        class Wrong(enamel.PythonRenderer):
            def render(self, tick):
                return [0.0]

        class Unwilling(enamel.PythonRenderer):
            def activate(self, period):
                raise OSError(f"not at {period} s")

        with self.assertRaisesRegex(KeyError, "tired"):
            enamel.push(self.device, Tired)
        with self.assertRaisesRegex(ValueError, r"the result of render\(\) has the shape \(1,\), must be \(6,\)"):
            enamel.push(self.device, Wrong)
        with self.assertRaisesRegex(OSError, "not at 0.001 s"):
            enamel.push(self.device, Unwilling)
        with self.assertRaisesRegex(KeyError, "tired"):
            enamel.study(self.device, {"tired": Tired}, grid=1, runs=2, threads=2)
        with self.assertRaisesRegex(KeyError, "tired"):
            enamel.trials(self.device, Tired, filter="ramp", runs=1)

    def test_options_go_by_name_or_by_place(self):
        law = enamel.hold(self.device)
        for options, message in (({"forse": 1.0}, r'push\(\) has no argument "forse"'),
                                 ({"force": "strong"}, r"push\(\): force is 'strong', must be float"),
                                 ({"delay": 1}, r"push\(\): delay is 1, must be Tuple\[int, int\]")):
            with self.assertRaisesRegex(TypeError, message):
                enamel.push(self.device, law, **options)
        with self.assertRaises(TypeError):
            enamel.push(self.device, law, None)  # options by name only
        corner = np.array([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0]]), [[0, 1, 2]]
        placed, named = enamel.Scene(), enamel.Scene()
        placed.add_mesh("sheet", *corner, (0, 0, -0.01), None, 2e4, 0.1, 1e-3)
        named.add_mesh("sheet", *corner, thickness=1e-3, position=(0, 0, -0.01))
        point = [[0.002, 0.002, 0.0]]
        self.assertEqual(placed.nearest(point).tobytes(), named.nearest(point).tobytes())
        np.testing.assert_allclose(placed.nearest(point)["gap"], 0.0095)
        with self.assertRaisesRegex(TypeError, 'got "position" twice'):
            placed.add_mesh("again", *corner, (0, 0, 0), position=(0, 0, 0))
        with self.assertRaisesRegex(TypeError, "too many arguments"):
            placed.add_mesh("again", *corner, (0, 0, 0), None, 2e4, 0.1, 1e-3, 1)

    def test_a_study_does_not_depend_on_threads(self):
        def run(threads):
            return enamel.study(self.device, {"hold": enamel.hold(self.device, release=False)}, grid=2, runs=2,
                                scenarios=[1], threads=threads)

        one, two = run(1), run(2)
        self.assertEqual(one.runs.tobytes(), two.runs.tobytes())
        self.assertEqual((len(one.runs), one.renderers), (8, ["hold"]))
        means = [one.runs["K_z1"][one.runs["point"] == p].mean() for p in range(4)]
        self.assertAlmostEqual(one.walls[0]["lowest K_z1"], min(means), delta=1e-9 * min(means))
        np.testing.assert_allclose(one.point(0), [-0.025, -0.025, 0.0])

    def test_design(self):
        design = enamel.design_servo(self.device)
        self.assertEqual((design.K.shape, design.A.shape, design.B.shape), ((6, 18), (12, 12), (12, 6)))
        self.assertFalse(design.K.flags.owndata)
        self.assertEqual(enamel.load_servo(enamel.data / "servos/tau-hold-0.json").shape, (6, 18))
        by_gain = enamel.push(self.device, enamel.hold(self.device, gain=design.K), duration=1.1).ticks
        by_default = enamel.push(self.device, enamel.hold(self.device), duration=1.1).ticks
        self.assertEqual(by_gain.tobytes(), by_default.tobytes())

    def test_long_calls_let_other_threads_run(self):
        def counted(duration):
            worker = threading.Thread(
                target=lambda: enamel.push(self.device, enamel.hold(self.device), substeps=20, duration=duration))
            worker.start()
            count = 0
            while worker.is_alive():
                count += 1
                time.sleep(1e-3)
            return count

        # If the GIL were not released, this thread would run once or twice, however long the call. A longer call
        # gives it more chances on a loaded machine.
        self.assertTrue(any(counted(duration) > 10 for duration in (10.0, 40.0, 160.0)))


class Stub(unittest.TestCase):
    """__init__.pyi lists all names with their arguments, and everything has a docstring."""

    def test_names_and_arguments(self):
        text = Path(enamel.__file__).with_suffix(".pyi").read_text()
        stated = {}
        for owner, body in re.findall(r"^(?:class (\w+).*?:|)((?:.|\n)*?)(?=^class |^def |\Z)", text, re.M):
            stated.setdefault(owner, body)
        names = set(re.findall(r"^(?:class|def) (\w+)|^(\w+)(?::| =)", text, re.M))
        names = {a or b for a, b in names} - {"_File"}
        public = {name for name in dir(enamel) if not name.startswith("_")}
        self.assertEqual(public - names, set())
        self.assertEqual({n for n in names if not n.startswith("_")} - public, set())

        functions = re.findall(r"^( *)def (\w+)\(((?:.|\n)*?)\) ->", text, re.M)
        owner_at = [(m.start(), m.group(1)) for m in re.finditer(r"^class (\w+)", text, re.M)]
        at = 0
        compared = 0
        for indent, name, arguments in functions:
            at = text.index(f"def {name}(", at)
            owner = next((o for s, o in reversed(owner_at) if s < at), None) if indent else None
            at += 1
            scope = getattr(enamel, owner) if owner else enamel
            attribute = inspect.getattr_static(scope, name)
            if isinstance(attribute, property) or owner == "PythonRenderer":
                continue
            said = [a for a in re.findall(r"(\w+):", re.sub(r"\[[^\]]*\]", "", arguments)) if a not in ("numbers", "parameters")]
            line = getattr(scope, name).__doc__.splitlines()[0]
            inner = line[line.index("(") + 1:line.rindex(")")]
            there = [a for a in re.findall(r"(\w+): ", inner) if a != "self"]
            self.assertEqual(said, there, f"{owner}.{name}")
            compared += 1
        self.assertGreater(compared, 30)

    def test_everything_is_documented(self):
        for name in dir(enamel):
            thing = getattr(enamel, name)
            if name.startswith("_") or not (inspect.isclass(thing) or callable(thing)) or name.endswith("Error") or name == "RendererLike":
                continue
            self.assertTrue(thing.__doc__ and len(thing.__doc__.strip()) > 20, name)


class Numpy(unittest.TestCase):
    def test_numpy_2_works_or_is_refused(self):
        """A module built with an old pybind11 must not give wrong arrays with NumPy 2."""
        code = "import enamel; print(float(enamel.Device(enamel.data / 'devices/tau-nominal.toml').home.inertia.sum()))"
        with tempfile.TemporaryDirectory() as folder:
            if np.lib.NumpyVersion(np.__version__) < "2.0.0":  # a stand-in that only has a version
                (Path(folder) / "numpy").mkdir()
                (Path(folder) / "numpy/__init__.py").write_text("__version__ = '2.1.0'\nndarray = object\n")
            path = os.pathsep.join([folder, os.environ.get("PYTHONPATH", "")])
            result = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path},
                                    capture_output=True, text=True)
        if result.returncode == 0:
            self.assertGreaterEqual(enamel._enamel._pybind11, (2, 12))
            self.assertAlmostEqual(float(result.stdout), float(enamel.Device(TAU).home.inertia.sum()))
        elif enamel._enamel._pybind11 < (2, 12):
            self.assertIn("pybind11 2.", result.stderr)
            self.assertIn("NumPy 2.1.0: install numpy<2", result.stderr)
        else:  # the stand-in has no arrays: a pybind11 that supports NumPy 2 fails elsewhere
            self.assertIn("numpy", result.stderr)


if __name__ == "__main__":
    unittest.main()
