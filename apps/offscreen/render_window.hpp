// VTK's window in a context that somebody else owns.
#pragma once

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkSmartPointer.h>

#include "surface.hpp"

namespace enamel::offscreen {

/// A window that draws into `surface`, which must outlive it; VTK's messages go to stderr, a line each, after the name
/// of the program. Before the surface ends: Finalize() and RemoveAllObservers().
vtkSmartPointer<vtkGenericOpenGLRenderWindow> makeRenderWindow(Surface& surface, const char* program);

}  // namespace enamel::offscreen
