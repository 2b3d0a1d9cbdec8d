// Reads volumes of labels in NRRD. VTK 9.1 drops the directions of the axes and accepts truncated files.
#pragma once

#include <string>

#include "enamel/collision/label_volume.hpp"

namespace enamel::app {

/// Return whether a file begins as NRRD does. False if it cannot be read.
bool isNrrd(const std::string& path);

/// Read an NRRD file with data attached (.nrrd) or in one other file (.nhdr), raw or compressed by gzip. Positions are
/// in right-anterior-superior (RAS) if the file names an anatomical space, else as in the file; without a unit it has
/// mm. Throws ConfigurationError with the file, and the line of its header, for:
/// - a file that does not follow the definition (teem.sourceforge.net/nrrd/format.html);
/// - several data files, skipped bytes, or another encoding;
/// - values that are not labels.
LabelVolume loadNrrd(const std::string& path);

}  // namespace enamel::app
