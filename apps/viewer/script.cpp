#include "script.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel::viewer {
namespace {

constexpr double kLongest = 7200.0;  // s

class Line {
 public:
  Line(const std::string& text, const std::string& file, int number, const std::vector<std::string>& renderers)
      : file_(file), number_(number), renderers_(renderers) {
    std::istringstream stream(text.substr(0, text.find('#')));
    for (std::string word; stream >> word;) words_.push_back(word);
  }

  const std::string& file() const { return file_; }
  /// Return the available renderers; empty: the script is for a recording.
  const std::vector<std::string>& renderers() const { return renderers_; }

  bool empty() const { return next_ >= words_.size(); }

  [[noreturn]] void fail(const std::string& key, const std::string& problem) const {
    throw ConfigurationError(file_, number_, key, problem);
  }

  std::string word(const char* what) {
    if (empty()) fail(what, "is missing");
    return words_[next_++];
  }

  double number(const char* what, double low, double high) {
    const std::string text = word(what);
    double value = 0.0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value))
      fail(what, "is \"" + text + "\", must be a number");
    if (!(value >= low && value <= high)) {
      std::ostringstream range;
      range << "is " << text << ", must be in " << low << " to " << high;
      fail(what, range.str());
    }
    return value;
  }

  int integer(const char* what, int low, int high) {
    const double value = number(what, low, high);
    if (value != std::floor(value)) fail(what, "must be a whole number");
    return static_cast<int>(value);
  }

  bool accept(const char* keyword) {
    if (empty() || words_[next_] != keyword) return false;
    ++next_;
    return true;
  }

  void finish() const {
    if (!empty()) fail(words_[next_], "is not expected here");
  }

 private:
  const std::string& file_;
  int number_;
  const std::vector<std::string>& renderers_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

void parseHand(Line& line, ScriptStep& step) {
  for (int i = 0; i < 3; ++i) step.target[i] = line.number("hand", -1000.0, 1000.0);
  if (line.accept("over")) step.over = line.number("over", 0.0, kLongest);
}

void parseSpin(Line& line, ScriptStep& step) {
  step.number = line.accept("on") ? 1 : 0;
  if (step.number == 0 && !line.accept("off")) line.fail("spin", "must be on or off");
}

void parseView(Line& line, ScriptStep& step) {
  for (int i = 0; i < 3; ++i) step.view.focus[i] = line.number("view", -300.0, 300.0);
  step.view.azimuth = glm::radians(line.number("azimuth", -180.0, 180.0));
  step.view.elevation = glm::radians(line.number("elevation", -88.0, 88.0));
  step.view.distance = line.number("distance", kNearest, 2000.0);
}

void parseRenderer(Line& line, ScriptStep& step) {
  const char* const command = step.kind == ScriptStep::Kind::right ? "right" : "renderer";
  const std::vector<std::string>& renderers = line.renderers();
  const std::string name = line.word(command);
  const auto found = std::find(renderers.begin(), renderers.end(), name);
  if (found == renderers.end()) {
    std::string known;
    for (const std::string& one : renderers)
      known += (one == renderers.back() ? " or " : known.empty() ? "" : ", ") + one;
    line.fail(command, "is \"" + name + "\", must be " + known);
  }
  step.number = static_cast<int>(found - renderers.begin());
}

void parseSet(Line& line, ScriptStep& step) {
  step.name = line.word("set");
  const auto& rows = settingRows();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const SettingRow& r) { return step.name == r.name; });
  if (row == rows.end()) line.fail("set", "\"" + step.name + "\" is not a known setting");
  step.value = row->whole ? line.integer(row->name, static_cast<int>(row->low), static_cast<int>(row->high))
                          : line.number(row->name, row->low, row->high);
}

void parseScene(Line& line, ScriptStep& step) {
  const std::filesystem::path path = line.word("scene");
  step.name = path.is_absolute() ? path.string() : (std::filesystem::path(line.file()).parent_path() / path).string();
}

void parseSizeOf(Line& line, ScriptStep& step) {
  const std::string text = line.word("size");
  try {
    step.size = parseSize(text);
  } catch (const Error& error) {
    line.fail("size", error.what());
  }
}

