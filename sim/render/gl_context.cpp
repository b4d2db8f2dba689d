#include "sim/render/gl_context.h"

#include <cstdlib>

#include <dlfcn.h>

#include "sim/render/gl_backends.h"

namespace vantage::sim {
namespace {

thread_local GlContext* current_context = nullptr;

}  // namespace

void GlContext::MakeCurrent() {
  if (current_context == this) return;
  // The backends share Mesa's per-thread dispatch and do not know of one another: leave the old
  // context in its own words before the new one comes in.
  if (current_context != nullptr) current_context->Unbind();
  current_context = nullptr;
  Bind();
  current_context = this;
}

void GlContext::ReleaseIfCurrent() noexcept {
  if (current_context != this) return;
  Unbind();
  current_context = nullptr;
}

std::unique_ptr<GlContext> MakeGlContext(GlBackend backend) {
  setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);
  if (backend == GlBackend::kOsmesa) return MakeOsmesaContext();
  if (backend == GlBackend::kEgl) return MakeEglContext();
  try {
    return MakeOsmesaContext();
  } catch (const ConfigError& no_osmesa) {
    try {
      return MakeEglContext();
    } catch (const ConfigError& no_egl) {
      throw ConfigError("", "sim.renderer",
                        std::string(no_osmesa.what()) + "; and " + no_egl.what());
    }
  }
}

SharedLibrary::SharedLibrary(std::initializer_list<const char*> names, const char* package) {
  for (const char* name : names) {
    handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (handle_ != nullptr) return;
  }
  throw ConfigError("", "sim.renderer",
                    std::string("cannot load ") + *names.begin() + ": " + dlerror() +
                        " (Debian package " + package + ")");
}

void* SharedLibrary::Find(const char* name) const {
  void* const address = dlsym(handle_, name);
  if (address == nullptr) throw RenderError(std::string("no function ") + name + " in its library");
  return address;
}

}  // namespace vantage::sim
