#include "enamel/core/status.hpp"

#include <set>
#include <string>

#include "support/catch.hpp"

namespace enamel::test_status {

TEST_CASE("every status has a text of its own", "[status]") {
  std::set<std::string> texts;
  for (int i = 0; i < kStatuses; ++i) texts.insert(toString(static_cast<Status>(i)));
  CHECK(texts.size() == kStatuses);
  CHECK(texts.count("unknown status") == 0);
  CHECK(std::string(toString(Status::ok)) == "ok");
  CHECK(std::string(toString(Status::stopped)) == "stopped by the guard");
  CHECK(std::string(toString(static_cast<Status>(kStatuses))) == "unknown status");
}

}  // namespace enamel::test_status
