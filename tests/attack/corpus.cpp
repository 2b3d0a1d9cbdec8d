// Runs every stored input of the fuzzer on its surface. An input that violates a promise ends the program.
#include <filesystem>

#include "attack/surfaces.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_corpus {

TEST_CASE("kept inputs break no promise", "[attack]") {
  const std::filesystem::path corpus = ENAMEL_SOURCE_DIR "/tests/attack/corpus";
  REQUIRE(!attack::surfaces().empty());
  for (const attack::Surface& surface : attack::surfaces()) {
    int inputs = 0;
    surface.attack("");
    for (const auto& entry : std::filesystem::directory_iterator(corpus / surface.name)) {
      INFO(entry.path());
      surface.attack(test::readFile(entry.path().string()));
      ++inputs;
    }
    INFO(surface.name);
    CHECK(inputs > 0);
  }
}

}  // namespace enamel::test_corpus
