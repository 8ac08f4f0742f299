#include "pipeline/measure/number_range.h"

#include "pipeline/box_text.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cmath>

namespace slim {

void require_squares(const std::pair<std::string, std::string>& files, const Bbox& box,
                     std::uint64_t n) {
    const Vec3d extent = box.extent();
    const bool overflows = !std::isfinite(static_cast<double>(n) * sq_length(extent));
    const bool vanishes = sq_length(extent) == 0 && std::max({extent.x, extent.y, extent.z}) > 0;
    if (!overflows && !vanishes) return;
    throw DataError(fmt::format(
        "{} and {}: the extent {}: from {}; expected one whose square is a number, change the unit",
        files.first, files.second, overflows ? "overflows" : "vanishes", box_text(box)));
}

}  // namespace slim
