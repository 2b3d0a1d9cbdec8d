/* A renderer plugin in plain C, to copy: it holds the joints where the tool first touched, with a spring and a damper in
 * every joint. It knows no kinematics, so it neither balances gravity nor reports the wall's force; see ../impedance for
 * a plugin that does, and ../AUTHORS.md for the contract.
 *
 * Build it with the installed package:  find_package(Enamel REQUIRED)  enamel_add_plugin(my_wall plugin.c)
 */
#include <enamel/plugin/abi.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what it is ---- */

static const EnamelParameter kParameters[] = {
    {"stiffness", "40", "of every joint, N m/rad"},
    {"damping", "0.4", "of every joint, N m s/rad"},
};

static const EnamelDescription kDescription = {
    "template", "0.1.0", "Holds the joints where the tool first touched, by springs: a template for your own",
    kParameters, sizeof kParameters / sizeof kParameters[0]};

static const EnamelDescription* describe(void) { return &kDescription; }

/* ---- an instance ---- */

/* Everything that changes from tick to tick, in one block: save, load and compare are then copies of bytes. */
typedef struct State {
  double last_time;    /* s */
  double reference[6]; /* joint angles at first touch, rad */
  int64_t holding;     /* 64 bits: no padding, so equal states have equal bytes */
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

/* ---- setup: may allocate, read files and take its time ---- */

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
      if (!read_number(given, 0.0, 1e4, &stiffness))
        return refuse(message, ENAMEL_BAD_CONFIGURATION, "stiffness must be in 0 to 10000 N m/rad, is ", given->value);
    } else if (strcmp(given->key, "damping") == 0) {
      if (!read_number(given, 0.0, 100.0, &damping))
        return refuse(message, ENAMEL_BAD_CONFIGURATION, "damping must be in 0 to 100 N m s/rad, is ", given->value);
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
  if (!(period > 0.0 && period <= 0.1))
    return refuse(message, ENAMEL_BAD_CONFIGURATION, "the period must be in (0, 0.1] s", "");
  wall->active = 1;
  reset(wall);
  return ENAMEL_OK;
}

static void deactivate(void* self) { ((Wall*)self)->active = 0; }

/* ---- tick: no allocation, no lock, no file ---- */

static int32_t check(const Wall* wall, const EnamelTickInput* input) {
  int i;
  if (!wall->active) return ENAMEL_INACTIVE;
  if (!isfinite(input->time) || !isfinite(input->max_torque)) return ENAMEL_NOT_FINITE;
  for (i = 0; i < 6; ++i)
    if (!isfinite(input->q[i]) || !isfinite(input->rates[i])) return ENAMEL_NOT_FINITE;
  for (i = 0; i < 6; ++i)
    if (fabs(input->q[i]) > 1e3 || fabs(input->rates[i]) > 1e3) return ENAMEL_OUT_OF_RANGE;
  if (input->max_torque < 0.0 || input->contact_count < 0 || input->contact_count > ENAMEL_MAX_CONTACTS)
    return ENAMEL_OUT_OF_RANGE;
  if (input->contact_count > 0 && !isfinite(input->contacts[0].gap)) return ENAMEL_NOT_FINITE;
  return input->time > wall->state.last_time ? ENAMEL_OK : ENAMEL_STALE;
}

static int32_t step(void* self, const EnamelTickInput* input, EnamelTickOutput* output) {
  Wall* wall = self;
  const int32_t result = check(wall, input);
  int i;
  memset(output, 0, sizeof *output);
  output->mode = ENAMEL_FAULT;
  if (result != ENAMEL_OK) return result;

  wall->state.last_time = input->time;
  output->mode = ENAMEL_FREE;
  if (input->contact_count == 0 || input->contacts[0].gap > 0.0) {
    wall->state.holding = 0;
    memset(wall->state.reference, 0, sizeof wall->state.reference);
    return ENAMEL_OK;
  }
  if (!wall->state.holding) {
    wall->state.holding = 1;
    memcpy(wall->state.reference, input->q, sizeof wall->state.reference);
  }
  output->mode = ENAMEL_CONTACT;
  for (i = 0; i < 6; ++i) {
    const double wanted =
        -wall->stiffness * (input->q[i] - wall->state.reference[i]) - wall->damping * input->rates[i];
    output->torque[i] = fmax(-input->max_torque, fmin(input->max_torque, wanted));
    if (output->torque[i] != wanted) output->saturated = 1;
  }
  return ENAMEL_OK;
}

static size_t state_size(const void* self) { return sizeof ((const Wall*)self)->state; }

static void save_state(const void* self, void* state) { memcpy(state, &((const Wall*)self)->state, sizeof(State)); }

static void load_state(void* self, const void* state) { memcpy(&((Wall*)self)->state, state, sizeof(State)); }

/* ---- the table ---- */

const EnamelPlugin* enamel_plugin(void) {
  static const EnamelPlugin table = {
      ENAMEL_ABI_VERSION, sizeof(EnamelPlugin), sizeof(EnamelTickInput), sizeof(EnamelTickOutput),
      describe,           create,               configure,               activate,
      step,               reset,                deactivate,              destroy,
      state_size,         save_state,           load_state};
  return &table;
}
