#include "study/study.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "bench/nominal_device.hpp"
#include "enamel/core/error.hpp"
#include "enamel/study/parallel.hpp"
#include "plugin_folder.hpp"

namespace enamel::app {
namespace {

constexpr const char* kRateNames[] = {"exact", "difference", "lowPass"};
constexpr const char* kIntegratorNames[] = {"rungeKutta4", "midpoint", "semiImplicitEuler"};

TauParameters deviceOf(const std::string& path) { return path.empty() ? bench::nominalDevice() : loadTau(path); }

// Fowler, Noll, Vo (1991), FNV-1a, 64 bits: tells devices and designs apart, no more.
std::string hashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{:016x}", hash);
}

template <typename Matrix>
void append(std::string& text, const Matrix& m) {
  for (Eigen::Index i = 0; i < m.size(); ++i) text += fmt::format("{} ", m.data()[i]);
}

std::string hashOf(const TauParameters& d) {
  std::string text;
  append(text, d.gravity);
  for (const ChainParameters& c : d.chain) {
    append(text, c.base);
    append(text, c.platform);
    for (const LinkParameters* link : {&c.link1, &c.link2}) {
      text += fmt::format("{} {} ", link->length, link->mass);
      append(text, link->com);
      append(text, link->inertia);
    }
    text += fmt::format("{} ", c.elbow);
  }
  text += fmt::format("{} ", d.platform.mass);
  append(text, d.platform.com);
  append(text, d.platform.inertia);
  append(text, d.platform.damping);
  text += fmt::format("{} {} {} {}", d.motor.maxTorque, d.motor.rotorInertia, d.motor.encoderCounts,
                      d.motor.viscousFriction);
  return hashOf(text);
}

std::string hashOf(const std::vector<PositionControlRenderer::Gain>& gains) {
  std::string text;
  for (const auto& gain : gains) append(text, gain);
  return hashOf(text);
}

// A null where a number does not exist: neither 0 nor infinite.
Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

}  // namespace

std::size_t Study::column(const std::string& name) const {
  std::size_t i = 0;
  while (i < plan.columns.size() && plan.columns[i].name != name) ++i;
  return i;
}

