#include "sim/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "sim/render/floor_tiles.h"
#include "sim/render/gl_functions.h"
#include "sim/render/marker_geometry.h"
#include "sim/render/shaders.h"
#include "sim/render/visible_triangles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Matrix3f;
using Eigen::Matrix4f;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kNear = 0.03;     // [m].
constexpr double kFar = 60.0;      // [m].
constexpr int kSupersampling = 2;  // Of colour images, each way.

// A pass over all bodies costs about as much as filling this many pixels: windows nearer to one
// another than that are drawn in one pass.
constexpr std::int64_t kPassCost = 24000;  // [px].

// The floor's chequer loses half its contrast where kTileFading · Z² = 1.
constexpr float kTileFading = 0.06F;

// Depth Z to normalised device depth is kDepthOffset + kDepthScale / Z.
constexpr double kDepthOffset = (kFar + kNear) / (kFar - kNear);
constexpr double kDepthScale = -2.0 * kFar * kNear / (kFar - kNear);

// The same camera with `factor` pixels for each one, each way.
CameraModel Magnify(const CameraModel& camera, int factor) {
  CameraModel fine = camera;
  fine.fx *= factor;
  fine.fy *= factor;
  fine.skew *= factor;
  fine.u0 = factor * (camera.u0 + 0.5) - 0.5;
  fine.v0 = factor * (camera.v0 + 0.5) - 0.5;
  fine.width *= factor;
  fine.height *= factor;
  return fine;
}

// Camera frame to clip space, with image row 0 at the bottom of the framebuffer. Pixel centres are
// whole numbers in the camera model and halves in GL.
Matrix4f Projection(const CameraModel& camera) {
  Matrix4f P = Matrix4f::Zero();
  P(0, 0) = static_cast<float>(2.0 * camera.fx / camera.width);
  P(0, 1) = static_cast<float>(2.0 * camera.skew / camera.width);
  P(0, 2) = static_cast<float>(2.0 * (camera.u0 + 0.5) / camera.width - 1.0);
  P(1, 1) = static_cast<float>(2.0 * camera.fy / camera.height);
  P(1, 2) = static_cast<float>(2.0 * (camera.v0 + 0.5) / camera.height - 1.0);
  P(2, 2) = static_cast<float>(kDepthOffset);
  P(2, 3) = static_cast<float>(kDepthScale);
  P(3, 2) = 1.0F;
  return P;
}

// Windows to passes: overlapping ones and those that are cheaper together become one.
std::vector<PixelWindow> PlanPasses(const std::vector<PixelWindow>& windows, int width,
                                    int height) {
  std::vector<PixelWindow> passes = MergeOverlapping(windows, width, height);
  for (std::size_t i = 0; i < passes.size();) {
    bool merged = false;
    for (std::size_t j = i + 1; j < passes.size() && !merged; ++j) {
      const PixelWindow hull = Hull(passes[i], passes[j]);
      if (hull.area() >= passes[i].area() + passes[j].area() + kPassCost) continue;
      passes.erase(passes.begin() + static_cast<std::ptrdiff_t>(j));
      passes[i] = hull;
      passes = MergeOverlapping(passes, width, height);
      merged = true;
    }
    i = merged ? 0 : i + 1;
  }
  return passes;
}

struct MarkerVertex {
  float corner[3];
  float row_s[3], row_t[3], row_w[3];
  float reference_levels[4];
  float index;
  float plate[2];  // Radius in the disc's radii, brightness; radius 0: no plate.
};

struct MeshBuffers {
  GLuint vertex_array{0};
  GLsizei indices{0};
  BoundingSphere bound;
};

// A framebuffer with its colour and depth storage.
struct Target {
  GLuint framebuffer{0};
  int width{0}, height{0};
};

struct Program {
  GLuint name{0};
  GLint projection{-1}, body_to_camera{-1}, light{-1}, up{-1}, surface{-1}, ambient{-1}, eye{-1};
  GLint id{-1}, radial{-1}, tangential{-1}, pixel_to_ray{-1}, tiles{-1};
};

// What one image needs of a camera: its lens maps are made once for each resolution.
struct Lens {
  CameraModel camera;
  Matrix4f projection;
  GLuint map{0}, slope{0};  // Textures; 0 without distortion.
};

// Largest r² at which the radial polynomial still grows, up to a little more than the image needs.
double TrustedRadius2(const CameraModel& camera) {
  double needed = 0.0;
  for (const double u : {-0.5, camera.width - 0.5}) {
    for (const double v : {-0.5, camera.height - 0.5}) {
      needed = std::max(needed, ToNormalised(camera, {u, v}).squaredNorm());
    }
  }
  const Distortion& d = camera.distortion;
  const double target = 1.7 * needed;
  double trusted = 0.0;
  constexpr int kSteps = 1000;
  for (int i = 1; i <= kSteps; ++i) {
    const double r2 = target * i / kSteps;
    if (1.0 + r2 * (3.0 * d.k1 + r2 * (5.0 * d.k2 + r2 * 7.0 * d.k3)) <= 0.05) break;
    trusted = r2;
  }
  return std::max(trusted, 1e-6);
}

