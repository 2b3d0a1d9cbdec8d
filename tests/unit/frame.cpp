// The rows and responses of a frame, compared with the mechanism's own numbers, and without motors on some joints.
#include "enamel/render/frame.hpp"

#include <Eigen/Cholesky>

#include "enamel/device/cartesian/mechanism.hpp"
#include "support/catch.hpp"
#include "support/mechanisms.hpp"
#include "support/pushes.hpp"

namespace enamel::test_frame {

namespace {

// Return a frame at a random pose with `count` random contacts near the TCP.
TickFrame randomFrame(const test::Shipped& shipped, const Mechanism& mechanism, test::Random& random, int count) {
  TickFrame frame;
  frame.time = 1.0;
  frame.maxTorque = mechanism.limits().effort;
  REQUIRE(mechanism.reach(shipped.pose(random), Vec6::Zero(), true, frame.kinematics) == Status::ok);
  frame.contacts.count = count;
  for (int i = 0; i < count; ++i) {
    Contact& c = frame.contacts.contacts[i];
    c.normal = random.vector(1.0).normalized();
    c.point = frame.kinematics.pose.position + random.vector(0.02);
    c.material.friction = c.material.slidingFriction = i % 2 == 0 ? 0.3 : 0.0;
  }
  return frame;
}

JointVector vectorOf(const JointRow& row, Eigen::Index n) { return Eigen::Map<const JointVector>(row.data(), n); }

}  // namespace

TEST_CASE("rows are J^T of the force, responses M^-1 of it, masses those of effectiveMass()", "[frame]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    const auto mechanism = shipped.mechanism();
    test::Random random(4101);
    INFO(shipped.file << ", seed 4101");
    for (int i = 0; i < 50; ++i) {
      TickFrame frame = randomFrame(shipped, *mechanism, random, 1 + i % kMaxContacts);
      REQUIRE(fillContactRows(frame) == Status::ok);
      REQUIRE(frame.rows.count == frame.contacts.count);
      const Kinematics& k = frame.kinematics;
      const Eigen::LLT<Eigen::MatrixXd> inertia(k.inertia);
      for (int c = 0; c < frame.rows.count; ++c) {
        const Contact& contact = frame.contacts.contacts[c];
        const ContactRow& row = frame.rows.row[c];
        const auto check = [&](const Vec3& direction, const JointRow& torque, const JointRow& response) {
          Vec6 force;
          force << direction, (contact.point - k.pose.position).cross(direction);
          const JointVector expected = k.jacobian.transpose() * force, answer = inertia.solve(expected);
          // Two orders of a sum of six products.
          CHECK((vectorOf(torque, k.q.size()) - expected).norm() <= 1e-14 * (1.0 + expected.norm()));
          CHECK((vectorOf(response, k.q.size()) - answer).norm() <= 1e-11 * (1.0 + answer.norm()));
        };
        check(contact.normal, row.normal, row.response);
        CHECK(row.mass == Approx(effectiveMass(k, contact.point, contact.normal)).epsilon(1e-12));
        if (contact.material.friction == 0.0) {
          CHECK(row.axes.isZero(0.0));
          continue;
        }
        CHECK(isRotation(row.axes));
        CHECK(row.axes.col(2).isApprox(contact.normal, 1e-12));
        for (int t = 0; t < 2; ++t) check(row.axes.col(t), row.tangent[t], row.tangentResponse[t]);
      }
    }
  }
}

TEST_CASE("a joint without a motor takes part in rows, not in responses", "[frame]") {
  const CartesianMechanism stylus(loadCartesian(test::deviceFile("stylus.toml")));
  TickFrame frame = test::frameAt(stylus, Pose{}, 1.0);
  Contact& contact = frame.contacts.contacts[0];
  contact.point = Vec3(0.03, 0.0, 0.0);
  contact.normal = Vec3::UnitZ();
  REQUIRE(fillContactRows(frame) == Status::ok);
  const ContactRow& row = frame.rows.row[0];
  CHECK(row.normal[2] == 1.0);
  CHECK(row.normal[4] == Approx(-0.03).epsilon(1e-12));                      // moment about y
  CHECK(row.response[4] == 0.0);                                             // no motor can give it
  CHECK(row.mass == Approx(frame.kinematics.inertia(2, 2)).epsilon(1e-12));  // mass of everything that the motors move
}

TEST_CASE("a frame whose inertia is missing or not positive definite has no rows", "[frame]") {
  const TauMechanism device(test::nominal());
  const TickFrame good = test::frameAt(device, Pose{}, 1.0);
  const auto refuses = [&good](const auto& damage) {
    TickFrame bad = good;
    damage(bad);
    return fillContactRows(bad) == Status::outOfRange && bad.rows.count == -1;
  };
  CHECK(refuses([](TickFrame& f) { f.kinematics.inertia.resize(0, 0); }));
  CHECK(refuses([](TickFrame& f) { f.kinematics.inertia *= -1.0; }));
  CHECK(refuses([](TickFrame& f) { f.kinematics.inertia(0, 0) = std::nan(""); }));
  CHECK(refuses([](TickFrame& f) { f.contacts.count = kMaxContacts + 1; }));
  CHECK(refuses([](TickFrame& f) { f.contacts.count = -1; }));
  CHECK(refuses([](TickFrame& f) { f.maxTorque.resize(3); }));
}

}  // namespace enamel::test_frame