// Parse a name that cannot leave the folder it is written to.
void parsePicture(Line& line, ScriptStep& step) {
  step.name = line.word("picture");
  for (const char c : step.name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_')
      line.fail("picture", "is \"" + step.name + "\", must have only letters, digits, - and _");
}

struct CommandRow {
  const char* name;
  ScriptStep::Kind kind;
  Source source;
  void (*parse)(Line& line, ScriptStep& step);
};
constexpr CommandRow kCommands[] = {
    {"hand", ScriptStep::Kind::hand, Source::live, parseHand},
    {"spin", ScriptStep::Kind::spin, Source::live, parseSpin},
    {"view", ScriptStep::Kind::view, Source::both, parseView},
    {"renderer", ScriptStep::Kind::renderer, Source::live, parseRenderer},
    {"right", ScriptStep::Kind::right, Source::live, parseRenderer},
    {"set", ScriptStep::Kind::set, Source::live, parseSet},
    {"scene", ScriptStep::Kind::scene, Source::live, parseScene},
    {"slow", ScriptStep::Kind::slowdown, Source::both,
     [](Line& line, ScriptStep& step) { step.number = line.integer("slow", 1, 1000); }},
    {"seek", ScriptStep::Kind::seek, Source::recording,
     [](Line& line, ScriptStep& step) { step.value = line.number("seek", 0.0, 1e9); }},
    {"size", ScriptStep::Kind::size, Source::both, parseSizeOf},
    {"frames", ScriptStep::Kind::frames, Source::both,
     [](Line& line, ScriptStep& step) { step.number = line.integer("frames", 0, 60); }},
    {"picture", ScriptStep::Kind::picture, Source::both, parsePicture},
    {"end", ScriptStep::Kind::end, Source::both, [](Line&, ScriptStep&) {}},
};

ScriptStep parseStep(Line& line) {
  ScriptStep step;
  step.time = line.number("time", 0.0, kLongest);
  const std::string command = line.word("command");
  const bool recording = line.renderers().empty();
  const auto check = [&](Source source) {
    if (source != Source::both && source != Source::timed && (source == Source::recording) != recording)
      line.fail(command, recording ? "is not available for a recording" : "is for recordings only: give --play");
  };
  if (const ActionRow* row = actionOfName(command); row != nullptr) {
    check(row->source);
    step.kind = ScriptStep::Kind::action;
    step.action = row->action;
  } else {
    const auto* found = std::find_if(std::begin(kCommands), std::end(kCommands),
                                     [&](const CommandRow& one) { return command == one.name; });
    if (found == std::end(kCommands)) line.fail(command, "is not a known command");
    check(found->source);
    step.kind = found->kind;
    found->parse(line, step);
  }
  line.finish();
  return step;
}

}  // namespace

const std::vector<SettingRow>& settingRows() {
  static const std::vector<SettingRow> rows{
      {"stiffness", 0.0, 1e5, false, [](Settings& s, double v) { s.spring.stiffness = v; }},         // N/m
      {"wall-damping", 0.0, 100.0, false, [](Settings& s, double v) { s.spring.damping = v; }},      // N s/m
      {"release", 0.0, 1.0, true, [](Settings& s, double v) { s.hold.release = v != 0.0; }},         // 0 or 1
      {"anti-windup", 0.0, 1.0, true, [](Settings& s, double v) { s.hold.antiWindup = v != 0.0; }},  // 0 or 1
      {"added-mass", 0.0, 1.0, false, [](Settings& s, double v) { s.extraMass = v; }},               // kg
      {"joint-friction", 0.0, 1.0, false, [](Settings& s, double v) { s.friction = v; }},            // N m s/rad
      {"tool-damping", 0.0, 100.0, false, [](Settings& s, double v) { s.toolDamping = v; }},         // N s/m
      {"tremor", 0.0, 10.0, false, [](Settings& s, double v) { s.noise = v; }},                      // N
      {"delay", 0.0, kMaxLoopDelay, true,
       [](Settings& s, double v) { s.delay.low = s.delay.high = static_cast<int>(v); }},  // ticks
      {"delay-low", 0.0, kMaxLoopDelay, true,
       [](Settings& s, double v) { s.delay.low = std::min(s.delay.high, static_cast<int>(v)); }},  // of a random delay
      {"encoders", 0.0, 1.0, true, [](Settings& s, double v) { s.encoders.quantised = v != 0.0; }},  // 0 or 1
      {"rates", 0.0, 2.0, true,  // 0 exact, 1 difference, 2 low pass
       [](Settings& s, double v) { s.encoders.rates = static_cast<RateSource>(static_cast<int>(v)); }},
  };
  return rows;
}

glm::ivec2 parseSize(const std::string& text) {
  glm::ivec2 size{0};
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.x);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.y);
    if (height.ec == std::errc() && height.ptr == end && size.x >= 160 && size.y >= 160 && size.x <= 8192 &&
        size.y <= 8192)
      return size;
  }
  throw Error("is \"" + text + "\", must be WIDTHxHEIGHT, each 160 to 8192 pixels");
}

std::vector<ScriptStep> parseScript(std::string_view text, const std::string& file,
                                    const std::vector<std::string>& renderers) {
  std::vector<ScriptStep> steps;
  std::istringstream stream{std::string(text)};
  int number = 0;
  for (std::string content; std::getline(stream, content);) {
    Line line(content, file, ++number, renderers);
    if (line.empty()) continue;
    if (!steps.empty() && steps.back().kind == ScriptStep::Kind::end) line.fail("", "comes after the end");
    ScriptStep step = parseStep(line);
    if (!steps.empty() && step.time < steps.back().time) line.fail("time", "is earlier than that of the previous step");
    steps.push_back(std::move(step));
  }
  if (steps.empty() || steps.back().kind != ScriptStep::Kind::end)
    throw ConfigurationError(file, number, "end", "is missing: the last step must be an end");
  return steps;
}

std::vector<ScriptStep> loadScript(const std::string& path, const std::vector<std::string>& renderers) {
  constexpr std::size_t kLargestScript = std::size_t{1} << 20;  // bytes
  return parseScript(readFile(path, kLargestScript), path, renderers);
}

}  // namespace enamel::viewer
