#include "raytrace/lines/crest_look.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kMostSamples = 800;  // along the shorter side of a picture

}  // namespace

void CurvatureSamples::add(const LineScene& s) {
    const auto picture_width = static_cast<std::size_t>(s.buffer.width),
               picture_height = static_cast<std::size_t>(s.picture_height());
    const std::size_t shorter = std::min(picture_width, picture_height);
    if (step_ == 0) {
        step_ = (shorter + kMostSamples - 1) / kMostSamples;
        width_ = picture_width / step_, height_ = picture_height / step_;
        samples_.assign(width_ * height_, {Vec3f{kNone}, kNone, kNone, 0});
        near_px_ = std::max(3.0f, 0.003f * static_cast<float>(shorter));
        view_ = s.view;
    }
    for (std::size_t row = s.first_row(); row < s.end_row(); ++row) {
        const std::size_t y = row + static_cast<std::size_t>(s.rows.top);
        if (y % step_ != step_ / 2 || y / step_ >= height_) continue;
        for (std::size_t x = 0; x < width_; ++x) {
            const std::size_t i = row * picture_width + x * step_ + step_ / 2;
            if (s.hit(i))
                samples_[y / step_ * width_ + x] = {s.point(i), s.buffer.k1[i], s.buffer.k2[i],
                                                    s.fit_error(i)};
        }
    }
}

const CurvatureSamples::Sample* CurvatureSamples::at(float x, float y) const {
    if (!(x >= 0 && y >= 0)) return nullptr;
    const std::size_t column = static_cast<std::size_t>(x) / step_,
                      row = static_cast<std::size_t>(y) / step_;
    return column < width_ && row < height_ ? &samples_[row * width_ + column] : nullptr;
}

float CurvatureSamples::footprint(const Vec3f& point) const {
    const auto depth = static_cast<float>(view_.camera_from_local(to_double(point)).z);
    return view_.orthographic ? static_cast<float>(1 / view_.px_per_unit)
                              : depth / static_cast<float>(view_.focal_px);
}

/// How much k has fallen at p, beside q, as a share; NaN where p is not on the surface seen: behind
/// a limb, another part of it lies in p's pixel, which is less far on.
float CurvatureSamples::fall_at(const Vec3f& p, const Vec3f& q, float k, bool ridge) const {
    const Vec3d c = view_.camera_from_local(to_double(p));
    const double scale = (view_.orthographic ? view_.px_per_unit : view_.focal_px / c.z) /
                         static_cast<double>(step_);
    const double x = view_.center_x / static_cast<double>(step_) + scale * c.x,
                 y = view_.center_y / static_cast<double>(step_) + scale * c.y;
    if (!(x >= 0 && y >= 0 && x < static_cast<double>(width_) && y < static_cast<double>(height_)))
        return kNone;
    const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
    const Sample& sample = samples_[row * width_ + column];
    if (std::isnan(sample.k1)) return kNone;
    const float sq_way = sq_length(p - q);
    if (sq_length(sample.point - q) > 4 * sq_way || dot(sample.point - q, p - q) < 0.5f * sq_way)
        return kNone;
    return 1 - (ridge ? sample.k1 : -sample.k2) / k;
}

float CurvatureSamples::fall_along(const Vec3f& q, const CrestLook& look, float k, float turn,
                                   bool ridge) const {
    // Where the osculating circle leads.
    const Vec3f inwards = look.normal * (ridge ? -1.0f : 1.0f);
    const Vec3f p = q + (look.along * std::sin(turn) + inwards * (1 - std::cos(turn))) * (1 / k);
    return fall_at(p, q, k, ridge);
}

float CurvatureSamples::sharpness(const LinePoint& at, const CrestLook& look, bool ridge) const {
    constexpr float kTurn = 0.7f, kMostTurn = 1.2f, kLeastTurn = 0.5f;
    const float k = at.weight;
    float turn = std::min(std::max(kTurn, near_px_ * footprint(at.point) * k), kMostTurn);
    for (int nearer = 0; nearer < 3; ++nearer, turn *= 0.5f) {
        float least = kNone;
        for (const float side : {-turn, turn})
            least = std::fmin(least, fall_along(at.point, look, k, side, ridge));
        const float unit = std::max(turn, kLeastTurn);
        if (!std::isnan(least)) return std::clamp(2 * least / (unit * unit), -1.0f, 4.0f);
    }
    return kNone;
}

}  // namespace slim
