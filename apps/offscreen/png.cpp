#include "png.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cstddef>

#include "enamel/core/file.hpp"

namespace enamel::offscreen {

void writePng(int width, int height, const unsigned char* rgb, const std::string& path) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(width, height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  std::copy_n(rgb, 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
              static_cast<unsigned char*>(image->GetScalarPointer()));
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(image);
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  writeFile(path, {reinterpret_cast<const char*>(bytes->GetPointer(0)),
                   static_cast<std::size_t>(bytes->GetNumberOfValues())});
}

}  // namespace enamel::offscreen
