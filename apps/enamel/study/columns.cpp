#include "study/columns.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>

#include "colours/renderers.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/best_spring.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/parallel.hpp"
#include "program/plugin_folder.hpp"

namespace enamel::app {
namespace {

// --device-damping: B for every column, or NAME=B for some columns and 0 for the others.
class DampingOption {
 public:
  explicit DampingOption(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      const std::size_t equals = text.find('=');
      const std::string name = equals == std::string::npos ? "" : text.substr(0, equals);
      const char* number = text.c_str() + (equals == std::string::npos ? 0 : equals + 1);
      char* end = nullptr;
      const double value = std::strtod(number, &end);
      if (end == number || *end != 0 || !(value >= 0.0 && value <= 1e3) || equals == 0)
        throw Error("--device-damping is \"" + text + "\", must be B or NAME=B with B in 0 to 1000 N s/m");
      if (!values_.emplace(name, value).second)
        throw Error("--device-damping is given twice for " + (name.empty() ? "every renderer" : name));
    }
    if (values_.size() > 1 && values_.count("") > 0)
      throw Error("--device-damping must not give both a value for every renderer and one for " +
                  values_.rbegin()->first);
    unused_ = values_;
    unused_.erase("");
  }

  double of(const std::string& renderer) {
    unused_.erase(renderer);
    const auto found = values_.find(values_.count("") > 0 ? "" : renderer);
    return found == values_.end() ? 0.0 : found->second;
  }

  /// Return a name that matches no renderer; empty if all names match.
  std::string unused() const { return unused_.empty() ? "" : unused_.begin()->first; }

 private:
  std::map<std::string, double> values_, unused_;
};

// Meaning of a name in --renderers.
struct RendererChoice {
  ColumnKind kind = ColumnKind::plugin;
  std::string name, title;
  std::string servo;  // servo file; empty: the study's servo
  std::shared_ptr<const PluginLibrary> plugin;
};

RendererChoice choiceOf(const std::string& text) {
  if (text.rfind(kTuned, 0) == 0) {
    const viewer::RendererLook* look = viewer::lookOf(text);
    const std::string title = rivalSpec(text.substr(std::strlen(kTuned))).title;
    return {ColumnKind::rival, text, look != nullptr ? look->title : title, "", nullptr};
  }
  const auto listed = [&text](ColumnKind kind) {
    return RendererChoice{kind, text, viewer::lookOf(text)->title, "", nullptr};
  };
  if (text == kEdge) return listed(ColumnKind::edge);
  if (text == kBestSpring) return listed(ColumnKind::bestSpring);
  if (text == kScheduled) return listed(ColumnKind::scheduled);
  if (const std::filesystem::path path = std::filesystem::u8path(text); path.extension() == ".json") {
    const std::string name = path.stem().u8string();
    return {ColumnKind::hold, name, name, text, nullptr};
  }
  const RendererSource source = findRenderer(text, pluginFolder());
  if (source.plugin)
    return {ColumnKind::plugin, source.name + " (plugin)", source.name + " (plugin)", "", source.plugin};
  return listed(text == kImpedance   ? ColumnKind::impedance
                : text == kPassivity ? ColumnKind::passivity
                : text == kHold      ? ColumnKind::hold
                                     : ColumnKind::positionControl);
}

// Return the style of a column: that of its renderer, or the next one of the others.
Style styleOf(const RendererChoice& choice, std::size_t& others) {
  const viewer::RendererLook* look = choice.kind == ColumnKind::plugin ? nullptr : viewer::lookOf(choice.name);
  if (look == nullptr) look = &viewer::kOtherLooks[others++ % std::size(viewer::kOtherLooks)];
  Style style{look->colour, {}, 2.0};
  if (look->dash[0] > 0) style.dash = {look->dash[0], look->dash[1]};
  return style;
}

// Makes the renderers of plugins. Each receives those parameters of --set that it has.
class Plugins {
 public:
  explicit Plugins(const StudyOptions& options) : parameters_(parseParameters(options.set)), unused_(parameters_) {
    setup_.devicePath = options.designDevice.empty() ? options.device : options.designDevice;
    if (setup_.devicePath.empty()) setup_.deviceText = nominalDeviceText();
  }

