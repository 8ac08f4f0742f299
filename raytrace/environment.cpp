#include "raytrace/environment.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace slim {
namespace {

constexpr int kTableWidth = 64, kTableHeight = 32;
constexpr int kSumWidth = 256, kSumHeight = 128;
constexpr float kMeanRadiance = 0.5f;
constexpr float kPi = std::numbers::pi_v<float>;

/// The direction of a texel's centre, in the picture's axes.
Vec3f direction_of(int x, int y, int width, int height) {
    const float longitude =
        2 * kPi * ((static_cast<float>(x) + 0.5f) / static_cast<float>(width) - 0.5f);
    const float polar = kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    return {std::sin(polar) * std::sin(longitude), std::cos(polar),
            -std::sin(polar) * std::cos(longitude)};
}

/// Solid angle of the texels of a row.
float solid_angle(int y, int width, int height) {
    const float top = kPi * static_cast<float>(y) / static_cast<float>(height);
    const float bottom = kPi * static_cast<float>(y + 1) / static_cast<float>(height);
    return 2 * kPi / static_cast<float>(width) * (std::cos(top) - std::cos(bottom));
}

/// A texel with its light times its solid angle.
struct Lamp {
    Vec3f toward, flux;
    float weight = 0;
};

float cosine_to_32(float c) {
    for (int i = 0; i < 5; ++i) c *= c;
    return c;
}

/// Brightness of a soft-edged round lamp of angular radius r about `center` as seen in direction d.
float lamp(const Vec3f& d, const Vec3f& center, float r) {
    const float angle = std::acos(std::clamp(dot(d, normalized(center)), -1.0f, 1.0f));
    const float t = std::clamp((angle - 0.8f * r) / (0.4f * r), 0.0f, 1.0f);
    return 1 - t * t * (3 - 2 * t);
}

Vec3f studio_light(const Vec3f& d) {
    const float up = 0.5f + 0.5f * d.y;
    const Vec3f floor{0.16f, 0.14f, 0.12f}, sky{0.42f, 0.45f, 0.50f};
    const float t = std::clamp(4 * up - 1.5f, 0.0f, 1.0f);  // a soft horizon
    return floor * (1 - t) + sky * t +
           Vec3f{9.0f, 8.6f, 8.0f} * lamp(d, {-0.65f, 0.75f, 0.6f}, 0.34f) +
           Vec3f{1.3f, 1.6f, 2.0f} * lamp(d, {0.9f, 0.1f, 0.45f}, 0.42f) +
           Vec3f{2.2f, 2.1f, 2.0f} * lamp(d, {0.2f, 0.6f, -0.8f}, 0.30f);
}

}  // namespace

Vec3f Environment::Table::at(float u, float v) const {
    const float x = u * static_cast<float>(width) - 0.5f, y = v * static_cast<float>(height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y);
    const int x0 = static_cast<int>(left), y0 = static_cast<int>(top);
    const auto texel = [&](int column, int row) {
        const int wrapped = (column % width + width) % width;
        return texels[static_cast<std::size_t>(std::clamp(row, 0, height - 1)) *
                          static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(wrapped)];
    };
    const float s = x - left, t = y - top;
    return (texel(x0, y0) * (1 - s) + texel(x0 + 1, y0) * s) * (1 - t) +
           (texel(x0, y0 + 1) * (1 - s) + texel(x0 + 1, y0 + 1) * s) * t;
}

Environment::Environment(int width, int height, std::vector<float> rgb,
                         const std::array<Vec3d, 3>& axes, double turn_deg) {
    SLIM_CHECK(rgb.size(), ==,
               3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    map_ = {width, height, {}};
    map_.texels.resize(rgb.size() / 3);
    for (std::size_t i = 0; i < map_.texels.size(); ++i)
        map_.texels[i] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]};
    const double a = turn_deg * std::numbers::pi / 180;
    axes_ = {to_float(axes[0] * std::cos(a) - axes[2] * std::sin(a)), to_float(axes[1]),
             to_float(axes[0] * std::sin(a) + axes[2] * std::cos(a))};
    normalize();
    sum_lobes();
}

