// SPDX-License-Identifier: Apache-2.0
#include "rack_texture_bake.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr double kFinestTexel = 0.0025;  // m: half a pixel at 3 m
constexpr int kMostRows = 8192;

float smooth(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

float mix(float a, float b, float share) {
  return a + share * (b - a);
}

int draw_int(std::mt19937_64& engine, int end) {
  return static_cast<int>(statistics::uniform(engine, 0, end));
}

/// A place of the fractal where one layer of one texture begins.
struct Origin {
  int x = 0;
  int y = 0;
};

Origin draw_origin(std::mt19937_64& engine) {
  const int x = draw_int(engine, Fractal::kWidth);
  return {x, draw_int(engine, Fractal::kHeight)};
}

/// A reflectance picture in the making.
struct Canvas {
  int width;
  int height;
  std::vector<float> values;

  Canvas(int w, int h)
      : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}

  float& at(int x, int y) {
    return values[static_cast<std::size_t>((y & (height - 1)) * width + (x & (width - 1)))];
  }

  /// `paint(texel, distance)` for all texels within `reach` rows and columns of (x, y), where
  /// distance is 0 in the middle and 1 at the reach.
  template <typename Paint>
  void blot(int x, int y, int reach_x, int reach_y, const Paint& paint) {
    for (int j = -reach_y; j <= reach_y; ++j) {
      for (int i = -reach_x; i <= reach_x; ++i) {
        const float dx = static_cast<float>(i) / static_cast<float>(reach_x);
        const float dy = static_cast<float>(j) / static_cast<float>(reach_y);
        paint(at(x + i, y + j), std::sqrt(dx * dx + dy * dy), x + i, y + j);
      }
    }
  }
};

/// Metres to texels of one canvas; `around` at the largest radius.
struct Scale {
  double around;
  double along;

  [[nodiscard]] int columns(double metres) const {
    return std::max(1, static_cast<int>(std::lround(metres / around)));
  }
  [[nodiscard]] int rows(double metres) const {
    return std::max(1, static_cast<int>(std::lround(metres / along)));
  }
};

void paint_and_rust(Canvas& canvas, const PipeFinish& finish, const Fractal& fractal,
                    std::mt19937_64& engine) {
  const Origin coarse = draw_origin(engine);
  const Origin fine = draw_origin(engine);
  const Origin streak = draw_origin(engine);
  const Origin patch = draw_origin(engine);
  const auto paint = static_cast<float>(finish.albedo);
  const auto rust = static_cast<float>(statistics::uniform(engine, 0.07, 0.16));
  // The fractal is close to Gaussian: its quantile at the share of rust, by a logistic curve.
  const double share = std::clamp(finish.rust, 0.002, 0.998);
  const auto threshold = static_cast<float>(-std::log(share / (1 - share)) / 1.702);
  for (int y = 0; y < canvas.height; ++y) {
    for (int x = 0; x < canvas.width; ++x) {
      const float weather = fractal.at(x + coarse.x, y + coarse.y);
      const float grain = fractal.at(3 * x + fine.x, 3 * y + fine.y);
      // Water runs down the flanks: narrow along the pipe, long around it.
      const float run = fractal.stretched(x + 8 * streak.x, 2 * y + streak.y, 8);
      const float field = fractal.at(x + patch.x, y + patch.y);
      const float flaked = smooth(threshold - 0.12F, threshold + 0.12F, field + 0.25F * grain);
      // Round an open patch the paint is stained.
      const float stained = smooth(threshold - 0.9F, threshold, field + 0.3F * run);
      float value = paint * (1.0F + 0.07F * weather + 0.035F * grain);
      value *= 1.0F - 0.22F * smooth(0.4F, 1.8F, run);
      value = mix(value, 0.6F * value + 0.4F * rust, 0.6F * stained);
      const float scale = rust * std::max(0.25F, 1.0F + 0.32F * grain + 0.2F * weather);
      canvas.at(x, y) = mix(value, scale, flaked);
    }
  }
}

