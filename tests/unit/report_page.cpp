// Reports in a real browser: figures are drawn, the mouse shows values, and the data are those of the files.
#include <filesystem>
#include <regex>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"
#include "support/skip.hpp"

namespace enamel::test_report_page {

namespace {

// Collects errors from the beginning of the page.
const char* const kCollector = R"(<script>
self.problems = [];
addEventListener('error', event => problems.push(event.message));
addEventListener('unhandledrejection', event => problems.push(String(event.reason)));
for (const kind of ['error', 'warn']) console[kind] = (...said) => problems.push(said.join(' '));
</script>)";

// Moves the mouse over figures, drags over a plot, and follows the links to data.
const char* const kProbe = R"(<script>//<![CDATA[
(() => {
const results = {hovers: {}, data: {}, figures: {}};
const tip = () => document.querySelector('.tooltip').style.display === 'block' ? document.querySelector('.tooltip').textContent : '';
function act(type, element, share) {
  const box = element.getBoundingClientRect();
  element.dispatchEvent(new MouseEvent(type, {bubbles: true, cancelable: true, view: self, clientX: box.left + share * box.width, clientY: box.top + box.height / 2}));
}
const settled = () => new Promise(resolve => setTimeout(resolve, 50));
async function probe() {
  while (!document.body.dataset.ready && !document.body.dataset.error) await settled();
  for (const plot of document.querySelectorAll('.plot')) {
    results.figures[plot.id] = plot.querySelectorAll('svg path, svg line').length;
    const sheet = plot.querySelector('[class*="sheet1"] path') || plot.querySelector('[class*="sheet0"] path');
    const cell = [...plot.querySelectorAll('.mark-rect path, .mark-symbol path')].find(path => path.__data__ && path.__data__.tooltip && !path.__data__.tooltip.panel);
    for (const [name, element] of [['sheet', sheet], ['cell', cell]]) {
      if (!element) continue;
      act('mousemove', element, 0.5);
      results.hovers[plot.id + ' ' + name] = tip();
      act('mouseout', element, 0.5);
    }
    if (!sheet || !plot.id.startsWith('fig08')) continue;
    act('mousedown', sheet, 0.25);
    act('mousemove', sheet, 0.75);
    act('mouseup', sheet, 0.75);
    await settled();
    act('mousemove', sheet, 0);
    results.zoomed = tip();
    act('mouseout', sheet, 0);
  }
  for (const link of document.querySelectorAll('a[download]')) results.data[link.download] = await (await fetch(link.href)).text();
  results.exports = document.querySelectorAll('.exports button').length;
  results.wide = document.documentElement.scrollWidth - innerWidth;
  results.problems = problems;
  document.body.dataset.probe = btoa(unescape(encodeURIComponent(JSON.stringify(results))));
}
probe().catch(error => { document.body.dataset.probe = btoa(JSON.stringify({problems: [String(error)]})); });
})();
//]]></script></body>)";

std::string decoded(const std::string& base64) {
  std::string bytes;
  unsigned word = 0;
  int bits = 0;
  for (const char c : base64) {
    const unsigned digit = c >= 'A' && c <= 'Z'   ? static_cast<unsigned>(c - 'A')
                           : c >= 'a' && c <= 'z' ? static_cast<unsigned>(c - 'a' + 26)
                           : c >= '0' && c <= '9' ? static_cast<unsigned>(c - '0' + 52)
                           : c == '+'             ? 62u
                                                  : 63u;
    if (c == '=') break;
    word = word << 6 | digit;
    bits += 6;
    if (bits >= 8) bytes += static_cast<char>(word >> (bits -= 8) & 255u);
  }
  return bytes;
}

// Open a copy of a page with the probe and return what it has seen.
nlohmann::json probed(const test::TemporaryFolder& folder, const std::string& page) {
  std::string text = test::readFile(page);
  text.insert(text.find("<body>") + 6, kCollector);
  text.replace(text.rfind("</body>"), 7, kProbe);
  const std::string copy = folder / "probe.html";
  test::writeFile(copy, text);
  const auto result = test::runCommand(
      "timeout 600 chromium --headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader "
      "--user-data-dir='" +
      (folder / "profile") +
      "' --window-size=1280,720 --virtual-time-budget=20000 --dump-dom "
      "'file://" +
      copy + "' 2>/dev/null");
  REQUIRE(result.status == 0);
  const std::size_t at = result.output.find("data-probe=\"");
  REQUIRE(at != std::string::npos);
  return test::parseJson(decoded(result.output.substr(at + 12, result.output.find('"', at + 12) - at - 12)));
}

// Return the data of a figure.
nlohmann::json figureOf(const std::string& page, const std::string& name) {
  const std::string head = "id=\"" + name + "-data\">";
  const std::size_t at = page.find(head);
  REQUIRE(at != std::string::npos);
  return test::parseJson(page.substr(at + head.size(), page.find("</script>", at) - at - head.size()));
}

double numberAfter(const std::string& text, const std::string& name) {
  std::string rest = text.substr(text.find(name) + name.size());
  return std::stod(std::regex_replace(rest, std::regex("−"), "-"));
}

}  // namespace

