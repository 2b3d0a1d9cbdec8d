// Enamel for C#: the C interface through P/Invoke. Copy this file into a Unity project, and enamel.dll (Windows) or
// libenamel.so (Linux) into Assets/Plugins. Structs and functions have the names and contracts of enamel/c/enamel.h.
//
//   using (var session = new Enamel.Session()) {
//     session.StartVirtual();
//     Console.WriteLine(session.Snapshot().position[2]);
//   }
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Text;

namespace Enamel
{
    // generated from enamel.h: begin
    public enum EnamelResult { ENAMEL_OK = 0, ENAMEL_NOT_FINITE = 1, ENAMEL_UNREACHABLE = 2, ENAMEL_SINGULAR = 3, ENAMEL_NOT_CONVERGED = 4, ENAMEL_OUT_OF_RANGE = 5, ENAMEL_STALE = 6, ENAMEL_INACTIVE = 7, ENAMEL_WRONG_ORDER = 8, ENAMEL_BAD_CONFIGURATION = 9 }
    public enum EnamelMode { ENAMEL_FREE = 0, ENAMEL_CONTACT = 1, ENAMEL_FAULT = 2 }
    public enum EnamelAnswer { ENAMEL_TORQUE = 0, ENAMEL_WRENCH = 1 }
    public enum EnamelFeature { ENAMEL_FACE = 0, ENAMEL_EDGE = 1, ENAMEL_VERTEX = 2 }
    public enum EnamelApplied { ENAMEL_APPLIED_UNKNOWN = 0, ENAMEL_APPLIED_REPORTED = 1, ENAMEL_APPLIED_SENT = 2 }
    public enum EnamelCondition { ENAMEL_FORCES_CUT = 1, ENAMEL_UNCALIBRATED = 2 }
    public enum EnamelFailure { ENAMEL_FAILED = 100, ENAMEL_NULL = 101, ENAMEL_SIZE = 102, ENAMEL_NOTHING = 103, ENAMEL_STOPPED = 104 }
    public enum EnamelShape { ENAMEL_HALF_SPACE = 0, ENAMEL_BOX = 1, ENAMEL_SPHERE = 2, ENAMEL_CAPSULE = 3, ENAMEL_MESH = 4, ENAMEL_SOLID = 5 }
    public enum EnamelGuideShape { ENAMEL_GUIDE_LINE = 0, ENAMEL_GUIDE_PLANE = 1, ENAMEL_GUIDE_HALF_SPACE = 2, ENAMEL_GUIDE_BOX = 3 }
    public enum EnamelEventKind { ENAMEL_CONTACT_BEGIN = 0, ENAMEL_CONTACT_END = 1, ENAMEL_GUARD_STOP = 2, ENAMEL_CUT = 3, ENAMEL_MISSED = 4, ENAMEL_DEVICE_LOST = 5, ENAMEL_DEVICE_BACK = 6, ENAMEL_RECORDING_END = 7, ENAMEL_UNUSUAL_SIZE = 8 }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void EnamelHand(IntPtr user, double time, ref EnamelPose pose, IntPtr twist, IntPtr wrench);

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelContact
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] point;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] normal;
        public double gap;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] obstacle_velocity;
        public double stiffness;
        public double friction;
        public double sliding_friction;
        public double viscosity;
        public int obstacle;
        public int part;
        public int triangle;
        public int feature;
        public int feature_index;
        public uint key;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelParameter
    {
        public IntPtr key;
        public IntPtr value;
        public IntPtr meaning;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelMessage
    {
        public IntPtr text;
        public UIntPtr size;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelMeasurement
    {
        public uint size;
        public int age;
        public double time;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] q;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] rates;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] applied;
        public double gripper;
        public double heat;
        public int applied_known;
        public int has_gripper;
        public int enabled;
        public int failed;
        public uint buttons;
        public uint conditions;
    }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelDevice_open(IntPtr user, EnamelMessage message);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void EnamelDevice_close(IntPtr user);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelDevice_measure(IntPtr user, ref EnamelMeasurement measurement);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelDevice_actuate(IntPtr user, IntPtr effort, int joints);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelDevice_grip(IntPtr user, double force);

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelDevice
    {
        public uint size;
        public uint reserved;
        public IntPtr user;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelDevice_open open;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelDevice_close close;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelDevice_measure measure;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelDevice_actuate actuate;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelDevice_grip grip;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelObstacle
    {
        public int slot;
        public uint generation;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelPose
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] position;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)] public double[] rotation;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelMaterial
    {
        public double stiffness;
        public double friction;
        public double sliding_friction;
        public double viscosity;
        public double exponent;
        public double thickness;
        public double hysteresis;
        public double puncture;
        public double stribeck;
        public double roughness;
        public double wavelength;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelSuspension
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] centre;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] inertia;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] stiffness;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] damping;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelToolPart
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] a;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] b;
        public double radius;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelTool
    {
        public uint size;
        public int count;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public EnamelToolPart[] parts;
        public int head;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelBur
    {
        public uint size;
        public int part;
        public double wear;
        public double turns;
        public double torque;
        public double inertia;
        public double drag;
        public double run_out;
        public int blades;
        public double shaft_compliance;
        public double shaft_frequency;
        public double shaft_damping;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelKinematics
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] q;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] rates;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] position;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)] public double[] rotation;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] twist;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 42)] public double[] jacobian;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 42)] public double[] inverse;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] gravity;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 49)] public double[] inertia;
    }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelMechanism_track(IntPtr user, IntPtr q, IntPtr rates, ref EnamelKinematics state);

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate int EnamelMechanism_reach(IntPtr user, ref EnamelPose pose, IntPtr twist, ref EnamelKinematics state);

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelMechanism
    {
        public uint size;
        public int joints;
        public IntPtr name;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] max_torque;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] encoder_step;
        public IntPtr user;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelMechanism_track track;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelMechanism_reach reach;
    }

    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    public delegate void EnamelSessionDef_before_tick(IntPtr user, IntPtr access);

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelSessionDef
    {
        public uint size;
        public int clutch_button;
        public IntPtr device;
        public IntPtr mechanism;
        public IntPtr scene;
        public IntPtr tool;
        public IntPtr bur;
        public IntPtr start;
        public IntPtr renderer;
        public IntPtr parameters;
        public UIntPtr parameter_count;
        public IntPtr plugin_folder;
        public double rate;
        public IntPtr @base;
        public double scale;
        public double centring;
        public double max_force;
        public int priority;
        public int lock_memory;
        public IntPtr shares_with;
        [MarshalAs(UnmanagedType.FunctionPtr)] public EnamelSessionDef_before_tick before_tick;
        public IntPtr user;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelLayer
    {
        public EnamelMaterial material;
        public double hardness;
        public double depth;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelObstacleDef
    {
        public uint size;
        public int shape;
        public IntPtr name;
        public EnamelPose pose;
        public EnamelMaterial material;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] dimensions;
        public double thickness;
        public IntPtr vertices;
        public UIntPtr vertex_count;
        public IntPtr triangles;
        public UIntPtr triangle_count;
        public IntPtr file;
        public double unit;
        public IntPtr layers;
        public UIntPtr layer_count;
        public double cell;
        public int active;
        public int reserved;
        public IntPtr solid;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelLabelLayer
    {
        public EnamelMaterial material;
        public double hardness;
        public IntPtr labels;
        public UIntPtr label_count;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelLabels
    {
        public uint size;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public int[] voxels;
        public IntPtr labels;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] spacing;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] origin;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)] public double[] axes;
        public IntPtr layers;
        public UIntPtr layer_count;
        public double smoothing;
        public double cell;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelCutDifference
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] over_cut;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] under_cut;
        public double area;
        public double mean;
        public double p95;
        public double deepest;
        public double highest;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelCutComparison
    {
        public uint size;
        public int reserved;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] removed;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] planned;
        public EnamelCutDifference whole;
        public EnamelCutDifference floors;
        public EnamelCutDifference walls;
        public IntPtr vertices;
        public IntPtr distance;
        public IntPtr prepared;
        public IntPtr triangles;
        public UIntPtr vertex_count;
        public UIntPtr triangle_count;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelSurface
    {
        public uint size;
        public int brick;
        public IntPtr vertices;
        public IntPtr normals;
        public IntPtr layers;
        public IntPtr triangles;
        public UIntPtr vertex_capacity;
        public UIntPtr triangle_capacity;
        public UIntPtr vertex_count;
        public UIntPtr triangle_count;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelGuide
    {
        public int shape;
        public int reserved;
        public EnamelPose pose;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] dimensions;
        public IntPtr points;
        public UIntPtr point_count;
        public double stiffness;
        public double max_force;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelSnapshot
    {
        public uint size;
        public int joints;
        public ulong tick;
        public double time;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] position;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)] public double[] rotation;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] twist;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 6)] public double[] wrench;
        public double normal_force;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] @base;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] q;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 7)] public double[] command;
        public double gripper;
        public double heat;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] removed;
        public ulong missed;
        public ulong held;
        public ulong dropped_events;
        public ulong lost_cuts;
        public ulong unsent;
        public double bur_turns;
        public double bur_torque;
        public double bur_chatter;
        public double since_tick;
        public int mode;
        public int status;
        public int reason;
        public int fault;
        public int enabled;
        public int clutched;
        public int spins;
        public uint buttons;
        public uint conditions;
        public int contact_count;
        public int omitted_contacts;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public EnamelContact[] contacts;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct EnamelEvent
    {
        public uint size;
        public int kind;
        public ulong tick;
        public double time;
        public EnamelObstacle obstacle;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] point;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] normal;
        public double speed;
        public double impulse;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public double[] removed;
        public ulong count;
        public double extent;
        public int part;
        public int reason;
    }

    public static class Native
    {
        const string Library = "enamel";

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern uint enamel_version();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_session_defaults(ref EnamelSessionDef def);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_obstacle_defaults(ref EnamelObstacleDef def);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_session_create(ref EnamelSessionDef def, out IntPtr session, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_session_destroy(IntPtr session);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_message(IntPtr session, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_start(IntPtr session);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_start_device(IntPtr session, ref EnamelDevice device);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_start_virtual(IntPtr session, EnamelHand hand, IntPtr user);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_stop(IntPtr session);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_is_running(IntPtr session, out int running);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick(IntPtr session, ref EnamelMeasurement measurement, [In, Out] double[] effort);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_snapshot(IntPtr session, ref EnamelSnapshot snapshot);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_next_event(IntPtr session, ref EnamelEvent @event);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_add(IntPtr session, ref EnamelObstacleDef def, ref EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_replace(IntPtr session, EnamelObstacle obstacle, ref EnamelObstacleDef by);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_remove(IntPtr session, EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_find(IntPtr session, [MarshalAs(UnmanagedType.LPUTF8Str)] string name, ref EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_move(IntPtr session, EnamelObstacle obstacle, ref EnamelPose pose, double[] twist);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_material(IntPtr session, EnamelObstacle obstacle, ref EnamelMaterial material);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_suspension(IntPtr session, EnamelObstacle obstacle, ref EnamelSuspension suspension);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_tap(IntPtr session, EnamelObstacle obstacle, double frequency, double decay);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_activate(IntPtr session, EnamelObstacle obstacle, int active);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_move_vertices(IntPtr session, EnamelObstacle obstacle, int[] vertices, double[] positions, UIntPtr count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_restore(IntPtr session, EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_mark(IntPtr session, EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_undo(IntPtr session, EnamelObstacle obstacle);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_bricks(IntPtr session, EnamelObstacle obstacle, out int count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_take_surface(IntPtr session, EnamelObstacle obstacle, ref EnamelSurface surface);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_load([MarshalAs(UnmanagedType.LPUTF8Str)] string file, out IntPtr solid, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_labels_defaults(ref EnamelLabels labels);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_from_labels(ref EnamelLabels labels, out IntPtr solid, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_copy(IntPtr session, EnamelObstacle obstacle, out IntPtr solid);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_solid_destroy(IntPtr solid);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_save(IntPtr solid, [MarshalAs(UnmanagedType.LPUTF8Str)] string file, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_solid_compare(IntPtr solid, ref EnamelObstacleDef target, double[] axis, ref EnamelCutComparison comparison, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_guides(IntPtr session, EnamelGuide[] guides, UIntPtr guide_count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_named_tool([MarshalAs(UnmanagedType.LPUTF8Str)] string name, ref EnamelTool tool, EnamelMessage message);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_tool(IntPtr session, IntPtr tool, IntPtr bur);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_renderer(IntPtr session, [MarshalAs(UnmanagedType.LPUTF8Str)] string name, EnamelParameter[] parameters, UIntPtr parameter_count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_effect(IntPtr session, double[] wrench);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_set_gripper(IntPtr session, double force);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_spin(IntPtr session, int on);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_clutch(IntPtr session, int on);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_enable(IntPtr session, int on);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_reset(IntPtr session);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_record(IntPtr session, [MarshalAs(UnmanagedType.LPUTF8Str)] string path);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_stop_recording(IntPtr session, out ulong ticks, out ulong lost);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_measurement(IntPtr access, ref EnamelMeasurement measurement);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_move(IntPtr access, EnamelObstacle obstacle, ref EnamelPose pose, double[] twist);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_activate(IntPtr access, EnamelObstacle obstacle, int active);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_spin(IntPtr access, int on);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_effect(IntPtr access, double[] wrench);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_tick_gripper(IntPtr access, double force);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_virtual_create(IntPtr session, out IntPtr device);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_virtual_destroy(IntPtr device);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_virtual_measure(IntPtr device, ref EnamelMeasurement measurement);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_virtual_actuate(IntPtr device, double[] effort);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_virtual_advance(IntPtr device, double[] wrench);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int enamel_virtual_state(IntPtr device, ref EnamelPose pose, [In, Out] double[] twist);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_vector_from_unity([In, Out] double[] vector);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_vector_to_unity([In, Out] double[] vector);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_rotation_from_unity(double[] quaternion, [In, Out] double[] rotation);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void enamel_rotation_to_unity(double[] rotation, [In, Out] double[] quaternion);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr enamel_reason_text(int reason);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr enamel_event_text(int kind);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr enamel_result_text(int result);
    }
    // generated from enamel.h: end

    /// An error of the library, with its reason.
    public class EnamelException : Exception
    {
        public EnamelException(string message) : base(message) { }
    }

    /// A session. Every method throws EnamelException on an error. Threads as in enamel.h.
    public sealed class Session : IDisposable
    {
        const int MessageSize = 2048;
        IntPtr handle;
        readonly List<object> kept = new List<object>(); // delegates that C refers to

        /// Texts and `start` may be null. `change` edits the other members of the definition.
        public Session(string device = null, string scene = null, string renderer = "position-control",
                       EnamelPose? start = null, Func<EnamelSessionDef, EnamelSessionDef> change = null)
        {
            var def = new EnamelSessionDef();
            Native.enamel_session_defaults(ref def);
            var texts = new[] { Text(device), Text(scene), Text(renderer), Copy(start) };
            def.device = texts[0];
            def.scene = texts[1];
            def.renderer = texts[2];
            def.start = texts[3];
            if (change != null) def = change(def);
            var message = new EnamelMessage { text = Marshal.AllocHGlobal(MessageSize), size = (UIntPtr)MessageSize };
            try
            {
                if (Native.enamel_session_create(ref def, out handle, message) != (int)EnamelResult.ENAMEL_OK)
                    throw new EnamelException(FromUtf8(message.text));
            }
            finally
            {
                Marshal.FreeHGlobal(message.text);
                foreach (var text in texts) Marshal.FreeHGlobal(text);
            }
        }

        public IntPtr Handle { get { return handle; } }

        public void Dispose()
        {
            Native.enamel_session_destroy(handle);
            handle = IntPtr.Zero;
            GC.SuppressFinalize(this);
        }

        ~Session() { Native.enamel_session_destroy(handle); }

        /// Throw if the result of a native function is an error.
        public void Check(int result)
        {
            if (result == (int)EnamelResult.ENAMEL_OK) return;
            var message = new EnamelMessage { text = Marshal.AllocHGlobal(MessageSize), size = (UIntPtr)MessageSize };
            Native.enamel_message(handle, message);
            var reason = FromUtf8(result == (int)EnamelFailure.ENAMEL_FAILED ? message.text : Native.enamel_result_text(result));
            Marshal.FreeHGlobal(message.text);
            throw new EnamelException(reason);
        }

        /// Run the loop with the device whose URL is `device` of the definition, such as virtual:FILE.
        public void Start() { Check(Native.enamel_start(handle)); }

        /// Run the loop with a simulated device. `hand` runs on the loop's thread; null: it pushes along -z with 1 N.
        public void StartVirtual(EnamelHand hand = null)
        {
            if (hand != null) kept.Add(hand);
            Check(Native.enamel_start_virtual(handle, hand, IntPtr.Zero));
        }

        public void StartDevice(EnamelDevice device)
        {
            device.size = (uint)Marshal.SizeOf(typeof(EnamelDevice));
            kept.Add(device);
            Check(Native.enamel_start_device(handle, ref device));
        }

        /// Continue after a fault of the guard.
        public void Reset() { Check(Native.enamel_reset(handle)); }

        public void Stop() { Check(Native.enamel_stop(handle)); }

        public EnamelSnapshot Snapshot()
        {
            var now = new EnamelSnapshot { size = (uint)Marshal.SizeOf(typeof(EnamelSnapshot)) };
            Check(Native.enamel_snapshot(handle, ref now));
            return now;
        }

        public bool NextEvent(out EnamelEvent found)
        {
            found = new EnamelEvent { size = (uint)Marshal.SizeOf(typeof(EnamelEvent)) };
            var result = Native.enamel_next_event(handle, ref found);
            if (result == (int)EnamelFailure.ENAMEL_NOTHING) return false;
            Check(result);
            return true;
        }

        /// Add a mesh: 3 numbers a vertex in m, 3 vertices a triangle, counter-clockwise from outside.
        public EnamelObstacle AddMesh(string name, double[] vertices, int[] triangles,
                                      Func<EnamelObstacleDef, EnamelObstacleDef> change = null)
        {
            var points = GCHandle.Alloc(vertices, GCHandleType.Pinned);
            var corners = GCHandle.Alloc(triangles, GCHandleType.Pinned);
            try
            {
                return Add(name, EnamelShape.ENAMEL_MESH, def =>
                {
                    def.vertices = points.AddrOfPinnedObject();
                    def.vertex_count = (UIntPtr)(vertices.Length / 3);
                    def.triangles = corners.AddrOfPinnedObject();
                    def.triangle_count = (UIntPtr)(triangles.Length / 3);
                    return change == null ? def : change(def);
                });
            }
            finally
            {
                points.Free();
                corners.Free();
            }
        }

        /// Add a mesh file: PLY, OBJ, STL or OFF, with the unit of its coordinates in m.
        public EnamelObstacle AddMesh(string name, string file, double unit,
                                      Func<EnamelObstacleDef, EnamelObstacleDef> change = null)
        {
            var path = Text(file);
            try
            {
                return Add(name, EnamelShape.ENAMEL_MESH, def =>
                {
                    def.file = path;
                    def.unit = unit;
                    return change == null ? def : change(def);
                });
            }
            finally
            {
                Marshal.FreeHGlobal(path);
            }
        }

        /// Use a tool of these parts, without a bur.
        public void SetTool(params EnamelToolPart[] parts) { SetTool(null, parts); }

        /// Use a tool of these parts. One of them is a bur.
        public void SetTool(EnamelBur? bur, EnamelToolPart[] parts)
        {
            var tool = new EnamelTool { size = (uint)Marshal.SizeOf(typeof(EnamelTool)), count = parts.Length };
            tool.parts = new EnamelToolPart[8];
            for (int i = 0; i < tool.parts.Length; ++i)
                tool.parts[i] = i < parts.Length ? parts[i] : new EnamelToolPart { a = new double[3], b = new double[3] };
            var cutter = bur.GetValueOrDefault();
            cutter.size = (uint)Marshal.SizeOf(typeof(EnamelBur));
            IntPtr memory = Copy<EnamelTool>(tool), cutting = bur == null ? IntPtr.Zero : Copy<EnamelBur>(cutter);
            try { Check(Native.enamel_set_tool(handle, memory, cutting)); }
            finally
            {
                Marshal.FreeHGlobal(memory);
                Marshal.FreeHGlobal(cutting);
            }
        }

        public EnamelObstacle Add(string name, EnamelShape shape, Func<EnamelObstacleDef, EnamelObstacleDef> change = null)
        {
            var def = new EnamelObstacleDef();
            Native.enamel_obstacle_defaults(ref def);
            def.name = Text(name);
            def.shape = (int)shape;
            try
            {
                var given = change == null ? def : change(def);
                var id = new EnamelObstacle();
                Check(Native.enamel_add(handle, ref given, ref id));
                return id;
            }
            finally
            {
                Marshal.FreeHGlobal(def.name);
            }
        }

        public void Remove(EnamelObstacle obstacle) { Check(Native.enamel_remove(handle, obstacle)); }

        public void Move(EnamelObstacle obstacle, EnamelPose pose)
        {
            Check(Native.enamel_move(handle, obstacle, ref pose, null));
        }

        public void SetMaterial(EnamelObstacle obstacle, EnamelMaterial material)
        {
            Check(Native.enamel_set_material(handle, obstacle, ref material));
        }

        public void Activate(EnamelObstacle obstacle, bool on) { Check(Native.enamel_activate(handle, obstacle, on ? 1 : 0)); }

        public void Spin(bool on) { Check(Native.enamel_spin(handle, on ? 1 : 0)); }

        /// Name of an event in plain words.
        public static string TextOf(EnamelEventKind kind) { return FromUtf8(Native.enamel_event_text((int)kind)); }

        /// Name of a reason of the guard in plain words.
        public static string TextOfReason(int reason) { return FromUtf8(Native.enamel_reason_text(reason)); }

        static IntPtr Copy<T>(T? given) where T : struct
        {
            if (given == null) return IntPtr.Zero;
            var copy = Marshal.AllocHGlobal(Marshal.SizeOf(typeof(T)));
            Marshal.StructureToPtr(given.Value, copy, false);
            return copy;
        }

        static IntPtr Text(string text)
        {
            if (text == null) return IntPtr.Zero;
            var bytes = Encoding.UTF8.GetBytes(text + "\0");
            var copy = Marshal.AllocHGlobal(bytes.Length);
            Marshal.Copy(bytes, 0, copy, bytes.Length);
            return copy;
        }

        static string FromUtf8(IntPtr text)
        {
            var bytes = new List<byte>();
            for (int i = 0; text != IntPtr.Zero && Marshal.ReadByte(text, i) != 0; ++i) bytes.Add(Marshal.ReadByte(text, i));
            return Encoding.UTF8.GetString(bytes.ToArray());
        }
    }
}
