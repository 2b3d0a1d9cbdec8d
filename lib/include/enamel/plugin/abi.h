/* The boundary between a host and a renderer plugin: C11 and C++17, plain data, no exceptions, no C++ types.
 *
 * A plugin is a shared library that exports one function, enamel_plugin(). Life of an instance:
 *
 *   create -> configure -> activate(period) -> step ... reset ... step -> deactivate -> destroy
 *
 * Threads: "setup" functions run in one thread that may allocate, lock and wait; "tick" functions run in the host's
 * real-time thread and must not. No two functions of one instance run at the same time; different instances may run in
 * different threads. All numbers are SI; poses, twists and contacts are in the world frame W (x right, y up, z from the
 * wall to the user).
 */
#ifndef ENAMEL_PLUGIN_ABI_H
#define ENAMEL_PLUGIN_ABI_H

/* NOLINTBEGIN(modernize-deprecated-headers, readability-identifier-naming): this is C. */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when any struct or the meaning of any function changes. */
#define ENAMEL_ABI_VERSION 3u

/* The oldest version that hosts still load. Version 2 had no EnamelTickInput.age: its plugins take an old sample for a new
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

/* What every function that can fail answers. */
enum EnamelResult {
  ENAMEL_OK = 0,
  ENAMEL_NOT_FINITE = 1,    /* an input is NaN or infinite */
  ENAMEL_UNREACHABLE = 2,   /* no configuration of the device has this pose */
  ENAMEL_SINGULAR = 3,      /* the configuration is singular */
  ENAMEL_NOT_CONVERGED = 4, /* an iteration reached its limit */
  ENAMEL_OUT_OF_RANGE = 5,  /* an input is finite but beyond what a device can do */
  ENAMEL_STALE = 6,         /* the input's time has not advanced */
  ENAMEL_INACTIVE = 7,      /* step() without activate() */
  ENAMEL_WRONG_ORDER = 8,   /* a function was called out of order; nothing has changed */
  ENAMEL_BAD_CONFIGURATION = 9
};

enum EnamelMode { ENAMEL_FREE = 0, ENAMEL_CONTACT = 1, ENAMEL_FAULT = 2 };

/* What a renderer answers with. */
enum EnamelAnswer {
  ENAMEL_TORQUE = 0, /* the torque of every joint, gravity included */
  ENAMEL_WRENCH = 1  /* the wall's wrench on the tool: the host adds the gravity torque, tau = gravity + J^T wrench */
};

/* What a plugin may ask for beyond what every tick has; bits of EnamelPlugin.needs. */
#define ENAMEL_NEEDS_INERTIA 1u

/* What a place on an obstacle's surface lies on. */
enum EnamelFeature { ENAMEL_FACE = 0, ENAMEL_EDGE = 1, ENAMEL_VERTEX = 2 };

/* One place where the tool is near or in an obstacle. */
typedef struct EnamelContact {
  double point[3];             /* of the tool, nearest to or deepest in the obstacle, W, m */
  double normal[3];            /* outward unit normal of the obstacle there, W */
  double gap;                  /* signed distance, m; negative inside the obstacle */
  double obstacle_velocity[3]; /* of the obstacle's material at the point, W, m/s */
  double stiffness;            /* of the obstacle's surface along the normal, N/m; infinite: rigid */
  double friction;             /* its largest tangential over normal force at rest */
  double sliding_friction;     /* the same while it slides, at most `friction` */
  double viscosity;            /* on the sliding speed, N s/m */
  int32_t obstacle;            /* number of the obstacle in the scene */
  int32_t part;                /* number of the tool's part */
  int32_t triangle;            /* of the obstacle's mesh; -1: it has none */
  int32_t feature;             /* EnamelFeature: what the nearest point of the obstacle lies on */
  int32_t feature_index;       /* which edge or vertex of the triangle (0 to 2) or shape; -1: a face */
  uint32_t key;                /* the same from tick to tick while the contact slides on; 0: the host does not tell */
} EnamelContact;

/* What is known at a tick. Joints: the first joint_count entries; those beyond are undefined.
 * Where age is k > 0, no sample came for k periods: everything but time, applied and age is that of the last sample. A
 * renderer predicts from it and answers as at any other tick. Ticks may be missing and samples late: see time. */
