#include "study/study.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/nominal_device.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/render/surface_file.hpp"
#include "enamel/runtime/recording.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/parallel.hpp"
#include "json_matrices.hpp"
#include "plugin_folder.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kRateNames[] = {"exact", "difference", "lowPass"};
constexpr const char* kIntegratorNames[] = {"rungeKutta4", "midpoint", "semiImplicitEuler"};

// A device with the text of its file.
struct DeviceSource {
  DeviceParameters parameters;
  std::string text;
};

DeviceSource deviceOf(const std::string& path) {
  if (path.empty()) return {parseDevice(bench::nominalDeviceText(), "tau-nominal.toml"), bench::nominalDeviceText()};
  const std::string text = readFile(path);
  return {parseDevice(text, path), text};
}

// Fowler, Noll, Vo (1991), FNV-1a, 64 bits: tells devices and designs apart, no more.
std::string hashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{:016x}", hash);
}

std::string hashOf(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{} ", value);
  return hashOf(text);
}

std::string hashOf(const std::vector<ServoGain>& gains) {
  std::vector<double> values;
  for (const ServoGain& gain : gains) values.insert(values.end(), gain.data(), gain.data() + gain.size());
  return hashOf(values);
}

// --device-damping: B for every column, or NAME=B for some and 0 for the others.
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
      throw Error("--device-damping gives a value for every renderer and one for " + values_.rbegin()->first);
    unused_ = values_;
    unused_.erase("");
  }

  double of(const std::string& renderer) {
    unused_.erase(renderer);
    const auto found = values_.find(values_.count("") > 0 ? "" : renderer);
    return found == values_.end() ? 0.0 : found->second;
  }

  /// A name that no renderer has; empty where all were found.
  std::string unused() const { return unused_.empty() ? "" : unused_.begin()->first; }

 private:
  std::map<std::string, double> values_, unused_;
};

DeviceParameters withDamping(DeviceParameters device, double damping) {
  addDamping(device, damping * Vec6::Unit(2));
  return device;
}

bool isTuned(const std::string& name) { return name.rfind(kTuned, 0) == 0; }

ColumnKind kindOf(const std::string& linked) {
  return isTuned(linked)        ? ColumnKind::rival
         : linked == kEdge      ? ColumnKind::edge
         : linked == kImpedance ? ColumnKind::impedance
         : linked == kPassivity ? ColumnKind::passivity
         : linked == kScheduled ? ColumnKind::scheduled
         : linked == kHold      ? ColumnKind::hold
                                : ColumnKind::positionControl;
}

const char* titleOf(ColumnKind kind) {
  return kind == ColumnKind::impedance   ? "impedance"
         : kind == ColumnKind::passivity ? "impedance with passivity control"
         : kind == ColumnKind::scheduled ? "scheduled hold"
         : kind == ColumnKind::edge      ? "impedance at the edge of eq. 16"
         : kind == ColumnKind::hold      ? "hold"
                                         : "position control";
}

// The values that a file has for a law and a delay.
std::vector<double> valuesFor(const std::string& path, const std::string& law, const Delay& delay) {
  if (path.empty())
    throw Error(std::string(kTuned) + law +
                " needs --laws: a file of enamel design --rivals, or servos/rivals-tau.json of the data");
  for (const ControllerValues& found : loadControllers(path).controllers)
    if (found.controller == law && found.delayLow == delay.low && found.delayHigh == delay.high) return found.values;
  throw Error(fmt::format("{}: has no {} for a delay of {} to {} ticks", path, law, delay.low, delay.high));
}

// A null where a number does not exist: neither 0 nor infinite.
Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// What a push ends without a first impact stiffness for.
constexpr FirstImpactVerdict kWithoutFirst[] = {FirstImpactVerdict::rings, FirstImpactVerdict::slips,
                                                FirstImpactVerdict::noReturn, FirstImpactVerdict::unstable};
const Metric* const kFirst = &allMetrics()[indexOf(&PushMetrics::firstStiffness)];

// "rms depth [N/m]": a force over this depth.
std::string perForce(const MetricMember& depth) { return fmt::format("{} [N/m]", allMetrics()[indexOf(depth)].symbol); }

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

