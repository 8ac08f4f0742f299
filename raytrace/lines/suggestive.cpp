#include "raytrace/lines/crossings.h"
#include "raytrace/lines/sheet_blur.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace slim {
namespace {

/// sin of the least angle between N and v: nearer, w is no direction any more.
constexpr float kLeastSin = 0.342f;  // 20 degrees

/// The view at a pixel, split at the tangent plane.
struct Radial {
    Vec3f w;             ///< unit, towards the eye
    float cot = 0;       ///< N.v / |tangent part of v|
    float c = 0, s = 0;  ///< w in the principal directions
};

Radial radial_at(const LineScene& scene, std::size_t i) {
    const Vec3f n = scene.normal(i), v = scene.toward_eye(i);
    const float along = dot(n, v);
    const Vec3f tangent = v - n * along;
    const float size = length(tangent);
    Radial r{tangent / size, along / size, 0, 0};
    const auto& t = scene.buffer.direction;
    const Vec3f t1{t[0][i], t[1][i], t[2][i]};
    r.c = dot(r.w, t1), r.s = dot(r.w, cross(n, t1));
    return r;
}

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// kappa_r = S(w, w); NaN without a hit, seen from behind, or along the normal.
std::vector<float> radial_curvature(const LineScene& scene) {
    std::vector<float> out(scene.buffer.n_pixels(), kNone);
    const GBuffer& g = scene.buffer;
    parallel_blocks(out.size(), static_cast<std::size_t>(g.width),
                    [&](std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i) {
                            if (!scene.hit(i)) continue;
                            const float facing = scene.facing(i);
                            if (!(facing > 0 && facing * facing < 1 - kLeastSin * kLeastSin))
                                continue;
                            const Radial r = radial_at(scene, i);
                            out[i] = g.k1[i] * r.c * r.c + g.k2[i] * r.s * r.s;
                        }
                    });
    return out;
}

/// D_w kappa_r = Q(w, w, w) - 2 cot tau^2 (DeCarlo et al. 2004; NUMERICS 5.4), of a cubic model.
float exact_slope(const LineScene& scene, std::size_t i) {
    const GBuffer& g = scene.buffer;
    const Radial r = radial_at(scene, i);
    const float q = r.c * r.c * (r.c * g.third[0][i] + 3 * r.s * g.third[1][i]) +
                    r.s * r.s * (3 * r.c * g.third[2][i] + r.s * g.third[3][i]);
    const float tau = (g.k2[i] - g.k1[i]) * r.c * r.s;
    return q - 2 * r.cot * tau * tau;
}

/// The same by differences in the picture, for models without third derivatives.
class SlopeByDifferences {
public:
    SlopeByDifferences(const LineScene& scene, const std::vector<float>& kappa)
        : scene_(scene), kappa_(kappa) {}

    /// NaN where a neighbour is missing or on another sheet.
    float operator()(std::size_t i) const {
        const auto width = static_cast<std::size_t>(scene_.buffer.width);
        const auto reach = static_cast<std::size_t>(kReach);
        const std::size_t x = i % width, y = i / width;
        if (x < reach || y < reach || x + reach >= width ||
            y + reach >= static_cast<std::size_t>(scene_.buffer.height))
            return kNone;
        const Step right = step(i, 1), down = step(i, width);
        // w = a right + b down in the tangent plane, by least squares.
        // In doubles: fourth powers of a length in any unit.
        const Vec3d w = to_double(radial_at(scene_, i).w), r = to_double(right.move),
                    d = to_double(down.move);
        const double xx = sq_length(r), xy = dot(r, d), yy = sq_length(d), wx = dot(w, r),
                     wy = dot(w, d);
        const double det = xx * yy - xy * xy;
        if (!(det > 1e-6 * xx * yy)) return kNone;
        return static_cast<float>(
            ((wx * yy - wy * xy) * right.change + (wy * xx - wx * xy) * down.change) / det);
    }

private:
    /// Central differences over this many pixels: fewer show the seams between surfels.
    static constexpr int kReach = 2;
    struct Step {
        Vec3f move;
        float change;
    };
    Step step(std::size_t i, std::size_t stride) const {
        const std::size_t after = i + kReach * stride, before = i - kReach * stride;
        if (!one_sheet(scene_, before, i) || !one_sheet(scene_, i, after)) return {{}, kNone};
        return {scene_.point(after) - scene_.point(before), kappa_[after] - kappa_[before]};
    }

    const LineScene& scene_;
    const std::vector<float>& kappa_;
};

}  // namespace

void sample_curvature(const LineScene& scene, std::vector<float>& sample) {
    const GBuffer& g = scene.buffer;
    const auto width = static_cast<std::size_t>(g.width),
               before = static_cast<std::size_t>(scene.rows.top) * width;
    const std::size_t stride =
        std::max<std::size_t>(1, width * static_cast<std::size_t>(scene.picture_height()) / 200000);
    const std::size_t first = before + scene.first_row() * width,
                      end = before + scene.end_row() * width;
    for (std::size_t i = (first + stride - 1) / stride * stride; i < end; i += stride) {
        const std::size_t own = i - before;
        if (g.hit[own]) sample.push_back(std::fmax(std::fabs(g.k1[own]), std::fabs(g.k2[own])));
    }
}

float typical_curvature(std::vector<float> sample, double diagonal) {
    const auto least = static_cast<float>(1 / diagonal);
    if (sample.empty()) return least;
    const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), middle, sample.end());
    return std::fmax(*middle, least);
}

CrossingField suggestive_crossings(const LineScene& s, const Sheets& sheets) {
    // seams between surfels make it jagged
    const std::vector<float> kappa = blurred(sheets, radial_curvature(s));
    const SlopeByDifferences differences(s, kappa);
    const bool exact = s.degree >= 3;
    return find_on_sheets(
        s, sheets, [=, &s, &kappa](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
            const float ka = kappa[a], kb = kappa[b];
            if (!(ka * kb <= 0) || (ka > 0) == (kb > 0)) return std::nullopt;
            const float at = ka / (ka - kb);
            const float slope = exact ? exact_slope(s, a) * (1 - at) + exact_slope(s, b) * at
                                      : differences(a) * (1 - at) + differences(b) * at;
            if (!(slope > 0)) return std::nullopt;
            return EdgeHit{at, std::sqrt(slope), slope};
        });
}

}  // namespace slim
