#include "enamel/identify/device_text.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "core/message.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel {
namespace {

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string vectorText(const double* values, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + rounded(values[i]);
  return text + "]";
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

std::string matrixText(const Mat3& matrix) {
  if (Mat3(matrix.diagonal().asDiagonal()) == matrix) return vectorText(Vec3(matrix.diagonal()).data(), 3);
  std::string rows = "[";
  for (int i = 0; i < 3; ++i) rows += (i > 0 ? ", " : "") + vectorText(Vec3(matrix.row(i)).data(), 3);
  return rows + "]";
}

// Values of vectors, whose elements are single estimates.
std::string vectorOf(const std::string& key, const DeviceParameters& device) {
  if (const auto* tau = std::get_if<TauParameters>(&device))
    return key == "platform.com" ? vectorText(tau->platform.com.data(), 3) : matrixText(tau->platform.inertia);
  const auto& cartesian = std::get<CartesianParameters>(device);
  if (key == "gravity") return vectorText(cartesian.gravity.data(), 3);
  if (key == "platform.damping") return vectorText(cartesian.damping.data(), static_cast<std::size_t>(cartesian.axes));
  return matrixText(cartesian.inertia);
}

// Replace mass and inertia of a link of a TAU: an inline table, or a table of its own.
std::string withLink(const std::string& text, int chain, int number, const LinkParameters& link) {
  const std::string name = "link" + std::to_string(number);
  std::istringstream lines(text);
  std::string result;
  int present = -1;
  bool isInside = false;
  for (std::string line; std::getline(lines, line); result += line + "\n") {
    const std::string content = trimmed(line.substr(0, line.find('#')));
    if (content == "[[chain]]") ++present;
    if (!content.empty() && content.front() == '[') isInside = present == chain && content == "[chain." + name + "]";
    if (present != chain) continue;
    const std::string key = trimmed(content.substr(0, content.find('=')));
    if (key == name && content.find('{') != std::string::npos)
      line = name + " = { length = " + rounded(link.length) + ", mass = " + rounded(link.mass) +
             ", com = " + vectorText(link.com.data(), 3) + ", inertia = " + matrixText(link.inertia) + " }";
    if (isInside && key == "mass") line = "mass = " + rounded(link.mass);
    if (isInside && key == "inertia") line = "inertia = " + matrixText(link.inertia);
  }
  return result;
}

// Keys and values for the file.
std::map<std::string, std::string> valuesOf(const Identification& result) {
  std::map<std::string, std::string> values;
  for (const Estimate& e : result.estimates) {
    if (!e.isInFile) continue;
    const std::string key = e.key.substr(0, e.key.find('['));
    values[key] = key == e.key ? rounded(e.value) : vectorOf(key, result.device);
  }
  const Imperfections& e = imperfectionsOf(result.device);
  const auto* cartesian = std::get_if<CartesianParameters>(&result.device);
  if (cartesian == nullptr || cartesian->axes == 3)
    values["imperfections.coulomb_friction"] = rounded(e.coulombFriction);
  values["imperfections.current_bandwidth"] = rounded(e.currentBandwidth);
  values["imperfections.lost_samples"] = rounded(result.lostSamples);
  if (e.cogging > 0.0) values["imperfections.cogging"] = rounded(e.cogging);
  return values;
}

// The same for all masses and inertias, except links of a TAU.
struct MassesOf {
  std::map<std::string, std::string> operator()(const TauParameters& p) const {
    return {{"platform.mass", rounded(p.platform.mass)},
            {"platform.inertia", matrixText(p.platform.inertia)},
            {"motor.rotor_inertia", rounded(p.motor.rotorInertia)}};
  }
  std::map<std::string, std::string> operator()(const DeltaParameters& p) const {
    return {{"platform.mass", rounded(p.platform.mass)},
            {"upper_link.mass", rounded(p.upperLink.mass)},
            {"upper_link.inertia", rounded(p.upperLink.inertia)},
            {"bar.mass", rounded(p.bar.mass)},
            {"motor.rotor_inertia", rounded(p.motor.rotorInertia)}};
  }
  std::map<std::string, std::string> operator()(const CartesianParameters& p) const {
    const std::vector<double>& masses = p.massTable.mass;
    std::map<std::string, std::string> values;
    masses.empty() ? values["platform.mass"] = rounded(p.mass)
                   : values["platform.mass_table"] = vectorText(masses.data(), masses.size());
    if (p.axes == 6) values["platform.inertia"] = matrixText(p.inertia);
    if (p.rotorMass > 0.0) values["rotor_mass"] = rounded(p.rotorMass);
    return values;
  }
};

std::string withLinks(std::string text, const DeviceParameters& device) {
  if (const auto* tau = std::get_if<TauParameters>(&device))
    for (int chain = 0; chain < 3; ++chain) {
      text = withLink(text, chain, 1, tau->chain[static_cast<std::size_t>(chain)].link1);
      text = withLink(text, chain, 2, tau->chain[static_cast<std::size_t>(chain)].link2);
    }
  return text;
}

// The text with lines of comment above it. Throws if it is not a device.
std::string withComment(const std::string& head, const std::string& table, const std::string& text) {
  std::string whole = head;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) whole += "#   " + line + "\n";
  whole += "\n" + text;
  (void)makeMechanism(parseDevice(whole, "the new device file"));
  return whole;
}

std::string factorOf(const char* name, double factor, double deviation) {
  const double interval = std::exp(1.96 * deviation);
  char text[120];
  std::snprintf(text, sizeof(text), "%s: %.3f times the file's (95 %%: %.3f to %.3f)\n", name, factor,
                factor / interval, factor * interval);
  return text;
}

std::string lineOf(const Estimate& e) {
  char text[160];
  std::snprintf(text, sizeof(text), "%-34s %12.5g  [%.5g, %.5g] %s  (file: %.5g)%s", e.key.c_str(), e.value, e.low,
                e.high, e.unit.c_str(), e.before, e.isSeen ? "" : "  not seen");
  return text;
}

}  // namespace