std::string Study::runsPath(int part) const {
  return path(options.parts == 1 ? "runs.csv" : fmt::format("runs-{}-of-{}.csv", part, options.parts));
}

std::size_t Study::column(ColumnKind kind) const {
  std::size_t i = 0;
  while (i < labels.size() && labels[i].kind != kind) ++i;
  return i;
}

Study prepareStudy(const StudyOptions& options) {
  Study study;
  study.options = options;
  const DeviceSource device = deviceOf(options.device),
                     designDevice = options.designDevice.empty() ? device : deviceOf(options.designDevice);
  study.device = device.parameters;
  study.designDevice = designDevice.parameters;
  study.mechanism = makeMechanism(study.device);
  study.design = makeMechanism(study.designDevice);
  StudyPlan& plan = study.plan;
  plan.scenarios = options.scenarios;
  plan.grid = options.grid;
  plan.runs = options.runs;
  plan.setup.seed = options.seed;
  plan.insideTick = options.insideTick;
  plan.setup.person.preload = options.preload;
  if (options.arm) plan.setup.person.arm = kArm;
  if (!(0.0 <= options.force[0] && options.force[0] <= options.force[1] && options.force[1] <= 1e3))
    throw Error(fmt::format("--force is {},{}, must be in 0 to 1000 N, low first", options.force[0], options.force[1]));
  plan.lowestForce = options.force[0];
  plan.highestForce = options.force[1];
  std::string sceneText;
  if (!options.scene.empty()) {
    if (options.grid != 1 || options.tip_mm != StudyOptions().tip_mm)
      throw Error("--scene has one query point and a tool of its own: it needs --grid 1 and no --tip");
    sceneText = readFile(options.scene);
    pushIn(parseScene(sceneText, options.scene), plan.setup);
    plan.middle = plan.setup.start.position;
  }
  const Vec3 tip = 1e-3 * Vec3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]);
  if (tip != Vec3::Zero()) holdAt(tip, plan.setup);
  plan.setup.delay = parseDelay(options.delay);
  plan.setup.guarded = options.guard;
  plan.setup.encoders.quantised = options.encoders;
  plan.setup.encoders.rates = options.encoders ? RateSource::difference : RateSource::exact;

  PluginSetup pluginSetup;
  pluginSetup.devicePath = options.designDevice.empty() ? options.device : options.designDevice;
  if (pluginSetup.devicePath.empty()) pluginSetup.deviceText = bench::nominalDeviceText();
  const std::map<std::string, std::string> parameters = parseParameters(options.set);
  std::map<std::string, std::string> unused = parameters;
  DampingOption damping(options.deviceDamping);
  Json plugins = Json::object(), dampings = Json::object();
  for (const std::string& text : options.renderers) {
    const bool own = text == kScheduled || text == kEdge || isTuned(text);
    const RendererSource source = own ? RendererSource{text, nullptr} : findRenderer(text);
    const std::string name = source.name + (source.plugin ? " (plugin)" : "");
    for (const StudyColumn& other : plan.columns)
      if (other.name == name) throw Error("--renderers names " + name + " twice");
    const double more = damping.of(source.name);
    const DeviceParameters damped = withDamping(study.device, more);
    plan.columns.push_back({name, more > 0.0 ? makeMechanism(damped) : study.mechanism, {}});
    plan.columns.back().makePlant = makerOf(options.plant, damped, plan.setup);
    // To the nanonewton: what is left of the file's zero is rounding.
    const double whole = 1e-9 * std::nearbyint(1e9 * dampingAlong(*plan.columns.back().plant, plan.setup.start,
                                                                  plan.setup.person.normal));
    dampings[name] = more;
    if (!source.plugin) {
      const ColumnKind kind = kindOf(name);
      study.labels.push_back(
          {kind, kind == ColumnKind::rival ? rivalSpec(name.substr(std::strlen(kTuned))).title : titleOf(kind), whole});
      continue;
    }
    study.labels.push_back({ColumnKind::plugin, name, whole});
    const EnamelDescription& description = source.plugin->description();
    pluginSetup.parameters.clear();
    for (std::size_t i = 0; i < description.parameter_count; ++i)
      if (const auto set = parameters.find(description.parameters[i].key); set != parameters.end()) {
        pluginSetup.parameters.insert(*set);
        unused.erase(set->first);
      }
    plugins[name] = {{"version", description.version}, {"parameters", pluginSetup.parameters}};
    plan.columns.back().make = [plugin = source.plugin, pluginSetup](std::size_t) {
      return makeRenderer(plugin, pluginSetup);
    };
  }
  if (!unused.empty()) throw Error("--set gives " + unused.begin()->first + ", which no plugin of --renderers has");
  // The default may name a renderer that is not asked for.
  if (!damping.unused().empty() && options.deviceDamping != StudyOptions().deviceDamping)
    throw Error("--device-damping names " + damping.unused() + ", which --renderers does not");
  for (std::size_t i = 0; i < options.scenarios.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (options.scenarios[i] == options.scenarios[j])
        throw Error(fmt::format("--scenario names {} twice", options.scenarios[i]));
  if (options.threads < 1 || options.threads > kMaxThreads)
    throw Error(fmt::format("threads is {}, must be in 1 to {}", options.threads, kMaxThreads));
  checkStudy(plan);

  const double period = plan.setup.period;
  const std::size_t none = plan.columns.size();
  std::vector<std::string> linked;
  for (std::size_t c = 0; c < none; ++c)
    if (study.labels[c].kind != ColumnKind::plugin) linked.push_back(plan.columns[c].name);
  checkGain(options.gain, linked, "--renderers");
  study.gainFor = options.gain.empty() ? "" : rendererOf(options.gain);
  if (study.column(ColumnKind::hold) < none || study.column(ColumnKind::scheduled) < none) {
    study.home = designServo(study.design, Pose{}, period);
    if (study.gainFor == kHold) study.home->K = loadGain(options.gain, study.mechanism->joints(), period);
  }
  Json gainHashes = Json::object();
  for (std::size_t c = 0; c < none; ++c) {
    StudyColumn& column = plan.columns[c];
    const ColumnKind kind = study.labels[c].kind;
    if (kind == ColumnKind::plugin) continue;
    if (kind == ColumnKind::impedance) {
      column.make = [impedance = study.impedance](std::size_t) {
        return std::make_unique<ImpedanceRenderer>(impedance);
      };
      continue;
    }
    if (kind == ColumnKind::edge) {
      constexpr double kRate = 4.0, kInside = 0.95;
      const double available = study.labels[c].damping;
      if (!(available > 0.0))
        throw Error(std::string(kEdge) + " needs device damping: --device-damping " + kEdge + "=B");
      column.period = period / kRate;
      column.make = [wall = ImpedanceOptions{kInside * 2.0 * available / column.period, 0.0}](std::size_t) {
        return std::make_unique<ImpedanceRenderer>(wall);
      };
      continue;
    }
    if (kind == ColumnKind::rival) {
      const ControllerSpec& law = rivalSpec(column.name.substr(std::strlen(kTuned)));
      const std::vector<double> values = valuesFor(options.laws, law.name, plan.setup.delay);
      gainHashes[column.name] = hashOf(values);
      column.make = [make = law.with({study.design, period, plan.setup.delay}, values)](std::size_t) { return make(); };
      continue;
    }
    if (kind == ColumnKind::passivity) {
      column.make = [impedance = study.impedance](std::size_t) {
        return std::make_unique<PassivityRenderer>(std::make_unique<ImpedanceRenderer>(impedance));
      };
      continue;
    }
    if (kind == ColumnKind::positionControl) {
      const SurfaceServoOptions servo = surfaceServo(study.gainFor == kPositionControl ? options.gain : "",
                                                     *study.mechanism, period, plan.setup.delay);
      gainHashes[column.name] = hashOf(surfaceServoText({"", servo}));
      column.make = [servo](std::size_t) { return std::make_unique<SurfaceServoRenderer>(servo); };
      continue;
    }
    const bool scheduled = kind == ColumnKind::scheduled;
    std::vector<ServoGain> gains(scheduled ? plan.points() : 1);
    parallelFor(gains.size(), options.threads, [&](std::size_t point) {
      Pose pose;
      if (scheduled) pose.position = queryPoint(plan, point);
      gains[point] = scheduled ? designServo(study.design, pose, period).K : study.home->K;
    });
    gainHashes[column.name] = hashOf(gains);
    PositionControlOptions servo;
    servo.release = options.release;
    column.make = [gains = std::move(gains), period, servo](std::size_t point) {
      return std::make_unique<PositionControlRenderer>(gains[gains.size() > 1 ? point : 0], period, servo);
    };
  }

  const PushSetup& setup = plan.setup;
  Json m;
  m["enamel"] = ENAMEL_VERSION;
  m["scenarios"] = plan.scenarios;
  for (const StudyColumn& column : plan.columns) m["renderers"].push_back(column.name);
  if (!plugins.empty()) m["plugins"] = plugins;
  m["grid"] = plan.grid;
  m["runs"] = plan.runs;
  m["seed"] = setup.seed;
  m["plant"] = options.plant;
  if (isUnit(options.plant)) m["CRC-32 of the plant"] = crc32(readFile(options.plant, std::size_t{1} << 30));
  m["delay [ticks]"] = {setup.delay.low, setup.delay.high};
  m["encoders"] = setup.encoders.quantised;
  m["rates"] = kRateNames[static_cast<int>(setup.encoders.rates)];
  m["period [s]"] = setup.period;
  m["duration [s]"] = setup.duration;
  m["noise [N]"] = setup.person.noise;
  m["preload [N]"] = setup.person.preload;
  m["arm"] = options.arm;
  m["tip [mm]"] = options.tip_mm;
  m["step inside its tick"] = plan.insideTick;
  m["release"] = options.release;
  m["guard"] = options.guard;
  m["guide"] = setup.person.guide;
  m["F_c [N]"] = {plan.lowestForce, plan.highestForce};
  m["half width [m]"] = plan.halfWidth;
  if (!options.scene.empty()) m["scene"] = hashOf(sceneText);
  m["integrator"] = kIntegratorNames[static_cast<int>(setup.integrator)];
  m["substeps"] = setup.substeps;
  m["impedance"] = {{"stiffness [N/m]", study.impedance.stiffness}, {"damping [N s/m]", study.impedance.damping}};
  m["device"] = {{"name", nameOf(study.device)}, {"hash", hashOf(device.text)}};
  m["device damping [N s/m]"] = dampings;
  m["design device"] = {{"name", nameOf(study.designDevice)}, {"hash", hashOf(designDevice.text)}};
  m["gain"] = study.gainFor.empty() ? "none given" : "given for " + study.gainFor;
  m["servo gains"] = gainHashes;
  study.manifest = textOf(m);
  return study;
}

