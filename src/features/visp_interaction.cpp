#include "visp_interaction.h"

#include <visp3/core/vpMomentBasic.h>
#include <visp3/core/vpMomentCentered.h>
#include <visp3/core/vpMomentDatabase.h>
#include <visp3/core/vpMomentGravityCenter.h>
#include <visp3/core/vpMomentObject.h>
#include <visp3/core/vpPoint.h>
#include <visp3/visual_features/vpFeatureMomentBasic.h>
#include <visp3/visual_features/vpFeatureMomentCentered.h>
#include <visp3/visual_features/vpFeatureMomentDatabase.h>
#include <visp3/visual_features/vpFeatureMomentGravityCenter.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/visual_features/vpFeatureSegment.h>

namespace vantage {
namespace {

template <int Rows>
Eigen::Matrix<double, Rows, 6> ToEigen(const vpMatrix& L) {
  if constexpr (Rows == 1) {
    return Eigen::Map<const Eigen::Matrix<double, 1, 6>>(L.data);
  } else {
    return Eigen::Map<const Eigen::Matrix<double, Rows, 6, Eigen::RowMajor>>(L.data);
  }
}

}  // namespace

Eigen::Matrix<double, 2, 6> VispPointInteraction(const ImagePoint& point) {
  // Kept by the thread: making a vpFeaturePoint allocates too.
  thread_local vpFeaturePoint feature;
  feature.set_xyZ(point.n.x(), point.n.y(), point.depth);
  return ToEigen<2>(feature.interaction());
}

Eigen::Matrix<double, 4, 6> VispSegmentInteraction(const ImagePoint& i, const ImagePoint& j) {
  thread_local vpFeatureSegment feature;
  // ViSP's angle is that of the edge from its second point to its first.
  feature.buildFrom(j.n.x(), j.n.y(), j.depth, i.n.x(), i.n.y(), i.depth);
  return ToEigen<4>(feature.interaction());
}

MomentInteraction VispMomentInteraction(const std::vector<Eigen::Vector2d>& points,
                                        const ImagePlane& plane) {
  std::vector<vpPoint> vertices(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    vertices[i].set_x(points[i].x());
    vertices[i].set_y(points[i].y());
  }
  vpMomentObject object(kMaxMomentOrder + 1);  // a moment's motion depends on the next order
  object.setType(vpMomentObject::DISCRETE);
  object.fromVector(vertices);

  vpMomentDatabase moments;
  vpMomentBasic basic;
  vpMomentGravityCenter centre;
  vpMomentCentered centred;
  basic.linkTo(moments);
  centre.linkTo(moments);
  centred.linkTo(moments);
  // Step by step: ViSP's updateAll() starts threads, and keeps no order.
  basic.update(object);
  centre.update(object);
  centred.update(object);
  centre.compute();
  centred.compute();

  vpFeatureMomentDatabase features;
  vpFeatureMomentBasic basic_feature(moments, plane.A, plane.B, plane.C);
  vpFeatureMomentGravityCenter centre_feature(moments, plane.A, plane.B, plane.C);
  vpFeatureMomentCentered centred_feature(moments, plane.A, plane.B, plane.C);
  basic_feature.linkTo(features);
  centre_feature.linkTo(features);
  centred_feature.linkTo(features);
  basic_feature.update(plane.A, plane.B, plane.C);
  centre_feature.update(plane.A, plane.B, plane.C);
  centred_feature.update(plane.A, plane.B, plane.C);

  MomentInteraction result;
  result.centre << ToEigen<1>(centre_feature.interaction(vpFeatureMomentGravityCenter::selectXg())),
      ToEigen<1>(centre_feature.interaction(vpFeatureMomentGravityCenter::selectYg()));
  for (unsigned order = 1; order <= kMaxMomentOrder; ++order) {
    for (unsigned p = 0; p <= order; ++p) {
      const unsigned q = order - p;
      result.basic[p][q] = ToEigen<1>(basic_feature.interaction(p, q));
      if (order >= 2) result.centred[p][q] = ToEigen<1>(centred_feature.interaction(p, q));
    }
  }
  return result;
}

}  // namespace vantage
