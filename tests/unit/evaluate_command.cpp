// `enamel evaluate` as a user runs it.

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"
#include "support/relative_error.hpp"

namespace enamel::test_evaluate_command {

using test::run;

namespace {

std::string evaluate(const std::string& device, const std::string& input, const std::string& output) {
  return "evaluate --device '" + device + "' --input '" + input + "' --output '" + output + "'";
}

}  // namespace

TEST_CASE("evaluate reproduces the reference rows, from poses and from joint angles", "[evaluate]") {
  const test::TemporaryFolder folder;
  const auto reference = test::referenceFile("tau-detailed.json");
  nlohmann::json input;
  for (const auto& row : reference.at("rows"))
    for (const bool fromPose : {true, false}) {
      nlohmann::json in = {
          {"qdot", row.at("qdot")}, {"torque", row.at("torque")}, {"tcp_wrench", row.at("tcp_wrench")}};
      if (fromPose) {
        in["position"] = row.at("position");
        in["euler_xyz"] = row.at("euler_xyz");
      } else {
        in["q"] = row.at("q");
      }
      input["rows"].push_back(in);
    }
  test::writeFile(folder / "rows.json", input.dump());
  const auto result = run(evaluate(test::deviceFile("tau-detailed.toml"), folder / "rows.json", folder / "out.json"));
  REQUIRE(result.status == 0);
  const auto output = test::parseJson(test::readFile(folder / "out.json"));
  REQUIRE(output.at("rows").size() == 2 * reference.at("rows").size());
  for (std::size_t i = 0; i < output.at("rows").size(); ++i) {
    const auto& out = output.at("rows")[i];
    const auto& expected = reference.at("rows")[i / 2];
    REQUIRE(!out.contains("status"));
    for (const char* key : {"q", "gravity_torque"})
      CHECK(test::relativeError(test::vectorFrom(out.at(key)), test::vectorFrom(expected.at(key))) < 1e-12);
    CHECK(test::relativeError(test::vectorFrom(out.at("elbow")), test::vectorFrom(expected.at("elbow"))) < 1e-12);
    for (const char* key : {"jacobian", "mass_matrix"})
      CHECK(test::relativeError(test::matrixFrom(out.at(key)), test::matrixFrom(expected.at(key))) < 1e-12);
    CHECK(test::relativeError(test::vectorFrom(out.at("qddot")), test::vectorFrom(expected.at("qddot"))) < 1e-10);
    CHECK((test::vectorFrom(out.at("position")) - test::vectorFrom(expected.at("position"))).norm() < 1e-12);
    CHECK((test::vectorFrom(out.at("euler_xyz")) - test::vectorFrom(expected.at("euler_xyz"))).norm() < 1e-11);
  }
}

TEST_CASE("evaluate: a bad row gets a status, the others are still evaluated", "[evaluate]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "rows.json", R"([
    {"position": [0.5, 0, 0], "euler_xyz": [0, 0, 0]},
    {"position": [0, 0, 0], "euler_xyz": [0, 0, 0]},
    {"q": [null, 0, 0, 0, 0, 0]},
    {"q": [9, 9, 9, 9, 9, 9]},
    {"q": [0, 0]},
    {"position": [0, 0, 0]},
    {},
    7,
    {"position": [0, 0, 0], "euler_xyz": [0, 0, 0], "qdot": [1, 2, 3], "torque": [0,0,0,0,0,0], "tcp_wrench": [0,0,0,0,0,0]}
  ])");
  const auto result = run(evaluate(test::deviceFile("tau-nominal.toml"), folder / "rows.json", folder / "out.json"));
  REQUIRE(result.status == 0);
  const auto rows = test::parseJson(test::readFile(folder / "out.json")).at("rows");
  REQUIRE(rows.size() == 9);
  CHECK(rows[0].at("status") == "the pose is unreachable");
  CHECK(!rows[1].contains("status"));
  CHECK(!rows[1].contains("qddot"));
  CHECK(rows[2].at("status") == "q[0] must be a finite number");
  CHECK(rows[3].contains("status"));
  CHECK(rows[4].at("status") == "q must be a list of 6 numbers");
  CHECK(rows[5].at("status") == "position and euler_xyz must be given together");
  CHECK(rows[6].at("status") == "position and euler_xyz, or q, are missing");
  CHECK(rows[7].at("status") == "must be an object");
  CHECK(rows[8].at("status") == "qdot must be a list of 6 numbers");
}

TEST_CASE("evaluate is for the TAU: another kind of device is named", "[evaluate]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "rows.json", "[]");
  test::writeFile(folder / "delta.toml", "kind = \"delta\"\n");
  const auto result = run(evaluate(folder / "delta.toml", folder / "rows.json", folder / "out.json"));
  CHECK(result.status == 1);
  CHECK(result.output.find("is \"delta\", must be \"tau\"") != std::string::npos);
  CHECK(!std::filesystem::exists(folder / "out.json"));
}

TEST_CASE("enamel: errors are one line and the status is not 0", "[evaluate]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "rows.json", "[]");
  test::writeFile(folder / "broken.json", "{");
  test::writeFile(folder / "broken.toml", "name = ");
  const std::string device = test::deviceFile("tau-nominal.toml");
  for (const std::string& arguments :
       {evaluate(folder / "none.toml", folder / "rows.json", folder / "o.json"),
        evaluate(folder / "broken.toml", folder / "rows.json", folder / "o.json"),
        evaluate(device, folder / "none.json", folder / "o.json"),
        evaluate(device, folder / "broken.json", folder / "o.json"),
        evaluate(device, folder / "rows.json", folder / "no/such/folder/o.json"), std::string("evaluate"),
        std::string("frobnicate"), std::string(""),
        std::string("bench --filter 'device nothing-like-this' --scale 0.01"), std::string("bench --scale 0")}) {
    const auto result = run(arguments);
    INFO(arguments << "\n" << result.output);
    CHECK(result.status != 0);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
    CHECK(result.output.rfind("enamel: ", 0) == 0);
  }
  for (const char* arguments : {"--help", "evaluate --help", "bench --help"}) {
    const auto result = run(arguments);
    CHECK(result.status == 0);
    CHECK(result.output.size() > 100);
  }
}

}  // namespace enamel::test_evaluate_command
