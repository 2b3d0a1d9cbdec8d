#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "bench/assembled_dynamics.hpp"
#include "bench/long_matrix.hpp"
#include "bench/measurement.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "enamel/device/tau/mechanism.hpp"

namespace enamel::bench {
namespace {

constexpr int kSamples = 1024;  // a power of two, because a bit mask selects the inputs

struct Sample {
  TauConfiguration configuration;
  Vec6 q, rates, twist, torque, wrench;
};

Sample sampleAt(const TauModel& model, const Pose& pose) {
  Sample s;
  if (inverseKinematics(model, pose, s.configuration) != Status::ok)
    throw std::logic_error("pose outside the workspace");
  s.q = jointAngles(s.configuration);
  return s;
}

Vec3 randomVector(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

Pose randomPose(std::mt19937_64& random) {
  Pose pose;
  pose.position = randomVector(random, 0.025);
  pose.rotation = rotationFromEuler(randomVector(random, 10.0 * M_PI / 180.0));
  return pose;
}

std::vector<Sample> randomSamples(const TauModel& model) {
  std::mt19937_64 random(20260101);
  std::vector<Sample> samples;
  for (int i = 0; i < kSamples; ++i) {
    Sample s = sampleAt(model, randomPose(random));
    s.rates << randomVector(random, 3.0), randomVector(random, 3.0);
    s.twist = twistFromRates(model, s.configuration, s.rates);
    s.torque << randomVector(random, 2.0), randomVector(random, 2.0);
    s.wrench << randomVector(random, 10.0), randomVector(random, 0.3);
    samples.push_back(s);
  }
  return samples;
}

// Return samples at 1 kHz of a closed path through the workspace, at up to 0.18 m/s and 1 rad/s.
std::vector<Sample> pathSamples(const TauModel& model) {
  std::vector<Sample> samples;
  for (int i = 0; i < kSamples; ++i) {
    const double phase = 2.0 * M_PI * i / kSamples;
    Pose pose;
    pose.position = 0.02 * Vec3(std::sin(phase), std::cos(phase), std::sin(2.0 * phase));
    pose.rotation = rotationFromEuler(0.15 * Vec3(std::cos(phase), std::sin(phase), std::cos(2.0 * phase)));
    samples.push_back(sampleAt(model, pose));
  }
  return samples;
}

double poseError(const Pose& a, const Pose& b) {
  return std::max((a.position - b.position).norm(), 0.04 * angleBetween(a.rotation, b.rotation));
}

TreeState treeState(const TauParameters& device, const Sample& s) {
  TreeState state;
  const Vec3 elbow = elbowAngles(s.configuration);
  for (int i = 0; i < 3; ++i) state.angles[i] = {s.q[2 * i], s.q[2 * i + 1], elbow[i]};
  state.pose = s.configuration.pose;
  state.twist = s.twist;
  setRates(device, state);
  return state;
}

// The measurements and their common inputs.
struct DeviceBench {
  TauParameters device;
  TauModel model;
  std::vector<Sample> samples, path;
  int batches = 0;
  std::vector<Measurement> rows;

  void add(const char* name, const Timing& t, double error, const char* errorOf, double goal_us = kNoGoal,
           double reference_us = kNoGoal) {
    Measurement row;
    row.name = name;
    row.median_us = t.median_us;
    row.p99_us = t.p99_us;
    row.error = error;
    row.errorOf = errorOf;
    row.goal_us = goal_us;
    row.reference_us = reference_us;
    rows.push_back(std::move(row));
  }
};

const Sample& pick(const std::vector<Sample>& from, int i) { return from[i & (kSamples - 1)]; }

void addTracking(DeviceBench& bench) {
  TauConfiguration tracked = bench.path[0].configuration;
  double error = 0.0;
  for (int i = 0; i < 2 * kSamples; ++i) {
    const Sample& s = pick(bench.path, i);
    if (forwardKinematics(bench.model, s.q, tracked).status != Status::ok) error = 1.0;
    error = std::max(error, poseError(tracked.pose, s.configuration.pose));
  }
  const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) keep(forwardKinematics(bench.model, pick(bench.path, i).q, tracked));
  });
  bench.add("forward kinematics, tick to tick", t, error, "pose, m (rotation x 40 mm)", 0.25);
}

