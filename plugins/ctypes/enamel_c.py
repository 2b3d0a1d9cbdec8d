"""Enamel for Python without a compiler: the C interface through ctypes. Copy this file beside your program.

    import enamel_c
    with enamel_c.Session(scene="scene.toml") as session:
        session.start_virtual()
        print(session.snapshot().position[:])

The structs and functions have the names and contracts of enamel/c/enamel.h. Errors raise EnamelError with the reason.
"""

import ctypes
import os
import weakref
from ctypes import (CFUNCTYPE, POINTER, Structure, byref, c_char_p, c_double, c_int32, c_size_t, c_uint16, c_uint32,
                    c_uint64, c_void_p)

# generated from enamel.h: begin
ENAMEL_OK = 0
ENAMEL_NOT_FINITE = 1
ENAMEL_UNREACHABLE = 2
ENAMEL_SINGULAR = 3
ENAMEL_NOT_CONVERGED = 4
ENAMEL_OUT_OF_RANGE = 5
ENAMEL_STALE = 6
ENAMEL_INACTIVE = 7
ENAMEL_WRONG_ORDER = 8
ENAMEL_BAD_CONFIGURATION = 9

ENAMEL_FREE = 0
ENAMEL_CONTACT = 1
ENAMEL_FAULT = 2

ENAMEL_TORQUE = 0
ENAMEL_WRENCH = 1

ENAMEL_FACE = 0
ENAMEL_EDGE = 1
ENAMEL_VERTEX = 2

ENAMEL_APPLIED_UNKNOWN = 0
ENAMEL_APPLIED_REPORTED = 1
ENAMEL_APPLIED_SENT = 2

ENAMEL_FORCES_CUT = 1
ENAMEL_UNCALIBRATED = 2

ENAMEL_FAILED = 100
ENAMEL_NULL = 101
ENAMEL_SIZE = 102
ENAMEL_NOTHING = 103
ENAMEL_STOPPED = 104

ENAMEL_HALF_SPACE = 0
ENAMEL_BOX = 1
ENAMEL_SPHERE = 2
ENAMEL_CAPSULE = 3
ENAMEL_MESH = 4
ENAMEL_SOLID = 5

ENAMEL_GUIDE_LINE = 0
ENAMEL_GUIDE_PLANE = 1
ENAMEL_GUIDE_HALF_SPACE = 2
ENAMEL_GUIDE_BOX = 3

ENAMEL_CONTACT_BEGIN = 0
ENAMEL_CONTACT_END = 1
ENAMEL_GUARD_STOP = 2
ENAMEL_CUT = 3
ENAMEL_MISSED = 4
ENAMEL_DEVICE_LOST = 5
ENAMEL_DEVICE_BACK = 6
ENAMEL_RECORDING_END = 7
ENAMEL_UNUSUAL_SIZE = 8

ENAMEL_MAX_CONTACTS = 8
ENAMEL_MAX_JOINTS = 7
ENAMEL_MAX_TOOL_PARTS = 8
ENAMEL_MAX_LAYERS = 8
ENAMEL_ABI_VERSION = 3


class EnamelPose(Structure):
    _fields_ = [
        ("position", (c_double * 3)),
        ("rotation", (c_double * 9)),
    ]


EnamelHand = CFUNCTYPE(None, c_void_p, c_double, POINTER(EnamelPose), POINTER(c_double), POINTER(c_double))


class EnamelContact(Structure):
    _fields_ = [
        ("point", (c_double * 3)),
        ("normal", (c_double * 3)),
        ("gap", c_double),
        ("obstacle_velocity", (c_double * 3)),
        ("stiffness", c_double),
        ("friction", c_double),
        ("sliding_friction", c_double),
        ("viscosity", c_double),
        ("obstacle", c_int32),
        ("part", c_int32),
        ("triangle", c_int32),
        ("feature", c_int32),
        ("feature_index", c_int32),
        ("key", c_uint32),
    ]


