// Measures alone: nothing but Eigen and vantage::observability.

#include <cmath>
#include <cstdio>

#include <vantage/observability/measures.h>

int main() {
  // The paper's planar arm (section 6) at theta1 = 0, theta2 = pi/2, seen from theta = 0:
  // w_c = f^2 l1 l2 |sin theta2| / (R cos theta)^2.
  const double f = 1.0, R = 40.0, l = 10.0;
  Eigen::Matrix2d J_v = Eigen::Vector2d(-f / R, -f / R).asDiagonal();
  Eigen::Matrix2d J_r;
  J_r << l, 0.0, -l, -l;
  const vantage::Measure composite = vantage::MeasureOf(Eigen::MatrixXd(J_v * J_r));
  std::printf("w_c %.17g\n", composite.w);
  return std::abs(composite.w - 1.0 / 16.0) < 1e-15 ? 0 : 1;
}