void weld_seams(Canvas& canvas, const Scale& scale, double length, const Fractal& fractal,
                std::mt19937_64& engine) {
  const Origin wave = draw_origin(engine);
  const int heat = scale.rows(0.035);
  const int bead = scale.rows(0.006);
  for (double along = statistics::uniform(engine, 0.3, 2.5); along < length;
       along += statistics::uniform(engine, 1.5, 3)) {
    const int middle = scale.rows(along);
    for (int x = 0; x < canvas.width; ++x) {
      for (int j = -heat; j <= heat; ++j) {
        const float ripple = fractal.at(4 * x + wave.x, middle + wave.y);
        const float distance = std::abs(static_cast<float>(j) + 0.8F * ripple);
        float& texel = canvas.at(x, middle + j);
        const float in_heat = 1.0F - smooth(0.3F, 1.0F, distance / static_cast<float>(heat));
        texel = mix(texel, 0.6F * texel + 0.03F, in_heat);
        const float on_bead = 1.0F - smooth(0.5F, 1.5F, distance / static_cast<float>(bead));
        texel = mix(texel, 1.35F * texel + 0.05F, on_bead);
      }
    }
  }
}

void bands(Canvas& canvas, const Scale& scale, double length, const Fractal& fractal,
           std::mt19937_64& engine) {
  const Origin wear = draw_origin(engine);
  for (double along = statistics::uniform(engine, 0.5, 5); along < length;
       along += statistics::uniform(engine, 3, 8)) {
    const auto albedo = static_cast<float>(statistics::uniform(engine, 0.08, 0.75));
    const int begin = scale.rows(along);
    const int count = scale.rows(statistics::uniform(engine, 0.06, 0.25));
    for (int j = 0; j < count; ++j) {
      for (int x = 0; x < canvas.width; ++x) {
        const float worn = fractal.at(x + wear.x, begin + j + wear.y);
        float& texel = canvas.at(x, begin + j);
        const float fresh = albedo * (1.0F + 0.05F * worn);
        texel = mix(fresh, texel, smooth(0.5F, 1.4F, worn));
      }
    }
  }
}

/// Letters that no alphabet knows, three columns by five rows, about the top of the pipe.
void stencils(Canvas& canvas, const Scale& scale, double length, float paint,
              std::mt19937_64& engine) {
  const float ink = paint > 0.35F ? 0.06F : 0.7F;
  for (double along = statistics::uniform(engine, 0.2, 3); along < length;
       along += statistics::uniform(engine, 2, 4)) {
    const int across =
        kTexelsAround / 2 + draw_int(engine, scale.columns(0.2)) - scale.columns(0.1);
    const double cell = statistics::uniform(engine, 0.012, 0.022);
    const int letters = 3 + draw_int(engine, 5);
    const int wide = scale.columns(cell);
    const int tall = scale.rows(cell);
    for (int letter = 0; letter < letters; ++letter) {
      const std::uint64_t glyph = engine();
      for (int bit = 0; bit < 15; ++bit) {
        if (((glyph >> static_cast<unsigned>(bit)) & 1U) == 0) {
          continue;
        }
        const int x0 = across + (bit % 5) * wide;
        const int y0 = scale.rows(along) + (4 * letter + bit / 5) * tall;
        for (int j = 0; j < tall; ++j) {
          for (int i = 0; i < wide; ++i) {
            float& texel = canvas.at(x0 + i, y0 + j);
            texel = mix(texel, ink, 0.85F);
          }
        }
      }
    }
  }
}

void splashes(Canvas& canvas, const Scale& scale, double length, const Fractal& fractal,
              std::mt19937_64& engine) {
  const Origin rim = draw_origin(engine);
  const int count = static_cast<int>(length * 9);
  for (int n = 0; n < count; ++n) {
    const int x = draw_int(engine, canvas.width);
    const int y = draw_int(engine, scale.rows(length));
    // Many small ones, few large ones; most are dark (oil, grime), some are white (birds).
    const double size = 0.006 + 0.012 * statistics::exponential(engine);
    const double stretch = statistics::uniform(engine, 0.7, 2.5);
    const float target = statistics::uniform(engine) < 0.3 ? 0.7F : 0.05F;
    const auto strength = static_cast<float>(statistics::uniform(engine, 0.3, 0.9));
    canvas.blot(x, y, scale.columns(size * stretch), scale.rows(size),
                [&](float& texel, float distance, int column, int row) {
                  const float ragged =
                      distance + 0.25F * fractal.at(2 * column + rim.x, 2 * row + rim.y);
                  texel = mix(texel, target, strength * (1.0F - smooth(0.5F, 0.8F, ragged)));
                });
  }
}

