#include "slim/slicing/far_strays.h"

#include <algorithm>
#include <functional>

namespace slim {
namespace {

constexpr double kFar = 0.5;     // of the others' diagonal
constexpr double kLarger = 2;    // box with strays over that without
constexpr double kShare = 1e-3;  // of the points, a side

}  // namespace

void FarStrays::keep(const Vec3d& p) {
    for (std::size_t s = 0; s < sides_.size(); ++s) {
        std::vector<Vec3d>& points = sides_[s];
        if (!(outwards(s, p) > innermost_[s])) continue;
        const auto more = [s](const Vec3d& a, const Vec3d& b) {
            return outwards(s, a) > outwards(s, b);
        };
        if (points.size() == kKept) {
            std::pop_heap(points.begin(), points.end(), more);
            points.pop_back();
        }
        points.push_back(p);
        std::push_heap(points.begin(), points.end(), more);
        if (points.size() == kKept) innermost_[s] = outwards(s, points.front());
    }
}

double FarStrays::limit(std::size_t side, std::size_t skipped) const {
    std::vector<double> values;
    for (const Vec3d& p : sides_[side]) values.push_back(outwards(side, p));
    std::sort(values.begin(), values.end(), std::greater());
    const double value = values[skipped];
    return side % 2 ? value : -value;
}

FarStrays::Found FarStrays::find(std::uint64_t n_points) const {
    Found found;
    const auto most =
        std::min(kMostOfSide, static_cast<std::size_t>(kShare * static_cast<double>(n_points)));
    if (most == 0) return found;
    Bbox whole, inner;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        whole.lo[axis] = limit(2 * axis, 0), whole.hi[axis] = limit(2 * axis + 1, 0);
        inner.lo[axis] = limit(2 * axis, most), inner.hi[axis] = limit(2 * axis + 1, most);
    }
    const double far = kFar * inner.diagonal();
    if (!(whole.diagonal() > kLarger * inner.diagonal()) || !(far > 0)) return found;
    const Vec3d margin{far, far, far};
    const Bbox near{inner.lo - margin, inner.hi + margin};
    std::vector<Vec3d> strays;
    found.box = inner;
    for (const std::vector<Vec3d>& side : sides_)
        for (const Vec3d& p : side)
            if (near.sq_distance(p) == 0) found.box.extend(p);
            else if (std::find(strays.begin(), strays.end(), p) == strays.end())
                strays.push_back(p);
    if (strays.empty() || !(whole.diagonal() > kLarger * found.box.diagonal())) return {};
    found.n = strays.size();
    found.example = strays.front();
    return found;
}

}  // namespace slim
