/* A template for renderer plugins in plain C: a wall with a spring and a damper along each contact's normal. It returns
 * the wrench on the tool. The host adds gravity and converts the wrench to joint torques, so that the plugin runs on
 * any mechanism. ../AUTHORS.md has the contract.
 *
 * Build it with the installed package:  find_package(Enamel REQUIRED)  enamel_add_plugin(my_wall plugin.c)
 */
#include <enamel/plugin/abi.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- description ---- */

static const EnamelParameter kParameters[] = {
    {"stiffness", "2000", "stiffness of the wall, N/m"},
    {"damping", "2", "damping of the wall while the tool moves in, N s/m"},
};

static const EnamelDescription kDescription = {
    "template", "0.2.0", "A spring and a damper along every contact's normal: a template for your own", kParameters,
    sizeof kParameters / sizeof kParameters[0]};

static const EnamelDescription* describe(void) { return &kDescription; }

/* ---- an instance ---- */

/* All state that changes from tick to tick, in one block without padding: it can be saved, loaded and compared as
 * bytes. */
typedef struct State {
  double last_time; /* s */
} State;

typedef struct Wall {
  double stiffness, damping;
  int configured, active;
  State state;
} Wall;

static int32_t refuse(EnamelMessage message, int32_t result, const char* why, const char* what) {
  if (message.text != NULL && message.size > 0) snprintf(message.text, message.size, "%s%s", why, what);
  return result;
}

static void* create(void) { return calloc(1, sizeof(Wall)); }

static void destroy(void* self) { free(self); }

/* ---- setup: may allocate, read files and take long ---- */

static int32_t read_number(const EnamelParameter* given, double low, double high, double* value) {
  char* end = NULL;
  const double number = strtod(given->value, &end);
  if (end == given->value || *end != 0 || !(number >= low && number <= high)) return 0;
  *value = number;
  return 1;
}

static int32_t configure(void* self, const EnamelConfiguration* configuration, EnamelMessage message) {
  Wall* wall = self;
  double stiffness = strtod(kParameters[0].value, NULL), damping = strtod(kParameters[1].value, NULL);
  size_t i;
  if (wall->active) return refuse(message, ENAMEL_WRONG_ORDER, "configure() while active", "");
  for (i = 0; i < configuration->parameter_count; ++i) {
    const EnamelParameter* given = &configuration->parameters[i];
    if (strcmp(given->key, "stiffness") == 0) {
      if (!read_number(given, 0.0, 1e7, &stiffness))
        return refuse(message, ENAMEL_BAD_CONFIGURATION, "stiffness must be in 0 to 1e7 N/m, is ", given->value);
    } else if (strcmp(given->key, "damping") == 0) {
      if (!read_number(given, 0.0, 1e5, &damping))
        return refuse(message, ENAMEL_BAD_CONFIGURATION, "damping must be in 0 to 1e5 N s/m, is ", given->value);
    } else {
      return refuse(message, ENAMEL_BAD_CONFIGURATION, "unknown parameter: ", given->key);
    }
  }
  wall->stiffness = stiffness;
  wall->damping = damping;
  wall->configured = 1;
  return ENAMEL_OK;
}

static void reset(void* self) {
  Wall* wall = self;
  memset(&wall->state, 0, sizeof wall->state);
  wall->state.last_time = -HUGE_VAL;
}

static int32_t activate(void* self, double period, EnamelMessage message) {
  Wall* wall = self;
  if (wall->active) return refuse(message, ENAMEL_WRONG_ORDER, "activate() while active", "");
  if (!wall->configured) return refuse(message, ENAMEL_WRONG_ORDER, "activate() before configure()", "");
  if (!(period >= 1e-5 && period <= 0.1))
    return refuse(message, ENAMEL_BAD_CONFIGURATION, "the period must be in 1e-5 to 0.1 s", "");
  wall->active = 1;
  reset(wall);
  return ENAMEL_OK;
}

static void deactivate(void* self) { ((Wall*)self)->active = 0; }

/* ---- tick: no allocation, no lock, no file ---- */

/* Check that values are finite and physically possible. */
static int32_t check_numbers(const double* values, int count, double limit) {
  int i;
  for (i = 0; i < count; ++i)
    if (!isfinite(values[i])) return ENAMEL_NOT_FINITE;
  for (i = 0; i < count; ++i)
    if (fabs(values[i]) > limit) return ENAMEL_OUT_OF_RANGE;
  return ENAMEL_OK;
}

