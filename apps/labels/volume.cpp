#include "volume.hpp"

#include <vtkCallbackCommand.h>
#include <vtkDataArray.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNIFTIImageHeader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPointData.h>

#include <cmath>
#include <limits>

#include "enamel/core/error.hpp"
#include "nrrd.hpp"

namespace enamel::app {
namespace {

// Factor for the positions of a file, by its unit: m, mm, um; 0: unknown.
double scaleOf(int units) {
  switch (units & 7) {
    case 1: return 1.0;
    case 3: return 1e-6;
    default: return 1e-3;
  }
}

// Errors and warnings of VTK become a flag instead of text on stderr.
void watch(vtkObject* object, bool& failed) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(&failed);
  command->SetCallback([](vtkObject*, unsigned long, void* flag, void*) { *static_cast<bool*>(flag) = true; });
  object->AddObserver(vtkCommand::ErrorEvent, command);
  object->AddObserver(vtkCommand::WarningEvent, command);
}

}  // namespace

std::uint16_t labelOf(double value, const std::string& path) {
  if (!(value >= 0.0 && value <= std::numeric_limits<std::uint16_t>::max() && value == std::floor(value)))
    throw ConfigurationError(path, 0, "",
                             "has the value " + std::to_string(value) + ", labels must be whole numbers of 0 to 65535");
  return static_cast<std::uint16_t>(value);
}

LabelVolume loadLabels(const std::string& path) {
  if (isNrrd(path)) return loadNrrd(path);
  const auto refuse = [&path](const std::string& problem) { throw ConfigurationError(path, 0, "", problem); };
  vtkNew<vtkNIFTIImageReader> reader;
  bool failed = false;
  watch(reader, failed);
  watch(reader->GetExecutive(), failed);
  if (reader->CanReadFile(path.c_str()) == 0) refuse("is missing, or is neither a NIfTI nor an NRRD file");
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkImageData* const image = reader->GetOutput();
  vtkDataArray* const values = image->GetPointData()->GetScalars();
  if (failed || reader->GetErrorCode() != 0 || values == nullptr) refuse("is damaged or truncated");
  if (values->GetNumberOfComponents() != 1) refuse("has several values for each voxel, must have one label");
  if (reader->GetRescaleSlope() != 1.0 || reader->GetRescaleIntercept() != 0.0)
    refuse("has scaled values, must have labels");

  LabelVolume volume;
  image->GetDimensions(volume.size.data());
  const double scale = scaleOf(reader->GetNIFTIHeader()->GetXYZTUnits());
  for (int i = 0; i < 3; ++i) volume.spacing[i] = scale * image->GetSpacing()[i];
  vtkMatrix4x4* const pose = reader->GetSFormMatrix() != nullptr ? reader->GetSFormMatrix() : reader->GetQFormMatrix();
  const double* const first = image->GetOrigin();
  for (int i = 0; i < 3; ++i) {
    volume.origin[i] = scale * first[i];
    if (pose == nullptr) continue;
    volume.origin[i] = scale * pose->GetElement(i, 3);
    for (int k = 0; k < 3; ++k) {
      volume.axes(i, k) = pose->GetElement(i, k);
      volume.origin[i] += scale * pose->GetElement(i, k) * first[k];
    }
  }
  volume.labels.reserve(static_cast<std::size_t>(values->GetNumberOfTuples()));
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
    volume.labels.push_back(labelOf(values->GetComponent(i, 0), path));
  return volume;
}

}  // namespace enamel::app