// Of colour and ID images the plates are bodies like others.
void AddPlates(Scene* scene) {
  for (const SceneMarker& marker : scene->markers) {
    if (!marker.plate) continue;
    scene->bodies.push_back({marker.frame, MarkerPlate(marker.marker), *marker.plate, 0.1F});
  }
}

void Require(bool condition, const std::string& key, const std::string& reason) {
  if (!condition) throw ConfigError("", key, reason);
}

void Validate(const CameraModel& camera, const Scene& scene) {
  Require(camera.width > 0 && camera.height > 0 && camera.width <= 8192 && camera.height <= 8192,
          "camera.size",
          "must be in [1, 8192] px, is " + std::to_string(camera.width) + "x" +
              std::to_string(camera.height));
  Require(camera.fx > 0.0 && camera.fy > 0.0 && std::isfinite(camera.fx + camera.fy),
          "camera.focal", "must be > 0 px");
  Require(scene.floor.tile > 0.0 && std::isfinite(scene.floor.height + scene.floor.reach),
          "scene.floor", "needs a tile > 0 m and a finite height and reach");
  Require(scene.markers.size() <= kMaxMarkers, "scene.markers",
          "must be at most " + std::to_string(kMaxMarkers) + ", are " +
              std::to_string(scene.markers.size()));
  const auto known = [](int frame) { return frame >= kGoalFrame && frame < kMaxJoints; };
  for (const SceneMarker& marker : scene.markers) {
    const std::string key = "scene.markers." + std::to_string(marker.marker.id);
    Require(known(marker.frame), key, "is fixed to no frame: " + std::to_string(marker.frame));
    Require(marker.marker.radius > 0.0 && std::isfinite(marker.marker.radius), key,
            "needs a radius > 0 m");
    Require(std::abs(marker.marker.normal.norm() - 1.0) < 1e-6, key, "needs a unit normal");
  }
  for (const Body& body : scene.bodies) {
    Require(known(body.frame), "scene.bodies", "one is fixed to no frame");
    Require(body.mesh.vertices.size() == body.mesh.normals.size(), "scene.bodies",
            "one has not as many normals as vertices");
    Require(std::all_of(body.mesh.indices.begin(), body.mesh.indices.end(),
                        [&](std::uint32_t i) { return i < body.mesh.vertices.size(); }),
            "scene.bodies", "one has an index without a vertex");
  }
}

}  // namespace

class Renderer::Impl {
 public:
  Impl(std::unique_ptr<GlContext> context, const CameraModel& camera, Scene scene)
      : context_(std::move(context)), scene_(std::move(scene)) {
    Validate(camera, scene_);
    context_->MakeCurrent();
    gl_ = LoadGlFunctions(*context_);
    bent_ = !camera.distortion.none();
    trusted_radius2_ = bent_ ? TrustedRadius2(camera) : 1.0;
    native_ = MakeLens(camera);
    SetFixedState();
    MakePrograms();
    visible_.emplace(scene_, camera, kNear);
    AddPlates(&scene_);
    for (const Body& body : scene_.bodies) bodies_.push_back(Upload(body.mesh));
    MakeLitBuffer();
    floor_ = Upload(DarkTiles(scene_.floor));
    MakeMarkerBuffer();
    gl_.GenVertexArrays(1, &empty_array_);
    grey_ =
        MakeTarget(camera.width, camera.height, GL_R8, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    WarmUp();
  }

  // The context's destruction frees its objects; it may not be current, or be another thread's.
  ~Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] const CameraModel& camera() const noexcept { return native_.camera; }

  void RenderGrey(const Isometry3d& X_WC, const SceneState& state,
                  const std::vector<PixelWindow>* windows, GreyImage* image) {
    Begin(grey_, X_WC, state, native_);
    if (image->width != grey_.width || image->height != grey_.height) {
      image->Resize(grey_.width, grey_.height);
    }
    const std::vector<PixelWindow> passes =
        windows == nullptr ? std::vector<PixelWindow>{{0, 0, grey_.width, grey_.height}}
                           : PlanPasses(*windows, grey_.width, grey_.height);
    PlaceBodies(passes);
    for (std::size_t i = 0; i < passes.size(); ++i) {
      DrawGrey(passes[i], bounds_[i], /*scissored=*/windows != nullptr);
    }
    for (const PixelWindow& pass : passes) ReadGrey(pass, image);
  }

  void RenderColour(const Isometry3d& X_WC, const SceneState& state, ColourImage* image) {
    if (colour_.framebuffer == 0) {
      context_->MakeCurrent();
      fine_ = MakeLens(Magnify(native_.camera, kSupersampling));
      colour_ = MakeTarget(fine_.camera.width, fine_.camera.height, GL_RGBA8, GL_DEPTH24_STENCIL8,
                           GL_DEPTH_STENCIL_ATTACHMENT);
    }
    Begin(colour_, X_WC, state, fine_);
    gl_.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    DrawBackdrop();
    const RayBounds bounds = BoundRays(lens_->camera, {0, 0, colour_.width, colour_.height});
    if (FloorSeen()) DrawShadows();
    DrawBodies(mesh_colour_, bounds, Material::kColour);
    DrawMarkers(MarkerLook::kColour, {0, 0, colour_.width, colour_.height});
    ReadColour(image);
  }

