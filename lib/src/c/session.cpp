// The functions of enamel.h: each calls the session, and turns exceptions into results.
#include <limits>
#include <mutex>
#include <string>

#include "c/convert.hpp"
#include "enamel/core/unity_frame.hpp"

using namespace enamel;

struct EnamelSession {
  std::shared_ptr<Session> session;
  int joints = 0;
  std::mutex mutex;  // of `message`
  std::string message;
};

struct EnamelVirtualDevice {
  VirtualDevice device;
};

struct EnamelTickAccess {
  TickAccess* access;
};

namespace {

constexpr std::uint32_t kVersion = ENAMEL_VERSION_MAJOR * 65536U + ENAMEL_VERSION_MINOR * 256U + ENAMEL_VERSION_PATCH;

void remember(EnamelSession& session, const char* text) noexcept {
  const std::lock_guard<std::mutex> lock(session.mutex);
  try {
    session.message = text;
  } catch (...) {
    session.message.clear();  // no memory
  }
}

// Run `work` with a session; it may throw.
template <typename Work>
std::int32_t run(EnamelSession* session, const Work& work) noexcept {
  if (session == nullptr) return ENAMEL_NULL;
  try {
    work(*session->session);
    return ENAMEL_OK;
  } catch (const std::exception& error) {
    remember(*session, error.what());
  } catch (...) {
    remember(*session, "an unknown exception");
  }
  return ENAMEL_FAILED;
}

// Also require pointers that the caller must give.
template <typename Work>
std::int32_t runWith(EnamelSession* session, bool isGiven, const Work& work) noexcept {
  if (session == nullptr) return ENAMEL_NULL;
  if (!isGiven) {
    remember(*session, "a required pointer is NULL");
    return ENAMEL_NULL;
  }
  return run(session, work);
}

std::int32_t wrongSize(EnamelSession& session) noexcept {
  remember(session, "the `size` of a struct is wrong: initialise it with sizeof, and use the header of this library");
  return ENAMEL_SIZE;
}

ObstacleId idOf(EnamelObstacle obstacle) noexcept { return {obstacle.slot, obstacle.generation}; }
Pose rigid(const EnamelPose& pose) noexcept { return c::poseOf(pose); }

SessionDef definitionOf(const EnamelSessionDef& in) {
  SessionDef def;
  const auto text = [](const char* given) { return given == nullptr ? std::string() : std::string(given); };
  def.device = text(in.device);
  if (in.mechanism != nullptr) def.mechanism = c::makeMechanism(*in.mechanism);
  def.scene = text(in.scene);
  if (in.tool != nullptr) def.tool = c::toolOf(*in.tool);
  if (in.bur != nullptr) def.bur = c::burOf(*in.bur);
  if (in.start != nullptr) def.start = rigid(*in.start);
  if (in.renderer != nullptr) def.renderer = in.renderer;
  def.parameters = c::parametersOf(in.parameters, in.parameter_count);
  def.pluginFolder = text(in.plugin_folder);
  def.rate = in.rate;
  if (in.base != nullptr || in.scale != 1.0)
    def.map = WorkspaceMap{in.base == nullptr ? Pose{} : rigid(*in.base), in.scale};
  def.clutchButton = in.clutch_button;
  def.centring = in.centring;
  def.maxForce = in.max_force;
  def.priority = in.priority;
  def.lockMemory = in.lock_memory != 0;
  if (in.shares_with != nullptr) def.sharesWith = in.shares_with->session;
  if (in.before_tick != nullptr)
    def.beforeTick = [call = in.before_tick, user = in.user](TickAccess& access) {
      EnamelTickAccess plain{&access};
      call(user, &plain);
    };
  return def;
}

}  // namespace