std::string withValue(const std::string& text, const std::string& key, const std::string& value) {
  const std::size_t dot = key.rfind('.');
  const std::string table = dot == std::string::npos ? "" : key.substr(0, dot);
  const std::string name = dot == std::string::npos ? key : key.substr(dot + 1);
  std::istringstream lines(text);
  std::string result, here;
  bool isDone = false;
  std::size_t end = table.empty() ? 0 : std::string::npos;  // of the table's header, in `result`
  for (std::string line; std::getline(lines, line);) {
    const std::string content = trimmed(line.substr(0, line.find('#')));
    if (!content.empty() && content.front() == '[' && content.find('=') == std::string::npos) {
      here =
          trimmed(content.substr(content.find_first_not_of('['), content.find(']') - content.find_first_not_of('[')));
    }
    const std::size_t equals = content.find('=');
    if (!isDone && here == table && equals != std::string::npos && trimmed(content.substr(0, equals)) == name) {
      if (content.find('[') != std::string::npos && content.find(']') == std::string::npos)
        throw Error("the value of " + key + " extends over several lines: write it on one line");
      const std::size_t comment = line.find('#');
      std::string changed = name + " = " + value;
      if (comment != std::string::npos)
        changed += std::string(comment > changed.size() ? comment - changed.size() : 1, ' ') + line.substr(comment);
      line = changed;
      isDone = true;
    }
    result += line + "\n";
    if (here == table && !table.empty() && end == std::string::npos) end = result.size();
  }
  if (isDone) return result;
  if (end == std::string::npos) return result + "\n[" + table + "]\n" + name + " = " + value + "\n";
  return result.insert(end, name + " = " + value + "\n");
}

std::string tableOf(const Identification& result) {
  std::string text;
  for (const Estimate& e : result.estimates) text += lineOf(e) + "\n";
  const DelayEstimate& d = result.delay;
  text += "loop delay: " + std::to_string(d.low) + (d.high > d.low ? " to " + std::to_string(d.high) : "") + " ticks" +
          (d.isCertain ? "" : ", not certain: " + d.second + " explains the recording nearly as well") + "\n";
  text += "samples lost: " + rounded(100.0 * result.lostSamples) + " %\n";
  return text;
}

std::string identifiedText(const std::string& text, const Identification& result) {
  if (!result.isUsable()) throw Error("the device cannot be identified: " + result.problems.front());
  std::string changed = text;
  for (const auto& [key, value] : valuesOf(result)) changed = withValue(changed, key, value);
  return withComment(
      "# Numbers estimated by enamel identify: value, 95 % interval, value of the file before. The torque constants "
      "are\n"
      "# relative to their mean: with it, all masses, inertias and frictions may be wrong by one common factor.\n",
      tableOf(result), withLinks(changed, result.device));
}

std::string tableOf(const PositionControlState& learnt) {
  std::string text = factorOf("masses", learnt.mass, learnt.deviation);
  if (learnt.cableDeviation > 0.0) text += factorOf("stiffness of the cables", learnt.cable, learnt.cableDeviation);
  return text + "delay: " + toText({learnt.delayLow, learnt.delayHigh}) + " ticks\n";
}

std::string learntText(const std::string& text, const PositionControlState& learnt) {
  DeviceParameters device = parseDevice(text, "the device file");
  scaleMasses(device, learnt.mass);
  std::string changed = text;
  for (const auto& [key, value] : std::visit(MassesOf{}, device)) changed = withValue(changed, key, value);
  if (const double cables = imperfectionsOf(device).cableStiffness; cables > 0.0)
    changed = withValue(changed, "imperfections.cable_stiffness", rounded(cables * learnt.cable));
  return withComment(
      "# Numbers that position control has learnt in use: a proposal. One factor holds for all masses, except those "
      "of\n"
      "# rotors behind cables.\n",
      tableOf(learnt), withLinks(changed, device));
}

}  // namespace enamel
