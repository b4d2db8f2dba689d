#include "vantage/math/format.h"

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

namespace vantage {
namespace {

TEST(Format, IsPrintfs) {
  EXPECT_EQ(Format("%s %.2f %d", "w_c", 1.005e1, -3), "w_c 10.05 -3");
  EXPECT_EQ(Format("%%"), "%");
}

TEST(Format, HasNoLongestText) {
  const std::string name(5000, 'x');
  EXPECT_EQ(Format("<%s>", name.c_str()), "<" + name + ">");
}

TEST(ExactText, ReadsBackAsItself) {
  for (const double value : {0.1, -1.0 / 3.0, 6.02214076e23, 5e-324, 0.0}) {
    EXPECT_EQ(std::strtod(ExactText(value).c_str(), nullptr), value) << ExactText(value);
  }
}

}  // namespace
}  // namespace vantage
