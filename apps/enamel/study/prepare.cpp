#include <fmt/core.h>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_design.hpp"
#include "json_matrices.hpp"
#include "plant_option.hpp"
#include "study/columns.hpp"

namespace enamel::app {
namespace {

constexpr const char* kRateNames[] = {"exact", "difference", "lowPass"};
constexpr const char* kIntegratorNames[] = {"rungeKutta4", "midpoint", "semiImplicitEuler"};

// Contents of the files that a study reads.
struct SourceTexts {
  std::string device, designDevice, scene;
};

std::string deviceText(const std::string& path) { return path.empty() ? nominalDeviceText() : readFile(path); }

void loadDevices(Study& study, SourceTexts& texts) {
  const auto parse = [](const std::string& text, const std::string& path) {
    return parseDevice(text, path.empty() ? "tau-nominal.toml" : path);
  };
  const StudyOptions& options = study.options;
  texts.device = texts.designDevice = deviceText(options.device);
  study.device = study.designDevice = parse(texts.device, options.device);
  if (!options.designDevice.empty()) {
    texts.designDevice = deviceText(options.designDevice);
    study.designDevice = parse(texts.designDevice, options.designDevice);
  }
  study.mechanism = makeMechanism(modelFor(options.plant, study.device));
  study.design = makeMechanism(modelFor(options.plant, study.designDevice));
  if (options.inertia != 1.0) study.design = withInertia(study.design, options.inertia);
}

// Set where the tool is pushed: in a scene, or at a point beside its TCP.
void placePush(Study& study, SourceTexts& texts) {
  const StudyOptions& options = study.options;
  StudyPlan& plan = study.plan;
  if (!options.scene.empty()) {
    if (options.grid != 1 || options.tip_mm != StudyOptions().tip_mm)
      throw Error("--scene has one query point and its own tool: give --grid 1 and omit --tip");
    texts.scene = readFile(options.scene);
    setScene(parseScene(texts.scene, options.scene), plan.setup);
    plan.middle = plan.setup.start.position;
  }
  const Vec3 tip = 1e-3 * Vec3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]);
  if (tip != Vec3::Zero()) setToolTip(tip, plan.setup);
}

void setPlan(Study& study, SourceTexts& texts) {
  const StudyOptions& options = study.options;
  StudyPlan& plan = study.plan;
  plan.scenarios = options.scenarios;
  plan.grid = options.grid;
  plan.runs = options.runs;
  plan.setup.seed = options.seed;
  plan.insideTick = options.insideTick;
  plan.setup.hand.preload = options.preload;
  plan.setup.hand.noise = options.noise;
  if (options.arm) plan.setup.hand.arm = kArm;
  if (options.rest) plan.setup.hand.rest = kFingerRest;
  if (!(0.0 <= options.force[0] && options.force[0] <= options.force[1] && options.force[1] <= 1e3))
    throw Error(
        fmt::format("--force is {},{}, must be in 0 to 1000 N, the smaller first", options.force[0], options.force[1]));
  plan.lowestForce = options.force[0];
  plan.highestForce = options.force[1];
  placePush(study, texts);
  plan.setup.delay = parseDelay(options.delay);
  plan.setup.guarded = options.guard;
  plan.setup.encoders.quantised = options.encoders;
  plan.setup.encoders.rates = options.encoders ? RateSource::difference : RateSource::exact;
}

void checkOptions(const StudyOptions& options) {
  for (std::size_t i = 0; i < options.scenarios.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (options.scenarios[i] == options.scenarios[j])
        throw Error(fmt::format("--scenario names {} twice", options.scenarios[i]));
  if (options.threads < 1 || options.threads > kMaxThreads)
    throw Error(fmt::format("threads is {}, must be in 1 to {}", options.threads, kMaxThreads));
}

std::string manifestOf(const Study& study, const SourceTexts& texts, const ColumnRecords& records) {
  const StudyOptions& options = study.options;
  const StudyPlan& plan = study.plan;
  const PushSetup& setup = plan.setup;
  Json m;
  m["enamel"] = ENAMEL_VERSION;
  m["scenarios"] = plan.scenarios;
  for (const StudyColumn& column : plan.columns) m["renderers"].push_back(column.name);
  if (!records.plugins.empty()) m["plugins"] = records.plugins;
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
  m["noise [N]"] = setup.hand.noise;
  m["preload [N]"] = setup.hand.preload;
  m["arm"] = options.arm;
  if (options.rest) m["finger rest"] = true;
  m["tip [mm]"] = options.tip_mm;
  m["step inside its tick"] = plan.insideTick;
  m["release"] = options.release;
  m["guard"] = options.guard;
  m["guide"] = setup.hand.guide;
  m["F_c [N]"] = {plan.lowestForce, plan.highestForce};
  m["half width [m]"] = plan.halfWidth;
  if (!options.scene.empty()) m["scene"] = checksumOf(texts.scene);
  m["integrator"] = kIntegratorNames[static_cast<int>(setup.integrator)];
  m["substeps"] = setup.substeps;
  m["impedance"] = {{"stiffness [N/m]", options.impedance.stiffness}, {"damping [N s/m]", options.impedance.damping}};
  m["device"] = {{"name", nameOf(study.device)}, {"CRC-32", checksumOf(texts.device)}};
  m["device damping [N s/m]"] = records.dampings;
  m["design device"] = {{"name", nameOf(study.designDevice)}, {"CRC-32", checksumOf(texts.designDevice)}};
  if (options.inertia != 1.0) m["inertia of the model"] = options.inertia;
  m["gain"] = options.gain.empty() ? "none given" : "given for hold";
  m["servo gains"] = records.servos;
  return textOf(m);
}

}  // namespace

Study prepareStudy(const StudyOptions& options) {
  Study study;
  study.options = options;
  SourceTexts texts;
  ColumnRecords records;
  loadDevices(study, texts);
  setPlan(study, texts);
  addColumns(study, records);
  checkOptions(options);
  checkStudy(study.plan);
  makeRenderers(study, records);
  study.manifest = manifestOf(study, texts, records);
  return study;
}

}  // namespace enamel::app
