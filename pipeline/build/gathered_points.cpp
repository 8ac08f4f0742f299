#include "pipeline/build/gathered_points.h"

#include <algorithm>
#include <utility>

namespace slim {

/// A growing array is copied and cleared page by page each time.
void GatheredPoints::reserve(const CloudInfo& info) {
    const auto n = static_cast<std::size_t>(std::min(info.n_points.value_or(0), most_points_));
    points_.position.reserve(n);
    points_.id.reserve(n);
    if (info.has_normals) points_.normal.reserve(n);
    if (info.has_scan) points_.scan.reserve(n);
}

bool GatheredPoints::add(const PointChunk& chunk, std::uint64_t first_id, std::uint32_t first_scan,
                         const CloudInfo& info) {
    if (points_.size() + chunk.size() > most_points_) return false;
    if (points_.empty()) reserve(info);
    // Columns that an earlier input lacks: no normal, the one scan that each of them is.
    if (info.has_normals) points_.normal.resize(points_.size());
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        if (!is_finite(chunk.position[i])) continue;
        points_.position.push_back(chunk.position[i]);
        points_.id.push_back(first_id + i);
        if (info.has_normals)
            points_.normal.push_back(is_finite(chunk.normal[i]) ? chunk.normal[i] : Vec3f{});
        const std::uint32_t own = info.has_scan ? chunk.scan[i] : 0u;
        points_.scan.push_back(static_cast<std::uint16_t>(first_scan + own));
    }
    return true;
}

PointBlock GatheredPoints::release(bool has_normals, bool has_scans) {
    most_points_ = 0;
    PointBlock out = std::exchange(points_, {});
    out.normal.resize(has_normals ? out.size() : 0);
    if (!has_scans) out.scan = {};
    const auto drop_spare = [](auto& values) {
        if (values.capacity() > values.size() + values.size() / 8) values.shrink_to_fit();
    };
    drop_spare(out.position), drop_spare(out.normal), drop_spare(out.id), drop_spare(out.scan);
    return out;
}

}  // namespace slim
