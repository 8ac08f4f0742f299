#include "pipeline/build/input_frames.h"

#include "pipeline/box_text.h"
#include "slim/base/check.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <vector>

namespace slim {
namespace {

/// Gap between two clouds, over the larger one's diagonal, up to which they are neighbours: tiles
/// and stations of one survey have one that near, though the first and the last of a long row lie
/// farther apart.
constexpr double kOtherFrame = 10;

/// Between the boxes' nearest places; 0 where they meet.
double gap_between(const Bbox& a, const Bbox& b) {
    Vec3d gap;
    for (std::size_t axis = 0; axis < 3; ++axis)
        gap[axis] = std::max({a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis], 0.0});
    return length(gap);
}

/// The gap over the larger diagonal; nothing where neither box has a size.
std::optional<double> relative_gap(const Bbox& a, const Bbox& b) {
    const double diagonal = std::max(a.diagonal(), b.diagonal());
    if (!(diagonal > 0)) return std::nullopt;
    return gap_between(a, b) / diagonal;
}

/// Clouds that neighbours join, one to the next (single linkage).
class Groups {
public:
    explicit Groups(std::size_t n) : above_(n) {
        std::iota(above_.begin(), above_.end(), std::size_t{0});
    }
    std::size_t of(std::size_t i) {
        while (above_[i] != i) i = above_[i] = above_[above_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) { above_[of(a)] = of(b); }

private:
    std::vector<std::size_t> above_;
};

/// The clouds with points, rising along the axis that they are spread along most.
std::vector<std::size_t> along_axis(std::span<const Bbox> boxes, std::size_t& axis) {
    Bbox all;
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < boxes.size(); ++i)
        if (!boxes[i].empty()) all.extend(boxes[i]), out.push_back(i);
    const Vec3d extent = all.extent();
    axis = extent.x >= std::max(extent.y, extent.z) ? 0 : extent.y >= extent.z ? 1 : 2;
    std::sort(out.begin(), out.end(),
              [&](std::size_t a, std::size_t b) { return boxes[a].lo[axis] < boxes[b].lo[axis]; });
    return out;
}

/// The clouds with points, group by group, that of the first cloud first.
std::vector<std::vector<std::size_t>> groups_of(std::span<const Bbox> boxes) {
    std::size_t axis = 0;
    const std::vector<std::size_t> sorted = along_axis(boxes, axis);
    Groups groups(boxes.size());
    for (const std::size_t i : sorted) {
        // Its neighbours that are no larger: they begin at most a diagonal, as wide as they may be,
        // before its reach.
        const double diagonal = boxes[i].diagonal(), reach = kOtherFrame * diagonal;
        const double first = boxes[i].lo[axis] - reach - diagonal, last = boxes[i].hi[axis] + reach;
        auto k = std::lower_bound(
            sorted.begin(), sorted.end(), first,
            [&](std::size_t at, double place) { return boxes[at].lo[axis] < place; });
        for (; k != sorted.end() && boxes[*k].lo[axis] <= last; ++k)
            if (groups.of(i) != groups.of(*k) && gap_between(boxes[i], boxes[*k]) <= reach)
                groups.join(i, *k);
    }
    std::vector<std::vector<std::size_t>> out;
    std::vector<std::size_t> place(boxes.size(), boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].empty()) continue;
        std::size_t& at = place[groups.of(i)];
        if (at == boxes.size()) at = out.size(), out.emplace_back();
        out[at].push_back(i);
    }
    return out;
}

struct FarPair {
    double gap = 0;
    std::size_t first = 0, second = 0;
};

/// Of two groups' clouds the two with the widest gap for their size;
/// a gap of 0 where none has a size.
FarPair farthest_of(std::span<const std::size_t> a, std::span<const std::size_t> b,
                    std::span<const Bbox> boxes) {
    FarPair out;
    for (const std::size_t i : a)
        for (const std::size_t k : b)
            if (const double gap = relative_gap(boxes[i], boxes[k]).value_or(0); gap > out.gap)
                out = {gap, std::min(i, k), std::max(i, k)};
    return out;
}

}  // namespace

std::string other_frame_text(std::span<const std::string> paths, std::span<const Bbox> boxes) {
    SLIM_CHECK(paths.size(), ==, boxes.size());
    const auto groups = groups_of(boxes);
    FarPair far;
    for (std::size_t g = 1; g < groups.size(); ++g)
        if (const FarPair pair = farthest_of(groups[0], groups[g], boxes); pair.gap > far.gap)
            far = pair;
    if (!(far.gap > 0)) return {};
    return fmt::format(
        "{} from {} and {} from {} lie {:.3g} times their size apart{}: are both in the same "
        "frame? (One may be georeferenced, or lack its scanner's pose.) One model of both has "
        "little detail: T_MDL and errors count over the diagonal of all",
        paths[far.first], box_text(boxes[far.first]), paths[far.second],
        box_text(boxes[far.second]), far.gap, boxes.size() > 2 ? ", with no cloud between" : "");
}

}  // namespace slim
