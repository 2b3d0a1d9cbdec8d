// Touch your own tooth: own_tooth.exe MESH [mm per unit of the file]. A simulated hand pushes a ball of 1.2 mm down.
using System;
using System.Runtime.InteropServices;
using System.Threading;
using Enamel;

static class OwnTooth
{
    static EnamelPose At(double z)
    {
        return new EnamelPose { position = new[] { 0.0, 0.0, z }, rotation = new[] { 1.0, 0, 0, 0, 1, 0, 0, 0, 1 } };
    }

    static int Main(string[] arguments)
    {
        if (arguments.Length < 1)
        {
            Console.Error.WriteLine("usage: own_tooth.exe MESH.ply|obj|stl|off [mm per unit of the file]");
            return 2;
        }
        double unit = 1e-3 * (arguments.Length > 1 ? double.Parse(arguments[1]) : 1.0);
        using (var session = new Session(start: At(4e-3)))
        {
            session.SetTool(new EnamelToolPart { a = new[] { 0, 0, 0.6e-3 }, b = new[] { 0, 0, 0.6e-3 }, radius = 0.6e-3 });
            session.AddMesh("tooth", arguments[0], unit, def => { def.pose = At(-7e-3); return def; });
            session.StartVirtual();
            var now = session.Snapshot();
            bool pushes = false;
            for (int frame = 0; frame < 600 && !pushes; ++frame) // at most 20 s; a busy machine needs longer
            {
                Thread.Sleep(33);
                now = session.Snapshot();
                Console.WriteLine("tick {0,6}  z {1,7:F3} mm  {2} contacts  {3,5:F2} N", now.tick, 1e3 * now.position[2],
                                  now.contact_count, now.wrench[2]);
                pushes = now.contact_count > 0 && now.wrench[2] > 0.5;
                if (now.fault == 0) continue;
                Console.WriteLine("stopped: {0}", Session.TextOfReason(now.fault)); // a late tick on a busy machine
                session.Reset();                                                    // a real program asks the person first
            }
            session.Stop();
            EnamelEvent found;
            while (session.NextEvent(out found))
                Console.WriteLine("{0:F3} s: {1}", found.time, Session.TextOf((EnamelEventKind)found.kind));
            return pushes ? 0 : 1;
        }
    }
}