class EnamelTickInput(Structure):
    _fields_ = [
        ("time", c_double),
        ("q", (c_double * 7)),
        ("rates", (c_double * 7)),
        ("position", (c_double * 3)),
        ("rotation", (c_double * 9)),
        ("twist", (c_double * 6)),
        ("gravity", (c_double * 7)),
        ("max_torque", (c_double * 7)),
        ("applied", (c_double * 7)),
        ("jacobian", ((c_double * 6) * 7)),
        ("inverse", ((c_double * 6) * 7)),
        ("inertia", ((c_double * 7) * 7)),
        ("joint_count", c_int32),
        ("contact_count", c_int32),
        ("applied_known", c_int32),
        ("age", c_int32),
        ("contacts", (EnamelContact * 8)),
    ]


class EnamelTickOutput(Structure):
    _fields_ = [
        ("torque", (c_double * 7)),
        ("wrench", (c_double * 6)),
        ("normal_force", c_double),
        ("answer", c_int32),
        ("mode", c_int32),
        ("saturated", c_int32),
        ("reserved", c_int32),
    ]


class EnamelParameter(Structure):
    _fields_ = [
        ("key", c_char_p),
        ("value", c_char_p),
        ("meaning", c_char_p),
    ]


class EnamelDescription(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("version", c_char_p),
        ("summary", c_char_p),
        ("parameters", POINTER(EnamelParameter)),
        ("parameter_count", c_size_t),
    ]


class EnamelConfiguration(Structure):
    _fields_ = [
        ("device_path", c_char_p),
        ("device_text", c_char_p),
        ("scene_path", c_char_p),
        ("scene_text", c_char_p),
        ("parameters", POINTER(EnamelParameter)),
        ("parameter_count", c_size_t),
    ]


class EnamelMessage(Structure):
    _fields_ = [
        ("text", c_void_p),
        ("size", c_size_t),
    ]


class EnamelPlugin(Structure):
    _fields_ = [
        ("abi_version", c_uint32),
        ("plugin_size", c_uint32),
        ("input_size", c_uint32),
        ("output_size", c_uint32),
        ("needs", c_uint32),
        ("reserved", c_uint32),
        ("describe", CFUNCTYPE(POINTER(EnamelDescription))),
        ("create", CFUNCTYPE(c_void_p)),
        ("configure", CFUNCTYPE(c_int32, c_void_p, POINTER(EnamelConfiguration), EnamelMessage)),
        ("activate", CFUNCTYPE(c_int32, c_void_p, c_double, EnamelMessage)),
        ("step", CFUNCTYPE(c_int32, c_void_p, POINTER(EnamelTickInput), POINTER(EnamelTickOutput))),
        ("reset", CFUNCTYPE(None, c_void_p)),
        ("deactivate", CFUNCTYPE(None, c_void_p)),
        ("destroy", CFUNCTYPE(None, c_void_p)),
        ("state_size", CFUNCTYPE(c_size_t, c_void_p)),
        ("save_state", CFUNCTYPE(None, c_void_p, c_void_p)),
        ("load_state", CFUNCTYPE(None, c_void_p, c_void_p)),
    ]


class EnamelMeasurement(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("age", c_int32),
        ("time", c_double),
        ("q", (c_double * 7)),
        ("rates", (c_double * 7)),
        ("applied", (c_double * 7)),
        ("gripper", c_double),
        ("heat", c_double),
        ("applied_known", c_int32),
        ("has_gripper", c_int32),
        ("enabled", c_int32),
        ("failed", c_int32),
        ("buttons", c_uint32),
        ("conditions", c_uint32),
    ]


class EnamelDevice(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("reserved", c_uint32),
        ("user", c_void_p),
        ("open", CFUNCTYPE(c_int32, c_void_p, EnamelMessage)),
        ("close", CFUNCTYPE(None, c_void_p)),
        ("measure", CFUNCTYPE(c_int32, c_void_p, POINTER(EnamelMeasurement))),
        ("actuate", CFUNCTYPE(c_int32, c_void_p, POINTER(c_double), c_int32)),
        ("grip", CFUNCTYPE(c_int32, c_void_p, c_double)),
    ]