void addFromFar(DeviceBench& bench) {
  std::mt19937_64 random(7);
  std::vector<TauConfiguration> starts;
  double error = 0.0;
  for (const Sample& s : bench.samples) {
    Pose start = s.configuration.pose;
    start.position += 0.005 * randomVector(random, 1.0).normalized();
    start.rotation =
        Eigen::AngleAxis<double>(3.0 * M_PI / 180.0, randomVector(random, 1.0).normalized()) * start.rotation;
    starts.push_back(sampleAt(bench.model, start).configuration);
    TauConfiguration solved = starts.back();
    if (forwardKinematics(bench.model, s.q, solved).status != Status::ok) error = 1.0;
    error = std::max(error, poseError(solved.pose, s.configuration.pose));
  }
  const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) {
      TauConfiguration c = starts[i & (kSamples - 1)];
      keep(forwardKinematics(bench.model, pick(bench.samples, i).q, c));
    }
  });
  bench.add("forward kinematics, from 5 mm and 3 deg", t, error, "pose, m (rotation x 40 mm)", 0.25);
}

void addFromHome(DeviceBench& bench) {
  double error = 0.0;
  for (const Sample& s : bench.samples) {
    TauConfiguration c;
    if (forwardKinematicsFromHome(bench.model, s.q, c).status != Status::ok) error = 1.0;
    error = std::max(error, poseError(c.pose, s.configuration.pose));
  }
  const Timing t = timeCalls(bench.batches / 4, kSamples, [&](int first, int count) {
    TauConfiguration c;
    for (int i = first; i < first + count; ++i)
      keep(forwardKinematicsFromHome(bench.model, pick(bench.samples, i).q, c));
  });
  bench.add("forward kinematics, cold from home", t, error, "pose, m (rotation x 40 mm)");
}

void addInverse(DeviceBench& bench) {
  double error = 0.0;
  for (const Sample& s : bench.samples) {
    const Mat6 inverse = inverseJacobian(bench.model, s.configuration);
    error = std::max(error, relativeError(inverse * s.twist, s.rates));
  }
  const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    TauConfiguration c;
    for (int i = first; i < first + count; ++i) {
      keep(inverseKinematics(bench.model, pick(bench.samples, i).configuration.pose, c));
      keep(jointAngles(c));
      keep(inverseJacobian(bench.model, c));
    }
  });
  bench.add("inverse kinematics + inverse Jacobian", t, error, "rates, relative, against the twist map", 0.18);
}

void addJacobian(DeviceBench& bench) {
  double error = 0.0;
  for (const Sample& s : bench.samples) {
    const LongMatrix inverse = inverseJacobian(bench.model, s.configuration).cast<long double>();
    const Mat6 reference = solved(inverse, LongMatrix::Identity(6, 6)).cast<double>();
    error = std::max(error, relativeError(jacobian(bench.model, s.configuration), reference));
  }
  const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) keep(jacobian(bench.model, pick(bench.samples, i).configuration));
  });
  const Timing general = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i)
      keep(Mat6(inverseJacobian(bench.model, pick(bench.samples, i).configuration).partialPivLu().inverse()));
  });
  bench.add("Jacobian", t, error, "relative, against an 80-bit inverse", 0.35, general.median_us);
}

