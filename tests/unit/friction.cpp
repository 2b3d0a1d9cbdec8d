// Friction sticks below its limit, slides at it, and creates no energy.
#include "enamel/render/friction.hpp"

#include <algorithm>
#include <cmath>

#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_friction {

namespace {

constexpr double kPeriod = 1e-3;
constexpr TangentialGains kGains{20e3, 10.0};

Contact rough(double friction, double sliding) {
  Contact contact;
  contact.obstacle = contact.part = 0;
  contact.material.friction = friction;
  contact.material.slidingFriction = sliding;
  return contact;
}

// Return the servo's gains for a mass: poles at 0.7.
TangentialGains gainsOf(double mass) {
  constexpr double z = 0.7;
  return {(1.0 - z) * (1.0 - z) * mass / (kPeriod * kPeriod), 0.5 * (1.0 - z) * (3.0 + z) * mass / kPeriod};
}

}  // namespace

TEST_CASE("friction sticks below its limit and slides at it, against the motion", "[friction]") {
  FrictionMemory memory;
  const Contact contact = rough(0.5, 0.4);
  const auto pulled = [&](double way) {
    memory.begin();
    const Vec3 force = memory.force(contact, {{way, 0, 0}, Vec3::Zero(), Vec3::Zero()}, kGains, 2.0);
    memory.end();
    return force;
  };
  CHECK(pulled(30e-6).norm() == 0.0);               // new contact: it has no earlier position
  CHECK(pulled(40e-6).isApprox(Vec3(-0.8, 0, 0)));  // a spring
  CHECK(pulled(-80e-6).isApprox(Vec3(0.8, 0, 0)));  // in both directions
  CHECK(
      pulled(100e-6).isApprox(Vec3(-0.8, 0, 0), 1e-12));  // 60 um: 1.2 N would be above mu_s 2 N = 1 N: slides at 0.8 N
  CHECK(pulled(1e-3).isApprox(Vec3(-0.8, 0, 0)));         // further sliding
  CHECK(pulled(-10e-6).isApprox(Vec3(-0.6, 0, 0)));       // a spring again, from where it stopped
  // Lifted off for a tick: the memory is cleared.
  memory.begin();
  memory.end();
  CHECK(pulled(30e-6).norm() == 0.0);
}

TEST_CASE("a viscous surface slows a tool that slides, not one that sticks", "[friction]") {
  FrictionMemory memory;
  Contact contact = rough(0.5, 0.4);
  contact.material.viscosity = 2.0;
  const auto pulled = [&](double way) {
    memory.begin();
    const Vec3 force = memory.force(contact, {{way, 0, 0}, Vec3::Zero(), {0.1, 0, 0}}, {20e3, 0.0}, 2.0);
    memory.end();
    return force;
  };
  (void)pulled(0.0);
  CHECK(pulled(40e-6).isApprox(Vec3(-0.8, 0, 0)));       // spring only
  CHECK(pulled(1e-3).isApprox(Vec3(-0.8 - 0.2, 0, 0)));  // mu_d 2 N, and 2 N s/m at 0.1 m/s
}

// A force of 1 N on average that alternates between 0.1 and 1.9 N. Positions are counts of 4 um, and rates their
// differences. A mass must stay under 0.1 N and move under 0.3 N.
TEST_CASE("friction holds by the mean of a force that flickers", "[friction]") {
  const double mass = 0.25, count = 4e-6;
  const TangentialGains gains = gainsOf(mass);
  for (const double hand : {0.1, 0.3}) {
    FrictionMemory memory;
    double x = 0.0, v = 0.0, measured = 0.0;
    for (int i = 0; i < 1000; ++i) {
      const double last = measured;
      measured = count * std::round(x / count);
      const double way = measured - last, flickers = i % 2 == 0 ? 1.9 : 0.1;
      memory.begin();
      const Vec3 force =
          memory.force(rough(0.2, 0.2), {{way, 0, 0}, Vec3::Zero(), {way / kPeriod, 0, 0}}, gains, flickers);
      memory.end();
      REQUIRE(force.norm() <= 0.2 * 1.9 + 1e-12);
      const double acceleration = (hand + force.x() - 5.0 * v) / mass;
      x += kPeriod * v + 0.5 * kPeriod * kPeriod * acceleration;
      v += kPeriod * acceleration;
    }
    INFO(hand << " N: " << 1e6 * x << " um");
    CHECK((hand < 0.2 ? std::abs(x) < 20e-6 : x > 1e-3));
  }
}

