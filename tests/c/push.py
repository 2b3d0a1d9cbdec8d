"""The push of push.c through ctypes: the same mesh, the same device, the same numbers."""

import os
import struct
import sys
from ctypes import byref, c_double, c_void_p, sizeof

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../plugins/ctypes"))
import enamel_c  # noqa: E402

VERTICES = [(-0.02, -0.02, -0.01), (0.02, -0.02, -0.01), (0.02, 0.02, -0.01), (-0.02, 0.02, -0.01),
            (-0.02, -0.02, 0.0), (0.02, -0.02, 0.0), (0.02, 0.02, 0.0), (-0.02, 0.02, 0.0)]
TRIANGLES = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
             (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]


def main():
    library = enamel_c.load()
    with enamel_c.Session(library, start=enamel_c.pose((0.0, 0.0, 0.5e-3))) as session:
        plate = session.add_mesh("plate", VERTICES, TRIANGLES)
        device = c_void_p()
        session.call("virtual_create", byref(device))
        measurement, place = enamel_c.EnamelMeasurement(size=sizeof(enamel_c.EnamelMeasurement)), enamel_c.EnamelPose()
        effort, twist = (c_double * 7)(), (c_double * 6)()
        for _ in range(300):
            assert library.enamel_virtual_measure(device, byref(measurement)) == enamel_c.ENAMEL_OK
            assert library.enamel_tick(session.handle, byref(measurement), effort) == enamel_c.ENAMEL_OK
            library.enamel_virtual_state(device, byref(place), twist)
            wrench = [(-5.0 if j < 3 else -0.02) * twist[j] for j in range(6)]
            wrench[2] -= 2.0
            library.enamel_virtual_actuate(device, effort)
            assert library.enamel_virtual_advance(device, (c_double * 6)(*wrench)) == enamel_c.ENAMEL_OK
            print(" ".join("%016x" % struct.unpack("<Q", struct.pack("<d", effort[j])) for j in range(6)))
        library.enamel_virtual_destroy(device)
        assert session.snapshot().contact_count == 1
        assert session.events()[0].kind == enamel_c.ENAMEL_CONTACT_BEGIN
        session.call("remove", plate)
        try:
            session.move(plate, enamel_c.pose())
        except enamel_c.EnamelError as error:
            assert "it was removed" in str(error)
        else:
            raise SystemExit("a removed obstacle was moved")
        for wrong in (lambda: session.add_mesh("flat", [(0.0, 0.0)] * 3, [(0, 1, 2)]),
                      lambda: session.add("ball", enamel_c.ENAMEL_SPHERE, radius=1e-3),
                      lambda: enamel_c.Session(library, rte=5.0)):
            try:
                wrong()
            except enamel_c.EnamelError:
                continue
            raise SystemExit("a wrong argument was accepted")
    forgotten = enamel_c.Session(library)  # is destroyed at the end of the program
    hand = enamel_c.EnamelHand(lambda *_: None)
    forgotten.start_virtual(hand)


main()
