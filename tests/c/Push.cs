// The push of push.c from C#: the same mesh, the same device, the same numbers. Bits are printed as integers.
using System;
using System.Runtime.InteropServices;
using Enamel;

static class Push
{
    static readonly double[] Vertices = {
        -0.02, -0.02, -0.01, 0.02, -0.02, -0.01, 0.02, 0.02, -0.01, -0.02, 0.02, -0.01,
        -0.02, -0.02, 0.0, 0.02, -0.02, 0.0, 0.02, 0.02, 0.0, -0.02, 0.02, 0.0 };
    static readonly int[] Triangles = {
        0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7 };

    // The size of a struct and the offsets of its members, for the comparison with enamel.abi.
    static void PrintLayout(Type type)
    {
        Console.WriteLine("struct {0} {1}", type.Name, Marshal.SizeOf(type));
        foreach (var field in type.GetFields())
            Console.WriteLine("  {0} {1}", Marshal.OffsetOf(type, field.Name), field.Name);
    }

    static int Main(string[] arguments)
    {
        if (arguments.Length == 1 && arguments[0] == "--layout")
        {
            foreach (var type in typeof(EnamelContact).Assembly.GetTypes())
                if (type.IsValueType && !type.IsEnum && type.Name.StartsWith("Enamel")) PrintLayout(type);
            return 0;
        }
        var start = new EnamelPose { position = new[] { 0.0, 0.0, 0.5e-3 }, rotation = new[] { 1.0, 0, 0, 0, 1, 0, 0, 0, 1 } };
        using (var session = new Session(start: start))
        {
            var plate = session.AddMesh("plate", Vertices, Triangles);
            IntPtr device;
            session.Check(Native.enamel_virtual_create(session.Handle, out device));
            var measurement = new EnamelMeasurement { size = (uint)Marshal.SizeOf(typeof(EnamelMeasurement)) };
            var effort = new double[7];
            var pose = new EnamelPose();
            var twist = new double[6];
            var wrench = new double[6];
            for (int i = 0; i < 300; ++i)
            {
                if (Native.enamel_virtual_measure(device, ref measurement) != 0) return 1;
                if (Native.enamel_tick(session.Handle, ref measurement, effort) != 0) return 1;
                if (Native.enamel_virtual_state(device, ref pose, twist) != 0) return 1;
                for (int j = 0; j < 6; ++j) wrench[j] = (j < 3 ? -5.0 : -0.02) * twist[j];
                wrench[2] -= 2.0;
                Native.enamel_virtual_actuate(device, effort);
                if (Native.enamel_virtual_advance(device, wrench) != 0) return 1;
                for (int j = 0; j < 6; ++j)
                    Console.Write("{0:x16}{1}", BitConverter.DoubleToInt64Bits(effort[j]), j < 5 ? ' ' : '\n');
            }
            Native.enamel_virtual_destroy(device);
            if (session.Snapshot().contact_count != 1) return 2;
            EnamelEvent found;
            if (!session.NextEvent(out found) || found.kind != (int)EnamelEventKind.ENAMEL_CONTACT_BEGIN) return 3;
            session.Remove(plate);
            try
            {
                session.Move(plate, start);
                return 4;
            }
            catch (EnamelException error)
            {
                return error.Message.Contains("it was removed") ? 0 : 5;
            }
        }
    }
}