std::string pointText(const Study& study, std::size_t point) {
  const Vec3 p = 1e3 * queryPoint(study.plan, point);
  return fmt::format("({:.4g}, {:.4g})", p.x(), p.y());
}

std::string delayText(const std::string& delay) {
  const Delay d = parseDelay(delay);
  return d.high == 0      ? "no delay"
         : d.low < d.high ? fmt::format("{}..{} ticks", d.low, d.high)
         : d.high == 1    ? "1 tick"
                          : fmt::format("{} ticks", d.high);
}

std::string withoutFirstText(const WallSummary& wall) {
  std::string text;
  for (const FirstImpactVerdict verdict : kWithoutFirst)
    if (const int count = wall.verdicts[static_cast<std::size_t>(verdict)]; count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, toString(verdict));
  return text;
}

std::string lostText(const WallSummary& wall) {
  std::string text;
  if (wall.failed > wall.stopped) text = fmt::format("{} runs left the workspace", wall.failed - wall.stopped);
  if (wall.stopped > 0)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", wall.stopped, toString(Status::stopped));
  return text;
}

bool anyFinished(const Study& study, const WallSummary& wall) {
  return static_cast<std::size_t>(wall.failed) < study.plan.points() * static_cast<std::size_t>(study.plan.runs);
}

