/* Enamel for hosts in C and every language that can call C: one session per device, plain data. C99, ASCII, no global
 * state. The C++ session behind it: enamel/session/session.hpp.
 *
 * Life of a session:
 *
 *   enamel_session_defaults -> enamel_session_create -> enamel_start_... -> snapshot, events, changes ... ->
 *   enamel_stop -> enamel_session_destroy
 *
 * Conventions:
 * - All numbers are SI. Rotations are 3 x 3 matrices, row by row. The frame is that of the scene: x right, y up, z from
 *   the wall to the user (enamel_frame_from_unity() converts).
 * - Every struct with a `size` is initialised with its sizeof. Arrays of joints have entries up to the number of
 * joints.
 * - Functions return ENAMEL_OK or an error (EnamelResult, EnamelFailure). After an error nothing has changed, and
 *   enamel_message() has the reason. NULL as a handle gives ENAMEL_NULL.
 * - Threads: "any" functions may be called from any thread while the loop runs. They never make the loop wait.
 *   "loop" functions belong to the thread that runs the ticks. create, destroy and "owner" functions: one thread at a
 *   time, no other call with this handle at the same time.
 */
#ifndef ENAMEL_H
#define ENAMEL_H

/* NOLINTBEGIN(modernize-deprecated-headers, modernize-use-using, readability-identifier-naming): this is C. */
#include <stddef.h>
#include <stdint.h>

#include "enamel/plugin/driver.h"

#if defined(_WIN32)
#if defined(ENAMEL_BUILDS_DLL)
#define ENAMEL_API __declspec(dllexport)
#else
#define ENAMEL_API __declspec(dllimport)
#endif
#else
#define ENAMEL_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this header; enamel_version() has that of the library. The interface of 0.MINOR stays compatible. */
#define ENAMEL_VERSION_MAJOR 0
#define ENAMEL_VERSION_MINOR 2
#define ENAMEL_VERSION_PATCH 0

/* Further results. */
enum EnamelFailure {
  ENAMEL_FAILED = 100, /* see enamel_message() */
  ENAMEL_NULL = 101,   /* a handle or a required pointer is NULL */
  ENAMEL_SIZE = 102,   /* the `size` of a struct is not known: initialise it, or the header is newer than the library */
  ENAMEL_NOTHING = 103, /* no event, or no change, is waiting */
  ENAMEL_STOPPED = 104  /* of a tick: the guard has latched a fault */
};

#define ENAMEL_MAX_TOOL_PARTS 8
#define ENAMEL_MAX_LAYERS 8

typedef struct EnamelSession EnamelSession;             /* a session */
typedef struct EnamelVirtualDevice EnamelVirtualDevice; /* a simulated device for an own loop */
typedef struct EnamelTickAccess EnamelTickAccess;       /* valid during EnamelSessionDef.before_tick only */
typedef struct EnamelSolid EnamelSolid;                 /* a solid with its cuts, apart from all sessions */

/* Name of an obstacle. The name of a removed one is never used again. generation 0: no obstacle. */
typedef struct EnamelObstacle {
  int32_t slot;
  uint32_t generation;
} EnamelObstacle;

typedef struct EnamelPose {
  double position[3]; /* m */
  double rotation[9];
} EnamelPose;

typedef struct EnamelMaterial {
  double stiffness;        /* force at the hand per distance in the scene, N/m; infinite: rigid */
  double friction;         /* 0 to 10 */
  double sliding_friction; /* 0 to friction */
  double viscosity;        /* N s/m */
  double exponent;         /* of force over depth, 1 to 10: the stiffness is that at 1 mm; 0: 1, linear */
  double thickness;        /* at which a compliant layer bottoms out, m; 0: never */
  double hysteresis;       /* damping in proportion to the force, s/m */
  double puncture;         /* force at which the layer breaks, N; 0: never; needs a thickness */
  double stribeck;         /* sliding speed at which friction has fallen by 63 % to sliding_friction, m/s; 0: at once */
  double roughness;        /* root mean square height of a rough surface, m */
  double wavelength;       /* longest one of a rough surface, m */
} EnamelMaterial;

