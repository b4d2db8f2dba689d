#include "sim/effects.h"

#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "vantage/math/error.h"

namespace vantage::sim {
namespace {

GreyImage Pattern() {
  GreyImage image;
  image.Resize(200, 150);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      *image.at(u, v) = static_cast<std::uint8_t>((u / 20 + v / 15) % 2 == 0 ? 60 : 180);
    }
  }
  return image;
}

ImageEffects All() {
  ImageEffects effects;
  effects.noise = 4.0;
  effects.blur = 1.3;
  effects.gain_step = 0.3;
  effects.gain_period = 0.05;
  return effects;
}

Time At(int frame) {
  return Time(FromSeconds(0.01 * frame));
}

TEST(EffectChain, NothingIsNothing) {
  EffectChain chain({}, 1);
  GreyImage image = Pattern();
  chain.Begin(At(0));
  chain.Apply(&image);
  EXPECT_EQ(image.pixels, Pattern().pixels);
}

TEST(EffectChain, NoiseHasItsMeanAndDeviation) {
  ImageEffects effects;
  effects.noise = 5.0;
  EffectChain chain(effects, 7);
  double sum = 0.0;
  double squares = 0.0;
  double neighbours = 0.0;
  int count = 0;
  for (int frame = 0; frame < 10; ++frame) {
    GreyImage image = Pattern();
    const GreyImage clean = Pattern();
    chain.Begin(At(frame));
    chain.Apply(&image);
    for (std::size_t i = 0; i + 200 < image.pixels.size(); ++i, ++count) {
      const double d = image.pixels[i] - clean.pixels[i];
      sum += d;
      squares += d * d;
      neighbours += d * (image.pixels[i + 200] - clean.pixels[i + 200]);
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / count), 5.0, 0.1);
  EXPECT_NEAR(neighbours / count / 25.0, 0.0, 0.02);
}

TEST(EffectChain, SameSeedSameImages) {
  EffectChain a(All(), 3);
  EffectChain b(All(), 3);
  EffectChain c(All(), 4);
  for (int frame = 0; frame < 20; ++frame) {
    GreyImage one = Pattern();
    GreyImage two = Pattern();
    GreyImage other = Pattern();
    a.Begin(At(frame));
    b.Begin(At(frame));
    c.Begin(At(frame));
    a.Apply(&one);
    b.Apply(&two);
    c.Apply(&other);
    ASSERT_EQ(one.pixels, two.pixels);
    ASSERT_NE(one.pixels, other.pixels);
  }
}

TEST(EffectChain, WindowsHoldWhatTheWholeImageHolds) {
  EffectChain whole(All(), 3);
  EffectChain parts(All(), 3);
  const std::vector<PixelWindow> windows{{10, 12, 40, 30}, {45, 30, 30, 40}, {180, -5, 60, 30}};
  for (int frame = 0; frame < 5; ++frame) {
    GreyImage all = Pattern();
    GreyImage some = Pattern();
    // What is not rendered is garbage.
    const auto grown = Grow(windows, parts.margin());
    for (int v = 0; v < some.height; ++v) {
      for (int u = 0; u < some.width; ++u) {
        bool rendered = false;
        for (const PixelWindow& window : grown) rendered = rendered || window.contains(u, v);
        if (!rendered) *some.at(u, v) = static_cast<std::uint8_t>(u * 31 + v * 17);
      }
    }
    whole.Begin(At(frame));
    parts.Begin(At(frame));
    whole.Apply(&all);
    parts.Apply(windows, &some);
    for (const PixelWindow& window : windows) {
      const PixelWindow clipped = Clip(window, all.width, all.height);
      for (int v = clipped.v; v < clipped.v + clipped.height; ++v) {
        for (int u = clipped.u; u < clipped.u + clipped.width; ++u) {
          ASSERT_EQ(*some.at(u, v), *all.at(u, v)) << u << " " << v;
        }
      }
    }
  }
}

TEST(EffectChain, GainJumpsWithinItsBounds) {
  ImageEffects effects;
  effects.gain_step = 0.3;
  effects.gain_period = 0.05;
  EffectChain chain(effects, 11);
  std::set<double> gains;
  for (int frame = 0; frame < 300; ++frame) {
    chain.Begin(At(frame));
    gains.insert(chain.gain());
    ASSERT_LE(std::abs(std::log(chain.gain())), 0.3);
  }
  EXPECT_GT(gains.size(), 30U);  // 60 jumps expected in 3 s.
  EXPECT_LT(gains.size(), 90U);
  GreyImage image = Pattern();
  chain.Apply(&image);
  EXPECT_EQ(image.pixels[0], std::lround(60 * chain.gain()));
}

TEST(EffectChain, BlurWidensAnEdgeAndKeepsItsPlace) {
  ImageEffects effects;
  effects.blur = 2.0;
  EffectChain chain(effects, 1);
  GreyImage image;
  image.Resize(80, 40);
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 80; ++u) *image.at(u, v) = u < 40 ? 50 : 200;
  }
  chain.Begin(At(0));
  chain.Apply(&image);
  // The error function of an edge at 39.5 blurred by 2 px.
  for (int u = 30; u < 50; ++u) {
    const double expected = 125.0 + 75.0 * std::erf((u - 39.5) / (2.0 * std::sqrt(2.0)));
    EXPECT_NEAR(*image.at(u, 20), expected, 2.0) << u;
  }
}

TEST(EffectChain, RefusesWhatIsOutOfBounds) {
  for (const ImageEffects& effects :
       {ImageEffects{-1.0, 0.0, 0.0, 1.0}, ImageEffects{0.0, -0.1, 0.0, 1.0},
        ImageEffects{0.0, 0.0, 1.5, 1.0}, ImageEffects{0.0, 0.0, 0.1, 0.0},
        ImageEffects{std::nan(""), 0.0, 0.0, 1.0}}) {
    EXPECT_THROW(EffectChain(effects, 1), ConfigError);
  }
}

}  // namespace
}  // namespace vantage::sim