std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points) {
  std::string text = "scenario,renderer,x [m],y [m],runs,failed";
  for (const FirstImpactVerdict verdict : kWithoutFirst) text += fmt::format(",{}", toString(verdict));
  for (const Metric& metric : allMetrics())
    text += fmt::format(",mean {},deviation {}", enamel::keyOf(metric), enamel::keyOf(metric));
  text += fmt::format(",runs with {},K_zs [N/m],mean F_c/{},mean F_c/{},largest {},largest {},faults\n", kFirst->symbol,
                      perForce(&PushMetrics::rmsDepth), perForce(&PushMetrics::depth95),
                      keyOf(&PushMetrics::largestDepth), keyOf(&PushMetrics::drift));
  for (const PointStatistics& p : points) {
    const Vec3 at = queryPoint(study.plan, p.point);
    const bool any = p.failed < p.runs;
    text += fmt::format("{},{},{},{},{},{}", p.scenario, study.plan.columns[p.column].name, at.x(), at.y(), p.runs,
                        p.failed);
    for (const FirstImpactVerdict verdict : kWithoutFirst)
      text += fmt::format(",{}", p.verdicts[static_cast<std::size_t>(verdict)]);
    for (const Spread& s : p.metrics) text += ',' + cell(s.mean) + ',' + cell(s.deviation);
    text += fmt::format(",{},{},{},{},{},{},{}\n", p.of(&PushMetrics::firstStiffness).count,
                        p.steadyStiffness ? fmt::format("{}", *p.steadyStiffness)
                        : any             ? "unresolved"
                                          : "",
                        cell(p.forceOverRms.mean), cell(p.forceOver95.mean),
                        any ? fmt::format("{}", p.largestDepth) : "", any ? fmt::format("{}", p.drift) : "", p.faults);
  }
  return text;
}

