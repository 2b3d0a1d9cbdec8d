// Identification: its parts compared with properties and the imperfect plant, and blind tests of the whole.
#include "enamel/identify/identify.hpp"

#include <cmath>
#include <map>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/identify/device_text.hpp"
#include "identify/cogging.hpp"
#include "identify/fit.hpp"
#include "identify/wiring.hpp"
#include "support/blind_devices.hpp"
#include "support/catch.hpp"
#include "support/mechanisms.hpp"
#include "support/run_length.hpp"

namespace enamel::test_identify {

namespace {

const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };

RecordedTick tickAt(std::uint64_t number, double q, int age = 0) {
  RecordedTick tick;
  tick.number = number;
  tick.measurement.time = 1e-3 * static_cast<double>(number);
  tick.measurement.q = JointVector::Constant(3, q);
  tick.measurement.age = age;
  tick.command = JointVector::Zero(3);
  return tick;
}

const Estimate& find(const Identification& result, const std::string& key) {
  for (const Estimate& e : result.estimates)
    if (e.key == key) return e;
  FAIL("no estimate of " << key);
  return result.estimates.front();
}

// Identify a blind device of 3 axes.
Identification identifyFrom(const std::vector<RecordedTick>& ticks, const test::BlindDevice& device) {
  return identifyDevice(motionsOf(ticks, 1e-3, 3), device.file);
}

}  // namespace

TEST_CASE("motions end at missing ticks, and a lost sample is interpolated", "[identify]") {
  std::vector<RecordedTick> ticks;
  for (std::uint64_t i = 0; i < 3000; ++i) ticks.push_back(tickAt(i, 1e-3 * static_cast<double>(i)));
  ticks[1000] = tickAt(1000, 99.0, 1);
  for (std::uint64_t i = 3005; i < 6000; ++i) ticks.push_back(tickAt(i, 0.0));
  for (std::uint64_t i = 6000; i < 6500; ++i) ticks.push_back(tickAt(i + 100, 0.0));  // too short
  const auto motions = motionsOf(ticks, 1e-3, 3);
  REQUIRE(motions.size() == 2);
  CHECK(motions[0].ticks() == 3000);
  CHECK(motions[1].ticks() == 2995);
  CHECK(motions[0].isSample[1000] == 0);
  CHECK(motions[0].reading(2, 1000) == Approx(1.0).margin(1e-12));  // rounding
  CHECK_THROWS_AS(motionsOf(ticks, 1e-3, 6), Error);
}

TEST_CASE("a spectrum has the power of its signal, and whitening leaves unit power", "[identify]") {
  test::Random random(5);
  Eigen::VectorXd noise(4000);
  for (double& v : noise) v = random.uniform(-1.0, 1.0);  // variance 1/3
  const identify::Spectrum spectrum(noise.size(), 1e-3, 2.0);
  const Eigen::VectorXcd transformed = spectrum.transform(noise);
  CHECK(spectrum.mean(transformed.cwiseAbs2()) == Approx(1.0 / 3.0).epsilon(0.06));  // 3 deviations of 4000 samples
  const Eigen::VectorXd power = spectrum.spread(spectrum.bands(transformed.cwiseAbs2()));
  CHECK(spectrum.mean(transformed.cwiseAbs2().cwiseQuotient(power)) == Approx(1.0).epsilon(0.06));
  CHECK((spectrum.bands(power) - spectrum.bands(transformed.cwiseAbs2())).norm() < 0.2 * spectrum.bands(power).norm());
  const Eigen::VectorXd back = spectrum.inverse(transformed);
  CHECK((back - noise).segment(300, 3400).norm() < 1e-12 * noise.norm());  // the window is 1 there; rounding
}

