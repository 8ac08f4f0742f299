#include "pipeline/input_frames.h"

#include "pipeline/box_text.h"
#include "slim/base/check.h"

#include <algorithm>

namespace slim {
namespace {

/// Gap between two clouds, over the larger one's diagonal: tiles and stations of one survey lie nearer.
constexpr double kOtherFrame = 10;

/// Between the boxes' nearest places; 0 where they meet.
double gap_between(const Bbox& a, const Bbox& b) {
    Vec3d gap;
    for (std::size_t axis = 0; axis < 3; ++axis)
        gap[axis] = std::max({a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis], 0.0});
    return length(gap);
}

}  // namespace

std::string other_frame_text(std::span<const std::string> paths, std::span<const Bbox> boxes) {
    SLIM_CHECK(paths.size(), ==, boxes.size());
    double widest = kOtherFrame;
    std::string text;
    for (std::size_t i = 0; i < boxes.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            const double diagonal = std::max(boxes[i].diagonal(), boxes[k].diagonal());
            if (boxes[i].empty() || boxes[k].empty() || !(diagonal > 0)) continue;
            const double gap = gap_between(boxes[i], boxes[k]) / diagonal;
            if (!(gap > widest)) continue;
            widest = gap;
            text = fmt::format(
                "{} from {} and {} from {} lie {:.3g} times their size apart: are both in the same frame? (One may be "
                "georeferenced, or lack its scanner's pose.) One model of both has little detail: T_MDL and errors "
                "count over the diagonal of all",
                paths[k], box_text(boxes[k]), paths[i], box_text(boxes[i]), gap);
        }
    return text;
}

}  // namespace slim
