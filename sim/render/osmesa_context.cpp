#include <array>
#include <cstdint>

#include <GL/osmesa.h>

#include "sim/render/gl_backends.h"

namespace vantage::sim {
namespace {

class OsmesaContext final : public GlContext {
 public:
  OsmesaContext() : library_({"libOSMesa.so.8", "libOSMesa.so"}, "libosmesa6") {
    make_current_ = library_.Get<decltype(&OSMesaMakeCurrent)>("OSMesaMakeCurrent");
    destroy_ = library_.Get<decltype(&OSMesaDestroyContext)>("OSMesaDestroyContext");
    get_proc_ = library_.Get<decltype(&OSMesaGetProcAddress)>("OSMesaGetProcAddress");
    const auto create =
        library_.Get<decltype(&OSMesaCreateContextAttribs)>("OSMesaCreateContextAttribs");
    // Everything is drawn to framebuffer objects, so the context's own buffers are token ones.
    const std::array<int, 13> attributes{OSMESA_FORMAT,
                                         OSMESA_RGBA,
                                         OSMESA_DEPTH_BITS,
                                         0,
                                         OSMESA_STENCIL_BITS,
                                         0,
                                         OSMESA_PROFILE,
                                         OSMESA_CORE_PROFILE,
                                         OSMESA_CONTEXT_MAJOR_VERSION,
                                         3,
                                         OSMESA_CONTEXT_MINOR_VERSION,
                                         3,
                                         0};
    context_ = create(attributes.data(), nullptr);
    if (context_ == nullptr) throw RenderError("OSMesa cannot make an OpenGL 3.3 core context");
  }

  ~OsmesaContext() override {
    ReleaseIfCurrent();
    destroy_(context_);
  }

  [[nodiscard]] Proc GetProc(const char* name) const override { return get_proc_(name); }
  [[nodiscard]] std::string name() const override { return "osmesa"; }

 private:
  void Bind() override {
    if (make_current_(context_, buffer_.data(), GL_UNSIGNED_BYTE, kSize, kSize) == GL_FALSE) {
      throw RenderError("OSMesaMakeCurrent failed");
    }
  }
  void Unbind() noexcept override { make_current_(nullptr, nullptr, 0, 0, 0); }

  static constexpr int kSize = 16;
  SharedLibrary library_;
  decltype(&OSMesaMakeCurrent) make_current_{nullptr};
  decltype(&OSMesaDestroyContext) destroy_{nullptr};
  decltype(&OSMesaGetProcAddress) get_proc_{nullptr};
  OSMesaContext context_{nullptr};
  std::array<std::uint8_t, 4 * kSize * kSize> buffer_{};
};

}  // namespace

std::unique_ptr<GlContext> MakeOsmesaContext() {
  return std::make_unique<OsmesaContext>();
}

}  // namespace vantage::sim