extern "C" {

std::uint32_t enamel_version(void) { return kVersion; }

std::int32_t enamel_session_defaults(EnamelSessionDef* def) {
  if (def == nullptr) return ENAMEL_NULL;
  const SessionDef defaults;
  *def = EnamelSessionDef{};
  def->size = sizeof *def;
  def->clutch_button = defaults.clutchButton;
  def->renderer = "position-control";
  def->rate = defaults.rate;
  def->scale = 1.0;
  def->max_force = defaults.maxForce;
  def->priority = defaults.priority;
  def->lock_memory = 1;
  return ENAMEL_OK;
}

std::int32_t enamel_obstacle_defaults(EnamelObstacleDef* def) {
  if (def == nullptr) return ENAMEL_NULL;
  *def = EnamelObstacleDef{};
  def->size = sizeof *def;
  toPlain(Pose{}, def->pose.position, def->pose.rotation);
  def->material.stiffness = std::numeric_limits<double>::infinity();
  def->unit = 1e-3;
  def->cell = SolidOptions{}.cell;
  def->active = 1;
  return ENAMEL_OK;
}

std::int32_t enamel_session_create(const EnamelSessionDef* def, EnamelSession** session, EnamelMessage message) {
  if (session != nullptr) *session = nullptr;
  if (def == nullptr || session == nullptr) return ENAMEL_NULL;
  if (!isKnown(*def)) {
    c::copyText("EnamelSessionDef.size is wrong: call enamel_session_defaults(), and use the header of this library",
                message);
    return ENAMEL_SIZE;
  }
  return c::attempt(message, [&] {
    auto handle = std::make_unique<EnamelSession>();
    handle->session = std::make_shared<Session>(definitionOf(*def));
    handle->joints = handle->session->mechanism().joints();
    *session = handle.release();
  });
}

void enamel_session_destroy(EnamelSession* session) {
  if (session == nullptr) return;
  session->session->stop();
  delete session;
}

std::int32_t enamel_message(EnamelSession* session, EnamelMessage message) {
  if (session == nullptr) return ENAMEL_NULL;
  const std::lock_guard<std::mutex> lock(session->mutex);
  c::copyText(session->message.c_str(), message);
  return ENAMEL_OK;
}

std::int32_t enamel_start(EnamelSession* session) {
  return run(session, [](Session& s) { s.startOpened(); });
}

std::int32_t enamel_start_device(EnamelSession* session, const EnamelDevice* device) {
  return runWith(session, device != nullptr, [&](Session& s) { s.start(makeDevice(*device, session->joints)); });
}

std::int32_t enamel_start_virtual(EnamelSession* session, EnamelHand hand, void* user) {
  return run(session, [&](Session& s) {
    WrenchFunction held;
    if (hand != nullptr)
      held = [hand, user](double time, const Pose& pose, const Vec6& twist) {
        EnamelPose plain;
        toPlain(pose, plain.position, plain.rotation);
        Vec6 wrench = Vec6::Zero();
        hand(user, time, &plain, twist.data(), wrench.data());
        return wrench;
      };
    s.start(makeVirtualDevice(s, std::move(held)));
  });
}

std::int32_t enamel_stop(EnamelSession* session) {
  return run(session, [](Session& s) {
    s.stop();
    if (s.isRunning())
      throw Error("enamel_stop() was called in before_tick or in a hand: the loop cannot wait for itself");
  });
}

std::int32_t enamel_is_running(EnamelSession* session, std::int32_t* running) {
  return runWith(session, running != nullptr, [&](Session& s) { *running = s.isRunning() ? 1 : 0; });
}

std::int32_t enamel_tick(EnamelSession* session, const EnamelMeasurement* measurement, double* effort) {
  if (session == nullptr || effort == nullptr) return ENAMEL_NULL;
  std::fill_n(effort, session->joints, 0.0);
  if (measurement == nullptr) return ENAMEL_NULL;
  if (!isKnown(*measurement)) return wrongSize(*session);
  Command command;
  const Status status = session->session->tick(measurementOf(*measurement, session->joints), command);
  enamel::toPlain(command.effort, effort);
  return c::resultOf(status);
}

std::int32_t enamel_snapshot(EnamelSession* session, EnamelSnapshot* snapshot) {
  if (session == nullptr || snapshot == nullptr) return ENAMEL_NULL;
  if (!isKnown(*snapshot)) return wrongSize(*session);
  return run(session, [&](Session& s) { c::toPlain(s.snapshot(), *snapshot); });
}

std::int32_t enamel_next_event(EnamelSession* session, EnamelEvent* event) {
  if (session == nullptr || event == nullptr) return ENAMEL_NULL;
  if (!isKnown(*event)) return wrongSize(*session);
  bool found = false;
  const std::int32_t result = run(session, [&](Session& s) {
    SessionEvent next;
    found = s.nextEvent(next);
    if (found) c::toPlain(next, *event);
  });
  return result != ENAMEL_OK || found ? result : std::int32_t{ENAMEL_NOTHING};
}

std::int32_t enamel_add(EnamelSession* session, const EnamelObstacleDef* def, EnamelObstacle* obstacle) {
  return runWith(session, def != nullptr && obstacle != nullptr, [&](Session& s) {
    *obstacle = {-1, 0};
    const ObstacleId id = s.add(c::obstacleOf(*def));
    *obstacle = {id.slot, id.generation};
  });
}

std::int32_t enamel_replace(EnamelSession* session, EnamelObstacle obstacle, const EnamelObstacleDef* by) {
  return runWith(session, by != nullptr, [&](Session& s) { s.replace(idOf(obstacle), c::obstacleOf(*by)); });
}

std::int32_t enamel_remove(EnamelSession* session, EnamelObstacle obstacle) {
  return run(session, [&](Session& s) { s.remove(idOf(obstacle)); });
}

std::int32_t enamel_find(EnamelSession* session, const char* name, EnamelObstacle* obstacle) {
  const std::int32_t result = runWith(session, name != nullptr && obstacle != nullptr, [&](Session& s) {
    const ObstacleId id = s.find(name);
    *obstacle = {id.slot, id.generation};
  });
  return result != ENAMEL_OK || obstacle->generation != 0 ? result : std::int32_t{ENAMEL_NOTHING};
}

std::int32_t enamel_move(EnamelSession* session, EnamelObstacle obstacle, const EnamelPose* pose, const double* twist) {
  return runWith(session, pose != nullptr,
                 [&](Session& s) { s.move(idOf(obstacle), rigid(*pose), c::twistOf(twist)); });
}

std::int32_t enamel_set_material(EnamelSession* session, EnamelObstacle obstacle, const EnamelMaterial* material) {
  return runWith(session, material != nullptr,
                 [&](Session& s) { s.setMaterial(idOf(obstacle), c::materialOf(*material)); });
}

std::int32_t enamel_set_tap(EnamelSession* session, EnamelObstacle obstacle, double frequency, double decay) {
  return run(session, [&](Session& s) { s.setTap(idOf(obstacle), {frequency, decay}); });
}

std::int32_t enamel_set_suspension(EnamelSession* session, EnamelObstacle obstacle,
                                   const EnamelSuspension* suspension) {
  return run(session, [&](Session& s) { s.setSuspension(idOf(obstacle), c::suspensionOf(suspension)); });
}

std::int32_t enamel_activate(EnamelSession* session, EnamelObstacle obstacle, std::int32_t active) {
  return run(session, [&](Session& s) { s.activate(idOf(obstacle), active != 0); });
}

std::int32_t enamel_move_vertices(EnamelSession* session, EnamelObstacle obstacle, const std::int32_t* vertices,
                                  const double* positions, std::size_t count) {
  return runWith(session, vertices != nullptr && positions != nullptr, [&](Session& s) {
    if (count > (1U << 27U)) throw Error("enamel_move_vertices: " + std::to_string(count) + " vertices are too many");
    std::vector<int> numbers(vertices, vertices + count);
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < count; ++i) places.emplace_back(Eigen::Map<const Vec3>(positions + 3 * i));
    s.moveVertices(idOf(obstacle), std::move(numbers), std::move(places));
  });
}

