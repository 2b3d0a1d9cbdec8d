// Our plugins satisfy the contract; plugins that violate it are detected, each with its reason.
#include <map>

#include "enamel/plugin/host.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_conformance {

using test::ContainsSubstring;

namespace {

std::string good(const std::string& name) { return ENAMEL_PLUGINS "/enamel_" + name + ".so"; }
std::string bad(const std::string& name) { return ENAMEL_BAD_PLUGINS "/bad_" + name + ".so"; }

}  // namespace

TEST_CASE("our plugins keep the contract and export one symbol", "[plugin]") {
  for (const auto& [name, options] : {std::pair<std::string, std::string>{"position_control", ""},
                                      {"position_control", "--set delay=1 --set delay-high=3"},
                                      {"position_control", "--set mode=hold"},
                                      {"impedance", ""},
                                      {"template", ""}}) {
    INFO(name << " " << options);
    const auto result = test::run("check-plugin '" + good(name) + "' " + options);
    INFO(result.output);
    CHECK(result.status == 0);
    CHECK_THAT(result.output, ContainsSubstring("the plugin keeps the contract") && !ContainsSubstring("FAILED"));
    const auto symbols = test::runCommand("nm -D --defined-only '" + good(name) + "'");
    REQUIRE(symbols.status == 0);
    CHECK_THAT(symbols.output, ContainsSubstring(" T enamel_plugin\n"));
    CHECK(std::count(symbols.output.begin(), symbols.output.end(), '\n') == 1);
  }
}

TEST_CASE("bad plugins are caught with the right reason", "[plugin]") {
  std::map<std::string, std::string> reasons = {
      {"version", "has ABI version 4, this host loads 2 to 3"},
      {"size", "its EnamelTickInput has"},
      {"table", "a function of its table is missing"},
      {"symbol", "a_function_that_nobody_has"},
      {"throw", "an exception crossed the boundary: thrown in a tick"},
      {"nan", "torque 4 is not finite"},
      {"limit", "torque 3 is 4 N m, the limit is 2 N m"},
      {"reset", "FAILED       repeats the first tick after reset"},
      {"counter", "differs"},
      {"late", "FAILED       repeats the first tick after reset"},
      {"activate", "activate() failed: bad configuration: no brain"},
      {"double", "a second activate() was accepted"},
      {"crash", "ended in a crash (Aborted)"},
  };
#ifndef ENAMEL_SANITIZED
  reasons["allocation"] = "allocations or releases in 2000 ticks";
#endif
  for (const auto& [name, reason] : reasons) {
    INFO(name);
    const auto result = test::run("check-plugin '" + bad(name) + "'");
    CHECK(result.status == 1);
    CHECK_THAT(result.output, ContainsSubstring(reason) && !ContainsSubstring("keeps the contract"));
  }
}

TEST_CASE("files that are no plugins are refused with what they are", "[plugin]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "text.so", "this is not a library, however long its text may be; it has no header at all\n");
  std::string other = test::readFile(good("template"));
  other[18] = other[18] == '\xb7' ? '\x3e' : '\xb7';  // e_machine: AArch64, or x86-64 on that machine
  other[19] = 0;
  test::writeFile(folder / "other.so", other);
  test::writeFile(folder / "cut.so", other.substr(0, 10));
  CHECK_THROWS_WITH(PluginLibrary::load(folder / "none.so"), ContainsSubstring("none.so: no such file"));
  CHECK_THROWS_WITH(PluginLibrary::load(folder / "text.so"),
                    ContainsSubstring("is not a shared library (its ELF header is missing)"));
  CHECK_THROWS_WITH(PluginLibrary::load(folder / "cut.so"),
                    ContainsSubstring("is not a shared library (its ELF header is missing)"));
  CHECK_THROWS_WITH(PluginLibrary::load(folder / "other.so"),
                    ContainsSubstring("is built for ") && ContainsSubstring("this host for"));
  const auto listed = test::run("plugins '" + (folder / ".") + "'");
  CHECK(listed.status == 0);
  CHECK(std::count(listed.output.begin(), listed.output.end(), '\n') == 3);
  CHECK_THAT(listed.output, ContainsSubstring("refused: ") && ContainsSubstring("text.so: is not a shared library"));
  CHECK_THAT(test::run("plugins '" ENAMEL_PLUGINS "'").output,
             ContainsSubstring("impedance 0.2.0") &&
                 ContainsSubstring("--set stiffness=6000  stiffness of the wall, N/m") &&
                 ContainsSubstring("template"));
  CHECK(test::run("plugins /no/such/folder").status == 1);
}

}  // namespace enamel::test_conformance
