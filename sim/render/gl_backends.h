#pragma once

#include <memory>

#include "sim/render/gl_context.h"

/// @file
/// The backends behind MakeGlContext().

namespace vantage::sim {

/// A shared library opened at run time and kept open until the process ends: Mesa's drivers do not
/// survive being unloaded while a thread's storage still refers to them.
class SharedLibrary {
 public:
  /// Opens the first of the given names that exists. Throws ConfigError (key "sim.renderer") that
  /// names `package` when there is none.
  SharedLibrary(std::initializer_list<const char*> names, const char* package);

  /// Address of a function of the library. Throws RenderError when it has none of this name.
  template <typename Function>
  [[nodiscard]] Function Get(const char* name) const {
    return reinterpret_cast<Function>(Find(name));
  }

 private:
  [[nodiscard]] void* Find(const char* name) const;

  void* handle_{nullptr};
};

[[nodiscard]] std::unique_ptr<GlContext> MakeOsmesaContext();
[[nodiscard]] std::unique_ptr<GlContext> MakeEglContext();

}  // namespace vantage::sim