static int32_t check(const Wall* wall, const EnamelTickInput* input) {
  int32_t result;
  int i;
  if (!wall->active) return ENAMEL_INACTIVE;
  if (!isfinite(input->time)) return ENAMEL_NOT_FINITE;
  if (input->joint_count < 1 || input->joint_count > ENAMEL_MAX_JOINTS || input->contact_count < 0 ||
      input->contact_count > ENAMEL_MAX_CONTACTS)
    return ENAMEL_OUT_OF_RANGE;
  if ((result = check_numbers(input->q, input->joint_count, 1e3)) != ENAMEL_OK) return result;
  if ((result = check_numbers(input->position, 3, 10.0)) != ENAMEL_OK) return result;
  if ((result = check_numbers(input->twist, 6, 1e3)) != ENAMEL_OK) return result;
  for (i = 0; i < input->contact_count; ++i) {
    const EnamelContact* contact = &input->contacts[i];
    if ((result = check_numbers(&contact->gap, 1, 100.0)) != ENAMEL_OK) return result;
    if ((result = check_numbers(contact->point, 3, 10.0)) != ENAMEL_OK) return result;
    if ((result = check_numbers(contact->normal, 3, 1.001)) != ENAMEL_OK) return result;
    if ((result = check_numbers(contact->obstacle_velocity, 3, 100.0)) != ENAMEL_OK) return result;
  }
  return input->time > wall->state.last_time ? ENAMEL_OK : ENAMEL_STALE;
}

static double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double* a, const double* b, double* result) {
  result[0] = a[1] * b[2] - a[2] * b[1];
  result[1] = a[2] * b[0] - a[0] * b[2];
  result[2] = a[0] * b[1] - a[1] * b[0];
}

static int32_t step(void* self, const EnamelTickInput* input, EnamelTickOutput* output) {
  Wall* wall = self;
  const int32_t result = check(wall, input);
  int i, k;
  memset(output, 0, sizeof *output);
  output->mode = ENAMEL_FAULT;
  if (result != ENAMEL_OK) return result;

  wall->state.last_time = input->time;
  output->mode = ENAMEL_FREE;
  output->answer = ENAMEL_WRENCH;
  for (i = 0; i < input->contact_count && input->contacts[i].gap < 0.0; ++i) { /* sorted by gap, deepest first */
    const EnamelContact* contact = &input->contacts[i];
    double arm[3], spin[3], velocity[3], moment[3], force;
    for (k = 0; k < 3; ++k) arm[k] = contact->point[k] - input->position[k];
    cross(input->twist + 3, arm, spin);
    for (k = 0; k < 3; ++k) velocity[k] = input->twist[k] + spin[k] - contact->obstacle_velocity[k];
    force = -wall->stiffness * contact->gap - wall->damping * dot(contact->normal, velocity);
    if (force < 0.0) force = 0.0; /* a wall does not pull */
    cross(arm, contact->normal, moment);
    for (k = 0; k < 3; ++k) {
      output->wrench[k] += force * contact->normal[k];
      output->wrench[k + 3] += force * moment[k];
    }
    if (i == 0) output->normal_force = force;
    output->mode = ENAMEL_CONTACT;
  }
  return ENAMEL_OK;
}

static size_t state_size(const void* self) { return sizeof((const Wall*)self)->state; }

static void save_state(const void* self, void* state) { memcpy(state, &((const Wall*)self)->state, sizeof(State)); }

static void load_state(void* self, const void* state) { memcpy(&((Wall*)self)->state, state, sizeof(State)); }

/* ---- the table ---- */

const EnamelPlugin* enamel_plugin(void) {
  static const EnamelPlugin table = {ENAMEL_ABI_VERSION,
                                     sizeof(EnamelPlugin),
                                     sizeof(EnamelTickInput),
                                     sizeof(EnamelTickOutput),
                                     0, /* needs */
                                     0, /* reserved */
                                     describe,
                                     create,
                                     configure,
                                     activate,
                                     step,
                                     reset,
                                     deactivate,
                                     destroy,
                                     state_size,
                                     save_state,
                                     load_state};
  return &table;
}
