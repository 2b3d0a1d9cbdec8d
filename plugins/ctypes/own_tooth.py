"""Touch your own tooth: own_tooth.py MESH [mm per unit of the file]. A simulated hand pushes a ball of 1.2 mm down."""

import sys
import time

import enamel_c


def main():
    if len(sys.argv) < 2:
        raise SystemExit("usage: own_tooth.py MESH.ply|obj|stl|off [mm per unit of the file]")
    bur = enamel_c.tool(((0.0, 0.0, 0.6e-3), (0.0, 0.0, 0.6e-3), 0.6e-3))  # ends and radius; its lowest point is the TCP
    with enamel_c.Session(tool=bur, start=enamel_c.pose((0.0, 0.0, 4e-3))) as session:
        unit = 1e-3 * (float(sys.argv[2]) if len(sys.argv) > 2 else 1.0)
        session.add("tooth", enamel_c.ENAMEL_MESH, enamel_c.pose((0.0, 0.0, -7e-3)), file=sys.argv[1], unit=unit)
        session.start_virtual()
        now = session.snapshot()
        for _ in range(600):  # at most 20 s; a busy machine needs longer
            time.sleep(1.0 / 30.0)
            now = session.snapshot()
            print("tick %6d  z %7.3f mm  %d contacts  %5.2f N" %
                  (now.tick, 1e3 * now.position[2], now.contact_count, now.wrench[2]))
            if now.contact_count > 0 and now.wrench[2] > 0.5:
                break
            if now.fault != 0:  # a late tick on a busy machine; a real program asks the person first
                print("stopped:", session.library.enamel_reason_text(now.fault).decode())
                session.reset()
        session.stop()
        for event in session.events():
            print("%.3f s: %s" % (event.time, session.library.enamel_event_text(event.kind).decode()))
    return 0 if now.contact_count > 0 and now.wrench[2] > 0.5 else 1


if __name__ == "__main__":
    sys.exit(main())