// A light tool that hops: 3 N in one tick of three. While it is down, friction uses the present normal force. The mean
// friction must not exceed Coulomb's limit for the mean force.
TEST_CASE("friction outlasts hops, and is never more than its share", "[friction]") {
  for (const bool dragged : {false, true}) {
    FrictionMemory memory;
    double held = 0.0, pressed = 0.0, last = 0.0;
    for (int i = 0; i < 301; ++i) {
      const double normal = i % 3 == 0 ? 3.0 : 0.0, way = dragged ? 1e-3 : i == 1 ? 20e-6 : 0.0;
      memory.begin();
      last = memory.force(rough(0.2, 0.2), {{way, 0, 0}, Vec3::Zero(), Vec3::Zero()}, kGains, normal).norm();
      memory.end();
      held += last;
      pressed += normal;
      REQUIRE(held <= 0.2 * pressed + 1e-9);
    }
    INFO(held << " of " << 0.2 * pressed);
    CHECK(last == Approx(dragged ? 0.6 : 0.4));  // 20 um at a grip of 20 N/mm, more than the mean force would hold
    if (dragged) CHECK(held > 0.95 * 0.2 * pressed);
  }
  // Friction in excess of weak ticks is subtracted in strong ones.
  test::Random random(12);
  for (int path = 0; path < test::count(1000, 10000); ++path) {
    FrictionMemory memory;
    double held = 0.0, pressed = 0.0;
    for (int i = 0; i < 100; ++i) {
      const double normal = std::max(0.0, random.uniform(-3.0, 3.0));
      const Vec3 way = 1e-4 * Vec3(random.uniform(-1.0, 1.5), random.uniform(-1.0, 1.0), 0.0);
      memory.begin();
      held += memory.force(rough(0.5, 0.4), {way, Vec3::Zero(), way / kPeriod}, kGains, normal).norm();
      memory.end();
      pressed += normal;
      REQUIRE(held <= 0.5 * pressed + 1e-9);
    }
  }
}

