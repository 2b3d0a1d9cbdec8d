// Parts of pages: the files in page/, and the libraries of others.
#pragma once

namespace enamel::app {

extern const char* const kReplayPage;
extern const char* const kReplayStyle;
extern const char* const kReplayScript;
extern const char* const kThree;

extern const char* const kVega;  ///< defines `vega`
extern const char* const kFigures;

}  // namespace enamel::app