TEST_CASE("inverse dynamics invert the forward dynamics of every device", "[identify]") {
  test::Random random(7);
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    const Pose pose = shipped.pose(random);
    const Vec6 twist = shipped.twist(random);
    Kinematics k;
    REQUIRE(mechanism->reach(pose, twist, false, k) == Status::ok);
    JointVector torque = mechanism->limits().effort;
    for (double& t : torque) t *= random.uniform(-0.5, 0.5);
    Vec6 acceleration;
    REQUIRE(mechanism->accelerate(pose, twist, torque, Vec6::Zero(), acceleration) == Status::ok);
    constexpr double kAhead = 1e-4;  // s
    Kinematics before, after;
    REQUIRE(mechanism->track(k.q - kAhead * k.rates, k.rates, false, before = k) == Status::ok);
    REQUIRE(mechanism->track(k.q + kAhead * k.rates, k.rates, false, after = k) == Status::ok);
    const Vec6 turning = (after.jacobian - before.jacobian) * k.rates / (2.0 * kAhead);
    const JointVector joints = k.inverseTransposed.transpose() * (acceleration - turning);
    Kinematics start = k;
    const auto needed = identify::inverseDynamics(*mechanism, k.q, k.rates, joints, start);
    REQUIRE(needed);
    CHECK((*needed - torque).norm() < 1e-3 * mechanism->limits().effort.norm());  // one-sided difference of J
  }
}

namespace {

// A blind device whose recording loses no sample, and the model of its hidden numbers.
struct Known {
  test::BlindDevice device;
  RecordedMotion motion;
  identify::DeviceModel model;
  ImperfectDevice built;
  identify::Observer observer;
  Eigen::MatrixXd route;

  explicit Known(test::BlindKind kind, bool isRounded = true) : device(test::makeBlindDevice(kind, 4)) {
    device.lost = device.jitter = 0.0;
    device.isRounded = isRounded;
    const int n = device.built.mechanism->joints();
    motion = motionsOf(test::recordBlind(device, 5.0, 2), 1e-3, n)[0];
    model = identify::modelOf(device.truth);
    model.home = makeMechanism(device.file)->home().q;
    model.delay = device.delay.low;
    model.lag = device.value.at("motor lag");
    model.ratio = device.built.torqueConstant;
    model.coulomb = device.built.coulombFriction;
    model.drive = device.built.imperfections;
    for (int i = 0; i < n; ++i)
      if (const auto offset = device.value.find("encoder offset of joint " + std::to_string(i + 1));
          offset != device.value.end())
        model.offset[i] = offset->second;
    built = identify::deviceOf(model);
    const JointVector phase = device.built.coggingPhase - model.drive.periods * built.offset;  // of the reading
    model.sine = device.built.cogging.array() * phase.array().cos();
    model.cosine = device.built.cogging.array() * phase.array().sin();
    observer = identify::observerFor(model, 1e-3);
    route = motion.reading.colwise() - Eigen::VectorXd(built.offset);
  }

