// Scripts: a person's actions with their times.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "actions.hpp"
#include "camera.hpp"
#include "experiment.hpp"

namespace enamel::viewer {

/// One line of a script.
struct ScriptStep {
  enum class Kind {
    action,
    hand,
    spin,
    view,
    renderer,
    right,
    set,
    scene,
    slowdown,
    seek,
    size,
    frames,
    picture,
    end
  } kind = Kind::end;
  double time = 0.0;  ///< s of wall time since the start
  Action action = Action::pause;
  glm::dvec3 target{0.0};  ///< of hand, mm
  Camera view;             ///< of view
  double over = 0.0;       ///< of hand: duration of the motion, s
  int number = 0;          ///< of renderer and right (RendererSlot), spin (0 or 1), slowdown, frames (per second)
  glm::ivec2 size{0};
  double value = 0.0;  ///< of set; of seek, s
  std::string name;    ///< of picture and scene
};

/// Read a script. Each line is a step, "TIME COMMAND"; times must not decrease, and # begins a remark. The commands are
/// the names of the actions (see the help), and:
/// - `hand X Y Z [over S]` [mm];
/// - `spin on`, `spin off`: of the bur;
/// - `view X Y Z AZIMUTH ELEVATION DISTANCE`: the camera looks at a point [mm], from there [deg, mm];
/// - `renderer NAME`: one of `renderers`; in the split screen for the left tool;
/// - `right NAME`: for the right tool;
/// - `scene FILE`: relative to the script's folder;
/// - `slow N`: slow motion 1:N;
/// - `seek S`: to a time of the recording, s;
/// - `size WxH`;
/// - `frames FPS`: records every frame from here on; 0 ends it;
/// - `picture NAME`;
/// - `set NAME VALUE`: NAME as in settingRows();
/// - `end`: must be the last step.
/// For a recording, `renderers` is empty, and hand, spin, renderer, set and scene are not available. Throws
/// ConfigurationError. Realtime: no.
std::vector<ScriptStep> loadScript(const std::string& path, const std::vector<std::string>& renderers);
std::vector<ScriptStep> parseScript(std::string_view text, const std::string& file,
                                    const std::vector<std::string>& renderers);

/// A setting that `set` changes, with its range.
struct SettingRow {
  const char* name;
  double low, high;
  bool whole;  ///< must be a whole number
  void (*apply)(Settings& settings, double value);
};
const std::vector<SettingRow>& settingRows();

/// Parse "WxH", each 160 to 8192. Throws Error.
glm::ivec2 parseSize(const std::string& text);

}  // namespace enamel::viewer