Study prepareStudy(const StudyOptions& options) {
  Study study;
  study.options = options;
  study.device = deviceOf(options.device);
  study.designDevice = options.designDevice.empty() ? study.device : deviceOf(options.designDevice);
  study.designModel = makeModel(study.designDevice);
  StudyPlan& plan = study.plan;
  plan.scenarios = options.scenarios;
  plan.grid = options.grid;
  plan.runs = options.runs;
  plan.setup.seed = options.seed;
  plan.setup.delay = parseDelay(options.delay);
  plan.setup.encoders.quantised = options.encoders;
  plan.setup.encoders.rates = options.encoders ? RateSource::difference : RateSource::exact;

  PluginSetup pluginSetup;
  pluginSetup.devicePath = options.designDevice.empty() ? options.device : options.designDevice;
  if (pluginSetup.devicePath.empty()) pluginSetup.deviceText = bench::nominalDeviceText();
  const std::map<std::string, std::string> parameters = parseParameters(options.set);
  std::map<std::string, std::string> unused = parameters;
  Json plugins = Json::object();
  for (const std::string& text : options.renderers) {
    const RendererSource source = text == kScheduled ? RendererSource{text, nullptr} : findRenderer(text);
    if (study.column(source.name) < plan.columns.size()) throw Error("--renderers names " + source.name + " twice");
    plan.columns.push_back({source.name, plantFor(source.name, study.device, study.impedance), {}});
    if (!source.plugin) continue;
    const EnamelDescription& description = source.plugin->description();
    pluginSetup.parameters.clear();
    for (std::size_t i = 0; i < description.parameter_count; ++i)
      if (const auto set = parameters.find(description.parameters[i].key); set != parameters.end()) {
        pluginSetup.parameters.insert(*set);
        unused.erase(set->first);
      }
    plugins[source.name] = {{"version", description.version}, {"parameters", pluginSetup.parameters}};
    plan.columns.back().make = [plugin = source.plugin, pluginSetup](std::size_t) {
      return makeRenderer(plugin, pluginSetup);
    };
  }
  if (!unused.empty()) throw Error("--set gives " + unused.begin()->first + ", which no plugin of --renderers has");
  for (std::size_t i = 0; i < options.scenarios.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (options.scenarios[i] == options.scenarios[j])
        throw Error(fmt::format("--scenario names {} twice", options.scenarios[i]));
  if (options.threads < 1 || options.threads > kMaxThreads)
    throw Error(fmt::format("threads is {}, must be in 1 to {}", options.threads, kMaxThreads));
  checkStudy(plan);

  const double period = plan.setup.period;
  study.home = designServo(study.designModel, Pose{}, period);
  Json gainHashes;
  for (StudyColumn& column : plan.columns) {
    if (column.make) continue;  // a plugin
    if (column.name == kImpedance) {
      column.make = [model = study.designModel, impedance = study.impedance](std::size_t) {
        return std::make_unique<ImpedanceRenderer>(model, impedance);
      };
      continue;
    }
    std::vector<PositionControlRenderer::Gain> gains(column.name == kScheduled ? plan.points() : 1);
    parallelFor(gains.size(), options.threads, [&](std::size_t point) {
      Pose pose;
      if (column.name == kScheduled) pose.position = queryPoint(plan, point);
      gains[point] = column.name == kScheduled ? designServo(study.designModel, pose, period).K : study.home.K;
    });
    gainHashes[column.name] = hashOf(gains);
    PositionControlOptions servo;
    servo.release = options.release;
    column.make = [model = study.designModel, gains = std::move(gains), period, servo](std::size_t point) {
      return std::make_unique<PositionControlRenderer>(model, gains[gains.size() > 1 ? point : 0], period, servo);
    };
  }

  const PushSetup& setup = plan.setup;
  Json& m = study.manifest;
  m["enamel"] = ENAMEL_VERSION;
  m["scenarios"] = plan.scenarios;
  for (const StudyColumn& column : plan.columns) m["renderers"].push_back(column.name);
  if (!plugins.empty()) m["plugins"] = plugins;
  m["grid"] = plan.grid;
  m["runs"] = plan.runs;
  m["seed"] = setup.seed;
  m["delay [ticks]"] = {setup.delay.low, setup.delay.high};
  m["encoders"] = setup.encoders.quantised;
  m["rates"] = kRateNames[static_cast<int>(setup.encoders.rates)];
  m["period [s]"] = setup.period;
  m["duration [s]"] = setup.duration;
  m["noise [N]"] = setup.person.noise;
  m["release"] = options.release;
  m["guide"] = setup.person.guide;
  m["F_c [N]"] = {plan.lowestForce, plan.highestForce};
  m["half width [m]"] = plan.halfWidth;
  m["integrator"] = kIntegratorNames[static_cast<int>(setup.integrator)];
  m["substeps"] = setup.substeps;
  m["impedance"] = {{"stiffness [N/m]", study.impedance.stiffness},
                    {"damping [N s/m]", study.impedance.damping},
                    {"device damping [N s/m]", study.impedance.deviceDamping}};
  m["device"] = {{"name", study.device.name}, {"hash", hashOf(study.device)}};
  m["design device"] = {{"name", study.designDevice.name}, {"hash", hashOf(study.designDevice)}};
  m["servo gains"] = gainHashes;
  return study;
}

void writeFile(const std::string& path, const std::string& text) {
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wb"), &std::fclose);
  if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() || std::fflush(file.get()) != 0)
    throw Error(path + ": cannot write the file: " + std::strerror(errno));
}

std::string pointText(const Study& study, std::size_t point) {
  const Vec3 p = 1e3 * queryPoint(study.plan, point);
  return fmt::format("({:.4g}, {:.4g})", p.x(), p.y());
}

std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points) {
  std::string text =
      "scenario,renderer,x [m],y [m],runs,failed,D_z1 mean [m],D_z1 deviation [m],K_z1 runs,K_z1 mean [N/m],"
      "K_z1 deviation [N/m],C_zs mean [m/N],C_zs deviation [m/N],K_zs [N/m],F_c/rms depth mean [N/m],"
      "F_c/depth 95 % mean [N/m],largest depth [m],chatter mean [N m],saturated share mean,tangential force mean [N],"
      "largest drift [m],faults\n";
  for (const PointStatistics& p : points) {
    const Vec3 at = queryPoint(study.plan, p.point);
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", p.scenario,
                        study.plan.columns[p.column].name, at.x(), at.y(), p.runs, p.failed, cell(p.firstDepth.mean),
                        cell(p.firstDepth.deviation), p.firstStiffness.count, cell(p.firstStiffness.mean),
                        cell(p.firstStiffness.deviation), cell(p.compliance.mean), cell(p.compliance.deviation),
                        p.steadyStiffness         ? fmt::format("{}", *p.steadyStiffness)
                        : p.compliance.count == 0 ? ""
                                                  : "unresolved",
                        cell(p.forceOverRms.mean), cell(p.forceOver95.mean),
                        p.failed == p.runs ? "" : fmt::format("{}", p.largestDepth), cell(p.chatter),
                        cell(p.saturatedShare), cell(p.tangentialForce),
                        p.failed == p.runs ? "" : fmt::format("{}", p.drift), p.faults);
  }
  return text;
}