void blank(Canvas& canvas, const Scale& scale, std::span<const PlainStretch> plain, float paint) {
  constexpr float kFade = 0.1F;  // m; an abrupt end would itself be texture
  for (int y = 0; y < canvas.height; ++y) {
    const auto along = static_cast<float>((y + 0.5) * scale.along);
    float bare = 0;
    for (const PlainStretch& stretch : plain) {
      const auto from = static_cast<float>(stretch.from);
      const auto to = static_cast<float>(stretch.to);
      bare =
          std::max(bare, smooth(from - kFade, from, along) * (1 - smooth(to, to + kFade, along)));
    }
    if (bare > 0) {
      for (int x = 0; x < canvas.width; ++x) {
        canvas.at(x, y) = mix(canvas.at(x, y), paint, bare);
      }
    }
  }
}

}  // namespace

Fractal::Fractal(std::mt19937_64& engine) : values_(kWidth * std::size_t{kHeight}, 0.0F) {
  constexpr int kCells = 256;
  constexpr int kLattice = 4096;
  std::vector<float> lattice(kCells * std::size_t{kLattice});
  for (float& value : lattice) {
    value = static_cast<float>(statistics::uniform(engine, -1, 1));
  }
  // An octave of 2^k cells around repeats after all rows: 2^k cells per 512 texels.
  float amplitude = 1.0F;
  for (int k = 2; k <= 8; ++k) {
    const int cells = 1 << k;
    const int size = kWidth / cells;
    const int rows = kHeight / size;
    const int skip = 97 * k;  // other octaves, other rows of the lattice
    for (int y = 0; y < kHeight; ++y) {
      const int j = y / size;
      const float fy =
          smooth(0, 1, (static_cast<float>(y % size) + 0.5F) / static_cast<float>(size));
      const auto upper = static_cast<std::size_t>((j + skip) % kLattice) * kCells;
      const auto lower = static_cast<std::size_t>(((j + 1) % rows + skip) % kLattice) * kCells;
      float* out = values_.data() + static_cast<std::ptrdiff_t>(y) * kWidth;
      for (int i = 0; i < cells; ++i) {
        const auto here = static_cast<std::size_t>(i);
        const auto next = static_cast<std::size_t>((i + 1) % cells);
        const float left = mix(lattice[upper + here], lattice[lower + here], fy);
        const float right = mix(lattice[upper + next], lattice[lower + next], fy);
        for (int n = 0; n < size; ++n) {
          const float fx = smooth(0, 1, (static_cast<float>(n) + 0.5F) / static_cast<float>(size));
          out[i * size + n] += amplitude * mix(left, right, fx);
        }
      }
    }
    amplitude *= 0.78F;
  }
  double sum = 0;
  double squares = 0;
  for (const float value : values_) {
    sum += static_cast<double>(value);
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  const auto n = static_cast<double>(values_.size());
  const double mean = sum / n;
  const double deviation = std::sqrt(squares / n - mean * mean);
  for (float& value : values_) {
    value = static_cast<float>((static_cast<double>(value) - mean) / deviation);
  }
}

TextureMap bake_pipe(const PipeFinish& finish, double radius, double length,
                     std::span<const PlainStretch> plain, const Fractal& fractal,
                     std::mt19937_64& engine) {
  const auto wanted = static_cast<unsigned>(
      std::clamp(std::ceil(length / kFinestTexel), 16.0, static_cast<double>(kMostRows)));
  const int rows = static_cast<int>(std::bit_ceil(wanted));
  Canvas canvas(kTexelsAround, rows);
  const Scale scale{2 * std::numbers::pi * radius / kTexelsAround, length / rows};
  const auto paint = static_cast<float>(finish.albedo);
  paint_and_rust(canvas, finish, fractal, engine);
  bands(canvas, scale, length, fractal, engine);
  weld_seams(canvas, scale, length, fractal, engine);
  stencils(canvas, scale, length, paint, engine);
  splashes(canvas, scale, length, fractal, engine);
  const auto contrast = static_cast<float>(finish.contrast);
  for (float& value : canvas.values) {
    value = mix(paint, value, contrast);
  }
  blank(canvas, scale, plain, paint);
  return {canvas.width, canvas.height, canvas.values};
}

TextureMap bake_ground(double albedo, const Fractal& fractal, std::mt19937_64& engine) {
  Canvas canvas(1024, 2048);
  const Origin gravel = draw_origin(engine);
  const Origin stain = draw_origin(engine);
  const auto mean = static_cast<float>(albedo);
  // Lanes along y: gravel, or slabs with joints; a kerb between two lanes.
  std::vector<int> lane_begins;
  for (int x = draw_int(engine, 60); x < canvas.width - 60; x += 60 + draw_int(engine, 180)) {
    lane_begins.push_back(x);
  }
  std::vector<float> lane_albedos;
  std::vector<bool> lane_is_slab;
  for (std::size_t n = 0; n <= lane_begins.size(); ++n) {
    lane_is_slab.push_back(statistics::uniform(engine) < 0.55);
    lane_albedos.push_back(
        mean * static_cast<float>(lane_is_slab.back() ? statistics::uniform(engine, 1.0, 1.6)
                                                      : statistics::uniform(engine, 0.45, 0.95)));
  }
  std::vector<float> stones(canvas.values.size());
  for (float& stone : stones) {
    stone = static_cast<float>(statistics::uniform(engine, -1, 1));
  }
  const int slab_length = 128 << draw_int(engine, 2);
  for (int x = 0; x < canvas.width; ++x) {
    const auto lane =
        static_cast<std::size_t>(std::ranges::upper_bound(lane_begins, x) - lane_begins.begin());
    const int border = lane == 0 ? canvas.width : x - lane_begins[lane - 1];
    for (int y = 0; y < canvas.height; ++y) {
      const float grain = fractal.at(4 * x + gravel.x, 4 * y + gravel.y);
      const float weather = fractal.at(x + stain.x, y + stain.y);
      float value = lane_albedos[lane];
      if (lane_is_slab[lane]) {
        value *= 1.0F + 0.05F * grain + 0.09F * weather;
        value *= 1.0F - 0.35F * smooth(0.9F, 1.9F, weather);  // oil
        value *= y % slab_length < 2 ? 0.45F : 1.0F;
        // A tone of its own for each slab.
        value *= 1.0F + 0.06F * fractal.at(17 * static_cast<int>(lane), 37 * (y / slab_length));
      } else {
        const float stone = stones[static_cast<std::size_t>(y * canvas.width + x)];
        const float pebbles = stones[static_cast<std::size_t>(y / 2 * canvas.width + x / 2)];
        value *= std::max(0.2F, 1.0F + 0.45F * stone + 0.45F * pebbles + 0.12F * weather);
      }
      if (border < 12) {
        value = mean * (1.9F + 0.1F * weather);  // kerb
      } else if (border < 15) {
        value = 0.35F * mean;  // the gap beside it
      } else if (lane_is_slab[lane] && border >= 30 && border < 40) {
        value = mix(0.75F, value, smooth(0.2F, 1.2F, weather));  // painted line, worn
      }
      canvas.at(x, y) = value;
    }
  }
  return {canvas.width, canvas.height, canvas.values};
}

TextureMap bake_grime(const Fractal& fractal) {
  Canvas canvas(512, 512);
  for (int y = 0; y < canvas.height; ++y) {
    for (int x = 0; x < canvas.width; ++x) {
      const float streak = fractal.stretched(x, 2 * y, 4);
      canvas.at(x, y) = 0.5F * (1.0F + 0.14F * fractal.at(x + 100, y + 900) + 0.06F * streak);
    }
  }
  return {canvas.width, canvas.height, canvas.values};
}

}  // namespace pipescout::simulation::internal