  void RenderIds(const Isometry3d& X_WC, const SceneState& state, IdImage* ids, DepthImage* depth) {
    if (ids_.framebuffer == 0) {
      context_->MakeCurrent();
      ids_ = MakeTarget(native_.camera.width, native_.camera.height, GL_R16UI,
                        GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    }
    Begin(ids_, X_WC, state, native_);
    const std::array<GLuint, 4> background{kIdBackground, 0, 0, 0};
    gl_.ClearBufferuiv(GL_COLOR, 0, background.data());
    gl_.Clear(GL_DEPTH_BUFFER_BIT);
    const PixelWindow all{0, 0, ids_.width, ids_.height};
    DrawBodies(mesh_id_, BoundRays(lens_->camera, all), Material::kId);
    gl_.DepthMask(GL_TRUE);
    DrawMarkers(MarkerLook::kId, all);
    ids->Resize(ids_.width, ids_.height);
    gl_.ReadPixels(0, 0, ids_.width, ids_.height, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
                   ids->pixels.data());
    DepthImage own;
    DepthImage* const metres = depth == nullptr ? &own : depth;
    metres->Resize(ids_.width, ids_.height);
    gl_.ReadPixels(0, 0, ids_.width, ids_.height, GL_DEPTH_COMPONENT, GL_FLOAT,
                   metres->pixels.data());
    FinishDepth(ids, metres);
  }

 private:
  enum class Material { kColour, kId };
  enum class MarkerLook { kGrey, kColour, kId };  // In grey images with the plate's face.

  // --- set-up -------------------------------------------------------------------------------------

  GLuint Compile(GLenum stage, std::initializer_list<const char*> sources, const char* defines) {
    std::string text = "#version 330 core\n";
    if (bent_) text += "#define BENT_LENS\n";
    text += defines;
    for (const char* source : sources) text += source;
    const GLuint shader = gl_.CreateShader(stage);
    const char* const pointer = text.c_str();
    gl_.ShaderSource(shader, 1, &pointer, nullptr);
    gl_.CompileShader(shader);
    GLint ok = GL_FALSE;
    gl_.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) {
      std::array<char, 2000> log{};
      gl_.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
      throw RenderError(std::string("shader: ") + log.data());
    }
    return shader;
  }

  Program Link(GLuint vertex, GLuint fragment) {
    Program program;
    program.name = gl_.CreateProgram();
    gl_.AttachShader(program.name, vertex);
    gl_.AttachShader(program.name, fragment);
    gl_.LinkProgram(program.name);
    GLint ok = GL_FALSE;
    gl_.GetProgramiv(program.name, GL_LINK_STATUS, &ok);
    if (ok != GL_TRUE) {
      std::array<char, 2000> log{};
      gl_.GetProgramInfoLog(program.name, static_cast<GLsizei>(log.size()), nullptr, log.data());
      throw RenderError(std::string("program: ") + log.data());
    }
    gl_.DeleteShader(vertex);
    gl_.DeleteShader(fragment);
    const auto at = [&](const char* name) { return gl_.GetUniformLocation(program.name, name); };
    program.projection = at("projection");
    program.body_to_camera = at("body_to_camera");
    program.light = at("light");
    program.up = at("up");
    program.surface = at("surface");
    program.ambient = at("ambient");
    program.eye = at("eye");
    program.id = at("id");
    program.radial = at("radial");
    program.tangential = at("tangential");
    program.pixel_to_ray = at("pixel_to_ray");
    program.tiles = at("tiles");
    gl_.UseProgram(program.name);
    if (bent_) {
      gl_.Uniform1i(at("lens_map"), 0);
      gl_.Uniform1i(at("lens_slope"), 1);
    }
    return program;
  }

  void MakePrograms() {
    using namespace shaders;  // NOLINT(google-build-using-namespace): a list of names, used here only.
    const auto vertex = [&](std::initializer_list<const char*> sources, const char* defines = "") {
      return Compile(GL_VERTEX_SHADER, sources, defines);
    };
    const auto fragment = [&](std::initializer_list<const char*> sources) {
      return Compile(GL_FRAGMENT_SHADER, sources, "");
    };
    lit_ = Link(vertex({kBend, kLitVertex}), fragment({kLitFragment}));
    mesh_colour_ = Link(vertex({kBend, kMeshVertex}, "#define SMOOTH_LIGHT\n"),
                        fragment({kMeshColourFragment}));
    mesh_id_ = Link(vertex({kBend, kMeshVertex}), fragment({kMeshIdFragment}));
    shadow_ = Link(vertex({kBend, kMeshVertex}), fragment({kShadowFragment}));
    tile_ = Link(vertex({kBend, kMeshVertex}, "#define TILE\n"), fragment({kTileFragment}));
    backdrop_ = Link(vertex({kBackdropVertex}), fragment({kLens, kBackdropFragment}));
    marker_ = Link(vertex({kMarkerVertex}), fragment({kLens, kMarkerRadius, kMarkerFragment}));
    marker_id_ = Link(vertex({kMarkerVertex}), fragment({kLens, kMarkerRadius, kMarkerIdFragment}));
  }

