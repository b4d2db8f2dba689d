#pragma once

/// @file
/// What the batch evaluator hands to its SIMD kernels: plain pointers and numbers. The translation units
/// that hold the kernels are compiled for instruction sets that the machine may lack, so nothing here,
/// and nothing they include, may bring inline code that the linker could choose for the rest of the
/// program: no Eigen and no containers.

namespace vantage::batch {

/// Arrays are padded to a multiple of this many entries; every register holds a divisor of it.
inline constexpr int kPadding = 16;

/// Most points, rows and columns of one Jacobian.
inline constexpr int kMaxBatchPoints = 16;
inline constexpr int kMaxBatchRows = 16;
inline constexpr int kMaxBatchColumns = 16;
/// Most boxes among the obstacles.
inline constexpr int kMaxBatchBoxes = 16;

/// Coordinates of one camera: the rows of R_CW (camera axes in the world), the centre, the zoom.
inline constexpr int kCameraFields = 13;
inline constexpr int kZoomField = 12;

/// Closed form that serves a scene's Jacobians. The records that follow are what one sample holds for it;
/// vectors are in the world, d_i = P_i - c.
enum class Family : int {
  /// Rows x1, y1, x2 and any n: u = m0 - M c [9 of M without its last, m0], P1, P2; then, for more than
  /// three columns, adj(A1) with adj(A1) P1 and the further columns of A2.
  kTriple,
  /// Rows x1, y1 and n >= 2: P1, adj(A1), adj(A1) P1.
  kPair,
  /// Both rows of 3 or more points of one body and n >= 6: P1, P_i - P1, w_r.
  kRigidSix,
  /// Anything else: for each point P, then A (3×columns, row by row).
  kGeneric,
};

/// What is computed of each Jacobian.
enum class Quantity : int { kW, kLogW, kSigmaMin, kInverseCondition, kNegativeTrace };

/// Rows of the image: point index and axis (0: x, 1: y).
struct Row {
  int point;
  int axis;
};

/// Points whose least and largest depths and image coordinates are those of the whole motion, as chains:
/// nodes, and between neighbouring nodes some points near the straight line from one to the other. What is
/// concave in the position is there at least the lesser of its values at the nodes, less its steepness
/// times the distance to the line.
template <class T>
struct Chain {
  T sag;             ///< Largest distance of the points between to the line.
  int first, count;  ///< Points between, in `xyz`.
};
template <class T>
struct HullView {
  const T* node;  ///< 3 entries a node.
  int nodes;
  const Chain<T>* chain;  ///< chain[i] lies between nodes i and i + 1; none may (count 0).
  const T* xyz;           ///< 3 entries a point between.
  T sag;                  ///< Largest of all.
  T min_depth, max_depth;
  T least_image;  ///< Image margin that counts as 0.
};

template <class T>
struct SceneView {
  Family family;
  int samples;  ///< N.
  int points;   ///< p.
  int rows;     ///< k.
  int columns;  ///< n after reduction (0 for kRigidSix).
  int fields;   ///< Entries of one record.
  Row row[kMaxBatchRows];
  const T* record;    ///< N records one after the other.
  const T* lanes;     ///< The same, field by field: `fields` arrays of `padded` entries.
  int padded;         ///< N rounded up to kPadding; the rest repeats the last sample.
  const T* weight;    ///< `padded` entries; 0 behind N.
  const T* weighted;  ///< kTriple with three columns: records whose value is scaled by the weight.
  T min_depth;        ///< Points nearer than this count as behind the camera.
  HullView<T> hull;   ///< Of the points; its limits are not used.
};

template <class T>
struct CamerasView {
  const T* field[kCameraFields];  ///< Readable up to the next multiple of kPadding.
  int count;
};

/// Intrinsics that all cameras share; the zoom of each multiplies them.
template <class T>
struct Lens {
  T aspect;         ///< fx / fy.
  T shear;          ///< skew / fy.
  T x_mid, x_half;  ///< Image in normalised coordinates at zoom 1.
  T y_mid, y_half;
};

/// A marker at one sample and the capsules that may hide it.
template <class T>
struct Sight {
  T p[3];
  T normal[3];
  int first_capsule, capsules;
};

/// A capsule seen from a marker P: axis direction u, length; e = (P - A) without its part along u.
template <class T>
struct CapsuleTest {
  T u[3];
  T e[3];
  T e2;                         ///< |e|².
  T before, after;              ///< Coordinate along u of the axis' ends, counted from P.
  T half_radius, half_inverse;  ///< r / 2 and 1 / (2 r).
};

/// A box that stands in the world: coordinates in its frame are B (p - centre).
template <class T>
struct BoxTest {
  T b[9];
  T centre[3];
  T half[3];
};

template <class T>
struct ObstaclesView {
  const Sight<T>* sight;
  int sights;
  const CapsuleTest<T>* capsule;
  const BoxTest<T>* box;
  int boxes;
  bool facing;
  T min_cosine;  ///< Of the angle between a marker's normal and the ray to the camera.
};

/// Per camera, `count` rounded up to kPadding entries each.
template <class T>
struct ValueOutput {
  T* sum;    ///< Σ weight · quantity.
  T* least;  ///< Least quantity.
};
template <class T>
struct FrustumOutput {
  T* near;
  T* far;
  T* image;
};
template <class T>
struct ObstacleOutput {
  T* occlusion;
  T* facing;
};

/// One camera: `padded` entries of w, and 6 · padded of its derivatives by the camera's twist.
template <class T>
struct ProfileOutput {
  T* w;
  T* gradient;  ///< May be null.
};

template <class T>
struct Kernels {
  int lanes;
  void (*value)(const SceneView<T>&, const CamerasView<T>&, const Lens<T>&, Quantity,
                const ValueOutput<T>&);
  void (*frustum)(const HullView<T>&, const CamerasView<T>&, const Lens<T>&,
                  const FrustumOutput<T>&);
  void (*obstacles)(const ObstaclesView<T>&, const CamerasView<T>&, const ObstacleOutput<T>&);
  /// kGeneric has no gradient here: out.gradient must be null.
  void (*profile)(const SceneView<T>&, const CamerasView<T>&, const Lens<T>&,
                  const ProfileOutput<T>&);
};

struct KernelTable {
  Kernels<double> f64;
  Kernels<float> f32;
};

/// One table per instruction set that the program was built for.
const KernelTable& BaselineKernels();
#ifdef VANTAGE_BATCH_X86
const KernelTable& Avx2Kernels();
const KernelTable& Avx512Kernels();
#endif

}  // namespace vantage::batch
