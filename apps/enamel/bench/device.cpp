#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "bench/assembled_dynamics.hpp"
#include "bench/measurement.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "enamel/device/tau/mechanism.hpp"

namespace enamel::bench {
namespace {

constexpr int kSamples = 1024;  // a power of two: inputs are picked with a mask

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

// 1 kHz samples of a closed path through the workspace at up to 0.18 m/s and 1 rad/s.
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

}  // namespace

std::vector<Measurement> measureDevice(double scale) {
  const TauParameters device = nominalDevice();
  const TauModel model = makeModel(device);
  const std::vector<Sample> samples = randomSamples(model), path = pathSamples(model);
  const int batches = std::max(20, static_cast<int>(400 * scale)), calls = kSamples;
  const auto pick = [](const std::vector<Sample>& from, int i) -> const Sample& { return from[i & (kSamples - 1)]; };
  std::vector<Measurement> rows;
  const auto add = [&rows](const char* name, const Timing& t, double error, const char* errorOf, double goal_us,
                           double reference_us = std::numeric_limits<double>::quiet_NaN()) {
    Measurement row;
    row.name = name;
    row.median_us = t.median_us;
    row.p99_us = t.p99_us;
    row.error = error;
    row.errorOf = errorOf;
    row.goal_us = goal_us;
    row.reference_us = reference_us;
    rows.push_back(std::move(row));
  };

  {
    TauConfiguration tracked = path[0].configuration;
    double error = 0.0;
    for (int i = 0; i < 2 * kSamples; ++i) {
      const Sample& s = pick(path, i);
      if (forwardKinematics(model, s.q, tracked).status != Status::ok) error = 1.0;
      error = std::max(error, poseError(tracked.pose, s.configuration.pose));
    }
    const Timing t = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) keep(forwardKinematics(model, pick(path, i).q, tracked));
    });
    add("forward kinematics, tick to tick", t, error, "pose, m (rotation x 40 mm)", 0.25);
  }
  {
    std::mt19937_64 random(7);
    std::vector<TauConfiguration> starts;
    double error = 0.0;
    for (const Sample& s : samples) {
      Pose start = s.configuration.pose;
      start.position += 0.005 * randomVector(random, 1.0).normalized();
      start.rotation =
          Eigen::AngleAxis<double>(3.0 * M_PI / 180.0, randomVector(random, 1.0).normalized()) * start.rotation;
      starts.push_back(sampleAt(model, start).configuration);
      TauConfiguration solved = starts.back();
      if (forwardKinematics(model, s.q, solved).status != Status::ok) error = 1.0;
      error = std::max(error, poseError(solved.pose, s.configuration.pose));
    }
    const Timing t = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) {
        TauConfiguration c = starts[i & (kSamples - 1)];
        keep(forwardKinematics(model, pick(samples, i).q, c));
      }
    });
    add("forward kinematics, from 5 mm and 3 deg", t, error, "pose, m (rotation x 40 mm)", 0.25);
  }
  {
    double error = 0.0;
    for (const Sample& s : samples) {
      TauConfiguration c;
      if (forwardKinematicsFromHome(model, s.q, c).status != Status::ok) error = 1.0;
      error = std::max(error, poseError(c.pose, s.configuration.pose));
    }
    const Timing t = timeCalls(batches / 4, calls, [&](int first, int count) {
      TauConfiguration c;
      for (int i = first; i < first + count; ++i) keep(forwardKinematicsFromHome(model, pick(samples, i).q, c));
    });
    add("forward kinematics, cold from home", t, error, "pose, m (rotation x 40 mm)",
        std::numeric_limits<double>::quiet_NaN());
  }
  {
    double error = 0.0;
    for (const Sample& s : samples) {
      const Mat6 inverse = inverseJacobian(model, s.configuration);
      error = std::max(error, relativeError(inverse * s.twist, s.rates));
    }
    const Timing t = timeCalls(batches, calls, [&](int first, int count) {
      TauConfiguration c;
      for (int i = first; i < first + count; ++i) {
        keep(inverseKinematics(model, pick(samples, i).configuration.pose, c));
        keep(jointAngles(c));
        keep(inverseJacobian(model, c));
      }
    });
    add("inverse kinematics + inverse Jacobian", t, error, "rates, relative, against the twist map", 0.18);
  }
  {
    double error = 0.0;
    for (const Sample& s : samples) {
      using Long6 = Eigen::Matrix<long double, 6, 6>;
      const Long6 inverse = inverseJacobian(model, s.configuration).cast<long double>();
      const Mat6 reference = inverse.partialPivLu().inverse().cast<double>();
      error = std::max(error, relativeError(jacobian(model, s.configuration), reference));
    }
    const Timing t = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) keep(jacobian(model, pick(samples, i).configuration));
    });
    const Timing general = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i)
        keep(Mat6(inverseJacobian(model, pick(samples, i).configuration).partialPivLu().inverse()));
    });
    add("Jacobian", t, error, "relative, against an 80-bit inverse", 0.35, general.median_us);
  }
  {
    std::vector<TreeState> trees;
    double error = 0.0;
    for (const Sample& s : samples) {
      trees.push_back(treeState(device, s));
      const Vec6 reference = assembledForwardDynamics(device, trees.back(), s.torque, s.wrench).twist;
      error = std::max(error,
                       relativeError(forwardDynamics(model, s.configuration, s.twist, s.torque, s.wrench), reference));
    }
    const Timing assembled = timeCalls(batches / 8, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) {
        const Sample& s = pick(samples, i);
        keep(assembledForwardDynamics(device, trees[i & (kSamples - 1)], s.torque, s.wrench));
      }
    });
    const Timing fromPose = timeCalls(batches, calls, [&](int first, int count) {
      TauConfiguration c;
      for (int i = first; i < first + count; ++i) {
        const Sample& s = pick(samples, i);
        keep(inverseKinematics(model, s.configuration.pose, c));
        keep(forwardDynamics(model, c, s.twist, s.torque, s.wrench));
      }
    });
    add("forward dynamics from pose and twist", fromPose, error, "relative, against the assembled KKT system", 0.45,
        assembled.median_us);
    const Timing fromAngles = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) {
        const Sample& s = pick(path, i);
        const Sample& load = pick(samples, i);
        TauConfiguration c = pick(path, i + kSamples - 1).configuration;
        keep(forwardKinematics(model, s.q, c));
        const Vec6 twist = twistFromRates(model, c, load.rates);
        keep(jointAccelerations(model, c, twist, forwardDynamics(model, c, twist, load.torque, load.wrench)));
      }
    });
    add("forward dynamics from q and q' (with forward kinematics)", fromAngles, error,
        "relative, against the assembled KKT system", 0.75, assembled.median_us);
  }
  {
    const TauMechanism mechanism(device);
    std::vector<JointVector> q, rates;
    for (const Sample& s : path) {
      q.push_back(s.q);
      rates.push_back(jointRates(model, s.configuration, samples[q.size() - 1].twist));
    }
    const auto track = [&](int i, bool withInertia, Kinematics& k) {
      const auto at = static_cast<std::size_t>(i & (kSamples - 1));
      return mechanism.track(q[at], rates[at], withInertia, k);
    };
    const auto reach = [&](int i, Kinematics& k) {
      const auto at = static_cast<std::size_t>(i & (kSamples - 1));
      return mechanism.reach(path[at].configuration.pose, samples[at].twist, true, k);
    };
    // Everything that a tick gets, each against another way to it: V = J q' against the twist that the rates came from,
    // gravity and inertia against the functions of a pose.
    const auto errorOf = [&](int i, const Kinematics& k) {
      const Sample& s = pick(path, i);
      double error = poseError(k.pose, s.configuration.pose);
      error = std::max(error, relativeError(k.twist, pick(samples, i).twist));
      error = std::max(error, relativeError(k.jacobian * k.rates, k.twist));
      error = std::max(error, relativeError(k.gravity, gravityTorque(model, s.configuration)));
      if (k.inertia.size() > 0) error = std::max(error, relativeError(k.inertia, massMatrix(model, s.configuration)));
      return error;
    };
    for (const bool withInertia : {false, true}) {
      Kinematics k = mechanism.home();
      double error = 0.0;
      for (int i = 0; i < 2 * kSamples; ++i)
        error = std::max(error, track(i, withInertia, k) == Status::ok ? errorOf(i, k) : 1.0);
      const Timing t = timeCalls(batches, calls, [&](int first, int count) {
        for (int i = first; i < first + count; ++i) keep(track(i, withInertia, k)), keep(k);
      });
      add(withInertia ? "track: pose, twist, Jacobian, gravity, inertia" : "track: pose, twist, Jacobian, gravity", t,
          error, "worst of them, relative or m", std::numeric_limits<double>::quiet_NaN());
    }
    Kinematics k;
    double error = 0.0;
    for (int i = 0; i < kSamples; ++i) error = std::max(error, reach(i, k) == Status::ok ? errorOf(i, k) : 1.0);
    const Timing t = timeCalls(batches, calls, [&](int first, int count) {
      for (int i = first; i < first + count; ++i) keep(reach(i, k)), keep(k);
    });
    add("reach: the same with inertia from pose and twist", t, error, "worst of them, relative or m",
        std::numeric_limits<double>::quiet_NaN());
  }
  return rows;
}

}  // namespace enamel::bench
