#include "raytrace/lines/parabolic_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr float kMost = 4;               ///< evidence
constexpr float kNoTurn = 0.1f;          ///< of the error
constexpr float kLeastError = 1e-5f;     ///< over L
constexpr float kGrowth = 1.08f;         ///< of the steps of a walk
constexpr float kSteepest = 8;           ///< way in space of a step over that in the picture
constexpr float kTangentReach = 10;      ///< points to either side, in a picture 1000 high
constexpr float kMeanReach = 30;         ///< the same, of means

/// What is seen from a line to one side.
struct Side {
    float height = 0;    ///< model units
    bool ended = false;  ///< the curvature went on with the other sign
};

/// The way across a line in the picture, unit.
std::array<float, 2> across(const FeatureLine& line, std::size_t i, float px) {
    const std::size_t n = line.points.size();
    const auto at = [&](std::size_t ahead, std::size_t behind) -> const LinePoint& {
        if (line.closed) return line.points[(i + n + ahead - behind) % n];
        return line.points[std::min(n - 1, i + ahead - std::min(i + ahead, behind))];
    };
    const std::size_t reach =
        std::min(static_cast<std::size_t>(kTangentReach * px), (n - 1) / 2 + 1);
    const LinePoint &a = at(0, reach), &b = at(reach, 0);
    const float dx = b.x - a.x, dy = b.y - a.y, size = std::hypot(dx, dy);
    return size > 0 ? std::array{-dy / size, dx / size} : std::array{1.0f, 0.0f};
}

/// Walks off to a side of a point until the lesser curvature turns the surface back by more than
/// half of what it had turned it, or it is high enough anyway. What the error may make is no turn.
Side walk(const CurvatureSamples& samples, const LinePoint& from, std::array<float, 2> to,
          float error) {
    constexpr float kPerWave = 1 / (2 * std::numbers::pi_v<float>);
    Side side;
    const auto step_px = static_cast<float>(samples.step_px());
    float turn = 0, most = 0, way = 0, step = step_px, at = 0;
    Vec3f before = from.point;
    while (side.height < kMost * error) {
        at += step;
        const CurvatureSamples::Sample* s = samples.at(from.x + to[0] * at, from.y + to[1] * at);
        if (!s || std::isnan(s->k1)) return side;
        const float piece = length(s->point - before);
        if (piece > kSteepest * step * samples.footprint(before)) return side;
        const float flat = std::fmin(std::fabs(s->k1), std::fabs(s->k2));
        turn += std::copysign(flat, s->k1 * s->k2) * piece, way += piece;
        if (std::fabs(turn) > std::fabs(most))
            most = turn, side.height = std::fabs(turn) * way * kPerWave;
        const float back = std::fabs(most) - turn * std::copysign(1.0f, most);
        if (back > 0.5f * std::fabs(most) && back * way * kPerWave > kNoTurn * error) {
            side.ended = true;
            return side;
        }
        before = s->point;
        step = std::max(step_px, (kGrowth - 1) * at);
    }
    return side;
}

float evidence(const CurvatureSamples& samples, const FeatureLine& line, std::size_t i,
               float least_error, float px) {
    const LinePoint& p = line.points[i];
    const CurvatureSamples::Sample* own = samples.at(p.x, p.y);
    const float error = std::max(least_error, own ? own->error : 0.0f);
    const std::array<float, 2> to = across(line, i, px);
    const Side a = walk(samples, p, to, error), b = walk(samples, p, {-to[0], -to[1]}, error);
    float height = 0;
    if (a.ended && b.ended)
        height = std::min(a.height, b.height);
    else if (a.ended || b.ended)
        height = a.ended ? a.height : b.height;
    else
        height = std::max(a.height, b.height);
    return std::min(kMost, height / error);
}

/// Means over some points to either side: where a line winds, it is crossed askew.
void average_evidence(FeatureLine& line, float px) {
    const std::size_t n = line.points.size(),
                      reach = std::min(static_cast<std::size_t>(kMeanReach * px), n / 2);
    std::vector<float> own;
    for (const LinePoint& p : line.points) own.push_back(p.evidence);
    for (std::size_t i = 0; i < n; ++i) {
        float sum = 0, count = 0;
        for (std::size_t k = 0; k <= 2 * reach; ++k) {
            if (!line.closed && (i + k < reach || i + k - reach >= n)) continue;
            sum += own[(i + k + n - reach) % n], count += 1;
        }
        line.points[i].evidence = sum / count;
    }
}

}  // namespace

void look_across_parabolic(std::span<FeatureLine> lines, const CurvatureSamples& samples,
                           double diagonal, float px) {
    const float least_error = kLeastError * static_cast<float>(diagonal);
    for (FeatureLine& line : lines) {
        for (std::size_t i = 0; i < line.points.size(); ++i)
            line.points[i].evidence = evidence(samples, line, i, least_error, px);
        average_evidence(line, px);
    }
}

}  // namespace slim
