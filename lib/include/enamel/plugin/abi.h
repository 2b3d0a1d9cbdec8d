/* The interface between a host and a renderer plugin: C11 and C++17, plain data, no exceptions, no C++ types.
 *
 * A plugin is a shared library that exports one function, enamel_plugin(). Life of an instance:
 *
 *   create -> configure -> activate(period) -> step ... reset ... step -> deactivate -> destroy
 *
 * Threads: the host calls "setup" functions in one thread; they may allocate, lock and wait. It calls "tick" functions
 * in its real-time thread; they must not. Two functions of one instance never run at the same time. Different instances
 * may run in different threads.
 *
 * All numbers are SI. Poses, twists and contacts are in the world frame W (x right, y up, z from the wall to the user).
 */
#ifndef ENAMEL_PLUGIN_ABI_H
#define ENAMEL_PLUGIN_ABI_H

/* NOLINTBEGIN(modernize-deprecated-headers, readability-identifier-naming): this is C. */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Interface version. It increases when a struct or the meaning of a function changes. */
#define ENAMEL_ABI_VERSION 3u

/* Oldest version that hosts load. Version 2 does not have EnamelTickInput.age. Its plugins treat an old sample as a new
 * one. */
#define ENAMEL_OLDEST_ABI_VERSION 2u

/* Name of the exported function. */
#define ENAMEL_PLUGIN_SYMBOL "enamel_plugin"

#if defined(_WIN32)
#define ENAMEL_PLUGIN_EXPORT __declspec(dllexport)
#else
#define ENAMEL_PLUGIN_EXPORT __attribute__((visibility("default")))
#endif

#define ENAMEL_MAX_CONTACTS 8
#define ENAMEL_MAX_JOINTS 7

/* Result of a function that can fail. */
enum EnamelResult {
  ENAMEL_OK = 0,
  ENAMEL_NOT_FINITE = 1,    /* an input is NaN or infinite */
  ENAMEL_UNREACHABLE = 2,   /* no configuration of the device has this pose */
  ENAMEL_SINGULAR = 3,      /* the configuration is singular */
  ENAMEL_NOT_CONVERGED = 4, /* an iteration reached its limit */
  ENAMEL_OUT_OF_RANGE = 5,  /* an input is finite but impossible for a device */
  ENAMEL_STALE = 6,         /* the time of the input did not advance */
  ENAMEL_INACTIVE = 7,      /* step() was called before activate() */
  ENAMEL_WRONG_ORDER = 8,   /* a function was called out of order; nothing changed */
  ENAMEL_BAD_CONFIGURATION = 9
};

enum EnamelMode { ENAMEL_FREE = 0, ENAMEL_CONTACT = 1, ENAMEL_FAULT = 2 };

/* Kind of a renderer's output. */
enum EnamelAnswer {
  ENAMEL_TORQUE = 0, /* the torque of each joint, including gravity */
  ENAMEL_WRENCH = 1  /* the wall's wrench on the tool; the host computes tau = gravity + J^T wrench */
};

/* Optional inputs of a tick that a plugin may require: bits of EnamelPlugin.needs. */
#define ENAMEL_NEEDS_INERTIA 1u

/* Feature of an obstacle's surface at a point. */
enum EnamelFeature { ENAMEL_FACE = 0, ENAMEL_EDGE = 1, ENAMEL_VERTEX = 2 };

/* A point where the tool is near or inside an obstacle. */
typedef struct EnamelContact {
  double point[3];             /* point of the tool nearest to or deepest in the obstacle, W, m */
  double normal[3];            /* outward unit normal of the obstacle at that point, W */
  double gap;                  /* signed distance, m; negative inside the obstacle */
  double obstacle_velocity[3]; /* of the obstacle's material at the point, W, m/s */
  double stiffness;            /* along the normal, N/m; infinite: rigid. A layer: force over last compression */
  double friction;             /* largest ratio of tangential to normal force at rest */
  double sliding_friction;     /* the same while sliding, at most `friction` */
  double viscosity;            /* tangential force per sliding speed, N s/m */
  int32_t obstacle;            /* number of the obstacle in the scene */
  int32_t part;                /* number of the tool's part */
  int32_t triangle;            /* of the obstacle's mesh; -1: not a mesh */
  int32_t feature;             /* EnamelFeature at the nearest point of the obstacle */
  int32_t feature_index;       /* number of the edge or vertex of the triangle (0 to 2) or shape; -1: a face */
  uint32_t key;                /* the same from tick to tick while the contact slides; 0: unknown */
} EnamelContact;

/* Kinds of EnamelTickInput.applied. */
enum EnamelApplied {
  ENAMEL_APPLIED_UNKNOWN = 0,  /* undefined */
  ENAMEL_APPLIED_REPORTED = 1, /* the torque that acted since the last tick, as the device reports it */
  ENAMEL_APPLIED_SENT = 2      /* no report: the torque that was sent at the last tick; it acts after the delay */
};

/* Input of a tick. Arrays of joints have joint_count valid entries; the others are undefined.
 * If age is k > 0, the last sample is k periods old. All data except time, applied and age are then those of that
 * sample. The renderer predicts from them and returns an output as at any other tick. Ticks may be missing and samples
 * late: use time. */