class EnamelConnected(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("joints", c_int32),
        ("device_file", c_char_p),
        ("delay_low", c_int32),
        ("delay_high", c_int32),
        ("has_own_clock", c_int32),
        ("reserved", c_uint32),
        ("device", EnamelDevice),
    ]


class EnamelDriver(Structure):
    _fields_ = [
        ("abi_version", c_uint32),
        ("driver_size", c_uint32),
        ("connected_size", c_uint32),
        ("measurement_size", c_uint32),
        ("describe", CFUNCTYPE(POINTER(EnamelDescription))),
        ("list", CFUNCTYPE(c_int32, EnamelMessage, EnamelMessage)),
        ("connect", CFUNCTYPE(c_int32, c_char_p, POINTER(EnamelParameter), c_size_t, POINTER(EnamelConnected), EnamelMessage)),
        ("disconnect", CFUNCTYPE(None, POINTER(EnamelConnected))),
    ]


class EnamelObstacle(Structure):
    _fields_ = [
        ("slot", c_int32),
        ("generation", c_uint32),
    ]


class EnamelMaterial(Structure):
    _fields_ = [
        ("stiffness", c_double),
        ("friction", c_double),
        ("sliding_friction", c_double),
        ("viscosity", c_double),
        ("exponent", c_double),
        ("thickness", c_double),
        ("hysteresis", c_double),
        ("puncture", c_double),
        ("stribeck", c_double),
        ("roughness", c_double),
        ("wavelength", c_double),
    ]


class EnamelSuspension(Structure):
    _fields_ = [
        ("centre", (c_double * 3)),
        ("inertia", (c_double * 6)),
        ("stiffness", (c_double * 6)),
        ("damping", (c_double * 6)),
    ]


class EnamelToolPart(Structure):
    _fields_ = [
        ("a", (c_double * 3)),
        ("b", (c_double * 3)),
        ("radius", c_double),
    ]


class EnamelTool(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("count", c_int32),
        ("parts", (EnamelToolPart * 8)),
        ("head", c_int32),
    ]


class EnamelBur(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("part", c_int32),
        ("wear", c_double),
        ("turns", c_double),
        ("torque", c_double),
        ("inertia", c_double),
        ("drag", c_double),
        ("run_out", c_double),
        ("blades", c_int32),
        ("shaft_compliance", c_double),
        ("shaft_frequency", c_double),
        ("shaft_damping", c_double),
    ]


class EnamelKinematics(Structure):
    _fields_ = [
        ("q", (c_double * 7)),
        ("rates", (c_double * 7)),
        ("position", (c_double * 3)),
        ("rotation", (c_double * 9)),
        ("twist", (c_double * 6)),
        ("jacobian", ((c_double * 6) * 7)),
        ("inverse", ((c_double * 6) * 7)),
        ("gravity", (c_double * 7)),
        ("inertia", ((c_double * 7) * 7)),
    ]


class EnamelMechanism(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("joints", c_int32),
        ("name", c_char_p),
        ("max_torque", (c_double * 7)),
        ("encoder_step", (c_double * 7)),
        ("user", c_void_p),
        ("track", CFUNCTYPE(c_int32, c_void_p, POINTER(c_double), POINTER(c_double), POINTER(EnamelKinematics))),
        ("reach", CFUNCTYPE(c_int32, c_void_p, POINTER(EnamelPose), POINTER(c_double), POINTER(EnamelKinematics))),
    ]


