// Cost of a contact query in Python compared with C++: batches of 1000 poses of a sliding tool, alternating in one run.
#include <algorithm>
#include <chrono>
#include <sstream>
#include <vector>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_python {

namespace {

struct Cost {
  double time = 1e9;  // us per pose, best of 30 batches
  int contacts = 0;
};

Cost costOf(const std::string& path) {
  const SceneFile file = loadScene(path);
  Pose low;
  low.position = file.start;
  for (int i = 0; i < 100; ++i)  // move down until it is 0.1 mm inside
    low.position.z() -= std::min(1e-3, nearestContact(file.scene, file.tool, low, nullptr).gap + 0.1e-3);
  Cost cost;
  for (int batch = 0; batch < 30; ++batch) {
    const auto begin = std::chrono::steady_clock::now();
    ToolCache cache = makeToolCache(file.scene, file.tool);
    ContactSnapshot contacts;
    cost.contacts = 0;
    for (int i = 0; i < 1000; ++i) {
      Pose pose = low;
      pose.position.x() += i * 1e-6;
      if (findContacts(file.scene, file.tool, pose, 1e-3, &cache, contacts) != Status::ok) return {};
      cost.contacts += contacts.count;
    }
    const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - begin;
    cost.time = std::min(cost.time, passed.count() / 1000.0);
  }
  return cost;
}

}  // namespace

TEST_CASE("timing: contact queries from Python beside those from C++", "[python]") {
  const std::string scenes = ENAMEL_SOURCE_DIR "/data/scenes/";
  for (const char* name : {"flat-wall.toml", "molar.toml"}) {
    std::vector<double> beyond;
    double own = 1e9;
    for (int round = 0; round < 5; ++round) {
      const Cost cost = costOf(scenes + name);
      const auto there = test::runCommand(
          ENAMEL_PYTHON_COMMAND " " ENAMEL_SOURCE_DIR "/tests/python/contact_cost.py '" + scenes + name + "'");
      INFO(there.output);
      REQUIRE(there.status == 0);
      double time = 0.0;
      int contacts = 0;
      REQUIRE(std::istringstream(there.output) >> time >> contacts);
      CHECK(contacts == cost.contacts);  // both make the same queries
      CHECK(contacts >= 1000);
      own = std::min(own, cost.time);
      beyond.push_back(time - cost.time);
    }
    std::sort(beyond.begin(), beyond.end());
    WARN(name << ": " << own << " us a query in C++, in Python " << beyond[2] << " us more (median of 5 rounds, "
              << beyond.front() << " to " << beyond.back() << ")");
  }
}

}  // namespace enamel::test_python
