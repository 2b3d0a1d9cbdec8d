// Parts of the page that replay_page.cpp writes: the files in page/, and three.js.
#pragma once

namespace enamel::app {

extern const char* const kReplayPage;
extern const char* const kReplayStyle;
extern const char* const kReplayScript;
extern const char* const kThree;

}  // namespace enamel::app