std::int32_t enamel_solid_bricks(EnamelSession* session, EnamelObstacle obstacle, std::int32_t* count) {
  return runWith(session, count != nullptr, [&](Session& s) {
    const std::shared_ptr<const Solid> solid = s.solid(idOf(obstacle));
    if (!solid) throw Error("the obstacle is not a solid");
    *count = solid->bricks();
  });
}

std::int32_t enamel_take_surface(EnamelSession* session, EnamelObstacle obstacle, EnamelSurface* surface) {
  if (session == nullptr || surface == nullptr) return ENAMEL_NULL;
  if (!isKnown(*surface)) return wrongSize(*session);
  bool found = false;
  const std::int32_t result = run(session, [&](Session& s) { found = c::takeSurface(s, idOf(obstacle), *surface); });
  return result != ENAMEL_OK || found ? result : std::int32_t{ENAMEL_NOTHING};
}

std::int32_t enamel_restore(EnamelSession* session, EnamelObstacle obstacle) {
  return run(session, [&](Session& s) { s.restore(idOf(obstacle)); });
}

std::int32_t enamel_mark(EnamelSession* session, EnamelObstacle obstacle) {
  return run(session, [&](Session& s) { s.mark(idOf(obstacle)); });
}

std::int32_t enamel_undo(EnamelSession* session, EnamelObstacle obstacle) {
  return run(session, [&](Session& s) { s.undo(idOf(obstacle)); });
}