/* How an obstacle moves under contact forces, along and about the axes of its frame. 0 inertia: it does not. */
typedef struct EnamelSuspension {
  double centre[3];    /* of mass and springs, in the obstacle's frame, m */
  double inertia[6];   /* kg and kg m^2 */
  double stiffness[6]; /* N/m and N m/rad; 0: a loose obstacle */
  double damping[6];   /* N s/m and N m s/rad */
} EnamelSuspension;

typedef struct EnamelToolPart {
  double a[3], b[3]; /* ends of the axis in the platform's frame, m; equal: a sphere */
  double radius;     /* m */
} EnamelToolPart;

typedef struct EnamelTool {
  uint32_t size;
  int32_t count; /* 0 to ENAMEL_MAX_TOOL_PARTS */
  EnamelToolPart parts[ENAMEL_MAX_TOOL_PARTS];
  int32_t head; /* number of parts, from EnamelBur.part on, that spin together as a bur; 0: 1 */
} EnamelTool;

typedef struct EnamelBur {
  uint32_t size;
  int32_t part;            /* of the tool: the first one of the head */
  double wear;             /* Archard's coefficient */
  double turns;            /* per second, without a load */
  double torque;           /* of the motor at rest, N m: it falls linearly to 0 at `turns`; 0: the speed is constant */
  double inertia;          /* of rotor and bur, kg m^2; 0: 1e-8 */
  double drag;             /* tangential over normal cutting force */
  double run_out;          /* of the head, m */
  int32_t blades;          /* 0: grit */
  double shaft_compliance; /* give of the shaft that carries the head, m/N; 0: rigid, no chatter */
  double shaft_frequency;  /* its natural frequency, Hz */
  double shaft_damping;    /* its damping ratio */
} EnamelBur;

/* State of a device as an own mechanism computes it. See EnamelTickInput for jacobian and inverse. */
typedef struct EnamelKinematics {
  double q[ENAMEL_MAX_JOINTS];
  double rates[ENAMEL_MAX_JOINTS];
  double position[3];
  double rotation[9];
  double twist[6];
  double jacobian[ENAMEL_MAX_JOINTS][6];
  double inverse[ENAMEL_MAX_JOINTS][6];
  double gravity[ENAMEL_MAX_JOINTS];
  double inertia[ENAMEL_MAX_JOINTS][ENAMEL_MAX_JOINTS];
} EnamelKinematics;

/* An own mechanism. Its functions return an EnamelResult, must be safe in real time, and may run in several threads. */
typedef struct EnamelMechanism {
  uint32_t size;
  int32_t joints; /* 1 to ENAMEL_MAX_JOINTS */
  const char* name;
  double max_torque[ENAMEL_MAX_JOINTS];   /* of each motor, N m or N; 0: no motor */
  double encoder_step[ENAMEL_MAX_JOINTS]; /* rad or m, positive */
  void* user;
  /* Forward kinematics. `state` has the last state as a start, and receives everything. */
  int32_t (*track)(void* user, const double* q, const double* rates, EnamelKinematics* state);
  /* Inverse kinematics: fill in everything from pose and twist. The pose 0 must be reachable: it is home. */
  int32_t (*reach)(void* user, const EnamelPose* pose, const double* twist, EnamelKinematics* state);
} EnamelMechanism;

/* Definition of a session. enamel_session_defaults() fills it in. Texts and pointers are read during create only. */
typedef struct EnamelSessionDef {
  uint32_t size;
  int32_t clutch_button;            /* -1: none */
  const char* device;               /* device file, or URL for enamel_start(); NULL: mechanism, or the nominal TAU */
  const EnamelMechanism* mechanism; /* NULL: none. Its `user` must outlive the session */
  const char* scene;                /* scene file; NULL: no obstacles at first */
  const EnamelTool* tool;           /* NULL: that of the scene file, or a point */
  const EnamelBur* bur;             /* NULL: that of the scene file, or none */
  const EnamelPose* start;          /* of the tool in the scene; NULL: that of the scene file, or home */
  const char* renderer;             /* name of a linked renderer or a plugin, or a plugin's path */
  const EnamelParameter* parameters;
  size_t parameter_count;
  const char* plugin_folder;  /* of renderers and drivers; NULL: renderers by path only, no drivers */
  double rate;                /* Hz */
  const EnamelPose* base;     /* of the device in the scene; NULL: frames are the same */
  double scale;               /* metres of the tool per metre of the device */
  double centring;            /* 0 to 0.5 */
  double max_force;           /* at the hand, N; infinite: no limit */
  int32_t priority;           /* SCHED_FIFO */
  int32_t lock_memory;        /* 1: lock memory while the loop runs */
  EnamelSession* shares_with; /* NULL, or another session that has not run yet: both have its obstacles */
  void (*before_tick)(void* user, EnamelTickAccess* access); /* NULL, or called before each tick on the loop's thread */
  void* user;
} EnamelSessionDef;