class EnamelSessionDef(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("clutch_button", c_int32),
        ("device", c_char_p),
        ("mechanism", POINTER(EnamelMechanism)),
        ("scene", c_char_p),
        ("tool", POINTER(EnamelTool)),
        ("bur", POINTER(EnamelBur)),
        ("start", POINTER(EnamelPose)),
        ("renderer", c_char_p),
        ("parameters", POINTER(EnamelParameter)),
        ("parameter_count", c_size_t),
        ("plugin_folder", c_char_p),
        ("rate", c_double),
        ("base", POINTER(EnamelPose)),
        ("scale", c_double),
        ("centring", c_double),
        ("max_force", c_double),
        ("priority", c_int32),
        ("lock_memory", c_int32),
        ("shares_with", c_void_p),
        ("before_tick", CFUNCTYPE(None, c_void_p, c_void_p)),
        ("user", c_void_p),
    ]


class EnamelLayer(Structure):
    _fields_ = [
        ("material", EnamelMaterial),
        ("hardness", c_double),
        ("depth", c_double),
    ]


class EnamelObstacleDef(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("shape", c_int32),
        ("name", c_char_p),
        ("pose", EnamelPose),
        ("material", EnamelMaterial),
        ("dimensions", (c_double * 3)),
        ("thickness", c_double),
        ("vertices", POINTER(c_double)),
        ("vertex_count", c_size_t),
        ("triangles", POINTER(c_int32)),
        ("triangle_count", c_size_t),
        ("file", c_char_p),
        ("unit", c_double),
        ("layers", POINTER(EnamelLayer)),
        ("layer_count", c_size_t),
        ("cell", c_double),
        ("active", c_int32),
        ("reserved", c_int32),
        ("solid", c_void_p),
    ]


class EnamelLabelLayer(Structure):
    _fields_ = [
        ("material", EnamelMaterial),
        ("hardness", c_double),
        ("labels", POINTER(c_int32)),
        ("label_count", c_size_t),
    ]


class EnamelLabels(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("voxels", (c_int32 * 3)),
        ("labels", POINTER(c_uint16)),
        ("spacing", (c_double * 3)),
        ("origin", (c_double * 3)),
        ("axes", (c_double * 9)),
        ("layers", POINTER(EnamelLabelLayer)),
        ("layer_count", c_size_t),
        ("smoothing", c_double),
        ("cell", c_double),
    ]


class EnamelCutDifference(Structure):
    _fields_ = [
        ("over_cut", (c_double * 8)),
        ("under_cut", (c_double * 8)),
        ("area", c_double),
        ("mean", c_double),
        ("p95", c_double),
        ("deepest", c_double),
        ("highest", c_double),
    ]


class EnamelCutComparison(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("reserved", c_int32),
        ("removed", (c_double * 8)),
        ("planned", (c_double * 8)),
        ("whole", EnamelCutDifference),
        ("floors", EnamelCutDifference),
        ("walls", EnamelCutDifference),
        ("vertices", POINTER(c_double)),
        ("distance", POINTER(c_double)),
        ("prepared", POINTER(c_int32)),
        ("triangles", POINTER(c_int32)),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
    ]


class EnamelSurface(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("brick", c_int32),
        ("vertices", POINTER(c_double)),
        ("normals", POINTER(c_double)),
        ("layers", POINTER(c_int32)),
        ("triangles", POINTER(c_int32)),
        ("vertex_capacity", c_size_t),
        ("triangle_capacity", c_size_t),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
    ]


class EnamelGuide(Structure):
    _fields_ = [
        ("shape", c_int32),
        ("reserved", c_int32),
        ("pose", EnamelPose),
        ("dimensions", (c_double * 3)),
        ("points", POINTER(c_double)),
        ("point_count", c_size_t),
        ("stiffness", c_double),
        ("max_force", c_double),
    ]