std::int32_t enamel_solid_copy(EnamelSession* session, EnamelObstacle obstacle, EnamelSolid** solid) {
  if (solid != nullptr) *solid = nullptr;
  return runWith(session, solid != nullptr, [&](Session& s) {
    *solid = new EnamelSolid{std::make_shared<const Solid>(s.cutSolid(idOf(obstacle))), {}, {}};
  });
}

std::int32_t enamel_set_guides(EnamelSession* session, const EnamelGuide* guides, std::size_t guide_count) {
  return runWith(session, guides != nullptr || guide_count == 0,
                 [&](Session& s) { s.setGuides(c::guidesOf(guides, guide_count)); });
}

std::int32_t enamel_named_tool(const char* name, EnamelTool* tool, EnamelMessage message) {
  if (name == nullptr || tool == nullptr) return ENAMEL_NULL;
  return c::attempt(message, [&] {
    const Tool found = toolOf(std::string(name));
    *tool = EnamelTool{};
    tool->size = sizeof *tool;
    tool->count = found.count;
    tool->head = found.head;
    for (int i = 0; i < found.count; ++i) {
      const ToolPart& part = found.parts[static_cast<std::size_t>(i)];
      Eigen::Map<Vec3>(tool->parts[i].a) = part.a;
      Eigen::Map<Vec3>(tool->parts[i].b) = part.b;
      tool->parts[i].radius = part.radius;
    }
  });
}

std::int32_t enamel_set_tool(EnamelSession* session, const EnamelTool* tool, const EnamelBur* bur) {
  return runWith(session, tool != nullptr, [&](Session& s) {
    std::optional<Bur> cutting;
    if (bur != nullptr) cutting = c::burOf(*bur);
    s.setTool(c::toolOf(*tool), cutting);
  });
}

std::int32_t enamel_set_renderer(EnamelSession* session, const char* name, const EnamelParameter* parameters,
                                 std::size_t parameter_count) {
  return runWith(session, name != nullptr,
                 [&](Session& s) { s.setRenderer(name, c::parametersOf(parameters, parameter_count)); });
}