std::string summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims) {
  Json summary;
  summary["study"] = Json::parse(study.manifest);
  Json& list = summary["walls"] = Json::array();
  const auto extreme = [&study](const std::optional<Extreme>& e) -> Json {
    if (!e || !std::isfinite(e->value)) return nullptr;
    const Vec3 at = queryPoint(study.plan, e->point);
    return {{"value", e->value}, {"x [m]", at.x()}, {"y [m]", at.y()}};
  };
  for (const WallSummary& w : walls) {
    const auto largest = [any = anyFinished(study, w)](double value) { return any ? Json(value) : Json(nullptr); };
    Json json;
    json["scenario"] = w.scenario;
    json["renderer"] = study.plan.columns[w.column].name;
    json["plant's damping along z [N s/m]"] = study.labels[w.column].damping;
    json["lowest " + keyOf(&PushMetrics::firstStiffness)] = extreme(w.lowestFirst);
    json["highest " + keyOf(&PushMetrics::firstStiffness)] = extreme(w.highestFirst);
    json["lowest mean " + keyOf(&PushMetrics::limitShare)] = extreme(w.lowestShare);
    json["lowest K_zs [N/m]"] = extreme(w.lowestSteady);
    json["highest K_zs [N/m]"] = extreme(w.highestSteady);
    json["mean K_zs [N/m]"] = numberOrNull(w.steady.mean);
    json["deviation K_zs over the wall [N/m]"] = numberOrNull(w.steady.deviation);
    json["points with K_zs unresolved"] = w.unresolved;
    json["lowest |mean C_zs| [m/N]"] = extreme(w.lowestCompliance);
    json["highest |mean C_zs| [m/N]"] = extreme(w.highestCompliance);
    json["lowest mean F_c/" + perForce(&PushMetrics::rmsDepth)] = numberOrNull(w.lowestOverRms);
    json["lowest mean F_c/" + perForce(&PushMetrics::depth95)] = numberOrNull(w.lowestOver95);
    json[keyOf(&PushMetrics::largestDepth)] = largest(w.largestDepth);
    json["largest " + keyOf(&PushMetrics::drift)] = largest(w.drift);
    json["largest mean " + keyOf(&PushMetrics::chatter)] = largest(w.chatter);
    json["largest mean " + keyOf(&PushMetrics::saturatedShare)] = largest(w.saturatedShare);
    json["largest mean " + keyOf(&PushMetrics::tangentialForce)] = largest(w.tangentialForce);
    json["largest mean " + keyOf(&PushMetrics::bounce)] = largest(w.bounce);
    json["runs that left the workspace"] = w.failed - w.stopped;
    json["runs stopped by the guard"] = w.stopped;
    Json& without = json[std::string("runs without ") + kFirst->symbol];
    for (const FirstImpactVerdict verdict : kWithoutFirst)
      without[toString(verdict)] = w.verdicts[static_cast<std::size_t>(verdict)];
    json["faults"] = w.faults;
    list.push_back(json);
  }
  summary["claims"] = Json::array();
  for (const Claim& c : claims)
    summary["claims"].push_back({{"claim", c.text}, {"holds", c.holds}, {"measured", c.measured}});
  return textOf(summary);
}