enum EnamelShape {
  ENAMEL_HALF_SPACE = 0, /* below z = 0 of its frame */
  ENAMEL_BOX = 1,        /* dimensions: half edges */
  ENAMEL_SPHERE = 2,     /* dimensions[0]: radius */
  ENAMEL_CAPSULE = 3,    /* dimensions[0]: radius, dimensions[1]: half length along z */
  ENAMEL_MESH = 4,       /* vertices and triangles */
  ENAMEL_SOLID = 5       /* the same, closed, and layers: a bur can cut it */
};

/* One layer of a solid. */
typedef struct EnamelLayer {
  EnamelMaterial material;
  double hardness; /* Pa */
  double depth;    /* below the surface, m */
} EnamelLayer;

/* Definition of an obstacle. Arrays are copied. */
typedef struct EnamelObstacleDef {
  uint32_t size;
  int32_t shape; /* EnamelShape */
  const char* name;
  EnamelPose pose;
  EnamelMaterial material; /* not of solids */
  double dimensions[3];    /* m */
  double thickness;        /* above 0: the mesh is a sheet, m */
  const double* vertices;  /* 3 numbers each, m */
  size_t vertex_count;
  const int32_t* triangles; /* 3 vertices each, counter-clockwise from outside */
  size_t triangle_count;
  const char* file;          /* instead of the arrays: a mesh file (PLY, OBJ, STL, OFF); NULL: the arrays */
  double unit;               /* of the file's coordinates, m */
  const EnamelLayer* layers; /* the outermost first */
  size_t layer_count;
  double cell;    /* of a solid, m */
  int32_t active; /* 0: reserved for later */
  int32_t reserved;
  const EnamelSolid* solid; /* of ENAMEL_SOLID, instead of mesh, layers and cell; copied; NULL: those */
} EnamelObstacleDef;

/* One layer of a solid made of labels. */
typedef struct EnamelLabelLayer {
  EnamelMaterial material;
  double hardness; /* Pa */
  const int32_t* labels;
  size_t label_count;
} EnamelLabelLayer;

/* Labels of voxels, such as a segmented CT. enamel_labels_defaults() fills it in. */
typedef struct EnamelLabels {
  uint32_t size;
  int32_t voxels[3];              /* number along the axes */
  const uint16_t* labels;         /* of all voxels, the first axis is the fastest */
  double spacing[3];              /* between the centres of voxels, m */
  double origin[3];               /* centre of the first voxel, m */
  double axes[9];                 /* the columns are the directions of the axes */
  const EnamelLabelLayer* layers; /* the outermost first */
  size_t layer_count;
  double smoothing; /* standard deviation of a Gaussian mean, m; negative: the mean spacing */
  double cell;      /* of the solid, m */
} EnamelLabels;

/* Differences of a cut solid from its target in one region; volumes in m^3 by layer. */
typedef struct EnamelCutDifference {
  double over_cut[ENAMEL_MAX_LAYERS];  /* removed but part of the target */
  double under_cut[ENAMEL_MAX_LAYERS]; /* present but not part of the target */
  double area;                         /* of the prepared surface, m^2 */
  double mean, p95;                    /* of its distance from the target's surface, m */
  double deepest, highest;             /* largest distance where too much, and where too little, is removed, m */
} EnamelCutDifference;