Json summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims) {
  Json summary;
  summary["study"] = study.manifest;
  Json& list = summary["walls"] = Json::array();
  const auto extreme = [&study](const std::optional<Extreme>& e) -> Json {
    if (!e || !std::isfinite(e->value)) return nullptr;
    const Vec3 at = queryPoint(study.plan, e->point);
    return {{"value", e->value}, {"x [m]", at.x()}, {"y [m]", at.y()}};
  };
  for (const WallSummary& w : walls) {
    Json json;
    json["scenario"] = w.scenario;
    json["renderer"] = study.plan.columns[w.column].name;
    json["lowest K_z1 [N/m]"] = extreme(w.lowestFirst);
    json["highest K_z1 [N/m]"] = extreme(w.highestFirst);
    json["lowest K_zs [N/m]"] = extreme(w.lowestSteady);
    json["highest K_zs [N/m]"] = extreme(w.highestSteady);
    json["mean K_zs [N/m]"] = numberOrNull(w.steady.mean);
    json["K_zs deviation over the wall [N/m]"] = numberOrNull(w.steady.deviation);
    json["points with K_zs unresolved"] = w.unresolved;
    json["lowest |C_zs| [m/N]"] = extreme(w.lowestCompliance);
    json["highest |C_zs| [m/N]"] = extreme(w.highestCompliance);
    json["lowest F_c/rms depth [N/m]"] = numberOrNull(w.lowestOverRms);
    json["lowest F_c/depth 95 % [N/m]"] = numberOrNull(w.lowestOver95);
    json["largest depth [m]"] = w.largestDepth;
    json["largest drift [m]"] = w.drift;
    json["largest mean chatter [N m]"] = w.chatter;
    json["largest mean saturated share"] = w.saturatedShare;
    json["largest mean tangential force [N]"] = w.tangentialForce;
    json["runs that left the workspace"] = w.failed;
    json["runs without a first impact"] = w.withoutFirst;
    json["faults"] = w.faults;
    list.push_back(json);
  }
  summary["claims"] = Json::array();
  for (const Claim& c : claims)
    summary["claims"].push_back({{"claim", c.text}, {"holds", c.holds}, {"measured", c.measured}});
  return summary;
}

std::vector<Claim> claimsOf(const Study& study, const std::vector<PointStatistics>& points,
                            const std::vector<WallSummary>& walls) {
  const std::size_t hold = study.column(kPositionControl), spring = study.column(kImpedance),
                    columns = study.plan.columns.size(), count = study.plan.points();
  std::vector<Claim> claims;
  const auto pointAt = [&](std::size_t scenario, std::size_t column, std::size_t point) -> const PointStatistics& {
    return points[(scenario * columns + column) * count + point];
  };
  for (std::size_t s = 0; s < study.plan.scenarios.size(); ++s) {
    const int scenario = study.plan.scenarios[s];
    if (hold < columns && spring < columns) {
      const WallSummary &servo = walls[s * columns + hold], &wall = walls[s * columns + spring];
      if (scenario == 1 && servo.lowestFirst && wall.highestFirst)
        claims.push_back(
            {"scenario 1: the lowest K_z1 of position control is above the highest of impedance",
             fmt::format("{:.0f} N/m at {} mm, {:.0f} N/m at {} mm", servo.lowestFirst->value,
                         pointText(study, servo.lowestFirst->point), wall.highestFirst->value,
                         pointText(study, wall.highestFirst->point)),
             servo.lowestFirst->value > wall.highestFirst->value && servo.withoutFirst == 0 && servo.failed == 0});
      std::size_t below = 0, worst = 0, lost = 0;
      double worstRatio = -1.0;
      for (std::size_t p = 0; p < count; ++p) {
        const double ratio =
            std::abs(pointAt(s, hold, p).compliance.mean) / std::abs(pointAt(s, spring, p).compliance.mean);
        below += ratio < 1.0;
        lost += !std::isfinite(ratio);
        if (ratio > worstRatio) worst = p, worstRatio = ratio;
      }
      claims.push_back(
          {fmt::format("scenario {}: |mean C_zs| of position control is below that of impedance", scenario),
           fmt::format("at {} of {} query points{}{}", below, count,
                       worstRatio < 0.0
                           ? ""
                           : fmt::format("; nearest at {} mm: {:.3g} of it", pointText(study, worst), worstRatio),
                       lost > 0 ? fmt::format("; at {} no run could be finished", lost) : ""),
           below == count});
    }
    if (hold < columns) {
      const WallSummary& servo = walls[s * columns + hold];
      claims.push_back({fmt::format("scenario {}: the largest penetration of position control is below 1 mm", scenario),
                        fmt::format("{:.3f} mm{}", 1e3 * servo.largestDepth,
                                    servo.failed > 0 ? fmt::format(", and {} runs left the workspace", servo.failed)
                                                     : std::string()),
                        servo.largestDepth < 1e-3 && servo.failed == 0});
    }
  }
  return claims;
}

}  // namespace enamel::app
