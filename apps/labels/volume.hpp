// Reads volumes of labels with VTK.
#pragma once

#include <string>

#include "enamel/collision/label_volume.hpp"

namespace enamel::app {

/// Read a NIfTI file (.nii, .nii.gz). Positions are those of its S-form, else of its Q-form, in m; without a unit it
/// has mm. Throws ConfigurationError with the file for a file that VTK cannot read, and for values that are not labels.
LabelVolume loadLabels(const std::string& path);

}  // namespace enamel::app