void addDynamics(DeviceBench& bench) {
  std::vector<TreeState> trees;
  double error = 0.0;
  for (const Sample& s : bench.samples) {
    trees.push_back(treeState(bench.device, s));
    const Vec6 reference = assembledForwardDynamics(bench.device, trees.back(), s.torque, s.wrench).twist;
    error = std::max(
        error, relativeError(forwardDynamics(bench.model, s.configuration, s.twist, s.torque, s.wrench), reference));
  }
  const Timing assembled = timeCalls(bench.batches / 8, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) {
      const Sample& s = pick(bench.samples, i);
      keep(assembledForwardDynamics(bench.device, trees[i & (kSamples - 1)], s.torque, s.wrench));
    }
  });
  const Timing fromPose = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    TauConfiguration c;
    for (int i = first; i < first + count; ++i) {
      const Sample& s = pick(bench.samples, i);
      keep(inverseKinematics(bench.model, s.configuration.pose, c));
      keep(forwardDynamics(bench.model, c, s.twist, s.torque, s.wrench));
    }
  });
  bench.add("forward dynamics from pose and twist", fromPose, error, "relative, against the assembled KKT system", 0.45,
            assembled.median_us);
  const Timing fromAngles = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) {
      const Sample& s = pick(bench.path, i);
      const Sample& load = pick(bench.samples, i);
      TauConfiguration c = pick(bench.path, i + kSamples - 1).configuration;
      keep(forwardKinematics(bench.model, s.q, c));
      const Vec6 twist = twistFromRates(bench.model, c, load.rates);
      keep(jointAccelerations(bench.model, c, twist, forwardDynamics(bench.model, c, twist, load.torque, load.wrench)));
    }
  });
  bench.add("forward dynamics from q and q' (with forward kinematics)", fromAngles, error,
            "relative, against the assembled KKT system", 0.75, assembled.median_us);
}

void addMechanism(DeviceBench& bench) {
  const TauMechanism mechanism(bench.device);
  std::vector<JointVector> q, rates;
  for (const Sample& s : bench.path) {
    q.push_back(s.q);
    rates.push_back(jointRates(bench.model, s.configuration, bench.samples[q.size() - 1].twist));
  }
  const auto track = [&](int i, bool withInertia, Kinematics& k) {
    const auto at = static_cast<std::size_t>(i & (kSamples - 1));
    return mechanism.track(q[at], rates[at], withInertia, k);
  };
  const auto reach = [&](int i, Kinematics& k) {
    const auto at = static_cast<std::size_t>(i & (kSamples - 1));
    return mechanism.reach(bench.path[at].configuration.pose, bench.samples[at].twist, true, k);
  };
  // Check everything that a tick receives against an independent computation. The reference for V = J q' is the twist
  // from which the rates were computed; for gravity and inertia, the functions of a pose.
  const auto errorOf = [&](int i, const Kinematics& k) {
    const Sample& s = pick(bench.path, i);
    double error = poseError(k.pose, s.configuration.pose);
    error = std::max(error, relativeError(k.twist, pick(bench.samples, i).twist));
    error = std::max(error, relativeError(k.jacobian * k.rates, k.twist));
    error = std::max(error, relativeError(k.gravity, gravityTorque(bench.model, s.configuration)));
    if (k.inertia.size() > 0)
      error = std::max(error, relativeError(k.inertia, massMatrix(bench.model, s.configuration)));
    return error;
  };
  for (const bool withInertia : {false, true}) {
    Kinematics k = mechanism.home();
    double error = 0.0;
    for (int i = 0; i < 2 * kSamples; ++i)
      error = std::max(error, track(i, withInertia, k) == Status::ok ? errorOf(i, k) : 1.0);
    const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) keep(track(i, withInertia, k)), keep(k);
    });
    bench.add(withInertia ? "track: pose, twist, Jacobian, gravity, inertia" : "track: pose, twist, Jacobian, gravity",
              t, error, "worst of them, relative or m");
  }
  Kinematics k;
  double error = 0.0;
  for (int i = 0; i < kSamples; ++i) error = std::max(error, reach(i, k) == Status::ok ? errorOf(i, k) : 1.0);
  const Timing t = timeCalls(bench.batches, kSamples, [&](int first, int count) {
    for (int i = first; i < first + count; ++i) keep(reach(i, k)), keep(k);
  });
  bench.add("reach: the same with inertia from pose and twist", t, error, "worst of them, relative or m");
}

}  // namespace

std::vector<Measurement> measureDevice(double scale) {
  DeviceBench bench;
  bench.device = nominalDevice();
  bench.model = makeModel(bench.device);
  bench.samples = randomSamples(bench.model);
  bench.path = pathSamples(bench.model);
  bench.batches = std::max(20, static_cast<int>(400 * scale));
  addTracking(bench);
  addFromFar(bench);
  addFromHome(bench);
  addInverse(bench);
  addJacobian(bench);
  addDynamics(bench);
  addMechanism(bench);
  return std::move(bench.rows);
}

}  // namespace enamel::bench
