#include "import.hpp"

#include <dlfcn.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <pugixml.hpp>
#include <vector>

#include "archive.hpp"
#include "enamel/core/error.hpp"
#include "export.hpp"
#include "fmi3.hpp"

namespace enamel::fmi {
namespace {

/// Dimensions of a unit in kg, m and s; angles have none.
struct Dimension {
  int kg, m, s;
};
constexpr Dimension kNone{0, 0, 0}, kLength{0, 1, 0}, kSpeed{0, 1, -1}, kRate{0, 0, -1}, kForce{1, 1, -2},
    kTorque{1, 2, -2};

/// References of a variable's numbers: one of an array, or one a scalar; none: the unit does not have it.
struct Found {
  std::vector<Reference> references;
  std::size_t size = 0;
};

/// A unit that is loaded; stays so while a plant of it lives.
class Library {
 public:
  Library(const std::string& path, const Mechanism& device) : path_(path), archive_(path) {
    readDescription(static_cast<std::size_t>(device.joints()), !device.home().jacobian.isIdentity(0.0));
    loadBinary();
  }
  ~Library() {
    if (handle_ != nullptr) dlclose(handle_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  const std::string& path() const noexcept { return path_; }

  Found torque, force, moment, position, orientation, velocity, angularVelocity, q, rates, startPosition,
      startOrientation;
  bool anyStep = false, onlyOne = false;
  std::string token;

  InstantiateCoSimulation* instantiate = nullptr;
  FreeInstance* free = nullptr;
  EnterInitializationMode* enterInitialization = nullptr;
  Transition *exitInitialization = nullptr, *terminate = nullptr;
  Get<double>* get = nullptr;
  Set<double>* set = nullptr;
  DoStep* doStep = nullptr;

  std::string resources() const { return archive_.folder() + "/resources/"; }

  mutable std::atomic<bool> taken{false};  ///< of a unit that can be instantiated only once

 private:
  [[noreturn]] void refuse(const std::string& reason) const { throw Error(path_ + ": " + reason); }

  void readDescription(std::size_t n, bool turns) {
    const pugi::xml_parse_result parsed = document_.load_file((archive_.folder() + "/modelDescription.xml").c_str());
    if (!parsed) refuse(std::string("modelDescription.xml: ") + parsed.description());
    const pugi::xml_node root = document_.child("fmiModelDescription");
    const std::string version = root.attribute("fmiVersion").value();
    if (version.rfind("3.", 0) != 0) refuse("is of FMI \"" + version + "\", must be 3.0");
    const pugi::xml_node simulation = root.child("CoSimulation");
    if (!simulation) refuse("is no unit of co-simulation");
    identifier_ = simulation.attribute("modelIdentifier").value();
    if (identifier_.empty() || identifier_.find('/') != std::string::npos)
      refuse("its modelIdentifier is \"" + identifier_ + "\"");
    anyStep = simulation.attribute("canHandleVariableCommunicationStepSize").as_bool();
    onlyOne = simulation.attribute("canBeInstantiatedOnlyOncePerProcess").as_bool();
    if (simulation.attribute("needsExecutionTool").as_bool()) refuse("needs the tool that it was made with");
    token = root.attribute("instantiationToken").value();

    const Dimension torqueIs = turns ? kTorque : kForce, jointIs = turns ? kNone : kLength,
                    rateIs = turns ? kRate : kSpeed;
    torque = require("torque", n, "input", torqueIs);
    force = require("force", 3, "input", kForce);
    moment = find("moment", 3, "input", kTorque);
    position = require("position", 3, "output", kLength);
    velocity = require("velocity", 3, "output", kSpeed);
    orientation = find("orientation", 4, "output", kNone);
    angularVelocity = find("angular_velocity", 3, "output", kRate);
    if (n > 3 && orientation.size == 0) refuse("has no output orientation, and the device turns");
    if (orientation.size > 0 && angularVelocity.size == 0) refuse("has no output angular_velocity");
    q = find("q", n, "output", jointIs);
    rates = find("rates", n, "output", rateIs);
    if ((q.size == 0) != (rates.size == 0)) refuse("has one of the outputs q and rates, must have both or none");
    startPosition = find("start_position", 3, "parameter", kLength);
    startOrientation = find("start_orientation", 4, "parameter", kNone);
  }

  pugi::xml_node variable(const std::string& name) const {
    for (const pugi::xml_node node : document_.child("fmiModelDescription").child("ModelVariables").children())
      if (name == node.attribute("name").value()) return node;
    return {};
  }

  Reference check(const pugi::xml_node& node, const std::string& name, const char* causality,
                  const Dimension& dimension) const {
    if (std::strcmp(node.name(), "Float64") != 0)
      refuse("variable " + name + " is of type " + node.name() + ", must be Float64");
    const std::string is = node.attribute("causality").value();
    if (is != causality)
      refuse("variable " + name + " has the causality \"" + (is.empty() ? "local" : is) + "\", must be " + causality);
    const std::string unit = node.attribute("unit").value();
    for (const pugi::xml_node u : document_.child("fmiModelDescription").child("UnitDefinitions").children("Unit")) {
      const pugi::xml_node base = u.child("BaseUnit");
      if (unit != u.attribute("name").value() || !base) continue;
      if (base.attribute("factor").as_double(1.0) != 1.0 || base.attribute("offset").as_double(0.0) != 0.0 ||
          base.attribute("kg").as_int() != dimension.kg || base.attribute("m").as_int() != dimension.m ||
          base.attribute("s").as_int() != dimension.s)
        refuse("variable " + name + " is in " + unit + ", must be in SI: kg^" + std::to_string(dimension.kg) + " m^" +
               std::to_string(dimension.m) + " s^" + std::to_string(dimension.s));
    }
    return node.attribute("valueReference").as_uint();
  }

  Found find(const std::string& name, std::size_t size, const char* causality, const Dimension& dimension) const {
    Found found;
    if (const pugi::xml_node node = variable(name)) {
      std::size_t has = 1;
      for (const pugi::xml_node d : node.children("Dimension")) has *= d.attribute("start").as_uint();
      if (has != size)
        refuse("variable " + name + " has " + std::to_string(has) + " numbers, must have " + std::to_string(size));
      found.references = {check(node, name, causality, dimension)};
      found.size = size;
      return found;
    }
    for (std::size_t i = 1; i <= size; ++i) {
      const std::string element = name + "[" + std::to_string(i) + "]";
      const pugi::xml_node node = variable(element);
      if (!node && i == 1) return found;
      if (!node) refuse("has " + name + "[1], but no " + causality + " " + element);
      found.references.push_back(check(node, element, causality, dimension));
    }
    found.size = size;
    return found;
  }

  Found require(const std::string& name, std::size_t size, const char* causality, const Dimension& dimension) const {
    Found found = find(name, size, causality, dimension);
    if (found.size == 0)
      refuse(std::string("has no ") + causality + " " + name + " of " + std::to_string(size) + " numbers");
    return found;
  }

  template <typename Function>
  void symbol(const char* name, Function*& function) {
    function = reinterpret_cast<Function*>(dlsym(handle_, name));
    if (function == nullptr) refuse(std::string("its binary has no ") + name + "()");
  }

  void loadBinary() {
    const std::string file = "binaries/" + platformTuple() + "/" + identifier_ + ".so",
                      place = archive_.folder() + "/" + file;
    if (!std::filesystem::exists(place)) refuse("has no " + file + ", a binary for this machine");
    handle_ = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr) {
      std::string reason = dlerror();
      if (const std::size_t at = reason.find(place + ": "); at != std::string::npos) reason.erase(at, place.size() + 2);
      refuse(file + " cannot be loaded: " + reason);
    }
    GetVersion* version = nullptr;
    symbol("fmi3GetVersion", version);
    if (const std::string is = version(); is.rfind("3.", 0) != 0) refuse("its binary is of FMI \"" + is + "\"");
    symbol("fmi3InstantiateCoSimulation", instantiate);
    symbol("fmi3FreeInstance", free);
    symbol("fmi3EnterInitializationMode", enterInitialization);
    symbol("fmi3ExitInitializationMode", exitInitialization);
    symbol("fmi3Terminate", terminate);
    symbol("fmi3GetFloat64", get);
    symbol("fmi3SetFloat64", set);
    symbol("fmi3DoStep", doStep);
  }

  std::string path_;
  UnpackedArchive archive_;
  pugi::xml_document document_;
  std::string identifier_;
  void* handle_ = nullptr;
};

/// A mechanism that lives as long as what is built on it.
struct Owner {
  std::shared_ptr<const Mechanism> mechanism;
};

class UnitPlant final : private Owner, public Plant {
 public:
  UnitPlant(std::shared_ptr<const Library> library, std::shared_ptr<const Mechanism> mechanism)
      : Owner{std::move(mechanism)}, Plant(*Owner::mechanism), library_(std::move(library)) {
    open();
  }
  ~UnitPlant() override { close(); }
  UnitPlant(const UnitPlant&) = delete;
  UnitPlant& operator=(const UnitPlant&) = delete;