  std::function<std::unique_ptr<Renderer>(std::size_t)> make(const RendererChoice& choice, ColumnRecords& records) {
    const EnamelDescription& description = choice.plugin->description();
    setup_.parameters.clear();
    for (std::size_t i = 0; i < description.parameter_count; ++i)
      if (const auto set = parameters_.find(description.parameters[i].key); set != parameters_.end()) {
        setup_.parameters.insert(*set);
        unused_.erase(set->first);
      }
    records.plugins[choice.name] = {{"version", description.version}, {"parameters", setup_.parameters}};
    return [plugin = choice.plugin, setup = setup_](std::size_t) { return makeRenderer(plugin, setup); };
  }

  void requireAllUsed() const {
    if (!unused_.empty())
      throw Error("--set gives " + unused_.begin()->first + ", which is not a parameter of any plugin in --renderers");
  }

 private:
  std::map<std::string, std::string> parameters_, unused_;
  PluginSetup setup_;
};

// Return the values of a rival at a delay from a file.
std::vector<double> valuesFor(const std::string& path, const std::string& rival, const Delay& delay) {
  if (path.empty())
    throw Error(std::string(kTuned) + rival +
                " needs --tuned: a file of enamel design --rivals, or servos/rivals-tau.json of the data");
  for (const ControllerValues& found : loadControllers(path).controllers)
    if (found.controller == rival && found.delayLow == delay.low && found.delayHigh == delay.high) return found.values;
  throw Error(fmt::format("{}: has no values of {} for a delay of {} to {} ticks", path, rival, delay.low, delay.high));
}

std::string checksumOfValues(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{} ", value);
  return checksumOf(text);
}

// Makes the renderer of a column for a query point.
using Make = std::function<std::unique_ptr<Renderer>(std::size_t point)>;

Make impedance(const ImpedanceOptions& wall, bool passive) {
  return [wall, passive](std::size_t) -> std::unique_ptr<Renderer> {
    auto spring = std::make_unique<ImpedanceRenderer>(wall);
    if (passive) return std::make_unique<PassivityRenderer>(std::move(spring));
    return spring;
  };
}

Make edge(const Study& study, std::size_t c, double& period) {
  constexpr double kRate = 4.0, kInside = 0.95;
  const double available = study.labels[c].damping;
  if (!(available > 0.0)) throw Error(std::string(kEdge) + " needs device damping: --device-damping " + kEdge + "=B");
  period = study.plan.setup.period / kRate;
  return impedance({kInside * 2.0 * available / period, 0.0}, false);
}

Make bestSpring(const Study& study, std::size_t c, ColumnRecords& records) {
  const std::string& name = study.plan.columns[c].name;
  const BestSpring best = findBestSpring(study.plan, c, study.options.threads);
  if (!(best.stiffness > 0.0)) throw Error(name + ": every spring of the search loses a run");
  const ImpedanceOptions& spring = best.spring;
  fmt::print(stderr, "{}: {:.4g} kN/m, {:.4g} N s/m; K_d {:.3g} kN/m in the search\n", name, 1e-3 * spring.stiffness,
             spring.damping, 1e-3 * best.stiffness);
  records.servos[name] = fmt::format("{} N/m, {} N s/m", spring.stiffness, spring.damping);
  return impedance(spring, false);
}

Make rival(const Study& study, const std::string& column, ColumnRecords& records) {
  const StudyOptions& options = study.options;
  const PushSetup& setup = study.plan.setup;
  const ControllerSpec& spec = rivalSpec(column.substr(std::strlen(kTuned)));
  const std::vector<double> values = valuesFor(options.tuned, spec.name, setup.delay);
  records.servos[column] = checksumOfValues(values);
  return [make = spec.with({study.design, setup.period, setup.delay}, values)](std::size_t) { return make(); };
}

Make positionControl(const Study& study) {
  const PushSetup& setup = study.plan.setup;
  const PositionControlOptions servo =
      positionControlFor(*study.mechanism, setup.period, setup.delay.low, setup.delay.high);
  PositionControlRenderer{servo};  // fail now rather than in a run
  return [servo](std::size_t) { return std::make_unique<PositionControlRenderer>(servo); };
}

Make hold(const Study& study, std::size_t c, ColumnRecords& records) {
  const StudyPlan& plan = study.plan;
  const double period = plan.setup.period;
  const bool scheduled = study.labels[c].kind == ColumnKind::scheduled;
  const std::string& file = study.labels[c].servo;
  std::vector<ServoGain> gains(scheduled ? plan.points() : 1);
  if (scheduled)
    parallelFor(gains.size(), study.options.threads, [&](std::size_t point) {
      Pose pose;
      pose.position = queryPoint(plan, point);
      gains[point] = designServo(study.design, pose, period).K;
    });
  else
    gains[0] = file.empty() ? ServoGain(study.home->K) : loadGain(file, study.mechanism->joints(), period);
  std::vector<double> entries;
  for (const ServoGain& gain : gains) entries.insert(entries.end(), gain.data(), gain.data() + gain.size());
  records.servos[plan.columns[c].name] = checksumOfValues(entries);
  HoldOptions servo;
  servo.release = study.options.release;
  return [gains = std::move(gains), period, servo](std::size_t point) {
    return std::make_unique<HoldRenderer>(gains[gains.size() > 1 ? point : 0], period, servo);
  };
}

Make linked(const Study& study, std::size_t c, double& period, ColumnRecords& records) {
  switch (study.labels[c].kind) {
    case ColumnKind::impedance: return impedance(study.options.impedance, false);
    case ColumnKind::passivity: return impedance(study.options.impedance, true);
    case ColumnKind::edge: return edge(study, c, period);
    case ColumnKind::bestSpring: return bestSpring(study, c, records);
    case ColumnKind::rival: return rival(study, study.plan.columns[c].name, records);
    case ColumnKind::positionControl: return positionControl(study);
    case ColumnKind::hold:
    case ColumnKind::scheduled: return hold(study, c, records);
    case ColumnKind::plugin: break;
  }
  return study.plan.columns[c].make;
}

// Design the servo of hold at home if a column needs it.
void designHome(Study& study) {
  const bool needed = std::any_of(study.labels.begin(), study.labels.end(), [](const ColumnLabel& label) {
    return label.kind == ColumnKind::scheduled || (label.kind == ColumnKind::hold && label.servo.empty());
  });
  if (!needed) return;
  const double period = study.plan.setup.period;
  study.home = designServo(study.design, Pose{}, period);
  if (!study.options.gain.empty()) study.home->K = loadGain(study.options.gain, study.mechanism->joints(), period);
}

}  // namespace

