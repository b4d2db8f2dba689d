#include <array>

#define EGL_NO_X11  // No window system's types: there is no window.
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "sim/render/gl_backends.h"

namespace vantage::sim {
namespace {

// The functions of libEGL, and the display, that all contexts of the process share: eglTerminate()
// by one context would end the others too, so the display stays until the process ends.
class Egl {
 public:
  [[nodiscard]] static const Egl& Get() {
    static const Egl egl;
    return egl;
  }

  decltype(&eglBindAPI) bind_api;
  decltype(&eglCreateContext) create_context;
  decltype(&eglDestroyContext) destroy_context;
  decltype(&eglMakeCurrent) make_current;
  decltype(&eglGetProcAddress) get_proc;
  EGLDisplay display{EGL_NO_DISPLAY};

 private:
  Egl() : library_({"libEGL.so.1", "libEGL.so"}, "libegl1") {
    bind_api = library_.Get<decltype(&eglBindAPI)>("eglBindAPI");
    create_context = library_.Get<decltype(&eglCreateContext)>("eglCreateContext");
    destroy_context = library_.Get<decltype(&eglDestroyContext)>("eglDestroyContext");
    make_current = library_.Get<decltype(&eglMakeCurrent)>("eglMakeCurrent");
    get_proc = library_.Get<decltype(&eglGetProcAddress)>("eglGetProcAddress");
    const auto get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_proc("eglGetPlatformDisplayEXT"));
    if (get_display == nullptr) throw RenderError("EGL has no platform displays");
    display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    const auto initialize = library_.Get<decltype(&eglInitialize)>("eglInitialize");
    if (display == EGL_NO_DISPLAY || initialize(display, nullptr, nullptr) == EGL_FALSE) {
      throw RenderError(
          "EGL cannot open a display without a surface (Debian package libegl-mesa0)");
    }
  }

  SharedLibrary library_;
};

class EglContext final : public GlContext {
 public:
  EglContext() : egl_(Egl::Get()) {
    const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                           3,
                                           EGL_CONTEXT_MINOR_VERSION,
                                           3,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                           EGL_NONE};
    egl_.bind_api(EGL_OPENGL_API);
    context_ =
        egl_.create_context(egl_.display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT) {
      throw RenderError("EGL cannot make an OpenGL 3.3 core context");
    }
  }

  ~EglContext() override {
    ReleaseIfCurrent();
    egl_.destroy_context(egl_.display, context_);
  }

  [[nodiscard]] Proc GetProc(const char* name) const override { return egl_.get_proc(name); }
  [[nodiscard]] std::string name() const override { return "egl"; }

 private:
  void Bind() override {
    egl_.bind_api(EGL_OPENGL_API);  // Per thread.
    if (egl_.make_current(egl_.display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      throw RenderError("eglMakeCurrent failed");
    }
  }
  void Unbind() noexcept override {
    egl_.make_current(egl_.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  const Egl& egl_;
  EGLContext context_{EGL_NO_CONTEXT};
};

}  // namespace

std::unique_ptr<GlContext> MakeEglContext() {
  return std::make_unique<EglContext>();
}

}  // namespace vantage::sim