TEST_CASE("a browser draws the study: no error, values under the mouse, data as in points.csv", "[report_page]") {
  const test::TemporaryFolder folder;
  const auto study =
      test::run("study --no-convergence --renderers position-control,impedance --grid 2 --runs 3 --output '" +
                (folder / "out") + "'");
  INFO(study.output);
  REQUIRE(study.status == 0);
  const std::string page = test::readFile(folder / "out/report.html");
  if (page.find("built without Vega") != std::string::npos) return test::skipTest("Vega is not installed");
  if (std::system("command -v chromium > /dev/null 2>&1") != 0) return test::skipTest("chromium is not installed");
  const nlohmann::json seen = probed(folder, folder / "out/report.html");
  CHECK(seen.at("problems") == nlohmann::json::array());
  CHECK(seen.at("data").at("points.csv").get<std::string>() == test::readFile(folder / "out/points.csv"));
  REQUIRE(seen.at("figures").size() == 8);
  CHECK(seen.at("exports") == 16);  // SVG and PNG of each
  CHECK(seen.at("wide").get<int>() <= 0);
  for (const auto& [name, shapes] : seen.at("figures").items()) {
    INFO(name);
    CHECK(shapes.get<int>() > 10);
  }
  // A cell of the map shows the first point's mean; a response shows the position at the middle of its time.
  const std::string cell = seen.at("hovers").at("fig10-first-impact cell");
  const nlohmann::json map = figureOf(page, "fig10-first-impact");
  CHECK(cell == map.at("panels")[0].at("layers")[0].at("cells")[0].at("text"));
  CHECK_THAT(cell, test::ContainsSubstring("(-25, -25) mm: ") && test::ContainsSubstring("±"));
  const nlohmann::json response = figureOf(page, "fig08-response-1").at("panels")[1], line = response.at("layers")[0];
  const std::string shown = seen.at("hovers").at("fig08-response-1 sheet");
  INFO(shown);
  const double time = numberAfter(shown, "time (s): ");
  CHECK(time == Approx(1.95).margin(0.002));
  const auto tick = static_cast<std::size_t>(std::lround((time - line.at("x").at("from").get<double>()) / 1e-3));
  const double z = line.at("y")[tick];
  CHECK(numberAfter(shown, "position control: ") == Approx(z).margin(std::abs(z)));  // the line's value near this time
  // A drag from a quarter to three quarters shows that part: it begins at 0.9 s + 2.1 s / 4.
  CHECK(numberAfter(seen.at("zoomed"), "time (s): ") == Approx(1.425).margin(0.01));
}

TEST_CASE("a browser draws the comparison: no error, intervals and boxes under the mouse, data as in its files",
          "[report_page]") {
  const test::TemporaryFolder folder;
  const auto compared = test::run("compare --device '" + test::deviceFile("tau-nominal.toml") +
                                  "' --plants closed-form --delays none,constant:1 --grid 1 --runs 4 --scenario 1 "
                                  "--tasks push,release --renderers position-control,impedance --output '" +
                                  (folder / "out") + "'");
  INFO(compared.output);
  REQUIRE(compared.status == 0);
  const std::string page = test::readFile(folder / "out/compare.html");
  if (page.find("built without Vega") != std::string::npos) return test::skipTest("Vega is not installed");
  if (std::system("command -v chromium > /dev/null 2>&1") != 0) return test::skipTest("chromium is not installed");
  const nlohmann::json seen = probed(folder, folder / "out/compare.html");
  CHECK(seen.at("problems") == nlohmann::json::array());
  for (const char* name : {"compare.csv", "tasks.csv"})
    CHECK(seen.at("data").at(name).get<std::string>() == test::readFile(folder / (std::string("out/") + name)));
  CHECK_THAT(seen.at("hovers").at("pairs-closed-form cell").get<std::string>(),
             test::ContainsSubstring("impedance, no delay: ") && test::ContainsSubstring(" times, better"));
  CHECK_THAT(seen.at("hovers").at("stiffness-closed-form cell").get<std::string>(),
             test::ContainsSubstring("position control, no delay: median "));
}

}  // namespace enamel::test_report_page