  void SetFixedState() {
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl_.DepthFunc(GL_LESS);
    gl_.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    // Image rows run downwards, which mirrors the winding of triangles.
    gl_.FrontFace(GL_CW);
    gl_.StencilFunc(GL_EQUAL, 0, 0xff);
    gl_.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  }

  MeshBuffers Upload(const TriangleMesh& mesh) {
    MeshBuffers buffers;
    buffers.bound = Bound(mesh);
    buffers.indices = static_cast<GLsizei>(mesh.indices.size());
    std::vector<float> data;
    data.reserve(6 * mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) data.push_back(mesh.vertices[i][k]);
      for (int k = 0; k < 3; ++k) data.push_back(mesh.normals[i][k]);
    }
    std::array<GLuint, 2> names{};
    gl_.GenVertexArrays(1, &buffers.vertex_array);
    gl_.BindVertexArray(buffers.vertex_array);
    gl_.GenBuffers(2, names.data());
    gl_.BindBuffer(GL_ARRAY_BUFFER, names[0]);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(float)),
                   data.data(), GL_STATIC_DRAW);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, names[1]);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)),
                   mesh.indices.data(), GL_STATIC_DRAW);
    constexpr GLsizei kStride = 6 * sizeof(float);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, nullptr);
    gl_.EnableVertexAttribArray(1);
    gl_.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, kStride,
                            reinterpret_cast<const void*>(3 * sizeof(float)));
    return buffers;
  }

  void MakeLitBuffer() {
    std::array<GLuint, 2> names{};
    gl_.GenVertexArrays(1, &lit_array_);
    gl_.BindVertexArray(lit_array_);
    gl_.GenBuffers(2, names.data());
    lit_vertices_ = names[0];
    lit_indices_ = names[1];
    gl_.BindBuffer(GL_ARRAY_BUFFER, lit_vertices_);
    gl_.BufferData(GL_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(visible_->vertex_count() * sizeof(LitVertex)), nullptr,
                   GL_STREAM_DRAW);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, lit_indices_);
    const auto attribute = [&](GLuint location, GLint size, std::size_t offset) {
      gl_.EnableVertexAttribArray(location);
      gl_.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(LitVertex),
                              reinterpret_cast<const void*>(offset));
    };
    attribute(0, 3, offsetof(LitVertex, position));
    attribute(1, 1, offsetof(LitVertex, brightness));
  }

  void MakeMarkerBuffer() {
    gl_.GenVertexArrays(1, &marker_array_);
    gl_.BindVertexArray(marker_array_);
    gl_.GenBuffers(1, &marker_buffer_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, marker_buffer_);
    const auto attribute = [&](GLuint location, GLint size, std::size_t offset) {
      gl_.EnableVertexAttribArray(location);
      gl_.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(MarkerVertex),
                              reinterpret_cast<const void*>(offset));
    };
    attribute(0, 3, offsetof(MarkerVertex, corner));
    attribute(1, 3, offsetof(MarkerVertex, row_s));
    attribute(2, 3, offsetof(MarkerVertex, row_t));
    attribute(3, 3, offsetof(MarkerVertex, row_w));
    attribute(4, 4, offsetof(MarkerVertex, reference_levels));
    attribute(5, 1, offsetof(MarkerVertex, index));
    attribute(6, 2, offsetof(MarkerVertex, plate));
  }

  Target MakeTarget(int width, int height, GLenum colour, GLenum depth, GLenum depth_attachment) {
    Target target;
    target.width = width;
    target.height = height;
    std::array<GLuint, 2> storage{};
    gl_.GenFramebuffers(1, &target.framebuffer);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl_.GenRenderbuffers(2, storage.data());
    gl_.BindRenderbuffer(GL_RENDERBUFFER, storage[0]);
    gl_.RenderbufferStorage(GL_RENDERBUFFER, colour, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, storage[0]);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, storage[1]);
    gl_.RenderbufferStorage(GL_RENDERBUFFER, depth, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, depth_attachment, GL_RENDERBUFFER, storage[1]);
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw RenderError("framebuffer of " + std::to_string(width) + "x" + std::to_string(height) +
                        " refused");
    }
    return target;
  }

  GLuint MakeTexture(GLenum format, GLenum layout, int width, int height,
                     const std::vector<float>& data) {
    GLuint name = 0;
    gl_.GenTextures(1, &name);
    gl_.BindTexture(GL_TEXTURE_2D, name);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, layout, GL_FLOAT,
                   data.data());
    return name;
  }

  Lens MakeLens(const CameraModel& camera) {
    Lens lens;
    lens.camera = camera;
    lens.projection = Projection(camera);
    if (camera.distortion.none()) return lens;
    std::vector<float> map;
    std::vector<float> slope;
    const std::size_t pixels = static_cast<std::size_t>(camera.width) * camera.height;
    map.reserve(2 * pixels);
    slope.reserve(4 * pixels);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Vector2d n = ToNormalised(camera, {u, v});
        const Eigen::Matrix2d J = PixelJacobian(camera, n).inverse();
        for (const double value : {n.x(), n.y()}) map.push_back(static_cast<float>(value));
        for (const double value : {J(0, 0), J(0, 1), J(1, 0), J(1, 1)}) {
          slope.push_back(static_cast<float>(value));
        }
      }
    }
    lens.map = MakeTexture(GL_RG32F, GL_RG, camera.width, camera.height, map);
    lens.slope = MakeTexture(GL_RGBA32F, GL_RGBA, camera.width, camera.height, slope);
    return lens;
  }

  // The driver compiles machine code at the first draw of each kind: have that behind us.
  void WarmUp() {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;  // Looks down.
    SceneState state;
    GreyImage image;
    for (const double height : {1.0, 4.0}) {
      X_WC.translation() = Vector3d(0.0, 0.0, scene_.floor.height + height);
      RenderGrey(X_WC, state, nullptr, &image);
      const std::vector<PixelWindow> windows{
          {0, 0, native_.camera.width / 2, native_.camera.height}};
      RenderGrey(X_WC, state, &windows, &image);
    }
    const GLenum error = gl_.GetError();
    if (error != GL_NO_ERROR) {
      throw RenderError("OpenGL error " + std::to_string(error) + " while warming up");
    }
  }

  // --- one image ----------------------------------------------------------------------------------

  void Begin(const Target& target, const Isometry3d& X_WC, const SceneState& state,
             const Lens& lens) {
    context_->MakeCurrent();
    lens_ = &lens;
    X_CW_ = X_WC.inverse();
    X_WC_ = X_WC;
    state_ = &state;
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl_.Viewport(0, 0, target.width, target.height);
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.DepthMask(GL_TRUE);
    if (bent_) {
      gl_.ActiveTexture(GL_TEXTURE0);
      gl_.BindTexture(GL_TEXTURE_2D, lens.map);
      gl_.ActiveTexture(GL_TEXTURE1);
      gl_.BindTexture(GL_TEXTURE_2D, lens.slope);
    }
    PlaceMarkers();
  }

  [[nodiscard]] bool FloorSeen() const {
    return scene_.floor.visible && X_WC_.translation().z() > scene_.floor.height + 1e-3;
  }

  // The bodies of a grey image, for all its passes.
  void PlaceBodies(const std::vector<PixelWindow>& passes) {
    bounds_.clear();
    for (const PixelWindow& pass : passes) bounds_.push_back(BoundRays(lens_->camera, pass));
    if (visible_->vertex_count() == 0) return;
    gl_.BindBuffer(GL_ARRAY_BUFFER, lit_vertices_);
    void* const memory = gl_.MapBufferRange(
        GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(visible_->vertex_count() * sizeof(LitVertex)),
        GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
    if (memory == nullptr) throw RenderError("no memory for the vertices of an image");
    visible_->Place(X_CW_, *state_, bounds_, static_cast<LitVertex*>(memory));
    gl_.UnmapBuffer(GL_ARRAY_BUFFER);
  }

  void DrawLitBodies(const RayBounds& bounds) {
    const std::size_t count = visible_->Select(bounds, &indices_);
    if (count == 0) return;
    gl_.Enable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    gl_.Disable(GL_BLEND);
    gl_.UseProgram(lit_.name);
    SetLens(lit_);
    gl_.BindVertexArray(lit_array_);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(count * sizeof(std::uint32_t)),
                   indices_.data(), GL_STREAM_DRAW);
    gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT, nullptr);
  }

  void DrawGrey(const PixelWindow& window, const RayBounds& bounds, bool scissored) {
    if (scissored) {
      gl_.Enable(GL_SCISSOR_TEST);
      gl_.Scissor(window.u, window.v, window.width, window.height);
    }
    gl_.DepthMask(GL_TRUE);
    gl_.ClearColor(scene_.background, 0.0F, 0.0F, 1.0F);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (FloorSeen()) DrawTiles(bounds);
    DrawLitBodies(bounds);
    DrawMarkers(MarkerLook::kGrey, window);
  }

  void SetTiles(const Program& program) {
    const std::array<float, 4> tiles{static_cast<float>(1.0 / scene_.floor.tile), scene_.background,
                                     scene_.floor.contrast, kTileFading};
    gl_.Uniform4fv(program.tiles, 1, tiles.data());
  }

  // The floor comes first and without depth: nothing of a scene lies below it.
  void DrawTiles(const RayBounds& bounds) {
    const IndexRange seen = bent_ ? IndexRange{0, static_cast<std::size_t>(floor_.indices)}
                                  : TilesSeen(scene_.floor, X_WC_, bounds);
    if (seen.count == 0) return;
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    gl_.Disable(GL_BLEND);
    gl_.UseProgram(tile_.name);
    SetLens(tile_);
    SetTiles(tile_);
    const Matrix4f world_to_camera = X_CW_.matrix().cast<float>();
    gl_.UniformMatrix4fv(tile_.body_to_camera, 1, GL_FALSE, world_to_camera.data());
    gl_.BindVertexArray(floor_.vertex_array);
    gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(seen.count), GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(seen.first * sizeof(std::uint32_t)));
  }

  void DrawBackdrop() {
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    gl_.Disable(GL_BLEND);
    gl_.UseProgram(backdrop_.name);
    Matrix3d rays = X_WC_.linear();
    if (!bent_) {
      Matrix3d K = Matrix3d::Identity();
      K.topLeftCorner<2, 2>() = CalibrationJacobian(lens_->camera);
      K.topRightCorner<2, 1>() << lens_->camera.u0, lens_->camera.v0;
      rays = rays * K.inverse();
    }
    const Matrix3f pixel_to_ray = rays.cast<float>();
    Vector3f eye = X_WC_.translation().cast<float>();
    // Without a floor in view everything is background: rays never meet a floor infinitely far down.
    eye.z() =
        FloorSeen() ? static_cast<float>(X_WC_.translation().z() - scene_.floor.height) : 1e9F;
    gl_.UniformMatrix3fv(backdrop_.pixel_to_ray, 1, GL_FALSE, pixel_to_ray.data());
    gl_.Uniform3fv(backdrop_.eye, 1, eye.data());
    SetTiles(backdrop_);
    gl_.BindVertexArray(empty_array_);
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  }

  void SetLens(const Program& program) {
    gl_.UniformMatrix4fv(program.projection, 1, GL_FALSE, lens_->projection.data());
    if (!bent_) return;
    const Distortion& d = lens_->camera.distortion;
    const std::array<float, 4> radial{static_cast<float>(d.k1), static_cast<float>(d.k2),
                                      static_cast<float>(d.k3),
                                      static_cast<float>(trusted_radius2_)};
    const std::array<float, 2> tangential{static_cast<float>(d.p1), static_cast<float>(d.p2)};
    gl_.Uniform4fv(program.radial, 1, radial.data());
    gl_.Uniform2fv(program.tangential, 1, tangential.data());
  }

  void DrawBodies(const Program& program, const RayBounds& bounds, Material material) {
    gl_.Enable(GL_DEPTH_TEST);
    gl_.Enable(GL_CULL_FACE);
    gl_.Disable(GL_BLEND);
    gl_.DepthMask(GL_TRUE);
    gl_.UseProgram(program.name);
    SetLens(program);
    gl_.Uniform1f(program.ambient, scene_.light.ambient);
    const Vector3d light_W = scene_.light.direction_W.cast<double>().normalized();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = scene_.bodies[i];
      const Isometry3d X_WB = FramePose(*state_, body.frame);
      const Isometry3d X_CB = X_CW_ * X_WB;
      const MeshBuffers& buffers = bodies_[i];
      if (!SphereMeets(bounds, X_CB * buffers.bound.centre, buffers.bound.radius)) continue;
      const Matrix4f body_to_camera = X_CB.matrix().cast<float>();
      const Vector3f light = (X_WB.linear().transpose() * light_W).cast<float>();
      const Vector3f up = X_WB.linear().row(2).cast<float>();
      gl_.UniformMatrix4fv(program.body_to_camera, 1, GL_FALSE, body_to_camera.data());
      gl_.Uniform3fv(program.light, 1, light.data());
      gl_.Uniform3fv(program.up, 1, up.data());
      if (material == Material::kId) {
        gl_.Uniform1ui(program.id, kIdBody + static_cast<GLuint>(i));
      } else {
        Eigen::Vector4f surface;
        surface << body.colour, body.gloss;
        gl_.Uniform4fv(program.surface, 1, surface.data());
      }
      if (material == Material::kColour) {
        const Vector3f eye = X_CB.inverse().translation().cast<float>();
        gl_.Uniform3fv(program.eye, 1, eye.data());
      }
      gl_.BindVertexArray(buffers.vertex_array);
      gl_.DrawElements(GL_TRIANGLES, buffers.indices, GL_UNSIGNED_INT, nullptr);
    }
  }

  // Bodies flattened onto the floor along the light, each pixel darkened once.
  void DrawShadows() {
    const Vector3d light = scene_.light.direction_W.cast<double>();
    if (light.z() <= 0.05) return;
    Eigen::Matrix4d flatten = Eigen::Matrix4d::Identity();
    flatten.block<2, 1>(0, 2) = -light.head<2>() / light.z();
    flatten.block<2, 1>(0, 3) = scene_.floor.height * light.head<2>() / light.z();
    flatten(2, 2) = 0.0;
    flatten(2, 3) = scene_.floor.height;
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    gl_.Enable(GL_BLEND);
    gl_.Enable(GL_STENCIL_TEST);
    gl_.UseProgram(shadow_.name);
    SetLens(shadow_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Isometry3d X_WB = FramePose(*state_, scene_.bodies[i].frame);
      const Matrix4f body_to_camera = (X_CW_.matrix() * flatten * X_WB.matrix()).cast<float>();
      gl_.UniformMatrix4fv(shadow_.body_to_camera, 1, GL_FALSE, body_to_camera.data());
      gl_.BindVertexArray(bodies_[i].vertex_array);
      gl_.DrawElements(GL_TRIANGLES, bodies_[i].indices, GL_UNSIGNED_INT, nullptr);
    }
    gl_.Disable(GL_STENCIL_TEST);
  }

  // Markers seen from their front, far ones first, so that near ones cover them.
  void PlaceMarkers() {
    placed_.clear();
    for (std::size_t i = 0; i < scene_.markers.size(); ++i) {
      const SceneMarker& marker = scene_.markers[i];
      const Isometry3d X_WF = FramePose(*state_, marker.frame);
      std::optional<MarkerQuad> quad = PlaceMarker(lens_->camera, X_CW_ * X_WF, marker.marker,
                                                   marker.plate ? kPlateRadii : kRingRadii);
      if (!quad) continue;
      quad->index = static_cast<int>(i);
      const double lift =
          MarkerLift(scene_.capsules, *state_, X_WF * marker.marker.p, X_WC_.translation()) +
          2.0 * marker.marker.radius * (1.0 - 0.9 * quad->cos_incidence);
      quad->lift = std::min(lift, 0.9 * (quad->depth - kNear));
      placed_.push_back(*quad);
    }
    std::stable_sort(placed_.begin(), placed_.end(),
                     [](const MarkerQuad& a, const MarkerQuad& b) { return a.depth > b.depth; });
  }

  void DrawMarkers(MarkerLook look, const PixelWindow& window) {
    vertices_.clear();
    for (const MarkerQuad& quad : placed_) {
      if (quad.bounds.overlaps(window)) AppendVertices(quad, look == MarkerLook::kGrey);
    }
    if (vertices_.empty()) return;
    gl_.Enable(GL_DEPTH_TEST);
    gl_.Disable(GL_CULL_FACE);
    if (look == MarkerLook::kId) {
      gl_.Disable(GL_BLEND);
      gl_.UseProgram(marker_id_.name);
    } else {
      gl_.Enable(GL_BLEND);
      gl_.DepthMask(GL_FALSE);
      gl_.UseProgram(marker_.name);
    }
    gl_.BindVertexArray(marker_array_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, marker_buffer_);
    gl_.BufferData(GL_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(vertices_.size() * sizeof(MarkerVertex)),
                   vertices_.data(), GL_STREAM_DRAW);
    gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
  }

  void AppendVertices(const MarkerQuad& quad, bool with_face) {
    MarkerVertex vertex{};
    const Marker& marker = scene_.markers[quad.index].marker;
    const std::optional<Vector3f>& plate = scene_.markers[quad.index].plate;
    for (int k = 0; k < 3; ++k) {
      vertex.row_s[k] = static_cast<float>(quad.to_plane(0, k));
      vertex.row_t[k] = static_cast<float>(quad.to_plane(1, k));
      vertex.row_w[k] = static_cast<float>(quad.to_plane(2, k));
    }
    vertex.reference_levels[0] = static_cast<float>(quad.reference.x());
    vertex.reference_levels[1] = static_cast<float>(quad.reference.y());
    vertex.reference_levels[2] = marker.dark ? scene_.dark : scene_.bright;
    vertex.reference_levels[3] = marker.dark ? scene_.bright : scene_.dark;
    vertex.index = static_cast<float>(quad.index);
    if (with_face && plate) {
      const Isometry3d X_WF = FramePose(*state_, scene_.markers[quad.index].frame);
      vertex.plate[0] = static_cast<float>(kPlateRadii);
      vertex.plate[1] = Brightness(scene_.light, *plate, X_WF.linear() * marker.normal);
    } else {
      vertex.plate[1] = vertex.reference_levels[3];  // The ring's: no other shines through.
    }
    const double nearer = kDepthScale * (1.0 / (quad.depth - quad.lift) - 1.0 / quad.depth);
    const PixelWindow& box = quad.bounds;
    for (const auto& [i, j] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) {
      const Vector2d pixel(box.u - 0.5 + i * box.width, box.v - 0.5 + j * box.height);
      const Vector2d n = ToNormalised(lens_->camera, pixel);
      vertex.corner[0] = static_cast<float>(2.0 * (pixel.x() + 0.5) / lens_->camera.width - 1.0);
      vertex.corner[1] = static_cast<float>(2.0 * (pixel.y() + 0.5) / lens_->camera.height - 1.0);
      const double inverse_depth = quad.inverse_depth.dot(n.homogeneous());
      vertex.corner[2] = static_cast<float>(kDepthOffset + kDepthScale * inverse_depth + nearer);
      vertices_.push_back(vertex);
    }
  }

  void ReadGrey(const PixelWindow& window, GreyImage* image) {
    gl_.PixelStorei(GL_PACK_ROW_LENGTH, image->width);
    gl_.ReadPixels(window.u, window.v, window.width, window.height, GL_RED, GL_UNSIGNED_BYTE,
                   image->at(window.u, window.v));
    gl_.PixelStorei(GL_PACK_ROW_LENGTH, 0);
  }

  void ReadColour(ColourImage* image) {
    readback_.resize(static_cast<std::size_t>(colour_.width) * colour_.height * 4);
    gl_.ReadPixels(0, 0, colour_.width, colour_.height, GL_RGBA, GL_UNSIGNED_BYTE,
                   readback_.data());
    image->Resize(native_.camera.width, native_.camera.height);
    constexpr int kSamples = kSupersampling * kSupersampling;
    for (int v = 0; v < image->height; ++v) {
      for (int u = 0; u < image->width; ++u) {
        std::array<int, 3> sum{};
        for (int j = 0; j < kSupersampling; ++j) {
          const std::size_t row = static_cast<std::size_t>(kSupersampling * v + j) * colour_.width;
          for (int i = 0; i < kSupersampling; ++i) {
            const std::uint8_t* sample = &readback_[4 * (row + kSupersampling * u + i)];
            for (int k = 0; k < 3; ++k) sum[k] += sample[k];
          }
        }
        std::uint8_t* pixel = image->at(u, v);
        for (int k = 0; k < 3; ++k) {
          pixel[k] = static_cast<std::uint8_t>((sum[k] + kSamples / 2) / kSamples);
        }
      }
    }
  }

  // Depth buffer values to metres, and the floor where nothing else is.
  void FinishDepth(IdImage* ids, DepthImage* depth) {
    const float infinity = std::numeric_limits<float>::infinity();
    for (int v = 0; v < depth->height; ++v) {
      for (int u = 0; u < depth->width; ++u) {
        float* const z = depth->at(u, v);
        const double ndc = 2.0 * *z - 1.0;
        *z = *ids->at(u, v) == kIdBackground
                 ? infinity
                 : static_cast<float>(kDepthScale / (ndc - kDepthOffset));
        if (*ids->at(u, v) != kIdBackground || !FloorSeen()) continue;
        const Vector3d ray_W =
            X_WC_.linear() * ToNormalised(native_.camera, Vector2d(u, v)).homogeneous();
        const double floor = (scene_.floor.height - X_WC_.translation().z()) / ray_W.z();
        if (floor > 0.0) {
          *z = static_cast<float>(floor);
          *ids->at(u, v) = kIdFloor;
        }
      }
    }
  }

  std::unique_ptr<GlContext> context_;
  Scene scene_;
  GlFunctions gl_;
  bool bent_{false};
  double trusted_radius2_{1.0};
  Lens native_, fine_;
  Program lit_, mesh_colour_, mesh_id_, shadow_, tile_, backdrop_, marker_, marker_id_;
  std::vector<MeshBuffers> bodies_;
  std::optional<VisibleTriangles> visible_;
  GLuint lit_array_{0}, lit_vertices_{0}, lit_indices_{0};
  MeshBuffers floor_;
  GLuint marker_array_{0}, marker_buffer_{0}, empty_array_{0};
  Target grey_, colour_, ids_;

  // Of the image being drawn.
  const Lens* lens_{nullptr};
  const SceneState* state_{nullptr};
  Isometry3d X_WC_{Isometry3d::Identity()}, X_CW_{Isometry3d::Identity()};
  std::vector<RayBounds> bounds_;  // Of each pass.
  std::vector<std::uint32_t> indices_;
  std::vector<MarkerQuad> placed_;
  std::vector<MarkerVertex> vertices_;
  std::vector<std::uint8_t> readback_;
};

Renderer::Renderer(std::unique_ptr<GlContext> context, const CameraModel& camera, Scene scene)
    : impl_(std::make_unique<Impl>(std::move(context), camera, std::move(scene))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const CameraModel& Renderer::camera() const noexcept {
  return impl_->camera();
}

void Renderer::RenderGrey(const Isometry3d& X_WC, const SceneState& state, GreyImage* image) {
  impl_->RenderGrey(X_WC, state, nullptr, image);
}

void Renderer::RenderGrey(const Isometry3d& X_WC, const SceneState& state,
                          const std::vector<PixelWindow>& windows, GreyImage* image) {
  impl_->RenderGrey(X_WC, state, &windows, image);
}

void Renderer::RenderColour(const Isometry3d& X_WC, const SceneState& state, ColourImage* image) {
  impl_->RenderColour(X_WC, state, image);
}

void Renderer::RenderIds(const Isometry3d& X_WC, const SceneState& state, IdImage* ids,
                         DepthImage* depth) {
  impl_->RenderIds(X_WC, state, ids, depth);
}

}  // namespace vantage::sim
