#pragma once

/// @file
/// GLSL sources of the renderer's programs: one short program a material. Each is compiled with one
/// line before it: "#version 330 core", and "#define BENT_LENS" for cameras with distortion.
///
/// Rows of the framebuffer are rows of the image from the top, so that nothing has to be flipped when
/// it is read: gl_FragCoord.xy - 0.5 are the pixel coordinates (u, v).

namespace vantage::sim::shaders {

// What all stages need of the lens. lens_map holds for each pixel the ideal ray (x, y) and lens_slope
// the derivative of (x, y) by (u, v).
inline constexpr const char* kLens = R"glsl(
#ifdef BENT_LENS
uniform sampler2D lens_map;
uniform sampler2D lens_slope;
#endif
)glsl";

// The lens's distortion of a point in the camera's frame.
inline constexpr const char* kBend = R"glsl(
#ifdef BENT_LENS
uniform vec4 radial;          // k1, k2, k3, largest r² at which the polynomial is trusted.
uniform vec2 tangential;      // p1, p2.
vec3 Bend(vec3 p) {
  vec2 n = p.xy / max(p.z, 1e-3);
  float excess = sqrt(max(1.0, dot(n, n) / radial.w));  // Go straight on beyond the trusted radius.
  vec2 m = n / excess;
  float r2 = dot(m, m);
  float gain = 1.0 + r2 * (radial.x + r2 * (radial.y + r2 * radial.z));
  vec2 bent = m * gain + vec2(2.0 * tangential.x * m.x * m.y + tangential.y * (r2 + 2.0 * m.x * m.x),
                              tangential.x * (r2 + 2.0 * m.y * m.y) + 2.0 * tangential.y * m.x * m.y);
  return p.z > 1e-3 ? vec3(bent * excess * p.z, p.z) : p;
}
#endif
)glsl";

// Bodies of grey images come placed and lit (visible_triangles.h).
inline constexpr const char* kLitVertex = R"glsl(
layout(location = 0) in vec3 position;  // In the camera's frame.
layout(location = 1) in float level;
uniform mat4 projection;                // Camera frame to clip space.
out float brightness;
void main() {
  vec4 p = vec4(position, 1.0);
#ifdef BENT_LENS
  p.xyz = Bend(p.xyz);
#endif
  gl_Position = projection * p;
  brightness = level;
}
)glsl";

inline constexpr const char* kMeshVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 projection;      // Camera frame to clip space.
uniform mat4 body_to_camera;
#ifdef SMOOTH_LIGHT
out vec3 surface_normal;
out vec3 surface_point;
#elif defined(TILE)
uniform vec4 tiles;           // 1 / tile, background, contrast, fading.
flat out float brightness;
#endif
void main() {
  vec4 p = body_to_camera * vec4(position, 1.0);
#ifdef BENT_LENS
  p.xyz = Bend(p.xyz);
#endif
  gl_Position = projection * p;
#ifdef SMOOTH_LIGHT
  surface_normal = normal;
  surface_point = position;
#elif defined(TILE)
  brightness = tiles.y - tiles.z / (1.0 + tiles.w * p.z * p.z);
#endif
}
)glsl";

inline constexpr const char* kLitFragment = R"glsl(
in float brightness;
out vec4 colour;
void main() { colour = vec4(brightness); }
)glsl";

inline constexpr const char* kMeshColourFragment = R"glsl(
in vec3 surface_normal;
in vec3 surface_point;
uniform vec3 light;           // Towards the light, in the body's frame.
uniform vec3 up;              // World's z, in the body's frame.
uniform vec3 eye;             // Camera, in the body's frame.
uniform vec4 surface;         // Colour, gloss.
uniform float ambient;
out vec4 colour;
void main() {
  vec3 n = normalize(surface_normal);
  vec3 to_eye = normalize(eye - surface_point);
  float sky = 0.8 + 0.2 * dot(n, up);
  float direct = max(0.0, dot(n, light));
  float highlight = pow(max(0.0, dot(n, normalize(light + to_eye))), 48.0) * step(0.0, dot(n, light));
  float rim = pow(1.0 - max(0.0, dot(n, to_eye)), 4.0);
  vec3 lit = surface.rgb * (ambient * sky + (1.0 - ambient) * direct);
  colour = vec4(lit + surface.a * (0.9 * highlight + 0.12 * rim), 1.0);
}
)glsl";

inline constexpr const char* kMeshIdFragment = R"glsl(
uniform uint id;
out uint value;
void main() { value = id; }
)glsl";

inline constexpr const char* kShadowFragment = R"glsl(
out vec4 colour;
void main() { colour = vec4(0.0, 0.0, 0.0, 0.32); }
)glsl";

// What lies behind everything in colour images: one triangle that covers the image.
inline constexpr const char* kBackdropVertex = R"glsl(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)glsl";

inline constexpr const char* kBackdropFragment = R"glsl(
uniform mat3 pixel_to_ray;    // Pixel (with a lens: ideal ray) to a ray with camera depth 1, in W.
uniform vec3 eye;             // Camera in W, z above the floor.
uniform vec4 tiles;           // 1 / tile, background, contrast, fading.
out vec4 colour;
void main() {
  vec2 at = gl_FragCoord.xy - 0.5;
#ifdef BENT_LENS
  at = texelFetch(lens_map, ivec2(gl_FragCoord.xy), 0).xy;
#endif
  vec3 ray = pixel_to_ray * vec3(at, 1.0);
  float depth = -eye.z / ray.z;
  vec2 cell = fract((eye.xy + depth * ray.xy) * tiles.x * 0.5) - 0.5;
  float fade = 1.0 / (1.0 + tiles.w * depth * depth);
  float level = tiles.y - (cell.x * cell.y > 0.0 && depth > 0.0 ? tiles.z * fade : 0.0);
  float far = depth > 0.0 ? 1.0 - fade : 1.0;
  float height = clamp(normalize(ray).z, 0.0, 1.0);
  vec3 haze = mix(vec3(0.66, 0.70, 0.74), vec3(0.40, 0.47, 0.56), sqrt(height));
  colour = vec4(mix(level * vec3(1.03, 1.06, 1.10), haze, far * far), 1.0);
}
)glsl";