  [[nodiscard]] enamel::Status start(const Pose& pose) override {
    if (isStarted_) {  // anew: not every unit can be reset
      close();
      open();
    }
    Kinematics kinematics;
    if (const auto status = rest(pose, kinematics); status != enamel::Status::ok) return status;
    const auto& o = state_.orientation;
    const double orientation[4] = {o.w(), o.x(), o.y(), o.z()};
    require(library_->enterInitialization(instance_, false, 0.0, 0.0, false, 0.0), "cannot be initialised");
    if (library_->startPosition.size > 0)
      require(put(library_->startPosition, pose.position.data()), "refuses its start");
    if (library_->startOrientation.size > 0) require(put(library_->startOrientation, orientation), "refuses its start");
    const JointVector& gravity = kinematics.gravity;
    require(put(library_->torque, gravity.data()), "refuses a torque");
    require(library_->exitInitialization(instance_), "cannot be initialised");
    isStarted_ = true;
    if (!look()) fail("has outputs that are not finite");
    const double off = (state_.position - pose.position).norm(),
                 turned = angleBetween(state_.pose().rotation, pose.rotation);
    if (off > 1e-6 || turned > 1e-6)
      fail("begins " + std::to_string(off) + " m and " + std::to_string(turned) +
           " rad away from the start of the push, and has no start_position or start_orientation that it follows");
    return enamel::Status::ok;
  }