TEST_CASE("friction lies in the surface, is forgotten with the contact, and knows its obstacle and part",
          "[friction]") {
  FrictionMemory memory;
  Contact first = rough(1.0, 1.0), second = first;
  first.normal = Vec3(0.6, 0.0, 0.8);
  second.part = 1;
  const SurfaceMotion slide{{10e-6, 20e-6, 30e-6}, Vec3::Zero(), Vec3::Zero()};
  for (int i = 0; i < 2; ++i) {
    memory.begin();
    memory.force(second, slide, kGains, 100.0);
    memory.force(first, slide, kGains, 100.0);
    memory.end();
  }
  memory.begin();
  const SurfaceMotion none{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const Vec3 a = memory.force(first, none, kGains, 100.0), b = memory.force(second, none, kGains, 100.0);
  // Only the second tick has moved an existing contact.
  const Vec3 along = slide.displacement - first.normal.dot(slide.displacement) * first.normal;
  CHECK(a.isApprox(-kGains.stiffness * along));
  CHECK(b.isApprox(-kGains.stiffness * Vec3(10e-6, 20e-6, 0.0)));
  memory.end();
  // Without normal force, friction or stiffness the force is zero, whatever the stretch and the speed.
  const auto next = [&](const Contact& contact, const TangentialGains& gains, double normalForce) {
    FrictionMemory copy = memory;
    copy.begin();
    return copy.force(contact, {slide.displacement, Vec3::Zero(), {0.1, 0.2, 0.0}}, gains, normalForce).norm();
  };
  CHECK(next(first, kGains, 1.0) > 0.1);
  CHECK(next(first, kGains, 0.0) == 0.0);
  Contact smooth = first;
  smooth.material.friction = 0.0;
  CHECK(next(smooth, kGains, 1.0) == 0.0);
  CHECK(next(first, {0.0, kGains.damping}, 1.0) == 0.0);
}

TEST_CASE("friction follows a contact by its key, and by its place where it has none", "[friction]") {
  // A point in a corner: two contacts of one part at one place, the deepest first. Their order changes.
  for (const bool keys : {true, false}) {
    FrictionMemory memory;
    Contact floor = rough(1.0, 1.0), side = floor;
    side.normal = Vec3::UnitX();
    if (keys) floor.key = 1, side.key = 2;
    const auto pulled = [&](Contact& a, Contact& b, const Vec3& way) {
      memory.begin();
      const SurfaceMotion slide{way, Vec3::Zero(), Vec3::Zero()};
      const Vec3 ofA = memory.force(a, slide, kGains, 100.0), ofB = memory.force(b, slide, kGains, 100.0);
      memory.end();
      return std::pair{ofA, ofB};
    };
    pulled(floor, side, Vec3::Zero());
    pulled(floor, side, {10e-6, 20e-6, 0.0});
    const auto [ofSide, ofFloor] = pulled(side, floor, Vec3::Zero());
    CHECK(ofFloor.isApprox(-kGains.stiffness * Vec3(10e-6, 20e-6, 0.0)) == keys);
    CHECK(ofSide.isApprox(-kGains.stiffness * Vec3(0.0, 20e-6, 0.0)));
    side.key *= 3;  // another contact at the same place
    const Vec3 first = pulled(side, floor, Vec3::Zero()).first;
    CHECK(first.isZero(0.0) == keys);
  }
}

TEST_CASE("friction falls from rest to sliding with the speed (Stribeck)", "[friction]") {
  Contact contact = rough(0.5, 0.2);
  contact.material.stribeck = 0.01;
  const auto sliding = [&](double speed) {  // at a constant speed, m/s, under 2 N
    FrictionMemory memory;
    Vec3 force;
    for (int i = 0; i < 200; ++i) {
      memory.begin();
      force = memory.force(contact, {{speed * kPeriod, 0, 0}, Vec3::Zero(), {speed, 0, 0}}, {1e6, 0.0}, 2.0);
      memory.end();
    }
    return -force.x() / 2.0;
  };
  for (const double speed : {1e-3, 5e-3, 0.01, 0.02, 0.1})
    CHECK(sliding(speed) == Approx(0.2 + 0.3 * std::exp(-(speed / 0.01) * (speed / 0.01))).epsilon(1e-9));
  contact.material.stribeck = 0.0;
  CHECK(sliding(1e-3) == Approx(0.2).epsilon(1e-9));
}

TEST_CASE("a mass on a spring sticks and slips where friction falls with the speed, and not above", "[friction]") {
  // m x'' = k (V t - x) + d (V - x') - F. Steady sliding at V is unstable if F falls faster with the speed than d. The
  // slope of F is -2 (mu_s - mu_k) N V / v_s^2 exp(-(V / v_s)^2).
  Contact contact = rough(0.5, 0.2);
  contact.material.stribeck = 0.01;
  constexpr double kMass = 0.2, kSpring = 2000.0, kDamper = 5.0, kNormal = 2.0;
  const auto slope = [&](double v) { return 2.0 * 0.3 * kNormal * v / 1e-4 * std::exp(-(v / 0.01) * (v / 0.01)); };
  REQUIRE(slope(0.007) > 5.0 * kDamper);
  REQUIRE(slope(0.04) < 0.1 * kDamper);
  const auto spread = [&](double pull) {  // of the speed, relative, after 1 s
    FrictionMemory memory;
    double x = 0.0, v = pull, last = 0.0, least = 1e9, most = -1e9;
    for (int i = 0; i < 20000; ++i) {  // ticks of 0.1 ms, so that the model of the surface is hardly sampled
      const double dt = 1e-4, t = dt * i;
      memory.begin();
      const Vec3 force = memory.force(contact, {{x - last, 0, 0}, Vec3::Zero(), {v, 0, 0}}, {2e5, 50.0}, kNormal);
      memory.end();
      last = x;
      v += dt * (kSpring * (pull * t - x) + kDamper * (pull - v) + force.x()) / kMass;
      x += dt * v;
      if (t > 1.0) least = std::min(least, v), most = std::max(most, v);
    }
    return (most - least) / pull;
  };
  CHECK(spread(0.007) > 0.5);
  CHECK(spread(0.04) < 0.02);
}

// A mass on a rough surface under a hand whose force changes at random. The model's mass is wrong by up to 30 %. The
// work of friction on the mass may exceed zero only by what one held tick can contribute. A hand that reverses inside a
// tick moves the mass along with a force that is not updated.
TEST_CASE("friction creates no energy on random paths", "[friction]") {
  test::Random random(11);
  const int paths = test::count(10000, 100000);
  double stuck = 0.0, slid = 0.0;
  for (int path = 0; path < paths; ++path) {
    const double mass = random.uniform(0.05, 0.55), friction = random.uniform(0.1, 1.0);
    const TangentialGains gains = gainsOf(mass * random.uniform(0.7, 1.3));
    const Contact contact = rough(friction, friction * random.uniform(0.5, 1.0));
    const double normal = random.uniform(1.0, 6.0), strength = random.uniform(0.0, 8.0),
                 beat = random.uniform(0.0, 3.0);
    FrictionMemory memory;
    Vec3 x = Vec3::Zero(), last = x, v = x, hand = x;
    double work = 0.0, largestTick = 0.0;
    bool created = false;
    for (int i = 0; i < 60; ++i) {
      if (i % 10 == 0) hand = strength * Vec3{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0};
      memory.begin();
      const double pressed = normal * (1.0 + 0.5 * std::sin(beat * i));
      const Vec3 force = memory.force(contact, {x - last, Vec3::Zero(), v}, gains, pressed);
      memory.end();
      last = x;
      const Vec3 acceleration = (hand + force) / mass;
      const Vec3 way = kPeriod * v + 0.5 * kPeriod * kPeriod * acceleration;
      x += way;
      v += kPeriod * acceleration;
      const double tick = force.dot(way);
      work += tick;
      largestTick = std::max(largestTick, tick);
      created = created || work > largestTick + 1e-12;
      (force.norm() < contact.material.slidingFriction * pressed * (1.0 - 1e-9) ? stuck : slid) += 1.0;
    }
    REQUIRE_FALSE(created);
  }
  CHECK(stuck > 5.0 * paths);  // both happened
  CHECK(slid > 5.0 * paths);
}

}  // namespace enamel::test_friction