std::int32_t enamel_set_own_renderer(EnamelSession* session, const EnamelPlugin* table,
                                     const EnamelParameter* parameters, std::size_t parameter_count) {
  return runWith(session, table != nullptr, [&](Session& s) {
    PluginSetup setup;
    setup.parameters = c::parametersOf(parameters, parameter_count);
    s.setRenderer(makeRenderer(PluginLibrary::of(*table, "own renderer"), setup));
  });
}

std::int32_t enamel_set_effect(EnamelSession* session, const double* wrench) {
  return runWith(session, wrench != nullptr, [&](Session& s) { s.setEffect(c::twistOf(wrench)); });
}
std::int32_t enamel_set_gripper(EnamelSession* session, double force) {
  return run(session, [&](Session& s) { s.setGripper(force); });
}
std::int32_t enamel_spin(EnamelSession* session, std::int32_t on) {
  return run(session, [&](Session& s) { s.spin(on != 0); });
}
std::int32_t enamel_clutch(EnamelSession* session, std::int32_t on) {
  return run(session, [&](Session& s) { s.clutch(on != 0); });
}
std::int32_t enamel_enable(EnamelSession* session, std::int32_t on) {
  return run(session, [&](Session& s) { s.enable(on != 0); });
}
std::int32_t enamel_reset(EnamelSession* session) {
  return run(session, [](Session& s) { s.reset(); });
}
std::int32_t enamel_record(EnamelSession* session, const char* path) {
  return runWith(session, path != nullptr, [&](Session& s) { s.record(path); });
}
std::int32_t enamel_stop_recording(EnamelSession* session, std::uint64_t* ticks, std::uint64_t* lost) {
  return run(session, [&](Session& s) {
    const RecordingResult result = s.stopRecording();
    if (ticks != nullptr) *ticks = result.ticks;
    if (lost != nullptr) *lost = result.lost;
    if (!result.problem.empty()) throw Error(result.problem);
  });
}

std::int32_t enamel_tick_measurement(EnamelTickAccess* access, EnamelMeasurement* measurement) {
  if (access == nullptr || measurement == nullptr) return ENAMEL_NULL;
  if (!isKnown(*measurement)) return ENAMEL_SIZE;
  enamel::toPlain(access->access->measurement(), *measurement);
  return ENAMEL_OK;
}
std::int32_t enamel_tick_move(EnamelTickAccess* access, EnamelObstacle obstacle, const EnamelPose* pose,
                              const double* twist) {
  if (access == nullptr || pose == nullptr) return ENAMEL_NULL;
  return c::resultOf(access->access->move(idOf(obstacle), rigid(*pose), c::twistOf(twist)));
}
std::int32_t enamel_tick_activate(EnamelTickAccess* access, EnamelObstacle obstacle, std::int32_t active) {
  if (access == nullptr) return ENAMEL_NULL;
  return c::resultOf(access->access->activate(idOf(obstacle), active != 0));
}
std::int32_t enamel_tick_spin(EnamelTickAccess* access, std::int32_t on) {
  if (access == nullptr) return ENAMEL_NULL;
  access->access->spin(on != 0);
  return ENAMEL_OK;
}
std::int32_t enamel_tick_effect(EnamelTickAccess* access, const double* wrench) {
  if (access == nullptr || wrench == nullptr) return ENAMEL_NULL;
  return c::resultOf(access->access->setEffect(c::twistOf(wrench)));
}
std::int32_t enamel_tick_gripper(EnamelTickAccess* access, double force) {
  if (access == nullptr) return ENAMEL_NULL;
  return c::resultOf(access->access->setGripper(force));
}