typedef struct EnamelTickInput {
  double time;                          /* s, strictly increasing after reset() */
  double q[ENAMEL_MAX_JOINTS];          /* measured joint coordinates, rad or m */
  double rates[ENAMEL_MAX_JOINTS];      /* measured or filtered q', rad/s or m/s */
  double position[3];                   /* of the TCP, W, m */
  double rotation[9];                   /* of the platform, platform to W, row after row */
  double twist[6];                      /* of the TCP, W: v m/s, then w rad/s */
  double gravity[ENAMEL_MAX_JOINTS];    /* torque that balances gravity, N m or N */
  double max_torque[ENAMEL_MAX_JOINTS]; /* limit of every motor, N m or N */
  double applied[ENAMEL_MAX_JOINTS];    /* torque that really acted since the last tick, N m or N; see applied_known */
  /* jacobian[i] is the twist of a unit rate of joint i: twist = sum_i jacobian[i] rates[i], and a wrench F at the TCP asks
   * for the torque tau_i = sum_k jacobian[i][k] F[k]. */
  double jacobian[ENAMEL_MAX_JOINTS][6];
  /* inverse[i] is the wrench of a unit torque of joint i: F = sum_i inverse[i] tau_i, rates_i = sum_k inverse[i][k]
   * twist[k]. */
  double inverse[ENAMEL_MAX_JOINTS][6];
  double inertia[ENAMEL_MAX_JOINTS][ENAMEL_MAX_JOINTS]; /* M(q), symmetric; undefined without ENAMEL_NEEDS_INERTIA */
  int32_t joint_count;   /* 1 to ENAMEL_MAX_JOINTS, the same at every tick */
  int32_t contact_count; /* 0 to ENAMEL_MAX_CONTACTS */
  int32_t applied_known; /* 0: the device cannot tell, `applied` is undefined */
  int32_t age;           /* periods since the sample; 0: a new sample */
  EnamelContact contacts[ENAMEL_MAX_CONTACTS]; /* the deepest first; beyond contact_count: undefined */
} EnamelTickInput;

/* What a renderer asks for. */
typedef struct EnamelTickOutput {
  double torque[ENAMEL_MAX_JOINTS]; /* N m or N, finite and within +-max_torque; 0 for ENAMEL_WRENCH and beyond joint_count */
  double wrench[6];    /* on the tool at the TCP, W, N and N m, finite; 0 for ENAMEL_TORQUE */
  double normal_force; /* of the wall on the tool along the deepest contact's normal, N */
  int32_t answer;      /* EnamelAnswer: which of the two counts */
  int32_t mode;        /* EnamelMode */
  int32_t saturated;   /* 1: a motor's limit cut the torque */
  int32_t reserved;    /* 0 */
} EnamelTickOutput;

/* One text parameter. */
typedef struct EnamelParameter {
  const char* key;
  const char* value;   /* in a description: the default, "" where the host must give one */
  const char* meaning; /* with its unit; NULL when given to configure() */
} EnamelParameter;

/* What a plugin is. Lives as long as the library is loaded. */
typedef struct EnamelDescription {
  const char* name;    /* as users type it: letters, digits, '-' */
  const char* version; /* of the plugin */
  const char* summary; /* one sentence */
  const EnamelParameter* parameters;
  size_t parameter_count;
} EnamelDescription;

/* What an instance is configured with; valid during the call only. Device and scene files are given by path, by value
 * (their TOML text), or both (the path then stands in messages and locates what the text refers to). */
typedef struct EnamelConfiguration {
  const char* device_path; /* or NULL */
  const char* device_text; /* or NULL: read device_path */
  const char* scene_path;  /* or NULL */
  const char* scene_text;  /* or NULL: read scene_path; both NULL: no scene is known, contacts come with the ticks */
  const EnamelParameter* parameters; /* those that differ from their default */
  size_t parameter_count;
} EnamelConfiguration;

/* Where a setup function explains why it refused: at most `size` bytes with the final 0. May be NULL with size 0. */
typedef struct EnamelMessage {
  char* text;
  size_t size;
} EnamelMessage;

/* The functions of a plugin. `self` is what create() returned. */
typedef struct EnamelPlugin {
  uint32_t abi_version;  /* ENAMEL_ABI_VERSION; every later field may change with it */
  uint32_t plugin_size;  /* sizeof(EnamelPlugin) */
  uint32_t input_size;   /* sizeof(EnamelTickInput) */
  uint32_t output_size;  /* sizeof(EnamelTickOutput) */
  uint32_t needs;        /* ENAMEL_NEEDS_... or 0 */
  uint32_t reserved;     /* 0 */

  /* Setup. Never NULL. */
  const EnamelDescription* (*describe)(void);

  /* Setup. NULL: no memory. */
  void* (*create)(void);

  /* Setup, any number of times while not active. On an error the instance is as before. */
  int32_t (*configure)(void* self, const EnamelConfiguration* configuration, EnamelMessage message);

  /* Setup, once configured: gets ready for ticks of `period` s, in 1e-5 to 0.1, and resets. Allocate here. */
  int32_t (*activate)(void* self, double period, EnamelMessage message);

  /* Tick. The output is defined whatever the result; on any but ENAMEL_OK torque and wrench are 0, the mode ENAMEL_FAULT and
   * the state unchanged. A number of joints that the renderer was not made for is ENAMEL_OUT_OF_RANGE. */
  int32_t (*step)(void* self, const EnamelTickInput* input, EnamelTickOutput* output);

  /* Tick. Back to the state after activate(). */
  void (*reset)(void* self);

  /* Setup. step() answers ENAMEL_INACTIVE until the next activate(). */
  void (*deactivate)(void* self);

  /* Setup, in any state. */
  void (*destroy)(void* self);

  /* Tick, while active. The state between ticks as bytes, at most 16 MB: copied out, copied in. Equal states have equal
   * bytes. */
  size_t (*state_size)(const void* self);
  void (*save_state)(const void* self, void* state);
  void (*load_state)(void* self, const void* state);
} EnamelPlugin;

/* The one exported symbol. Setup. The table lives as long as the library is loaded. */
ENAMEL_PLUGIN_EXPORT const EnamelPlugin* enamel_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-deprecated-headers, readability-identifier-naming) */

#endif