/* A comparison with the target of a preparation. The arrays belong to the cut solid: until its next comparison. */
typedef struct EnamelCutComparison {
  uint32_t size;
  int32_t reserved;
  double removed[ENAMEL_MAX_LAYERS]; /* by the cuts, m^3 by layer */
  double planned[ENAMEL_MAX_LAYERS]; /* that cuts to the target would remove */
  EnamelCutDifference whole;
  EnamelCutDifference floors; /* nearest to faces of the target whose normal is within 45 deg of the axis */
  EnamelCutDifference walls;
  const double* vertices;   /* of the cut surface, 3 numbers each, m */
  const double* distance;   /* of each vertex from the target's surface, m; positive: material should go */
  const int32_t* prepared;  /* 1: the vertex is in the preparation */
  const int32_t* triangles; /* 3 vertices each */
  size_t vertex_count, triangle_count;
} EnamelCutComparison;

/* Triangles of one brick of a solid, for drawing, in the frame of the solid. The caller gives the memory: 3 numbers a
 * vertex, a normal and a triangle. Layers are those just below the surface. */
#define ENAMEL_SURFACE_VERTICES 5200
#define ENAMEL_SURFACE_TRIANGLES 6200
typedef struct EnamelSurface {
  uint32_t size;
  int32_t brick;            /* in: the uncut surface of this brick; -1: the next brick that changed. Out: its number */
  double* vertices;         /* m */
  double* normals;          /* outward, unit length */
  int32_t* layers;          /* one number a vertex */
  int32_t* triangles;       /* 3 vertices each */
  size_t vertex_capacity;   /* at least ENAMEL_SURFACE_VERTICES */
  size_t triangle_capacity; /* at least ENAMEL_SURFACE_TRIANGLES */
  size_t vertex_count, triangle_count;
} EnamelSurface;

enum EnamelGuideShape {
  ENAMEL_GUIDE_LINE = 0,       /* points; dimensions[0]: radius, 0: the line itself */
  ENAMEL_GUIDE_PLANE = 1,      /* z = 0 of its frame */
  ENAMEL_GUIDE_HALF_SPACE = 2, /* the side z > 0 */
  ENAMEL_GUIDE_BOX = 3         /* dimensions: half edges; the tool stays inside */
};

/* A soft force towards a line, a surface or a region. */
typedef struct EnamelGuide {
  int32_t shape; /* EnamelGuideShape */
  int32_t reserved;
  EnamelPose pose;
  double dimensions[3]; /* m */
  const double* points; /* 3 numbers each, in the guide's frame, m; copied */
  size_t point_count;
  double stiffness; /* force at the hand per distance in the scene, N/m */
  double max_force; /* at the hand, N */
} EnamelGuide;

/* State after one tick. Poses and contacts are those of the tool in the scene, forces those at the hand. */
typedef struct EnamelSnapshot {
  uint32_t size;
  int32_t joints;
  uint64_t tick; /* number of the tick */
  double time;   /* s */
  double position[3];
  double rotation[9];
  double twist[6];
  double wrench[6];                  /* of the rendered part, N and N m */
  double normal_force;               /* of the deepest contact alone, N: use wrench for the whole force */
  double base[3];                    /* of the device in the scene, m: changes with the clutch */
  double q[ENAMEL_MAX_JOINTS];       /* as measured */
  double command[ENAMEL_MAX_JOINTS]; /* torque of the motors, N m or N */
  double gripper;                    /* rad; NaN: none */
  double heat;                       /* as EnamelMeasurement */
  double removed[ENAMEL_MAX_LAYERS]; /* material removed since the start, m^3 by layer */
  uint64_t missed, held, dropped_events, lost_cuts;
  uint64_t unsent;    /* commands that the device of enamel_start_device() refused */
  double bur_turns;   /* speed of the bur, turns per second */
  double bur_torque;  /* of the cut on its motor, N m */
  double bur_chatter; /* amplitude of its chatter, m */
  double since_tick;  /* s since the last tick began: grows if the loop hangs; 0: no loop runs */
  int32_t mode;       /* EnamelMode */
  int32_t status;     /* EnamelResult of the tick, or ENAMEL_STOPPED */
  int32_t reason;     /* of the guard for this tick: enamel_reason_text() */
  int32_t fault;      /* latched; 0: none */
  int32_t enabled, clutched, spins;
  uint32_t buttons, conditions;
  int32_t contact_count;    /* near contacts: those with a gap above 0 do not touch */
  int32_t omitted_contacts; /* further ones for which there was no room */
  EnamelContact contacts[ENAMEL_MAX_CONTACTS];
} EnamelSnapshot;