class EnamelSnapshot(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("joints", c_int32),
        ("tick", c_uint64),
        ("time", c_double),
        ("position", (c_double * 3)),
        ("rotation", (c_double * 9)),
        ("twist", (c_double * 6)),
        ("wrench", (c_double * 6)),
        ("normal_force", c_double),
        ("base", (c_double * 3)),
        ("q", (c_double * 7)),
        ("command", (c_double * 7)),
        ("gripper", c_double),
        ("heat", c_double),
        ("removed", (c_double * 8)),
        ("missed", c_uint64),
        ("held", c_uint64),
        ("dropped_events", c_uint64),
        ("lost_cuts", c_uint64),
        ("unsent", c_uint64),
        ("bur_turns", c_double),
        ("bur_torque", c_double),
        ("bur_chatter", c_double),
        ("since_tick", c_double),
        ("mode", c_int32),
        ("status", c_int32),
        ("reason", c_int32),
        ("fault", c_int32),
        ("enabled", c_int32),
        ("clutched", c_int32),
        ("spins", c_int32),
        ("buttons", c_uint32),
        ("conditions", c_uint32),
        ("contact_count", c_int32),
        ("omitted_contacts", c_int32),
        ("contacts", (EnamelContact * 8)),
    ]


class EnamelEvent(Structure):
    _fields_ = [
        ("size", c_uint32),
        ("kind", c_int32),
        ("tick", c_uint64),
        ("time", c_double),
        ("obstacle", EnamelObstacle),
        ("point", (c_double * 3)),
        ("normal", (c_double * 3)),
        ("speed", c_double),
        ("impulse", c_double),
        ("removed", (c_double * 8)),
        ("count", c_uint64),
        ("extent", c_double),
        ("part", c_int32),
        ("reason", c_int32),
    ]


