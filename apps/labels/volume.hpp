// Reads volumes of labels: NIfTI with VTK, and NRRD.
#pragma once

#include <string>

#include "enamel/collision/label_volume.hpp"

namespace enamel::app {

/// Return a value of a voxel as a label. Throws ConfigurationError with the file for a value that is not one.
std::uint16_t labelOf(double value, const std::string& path);

/// Read a NIfTI file (.nii, .nii.gz), or one in NRRD (loadNrrd()). Positions are those of its S-form, else of its
/// Q-form, in m; without a unit it has mm. Throws ConfigurationError with the file for a file that VTK cannot read, and
/// for values that are not labels.
LabelVolume loadLabels(const std::string& path);

}  // namespace enamel::app