enum EnamelEventKind {
  ENAMEL_CONTACT_BEGIN = 0,
  ENAMEL_CONTACT_END = 1,
  ENAMEL_GUARD_STOP = 2,
  ENAMEL_CUT = 3,
  ENAMEL_MISSED = 4,
  ENAMEL_DEVICE_LOST = 5,
  ENAMEL_DEVICE_BACK = 6,
  ENAMEL_RECORDING_END = 7,
  ENAMEL_UNUSUAL_SIZE = 8 /* a new mesh or solid is probably in another unit: extent */
};

typedef struct EnamelEvent {
  uint32_t size;
  int32_t kind; /* EnamelEventKind */
  uint64_t tick;
  double time; /* s */
  EnamelObstacle obstacle;
  double point[3], normal[3];
  double speed;                      /* of a contact that begins, m/s */
  double impulse;                    /* of a contact that ends, at the hand, N s */
  double removed[ENAMEL_MAX_LAYERS]; /* of a cut, m^3 by layer */
  uint64_t count;                    /* of missed periods */
  double extent;                     /* of an unusual size, m */
  int32_t part;
  int32_t reason; /* of a stop by the guard */
} EnamelEvent;

/* Version of the library: major * 65536 + minor * 256 + patch. Any thread. */
ENAMEL_API uint32_t enamel_version(void);

/* Fill in defaults, also `size`. Any thread. An obstacle is a rigid half space without friction at the origin, active,
 * with cells of 0.1 mm and files in mm. It needs a name that is unique. */
ENAMEL_API int32_t enamel_session_defaults(EnamelSessionDef* def);
ENAMEL_API int32_t enamel_obstacle_defaults(EnamelObstacleDef* def);

/* Create a session. `message` receives the reason of an error; it may be {NULL, 0}. */
ENAMEL_API int32_t enamel_session_create(const EnamelSessionDef* def, EnamelSession** session, EnamelMessage message);

/* Stop and destroy. NULL does nothing. Virtual devices of the session must be destroyed before. */
ENAMEL_API void enamel_session_destroy(EnamelSession* session);

/* Copy the reason of the last error of this session. Any thread. */
ENAMEL_API int32_t enamel_message(EnamelSession* session, EnamelMessage message);

/* Run a loop in a thread of its own: with the device whose URL is EnamelSessionDef.device, with an own device, or with
 * a simulated one that `hand` holds. `enamel devices` lists the forms of URLs. `hand` gives the wrench on the tool at
 * the TCP (N, N m) in the device's frame, on the loop's thread. NULL: it pushes along -z with 1 N, to 20 mm behind the
 * start, and holds the tool across. `device->user` and `user` must live until enamel_stop().
 * hand and before_tick must not call functions of the session, except enamel_tick_...(). A device whose measure does
 * not return blocks start and stop. enamel_reset() does not bring a simulated device back that has left its workspace:
 * stop and start. Owner. */
typedef void (*EnamelHand)(void* user, double time, const EnamelPose* pose, const double* twist, double* wrench);
ENAMEL_API int32_t enamel_start(EnamelSession* session);
ENAMEL_API int32_t enamel_start_device(EnamelSession* session, const EnamelDevice* device);
ENAMEL_API int32_t enamel_start_virtual(EnamelSession* session, EnamelHand hand, void* user);

/* Ramp out and end the loop, or mark the end of an own loop. Owner. */
ENAMEL_API int32_t enamel_stop(EnamelSession* session);
ENAMEL_API int32_t enamel_is_running(EnamelSession* session, int32_t* running); /* any */

/* Run one tick in an own loop. `effort` receives the torques for the motors with every result. Returns the status of
 * the tick; ENAMEL_INACTIVE while the loop of enamel_start_...() runs. Loop; safe in real time after the first call. */
ENAMEL_API int32_t enamel_tick(EnamelSession* session, const EnamelMeasurement* measurement, double* effort);

/* Newest state, and oldest event (ENAMEL_NOTHING: none). Initialise `size`. Any. */
ENAMEL_API int32_t enamel_snapshot(EnamelSession* session, EnamelSnapshot* snapshot);
ENAMEL_API int32_t enamel_next_event(EnamelSession* session, EnamelEvent* event);