_FUNCTIONS = {
    "enamel_version": (c_uint32, []),
    "enamel_session_defaults": (c_int32, [POINTER(EnamelSessionDef)]),
    "enamel_obstacle_defaults": (c_int32, [POINTER(EnamelObstacleDef)]),
    "enamel_session_create": (c_int32, [POINTER(EnamelSessionDef), POINTER(c_void_p), EnamelMessage]),
    "enamel_session_destroy": (None, [c_void_p]),
    "enamel_message": (c_int32, [c_void_p, EnamelMessage]),
    "enamel_start": (c_int32, [c_void_p]),
    "enamel_start_device": (c_int32, [c_void_p, POINTER(EnamelDevice)]),
    "enamel_start_virtual": (c_int32, [c_void_p, EnamelHand, c_void_p]),
    "enamel_stop": (c_int32, [c_void_p]),
    "enamel_is_running": (c_int32, [c_void_p, POINTER(c_int32)]),
    "enamel_tick": (c_int32, [c_void_p, POINTER(EnamelMeasurement), POINTER(c_double)]),
    "enamel_snapshot": (c_int32, [c_void_p, POINTER(EnamelSnapshot)]),
    "enamel_next_event": (c_int32, [c_void_p, POINTER(EnamelEvent)]),
    "enamel_add": (c_int32, [c_void_p, POINTER(EnamelObstacleDef), POINTER(EnamelObstacle)]),
    "enamel_replace": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelObstacleDef)]),
    "enamel_remove": (c_int32, [c_void_p, EnamelObstacle]),
    "enamel_find": (c_int32, [c_void_p, c_char_p, POINTER(EnamelObstacle)]),
    "enamel_move": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelPose), POINTER(c_double)]),
    "enamel_set_material": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelMaterial)]),
    "enamel_set_suspension": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelSuspension)]),
    "enamel_set_tap": (c_int32, [c_void_p, EnamelObstacle, c_double, c_double]),
    "enamel_activate": (c_int32, [c_void_p, EnamelObstacle, c_int32]),
    "enamel_move_vertices": (c_int32, [c_void_p, EnamelObstacle, POINTER(c_int32), POINTER(c_double), c_size_t]),
    "enamel_restore": (c_int32, [c_void_p, EnamelObstacle]),
    "enamel_mark": (c_int32, [c_void_p, EnamelObstacle]),
    "enamel_undo": (c_int32, [c_void_p, EnamelObstacle]),
    "enamel_solid_bricks": (c_int32, [c_void_p, EnamelObstacle, POINTER(c_int32)]),
    "enamel_take_surface": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelSurface)]),
    "enamel_solid_load": (c_int32, [c_char_p, POINTER(c_void_p), EnamelMessage]),
    "enamel_labels_defaults": (c_int32, [POINTER(EnamelLabels)]),
    "enamel_solid_from_labels": (c_int32, [POINTER(EnamelLabels), POINTER(c_void_p), EnamelMessage]),
    "enamel_solid_copy": (c_int32, [c_void_p, EnamelObstacle, POINTER(c_void_p)]),
    "enamel_solid_destroy": (None, [c_void_p]),
    "enamel_solid_save": (c_int32, [c_void_p, c_char_p, EnamelMessage]),
    "enamel_solid_compare": (c_int32, [c_void_p, POINTER(EnamelObstacleDef), POINTER(c_double), POINTER(EnamelCutComparison), EnamelMessage]),
    "enamel_set_guides": (c_int32, [c_void_p, POINTER(EnamelGuide), c_size_t]),
    "enamel_named_tool": (c_int32, [c_char_p, POINTER(EnamelTool), EnamelMessage]),
    "enamel_set_tool": (c_int32, [c_void_p, POINTER(EnamelTool), POINTER(EnamelBur)]),
    "enamel_set_renderer": (c_int32, [c_void_p, c_char_p, POINTER(EnamelParameter), c_size_t]),
    "enamel_set_own_renderer": (c_int32, [c_void_p, POINTER(EnamelPlugin), POINTER(EnamelParameter), c_size_t]),
    "enamel_set_effect": (c_int32, [c_void_p, POINTER(c_double)]),
    "enamel_set_gripper": (c_int32, [c_void_p, c_double]),
    "enamel_spin": (c_int32, [c_void_p, c_int32]),
    "enamel_clutch": (c_int32, [c_void_p, c_int32]),
    "enamel_enable": (c_int32, [c_void_p, c_int32]),
    "enamel_reset": (c_int32, [c_void_p]),
    "enamel_record": (c_int32, [c_void_p, c_char_p]),
    "enamel_stop_recording": (c_int32, [c_void_p, POINTER(c_uint64), POINTER(c_uint64)]),
    "enamel_tick_measurement": (c_int32, [c_void_p, POINTER(EnamelMeasurement)]),
    "enamel_tick_move": (c_int32, [c_void_p, EnamelObstacle, POINTER(EnamelPose), POINTER(c_double)]),
    "enamel_tick_activate": (c_int32, [c_void_p, EnamelObstacle, c_int32]),
    "enamel_tick_spin": (c_int32, [c_void_p, c_int32]),
    "enamel_tick_effect": (c_int32, [c_void_p, POINTER(c_double)]),
    "enamel_tick_gripper": (c_int32, [c_void_p, c_double]),
    "enamel_virtual_create": (c_int32, [c_void_p, POINTER(c_void_p)]),
    "enamel_virtual_destroy": (None, [c_void_p]),
    "enamel_virtual_measure": (c_int32, [c_void_p, POINTER(EnamelMeasurement)]),
    "enamel_virtual_actuate": (c_int32, [c_void_p, POINTER(c_double)]),
    "enamel_virtual_advance": (c_int32, [c_void_p, POINTER(c_double)]),
    "enamel_virtual_state": (c_int32, [c_void_p, POINTER(EnamelPose), POINTER(c_double)]),
    "enamel_vector_from_unity": (None, [POINTER(c_double)]),
    "enamel_vector_to_unity": (None, [POINTER(c_double)]),
    "enamel_rotation_from_unity": (None, [POINTER(c_double), POINTER(c_double)]),
    "enamel_rotation_to_unity": (None, [POINTER(c_double), POINTER(c_double)]),
    "enamel_reason_text": (c_char_p, [c_int32]),
    "enamel_event_text": (c_char_p, [c_int32]),
    "enamel_result_text": (c_char_p, [c_int32]),
}
# generated from enamel.h: end