  identify::PathDynamics path(const identify::DeviceModel& of, double period, int interval) const {
    return identify::dynamicsAlong(*identify::deviceOf(of).mechanism, route, period, interval, 2);
  }
  identify::Simulated simulate(const identify::DeviceModel& of,
                               const std::vector<identify::ModelChange>& changes = {}) const {
    return identify::simulate(of, path(of, 1e-3, observer.interval), motion, observer, 0, route.cols(), changes);
  }
  // Take the simulated stretch of the cables out of the route, and use short steps.
  void refine(int parts) {
    const identify::Simulated first = simulate(model);
    route = first.joints + motion.reading - first.reading;
    observer.parts = parts;
    observer.substeps = 2 * parts;
    observer.interval = 1;
  }
};

// A copy of a device with rounded encoders, which is recorded once.
Known knownDevice(test::BlindKind kind) {
  static std::map<test::BlindKind, Known> known;
  return known.try_emplace(kind, kind).first->second;
}

// Root mean square of rows in deviations of the encoder's rounding, 1/sqrt(12) steps, after the transient of 1.5 s.
JointVector inRoundings(const Known& known, const Eigen::MatrixXd& rows) {
  const Eigen::Index count = rows.cols() - 1500;
  const Eigen::VectorXd rms = (rows.rightCols(count).rowwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt();
  return std::sqrt(12.0) * rms.cwiseQuotient(known.built.mechanism->limits().encoderStep);
}

}  // namespace

TEST_CASE("the simulation of a fit moves as the imperfect plant", "[identify]") {
  for (const auto kind :
       {test::BlindKind::cartesian3, test::BlindKind::cartesian6, test::BlindKind::delta, test::BlindKind::tau}) {
    Known known(kind, false);
    INFO(known.built.mechanism->name());
    known.refine(32);
    const identify::Simulated simulated = known.simulate(known.model);
    CHECK(simulated.restarts == 0);
    // The TAU has 0.015, from the steps of both programs. 30 000 readings show errors from 1/sqrt(30 000) = 0.006 on.
    // Damping about wrong axes gives 2, and a start that is not forgotten 0.4.
    CHECK(inRoundings(known, simulated.reading - known.motion.reading).maxCoeff() < 0.03);
  }
}

TEST_CASE("dynamics between knots are as good as at every tick", "[identify]") {
  for (const auto kind : {test::BlindKind::cartesian6, test::BlindKind::delta, test::BlindKind::tau}) {
    Known known = knownDevice(kind);
    INFO(known.built.mechanism->name());
    known.refine(8);
    const Eigen::MatrixXd exact = known.simulate(known.model).reading;
    const auto errorOf = [&](int interval) {
      known.observer.interval = interval;
      return inRoundings(known, known.simulate(known.model).reading - exact).maxCoeff();
    };
    // Fourth order: half of the interval leaves 1/16 of the error, and the knots of refine() at most 1/15 of the
    // difference to those of twice their interval. 0.1 of the rounding adds 0.5 % to the noise.
    const double coarse = errorOf(4), fine = errorOf(2);
    CAPTURE(coarse, fine);
    CHECK(fine < 0.1);
    CHECK(fine < std::max(1e-3, 0.25 * coarse));
  }
}

TEST_CASE("slopes of the simulation are differences of simulations", "[identify]") {
  for (const auto kind :
       {test::BlindKind::cartesian3, test::BlindKind::cartesian6, test::BlindKind::delta, test::BlindKind::tau}) {
    Known known = knownDevice(kind);
    INFO(known.built.mechanism->name());
    known.refine(4);
    known.route.conservativeResize(Eigen::NoChange, 2000);
    std::vector<identify::Unknown> unknowns = identify::unknownsOf(known.model);
    for (const identify::Unknown& u : identify::coggingUnknowns(known.model, known.motion.reading))
      unknowns.push_back(u);
    unknowns[unknowns.size() - 2].reference = known.model.drive.periods;
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      if (unknowns[i].scale != 0.0) unknowns[i].reference = unknowns[i].value(known.model);
    // Small against each number: the motor lag, the smallest, is about its scale.
    constexpr double kStep = 1e-4;
    const auto n = static_cast<Eigen::Index>(unknowns.size());
    const auto changed = [&](Eigen::Index i, double step) {
      return identify::modelAt(known.model, unknowns, step * Eigen::VectorXd::Unit(n, i));
    };
    for (Eigen::Index first = 0; first < n; first += identify::kLanes) {
      const Eigen::Index count = std::min<Eigen::Index>(n - first, identify::kLanes);
      std::vector<identify::PathDynamics> slopes(static_cast<std::size_t>(count));
      std::vector<identify::ModelChange> changes;
      for (Eigen::Index k = 0; k < count; ++k) {
        changes.push_back({changed(first + k, -kStep), changed(first + k, kStep), 2.0 * kStep});
        if (unknowns[static_cast<std::size_t>(first + k)].isOfDrives) continue;
        identify::PathDynamics& slope = slopes[static_cast<std::size_t>(k)];
        slope = known.path(changes.back().after, 0.0, 1);
        slope.knots = (slope.knots - known.path(changes.back().before, 0.0, 1).knots) / (2.0 * kStep);
        changes.back().path = &slope;
      }
      const identify::Simulated simulated = known.simulate(known.model, changes);
      for (std::size_t k = 0; k < changes.size(); ++k) {
        INFO(unknowns[static_cast<std::size_t>(first) + k].key);
        const Eigen::MatrixXd difference =
            known.simulate(changes[k].after).reading - known.simulate(changes[k].before).reading;
        const Eigen::MatrixXd exact = difference.rightCols(1000) / (2.0 * kStep);
        // The mean torques of a step include those of inertia: ringing cables turn by up to 0.3 rad in it.
        CHECK((simulated.slopes[k].rightCols(1000) - exact).norm() < 0.02 * exact.norm());
      }
    }
  }
}

TEST_CASE("an excitation survives its file, begins smoothly and stays inside its box", "[identify]") {
  for (const char* file : {"cartesian-3.toml", "delta.toml", "cartesian-6.toml", "tau-nominal.toml"}) {
    INFO(file);
    const auto mechanism = makeMechanism(loadDevice(test::deviceFile(file)));
    ExcitationOptions options;
    options.duration = 6.0;
    const Excitation excitation = designExcitation(*mechanism, options);
    const std::string text = textOf(excitation);
    CHECK(textOf(parseExcitation(text, "plan")) == text);
    CHECK(wrenchAt(excitation, 0.001, Pose{}, Vec6::Zero()).norm() < 1e-3 * excitation.force);
    CHECK(wrenchAt(excitation, 6.001, Pose{}, Vec6::Zero()).norm() == 0.0);
    VirtualDeviceSetup setup;
    setup.encoders = {true, RateSource::difference, 100.0};
    VirtualDevice device(*mechanism, setup);
    double largest = 0.0;
    const auto each = [&](std::uint64_t, const Measurement&, const HapticTick& haptics, const Command&, Status) {
      const Vec3 p = haptics.frame().kinematics.pose.position;
      largest = std::max(largest, p.cwiseAbs().cwiseQuotient(excitation.workspace).maxCoeff());
    };
    CHECK(runExcitation(excitation, *mechanism, device, nothing, each) == GuardReason::none);
    CHECK(largest < 1.0);
    CHECK(largest > 0.1);
  }
  CHECK_THROWS_AS(parseExcitation("duration = 1\n", "plan"), ConfigurationError);
}

TEST_CASE("a value of a device file is replaced, and its comment stays", "[identify]") {
  const std::string text = "name = \"x\"  # [a]\n[platform]\nmass = 0.1   # kg\n\n[motor]\nmass = 2\n";
  CHECK(withValue(text, "platform.mass", "0.25") ==
        "name = \"x\"  # [a]\n[platform]\nmass = 0.25  # kg\n\n[motor]\nmass = 2\n");
  CHECK(withValue(text, "motor.lag", "1").find("[motor]\nlag = 1\nmass = 2\n") != std::string::npos);
  CHECK(withValue(text, "other.key", "1").find("\n[other]\nkey = 1\n") != std::string::npos);
  CHECK(withValue(text, "name", "\"y\"").find("name = \"y\"  # [a]\n") == 0);
  CHECK_THROWS_AS(withValue("[a]\nb = [\n1]\n", "a.b", "1"), Error);
}

TEST_CASE("a blind Cartesian device: delay, mass and friction", "[identify]") {
  const int devices = test::count(3, 100);
  const double duration = test::longRun() ? 30.0 : 8.0;
  int intervals = 0, covered = 0;
  for (int i = 0; i < devices; ++i) {
    const test::BlindDevice device =
        test::makeBlindDevice(test::BlindKind::cartesian3, test::seed() + static_cast<std::uint64_t>(i));
    const Identification result =
        identifyDevice(motionsOf(test::recordBlind(device, duration, test::seed() + 1), 1e-3, 3), device.file);
    INFO(tableOf(result));
    REQUIRE(result.isUsable());
    CHECK(result.delay.low == device.delay.low);
    CHECK(result.delay.high == device.delay.low);
    CHECK(find(result, "platform.mass").value == Approx(device.value.at("platform.mass")).epsilon(0.03));
    for (const char* axis : {"x", "y", "z"}) {
      const std::string key = std::string("Coulomb friction of axis ") + axis;
      CHECK(find(result, key).value == Approx(device.value.at(key)).epsilon(0.15));
    }
    CHECK(result.explained.minCoeff() > 0.97);
    const auto* written = std::get_if<CartesianParameters>(&result.device);
    REQUIRE(written != nullptr);
    const std::string text = identifiedText(readFile(test::deviceFile("cartesian-3.toml")), result);
    const auto read = std::get<CartesianParameters>(parseDevice(text, "identified"));
    CHECK(read.mass == Approx(written->mass).epsilon(1e-5));
    const Imperfections &drive = read.imperfections, &truth = device.built.imperfections;
    CHECK(drive.periods == Approx(truth.periods).epsilon(0.01));
    CHECK(drive.coulombFriction == Approx(device.built.coulombFriction.mean()).epsilon(0.15));
    CHECK(drive.cogging == Approx(device.built.cogging.mean()).epsilon(0.15));
    CHECK(drive.currentBandwidth == Approx(truth.currentBandwidth).epsilon(0.15));
    CHECK(drive.lostSamples == Approx(result.lostSamples).epsilon(1e-5));
    for (const Estimate& e : result.estimates) {
      const auto hidden = device.value.find(e.key);
      if (hidden == device.value.end()) continue;
      ++intervals;
      if (hidden->second >= e.low && hidden->second <= e.high) ++covered;
    }
  }
  // 95 % are expected. A short recording shows too little of the friction's slow errors, above all in gravity: 213 of
  // 228 intervals of 12 seeds. 85 % of 3 devices are 2.5 deviations below that.
  CHECK(covered >= (test::longRun() ? 0.9 : 0.85) * intervals);
}

// All motors give less or more than commanded. Without a known weight, all masses are wrong by that factor.
TEST_CASE("a known weight at the TCP shows the scale of all forces", "[identify]") {
  constexpr double kWeight = 0.1;  // kg
  for (int i = 0; i < test::count(2, 20); ++i)
    for (const double scale : {0.8, 1.15}) {
      test::BlindDevice device =
          test::makeBlindDevice(test::BlindKind::cartesian3, test::seed() + static_cast<std::uint64_t>(i));
      device.built.torqueConstant *= scale;
      std::vector<RecordedMotion> motions = motionsOf(test::recordBlind(device, 12.0, test::seed() + 1), 1e-3, 3);
      CartesianParameters heavier = std::get<CartesianParameters>(device.truth);
      heavier.mass += kWeight;
      device.built.mechanism = makeMechanism(heavier);
      for (RecordedMotion& motion : motionsOf(test::recordBlind(device, 12.0, test::seed() + 2), 1e-3, 3)) {
        motion.weight = kWeight;
        motions.push_back(std::move(motion));
      }
      const Identification result = identifyDevice(motions, device.file);
      INFO(scale << "\n" << tableOf(result));
      REQUIRE(result.isUsable());
      const Estimate& found = find(result, "torque of all motors over the command");
      CHECK(found.isSeen);
      CHECK(found.value == Approx(scale).epsilon(0.03));
      CHECK(found.high - found.low < 0.06);
      CHECK(scale > found.low - 0.01);
      CHECK(scale < found.high + 0.01);
      CHECK(find(result, "platform.mass").value == Approx(device.value.at("platform.mass") / scale).epsilon(0.03));
    }
}

TEST_CASE("weights of recordings that cannot be used are refused", "[identify]") {
  const test::BlindDevice device = test::makeBlindDevice(test::BlindKind::cartesian3, 3);
  std::vector<RecordedMotion> motions = motionsOf(test::recordBlind(device, 5.0, 3), 1e-3, 3);
  motions.push_back(motions[0]);
  const auto refuse = [&](double first, double second, const char* problem) {
    motions[0].weight = first;
    motions[1].weight = second;
    CHECK_THROWS_WITH(identifyDevice(motions, device.file), Catch::Contains(problem));
  };
  refuse(0.1, 0.1, "one without it is needed");
  refuse(0.1, 0.2, "different weights");
  refuse(0.0, -0.1, "the attached weight is -0.1 kg");
}

TEST_CASE("an identification has the same bits with any number of threads", "[identify]") {
  const test::BlindDevice device = test::makeBlindDevice(test::BlindKind::cartesian3, 3);
  const std::vector<RecordedMotion> motions = motionsOf(test::recordBlind(device, 8.0, 3), 1e-3, 3);
  IdentifyOptions options;
  const auto resultOf = [&](int threads) {
    options.threads = threads;
    return identifyDevice(motions, device.file, options);
  };
  const Identification one = resultOf(1), three = resultOf(3);
  REQUIRE(one.estimates.size() == three.estimates.size());
  for (std::size_t i = 0; i < one.estimates.size(); ++i) {
    CHECK(one.estimates[i].value == three.estimates[i].value);
    CHECK(one.estimates[i].low == three.estimates[i].low);
  }
  const std::vector<RecordedMotion> brief = motionsOf(test::recordBlind(device, 5.0, 3), 1e-3, 3);
  CHECK_THROWS_WITH(identifyDevice(brief, device.file), Catch::Contains("record longer"));  // no data for the test
}

TEST_CASE("every estimated number has a place in the device file, or is a comment", "[identify]") {
  for (const char* name : {"tau-nominal.toml", "tau-detailed.toml", "delta.toml", "cartesian-3.toml",
                           "cartesian-6.toml", "omega-6.toml", "stylus.toml"}) {
    const std::string file = readFile(test::deviceFile(name));
    Identification result;
    result.device = parseDevice(file, name);
    identify::DeviceModel model = identify::modelOf(result.device);
    for (const identify::Unknown& unknown : identify::unknownsOf(model)) {
      const double value = unknown.value(model);
      result.estimates.push_back({unknown.key, unknown.unit, value, value, value, value, unknown.isInFile});
    }
    INFO(name);
    std::string text;
    REQUIRE_NOTHROW(text = identifiedText(file, result));
    for (const Estimate& e : result.estimates) CHECK(text.find("#   " + e.key) != std::string::npos);
  }
}

TEST_CASE("a Cartesian device with motors of rotation gets no friction in newtons", "[identify]") {
  const std::string file = readFile(test::deviceFile("cartesian-6.toml"));
  Identification result;
  result.device = parseDevice(file, "file");
  imperfectionsOf(result.device).currentBandwidth = 500.0;
  const std::string text = identifiedText(file, result);
  CHECK(imperfectionsOf(parseDevice(text, "identified")).currentBandwidth == 500.0);
  CHECK(text.find("coulomb_friction") == std::string::npos);
}

TEST_CASE("what position control has learnt becomes a device file", "[identify]") {
  PositionControlState learnt;
  learnt.mass = 1.2;
  learnt.deviation = 0.05;
  learnt.cable = 0.8;
  learnt.cableDeviation = 0.1;
  learnt.delayHigh = 2;
  for (const char* name : {"tau-nominal.toml", "tau-detailed.toml", "delta.toml", "cartesian-3.toml",
                           "cartesian-6.toml", "stylus.toml", "touch.toml"})
    for (const double cable : {0.0, 1000.0}) {
      INFO(name << ", cables of " << cable << " N m/rad or N/m");
      std::string text = readFile(test::deviceFile(name));
      const auto device = parseDevice(text, name);
      const auto* cartesian = std::get_if<CartesianParameters>(&device);
      const bool needsRotor = cartesian != nullptr;
      if (cable > 0.0 && needsRotor && (cartesian->axes == 6 || !cartesian->massTable.isEmpty())) continue;
      text = withValue(text, "imperfections.cable_stiffness", formatNumber(cable));
      text = withValue(text, "imperfections.cable_damping", "0");
      if (cable == 0.0) text = withValue(text, "imperfections.backlash", "0");
      if (cable > 0.0 && needsRotor) text = withValue(text, "rotor_mass", "0.01");
      const DeviceParameters before = parseDevice(text, name), after = parseDevice(learntText(text, learnt), "learnt");
      CHECK(imperfectionsOf(after).cableStiffness == Approx(0.8 * cable));
      const std::shared_ptr<const Mechanism> old = makeMechanism(before), now = makeMechanism(after);
      const double rotor = old->limits().drive.rotorInertia;  // 0 in a rigid transmission
      const auto rotors = rotor * Eigen::MatrixXd::Identity(old->joints(), old->joints());
      const Eigen::MatrixXd wanted = rotors + 1.2 * (Eigen::MatrixXd(old->home().inertia) - rotors);
      CHECK((Eigen::MatrixXd(now->home().inertia) - wanted).norm() < 1e-5 * wanted.norm());  // six digits are written
    }
  const std::string text = learntText(readFile(test::deviceFile("tau-detailed.toml")), learnt);
  CHECK(text.find("#   masses: 1.200 times the file's (95 %: 1.088 to 1.324)\n") != std::string::npos);
  CHECK(text.find("#   delay: 0..2 ticks\n") != std::string::npos);
  CHECK_THROWS_AS(learntText("name = 1\n", learnt), ConfigurationError);
}

TEST_CASE("wrong wiring and wrong units get a diagnosis in words", "[identify]") {
  const test::BlindDevice device = test::makeBlindDevice(test::BlindKind::cartesian3, 2);
  const std::vector<RecordedTick> right = test::recordBlind(device, 8.0, 3);
  const auto problemOf = [&](const auto& change) {
    std::vector<RecordedTick> ticks = right;
    for (RecordedTick& tick : ticks) change(tick);
    const Identification result = identifyFrom(ticks, device);
    REQUIRE_FALSE(result.isUsable());
    CHECK_THROWS_AS(identifiedText("", result), Error);
    return result.problems[0];
  };
  CHECK(problemOf([](RecordedTick& t) { t.command[1] *= -1.0; }).find("axis y follows minus the command of axis y") !=
        std::string::npos);
  CHECK(problemOf([](RecordedTick& t) {
          std::swap(t.command[0], t.command[2]);
        }).find("axis x follows the command of axis z; axis z follows the command of axis x") != std::string::npos);
  CHECK(problemOf([](RecordedTick& t) { t.measurement.q *= 1000.0; }).find("check units") != std::string::npos);
  CHECK(problemOf([](RecordedTick& t) { t.command *= 1000.0; }).find("check the units") != std::string::npos);
}

TEST_CASE("lost samples, a saturating motor and a hand get a right result or a diagnosis", "[identify]") {
  test::BlindDevice device = test::makeBlindDevice(test::BlindKind::cartesian3, 5);
  const double mass = device.value.at("platform.mass");
  const auto isRight = [&](const Identification& result) {
    return result.delay.low == device.delay.low && std::abs(find(result, "platform.mass").value / mass - 1.0) < 0.03;
  };
  device.lost = 0.05;
  const Identification lost = identifyFrom(test::recordBlind(device, 8.0, 3), device);
  REQUIRE(lost.isUsable());
  CHECK(isRight(lost));
  CHECK(lost.lostSamples == Approx(0.05).margin(0.01));  // 3 deviations of 8000 ticks
  device.lost = 0.0;

  std::vector<RecordedTick> ticks = test::recordBlind(device, 8.0, 3);
  double largest = 0.0;
  for (const RecordedTick& tick : ticks) largest = std::max(largest, std::abs(tick.command[0]));
  device.saturation = 0.45 * largest;
  const Identification saturated = identifyFrom(test::recordBlind(device, 8.0, 3), device);
  REQUIRE_FALSE(saturated.isUsable());
  CHECK(saturated.problems[0].find("motor of axis x saturates") != std::string::npos);
  device.saturation = 1e9;

  const auto hand = [](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    const Vec3 at(0.01 * std::sin(3.0 * time), 0.01 * std::sin(4.1 * time), 0.01 * std::sin(2.3 * time));
    wrench.head<3>() = 150.0 * (at - pose.position) - 4.0 * twist.head<3>();
    return wrench;
  };
  const ExternalWrench load(hand);
  const Identification held = identifyFrom(test::recordBlind(device, 8.0, 3, &load), device);
  CHECK((!held.isUsable() || isRight(held)));
}

}  // namespace enamel::test_identify