/* Obstacles. Any. enamel_find: ENAMEL_NOTHING if the name is unknown. */
ENAMEL_API int32_t enamel_add(EnamelSession* session, const EnamelObstacleDef* def, EnamelObstacle* obstacle);
ENAMEL_API int32_t enamel_replace(EnamelSession* session, EnamelObstacle obstacle, const EnamelObstacleDef* by);
ENAMEL_API int32_t enamel_remove(EnamelSession* session, EnamelObstacle obstacle);
ENAMEL_API int32_t enamel_find(EnamelSession* session, const char* name, EnamelObstacle* obstacle);
ENAMEL_API int32_t enamel_move(EnamelSession* session, EnamelObstacle obstacle, const EnamelPose* pose,
                               const double* twist); /* twist: NULL is at rest */
ENAMEL_API int32_t enamel_set_material(EnamelSession* session, EnamelObstacle obstacle, const EnamelMaterial* material);
ENAMEL_API int32_t enamel_set_suspension(EnamelSession* session, EnamelObstacle obstacle,
                                         const EnamelSuspension* suspension); /* NULL: a fixed obstacle */
/* Vibration of the handle after a tap: 10 to 1000 Hz, 0 to 2000 1/s; both 0: none. */
ENAMEL_API int32_t enamel_set_tap(EnamelSession* session, EnamelObstacle obstacle, double frequency, double decay);
ENAMEL_API int32_t enamel_activate(EnamelSession* session, EnamelObstacle obstacle, int32_t active);
ENAMEL_API int32_t enamel_move_vertices(EnamelSession* session, EnamelObstacle obstacle, const int32_t* vertices,
                                        const double* positions, size_t count);
/* Make a solid whole. Then draw its uncut bricks again. */
ENAMEL_API int32_t enamel_restore(EnamelSession* session, EnamelObstacle obstacle);
/* Begin a stroke, and undo the last one. Without a stroke, undo does nothing. Not if two sessions share the solid. */
ENAMEL_API int32_t enamel_mark(EnamelSession* session, EnamelObstacle obstacle);
ENAMEL_API int32_t enamel_undo(EnamelSession* session, EnamelObstacle obstacle);

/* Draw a solid that is cut: draw each of its bricks once, then those that changed. ENAMEL_NOTHING: none has changed. A
 * brick replaces the triangles that were drawn for it. */
ENAMEL_API int32_t enamel_solid_bricks(EnamelSession* session, EnamelObstacle obstacle, int32_t* count);
ENAMEL_API int32_t enamel_take_surface(EnamelSession* session, EnamelObstacle obstacle, EnamelSurface* surface);

/* Solids apart from sessions: load a file (.solid), make one of labels, or copy that of a session with the cuts that
 * its loop has sent. After enamel_stop() these are all. One thread at a time may use a solid. Destroying NULL does
 * nothing.
 */
ENAMEL_API int32_t enamel_solid_load(const char* file, EnamelSolid** solid, EnamelMessage message);
ENAMEL_API int32_t enamel_labels_defaults(EnamelLabels* labels);
ENAMEL_API int32_t enamel_solid_from_labels(const EnamelLabels* labels, EnamelSolid** solid, EnamelMessage message);
ENAMEL_API int32_t enamel_solid_copy(EnamelSession* session, EnamelObstacle obstacle, EnamelSolid** solid);
ENAMEL_API void enamel_solid_destroy(EnamelSolid* solid);
ENAMEL_API int32_t enamel_solid_save(const EnamelSolid* solid, const char* file, EnamelMessage message);
/* Compare with a target, whose pose is ignored: a closed mesh (ENAMEL_MESH), or `solid` of an ENAMEL_SOLID. `axis`
 * points out of the tooth; NULL: z. About a second for a molar. */
ENAMEL_API int32_t enamel_solid_compare(EnamelSolid* solid, const EnamelObstacleDef* target, const double* axis,
                                        EnamelCutComparison* comparison, EnamelMessage message);

/* Set all guides. They replace the ones before, and ramp in. NULL and 0: none. Any. */
ENAMEL_API int32_t enamel_set_guides(EnamelSession* session, const EnamelGuide* guides, size_t guide_count);