class EnamelError(Exception):
    """An error of the library, with its reason."""


def load(path=None):
    """Load libenamel: `path`, the environment variable ENAMEL_LIBRARY, or the system's."""
    name = "enamel.dll" if os.name == "nt" else "libenamel.so.0.2"
    library = ctypes.CDLL(path or os.environ.get("ENAMEL_LIBRARY") or name)
    for function, (result, arguments) in _FUNCTIONS.items():
        getattr(library, function).restype = result
        getattr(library, function).argtypes = arguments
    return library


def _member(struct, key, value):
    """Return a value for a member of a struct: texts become bytes. Raise EnamelError for an unknown member."""
    if key not in dict(struct._fields_):
        raise EnamelError("%s has no member \"%s\"" % (struct.__name__, key))
    return value.encode() if isinstance(value, str) else value


def _destroy(library, handle, kept):
    library.enamel_session_destroy(handle)
    kept.clear()


def _array(kind, values):
    values = list(values)
    return (kind * len(values))(*values)


def pose(position=(0.0, 0.0, 0.0), rotation=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)):
    """Return a pose: m, and the rows of a rotation matrix."""
    return EnamelPose(_array(c_double, position), _array(c_double, rotation))


def material(stiffness=float("inf"), friction=0.0, sliding_friction=None, viscosity=0.0, exponent=1.0, thickness=0.0,
             hysteresis=0.0, puncture=0.0, stribeck=0.0, roughness=0.0, wavelength=0.0):
    """Return a material: N/m, friction at rest, friction while sliding (default: the same), N s/m. Of a compliant layer
    also the exponent of force over depth, its thickness (m; 0: none), s/m, and the force that breaks it (N; 0: none).
    The Stribeck speed is in m/s. Of a rough surface also the root mean square height and the longest wavelength, m."""
    return EnamelMaterial(stiffness, friction, friction if sliding_friction is None else sliding_friction, viscosity,
                          exponent, thickness, hysteresis, puncture, stribeck, roughness, wavelength)


def bur(part=0, wear=0.05, turns=2000.0, torque=0.0, inertia=0.0, drag=0.3, run_out=0.0, blades=0,
        shaft_compliance=0.0, shaft_frequency=1000.0, shaft_damping=0.05):
    """Return a bur: part of the tool, Archard's coefficient, turns per second without a load. Of its motor also the
    torque at rest (N m; 0: the speed is constant), the inertia of the rotor (kg m^2; 0: 1e-8), and tangential over
    normal cutting force. Of its vibration the run-out (m) and the number of blades. Of its chatter the give of the shaft
    (m/N; 0: no chatter), its natural frequency (Hz) and its damping ratio."""
    return EnamelBur(ctypes.sizeof(EnamelBur), part, wear, turns, torque, inertia, drag, run_out, blades,
                     shaft_compliance, shaft_frequency, shaft_damping)


def tool(*parts):
    """Return a tool of capsules: (end, end, radius), in m."""
    result = EnamelTool(size=ctypes.sizeof(EnamelTool), count=len(parts))
    for number, (a, b, radius) in enumerate(parts):
        result.parts[number] = EnamelToolPart(_array(c_double, a), _array(c_double, b), radius)
    return result


