#include "pipeline/smooth/smoother.h"

#include "pipeline/measure/apart.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace slim {
namespace {

using nlohmann::json;

}  // namespace

void SmoothCounts::add(const Vec3d& from, const SmoothedPoint& p) {
    ++points;
    if (is_finite(from)) box.extend(from);
    if (!p.moved) {
        ++(!is_finite(p.position) ? not_finite
           : p.held               ? held
           : p.held_back          ? kept
                                  : unsupported);
        return;
    }
    ++moved;
    opposed += p.opposed ? 1 : 0, astray += p.astray ? 1 : 0;
    by_model += p.by_model ? 1 : 0, held_back += p.held_back ? 1 : 0;
    sq_displacement += p.displacement * p.displacement;
    max = std::max(max, std::abs(p.displacement));
}

json SmoothCounts::to_json(const char* mode) const {
    const double n = static_cast<double>(moved);
    return {{"mode", mode},
            {"points", points},
            {"moved", moved},
            {"unsupported", unsupported},
            {"not_finite", not_finite},
            {"rms_displacement", moved > 0 ? json(std::sqrt(sq_displacement / n)) : json()},
            {"max_displacement", moved > 0 ? json(max) : json()}};
}

void require_moved(const Smoother& smoother, const SmoothCounts& counts) {
    const std::string& cloud = smoother.config.cloud;
    if (counts.points == counts.not_finite) throw DataError(cloud + ": no finite point to smooth");
    if (counts.moved > 0 || counts.unsupported == 0) return;
    const Bbox world{counts.box.lo + smoother.origin, counts.box.hi + smoother.origin};
    refuse_apart({cloud, world}, placed(smoother.config.model, smoother.tree.header()),
                 counts.points - counts.not_finite);
}

}  // namespace slim
