// Files of servos and studies.
#include <string>

#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/study/run_file.hpp"
#include "memory_file.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

void attackServo(std::string_view bytes) {
  try {
    const ServoFile servo = loadServo(MemoryFile(bytes).path());
    require(servo.gain.allFinite() && servo.gain.cols() == 3 * servo.gain.rows(), "gains are finite");
  } catch (const Error&) {
  }
}

void attackRuns(std::string_view bytes) {
  static const StudyPlan plan = [] {
    StudyPlan made;
    made.grid = 2;
    made.runs = 3;
    made.scenarios = {1};
    made.columns.push_back({"a", nullptr, {}});
    return made;
  }();
  try {
    for (const StudyResult& result : readRuns(plan, MemoryFile(bytes).path())) {
      const std::string line = runLine(plan, result) + '\n';
      require(bytes.find(line) != std::string_view::npos, "what was read is what is written");
    }
  } catch (const Error&) {
  }
}

const Registration kStudies[] = {{"servo", attackServo}, {"runs", attackRuns}};

}  // namespace

}  // namespace enamel::attack
