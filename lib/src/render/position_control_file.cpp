#include "enamel/render/position_control_file.hpp"

#include <nlohmann/json.hpp>

#include "core/message.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "surface";

// One file's values, each with its key in the error.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), json_(Json::parse(readJson(path), nullptr, false)) {
    if (!json_.is_object()) refuse("", "is not the JSON of a servo design");
    if (const Json& kind = value("kind"); kind != kKind) refuse("kind", "must be \"surface\"");
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& problem) const {
    throw ConfigurationError(path_, 0, key, problem);
  }
  const Json& value(const std::string& key) const {
    const auto found = json_.find(key);
    if (found == json_.end()) refuse(key, "is missing");
    return *found;
  }
  std::string text(const std::string& key) const {
    if (!value(key).is_string()) refuse(key, "must be a string");
    return value(key).get<std::string>();
  }
  double number(const std::string& key) const {
    if (!value(key).is_number()) refuse(key, "must be a number");
    return value(key).get<double>();
  }
  int whole(const std::string& key, const Json& json) const {
    if (!json.is_number_integer() || json < 0 || json > kMaxLoopDelay)
      refuse(key, "must be a whole number of ticks in 0 to " + std::to_string(kMaxLoopDelay));
    return json.get<int>();
  }
  const Json& list(const std::string& key, std::size_t least, std::size_t most) const {
    const Json& json = value(key);
    if (!json.is_array() || json.size() < least || json.size() > most)
      refuse(key, "must be a list of " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
                      " numbers");
    return json;
  }

 private:
  std::string path_;
  Json json_;
};

}  // namespace

PositionControlFile loadPositionControl(const std::string& path) {
  const Reader reader(path);
  PositionControlFile file;
  PositionControlOptions& o = file.options;
  file.model = reader.text("model");
  o.period = reader.number("period");
  const Json& count = reader.list("count", 1, kMaxJoints);
  o.encoderStep.resize(static_cast<Eigen::Index>(count.size()));
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (!count[i].is_number()) reader.refuse("count[" + std::to_string(i) + "]", "must be a number");
    o.encoderStep[static_cast<Eigen::Index>(i)] = count[i].get<double>();
  }
  const Json& delay = reader.list("delay", 2, 2);
  o.delayLow = reader.whole("delay[0]", delay[0]);
  o.delayHigh = reader.whole("delay[1]", delay[1]);
  o.horizon = reader.whole("horizon", reader.value("horizon"));
  for (const PositionControlParameter& p : positionControlParameters()) o.*p.value = reader.number(p.name);
  try {
    PositionControlRenderer{o};
  } catch (const Error& error) {
    reader.refuse("", error.what());
  }
  return file;
}

std::string positionControlText(const PositionControlFile& file) {
  const PositionControlOptions& o = file.options;
  Json json;
  json["kind"] = kKind;
  json["model"] = file.model;
  json["period"] = o.period;
  json["count"] = std::vector<double>(o.encoderStep.data(), o.encoderStep.data() + o.encoderStep.size());
  json["delay"] = {o.delayLow, o.delayHigh};
  json["horizon"] = o.horizon;
  for (const PositionControlParameter& p : positionControlParameters()) json[p.name] = o.*p.value;
  return json.dump(2) + "\n";
}

bool isPositionControlFile(const std::string& path) {
  try {
    const Json json = Json::parse(readJson(path), nullptr, false);
    return json.is_object() && json.value("kind", Json()) == kKind;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace enamel