class Session:
    """A session. Keyword arguments are the members of EnamelSessionDef: texts, numbers, structs by value."""

    def __init__(self, library=None, **definition):
        self.library = library or load()
        self.handle = c_void_p()
        self._kept = []  # objects that C refers to
        given = EnamelSessionDef()
        self.library.enamel_session_defaults(byref(given))
        for key, value in definition.items():
            value = _member(EnamelSessionDef, key, value)
            if isinstance(value, Structure):
                self._kept.append(value)
                value = ctypes.pointer(value)
            self._kept.append(value)
            setattr(given, key, value)
        text = ctypes.create_string_buffer(2048)
        message = EnamelMessage(ctypes.cast(text, c_void_p), len(text))
        if self.library.enamel_session_create(byref(given), byref(self.handle), message) != ENAMEL_OK:
            raise EnamelError(text.value.decode() or "enamel_session_create failed")
        # Also without close(), before the callbacks are freed and before the program ends.
        self._finalizer = weakref.finalize(self, _destroy, self.library, self.handle, self._kept)

    def close(self):
        self._finalizer()
        self.handle = c_void_p()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def call(self, name, *arguments):
        """Call enamel_NAME with this session; raise EnamelError on an error."""
        result = getattr(self.library, "enamel_" + name)(self.handle, *arguments)
        if result not in (ENAMEL_OK, ENAMEL_NOTHING):
            text = ctypes.create_string_buffer(2048)
            self.library.enamel_message(self.handle, EnamelMessage(ctypes.cast(text, c_void_p), len(text)))
            reason = text.value.decode() if result == ENAMEL_FAILED else self.library.enamel_result_text(result).decode()
            raise EnamelError("enamel_%s: %s" % (name, reason))
        return result

    def add_mesh(self, name, vertices, triangles, place=None, **members):
        """Add a mesh: vertices (x, y, z) in m, triangles (a, b, c). Members are those of EnamelObstacleDef."""
        if any(len(v) != 3 for v in vertices) or any(len(t) != 3 for t in triangles):
            raise EnamelError("add_mesh: a vertex must have 3 numbers, and a triangle 3 vertices")
        return self.add(name, ENAMEL_MESH, place, vertices=_array(c_double, (x for v in vertices for x in v)),
                        vertex_count=len(vertices), triangles=_array(c_int32, (i for t in triangles for i in t)),
                        triangle_count=len(triangles), **members)

    def add(self, name, shape, place=None, **members):
        """Add an obstacle and return its id."""
        given = EnamelObstacleDef()
        self.library.enamel_obstacle_defaults(byref(given))
        given.name, given.shape = name.encode(), shape
        if place is not None:
            given.pose = place
        for key, value in members.items():
            value = _member(EnamelObstacleDef, key, value)
            if isinstance(value, ctypes.Array) and key in ("vertices", "triangles", "layers"):
                value = ctypes.cast(value, dict(EnamelObstacleDef._fields_)[key])
            setattr(given, key, value)
        obstacle = EnamelObstacle()
        self.call("add", byref(given), byref(obstacle))
        return obstacle

    def move(self, obstacle, place):
        self.call("move", obstacle, byref(place), None)

    def remove(self, obstacle):
        self.call("remove", obstacle)

    def set_material(self, obstacle, given):
        self.call("set_material", obstacle, byref(given))

    def set_tool(self, given, bur=None):
        self.call("set_tool", byref(given), None if bur is None else byref(bur))

    def reset(self):
        """Continue after a fault of the guard."""
        self.call("reset")

    def start(self):
        """Run the loop on the device whose URL is `device` of the definition, such as virtual:FILE."""
        self.call("start")

    def start_virtual(self, hand=None):
        """Run the loop on a simulated device. `hand` is an EnamelHand; it must be fast: it runs in the loop."""
        callback = hand or ctypes.cast(None, EnamelHand)
        self._kept.append(callback)
        self.call("start_virtual", callback, None)

    def stop(self):
        self.call("stop")

    def snapshot(self):
        now = EnamelSnapshot(size=ctypes.sizeof(EnamelSnapshot))
        self.call("snapshot", byref(now))
        return now

    def events(self):
        """Return all waiting events."""
        found = []
        while True:
            event = EnamelEvent(size=ctypes.sizeof(EnamelEvent))
            if self.call("next_event", byref(event)) == ENAMEL_NOTHING:
                return found
            found.append(event)
