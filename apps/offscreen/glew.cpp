// Debian's GLEW supports GLX only. In an EGL context, glewInit() loads every function and then reports a missing GLX
// display; VTK would log an error per frame. This definition precedes the library's and ignores that report.
#include <GL/glew.h>
#include <dlfcn.h>

extern "C" GLenum glewInit() {
  using Function = GLenum (*)();
  static const auto original = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "glewInit"));  // NOLINT: what dlsym returns
  if (original == nullptr) return GLEW_ERROR_NO_GL_VERSION;
  const GLenum result = original();
  return result == GLEW_ERROR_NO_GLX_DISPLAY ? GLEW_OK : result;
}