void addColumns(Study& study, ColumnRecords& records) {
  const StudyOptions& options = study.options;
  StudyPlan& plan = study.plan;
  Plugins plugins(options);
  DampingOption damping(options.deviceDamping);
  std::size_t others = 0;  // renderers without a look of their own
  for (const std::string& text : options.renderers) {
    const RendererChoice choice = choiceOf(text);
    if (choice.name.find_first_of(",\"") != std::string::npos || printable(choice.name) != choice.name)
      throw Error(text +
                  ": the name of a renderer is written into CSV files and must not contain a comma, quote or control "
                  "character");
    for (const StudyColumn& other : plan.columns)
      if (other.name == choice.name) throw Error("--renderers names " + choice.name + " twice");
    const double more = damping.of(choice.plugin ? choice.plugin->description().name : choice.name);
    DeviceParameters damped = study.device;
    addDamping(damped, more * Vec6::Unit(2));
    StudyColumn column;
    column.name = choice.name;
    column.plant = more > 0.0 ? makeMechanism(modelFor(options.plant, damped)) : study.mechanism;
    if (options.inertia != 1.0) column.model = withInertia(column.plant, options.inertia);
    column.makePlant = makerOf(options.plant, damped, plan.setup);
    // Round to 1 nN s/m: a damping of zero in the file leaves rounding errors.
    const double whole =
        1e-9 * std::nearbyint(1e9 * dampingAlong(*column.plant, plan.setup.start, plan.setup.hand.normal));
    records.dampings[choice.name] = more;
    if (choice.plugin) column.make = plugins.make(choice, records);
    plan.columns.push_back(std::move(column));
    study.labels.push_back({choice.kind, choice.title, whole, choice.servo, styleOf(choice, others)});
  }
  plugins.requireAllUsed();
  // The default may name a renderer that this study does not have.
  if (!damping.unused().empty() && options.deviceDamping != StudyOptions().deviceDamping)
    throw Error("--device-damping names " + damping.unused() + ", which --renderers does not");
}

void makeRenderers(Study& study, ColumnRecords& records) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < study.labels.size(); ++c)
    if (study.labels[c].kind != ColumnKind::plugin) names.push_back(study.plan.columns[c].name);
  checkGain(study.options.gain, names, "--renderers");
  designHome(study);
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    StudyColumn& column = study.plan.columns[c];
    column.make = linked(study, c, column.period, records);
  }
}

}  // namespace enamel::app