/* A dental tool by its name, for example "flame-012-080" (lib/docs/preparation.md). Any. */
ENAMEL_API int32_t enamel_named_tool(const char* name, EnamelTool* tool, EnamelMessage message);

/* Tool, renderer, control. Any. */
ENAMEL_API int32_t enamel_set_tool(EnamelSession* session, const EnamelTool* tool, const EnamelBur* bur);
ENAMEL_API int32_t enamel_set_renderer(EnamelSession* session, const char* name, const EnamelParameter* parameters,
                                       size_t parameter_count);
/* An own renderer, by its table of functions (abi.h). The table must outlive the session. */
ENAMEL_API int32_t enamel_set_own_renderer(EnamelSession* session, const EnamelPlugin* table,
                                           const EnamelParameter* parameters, size_t parameter_count);
ENAMEL_API int32_t enamel_set_effect(EnamelSession* session, const double* wrench);
/* Force of the gripper's motor, N, opening it. The device cuts it at its limit. */
ENAMEL_API int32_t enamel_set_gripper(EnamelSession* session, double force);
ENAMEL_API int32_t enamel_spin(EnamelSession* session, int32_t on);
ENAMEL_API int32_t enamel_clutch(EnamelSession* session, int32_t on);
ENAMEL_API int32_t enamel_enable(EnamelSession* session, int32_t on);
ENAMEL_API int32_t enamel_reset(EnamelSession* session);
ENAMEL_API int32_t enamel_record(EnamelSession* session, const char* path);
ENAMEL_API int32_t enamel_stop_recording(EnamelSession* session, uint64_t* ticks, uint64_t* lost);

/* For before_tick. Loop; safe in real time. */
ENAMEL_API int32_t enamel_tick_measurement(EnamelTickAccess* access, EnamelMeasurement* measurement);
ENAMEL_API int32_t enamel_tick_move(EnamelTickAccess* access, EnamelObstacle obstacle, const EnamelPose* pose,
                                    const double* twist);
ENAMEL_API int32_t enamel_tick_activate(EnamelTickAccess* access, EnamelObstacle obstacle, int32_t active);
ENAMEL_API int32_t enamel_tick_spin(EnamelTickAccess* access, int32_t on);
ENAMEL_API int32_t enamel_tick_effect(EnamelTickAccess* access, const double* wrench);
ENAMEL_API int32_t enamel_tick_gripper(EnamelTickAccess* access, double force);

/* A simulated device for an own loop, at rest at the session's start, with exact time steps. The session must outlive
 * it. measure -> enamel_tick -> actuate -> advance: the hand's wrench (N, N m, in the device's frame) acts for one
 * period. position (m) and twist are the true ones of the device. Loop. */
ENAMEL_API int32_t enamel_virtual_create(EnamelSession* session, EnamelVirtualDevice** device);
ENAMEL_API void enamel_virtual_destroy(EnamelVirtualDevice* device);
ENAMEL_API int32_t enamel_virtual_measure(EnamelVirtualDevice* device, EnamelMeasurement* measurement);
ENAMEL_API int32_t enamel_virtual_actuate(EnamelVirtualDevice* device, const double* effort);
ENAMEL_API int32_t enamel_virtual_advance(EnamelVirtualDevice* device, const double* wrench);
ENAMEL_API int32_t enamel_virtual_state(EnamelVirtualDevice* device, EnamelPose* pose, double* twist);

/* Convert between Enamel's frame and that of Unity (left-handed: x right, y up, z away from the user), in place. A
 * point or direction has 3 numbers. A rotation (9 numbers) of Unity is that of a matrix; quaternions have x, y, z, w.
 */
ENAMEL_API void enamel_vector_from_unity(double* vector);
ENAMEL_API void enamel_vector_to_unity(double* vector);
ENAMEL_API void enamel_rotation_from_unity(const double* quaternion, double* rotation);
ENAMEL_API void enamel_rotation_to_unity(const double* rotation, double* quaternion);

/* Names in plain words. Any thread; valid forever. */
ENAMEL_API const char* enamel_reason_text(int32_t reason);
ENAMEL_API const char* enamel_event_text(int32_t kind);
ENAMEL_API const char* enamel_result_text(int32_t result);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-deprecated-headers, modernize-use-using, readability-identifier-naming) */

#endif