std::int32_t enamel_virtual_create(EnamelSession* session, EnamelVirtualDevice** device) {
  if (device != nullptr) *device = nullptr;
  return runWith(session, device != nullptr, [&](Session& s) {
    VirtualDeviceSetup setup;
    setup.start = s.start();
    setup.period = s.period();
    *device = new EnamelVirtualDevice{VirtualDevice(s.mechanism(), setup)};
  });
}
void enamel_virtual_destroy(EnamelVirtualDevice* device) { delete device; }
std::int32_t enamel_virtual_measure(EnamelVirtualDevice* device, EnamelMeasurement* measurement) {
  if (device == nullptr || measurement == nullptr) return ENAMEL_NULL;
  if (!isKnown(*measurement)) return ENAMEL_SIZE;
  Measurement sample;
  const Status status = device->device.measure(sample);
  if (status == Status::ok) enamel::toPlain(sample, *measurement);
  return c::resultOf(status);
}
std::int32_t enamel_virtual_actuate(EnamelVirtualDevice* device, const double* effort) {
  if (device == nullptr || effort == nullptr) return ENAMEL_NULL;
  Command command;
  enamel::fromPlain(effort, static_cast<int>(device->device.torque().size()), command.effort);
  return c::resultOf(device->device.actuate(command));
}
std::int32_t enamel_virtual_advance(EnamelVirtualDevice* device, const double* wrench) {
  if (device == nullptr || wrench == nullptr) return ENAMEL_NULL;
  const Vec6 held = c::twistOf(wrench);
  return c::resultOf(device->device.advance([&](double, const Pose&, const Vec6&) { return held; }));
}
std::int32_t enamel_virtual_state(EnamelVirtualDevice* device, EnamelPose* pose, double* twist) {
  if (device == nullptr || pose == nullptr || twist == nullptr) return ENAMEL_NULL;
  const DeviceState& state = device->device.state();
  toPlain(state.pose(), pose->position, pose->rotation);
  Eigen::Map<Vec6>(twist, 6) = state.twist;
  return ENAMEL_OK;
}

void enamel_vector_from_unity(double* vector) {
  if (vector != nullptr) Eigen::Map<Vec3>(vector, 3) = mirrorUnity(Eigen::Map<const Vec3>(vector));
}
void enamel_vector_to_unity(double* vector) { enamel_vector_from_unity(vector); }
void enamel_rotation_from_unity(const double* quaternion, double* rotation) {
  if (quaternion == nullptr || rotation == nullptr) return;
  const Eigen::Quaterniond q(quaternion[3], quaternion[0], quaternion[1], quaternion[2]);
  Eigen::Map<RowMajor>(rotation, 3, 3) = rotationFromUnity(q);
}
void enamel_rotation_to_unity(const double* rotation, double* quaternion) {
  if (rotation == nullptr || quaternion == nullptr) return;
  const Eigen::Quaterniond q = rotationToUnity(Mat3(Eigen::Map<const RowMajor>(rotation, 3, 3)));
  Eigen::Map<Eigen::Vector4d>(quaternion, 4) = q.coeffs();
}

const char* enamel_reason_text(std::int32_t reason) {
  const bool isReason = reason >= 0 && reason < static_cast<std::int32_t>(kGuardReasons);
  return isReason ? toString(static_cast<GuardReason>(reason)) : "unknown reason";
}
const char* enamel_event_text(std::int32_t kind) {
  const bool isKind = kind >= ENAMEL_CONTACT_BEGIN && kind <= ENAMEL_UNUSUAL_SIZE;
  return isKind ? toString(static_cast<EventKind>(kind)) : "unknown event";
}
const char* enamel_result_text(std::int32_t result) {
  switch (result) {
    case ENAMEL_FAILED: return "failed: see enamel_message()";
    case ENAMEL_NULL: return "a handle or a required pointer is NULL";
    case ENAMEL_SIZE: return "the size of a struct is not known";
    case ENAMEL_NOTHING: return "nothing is waiting";
    case ENAMEL_STOPPED: return toString(Status::stopped);
    default: break;
  }
  return result >= ENAMEL_OK && result <= ENAMEL_INACTIVE ? toString(static_cast<Status>(result)) : "unknown result";
}

}  // extern "C"