std::vector<Claim> claimsOf(const Study& study, const std::vector<PointStatistics>& points,
                            const std::vector<WallSummary>& walls) {
  const std::size_t spring = study.column(ColumnKind::impedance), columns = study.plan.columns.size(),
                    count = study.plan.points();
  std::vector<Claim> claims;
  const auto pointAt = [&](std::size_t scenario, std::size_t column, std::size_t point) -> const PointStatistics& {
    return points[(scenario * columns + column) * count + point];
  };
  const auto firstText = [&](std::size_t scenario, std::size_t column, std::size_t point) {
    return meanText(pointAt(scenario, column, point).of(&PushMetrics::firstStiffness));
  };
  for (std::size_t s = 0; s < study.plan.scenarios.size(); ++s) {
    const int scenario = study.plan.scenarios[s];
    for (const ColumnKind kind : {ColumnKind::hold, ColumnKind::positionControl}) {
      const std::size_t column = study.column(kind);
      if (column == columns) continue;
      const std::string& title = study.labels[column].title;
      const WallSummary& servo = walls[s * columns + column];
      if (spring < columns) {
        const WallSummary& wall = walls[s * columns + spring];
        if (scenario == 1 && servo.lowestFirst && wall.highestFirst)
          claims.push_back(
              {fmt::format("scenario 1: the lowest K_z1 of {} is above the highest of impedance", title),
               fmt::format("{} N/m at {} mm, {} N/m at {} mm", firstText(s, column, servo.lowestFirst->point),
                           pointText(study, servo.lowestFirst->point), firstText(s, spring, wall.highestFirst->point),
                           pointText(study, wall.highestFirst->point)),
               servo.lowestFirst->value > wall.highestFirst->value && servo.withoutFirst() == 0 && servo.stable()});
        std::size_t below = 0, worst = 0, lost = 0;
        double worstRatio = -1.0, half = 0.0;  // half: of the ratio's 95 % interval, to first order
        for (std::size_t p = 0; p < count; ++p) {
          const Spread &ours = pointAt(s, column, p).of(&PushMetrics::steadyCompliance),
                       &theirs = pointAt(s, spring, p).of(&PushMetrics::steadyCompliance);
          const double ratio = std::abs(ours.mean / theirs.mean);
          below += ratio < 1.0;
          lost += !std::isfinite(ratio);
          if (!(ratio > worstRatio)) continue;
          worst = p;
          worstRatio = ratio;
          half = std::hypot(halfInterval(ours), ratio * halfInterval(theirs)) / std::abs(theirs.mean);
        }
        claims.push_back(
            {fmt::format("scenario {}: |mean C_zs| of {} is below that of impedance", scenario, title),
             fmt::format("at {} of {} query points{}{}", below, count,
                         worstRatio < 0.0 ? ""
                                          : fmt::format("; nearest at {} mm: {} of it", pointText(study, worst),
                                                        meanText(worstRatio, half)),
                         lost > 0 ? fmt::format("; at {} no run could be finished", lost) : ""),
             below == count && servo.stable()});
      }
      claims.push_back({fmt::format("scenario {}: the largest penetration of {} is below 1 mm", scenario, title),
                        !anyFinished(study, servo)
                            ? lostText(servo)
                            : fmt::format("{:.3f} mm{}", 1e3 * servo.largestDepth,
                                          servo.failed > 0 ? ", and " + lostText(servo) : std::string()),
                        servo.largestDepth < 1e-3 && servo.stable()});
    }
  }
  return claims;
}

}  // namespace enamel::app