Environment Environment::studio(const std::array<Vec3d, 3>& axes, double turn_deg) {
    std::vector<float> rgb;
    rgb.reserve(3 * std::size_t{kSumWidth} * kSumHeight);
    for (int y = 0; y < kSumHeight; ++y)
        for (int x = 0; x < kSumWidth; ++x) {
            const Vec3f light = studio_light(direction_of(x, y, kSumWidth, kSumHeight));
            rgb.insert(rgb.end(), {light.x, light.y, light.z});
        }
    return Environment(kSumWidth, kSumHeight, std::move(rgb), axes, turn_deg);
}

void Environment::normalize() {
    double sum = 0, weights = 0;
    for (int y = 0; y < map_.height; ++y) {
        double row = 0;
        for (int x = 0; x < map_.width; ++x) {
            const Vec3f& t =
                map_.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(map_.width) +
                            static_cast<std::size_t>(x)];
            row += static_cast<double>(0.2126f * t.x + 0.7152f * t.y + 0.0722f * t.z);
        }
        const double weight = static_cast<double>(solid_angle(y, map_.width, map_.height));
        sum += weight * row, weights += weight * map_.width;
    }
    const double mean = sum / weights;
    if (!(mean > 0)) return;
    const auto scale = static_cast<float>(static_cast<double>(kMeanRadiance) / mean);
    for (Vec3f& t : map_.texels) t *= scale;
}

void Environment::sum_lobes() {
    // Texels by blocks: their light is added up, and seen where the block's middle is. Those of
    // small maps are split.
    const int split_x = (kSumWidth + map_.width - 1) / map_.width;
    const int split_y = (kSumHeight + map_.height - 1) / map_.height;
    const int width = map_.width * split_x, height = map_.height * split_y;
    const int columns = std::min(width, kSumWidth), rows = std::min(height, kSumHeight);
    std::vector<Lamp> lamps(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            lamps[static_cast<std::size_t>(y * columns + x)].toward =
                direction_of(x, y, columns, rows);
    for (int y = 0; y < height; ++y) {
        const float weight = solid_angle(y, width, height);
        for (int x = 0; x < width; ++x) {
            const auto row = static_cast<std::size_t>(static_cast<std::int64_t>(y) * rows / height);
            const auto column =
                static_cast<std::size_t>(static_cast<std::int64_t>(x) * columns / width);
            Lamp& l = lamps[row * static_cast<std::size_t>(columns) + column];
            l.flux += map_.texels[static_cast<std::size_t>(y / split_y) *
                                      static_cast<std::size_t>(map_.width) +
                                  static_cast<std::size_t>(x / split_x)] *
                      weight;
            l.weight += weight;
        }
    }
    diffuse_ =
        glossy_ = {kTableWidth, kTableHeight, std::vector<Vec3f>(kTableWidth * kTableHeight)};
    parallel_blocks(diffuse_.texels.size(), kTableWidth, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3f n =
                direction_of(static_cast<int>(i % kTableWidth), static_cast<int>(i / kTableWidth),
                             kTableWidth, kTableHeight);
            Vec3f diffuse, glossy;
            float weight = 0;
            for (const Lamp& l : lamps) {
                const float c = dot(n, l.toward);
                if (!(c > 0)) continue;
                diffuse += l.flux * c;
                if (c < 0.7f) continue;  // there the lobe is below 1e-5
                const float lobe = cosine_to_32(c);
                glossy += l.flux * lobe, weight += l.weight * lobe;
            }
            diffuse_.texels[i] = diffuse / kPi;
            glossy_.texels[i] = glossy / weight;
        }
    });
}

Vec3f Environment::look_up(const Table& table, const Vec3f& d) const {
    const float x = dot(axes_[0], d), y = dot(axes_[1], d), z = dot(axes_[2], d);
    return table.at(0.5f + std::atan2(x, -z) / (2 * kPi),
                    std::acos(std::clamp(y, -1.0f, 1.0f)) / kPi);
}

Vec3f Environment::radiance(const Vec3f& toward) const { return look_up(map_, toward); }
Vec3f Environment::diffuse(const Vec3f& normal) const { return look_up(diffuse_, normal); }
Vec3f Environment::glossy(const Vec3f& toward) const { return look_up(glossy_, toward); }

}  // namespace slim