// Of grey images: the dark tiles as flat squares on the cleared background. A ray or a brightness for
// each pixel would cost more than all the rest of the image.
inline constexpr const char* kTileFragment = R"glsl(
flat in float brightness;
out vec4 colour;
void main() { colour = vec4(brightness); }
)glsl";

inline constexpr const char* kMarkerVertex = R"glsl(
layout(location = 0) in vec3 corner;         // In normalised device coordinates.
layout(location = 1) in vec3 row_s;          // Rows of the map from the pixel (with a lens: ideal ray)
layout(location = 2) in vec3 row_t;          // less `reference` to the marker's plane, in units of the
layout(location = 3) in vec3 row_w;          // disc's radius, homogeneous.
layout(location = 4) in vec4 reference_levels;  // Reference point, brightness of disc and ring.
layout(location = 5) in float marker;        // Index.
layout(location = 6) in vec2 face;           // Radius in the disc's radii, brightness.
flat out vec3 to_s;
flat out vec3 to_t;
flat out vec3 to_w;
flat out vec4 frame;
flat out float index;
flat out vec2 plate;
void main() {
  gl_Position = vec4(corner, 1.0);
  to_s = row_s;
  to_t = row_t;
  to_w = row_w;
  frame = reference_levels;
  index = marker;
  plate = face;
}
)glsl";

// Radius in the marker's plane as a function of the pixel: edges are where it is 1 (disc), 2 (ring) and, with a plate, plate.x.
// p = (s, t) / w with rows (s, t, w) times the pixel. Its gradient is (s' p.x + t' p.y - w' p.p) / (w radius), and one pixel
// covers det / w³ of the plane.
inline constexpr const char* kMarkerRadius = R"glsl(
flat in vec3 to_s;
flat in vec3 to_t;
flat in vec3 to_w;
flat in vec4 frame;
flat in float index;
// slope: the gradient times w and the radius; stretch: the area times w³.
float Radius(out float w, out vec2 slope, out float stretch) {
  vec2 at = gl_FragCoord.xy - 0.5;
#ifdef BENT_LENS
  vec4 bend = texelFetch(lens_slope, ivec2(gl_FragCoord.xy), 0);  // dx/du, dx/dv, dy/du, dy/dv.
  at = texelFetch(lens_map, ivec2(gl_FragCoord.xy), 0).xy;
#endif
  vec3 x = vec3(at - frame.xy, 1.0);
  w = dot(to_w, x);
  vec2 p = vec2(dot(to_s, x), dot(to_t, x)) / w;
  float squared = dot(p, p);
  slope = p.x * to_s.xy + p.y * to_t.xy - squared * to_w.xy;
  stretch = dot(cross(to_s, to_t), to_w);
#ifdef BENT_LENS
  slope = vec2(dot(slope, bend.xz), dot(slope, bend.yw));
  stretch *= bend.x * bend.w - bend.y * bend.z;
#endif
  return max(sqrt(squared), 1e-5);
}
)glsl";

inline constexpr const char* kMarkerFragment = R"glsl(
flat in vec2 plate;
out vec4 colour;
// Share of a pixel's square on the inner side of an edge that is straight there.
// inside: the edge's radius less that at the pixel's centre; slope: absolute components of the radius's gradient, larger first.
// All may be multiplied by one number.
float Coverage(float inside, vec2 slope) {
  float d = abs(inside);
  float corner = max(0.0, 0.5 * (slope.x + slope.y) - d);
  float share = d <= 0.5 * (slope.x - slope.y) ? 0.5 + d / slope.x
                                               : 1.0 - corner * corner / (2.0 * slope.x * slope.y);
  return inside < 0.0 ? 1.0 - share : share;
}
void main() {
  float w;
  vec2 slope;
  float stretch;
  float radius = Radius(w, slope, stretch);
  float scale = abs(w) * radius;
  slope = max(abs(slope), 1e-9);
  // A round edge covers less of a pixel than its tangent does: by stretch² / gradient³ / 24 of a pixel on the average.
  float inset = stretch * stretch * radius * radius / (24.0 * dot(slope, slope) * w * w * w * w);
  slope = slope.x > slope.y ? slope : slope.yx;
  float disc = Coverage(scale * (1.0 - radius - inset), slope);
  float ring = Coverage(scale * (2.0 - radius), slope);
  // The plate's edge is sharp: what is behind the face may not shine through between it and the rim.
  float all = radius <= plate.x ? 1.0 : ring;
  colour = vec4(vec3(mix(plate.y, mix(frame.w, frame.z, disc), ring)), all);
}
)glsl";

inline constexpr const char* kMarkerIdFragment = R"glsl(
out uint value;
void main() {
  float w;
  vec2 slope;
  float stretch;
  float radius = Radius(w, slope, stretch);
  if (radius > 2.0) discard;
  value = (radius <= 1.0 ? 10000u : 20000u) + uint(index + 0.5);
}
)glsl";

}  // namespace vantage::sim::shaders