typedef struct EnamelTickInput {
  double time;                          /* s, strictly increasing after reset() */
  double q[ENAMEL_MAX_JOINTS];          /* measured joint coordinates, rad or m */
  double rates[ENAMEL_MAX_JOINTS];      /* measured or filtered q', rad/s or m/s */
  double position[3];                   /* of the TCP, W, m */
  double rotation[9];                   /* of the platform, platform to W, row by row */
  double twist[6];                      /* of the TCP, W: v m/s, then w rad/s */
  double gravity[ENAMEL_MAX_JOINTS];    /* torque that balances gravity, N m or N */
  double max_torque[ENAMEL_MAX_JOINTS]; /* limit of each motor, N m or N */
  double applied[ENAMEL_MAX_JOINTS];    /* torque of the last tick, N m or N; see applied_known */
  /* jacobian[i] is the twist of a unit rate of joint i: twist = sum_i jacobian[i] rates[i]. A wrench F at the TCP
   * requires the torque tau_i = sum_k jacobian[i][k] F[k]. */
  double jacobian[ENAMEL_MAX_JOINTS][6];
  /* inverse[i] is the wrench of a unit torque of joint i: F = sum_i inverse[i] tau_i. Also
   * rates_i = sum_k inverse[i][k] twist[k]. */
  double inverse[ENAMEL_MAX_JOINTS][6];
  double inertia[ENAMEL_MAX_JOINTS][ENAMEL_MAX_JOINTS]; /* M(q), symmetric; undefined without ENAMEL_NEEDS_INERTIA */
  int32_t joint_count;                                  /* 1 to ENAMEL_MAX_JOINTS, the same at every tick */
  int32_t contact_count;                                /* 0 to ENAMEL_MAX_CONTACTS */
  int32_t applied_known;                                /* EnamelApplied */
  int32_t age;                                          /* age of the sample, periods; 0: a new sample */
  EnamelContact contacts[ENAMEL_MAX_CONTACTS];          /* deepest first; undefined from contact_count on */
} EnamelTickInput;

/* Output of a renderer. */
typedef struct EnamelTickOutput {
  double torque[ENAMEL_MAX_JOINTS]; /* N m or N, finite, within +-max_torque; 0 for ENAMEL_WRENCH and from joint_count
                                       on */
  double wrench[6];                 /* on the tool at the TCP, W, N and N m, finite; 0 for ENAMEL_TORQUE */
  double normal_force;              /* of the wall on the tool along the deepest contact's normal, N */
  int32_t answer;                   /* EnamelAnswer: whether torque or wrench is valid */
  int32_t mode;                     /* EnamelMode */
  int32_t saturated;                /* 1: a motor's limit reduced the torque */
  int32_t reserved;                 /* 0 */
} EnamelTickOutput;

/* One text parameter. */
typedef struct EnamelParameter {
  const char* key;
  const char* value;   /* in a description: the default, "" if the host must give a value */
  const char* meaning; /* with its unit; NULL in configure() */
} EnamelParameter;

/* Description of a plugin. Valid while the library is loaded. */
typedef struct EnamelDescription {
  const char* name;    /* for users: letters, digits, '-' */
  const char* version; /* of the plugin */
  const char* summary; /* one sentence */
  const EnamelParameter* parameters;
  size_t parameter_count;
} EnamelDescription;

/* Configuration of an instance. Valid during the call only. The host gives device and scene files by path, by their
 * TOML text, or both. With both, the path appears in messages and locates files that the text refers to. */
typedef struct EnamelConfiguration {
  const char* device_path; /* or NULL */
  const char* device_text; /* or NULL: read device_path */
  const char* scene_path;  /* or NULL */
  const char* scene_text;  /* or NULL: read scene_path; both NULL: unknown scene, contacts come with the ticks */
  const EnamelParameter* parameters; /* those that differ from their defaults */
  size_t parameter_count;
} EnamelConfiguration;

/* Buffer for the error message of a setup function: at most `size` bytes including the final 0. May be NULL with size
 * 0. */
typedef struct EnamelMessage {
  char* text;
  size_t size;
} EnamelMessage;

/* Functions of a plugin. `self` is the result of create(). */
typedef struct EnamelPlugin {
  uint32_t abi_version; /* ENAMEL_ABI_VERSION; all later fields may change with it */
  uint32_t plugin_size; /* sizeof(EnamelPlugin) */
  uint32_t input_size;  /* sizeof(EnamelTickInput) */
  uint32_t output_size; /* sizeof(EnamelTickOutput) */
  uint32_t needs;       /* ENAMEL_NEEDS_... or 0 */
  uint32_t reserved;    /* 0 */

  /* Setup. Return the description, never NULL. */
  const EnamelDescription* (*describe)(void);

  /* Setup. Create an instance. NULL: out of memory. */
  void* (*create)(void);

  /* Setup, any number of times while not active. Configure an instance. On an error it does not change. */
  int32_t (*configure)(void* self, const EnamelConfiguration* configuration, EnamelMessage message);

  /* Setup, after configure(). Prepare for ticks of `period` s, in 1e-5 to 0.1, and reset. Allocate memory here. */
  int32_t (*activate)(void* self, double period, EnamelMessage message);

  /* Tick. Compute the output. It is defined with every result. On any result but ENAMEL_OK, torque and wrench are 0,
   * the mode is ENAMEL_FAULT and the state is unchanged. ENAMEL_OUT_OF_RANGE: also for an unsupported number of joints.
   */
  int32_t (*step)(void* self, const EnamelTickInput* input, EnamelTickOutput* output);

  /* Tick. Restore the state after activate(). */
  void (*reset)(void* self);

  /* Setup. Deactivate: step() returns ENAMEL_INACTIVE until the next activate(). */
  void (*deactivate)(void* self);

  /* Setup, in any state. Destroy the instance. */
  void (*destroy)(void* self);

  /* Tick, while active. Return the size of the state between ticks, at most 16 MB; save it; load it. Equal states have
   * equal bytes. */
  size_t (*state_size)(const void* self);
  void (*save_state)(const void* self, void* state);
  void (*load_state)(void* self, const void* state);
} EnamelPlugin;

/* Setup. Return the table of functions; the only exported symbol. The table is valid while the library is loaded. */
ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-deprecated-headers, readability-identifier-naming) */

#endif
