// Recordings and their replay in Python.
#include <optional>

#include "enamel/core/error.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/runtime/replay.hpp"
#include "renderers.hpp"

namespace enamel::python {
namespace {

class Recording {
 public:
  explicit Recording(const std::string& path) : reader_(path) {
    DeviceParameters parameters = parseDevice(header().deviceText, header().deviceFile);
    device_ = {parameters, makeMechanism(parameters)};
  }
  const RecordingHeader& header() const noexcept { return reader_.header(); }
  const Device& device() const noexcept { return device_; }

  std::shared_ptr<SceneFile> scene() const {
    if (!header().sceneText.empty())
      return std::make_shared<SceneFile>(parseScene(header().sceneText, header().sceneFile));
    auto wall = std::make_shared<SceneFile>();
    wall->scene = flatWall();
    return wall;
  }

  py::array ticks() {
    const int n = header().joints;
    Table table;
    table.column("tick", {}, "u8");
    for (const char* name : {"time", "normal_force"}) table.column(name);
    for (const char* name : {"q", "rates", "applied", "requested", "command"}) table.column(name, {n});
    table.column("position", {3});
    table.column("rotation", {3, 3});
    for (const char* name : {"mode", "saturated", "status", "guard", "enabled", "reset"}) table.column(name, {}, "i8");
    {
      const py::gil_scoped_release release;
      Kinematics kinematics = device_.mechanism->home();
      RecordedChunk chunk;
      for (std::uint64_t i = 0; i < reader_.chunks(); ++i) {
        if (const std::string problem = reader_.read(i, chunk); !problem.empty()) {
          if (i + 1 == reader_.chunks()) break;  // an incomplete last chunk
          throw Error(problem);
        }
        for (const RecordedTick& t : chunk.ticks) add(t, n, kinematics, table);
      }
    }
    return table.finish();
  }

  py::dict replayed(const py::object& renderer) {
    const auto failure = std::make_shared<Failure>();
    const std::unique_ptr<Renderer> own = makerOf(renderer, failure)();
    ReplayResult result;
    {
      const py::gil_scoped_release release;
      const auto file = scene();
      HapticTick tick(*device_.mechanism, file->scene, file->tool, *own, header().guard, header().start);
      std::optional<Drill> drill;
      if (file->bur) tick.attach(&drill.emplace(file->tool, file->solids, *file->bur));
      result = replay(reader_, tick, 0, [&](const RecordedTick&, const HapticTick&) { failure->rethrow(); });
      failure->rethrow();
    }
    py::dict found;
    found["ticks"] = result.ticks;
    found["different"] = result.different;
    found["lost"] = result.lost;
    found["damage"] = result.damage;
    found["closed"] = result.closed;
    found["requested"] = result.requested;
    found["command"] = result.command;
    return found;
  }

 private:
  void add(const RecordedTick& t, int n, Kinematics& kinematics, Table& table) const {
    const Measurement& m = t.measurement;
    table.add(t.number);
    table.add(m.time);
    table.add(t.normalForce);
    const JointVector applied = m.applied.value_or(JointVector());
    for (const JointVector* v : {&m.q, &m.rates, &applied, &t.requested, &t.command}) table.addJoints(*v, n);
    const bool found = device_.mechanism->track(m.q, m.rates, false, kinematics) == Status::ok;
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    table.add(found ? kinematics.pose.position : Vec3(Vec3::Constant(nothing)));
    table.add(found ? kinematics.pose.rotation : Mat3(Mat3::Constant(nothing)));
    for (const int value : {static_cast<int>(t.mode), static_cast<int>(t.saturated), static_cast<int>(t.status),
                            static_cast<int>(t.reason), static_cast<int>(m.enabled), static_cast<int>(t.reset)})
      table.add(static_cast<std::int64_t>(value));
  }

  RecordingReader reader_;
  Device device_;
};

}  // namespace

void addRecording(py::module_& m) {
  py::class_<Recording>(m, "Recording", "A recording of haptic ticks.")
      .def(py::init(
               [](const py::object& path) { return std::make_unique<Recording>(py::str(path).cast<std::string>()); }),
           py::arg("path"),
           "Open a recording. Raises ConfigurationError if the file is not a recording, has another version, or its "
           "header is damaged.")
      .def_property_readonly(
          "device", [](const Recording& self) { return self.device(); }, "Device of the recording.")
      .def_property_readonly("scene", &Recording::scene, "Scene that the tool could touch.")
      .def_property_readonly(
          "renderer", [](const Recording& self) { return self.header().renderer; }, "Name of the renderer.")
      .def_property_readonly(
          "parameters", [](const Recording& self) { return self.header().parameters; }, "Parameters of the renderer.")
      .def_property_readonly(
          "period", [](const Recording& self) { return self.header().guard.period; }, "Period of the ticks, s.")
      .def("ticks", &Recording::ticks,
           "Return all ticks as a structured array, one row a tick, SI units. Position and rotation are the forward "
           "kinematics, NaN without a solution. Lost ticks are missing: the column `tick` has the numbers. Raises "
           "Error if a chunk is damaged.")
      .def("replay", &Recording::replayed, py::arg("renderer"),
           "Run a renderer, the same or another one, on the recorded measurements and compare its answers bit for bit. "
           "Return the numbers of compared and different ticks and the largest differences of the torques (N m or N). "
           "Raises Error as enamel::replay() does.");
}

}  // namespace enamel::python