  [[nodiscard]] enamel::Status advance(double time, double duration, const JointVector& torque,
                                       const Load& load) noexcept override {
    if (!library_->anyStep) {
      if (step_ == 0.0) step_ = duration;
      if (std::abs(duration - step_) > 1e-9 * step_) {
        tell("takes steps of one size only");
        return enamel::Status::outOfRange;
      }
    }
    const Vec6 wrench = load(time, state_.pose(), state_.twist);
    const DeviceState before = state_;
    bool eventNeeded = false, terminated = false, early = false;
    double last = time;
    const bool done =
        put(library_->torque, torque.data()) == ok && put(library_->force, wrench.data()) == ok &&
        (library_->moment.size == 0 || put(library_->moment, wrench.data() + 3) == ok) &&
        library_->doStep(instance_, time, duration, true, &eventNeeded, &terminated, &early, &last) <= warning &&
        !terminated && !early && look();
    if (!done) {
      tell(problem_.empty() ? "cannot move on" : problem_.c_str());
      state_ = before;
      return enamel::Status::notConverged;
    }
    if (!isSlowEnough(state_)) {
      state_ = before;
      return enamel::Status::outOfRange;
    }
    return enamel::Status::ok;
  }

  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override {
    if (library_->q.size == 0) return Plant::read(truth, q, rates);
    q = q_;
    rates = rates_;
  }

 private:
  void open() {
    if (library_->onlyOne && library_->taken.exchange(true))
      throw Error(library_->path() + ": can be instantiated only once in a process: --threads 1");
    instance_ = library_->instantiate("plant", library_->token.c_str(), library_->resources().c_str(), false, false,
                                      false, false, nullptr, 0, this, &UnitPlant::log, nullptr);
    if (instance_ != nullptr) return;
    library_->taken = false;
    fail("cannot be instantiated");
  }

  static void log(void* environment, Status status, const char*, const char* message) {
    if (status > warning && environment != nullptr && message != nullptr)
      static_cast<UnitPlant*>(environment)->problem_ = message;
  }

  [[noreturn]] void fail(const std::string& what) {
    const std::string reason = problem_.empty() ? "" : ": " + problem_;
    close();
    throw Error(library_->path() + ": " + what + reason);
  }
  void require(Status status, const char* what) {
    if (status > warning) fail(what);
  }

  // Why a step failed: its status cannot say.
  void tell(const char* reason) const noexcept { std::fprintf(stderr, "%s: %s\n", library_->path().c_str(), reason); }

  Status put(const Found& variable, const double* values) const noexcept {
    return library_->set(instance_, variable.references.data(), variable.references.size(), values, variable.size);
  }
  bool take(const Found& variable, double* values) const noexcept {
    if (library_->get(instance_, variable.references.data(), variable.references.size(), values, variable.size) >
        warning)
      return false;
    for (std::size_t i = 0; i < variable.size; ++i)
      if (!std::isfinite(values[i])) return false;
    return true;
  }

  // The state as the unit has it.
  bool look() noexcept {
    DeviceState state;
    if (!take(library_->position, state.position.data()) || !take(library_->velocity, state.twist.data())) return false;
    if (library_->orientation.size > 0) {
      double o[4];
      if (!take(library_->orientation, o) || !take(library_->angularVelocity, state.twist.data() + 3)) return false;
      state.orientation = Eigen::Quaternion<double>(o[0], o[1], o[2], o[3]);
      if (!(std::abs(state.orientation.norm() - 1.0) < 1e-6)) return false;
    }
    if (library_->q.size > 0) {
      q_.resize(static_cast<Eigen::Index>(library_->q.size));
      rates_.resize(q_.size());
      if (!take(library_->q, q_.data()) || !take(library_->rates, rates_.data())) return false;
    }
    state_ = state;
    return true;
  }

  void close() noexcept {
    if (instance_ == nullptr) return;
    if (isStarted_) (void)library_->terminate(instance_);
    library_->free(instance_);
    library_->taken = false;
    instance_ = nullptr;
    isStarted_ = false;
  }

  std::shared_ptr<const Library> library_;
  Instance instance_ = nullptr;
  bool isStarted_ = false;
  double step_ = 0.0;
  std::string problem_;
  JointVector q_, rates_;
};

}  // namespace

std::function<std::unique_ptr<Plant>(std::uint32_t stream)> plantsOf(const std::string& path,
                                                                     const DeviceParameters& device) {
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(device);
  const auto library = std::make_shared<const Library>(path, *mechanism);
  return [library, mechanism](std::uint32_t) { return std::make_unique<UnitPlant>(library, mechanism); };
}

}  // namespace enamel::fmi
