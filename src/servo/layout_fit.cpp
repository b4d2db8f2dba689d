#include "vantage/servo/layout_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace vantage {
namespace {

// The first pass weighs all points alike, as if at this depth [m].
constexpr double kFirstDepth = 1.0;
// Nothing is known of the translation beforehand [m].
constexpr double kAnywhere = 1e3;

}  // namespace

LayoutFit FitLayout(const std::array<LayoutPoint, kMaxPoints>& points, int count,
                    const LayoutErrors& errors) noexcept {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  LayoutFit fit;
  if (count < 2) return fit;
  double depth = kFirstDepth;
  for (int pass = 0; pass < 2; ++pass) {
    // Unknown: translation, then the turn.
    Matrix6d information = Matrix6d::Zero();
    information.diagonal().head<3>().setConstant(1.0 / (kAnywhere * kAnywhere));
    information.diagonal().tail<3>().setConstant(1.0 / (errors.turn * errors.turn));
    Vector6d right = Vector6d::Zero();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d& r = points[static_cast<std::size_t>(i)].p_LP_C;
      const double x = points[static_cast<std::size_t>(i)].n.x();
      const double y = points[static_cast<std::size_t>(i)].n.y();
      const double sigma = std::hypot(errors.n * std::max(0.0, depth + r.z()), errors.point);
      const double weight = 1.0 / (sigma * sigma);
      Vector6d row_x, row_y;
      row_x << 1.0, 0.0, -x, -x * r.y(), r.z() + x * r.x(), -r.y();
      row_y << 0.0, 1.0, -y, -r.z() - y * r.y(), y * r.x(), r.x();
      information += weight * (row_x * row_x.transpose() + row_y * row_y.transpose());
      right += weight * ((x * r.z() - r.x()) * row_x + (y * r.z() - r.y()) * row_y);
    }
    const Eigen::LDLT<Matrix6d> solver(information);
    fit.p_CL = solver.solve(right).head<3>();
    depth = fit.p_CL.z();
    const Vector6d of_depth = solver.solve(Vector6d::Unit(2));
    fit.depth_sigma = std::sqrt(std::max(0.0, of_depth(2)));
  }
  fit.solved = fit.p_CL.allFinite() && std::isfinite(fit.depth_sigma) && fit.p_CL.z() > 0.0;
  return fit;
}

}  // namespace vantage
