#pragma once

#include <vector>

#include "oracle_file.h"
#include "vantage/math/angles.h"
#include "vantage/observability/paper_product.h"

/// @file
/// The paper's two examples: arms, points and cameras of sections 6 and 7.

namespace vantage::test {

/// Spherical coordinates of a camera about the origin.
struct Sphere {
  double R;
  double theta;
  double phi;
  double roll{0.0};
};

/// Section 6: planar arm with theta1 measured from +Y towards +X, P = (l1 s1 + l2 s12, l1 c1 + l2 c12).
[[nodiscard]] ArmModel PlanarArm(double l1, double l2);

/// Section 7, Fig. 5: waist, shoulder and elbow; P = (c1 r, s1 r, h + l2 s2 + l3 s23).
[[nodiscard]] ArmModel SimplePuma(double l2, double l3, double h);

/// The first three joints of the PUMA 560 up to its wrist centre, d1 = 0.
[[nodiscard]] ArmModel Puma560ToWrist(double a2, double a3, double d3, double d4);

/// Features x1, y1 of the point P (E's origin): the planar arm's.
[[nodiscard]] OracleCase PointCell(const ArmModel& arm, RigOrientation orientation, double f);

/// Two points, P1 = E's origin and P2, and the features (x1, y1, x2), or all four coordinates.
[[nodiscard]] OracleCase TwoPointCell(const ArmModel& arm, const Eigen::Vector3d& p_EP2, double f,
                                      bool all_four = false);

/// The cell with its arm at q and its camera at the given place.
[[nodiscard]] Evaluated At(OracleCase cell, const JointVector& q, const Sphere& camera);

/// {a, b, ...} as joint values.
[[nodiscard]] JointVector Joints(std::initializer_list<double> values);

/// n values from a to b.
[[nodiscard]] std::vector<double> Linspace(double a, double b, int n);

/// Trapezoid rule over equally spaced samples.
[[nodiscard]] double Trapezoid(const std::vector<double>& values, double step);

/// The translation-only product of an evaluated cell.
[[nodiscard]] PaperProduct ProductOf(const Evaluated& e, int dimension);

}  // namespace vantage::test
